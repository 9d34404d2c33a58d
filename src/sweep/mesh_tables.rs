//! Mesh tables of a job: fetched from the cache or computed, once for all points that share one.

use crate::gear::{
    Flanks, GearError, GearPair, MeshTable, MeshTableCycle, MeshTableError, MeshTableInputs,
    MisalignmentEnding, MisalignmentReport, MisalignmentSearch, NODES, TiltCompliance,
    loaded_misalignment,
};
use crate::manifest::{CourseSpec, PointSpec, TableSpec};
use crate::model::{Division, STIFFNESS_TERMS, Stiffness};
use crate::shaft::ModalStructure;
use crate::store::{Arrays, CacheError, CacheKind, CacheWarning, MappedTable, TableStore};
use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

/// Longest piece of a table whose stiffness is used as it is, in mesh cycles: windows end with
/// pieces, and the polynomials of longer ones would not be resolved.
const LONGEST_PIECE: f64 = 0.25;

/// Version of the method behind the numbers in a table.
const METHOD: u32 = 1;

// A piece of a table becomes the stiffness of a segment term by term.
const _: () = assert!(NODES == STIFFNESS_TERMS);

/// Why a point has no mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The gears are not a pair that meshes.
    #[error(transparent)]
    Gear(#[from] GearError),
    /// The table cannot be computed.
    #[error(transparent)]
    Table(#[from] MeshTableError),
    /// The table's arrays do not fit each other.
    #[error(transparent)]
    Arrays(#[from] CacheError),
    /// The flanks under load have no misalignment that the shafts agree with.
    #[error(
        "misalignment and shaft tilt do not settle after {steps} steps (last misalignment {misalignment:.3e} rad, residual {residual:.1e} rad); lower the load, stiffen shafts or bearings, or set mesh.shaft_tilt = false"
    )]
    Unsettled {
        /// Evaluations of the load centroid.
        steps: usize,
        /// Last misalignment tried \[rad\].
        misalignment: f64,
        /// What the structure made of it, less what was tried \[rad\].
        residual: f64,
    },
}

/// The mesh of one point, from its table.
#[derive(Debug, Clone, PartialEq)]
pub struct TabledMesh {
    /// The divisions of the mesh cycle.
    pub divisions: Vec<Division>,
    /// Mean stiffness \[N/m\].
    pub mean_stiffness: f64,
    /// How the misalignment under load was found, where shafts tilt.
    pub tilt: Option<MisalignmentReport>,
}

/// Mesh tables at hand. Points of a grid mostly share one.
#[derive(Debug)]
pub struct MeshTables {
    store: Option<TableStore>,
    known: Mutex<HashMap<String, Arc<MeshTableCycle>>>,
    tilts: Mutex<HashMap<String, MisalignmentReport>>,
    warnings: Mutex<BTreeSet<String>>,
}

impl MeshTables {
    /// Tables kept in a store, or in memory alone.
    pub fn new(store: Option<TableStore>) -> Self {
        Self {
            store,
            known: Mutex::default(),
            tilts: Mutex::default(),
            warnings: Mutex::default(),
        }
    }

    /// What the user should know of the cache, each once.
    pub fn warnings(&self) -> Vec<String> {
        lock(&self.warnings).iter().cloned().collect()
    }

    /// The mesh of a point that takes its stiffness from the table of `spec`.
    ///
    /// # Errors
    /// Gears that do not mesh, or a misalignment under load that is not found.
    pub fn mesh(
        &self,
        point: &PointSpec,
        spec: &TableSpec,
        structure: &ModalStructure,
    ) -> Result<TabledMesh, MeshError> {
        let force = point.load * structure.rated_force;
        let unloaded = point.mesh.misalignment;
        let (misalignment, tilt) = match spec.shaft_tilt {
            false => (unloaded, None),
            true => {
                let report = self.tilted(spec, structure, unloaded, force)?;
                (report.misalignment().unwrap_or(unloaded), Some(report))
            }
        };
        let cycle = self.cycle(spec, misalignment, force)?;
        Ok(TabledMesh {
            divisions: divisions(&cycle, spec.course),
            mean_stiffness: cycle.mean_stiffness(),
            tilt,
        })
    }

    /// The misalignment under the mean mesh force.
    fn tilted(
        &self,
        spec: &TableSpec,
        structure: &ModalStructure,
        unloaded: f64,
        force: f64,
    ) -> Result<MisalignmentReport, MeshError> {
        let compliance =
            TiltCompliance::of_modes(&structure.frequency, &structure.mesh, &structure.mesh_tilt);
        let key = format!("{spec:?} {compliance:?} {unloaded:e} {force:e}");
        if let Some(known) = lock(&self.tilts).get(&key) {
            return Ok(known.clone());
        }
        let flanks = Flanks::new(&spec.gears)?;
        let mut fault = None;
        let search = MisalignmentSearch::default();
        let report = loaded_misalignment(unloaded, force, compliance, search, |misalignment| {
            let inputs = inputs(&spec.gears, misalignment, force);
            match MeshTable::build(&flanks, &inputs, &|_, _| ()) {
                Ok(table) => table.cycle(0, 0).mean_centre(),
                Err(error) => {
                    fault.get_or_insert(error);
                    f64::NAN
                }
            }
        });
        if let Some(fault) = fault {
            return Err(fault.into());
        }
        if report.ending != MisalignmentEnding::Converged {
            let last = report.steps.last();
            return Err(MeshError::Unsettled {
                steps: report.steps.len(),
                misalignment: last.map_or(unloaded, |step| step.misalignment),
                residual: last.map_or(f64::NAN, |step| step.residual),
            });
        }
        lock(&self.tilts).insert(key, report.clone());
        Ok(report)
    }

