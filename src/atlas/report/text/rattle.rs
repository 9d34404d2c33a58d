//! The rattle of the meshes, as text.

use crate::report::numbers::number;
use crate::report::summary::Summary;
use std::fmt::Write;

/// Largest number of listed meshes; further ones are only counted.
const MOST_LISTED: usize = 12;

/// Appends one line per mesh, the one that rattles most first.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let all = &summary.rattle;
    if all.iter().all(|mesh| mesh.largest == 0.0) {
        return;
    }
    text.push_str("\nrattle by mesh (speeds of impacts per second, m/s²; of stages rad/s²)\n");
    let shown = &all[..all.len().min(MOST_LISTED)];
    let width = shown.iter().map(|mesh| mesh.name.chars().count()).max();
    let width = width.unwrap_or(0);
    for mesh in shown {
        let [mean, largest] = [mesh.mean, mesh.largest].map(number);
        _ = write!(text, "  {:<width$}  mean {mean:>8}", mesh.name);
        if mesh.largest > 0.0 {
            _ = write!(text, "  largest {largest:>8} at point {}", mesh.point_id);
        }
        text.push('\n');
    }
    if all.len() > MOST_LISTED {
        _ = writeln!(
            text,
            "  and {} more that rattle less",
            all.len() - MOST_LISTED
        );
    }
}
