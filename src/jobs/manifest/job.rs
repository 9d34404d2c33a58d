//! A whole job: what its name, grid and points are.

use super::axis::{AxisKey, AxisValues};
use super::expand::PointResolver;
use super::grid_dimension::GridDimension;
use super::points::Points;
use super::spec::{Axis, Carried, ContinuationSpec, PointSpec, Refine, RunUpSpec, Samples};
use super::{ManifestText, Warnings};

/// A whole job.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name; results go to `results/<name>` by default.
    pub name: String,
    /// Root of every random stream, unless an axis of the grid gives it.
    pub seed: u64,
    /// The manifest as the user wrote it.
    pub text: String,
    /// Keys that were given other values than the text has, as typed: `KEY=VALUE`.
    pub changes: Vec<String>,
    /// Keys without effect, and what else is worth a look although the job runs.
    pub warnings: Warnings,
    /// Hash over what matters to physics, as lower-case hexadecimal.
    pub hash: String,
    /// Axes of the grid: model keys first, by name, then `load` or `torque`, then `speed`; the order of
    /// the text is of no effect.
    pub axes: Vec<Axis>,
    /// Along which dimensions they go, slowest first: tied axes share one. `point_id` counts row-major over these,
    /// unless the state is carried along one.
    pub dimensions: Vec<GridDimension>,
    /// How points follow from each other; none where each starts from `run.initial`.
    pub carried: Option<Carried>,
    /// How the grid is refined: `axes` and `points` are then those of its finest grid, of which
    /// only some are computed, and `point_id` counts level by level. None where all are computed.
    pub refine: Option<Refine>,
    /// How values of axes are drawn, where some are distributions: these share one of the dimensions.
    pub samples: Option<Samples>,
    /// The grid's points, in `point_id` order.
    pub points: Points,
    /// Resolves points between those of the grid, where they are asked for.
    pub between: PointResolver,
    /// What orbits are followed over, where that is asked for.
    pub continuation: Option<ContinuationSpec>,
    /// The run-up, where one is asked for.
    pub run_up: Option<RunUpSpec>,
}

impl Job {
    /// What it was read from.
    pub fn written(&self) -> ManifestText<'_> {
        ManifestText {
            text: &self.text,
            changes: &self.changes,
        }
    }

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
        let swept = self.carried.as_ref()?.axis;
        let mut between = point.clone();
        let (before, part) = neighbours(&self.axes[swept].values, value)?;
        for &axis in self.tied(swept) {
            let values = &self.axes[axis].values;
            let [from, to] = before.map(|place| values.get(place));
            between.axis_values[axis] =
                if axis == swept { value } else { (1.0 - part) * from + part * to };
        }
        self.derive(&mut between.axis_values);
        self.apply(&mut between, self.tied(swept))?;
        Some(between)
    }

    /// Gives axes that expressions give the values that follow from those of the others; not a number where there is
    /// none.
    pub fn derive(&self, values: &mut [f64]) {
        let place = |name: &str| self.axes.iter().position(|axis| axis.name() == name);
        for (own, _, expression) in self.between.derived() {
            let value = expression.value(|name| place(name).map_or(f64::NAN, |at| values[at]));
            if let Some(own) = place(own.name()) {
                values[own] = value.unwrap_or(f64::NAN);
            }
        }
    }

    /// The axes that go along the dimension of one, itself among them.
    pub fn tied(&self, axis: usize) -> &[usize] {
        &self.dimensions[GridDimension::of(&self.dimensions, axis)].axes
    }

    /// Gives a point what its values of some axes stand for; none where they make no drive.
    fn apply(&self, point: &mut PointSpec, axes: &[usize]) -> Option<()> {
        let keys = || axes.iter().map(|&axis| (&self.axes[axis].key, axis));
        if keys().any(|(key, _)| key.is_model_key()) {
            self.between.resolve(point)?;
        }
        for (key, axis) in keys() {
            let value = point.axis_values[axis];
            match key {
                AxisKey::Load => point.load = value,
                AxisKey::Torque => point.load = point.model.load_of_torque(value),
                AxisKey::Speed => point.speed = value,
                AxisKey::Key(_) => {}
            }
        }
        Some(())
    }
}

/// The places of the values next to one, and the part of the way between them at which it lies; none for a single
/// value.
fn neighbours(values: &AxisValues, value: f64) -> Option<([usize; 2], f64)> {
    let ascending = values.ascending();
    let at = |rank: usize| values.get(ascending.place(rank));
    let last = ascending.len().checked_sub(1).filter(|last| *last > 0)?;
    let above = (1..last).find(|&rank| at(rank) >= value).unwrap_or(last);
    let [low, high] = [at(above - 1), at(above)];
    let part = (value - low) / (high - low);
    Some(([above - 1, above].map(|rank| ascending.place(rank)), part))
}
