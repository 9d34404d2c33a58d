//! The points with more than one attractor, as text.

use super::table::push_table;
use crate::report::coexistence::Ending;
use crate::report::numbers::number;
use crate::report::summary::Summary;
use std::fmt::Write;

/// Appends one line per point.
pub(super) fn push(text: &mut String, summary: &Summary) {
    if summary.coexisting.is_empty() {
        return;
    }
    text.push_str("\nmore than one attractor, shares of the probes with 95 % intervals\n");
    let found = |id| summary.coexisting.iter().find(|point| point.point_id == id);
    let points = &summary.coexisting_points;
    push_table(text, summary, points, points.len(), |point| {
        let endings = found(point.point_id).map_or(&[][..], |point| &point.endings);
        let parts: Vec<String> = endings.iter().map(described).collect();
        parts.join("; ")
    });
}

/// `period 1, RMS 36.7 µm: 12.5 % (5.6 … 25.5)`.
fn described(ending: &Ending) -> String {
    let mut text = match (ending.attractor, ending.class.as_deref(), ending.period) {
        (None, _, _) => ending.status.replace('_', " "),
        (_, Some("periodic"), Some(period)) => format!("period {period}"),
        (_, class, _) => class.unwrap_or("not classified").replace('_', " "),
    };
    if let (Some(_), Some(rms)) = (ending.attractor, ending.deflection_rms) {
        _ = write!(text, ", RMS {} µm", number(1e6 * rms));
    }
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let [low, high] = ending.interval.map(percent);
    _ = write!(text, ": {} % ({low} … {high})", percent(ending.share));
    text
}
