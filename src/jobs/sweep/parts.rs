//! Structures and mesh tables in memory: most points of a grid share them, and so do workers.
//!
//! On a machine with several NUMA nodes, the workers of a node may read copies in its memory. The first worker of the
//! node that needs a copy makes it, so that its pages belong to the node.

use super::build::{BuildError, model, structure};
use super::kernel_tables::KernelTables;
use super::mesh_tables::MeshTables;
use super::node_copies::NodeCopies;
use super::shared::lock;
use crate::gear::MeshTableSpec;
use crate::manifest::{Job, ModelSpec, PointSpec, StiffnessSpec, StructureSource, Variant};
use crate::model::Model;
use crate::propagate::{KernelChoice, KernelSetting};
use crate::shaft::{Drag, ShaftError};
use crate::store::{MeshUnderLoad, TableStore};
use crate::structure::ModalStructure;
use crate::topology::{CopyRoom, Topology};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// One point for every mesh table that some points of a job need, with the table's specification.
fn needed_meshes(
    job: &Job,
    points: impl IntoIterator<Item = usize>,
) -> impl Iterator<Item = (PointSpec, Arc<MeshTableSpec>)> {
    let tabled = |variant: &Variant| matches!(variant.mesh.stiffness, StiffnessSpec::Table(_));
    let any = job.points.variants().iter().any(tabled);
    // The key contains the address of the specification. Keep the specification, so that no other gets this address.
    let mut spec_of = HashMap::new();
    let points = points.into_iter().take_while(move |_| any);
    points.filter_map(move |id| {
        let point = job.points.at(id);
        let StiffnessSpec::Table(spec) = &point.mesh.stiffness else {
            return None;
        };
        let spec = spec.clone();
        let numbers = [point.load, point.mesh.misalignment].map(f64::to_bits);
        // With shafts that tilt, the table also depends on the structure.
        let tilt = (spec.shaft_tilt).then(|| format!("{:?}", point.model));
        // Drag changes the mean force.
        let drag = point.model.source.drag();
        let dragged = (drag != Drag::default()).then(|| Place::of(&point.model));
        let speed = (drag.viscous > 0.0).then(|| point.speed.to_bits());
        let key = (Arc::as_ptr(&spec), numbers, tilt, dragged, speed);
        let new = spec_of.insert(key, spec.clone()).is_none();
        new.then_some((point, spec))
    })
}

/// Number of mesh tables that some points of a job need.
pub fn needed_tables(job: &Job, points: impl IntoIterator<Item = usize>) -> usize {
    needed_meshes(job, points).count()
}

/// The specification of a structure. Specifications are compared by the address of their source, which is
/// much faster than by their text. Each keeps its source, so that no other source gets this address.
#[derive(Debug, Clone)]
struct Place(StructureSource, [usize; 2], bool);

impl Place {
    fn of(spec: &ModelSpec) -> Self {
        Self(spec.source.clone(), [spec.modes, spec.retained], spec.mta)
    }

    fn address(&self) -> usize {
        match &self.0 {
            StructureSource::Rigid(drive) => Arc::as_ptr(drive).addr(),
            StructureSource::Flexible(drive) => Arc::as_ptr(drive).addr(),
            StructureSource::Train(train) => Arc::as_ptr(train).addr(),
            StructureSource::Modal(structure) => Arc::as_ptr(structure).addr(),
        }
    }
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        (self.address(), self.1, self.2) == (other.address(), other.1, other.2)
    }
}

impl Eq for Place {}

impl Hash for Place {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.address(), self.1, self.2).hash(state);
    }
}

/// Number of different structures of a job. If a grid has very many combinations of model keys, only those that were
/// resolved in advance count.
pub fn structures(job: &Job) -> usize {
    let places = (job.points.variants().iter()).map(|variant| Place::of(&variant.model));
    places.collect::<HashSet<_>>().len()
}

/// Largest number of structures in memory. Each sampled drive has a separate structure, and so has each point
/// of a plane over numbers of a modal file. A structure of 40 modes with shafts takes some 150 KB.
const MOST_STRUCTURES: usize = 1 << 11;

