//! What is kept of a point: a row of `points.parquet`, and what it adds to the other tables.

use super::chain_part::ChainPart;
use super::mesh_under_load::MeshUnderLoad;
use crate::analysis::{
    ChainRecord, CovariantOutcome, HorizonOutcome, LeftChaos, LyapunovOutcome,
    MultistabilityOutcome, OrbitSurvey, PointOutcome,
};
use serde::{Deserialize, Serialize};

/// One axis of the grid as a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AxisColumn {
    /// `load`, `speed`, or the dotted manifest key.
    pub name: String,
    /// SI unit, `1` when dimensionless.
    pub unit: String,
}

/// Where and for how long a point was computed. These columns differ from run to run;
/// all others depend on the manifest alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Worker that computed the point, from 0.
    pub worker: u32,
    /// NUMA node it ran on, where the machine tells.
    pub numa_node: Option<u32>,
    /// Wall time \[s\].
    pub wall_time: f64,
}

/// A row of `points.parquet`, with what the point adds to the other tables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointRow {
    /// Place in the job's list of points.
    pub point_id: u64,
    /// Value of each axis, in the order of the axis columns.
    pub axis_values: Vec<f64>,
    /// What was found.
    pub outcome: PointOutcome,
    /// What its probes found, where they were asked for.
    pub multistability: Option<MultistabilityOutcome>,
    /// The periodic orbits found, where they were asked for.
    pub orbits: Option<OrbitSurvey>,
    /// Its part in a chain, where the state is carried from point to point.
    pub chain: Option<Box<ChainPart>>,
    /// How far ahead it can be foretold, where asked for and chaotic.
    pub horizon: Option<HorizonOutcome>,
    /// Averages over its unstable orbits, where asked for and chaotic.
    /// Covariant vectors, where asked for and the motion does not repeat.
    pub covariant: Option<CovariantOutcome>,
    /// What the mean load makes of its mesh, where that is computed from the gears.
    pub mesh: Option<MeshUnderLoad>,
    /// Name of the kernel that integrated it.
    pub kernel: String,
    /// Where and for how long.
    pub placement: Placement,
}

impl PointRow {
    pub(super) fn left_chaos(&self) -> Option<&LeftChaos> {
        self.outcome.chaos.as_ref()?.left.as_ref()
    }

    pub(super) fn chain_record(&self) -> Option<&ChainRecord> {
        self.outcome.evidence.as_ref()?.chains.as_ref()
    }

    pub(super) fn lyapunov(&self) -> Option<&LyapunovOutcome> {
        self.outcome.lyapunov.as_ref()
    }
}
