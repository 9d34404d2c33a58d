//! A whole job: what its name, grid and points are.

use super::axis::AxisKey;
use super::expand::Between;
use super::points::Points;
use super::spec::{Axis, Carried, ContinuationSpec, PointSpec, Refine};

/// A whole job.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name; results go to `results/<name>` by default.
    pub name: String,
    /// Root of every random stream.
    pub seed: u64,
    /// The manifest as the user wrote it.
    pub text: String,
    /// Hash over what matters to physics, as lower-case hexadecimal.
    pub hash: String,
    /// Axes of the grid: model keys first, by name, then `load`, then `speed`; the order of
    /// the text is of no effect. `point_id` counts row-major over them, unless the state is
    /// carried along one.
    pub axes: Vec<Axis>,
    /// How points follow from each other; none where each starts from `run.initial`.
    pub carried: Option<Carried>,
    /// How the grid is refined: `axes` and `points` are then those of its finest grid, of which
    /// only some are computed, and `point_id` counts level by level. None where all are computed.
    pub refine: Option<Refine>,
    /// The grid's points, in `point_id` order.
    pub points: Points,
    /// Resolves points between those of the grid, where they are asked for.
    pub between: Between,
    /// What orbits are followed over, where that is asked for.
    pub continuation: Option<ContinuationSpec>,
}

impl Job {
    /// Whether results are to have the same bits on every processor.
    pub fn portable(&self) -> bool {
        let mut variants = self.points.variants().iter();
        variants.any(|variant| variant.run.portable)
    }

    /// Points of a chain: each starts where the one before it ended, and all chains are
    /// equally long. 1 where points are independent.
    pub fn chain_length(&self) -> usize {
        self.carried.as_ref().map_or(1, |carried| carried.length)
    }

    /// The point like `point` with another value on the swept axis; none where no state is
    /// carried, where the manifest does not ask for refinement, or where the key takes no
    /// such value (a whole number between two).
    pub fn point_between(&self, point: &PointSpec, value: f64) -> Option<PointSpec> {
        let axis = self.carried.as_ref()?.axis;
        let mut between = point.clone();
        between.axis_values[axis] = value;
        match &self.axes[axis].key {
            AxisKey::Load => between.load = value,
            AxisKey::Speed => between.speed = value,
            AxisKey::Key(_) => self.between.resolve(&mut between)?,
        }
        Some(between)
    }
}
