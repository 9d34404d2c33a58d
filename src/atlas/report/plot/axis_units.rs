//! The units in which pictures show the axes of a grid.

use std::collections::BTreeMap;

use super::axis::{Axis, value_words};
use super::display::Unit;
use crate::report::Axis as GridAxis;

/// Units of axes, by the name of the axis. All other axes are shown in SI.
#[derive(Debug, Default)]
pub(super) struct AxisUnits(BTreeMap<String, Unit>);

impl AxisUnits {
    /// The units of `axes`: the first of `requested` that fits the axis, else its unit in the manifest,
    /// `written`.
    pub fn new(
        axes: &[GridAxis],
        written: &BTreeMap<String, String>,
        requested: &[String],
    ) -> Self {
        let of = |axis: &GridAxis| {
            let written = || Unit::of(written.get(&axis.name)?, &axis.unit);
            Unit::first(requested, &axis.unit).or_else(written)
        };
        let shown = axes
            .iter()
            .filter_map(|axis| Some((axis.name.clone(), of(axis)?)));
        Self(shown.collect())
    }

    /// The axis of a picture for a grid axis. `make` makes it from name and SI unit. This function then sets the
    /// shown unit.
    pub fn axis(&self, axis: &GridAxis, make: impl FnOnce(&str, &str) -> Axis) -> Axis {
        let made = make(&axis.name, &axis.unit);
        match self.0.get(&axis.name) {
            Some(unit) => made.in_unit(&axis.name, &unit.text, unit.factor),
            None => made,
        }
    }

    /// A value of an axis as text: `speed 6000 rpm`.
    pub fn words(&self, axis: &GridAxis, value: f64) -> String {
        match self.0.get(&axis.name) {
            Some(unit) => unit.words(&axis.name, value),
            None => format!("{} {}", axis.name, value_words(value, &axis.unit)),
        }
    }
}
