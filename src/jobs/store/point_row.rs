//! The data of a point: a row of `points.parquet`, and its additions to the other tables.

use super::chain_part::ChainPart;
use super::mesh_under_load::MeshUnderLoad;
use crate::analysis::{
    ChaosAverages, CovariantOutcome, GrowthRecord, HorizonOutcome, LyapunovOutcome,
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

/// Worker, node and wall time of a point's computation. Only these columns differ between runs; all others depend on
/// manifest and vector instructions alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Worker that computed the point, from 0.
    pub worker: u32,
    /// NUMA node of the worker, if known.
    pub numa_node: Option<u32>,
    /// Wall time \[s\], shared with the points that were computed side by side.
    pub wall_time: f64,
}

/// A row of `points.parquet`, with the point's additions to the other tables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointRow {
    /// Index in the job's list of points.
    pub point_id: u64,
    /// Value of each axis, in the order of the axis columns.
    pub axis_values: Vec<f64>,
    /// Results of its trajectories.
    pub outcome: PointOutcome,
    /// Results of its probes, if requested.
    pub multistability: Option<MultistabilityOutcome>,
    /// Its periodic orbits, if requested.
    pub orbits: Option<OrbitSurvey>,
    /// Its part in a chain, if the state is carried from point to point.
    pub chain: Option<Box<ChainPart>>,
    /// Its horizon of predictability, if requested and chaotic.
    pub horizon: Option<HorizonOutcome>,
    /// Covariant vectors, if requested and the motion does not repeat.
    pub covariant: Option<CovariantOutcome>,
    /// State of its mesh under the mean load, if computed from the gears.
    pub mesh: Option<MeshUnderLoad>,
    /// Name of the kernel that integrated it.
    pub kernel: String,
    /// Worker, node and wall time of the computation.
    pub placement: Placement,
}

/// One of several results of a point: a row of another table.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultOfPoint<T> {
    /// Id of the point, as in `points.parquet`.
    pub point_id: u64,
    /// The result.
    pub result: T,
}

impl<T> ResultOfPoint<T> {
    /// The rows of all results of a point.
    pub(super) fn all(point_id: u64, results: impl IntoIterator<Item = T>) -> Vec<Self> {
        let row = |result| Self { point_id, result };
        results.into_iter().map(row).collect()
    }
}

impl PointRow {
    pub(super) fn chaos_averages(&self) -> Option<&ChaosAverages> {
        self.outcome.chaos.as_ref()?.averages_before_exit.as_ref()
    }

    pub(super) fn growth_record(&self) -> Option<&GrowthRecord> {
        self.outcome.evidence.as_ref()?.chains.as_ref()
    }

    pub(super) fn lyapunov(&self) -> Option<&LyapunovOutcome> {
        self.outcome.lyapunov.as_ref()
    }
}
