//! The contact pattern: load over mesh phase and face width. Columns of panels are the smallest and the
//! largest torque. Rows are the misalignments of smallest and largest magnitude.

use super::data::MeshCurves;
use crate::report::plot::axis::{Axis, range};
use crate::report::plot::canvas::{Canvas, Colour, INK, SOFT};
use crate::report::plot::error::PlotError;
use crate::report::plot::panel::{LEFT, Panel};
use crate::report::plot::picture::Drawn;
use crate::report::plot::picture_kind::PictureKind;
use crate::report::plot::ramp::{bar, viridis};

const TOP: f64 = 96.0;
/// Width and height of all panels together \[px\].
const SIZE: [f64; 2] = [700.0, 420.0];
/// Gaps between panels \[px\].
const GAP: [f64; 2] = [34.0, 44.0];
/// Number of distinct colours. Neighbouring cells of one colour become one shape.
const COLOUR_STEPS: f64 = 64.0;
/// Colour of cells without contact.
const NO_CONTACT: Colour = Colour(0xe4, 0xe4, 0xe4);

pub(super) fn draw(mesh: &MeshCurves) -> Result<Drawn, PlotError> {
    let (values, slices) = (&mesh.table.pattern, mesh.table.slices);
    if values.is_empty() {
        return Err(PictureKind::Contact.unfit("the table was made without a contact pattern"));
    }
    let edges = mesh.phase_edges();
    let phases = edges.len() - 1;
    let rows = ends(mesh.aligned(), farthest(mesh));
    let columns = ends(0, mesh.table.torque.len() - 1);
    let cells = phases * slices;
    let pattern = |row: usize, column: usize| {
        let first = (row * mesh.table.torque.len() + column) * cells;
        &values[first..first + cells]
    };
    let shown = rows
        .iter()
        .flat_map(|&r| columns.iter().map(move |&c| (r, c)));
    let largest = range(shown.flat_map(|(r, c)| pattern(r, c)).copied())[1].max(f64::MIN_POSITIVE);
    let title = format!("{}: contact pattern over a mesh cycle", mesh.name);
    let subtitle = "load of all pairs per unit of face width; grey: no contact";
    let mut canvas = Canvas::titled(&title, subtitle);
    let fit =
        |axis: usize, count: usize| (SIZE[axis] - GAP[axis] * (count - 1) as f64) / count as f64;
    let [wide, high] = [fit(0, columns.len()), fit(1, rows.len())];
    for (down, &row) in rows.iter().enumerate() {
        for (right, &column) in columns.iter().enumerate() {
            let left = LEFT + (wide + GAP[0]) * right as f64;
            let top = TOP + (high + GAP[1]) * down as f64;
            let panel = Panel::new(
                [left, left + wide],
                [top, top + high],
                Axis::linear("mesh phase", "1", [0.0, 1.0]),
                Axis::linear("position / face width", "1", [-0.5, 0.5]),
            );
            frame(&mut canvas, &panel, right == 0, down + 1 == rows.len());
            cover(&mut canvas, &panel, &edges, pattern(row, column), largest);
            let words = [mesh.torque_text(column), mesh.misalignment_text(row)].join(", ");
            canvas.label([left, top - 8.0], &words, INK);
        }
    }
    let axis = Axis::linear("load", "N/m", [0.0, largest]);
    let x = LEFT + SIZE[0] + 30.0;
    bar(&mut canvas, x, [TOP, TOP + SIZE[1]], &axis);
    canvas.height = TOP + SIZE[1] + 64.0;
    let name = format!("{}-contact", mesh.name);
    Ok(Drawn::one(name, canvas))
}

/// Both indices, or one if they are equal.
fn ends(first: usize, last: usize) -> Vec<usize> {
    if first == last { vec![first] } else { vec![first, last] }
}

/// The index of the misalignment with the largest magnitude.
fn farthest(mesh: &MeshCurves) -> usize {
    let angles = &mesh.table.misalignment;
    let largest = (0..angles.len()).max_by(|&a, &b| angles[a].abs().total_cmp(&angles[b].abs()));
    largest.unwrap_or(0)
}

/// Draws frame and ticks. Only the first column and the lowest row of panels have texts.
fn frame(canvas: &mut Canvas, panel: &Panel, first: bool, lowest: bool) {
    if first {
        panel.frame(canvas, lowest);
    } else {
        panel.ticks_across(canvas, lowest);
    }
}

/// Draws the cells of a panel: mesh phases from left to right, slices of the face from bottom to top.
fn cover(canvas: &mut Canvas, panel: &Panel, edges: &[f64], values: &[f64], largest: f64) {
    let phases = edges.len() - 1;
    let slices = values.len() / phases;
    let step = |phase: usize, slice: usize| {
        let value = values[phase * slices + slice];
        // Without contact, the value is 0 or NaN.
        (value > 0.0).then(|| (COLOUR_STEPS * value / largest).round() as u32)
    };
    for slice in 0..slices {
        let y = |edge: usize| panel.y(edge as f64 / slices as f64 - 0.5);
        let mut start = 0;
        while start < phases {
            let load_step = step(start, slice);
            let run = (start..phases)
                .take_while(|&p| step(p, slice) == load_step)
                .count();
            let x = |edge: usize| panel.x(edges[edge]);
            let colour =
                load_step.map_or(NO_CONTACT, |step| viridis(f64::from(step) / COLOUR_STEPS));
            // Slightly enlarged, because abutting edges show as seams in some viewers.
            let right = (x(start + run) + 0.3).min(panel.right);
            let low = (y(slice) + 0.3).min(panel.bottom);
            canvas.rectangle([x(start), y(slice + 1)], [right, low], colour);
            start += run;
        }
    }
    let corners = [[panel.left, panel.top], [panel.right, panel.bottom]];
    canvas.outline(corners[0], corners[1], INK, 1.0);
    // A dashed line marks the middle of the face.
    let middle = panel.y(0.0);
    canvas.dashes([panel.left, middle], [panel.right, middle], SOFT, 0.8);
}
