//! Mesh tables of a job: fetched from the cache or computed, once for all points that share one.

use super::first_force::{first_force, friction};
use super::mesh_divisions::{divisions_of_pieces, joined_pieces, segments};
use super::mesh_error::MeshError;
use super::node_copies::NodeCopies;
use super::pair_meshes::PairSprings;
use super::shared::{SharedValues, lock};
use crate::gear::{
    CycleDivision, Flanks, GearPair, MeshSprings, MeshTable, MeshTableCycle, MeshTableInputs,
    MeshTableSpec, MisalignmentEnding, MisalignmentReport, MisalignmentSearch, StiffnessLaw,
    TiltCompliance, loaded_misalignment,
};
use crate::manifest::{CoastSpec, PointSpec};
use crate::model::{Division, MeshHarmonic, ToothCycles};
use crate::shaft::DrawnLaw;
use crate::store::{MeshUnderLoad, TableStore};
use crate::structure::ModalStructure;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

/// Longest piece of a table \[mesh cycles\]. The polynomials do not resolve longer pieces.
const LONGEST_PIECE: f64 = 0.25;

/// Largest relative error of a table: a tenth of the tolerance of its joined pieces.
const TABLE_TOLERANCE: f64 = 1e-6;

/// Largest number of meshes under their loads in memory, each of some 100 KB.
const MOST_MESHES: usize = 64;

/// Largest number of tables, of springs and of misalignments under load in memory, each of some 10 KB.
const MOST_TABLES: usize = 1 << 11;

/// The mesh of one point, from its table.
#[derive(Debug, Clone, PartialEq)]
pub struct TabledMesh {
    /// The divisions of the mesh cycle.
    pub divisions: Vec<Division>,
    /// The divisions of further springs, if every pair of teeth is a spring.
    pub further: Vec<Vec<Division>>,
    /// The divisions of all springs of drive and coast flanks in every mesh cycle of a revolution. Empty
    /// unless pairs are springs and single teeth differ.
    pub tooth_cycles: ToothCycles,
    /// Mean stiffness \[N/m\].
    pub mean_stiffness: f64,
    /// Harmonics of the transmission error that represent the error of loaded flanks; empty if the divisions
    /// include this error.
    pub transmission_error: Vec<MeshHarmonic>,
    /// How the misalignment under load was found; `None` if shafts do not tilt.
    pub tilt: Option<MisalignmentReport>,
    /// The mesh under the load; `None` without a load.
    pub under_load: Option<MeshUnderLoad>,
}

/// The load and the other conditions for which a mesh is computed.
#[derive(Debug, Clone, Copy)]
struct MeanLoad {
    /// Mean mesh force \[N\].
    force: f64,
    /// Whether mirrored coast flanks carry it.
    on_coast: bool,
    /// Coefficient of friction.
    friction: f64,
    /// Misalignment before the load acts \[rad\].
    misalignment: f64,
}

/// Mesh tables that this job has loaded or computed. Most points of a grid share one.
#[derive(Debug)]
pub struct MeshTables {
    shared: Arc<Common>,
    /// Copies in the memory of one NUMA node, if its workers use copies.
    node_copies: Option<NodeCopies<String, MeshTableCycle>>,
}

/// The state that all nodes share.
#[derive(Debug)]
struct Common {
    store: TableStore,
    tables: SharedValues<Arc<MeshTableCycle>>,
    tilts: SharedValues<MisalignmentReport>,
    springs: SharedValues<Arc<MeshSprings>>,
    /// Meshes under their loads.
    meshes: SharedValues<TabledMesh>,
    warnings: Mutex<BTreeSet<String>>,
}

impl MeshTables {
    /// Tables that are stored in `store`.
    pub fn new(store: TableStore) -> Self {
        Self {
            shared: Arc::new(Common {
                store,
                tables: SharedValues::new(MOST_TABLES),
                tilts: SharedValues::new(MOST_TABLES),
                springs: SharedValues::new(MOST_TABLES),
                meshes: SharedValues::new(MOST_MESHES),
                warnings: Mutex::default(),
            }),
            node_copies: None,
        }
    }