/// Structures that all nodes share.
#[derive(Debug, Default)]
struct Structures {
    /// By the text of the specification: equal text means an equal structure.
    by_text: HashMap<String, Arc<ModalStructure>>,
    by_place: HashMap<Place, Arc<ModalStructure>>,
}

impl Structures {
    fn get(&mut self, spec: &ModelSpec) -> Result<Arc<ModalStructure>, ShaftError> {
        let place = Place::of(spec);
        if let Some(found) = self.by_place.get(&place) {
            return Ok(found.clone());
        }
        if self.by_place.len() == MOST_STRUCTURES {
            *self = Self::default();
        }
        let found = match &spec.source {
            // Writing the text would take longer than computing the structure.
            StructureSource::Modal(_) => Arc::new(structure(spec)?),
            _ => self.of_text(spec)?,
        };
        self.by_place.insert(place, found.clone());
        Ok(found)
    }

    fn of_text(&mut self, spec: &ModelSpec) -> Result<Arc<ModalStructure>, ShaftError> {
        let text = format!("{spec:?}");
        if let Some(found) = self.by_text.get(&text) {
            return Ok(found.clone());
        }
        let found = Arc::new(structure(spec)?);
        self.by_text.insert(text, found.clone());
        Ok(found)
    }
}

/// A number for the table that a kernel reads at a point while it integrates; `None` if the kernel has no table. If
/// different tables had equal numbers, only the order of chains would change.
pub(super) fn table_number(point: &PointSpec) -> Option<u64> {
    let (KernelSetting::Auto | KernelSetting::Named(KernelChoice::ClosedModes)) = point.run.kernel
    else {
        return None;
    };
    // A mesh computed from the gears depends on the load.
    let load =
        matches!(point.mesh.stiffness, StiffnessSpec::Table(_)).then(|| point.load.to_bits());
    let mut hash = DefaultHasher::new();
    // Hash the text: addresses would change the order between runs.
    format!("{:?} {:?} {load:?}", point.model, point.mesh).hash(&mut hash);
    Some(hash.finish())
}

/// Structures and mesh tables in memory.
#[derive(Debug)]
pub struct Prepared {
    structures: Arc<Mutex<Structures>>,
    node_copies: Option<NodeCopies<Place, ModalStructure>>,
    meshes: MeshTables,
    kernels: KernelTables,
}

impl Prepared {
    /// Starts without structures; `tables` stores tables of meshes and kernels.
    pub fn new(tables: TableStore) -> Self {
        Self {
            structures: Arc::default(),
            node_copies: None,
            meshes: MeshTables::new(tables.clone()),
            kernels: KernelTables::new(tables),
        }
    }

    /// Starts without structures, for a job. With distributions, each sample may need a separate kernel table that
    /// no later run uses. Such a job does not store kernel tables.
    pub fn of_job(job: &Job, tables: TableStore) -> Self {
        let mut parts = Self::new(tables);
        if job.samples.is_some() {
            parts.kernels = KernelTables::new(TableStore::in_memory());
        }
        parts
    }

    /// Shares structures and tables with the workers of one NUMA node, which make copies of them. Kernel tables are
    /// copied only if there is room; otherwise all nodes share them.
    pub fn on_node(&self, room: CopyRoom) -> Self {
        Self {
            structures: self.structures.clone(),
            node_copies: Some(NodeCopies::default()),
            meshes: self.meshes.on_node(),
            kernels: self.kernels.on_node(room),
        }
    }

    /// The mesh tables.
    pub fn meshes(&self) -> &MeshTables {
        &self.meshes
    }

    /// The tables of kernels.
    pub fn kernels(&self) -> &KernelTables {
        &self.kernels
    }

    /// Warnings about the cache of tables, each once.
    pub fn warnings(&self) -> Vec<String> {
        let mut all = self.meshes.warnings();
        all.extend(self.kernels.warnings());
        all
    }

    /// NUMA nodes of the copies; empty if there are no copies or the system does not report it.
    pub fn nodes(&self, topology: &Topology) -> BTreeSet<u32> {
        let mut nodes = BTreeSet::new();
        if let Some(node_copies) = &self.node_copies {
            node_copies.for_each(|copy| nodes.extend(topology.nodes_of_memory(&copy.mesh)));
        }
        self.meshes.for_each_copy(|copy| {
            nodes.extend(topology.nodes_of_memory(copy.stiffness.as_flattened()))
        });
        self.kernels
            .for_each_copy(|values| nodes.extend(topology.nodes_of_memory(values)));
        nodes
    }

