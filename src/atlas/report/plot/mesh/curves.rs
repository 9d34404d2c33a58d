//! Stiffness, load centre and loaded transmission error over the mesh phase. One picture has lines for several
//! torques, and another picture has lines for several misalignments.

use super::data::MeshCurves;
use super::labels::{self, Named};
use super::spread;
use crate::gear::MeshTable;
use crate::report::plot::axis::{Axis, padded, range};
use crate::report::plot::canvas::Canvas;
use crate::report::plot::panel::{LEFT, Panel, TOP};
use crate::report::plot::picture::{Drawn, Picture};
use crate::report::plot::ramp::viridis;

/// A panel for one quantity.
struct Row {
    values: fn(&MeshTable) -> &[f64],
    unit: &'static str,
    /// Name of the vertical axis.
    name: &'static str,
    /// Smallest range of the axis in SI. Smaller variations are round-off, or negligible.
    least: f64,
}

const ROWS: [Row; 3] = [
    Row {
        values: |table| &table.stiffness,
        unit: "N/m",
        name: "mesh stiffness",
        least: 1e3,
    },
    Row {
        values: |table| &table.centre,
        unit: "m",
        name: "load centre",
        least: 2e-6,
    },
    Row {
        values: |table| &table.transmission_error,
        unit: "m",
        name: "transmission error",
        least: 1e-9,
    },
];
/// Largest number of lines in a panel.
const MOST_LINES: usize = 5;
/// The brightest colour of a line, as a fraction of the ramp. Brighter colours are invisible on white.
const BRIGHTEST: f64 = 0.72;
const RIGHT: f64 = 815.0;
const HEIGHT: f64 = 202.0;
const GAP: f64 = 18.0;

pub(super) fn draw(mesh: &MeshCurves) -> Drawn {
    let (aligned, middle) = (mesh.aligned(), mesh.table.torque.len() / 2);
    let (torques, torque_unit) = mesh.torques();
    let (angles, angle_unit) = mesh.misalignments();
    let mut families = Vec::new();
    if mesh.table.torque.len() > 1 || mesh.table.misalignment.len() == 1 {
        let lines = spread(mesh.table.torque.len(), MOST_LINES).into_iter();
        families.push(Family {
            picture: "mesh",
            by: "torque",
            held: mesh.misalignment_text(aligned),
            members: lines.map(|t| ([aligned, t], torques[t].clone())).collect(),
            unit: torque_unit,
        });
    }
    if mesh.table.misalignment.len() > 1 {
        let lines = spread(mesh.table.misalignment.len(), MOST_LINES).into_iter();
        families.push(Family {
            picture: "mesh-misalignment",
            by: "misalignment",
            held: mesh.torque_text(middle),
            members: lines.map(|m| ([m, middle], angles[m].clone())).collect(),
            unit: angle_unit,
        });
    }
    Drawn {
        pictures: families.iter().map(|family| family.draw(mesh)).collect(),
        notes: Vec::new(),
    }
}

/// The lines of a picture: the table at several torques, or at several misalignments.
struct Family {
    picture: &'static str,
    /// The quantity that distinguishes the lines.
    by: &'static str,
    /// The quantity with one value for all lines, as text.
    held: String,
    /// For each line, its indices of misalignment and torque in the table, and the value that distinguishes
    /// it.
    members: Vec<([usize; 2], String)>,
    /// Unit of that value.
    unit: String,
}

impl Family {
    fn draw(&self, mesh: &MeshCurves) -> Picture {
        let by = if self.members.len() > 1 { format!(" by {}", self.by) } else { String::new() };
        let title = format!(
            "{}: stiffness, load centre and transmission error{by}",
            mesh.name
        );
        let mut canvas = Canvas::titled(&title, &self.held);
        let mut top = TOP;
        for (place, row) in ROWS.iter().enumerate() {
            let lines = self.lines(mesh, row);
            let values = lines.iter().flat_map(|line| &line.curve);
            let bounds = widened(range(values.map(|[_, value]| *value)), row.least);
            let panel = Panel::new(
                [LEFT, RIGHT],
                [top, top + HEIGHT],
                Axis::linear("mesh phase", "1", [0.0, 1.0]),
                Axis::linear(row.name, row.unit, padded(bounds, 0.07)),
            );
            panel.frame(&mut canvas, place + 1 == ROWS.len());
            labels::draw(&mut canvas, &panel, &lines, &self.unit);
            top += HEIGHT + GAP;
        }
        canvas.height = top - GAP + 64.0;
        Picture::new(format!("{}-{}", mesh.name, self.picture), canvas)
    }

    fn lines(&self, mesh: &MeshCurves, row: &Row) -> Vec<Named> {
        let last = (self.members.len() - 1).max(1) as f64;
        let values = (row.values)(&mesh.table);
        let line = |(place, (at, name)): (usize, &([usize; 2], String))| Named {
            curve: mesh.curve(values, *at, [0, 1]),
            name: name.clone(),
            colour: viridis(BRIGHTEST * place as f64 / last),
        };
        self.members.iter().enumerate().map(line).collect()
    }
}

/// The range, widened about its middle to at least `least`.
fn widened([low, high]: [f64; 2], least: f64) -> [f64; 2] {
    if high - low < least {
        [0.5 * (low + high - least), 0.5 * (low + high + least)]
    } else {
        [low, high]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_off_is_not_blown_up() {
        assert_eq!(widened([-1e-18, 1e-18], 2e-6), [-1e-6, 1e-6]);
        assert_eq!(widened([3.0, 3.0], 1.0), [2.5, 3.5]);
        assert_eq!(widened([0.0, 2.0], 1.0), [0.0, 2.0]);
    }
}