    /// Shares the tables with the workers of one NUMA node, which make copies of them.
    pub(super) fn on_node(&self) -> Self {
        Self {
            shared: self.shared.clone(),
            node_copies: Some(NodeCopies::default()),
        }
    }

    /// Calls `visit` for each copy of a node.
    pub(super) fn for_each_copy(&self, visit: impl FnMut(&MeshTableCycle)) {
        if let Some(node_copies) = &self.node_copies {
            node_copies.for_each(visit);
        }
    }

    /// Warnings about the cache, each once.
    pub fn warnings(&self) -> Vec<String> {
        lock(&self.shared.warnings).iter().cloned().collect()
    }

    /// The mesh of a point whose stiffness comes from the table of `spec`.
    ///
    /// # Errors
    /// The gears do not mesh, or no misalignment under load is found.
    pub fn mesh(
        &self,
        point: &PointSpec,
        spec: &MeshTableSpec,
        structure: &ModalStructure,
    ) -> Result<TabledMesh, MeshError> {
        if let CycleDivision::Pairs { slices } = spec.division {
            return self.pairs(point, spec, structure, slices as usize);
        }
        let force = first_force(structure, point);
        let on_coast = on_mirrored_flanks(point, force);
        let loaded = MeanLoad {
            force,
            on_coast,
            friction: friction(structure, point)?,
            misalignment: point.mesh.misalignment,
        };
        let tilt = || {
            let on_coast = on_coast && structure.coast.is_some();
            TiltCompliance::of_flank(structure, usize::from(on_coast))
        };
        self.under(loaded, spec, tilt, point.excitation.table_harmonics)
    }

    /// A further mesh under its mean force \[N\]. `contact` is the structure's contact for its drive flanks; the next
    /// one is for its coast flanks.
    ///
    /// # Errors
    /// As [`Self::mesh`].
    pub fn further(
        &self,
        drawn: &DrawnLaw,
        force: f64,
        (structure, contact): (&ModalStructure, usize),
    ) -> Result<TabledMesh, MeshError> {
        let on_coast = force < 0.0;
        let loaded = MeanLoad {
            force,
            on_coast,
            friction: drawn.friction,
            misalignment: drawn.misalignment,
        };
        let flank = 2 + contact + usize::from(on_coast);
        let tilt = || TiltCompliance::of_flank(structure, flank);
        self.under(loaded, &drawn.table, tilt, None)
    }

    /// A mesh under its mean load, with the requested number of harmonics of its error.
    fn under(
        &self,
        load: MeanLoad,
        spec: &MeshTableSpec,
        compliance: impl FnOnce() -> TiltCompliance,
        harmonics: Option<u32>,
    ) -> Result<TabledMesh, MeshError> {
        let tilts = spec.shaft_tilt.then(compliance);
        let key = format!("{spec:?} {load:?} {tilts:?} {harmonics:?}");
        if let Some(mesh) = self.shared.meshes.get(&key) {
            return Ok(mesh);
        }
        let force = flank_load(load.force)?;
        let unloaded = load.misalignment;
        let (misalignment, tilt) = match tilts {
            Some(compliance) => {
                // Loaded coast flanks are computed as the mirror image of drive flanks, with reversed positions.
                let compliance =
                    if load.on_coast { compliance.other_way_round() } else { compliance };
                let report = self.tilted(spec, compliance, unloaded, force)?;
                (report.misalignment().unwrap_or(unloaded), Some(report))
            }
            None => (unloaded, None),
        };
        let cycle = self.scaled(spec, misalignment, force)?;
        let with_error = harmonics.is_none() && cycle.has_error();
        let mesh = TabledMesh {
            divisions: match spec.division {
                CycleDivision::Segments(count) if spec.stiffness.is_tangent() => {
                    segments(&cycle, count, with_error)
                }
                _ => divisions_of_pieces(&joined_pieces(load.friction, spec, &cycle), with_error),
            },
            further: Vec::new(),
            tooth_cycles: Default::default(),
            mean_stiffness: cycle.mean_stiffness(),
            transmission_error: (cycle.harmonics(&cycle.tangent_error(), harmonics.unwrap_or(0)))
                .into_iter()
                .map(|(harmonic, amplitude, phase)| MeshHarmonic::new(harmonic, amplitude, phase))
                .collect(),
            tilt,
            under_load: Some(under_load(load.on_coast, &cycle, misalignment)),
        };
        self.shared.meshes.keep(key, &mesh);
        Ok(mesh)
    }