    /// The cycle at a misalignment \[rad\] and a mesh force \[N\].
    fn cycle(
        &self,
        spec: &TableSpec,
        misalignment: f64,
        force: f64,
    ) -> Result<Arc<MeshTableCycle>, MeshError> {
        let inputs = inputs(&spec.gears, misalignment, force);
        let words = serde_json::json!({
            "method": METHOD,
            "gears": spec.gears,
            "table": inputs,
        });
        let key = words.to_string();
        if let Some(known) = lock(&self.known).get(&key) {
            return Ok(known.clone());
        }
        let build = || -> Result<MeshTable, MeshError> {
            let flanks = Flanks::new(&spec.gears)?;
            Ok(MeshTable::build(&flanks, &inputs, &|_, _| ())?)
        };
        let table = match &self.store {
            None => build()?,
            Some(store) => {
                let fetched =
                    store.get_or_build(CacheKind::Mesh, &words, || to_arrays(&build()?))?;
                let notes = fetched.warnings.iter().map(CacheWarning::to_string);
                lock(&self.warnings).extend(notes);
                from_arrays(&fetched.table, &inputs)?
            }
        };
        let cycle = Arc::new(table.cycle(0, 0));
        lock(&self.known).insert(key, cycle.clone());
        Ok(cycle)
    }
}

fn lock<T>(shared: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn inputs(gears: &GearPair, misalignment: f64, force: f64) -> MeshTableInputs {
    let mut inputs = MeshTableInputs::of_gears(gears);
    inputs.misalignment = vec![misalignment];
    inputs.torque = vec![force * inputs.base_radius];
    inputs.longest_piece = LONGEST_PIECE;
    inputs
}

/// The divisions of a cycle: means over equal segments, or pieces as they are.
fn divisions(cycle: &MeshTableCycle, course: CourseSpec) -> Vec<Division> {
    match course {
        CourseSpec::Segments(count) => (1..)
            .zip(cycle.segment_means(count as usize))
            .map(|(number, means)| Division {
                end: f64::from(number) / f64::from(count),
                stiffness: Stiffness::constant(means.stiffness),
                load_centre: means.centre,
                friction: [means.friction, means.friction_lever],
            })
            .collect(),
        CourseSpec::Continuous => (cycle.pieces().iter())
            .map(|piece| Division {
                end: piece.end,
                stiffness: Stiffness::series(piece.stiffness),
                load_centre: piece.centre,
                friction: [piece.friction, piece.friction_lever],
            })
            .collect(),
    }
}

/// Every array of a table, as a file keeps it.
fn to_arrays(table: &MeshTable) -> Result<Arrays, MeshError> {
    let [misalignments, torques, pieces, nodes] = table.shape();
    let shape = [misalignments, torques, pieces, nodes];
    let with_pairs = [
        misalignments,
        torques,
        pieces,
        nodes,
        table.share.len() / table.centre.len(),
    ];
    let mut arrays = Arrays::new();
    let axes: [(&str, &str, &Vec<f64>); 4] = [
        ("misalignment", "rad", &table.misalignment),
        ("torque", "N m", &table.torque),
        ("breaks", "1", &table.breaks),
        ("node", "1", &table.node),
    ];
    for (name, unit, values) in axes {
        arrays.push(name, unit, &[values.len()], values.clone())?;
    }
    let fields: [(&str, &str, &Vec<f64>); 6] = [
        ("stiffness", "N/m", &table.stiffness),
        ("centre", "m", &table.centre),
        ("transmission_error", "m", &table.transmission_error),
        ("friction", "1", &table.friction),
        ("friction_lever", "m", &table.friction_lever),
        ("contact_fraction", "1", &table.contact_fraction),
    ];
    for (name, unit, values) in fields {
        arrays.push(name, unit, &shape, values.clone())?;
    }
    arrays.push("share", "1", &with_pairs, table.share.clone())?;
    if !table.pattern.is_empty() {
        let shape = [misalignments, torques, pieces * nodes, table.slices];
        arrays.push("pattern", "N/m", &shape, table.pattern.clone())?;
    }
    Ok(arrays)
}

/// The table that [`to_arrays`] took apart.
fn from_arrays(table: &MappedTable, inputs: &MeshTableInputs) -> Result<MeshTable, MeshError> {
    let read = |name: &str| table.array(name).map(|(_, values)| values.to_vec());
    Ok(MeshTable {
        base_radius: inputs.base_radius,
        misalignment: read("misalignment")?,
        torque: read("torque")?,
        breaks: read("breaks")?,
        node: read("node")?,
        stiffness: read("stiffness")?,
        centre: read("centre")?,
        transmission_error: read("transmission_error")?,
        friction: read("friction")?,
        friction_lever: read("friction_lever")?,
        contact_fraction: read("contact_fraction")?,
        share: read("share")?,
        pattern: match inputs.pattern {
            true => read("pattern")?,
            false => Vec::new(),
        },
        slices: inputs.slices,
    })
}
