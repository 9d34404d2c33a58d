//! A traced trajectory over time: deflection between the flanks, mesh force, and the flank in contact.

use super::axis::{Axis, padded, range};
use super::canvas::{Anchor, BLUE, Canvas, Colour, INK, Place, RED, SOFT, WHITE};
use super::panel::{LABEL_SIZE, LEFT, Panel, TICK_SIZE, label_place};
use super::picture::Drawn;
use super::recording::{ContactChange, Recording};
use crate::report::numbers::number;

const RIGHT: f64 = 838.0;
/// Largest number of mesh cycles shown. With more, the curve would fill the panel.
const MOST_CYCLES: u64 = 40;
/// Largest number of places of a drawn curve. A longer curve is reduced to the minimum and maximum of each
/// interval.
const MOST_SAMPLES: usize = 6000;

/// Contact states, from bottom to top, with their colours.
const STATES: [(&str, Colour); 3] = [
    ("coast", Colour(0xd5, 0x5e, 0x00)),
    ("free", Colour(0xdc, 0xdc, 0xdc)),
    ("drive", Colour(0x0b, 0x5c, 0x9e)),
];

pub(super) fn draw(recording: &Recording) -> Drawn {
    let rows = recording.first_cycles(MOST_CYCLES);
    let time = &recording.time[..rows];
    let unit = match recording.period {
        Some(period) => {
            let (factor, unit) = super::axis::scaled_unit("s", period);
            format!("mesh cycles of {} {unit}", number(period * factor))
        }
        None => "mesh cycles".into(),
    };
    let across = Axis::linear("time since the start", &unit, range(time.iter().copied()));
    let title = format!("{}: trace of the mesh", recording.job);
    let mut canvas = Canvas::titled(&title, &recording.subtitle(rows));

    let gap = recording.half_gap;
    let edges = gap.into_iter().flat_map(|gap| [-gap, gap]);
    let deflection = &recording.deflection[..rows];
    let bounds = range(deflection.iter().copied().chain(edges));
    let panel = Panel::new(
        [LEFT, RIGHT],
        [72.0, 258.0],
        across.clone(),
        Axis::linear(
            "deflection",
            recording.unit("deflection"),
            padded(bounds, 0.07),
        ),
    );
    panel.frame(&mut canvas, false);
    if let Some(gap) = gap {
        let flanks = [(gap, "drive flank"), (-gap, "coast flank")];
        panel.levels(&mut canvas, &flanks, RED);
    }
    curve(&mut canvas, &panel, time, deflection);
    if let Some(gap) = gap {
        mark_changes(&mut canvas, &panel, &recording.changes, time, gap);
    }

    let force = &recording.force[..rows];
    let bounds = padded(range(force.iter().copied().chain([0.0])), 0.07);
    let panel = Panel {
        top: 276.0,
        bottom: 446.0,
        up: Axis::linear("mesh force", recording.unit("force"), bounds),
        ..panel
    };
    panel.frame(&mut canvas, false);
    curve(&mut canvas, &panel, time, force);
    if gap.is_some() {
        key(&mut canvas, [panel.right + 8.0, panel.top + 10.0]);
    }

    let panel = Panel {
        top: 464.0,
        bottom: 526.0,
        up: Axis::linear("contact", "1", [0.0, STATES.len() as f64]),
        ..panel
    };
    contact(&mut canvas, &panel, recording, rows);
    Drawn::one("trace", canvas)
}

fn curve(canvas: &mut Canvas, panel: &Panel, time: &[f64], values: &[f64]) {
    let stretch = (2 * values.len()).div_ceil(MOST_SAMPLES).max(1);
    let mut path: Vec<Place> = Vec::new();
    for (times, values) in time.chunks(stretch).zip(values.chunks(stretch)) {
        let finite = || (0..values.len()).filter(|&i| values[i].is_finite());
        let low = finite().min_by(|&a, &b| values[a].total_cmp(&values[b]));
        let high = finite().max_by(|&a, &b| values[a].total_cmp(&values[b]));
        let (Some(low), Some(high)) = (low, high) else {
            canvas.line(&path, BLUE, 1.3);
            path.clear();
            continue;
        };
        for row in [low.min(high), low.max(high)] {
            let place = panel.at(times[row], values[row]);
            if path.last() != Some(&place) {
                path.push(place);
            }
        }
    }
    canvas.line(&path, BLUE, 1.3);
}

