//! The mesh table of a pair of gears in the cache.

use serde_json::{Value, json};
use thiserror::Error;

use super::table_cache::{CacheContent, CacheKind, Fetched, TableStore};
use crate::gear::{
    Flanks, GearError, GearPair, MOST_PAIRS, MeshTable, MeshTableError, MeshTableInputs,
};
use crate::numerics::instructions::portable;

/// Part of every key: changes whenever the same gears give other numbers.
const METHOD: &str = "atlas mesh table 7";

/// Why these gears have no mesh table.
#[derive(Debug, Error)]
pub enum MeshFetchError {
    /// The gears do not mesh.
    #[error(transparent)]
    Gears(#[from] GearError),
    /// The table cannot be computed.
    #[error(transparent)]
    Table(#[from] MeshTableError),
}

/// One quantity of a mesh table over misalignment, torque, piece and node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshQuantity<'t> {
    /// Name of the field of the table.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Values, row by row.
    pub values: &'t [f64],
    /// Number of values per node.
    pub members: usize,
}

/// The quantities of a mesh table. The last is the contact pattern, which has no values unless it was requested.
pub fn mesh_quantities(table: &MeshTable) -> [MeshQuantity<'_>; 9] {
    [
        ("stiffness", "N/m", &table.stiffness, 1),
        ("centre", "m", &table.centre, 1),
        ("transmission_error", "m", &table.transmission_error, 1),
        ("friction", "1", &table.friction, 1),
        ("friction_lever", "m", &table.friction_lever, 1),
        ("contact_fraction", "1", &table.contact_fraction, 1),
        ("loaded_pairs", "1", &table.loaded_pairs, 1),
        ("share", "1", &table.share, MOST_PAIRS),
        ("pattern", "N/m", &table.pattern, table.slices),
    ]
    .map(|(name, unit, values, members)| MeshQuantity {
        name,
        unit,
        values,
        members,
    })
}

impl CacheContent for MeshTable {
    const KIND: CacheKind = CacheKind::Mesh;

    fn fault(&self) -> Option<&'static str> {
        let axes = [
            (&self.misalignment, 1),
            (&self.torque, 1),
            (&self.breaks, 2),
            (&self.node, 1),
        ];
        let rises = |(axis, least): (&Vec<f64>, usize)| {
            axis.len() >= least && axis.windows(2).all(|pair| pair[0] < pair[1])
        };
        if !axes.into_iter().all(rises) {
            return Some("an axis is too short or does not increase");
        }
        let nodes = self.shape().into_iter().fold(1, usize::saturating_mul);
        let fits = |quantity: MeshQuantity| {
            quantity.values.len() == nodes.saturating_mul(quantity.members)
                || quantity.name == "pattern" && quantity.values.is_empty()
        };
        if mesh_quantities(self).into_iter().all(fits) {
            None
        } else {
            Some("a quantity does not have a value at every node")
        }
    }
}

impl TableStore {
    /// The mesh table of a pair: from disk, or computed on the threads of the current rayon pool and stored. Bores that
    /// the gears do not specify must be set before (see [`GearPair::on_shafts`]).
    ///
    /// * `progress(done, all)`: called during the computation, from any thread.
    ///
    /// # Errors
    /// The gears do not mesh, or the inputs are out of range. A cache that cannot be read or written gives a warning.
    pub fn mesh_table(
        &self,
        gears: &GearPair,
        inputs: &MeshTableInputs,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Fetched<MeshTable>, MeshFetchError> {
        self.get_or_build(&key(gears, inputs), || {
            Ok(MeshTable::build(&Flanks::new(gears)?, inputs, progress)?)
        })
    }
}

/// All inputs that determine the numbers of a table.
fn key(gears: &GearPair, inputs: &MeshTableInputs) -> Value {
    let mut key = json!({ "method": METHOD, "gears": gears, "table": inputs });
    if let Some(drawing) = key["gears"].as_object_mut() {
        // These keys do not affect the flanks.
        drawing.retain(|name, _| !["body_length", "rated_torque"].contains(&name.as_str()));
    }
    // The system's mathematical functions round differently if they may use fused instructions.
    if portable() {
        key["instructions"] = "portable".into();
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::ToothForm;
    use crate::store::Origin;
    use std::fs;
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
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    /// Inconsistent numbers have a right checksum if another program wrote them.
    #[test]
    fn tables_whose_numbers_do_not_fit_each_other_are_refused() {
        let inputs = MeshTableInputs {
            slices: 2,
            pattern: true,
            ..MeshTableInputs::of_gears(&gears())
        };
        let table = MeshTable::build(&Flanks::new(&gears()).unwrap(), &inputs, &|_, _| {}).unwrap();
        assert_eq!(table.fault(), None);
        type Change = fn(&mut MeshTable);
        let changes: [(Change, &str); 9] = [
            (|table| table.breaks.clear(), "axis"),
            (|table| table.breaks.truncate(1), "axis"),
            (|table| table.node.clear(), "axis"),
            (|table| table.node[3] = f64::NAN, "axis"),
            (|table| table.torque.push(0.0), "axis"),
            (|table| table.misalignment.push(1.0), "quantity"),
            (|table| table.stiffness.truncate(8), "quantity"),
            (|table| table.share.push(0.0), "quantity"),
            (|table| table.slices = usize::MAX, "quantity"),
        ];
        for (place, (change, words)) in changes.into_iter().enumerate() {
            let mut other = table.clone();
            change(&mut other);
            let fault = other.fault().unwrap_or_default();
            assert!(fault.contains(words), "{place}: {fault}");
        }
    }
}
