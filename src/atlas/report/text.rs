//! A [`Summary`] as text for a terminal.

mod branches;
mod coexistence;
mod followed;
mod heat;
mod lifetimes;
mod manifest_units;
mod orbits;
mod rattle;
mod style;
mod table;
mod transitions;

pub use branches::render_branches;
pub use followed::counted;
pub use style::Style;

use std::fmt::Write;

use super::numbers::{number, plural};
use super::point::{PointSummary, TRANSIENT_CHAOS};
use super::summary::{LARGEST_RESIDUAL, Summary};
use crate::analysis::Effort;
use crate::input::printable;
use crate::store::{RefinedColumns, RunState};
use heat::heat_map;
use table::{place_words, push_table};

/// The summary as text.
pub fn render(summary: &Summary, style: Style) -> String {
    let summary = &manifest_units::converted(summary);
    let mut text = String::new();
    if summary.is_of_orbits_alone() {
        push_title(&mut text, summary);
        followed::push(&mut text, summary);
        return text;
    }
    push_header(&mut text, summary);
    push_classes(&mut text, summary);
    let map = heat_map(summary, style);
    if !map.is_empty() {
        _ = write!(text, "\n{map}");
    }
    push_chaotic(&mut text, summary);
    lifetimes::push(&mut text, summary);
    rattle::push(&mut text, summary);
    push_twins(&mut text, summary);
    transitions::push(&mut text, summary);
    followed::push(&mut text, summary);
    coexistence::push(&mut text, summary);
    orbits::push(&mut text, summary);
    push_energy(&mut text, summary);
    push_troubled(&mut text, summary);
    let (energy, errors) = (energy_warning(summary), errors_warning(summary));
    if !summary.warnings.is_empty() || energy.is_some() || errors.is_some() {
        text.push_str("\nwarnings\n");
        for warning in summary.warnings.iter().chain(&energy).chain(&errors) {
            _ = writeln!(text, "  {warning}");
        }
    }
    text
}

fn push_title(text: &mut String, summary: &Summary) {
    let job = summary.job.as_deref().unwrap_or("job unknown");
    _ = writeln!(
        text,
        "{job}  ({})",
        printable(&summary.folder.display().to_string())
    );
}

fn push_header(text: &mut String, summary: &Summary) {
    push_title(text, summary);
    let statuses: Vec<String> = summary
        .statuses
        .iter()
        .map(|(status, count)| format!("{count} {status}"))
        .collect();
    _ = write!(text, "  {}", plural(summary.points, "point"));
    if !statuses.is_empty() {
        _ = write!(text, ": {}", statuses.join(", "));
    }
    text.push('\n');
    let fixed_values: Vec<f64> = (summary.axes.iter())
        .map(|axis| axis.values.first().copied().unwrap_or(f64::NAN))
        .collect();
    let single = (0..summary.axes.len()).filter(|&axis| summary.axes[axis].values.len() == 1);
    let fixed_values = place_words(summary, single, &fixed_values);
    if !fixed_values.is_empty() && summary.points > 1 {
        _ = writeln!(text, "  all at {fixed_values}");
    } else if !fixed_values.is_empty() {
        _ = writeln!(text, "  at {fixed_values}");
    }
    if let Some([found, expected]) = summary.shards {
        _ = writeln!(text, "  {found} of {expected} shards");
    }
    let missing = summary.expected - summary.points as u64;
    let lacks_shards = summary
        .shards
        .is_some_and(|[found, expected]| found < expected);
    match summary.state {
        Some(RunState::Complete) => {}
        Some(RunState::Interrupted) if lacks_shards && missing == 0 => {
            text.push_str("  the other shards are missing; `atlas merge` joins all of them\n");
        }
        Some(RunState::Interrupted) => {
            let missing = if missing > 0 {
                let least = if summary.refined.is_some() { "at least " } else { "" };
                format!("{least}{missing} points are missing")
            } else {
                String::new()
            };
            let joint = if missing.is_empty() { "" } else { ": " };
            _ = writeln!(
                text,
                "  interrupted{joint}{missing}; the same `atlas run` continues"
            );
        }
        None => {
            _ = writeln!(
                text,
                "  no run.json: the run has not ended, or the file was removed"
            )
        }
    }
    let mut parts = Vec::new();
    if let Some(wall_time) = summary.wall_time {
        parts.push(format!("{} s wall time", number(wall_time)));
    }
    parts.push(format!("{} mesh cycles integrated", summary.cycles));
    if let Some(time) = summary.wall_time_per_cycle {
        parts.push(format!("{} µs per cycle", number(1e6 * time)));
    }
    if let Some(time) = summary.worker_time_per_cycle {
        parts.push(format!("{} µs per cycle on one worker", number(1e6 * time)));
    }
    _ = writeln!(text, "  {}", parts.join(", "));
    if let Some(refined) = &summary.refined {
        _ = writeln!(text, "  {}", refined_words(summary, refined));
    }
}