    /// The piecewise-linear system of a point.
    ///
    /// # Errors
    /// A structure, a mesh or a value is refused.
    pub fn model(&self, point: &PointSpec) -> Result<Model, BuildError> {
        Ok(self.model_and_mesh(point)?.0)
    }

    /// The piecewise-linear system of a point, and its mesh under the mean load if it is computed from the gears.
    ///
    /// # Errors
    /// As [`Self::model`].
    pub fn model_and_mesh(
        &self,
        point: &PointSpec,
    ) -> Result<(Model, Option<MeshUnderLoad>), BuildError> {
        if let Some(fault) = &point.fault {
            return Err(BuildError::Values(fault.clone()));
        }
        model(&*self.structure(&point.model)?, point, &self.meshes)
    }

    /// Fetches or computes the mesh tables of some points of a job, each on all threads of the current rayon pool,
    /// until `interrupt` is raised. Calls `progress` for every table. The affected points report failures.
    pub fn prepare(
        &self,
        job: &Job,
        points: impl IntoIterator<Item = usize>,
        interrupt: &AtomicBool,
        progress: &mut dyn FnMut(),
    ) {
        for (point, spec) in needed_meshes(job, points) {
            if interrupt.load(Ordering::Relaxed) {
                return;
            }
            if let Ok(structure) = self.structure(&point.model) {
                _ = self.meshes.mesh(&point, &spec, &structure);
            }
            progress();
        }
    }

    /// The structure of a model specification, computed once.
    ///
    /// # Errors
    /// The shaft model cannot be assembled or solved.
    pub fn structure(&self, spec: &ModelSpec) -> Result<Arc<ModalStructure>, ShaftError> {
        let far = || {
            // Computing under the lock keeps workers from computing the same structure twice.
            lock(&self.structures).get(spec)
        };
        match &self.node_copies {
            None => far(),
            Some(node_copies) => node_copies.get(Place::of(spec), far),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest;
    use std::path::Path;

    /// 8 loads × 10 speeds: one table per load, and one per point if a viscous drag adds to the mean force.
    #[test]
    fn tables_differ_where_mean_forces_differ() {
        let count = |drag: &str| {
            let text = include_str!("../../../manifests/flex80-table.toml");
            let wheel = format!("[shafts.wheel]\n{drag}\n");
            let text = text.replace("[shafts.wheel]\n", &wheel);
            let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
            needed_tables(&job, 0..job.points.len())
        };
        assert_eq!(count(""), 8);
        assert_eq!(count("drag_torque = \"1 N*m\""), 8);
        assert_eq!(count("drag = \"3e-3 N*m*s/rad\""), 80);
    }

    #[test]
    fn workers_of_a_node_share_a_copy_that_is_equal() {
        let text = include_str!("../../../manifests/quickstart.toml");
        let job = manifest::parse(text, "m.toml", Path::new("")).unwrap();
        let spec = &job.points.variants()[0].model;
        let parts = Prepared::new(TableStore::open(tempfile::tempdir().unwrap().path()));
        let room = CopyRoom {
            free: None,
            private_cache: 0,
        };
        let nodes = [parts.on_node(room), parts.on_node(room)];
        let of = |parts: &Prepared| parts.structure(spec).unwrap();
        let (common, [first, second]) = (of(&parts), nodes.each_ref().map(of));
        assert!(*common == *first && *first == *second);
        assert!(!Arc::ptr_eq(&common, &first) && !Arc::ptr_eq(&first, &second));
        assert_ne!(
            first.mesh.as_ptr(),
            second.mesh.as_ptr(),
            "all the way down"
        );
        assert!(Arc::ptr_eq(&first, &of(&nodes[0])), "copied once");
        let topology = Topology::current().unwrap();
        assert!(parts.nodes(&topology).is_empty(), "no copies");
        assert!(nodes[0].nodes(&topology).len() <= 1);
    }
}
