//! The branches of attractors, as text.

use super::manifest_units::converted;
use super::table::place_words;
use crate::report::numbers::number;
use crate::report::point::varied;
use crate::report::summary::Summary;
use std::fmt::Write;

/// The branches of a results folder as text: one line per attractor, branch by branch. Axes have the units of
/// the manifest.
pub fn render_branches(summary: &Summary) -> String {
    let summary = &converted(summary);
    let mut text = String::from("branches of attractors");
    let along = summary.axes.iter().rposition(|axis| axis.values.len() > 1);
    match along.map(|along| &summary.axes[along]) {
        Some(axis) => _ = writeln!(text, " along {}", axis.name),
        None => text.push('\n'),
    }
    let mut order: Vec<usize> = (0..summary.attractors.len()).collect();
    order.sort_by_key(|&index| summary.branches[index]);
    let mut last = None;
    for index in order {
        let (attractor, branch) = (&summary.attractors[index], summary.branches[index]);
        if last != Some(branch) {
            _ = writeln!(text, "\nbranch {branch}");
            last = Some(branch);
        }
        let place = summary
            .all
            .binary_search_by_key(&attractor.point_id, |point| point.point_id);
        let values = place.map_or(&[][..], |place| &summary.all[place].axis_values);
        let place = place_words(summary, varied(&summary.axes), values);
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        let [low, high] = attractor.interval.map(percent);
        let rms = attractor
            .deflection_rms
            .map_or("–".into(), |rms| number(1e6 * rms));
        _ = writeln!(
            text,
            "  point {:<5} {:<34} {:<15} RMS {rms:>6} µm  {:>5} % ({low} … {high})",
            attractor.point_id,
            place,
            attractor.kind(),
            percent(attractor.share),
        );
    }
    text
}
