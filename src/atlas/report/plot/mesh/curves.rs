//! Stiffness, load centre and loaded transmission error over the mesh phase: lines for several
//! torques in one picture, for several misalignments in another.

use super::data::MeshCurves;
use super::labels::{self, Named};
use super::spread;
use crate::report::plot::axis::{Axis, padded, range};
use crate::report::plot::canvas::Canvas;
use crate::report::plot::error::PlotError;
use crate::report::plot::panel::Panel;
use crate::report::plot::picture::{Drawn, Picture};
use crate::report::plot::ramp::viridis;
use crate::report::plot::what::What;

/// Panels: array, name of the axis up, least range shown in SI: less is round-off, or nothing
/// beside a face of centimetres.
const PANELS: [(&str, &str, f64); 3] = [
    ("stiffness", "mesh stiffness", 1e3),
    ("centre", "load centre", 2e-6),
    ("transmission_error", "loaded TE", 1e-9),
];
/// Most lines of a panel.
const MOST: usize = 5;
/// The brightest colour of a line, as a place on the ramp: beyond, it is lost on white.
const BRIGHTEST: f64 = 0.72;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 815.0;
const TOP: f64 = 72.0;
const HEIGHT: f64 = 202.0;
const GAP: f64 = 18.0;

pub(super) fn draw(mesh: &MeshCurves) -> Result<Drawn, PlotError> {
    let (aligned, middle) = (mesh.aligned(), mesh.torque.len() / 2);
    let (torques, torque_unit) = mesh.torques();
    let (angles, angle_unit) = mesh.misalignments();
    let mut families = Vec::new();
    if mesh.torque.len() > 1 || mesh.misalignment.len() == 1 {
        let lines = spread(mesh.torque.len(), MOST).into_iter();
        families.push(Family {
            picture: "mesh",
            title: "mesh cycle by torque",
            held: mesh.misalignment_text(aligned),
            members: lines.map(|t| ([aligned, t], torques[t].clone())).collect(),
            unit: torque_unit,
        });
    }
    if mesh.misalignment.len() > 1 {
        let lines = spread(mesh.misalignment.len(), MOST).into_iter();
        families.push(Family {
            picture: "mesh-misalignment",
            title: "mesh cycle by misalignment",
            held: mesh.torque_text(middle),
            members: lines.map(|m| ([m, middle], angles[m].clone())).collect(),
            unit: angle_unit,
        });
    }
    let pictures = families.iter().filter_map(|family| family.draw(mesh));
    let drawn = Drawn {
        pictures: pictures.collect(),
        notes: Vec::new(),
    };
    match drawn.pictures.is_empty() {
        false => Ok(drawn),
        true => Err(PlotError::Unfit {
            what: What::Mesh,
            reason:
                "the table has neither `stiffness`, `centre` nor `transmission_error` at every node"
                    .into(),
        }),
    }
}

/// The lines of a picture.
struct Family {
    picture: &'static str,
    title: &'static str,
    /// What is the same for all.
    held: String,
    /// Places on the axes of the table, and the value that tells them apart.
    members: Vec<([usize; 2], String)>,
    /// Unit of that value.
    unit: String,
}

impl Family {
    /// None where the table has none of the quantities.
    fn draw(&self, mesh: &MeshCurves) -> Option<Picture> {
        let title = format!("{}: {}", mesh.name, self.title);
        let mut canvas = Canvas::titled(&title, &self.held);
        let panels: Vec<_> = PANELS
            .iter()
            .map(|(array, name, least)| (*array, *name, *least, self.lines(mesh, array)))
            .filter(|(.., lines)| !lines.is_empty())
            .collect();
        let mut top = TOP;
        for (place, (array, name, least, lines)) in panels.iter().enumerate() {
            let values = lines.iter().flat_map(|line| &line.curve);
            let bounds = widened(range(values.map(|[_, value]| *value)), *least);
            let panel = Panel {
                left: LEFT,
                right: RIGHT,
                top,
                bottom: top + HEIGHT,
                across: Axis::linear("mesh phase", "1", [0.0, 1.0]),
                up: Axis::linear(name, mesh.unit(array), padded(bounds, 0.07)),
            };
            panel.frame(&mut canvas, place + 1 == panels.len());
            labels::draw(&mut canvas, &panel, lines, &self.unit);
            top += HEIGHT + GAP;
        }
        canvas.height = top - GAP + 64.0;
        let name = format!("{}-{}", mesh.name, self.picture);
        (!panels.is_empty()).then(|| Picture::new(name, canvas))
    }

    fn lines(&self, mesh: &MeshCurves, array: &str) -> Vec<Named> {
        let last = (self.members.len() - 1).max(1) as f64;
        let line = |(place, (at, name)): (usize, &([usize; 2], String))| {
            Some(Named {
                curve: mesh.curve(array, *at, [0, 1])?,
                name: name.clone(),
                colour: viridis(BRIGHTEST * place as f64 / last),
            })
        };
        self.members.iter().enumerate().filter_map(line).collect()
    }
}

/// A range at least so wide, about the same middle.
fn widened([low, high]: [f64; 2], least: f64) -> [f64; 2] {
    match high - low < least {
        true => [0.5 * (low + high - least), 0.5 * (low + high + least)],
        false => [low, high],
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