    /// The mesh of a point whose pairs of teeth are separate springs, on slices of the face. The damping is for the
    /// mean stiffness under the mean load, or under the rated load if the mean load is zero.
    fn pairs(
        &self,
        point: &PointSpec,
        spec: &MeshTableSpec,
        structure: &ModalStructure,
        slices: usize,
    ) -> Result<TabledMesh, MeshError> {
        let misalignment = point.mesh.misalignment;
        let signed_force = first_force(structure, point);
        let force = signed_force.abs();
        let loaded = if force > 0.0 { force } else { structure.rated_force };
        let cycle = self.cycle(spec, spec.stiffness, misalignment, loaded)?;
        let mean_stiffness = cycle.mean_stiffness();
        let springs = PairSprings {
            spec,
            misalignment,
            slices,
            force: loaded,
        };
        let mut springs = springs.divisions(point, mean_stiffness, &self.shared.springs)?;
        Ok(TabledMesh {
            divisions: springs.alike.remove(0),
            further: springs.alike,
            tooth_cycles: springs.tooth_cycles,
            mean_stiffness,
            transmission_error: Vec::new(),
            tilt: None,
            under_load: (force > 0.0).then(|| {
                under_load(
                    on_mirrored_flanks(point, signed_force),
                    &cycle,
                    misalignment,
                )
            }),
        })
    }