/// The refinement of a grid as text: criterion, undivided grid, number of halvings, and the state from which
/// points start.
fn refined_words(summary: &Summary, refined: &RefinedColumns) -> String {
    let nested = refined.nested;
    let [rows, columns] = nested.sides(nested.levels);
    let share = 100.0 * summary.points as f64 / nested.places(nested.levels) as f64;
    format!(
        "refined by {}: from {} x {} points by up to {}, {} % of {rows} x {columns}\n  every point \
         starts from run.initial ({}); where motions coexist, the map shows the motions reached from this state",
        printable(&refined.by),
        nested.coarse[0],
        nested.coarse[1],
        plural(nested.levels as usize, "halving"),
        number(share),
        printable(&refined.start),
    )
}

fn push_classes(text: &mut String, summary: &Summary) {
    if summary.classes.is_empty() {
        text.push_str("\nno point was computed\n");
        return;
    }
    text.push_str("\nclass of motion\n");
    for count in &summary.classes {
        let class = match (count.class.as_str(), count.period) {
            ("none", _) => "not classified".into(),
            (_, Some(period)) => format!("period {period}"),
            (class, None) => class.replace('_', " "),
        };
        _ = writeln!(text, "  {class:<24}{:>6}", count.points);
    }
}

fn push_chaotic(text: &mut String, summary: &Summary) {
    if summary.with_exponent == 0 {
        text.push_str("\nno Lyapunov exponents in these results\n");
        return;
    }
    if summary.chaotic.is_empty() {
        text.push_str("\nno chaotic point\n");
        return;
    }
    text.push_str("\nchaotic points, λ in 1/cycle\n");
    push_table(
        text,
        summary,
        &summary.chaotic,
        summary.chaotic_points,
        |point| {
            let mut cell = exponent(point);
            if point.class.as_deref() == Some(TRANSIENT_CHAOS) {
                cell.push_str("  transient");
            }
            if point.twin_agrees == Some(false) {
                cell.push_str("  twin disagrees");
            }
            cell
        },
    );
}

fn push_twins(text: &mut String, summary: &Summary) {
    let (disagree, compared) = (summary.twin_disagrees_points, summary.with_twin);
    if compared == 0 {
        return;
    }
    _ = writeln!(
        text,
        "\ntwin trajectories: {disagree} of {compared} disagree with the tangent vectors"
    );
    if disagree > 0 {
        push_table(text, summary, &summary.twin_disagrees, disagree, |point| {
            let twin = point.twin.map_or_else(|| "none".into(), number);
            format!("{}, twin {twin}", exponent(point))
        });
    }
}

fn push_energy(text: &mut String, summary: &Summary) {
    if let Some((point_id, residual)) = summary.worst_energy {
        _ = writeln!(
            text,
            "\nworst energy residual {residual:.1e} (point {point_id})"
        );
    }
}

/// A warning if the energy balance of some points has too large a residual for the digits shown.
fn energy_warning(summary: &Summary) -> Option<String> {
    let (point_id, worst) = summary.worst_energy?;
    let open = summary.open_balances;
    (open > 0).then(|| {
        format!(
            "energy_residual is above {LARGEST_RESIDUAL:.0e} at {}, {worst:.1e} at point {point_id}: the motion is \
             less accurate there than the digits shown; raise run.steps, or set another run.kernel",
            plural(open, "point")
        )
    })
}

/// A warning if some standard errors come from too few cycles for verified coverage.
fn errors_warning(summary: &Summary) -> Option<String> {
    let unverified = summary.unverified_points;
    (unverified > 0).then(|| {
        format!(
            "standard errors are not verified for {unverified} of {} that do not settle; set run.cycles to {} or more \
             and analyses.lyapunov.effort = \"verified\"",
            plural(summary.with_evidence, "point"),
            Effort::Verified.first_look()
        )
    })
}

fn push_troubled(text: &mut String, summary: &Summary) {
    if summary.troubled.is_empty() {
        return;
    }
    text.push_str("\npoints that are not ok\n");
    push_table(
        text,
        summary,
        &summary.troubled,
        summary.troubled_points,
        |point| format!("{}: {}", point.status, point.reason),
    );
}

/// λ with its standard error, rounded to two digits of the error.
fn exponent(point: &PointSummary) -> String {
    match (point.lambda, point.stderr) {
        (Some(lambda), Some(stderr)) if stderr > 0.0 => {
            // Decimals that show two digits of the error.
            let digits = (1.0 - stderr.log10().floor()).clamp(0.0, 12.0) as usize;
            format!("λ = {lambda:.digits$} ± {stderr:.digits$}")
        }
        (Some(lambda), _) => format!("λ = {}", number(lambda)),
        (None, _) => "λ unknown".into(),
    }
}

#[cfg(test)]
mod tests;
