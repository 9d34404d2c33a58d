//! A summary in the units of its manifest, for text. JSON has SI units.

use crate::report::Unit;
use crate::report::point::{Axis, PointSummary};
use crate::report::summary::Summary;

/// The summary with the values of all axes in the units of the manifest.
pub(super) fn converted(summary: &Summary) -> Summary {
    let mut shown = summary.clone();
    let unit = |axis: &Axis| Unit::of_axis(&summary.units, &axis.name, &axis.unit);
    let units: Vec<Unit> = summary.axes.iter().map(unit).collect();
    let named = |name: &str| {
        let place = summary.axes.iter().position(|axis| axis.name == name);
        place.map(|place| &units[place])
    };
    for (axis, unit) in shown.axes.iter_mut().zip(&units) {
        axis.unit.clone_from(&unit.text);
        scale(&mut axis.values, unit.factor);
    }
    let lists = [
        &mut shown.chaotic,
        &mut shown.twin_disagrees,
        &mut shown.coexisting_points,
        &mut shown.lifetimes.transient,
        &mut shown.troubled,
        &mut shown.all,
    ];
    for point in lists.into_iter().flatten() {
        convert(point, &units);
    }
    if let Some(unit) = shown.carried_along.as_deref().and_then(named) {
        for change in &mut shown.transitions {
            scale(&mut change.bracket, unit.factor);
        }
    }
    if let Some(found) = &mut shown.followed
        && let Some(unit) = named(&found.over)
    {
        found.unit.clone_from(&unit.text);
        scale(&mut found.range, unit.factor);
    }
    shown
}

fn convert(point: &mut PointSummary, units: &[Unit]) {
    for (value, unit) in point.axis_values.iter_mut().zip(units) {
        *value *= unit.factor;
    }
}

fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_list_of_points_is_in_the_units_of_the_manifest() {
        let points = || {
            vec![PointSummary {
                axis_values: vec![2e-5],
                ..PointSummary::default()
            }]
        };
        let mut summary = Summary {
            axes: vec![Axis {
                name: "mesh.half_gap".into(),
                unit: "m".into(),
                values: vec![2e-5],
            }],
            units: [("mesh.half_gap".to_owned(), "um".to_owned())].into(),
            chaotic: points(),
            all: points(),
            ..Summary::default()
        };
        summary.lifetimes.transient = points();
        let shown = converted(&summary);
        for list in [shown.chaotic, shown.all, shown.lifetimes.transient] {
            assert!((list[0].axis_values[0] - 20.0).abs() < 1e-9, "{list:?}");
        }
    }
}