/// Draws triangles on the flanks: filled where contact begins, hollow where it ends.
fn mark_changes(
    canvas: &mut Canvas,
    panel: &Panel,
    changes: &[ContactChange],
    time: &[f64],
    gap: f64,
) {
    let [first, last] = range(time.iter().copied());
    let shown = changes.iter().filter(|c| (first..=last).contains(&c.time));
    for change in shown {
        let edge = if change.on_drive_flank { gap } else { -gap };
        triangle(canvas, panel.at(change.time, edge), change);
    }
}

/// Draws the key of the triangles, from a place down.
fn key(canvas: &mut Canvas, [x, y]: Place) {
    for (line, entry, name) in [(0.0, true, "contact begins"), (1.0, false, "contact ends")] {
        let at = [x + 5.0, y + 18.0 * line];
        let change = ContactChange {
            time: 0.0,
            on_drive_flank: true,
            is_entry: entry,
        };
        triangle(canvas, at, &change);
        canvas.label([x + 15.0, at[1] + 0.35 * TICK_SIZE], name, SOFT);
    }
}

/// Draws a triangle that points out of the gap if contact begins, and into the gap if contact ends.
fn triangle(canvas: &mut Canvas, at: Place, change: &ContactChange) {
    const SIZE: f64 = 4.5;
    // The drive flank is at the top, and y points down.
    let up = change.on_drive_flank == change.is_entry;
    let tip = if up { -SIZE } else { SIZE };
    let corners = [
        [at[0], at[1] + tip],
        [at[0] + SIZE, at[1] - tip],
        [at[0] - SIZE, at[1] - tip],
    ];
    let fill = if change.is_entry { RED } else { WHITE };
    canvas.polygon(&corners, fill);
    canvas.line(&[corners[0], corners[1], corners[2], corners[0]], RED, 1.0);
}

/// Whether a recorded state of contact includes one of [`STATES`]. The state `both` includes `drive` and
/// `coast`.
fn has(contact: &str, state: &str) -> bool {
    contact == state || (contact == "both" && state != "free")
}

/// Draws the states of contact over time, each state in a separate row.
fn contact(canvas: &mut Canvas, panel: &Panel, recording: &Recording, rows: usize) {
    let height = (panel.bottom - panel.top) / STATES.len() as f64;
    for (row, (name, colour)) in STATES.iter().enumerate() {
        let [high, low] = [panel.y(row as f64 + 1.0), panel.y(row as f64)];
        let mut start = None;
        for sample in 0..=rows {
            let inside = sample < rows && has(&recording.contact[sample], name);
            match (inside, start) {
                (true, None) => start = Some(sample),
                (false, Some(from)) => {
                    let end = recording.time[sample.min(rows.saturating_sub(1))];
                    let [left, right] = [recording.time[from], end].map(|t| panel.x(t));
                    canvas.rectangle([left, high + 2.0], [right, low - 2.0], *colour);
                    start = None;
                }
                _ => {}
            }
        }
        let at = [panel.left - 9.0, low - 0.5 * height + 0.35 * TICK_SIZE];
        canvas.text(at, name, TICK_SIZE, INK, Anchor::End);
    }
    let at = [
        label_place(panel.left, 0.0),
        0.5 * (panel.top + panel.bottom),
    ];
    canvas.text_upwards(at, "contact", LABEL_SIZE, INK, Anchor::Middle);
    for (value, text) in panel.across.ticks(8) {
        let x = panel.x(value);
        canvas.line(&[[x, panel.bottom], [x, panel.bottom + 5.0]], INK, 1.0);
        let at = [x, panel.bottom + 9.0 + TICK_SIZE];
        canvas.text(at, &text, TICK_SIZE, INK, Anchor::Middle);
    }
    let at = [0.5 * (panel.left + panel.right), panel.bottom + 46.0];
    canvas.text(at, &panel.across.label, LABEL_SIZE, INK, Anchor::Middle);
    panel.outline(canvas);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_both_flanks_closed_each_is() {
        let rows = |contact: &str| STATES.map(|(state, _)| has(contact, state));
        assert_eq!(rows("both"), [true, false, true]);
        assert_eq!(rows("coast"), [true, false, false]);
        assert_eq!(rows("free"), [false, true, false]);
        assert_eq!(rows("drive"), [false, false, true]);
    }
}
