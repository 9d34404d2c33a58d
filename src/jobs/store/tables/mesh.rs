//! The mesh table of a pair of gears in the cache: the one place where its quantities meet
//! names and units of arrays.

use std::path::PathBuf;

use serde_json::{Value, json};
use thiserror::Error;

use super::{
    Arrays, CacheError, CacheKind, CacheWarning, Fetched, MappedTable, Origin, TableStore,
};
use crate::gear::{
    Flanks, GearError, GearPair, MOST_PAIRS, MeshTable, MeshTableError, MeshTableInputs,
};
use crate::numerics::instructions::portable;

/// Part of every key: changes whenever the same gears give other numbers or other arrays.
const METHOD: &str = "atlas mesh table 6";

/// A mesh table, and how it was come by.
#[derive(Debug)]
pub struct FetchedMesh {
    /// The table.
    pub table: MeshTable,
    /// Its file, which exists unless it was built in memory.
    pub file: PathBuf,
    /// Whether it was there.
    pub origin: Origin,
    /// What the user should know.
    pub warnings: Vec<CacheWarning>,
}

/// There is no mesh table of these gears.
#[derive(Debug, Error)]
pub enum MeshFetchError {
    /// The gears do not mesh.
    #[error(transparent)]
    Gears(#[from] GearError),
    /// The table cannot be computed.
    #[error(transparent)]
    Table(#[from] MeshTableError),
    /// Its arrays are not those of a mesh table.
    #[error(transparent)]
    Arrays(#[from] CacheError),
}

impl TableStore {
    /// The mesh table of a pair: the one on disk, or a new one, computed on the threads of the
    /// current rayon pool and kept. Bores that the gears leave open have to be set before (see
    /// [`GearPair::on_shafts`]).
    ///
    /// * `progress(done, all)`: called while it is computed, from any thread.
    ///
    /// # Errors
    /// The gears do not mesh, or the inputs are out of range. A cache that cannot be read or
    /// written is told in the warnings.
    pub fn mesh_table(
        &self,
        gears: &GearPair,
        inputs: &MeshTableInputs,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<FetchedMesh, MeshFetchError> {
        let key = key(gears, inputs);
        let build = || -> Result<Arrays, MeshFetchError> {
            let table = MeshTable::build(&Flanks::new(gears)?, inputs, progress)?;
            Ok(arrays(&table)?)
        };
        let Fetched {
            table,
            origin,
            warnings,
        } = self.get_or_build(CacheKind::Mesh, &key, build)?;
        Ok(FetchedMesh {
            table: mesh(&table, inputs)?,
            file: self.path(CacheKind::Mesh, &key),
            origin,
            warnings,
        })
    }
}

/// Everything that decides the numbers of a table.
fn key(gears: &GearPair, inputs: &MeshTableInputs) -> Value {
    let mut key = json!({ "method": METHOD, "gears": gears, "table": inputs });
    if let Some(drawing) = key["gears"].as_object_mut() {
        // Neither acts on the flanks.
        drawing.retain(|name, _| !["body_length", "rated_torque"].contains(&name.as_str()));
    }
    // The system's library of functions rounds otherwise where it may fuse.
    if portable() {
        key["instructions"] = "portable".into();
    }
    key
}

/// The arrays of a table, as `docs/notation.md` names them.
fn arrays(table: &MeshTable) -> Result<Arrays, CacheError> {
    let MeshTable {
        // Given by the inputs.
        base_radius: _,
        slices,
        misalignment,
        torque,
        breaks,
        node,
        stiffness,
        centre,
        transmission_error,
        friction,
        friction_lever,
        contact_fraction,
        loaded_pairs,
        share,
        pattern,
    } = table;
    let mut arrays = Arrays::new();
    for (name, unit, values) in [
        ("misalignment", "rad", misalignment),
        ("torque", "N*m", torque),
        ("breaks", "1", breaks),
        ("node", "1", node),
    ] {
        arrays.push(name, unit, &[values.len()], values.clone())?;
    }
    let shape = table.shape();
    for (name, unit, values) in [
        ("stiffness", "N/m", stiffness),
        ("centre", "m", centre),
        ("transmission_error", "m", transmission_error),
        ("friction", "1", friction),
        ("friction_lever", "m", friction_lever),
        ("contact_fraction", "1", contact_fraction),
        ("loaded_pairs", "1", loaded_pairs),
    ] {
        arrays.push(name, unit, &shape, values.clone())?;
    }
    let [m, t, pieces, nodes] = shape;
    arrays.push(
        "share",
        "1",
        &[m, t, pieces, nodes, MOST_PAIRS],
        share.clone(),
    )?;
    if !pattern.is_empty() {
        arrays.push(
            "pattern",
            "N/m",
            &[m, t, pieces * nodes, *slices],
            pattern.clone(),
        )?;
    }
    Ok(arrays)
}

/// The table of some arrays; refuses shapes that are not those of one.
fn mesh(table: &MappedTable, inputs: &MeshTableInputs) -> Result<MeshTable, CacheError> {
    let axis = |name: &str| table.array(name).map(|(_, values)| values.to_vec());
    let (misalignment, torque) = (axis("misalignment")?, axis("torque")?);
    let (breaks, node) = (axis("breaks")?, axis("node")?);
    let pieces = breaks.len().saturating_sub(1);
    let full = [misalignment.len(), torque.len(), pieces, node.len()];
    let array = |name: &str, wanted: &[usize]| {
        let (shape, values) = table.array(name)?;
        match shape == wanted {
            true => Ok(values.to_vec()),
            false => Err(CacheError::Shape {
                name: name.into(),
                shape: wanted.to_vec(),
                values: values.len(),
            }),
        }
    };
    let [m, t, pieces, nodes] = full;
    Ok(MeshTable {
        base_radius: inputs.base_radius,
        stiffness: array("stiffness", &full)?,
        centre: array("centre", &full)?,
        transmission_error: array("transmission_error", &full)?,
        friction: array("friction", &full)?,
        friction_lever: array("friction_lever", &full)?,
        contact_fraction: array("contact_fraction", &full)?,
        loaded_pairs: array("loaded_pairs", &full)?,
        share: array("share", &[m, t, pieces, nodes, MOST_PAIRS])?,
        pattern: match inputs.pattern {
            true => array("pattern", &[m, t, pieces * nodes, inputs.slices])?,
            false => Vec::new(),
        },
        slices: inputs.slices,
        misalignment,
        torque,
        breaks,
        node,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::ToothForm;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn gears() -> GearPair {
        GearPair {
            teeth: [25, 31],
            module: 3e-3,
            pressure_angle: 20f64.to_radians(),
            helix_angle: 0.0,
            face_width: 20e-3,
            body_length: [20e-3; 2],
            rated_torque: 100.0,
            form: ToothForm::default(),
        }
        .on_shafts([20e-3, 20e-3])
    }

    #[test]
    fn a_mesh_table_comes_back_bit_by_bit_and_is_built_once() {
        let folder = tempfile::tempdir().unwrap();
        let store = TableStore::open(folder.path());
        for pattern in [false, true] {
            let inputs = MeshTableInputs {
                misalignment: vec![0.0, 1e-4, 5e-4],
                torque: vec![30.0, 100.0],
                slices: 16,
                pattern,
                ..MeshTableInputs::of_gears(&gears())
            };
            let direct =
                MeshTable::build(&Flanks::new(&gears()).unwrap(), &inputs, &|_, _| {}).unwrap();
            let calls = AtomicUsize::new(0);
            let progress = |_, _| _ = calls.fetch_add(1, Ordering::Relaxed);
            for origin in [Origin::Built, Origin::Found] {
                calls.store(0, Ordering::Relaxed);
                let fetched = store.mesh_table(&gears(), &inputs, &progress).unwrap();
                assert_eq!(fetched.origin, origin);
                assert!(fetched.warnings.is_empty() && fetched.file.is_file());
                assert_eq!(fetched.table, direct);
                assert_eq!(calls.load(Ordering::Relaxed) > 0, origin == Origin::Built);
            }
        }
    }

    #[test]
    fn every_input_is_part_of_the_key() {
        let inputs = MeshTableInputs::of_gears(&gears());
        let store = TableStore::open("tables");
        let path = |gears: &GearPair, inputs: &MeshTableInputs| {
            store.path(CacheKind::Mesh, &key(gears, inputs))
        };
        let mut paths = vec![path(&gears(), &inputs)];
        let changed: [fn(&mut GearPair); 5] = [
            |gears| gears.teeth[1] += 1,
            |gears| gears.form.profile_shift[0] = 0.1,
            |gears| gears.form.bore[1] = None,
            |gears| gears.form.rack.tip_radius *= 0.5,
            |gears| gears.form.material[0].poisson_ratio = 0.29,
        ];
        for change in changed {
            let mut gears = gears();
            change(&mut gears);
            paths.push(path(&gears, &inputs));
        }
        let changed: [fn(&mut MeshTableInputs); 5] = [
            |inputs| inputs.misalignment.push(1e-3),
            |inputs| inputs.slices += 1,
            |inputs| inputs.pattern = true,
            |inputs| inputs.longest_piece = 0.05,
            |inputs| inputs.tolerance = 1e-6,
        ];
        for change in changed {
            let mut inputs = inputs.clone();
            change(&mut inputs);
            paths.push(path(&gears(), &inputs));
        }
        paths.sort();
        paths.dedup();
        assert_eq!(paths.len(), 11);
    }

    #[test]
    fn gears_that_do_not_mesh_are_refused_and_nothing_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let store = TableStore::open(folder.path());
        let mut apart = gears();
        apart.form.centre_distance = Some(0.1);
        let inputs = MeshTableInputs::of_gears(&apart);
        let error = store.mesh_table(&apart, &inputs, &|_, _| {}).unwrap_err();
        assert!(matches!(error, MeshFetchError::Gears(_)), "{error:?}");
        let inputs = MeshTableInputs {
            torque: vec![-1.0],
            ..inputs
        };
        let error = store.mesh_table(&gears(), &inputs, &|_, _| {}).unwrap_err();
        assert!(matches!(error, MeshFetchError::Table(_)), "{error:?}");
        assert!(store.entries().unwrap().is_empty());
    }
}