    /// The misalignment under the mean mesh force.
    fn tilted(
        &self,
        spec: &MeshTableSpec,
        compliance: TiltCompliance,
        unloaded: f64,
        force: f64,
    ) -> Result<MisalignmentReport, MeshError> {
        let key = format!("{spec:?} {compliance:?} {unloaded:e} {force:e}");
        if let Some(report) = self.shared.tilts.get(&key) {
            return Ok(report);
        }
        let flanks = Flanks::new(&spec.gears)?;
        let mut fault = None;
        let search = MisalignmentSearch::default();
        let report = loaded_misalignment(unloaded, force, compliance, search, |misalignment| {
            let inputs = inputs(spec, StiffnessLaw::Tangent, misalignment, force);
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
        self.shared.tilts.keep(key, &report);
        Ok(report)
    }

    /// The cycle of a further mesh under its mean force \[N\], before the shafts tilt.
    pub(super) fn before_tilt(
        &self,
        drawn: &DrawnLaw,
        force: f64,
    ) -> Result<Arc<MeshTableCycle>, MeshError> {
        self.scaled(&drawn.table, drawn.misalignment, flank_load(force)?)
    }

    /// The cycle at a misalignment \[rad\] and a mesh force \[N\]. If [`is_scaled`], its stiffness is scaled
    /// to the mean of the tangent stiffness.
    pub(super) fn scaled(
        &self,
        spec: &MeshTableSpec,
        misalignment: f64,
        force: f64,
    ) -> Result<Arc<MeshTableCycle>, MeshError> {
        let cycle = self.cycle(spec, spec.stiffness, misalignment, force)?;
        if !is_scaled(spec, misalignment) {
            return Ok(cycle);
        }
        let tangent = self.cycle(spec, StiffnessLaw::Tangent, misalignment, force)?;
        let table = MeshTableCycle::clone(&cycle);
        Ok(Arc::new(
            table.with_mean_stiffness(tangent.mean_stiffness()),
        ))
    }

    /// The cycle at a misalignment \[rad\] and a mesh force \[N\].
    fn cycle(
        &self,
        spec: &MeshTableSpec,
        stiffness: StiffnessLaw,
        misalignment: f64,
        force: f64,
    ) -> Result<Arc<MeshTableCycle>, MeshError> {
        let MeshTableSpec {
            gears,
            contact,
            face,
            ..
        } = spec;
        let key =
            format!("{gears:?} {contact:?} {face:?} {stiffness:?} {misalignment:e} {force:e}");
        let far = || {
            let inputs = inputs(spec, stiffness, misalignment, force);
            (self.shared).cycle(&key, gears, &inputs)
        };
        match &self.node_copies {
            None => far(),
            Some(node_copies) => node_copies.get(key.clone(), far),
        }
    }
}

/// Whether the load centroid may leave mid-face and move with the phase: under misalignment, with modified leads, and
/// in helical gears, whose lines of contact cross the face.
fn centroid_moves(gears: &GearPair, misalignment: f64) -> bool {
    misalignment != 0.0 || gears.helix_angle != 0.0 || gears.form.has_modified_lead()
}

/// Whether the secant stiffness is scaled to the mean of the tangent stiffness. If contact spreads along the
/// face, the mesh stiffens with the load. Its secant stiffness from the first touch is then on average half
/// the tangent stiffness.
fn is_scaled(spec: &MeshTableSpec, misalignment: f64) -> bool {
    !spec.stiffness.is_tangent() && centroid_moves(&spec.gears, misalignment)
}

/// Whether mirrored coast flanks carry the mean load.
fn on_mirrored_flanks(point: &PointSpec, force: f64) -> bool {
    force < 0.0 && matches!(point.mesh.coast, CoastSpec::Mirrored { .. })
}

/// The mesh of a point under its mean load.
fn under_load(on_coast: bool, cycle: &MeshTableCycle, misalignment: f64) -> MeshUnderLoad {
    let side = if on_coast { -1.0 } else { 1.0 };
    MeshUnderLoad {
        misalignment,
        load_centre: side * cycle.mean_centre() + 0.0,
        stiffness: cycle.mean_stiffness(),
        contact_ratio: cycle.mean_loaded_pairs(),
        transmission_error: cycle.peak_to_peak(),
    }
}

/// The load on the flanks under a mean mesh force \[N\]. The coast flanks, which mirror the drive flanks, carry a
/// negative force.
pub(super) fn flank_load(force: f64) -> Result<f64, MeshError> {
    if force == 0.0 { Err(MeshError::NoLoad) } else { Ok(force.abs()) }
}

impl Common {
    /// The cycle of a key, fetched if it is not in memory.
    fn cycle(
        &self,
        key: &str,
        gears: &GearPair,
        inputs: &MeshTableInputs,
    ) -> Result<Arc<MeshTableCycle>, MeshError> {
        if let Some(cycle) = self.tables.get(key) {
            return Ok(cycle);
        }
        let fetched = self.store.mesh_table(gears, inputs, &|_, _| ())?;
        let notes = fetched.warnings.iter().map(ToString::to_string);
        lock(&self.warnings).extend(notes);
        let cycle = Arc::new(fetched.table.cycle(0, 0));
        self.tables.keep(key.to_owned(), &cycle);
        Ok(cycle)
    }
}

fn inputs(
    spec: &MeshTableSpec,
    stiffness: StiffnessLaw,
    misalignment: f64,
    force: f64,
) -> MeshTableInputs {
    let gears = &spec.gears;
    let mut inputs = MeshTableInputs::of_gears(gears);
    inputs.contact = spec.contact;
    inputs.face = spec.face;
    inputs.stiffness = stiffness;
    inputs.misalignment = vec![misalignment];
    inputs.torque = vec![force * inputs.base_radius];
    inputs.longest_piece = LONGEST_PIECE;
    inputs.tolerance = TABLE_TOLERANCE;
    // A gap that is linear across the face of spur gears is exact on one slice.
    if gears.helix_angle == 0.0 && !gears.form.has_curved_lead() {
        inputs.slices = 1;
    }
    inputs
}
