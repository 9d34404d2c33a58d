//! The largest Lyapunov exponent over two axes: chaotic points in colour, all others by
//! what they are.

use super::axis::Axis;
use super::canvas::{Canvas, Colour};
use super::cells::{Cells, HEIGHT, MARGIN, notes};
use super::motion::{Motion, cell_sample, counts, key};
use super::picture::{Drawn, Picture};
use super::ramp::{bar, viridis};
use super::results::Results;
use super::what::What;
use crate::report::PointSummary;

/// Cells of points that are not chaotic: pale, so that the ramp stands out.
fn calm(motion: Motion) -> Colour {
    match motion {
        Motion::Failed | Motion::NotConverged => motion.colour(),
        Motion::QuasiPeriodic => Colour(0xc6, 0xdf, 0xf3),
        _ => Colour(0xee, 0xee, 0xee),
    }
}

/// The largest exponent of a chaotic point of the results: one scale for all slices, so that they
/// compare.
pub(super) fn largest_of(results: &Results) -> f64 {
    let chaotic = (results.summary.all.iter()).filter(|point| Motion::of(point) == Motion::Chaotic);
    chaotic.filter_map(|point| point.lambda).fold(0.0, f64::max)
}

/// The colour of a point.
pub(super) fn shade(point: &PointSummary, largest: f64) -> Colour {
    match Motion::of(point) {
        Motion::Chaotic if largest > 0.0 => viridis(point.lambda.unwrap_or(0.0) / largest),
        Motion::Chaotic => viridis(0.0),
        motion => calm(motion),
    }
}

pub(super) fn draw(results: &Results, cells: &Cells<'_>) -> Drawn {
    let largest = largest_of(results);
    let unit = results.unit("lambda_max");
    let (slices, all) = results.slices(&cells.free());
    let mut drawn = Drawn::of_slices(What::Lambda, slices.len(), all);
    for slice in slices {
        let title = format!(
            "{}: largest Lyapunov exponent λ over {}",
            results.job,
            cells.words()
        );
        let mut canvas = Canvas::titled(&title, &results.subtitle(&[&slice.words]));
        let cells_drawn = cells.draw(&mut canvas, &slice, |point| {
            let text = match Motion::of(point) {
                Motion::Chaotic => format!("{:.2}", point.lambda.unwrap_or(0.0)),
                motion => motion.mark(),
            };
            (shade(point, largest), text)
        });
        let mut others = counts(slice.points.iter().copied());
        let mut y = HEIGHT[0];
        if others.remove(&Motion::Chaotic).is_some() && largest > 0.0 {
            let name = "λ of chaotic points";
            let axis = Axis::linear(name, unit, [0.0, largest]);
            let bottom = HEIGHT[0] + 230.0;
            bar(&mut canvas, MARGIN, [HEIGHT[0], bottom], &axis);
            y = bottom + 26.0;
        }
        let bottom = HEIGHT[1] - 50.0;
        let used = key(
            &mut canvas,
            [MARGIN, y],
            bottom,
            &others,
            |canvas, at, motion| {
                cell_sample(canvas, at, calm(motion), &motion.mark());
            },
        );
        notes(&mut canvas, y + used + 2.0, cells_drawn);
        drawn
            .pictures
            .push(Picture::new(format!("lambda{}", slice.suffix), canvas));
    }
    drawn
}

/// The kind of motion over two axes.
pub(super) fn draw_classes(results: &Results, cells: &Cells<'_>) -> Drawn {
    let (slices, all) = results.slices(&cells.free());
    let mut drawn = Drawn::of_slices(What::Classes, slices.len(), all);
    for slice in slices {
        let title = format!("{}: kind of motion over {}", results.job, cells.words());
        let mut canvas = Canvas::titled(&title, &results.subtitle(&[&slice.words]));
        let cells_drawn = cells.draw(&mut canvas, &slice, |point| {
            let motion = Motion::of(point);
            (motion.colour(), motion.mark())
        });
        let found = counts(slice.points.iter().copied());
        let [top, bottom] = [HEIGHT[0], HEIGHT[1] - 50.0];
        let used = key(
            &mut canvas,
            [MARGIN, top],
            bottom,
            &found,
            |canvas, at, motion| {
                cell_sample(canvas, at, motion.colour(), &motion.mark());
            },
        );
        notes(&mut canvas, top + used + 2.0, cells_drawn);
        drawn
            .pictures
            .push(Picture::new(format!("classes{}", slice.suffix), canvas));
    }
    drawn
}
