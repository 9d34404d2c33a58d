//! A whole job: name, grid and points.

use super::axis::{AxisKey, AxisValues};
use super::grid_dimension::GridDimension;
use super::point_resolver::PointResolver;
use super::points::Points;
use super::spec::{Axis, Carried, ContinuationSpec, PointSpec, Refine, RunUpSpec, Samples};
use super::{ManifestText, Warnings};
use std::path::PathBuf;

/// A whole job.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name; results go to `results/<name>` by default.
    pub name: String,
    /// Seed of every random stream, unless the axis `job.seed` of the grid gives it.
    pub seed: u64,
    /// The manifest as the user wrote it.
    pub text: String,
    /// Keys with changed values, as typed: `KEY=VALUE`.
    pub changes: Vec<String>,
    /// The folder in which relative paths of the manifest start.
    pub folder: PathBuf,
    /// Keys without effect, and other warnings about the job.
    pub warnings: Warnings,
    /// Hash of all that affects the physics, as lower-case hexadecimal.
    pub hash: String,
    /// Axes of the grid: model keys first, by name, then `load` or `torque`, then `speed`; the order of the text has no
    /// effect.
    pub axes: Vec<Axis>,
    /// The dimensions of the axes, slowest first: tied axes share one. `point_id` counts row-major over these, unless
    /// the state is carried along one or the grid is refined.
    pub dimensions: Vec<GridDimension>,
    /// How the state is carried; `None` if each point starts from `run.initial`.
    pub carried: Option<Carried>,
    /// How the grid is refined; `None` if all points are computed. `axes` and `points` are those of the finest grid, of
    /// which only some are computed, and `point_id` counts level by level.
    pub refine: Option<Refine>,
    /// How values of axes with distributions are drawn, if any; these axes share one dimension.
    pub samples: Option<Samples>,
    /// The grid's points, in `point_id` order.
    pub points: Points,
    /// Resolves points between those of the grid.
    pub between: PointResolver,
    /// The parameters over which orbits are followed, if requested.
    pub continuation: Option<ContinuationSpec>,
    /// The run-up, if requested.
    pub run_up: Option<RunUpSpec>,
}

impl Job {
    /// The text and its changes.
    pub fn written(&self) -> ManifestText<'_> {
        ManifestText {
            text: &self.text,
            changes: &self.changes,
        }
    }

    /// Whether results must have the same bits on every processor.
    pub fn portable(&self) -> bool {
        let mut variants = self.points.variants().iter();
        variants.any(|variant| variant.run.portable)
    }

    /// Number of points in a chain; all chains are equally long. In a chain, each point starts at the end of
    /// the previous one. 1 if points are independent.
    pub fn chain_length(&self) -> usize {
        self.carried.as_ref().map_or(1, |carried| carried.length)
    }

    /// The point with another value on the swept axis; the values of tied axes are interpolated. `None` if no
    /// state is carried, if the axis has one value, or if a key cannot have its new value (a whole number has no
    /// value between two neighbours).
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

    /// Computes the values of axes given by expressions from the other axes; NaN if an expression has no value.
    pub fn derive(&self, values: &mut [f64]) {
        let place = |name: &str| self.axes.iter().position(|axis| axis.name() == name);
        for (key, _, expression) in self.between.derived() {
            let value = expression.value(|name| place(name).map_or(f64::NAN, |at| values[at]));
            if let Some(target) = place(key.name()) {
                values[target] = value.unwrap_or(f64::NAN);
            }
        }
    }

    /// All axes along the dimension of `axis`.
    pub fn tied(&self, axis: usize) -> &[usize] {
        &self.dimensions[GridDimension::of(&self.dimensions, axis)].axes
    }

    /// Sets load, speed, mesh and excitation of a point by its values on some axes; `None` if these are
    /// inconsistent.
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

/// The indices of the two neighbours of a value, and its relative position between them; `None` if the axis
/// has one value.
fn neighbours(values: &AxisValues, value: f64) -> Option<([usize; 2], f64)> {
    let ascending = values.ascending();
    let at = |rank: usize| values.get(ascending.place(rank));
    let last = ascending.len().checked_sub(1).filter(|last| *last > 0)?;
    let above = (1..last).find(|&rank| at(rank) >= value).unwrap_or(last);
    let [low, high] = [at(above - 1), at(above)];
    let part = (value - low) / (high - low);
    Some(([above - 1, above].map(|rank| ascending.place(rank)), part))
}
