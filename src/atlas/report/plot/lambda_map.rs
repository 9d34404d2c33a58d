//! The largest Lyapunov exponent over two axes: chaotic points in colour, all others by kind of motion. Transient chaos
//! is hatched.

use super::axis::Axis;
use super::canvas::Colour;
use super::cells::{Cells, HEIGHT, MARGIN, notes};
use super::evidence::Evidence;
use super::motion::{Motion, cell_key, counts};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::point_style::PointStyle;
use super::ramp::{bar, viridis};
use super::results::Results;
use crate::report::PointSummary;

/// Colour of a cell without chaos: pale beside the ramp, except Failed and NotConverged.
fn colour_without_chaos(motion: Motion) -> Colour {
    match motion {
        Motion::Failed | Motion::NotConverged => motion.colour(),
        Motion::QuasiPeriodic => Colour(0xc6, 0xdf, 0xf3),
        _ => Colour(0xee, 0xee, 0xee),
    }
}

/// The largest exponent of all chaotic points: all slices have one scale, so that they can be compared.
pub(super) fn largest_of(results: &Results) -> f64 {
    let chaotic = (results.summary.all.iter()).filter(|point| Motion::of(point).is_chaos());
    chaotic.filter_map(|point| point.lambda).fold(0.0, f64::max)
}

/// The colour of a point: a ramp from 0 to `largest` for chaotic points, else by its kind of motion.
pub(super) fn shade(point: &PointSummary, largest: f64) -> Colour {
    match Motion::of(point) {
        motion if !motion.is_chaos() => colour_without_chaos(motion),
        _ if largest > 0.0 => viridis(point.lambda.unwrap_or(0.0) / largest),
        _ => viridis(0.0),
    }
}

/// The sample of a motion in the key, for motions outside the ramp and for hatching.
fn sample(motion: Motion) -> PointStyle {
    if motion.is_hatched() {
        PointStyle {
            hatched: true,
            ..PointStyle::plain(viridis(0.5), "")
        }
    } else {
        PointStyle::plain(colour_without_chaos(motion), &motion.mark())
    }
}

pub(super) fn draw(results: &Results, cells: &Cells<'_>) -> Drawn {
    let largest = largest_of(results);
    let unit = results.unit("lambda_max");
    results.by_slice(
        PictureKind::Lambda,
        results.slices(&cells.free()),
        |slice| {
            let title = format!("largest Lyapunov exponent λ over {}", cells.words());
            let errors = Evidence::of(slice.points.iter().copied()).words();
            let mut canvas = results.canvas(&title, &[&slice.words, &errors]);
            let cells_drawn = cells.draw(&mut canvas, slice, |point| {
                let motion = Motion::of(point);
                let text = if motion.is_chaos() {
                    format!("{:.2}", point.lambda.unwrap_or(0.0))
                } else {
                    motion.mark()
                };
                PointStyle {
                    hatched: motion.is_hatched(),
                    dotted: point.errors_verified == Some(false),
                    ..PointStyle::plain(shade(point, largest), &text)
                }
            });
            let mut others = counts(slice.points.iter().copied());
            let mut y = HEIGHT[0];
            let has_ramp = others.keys().any(|motion| motion.is_chaos());
            others.remove(&Motion::Chaotic);
            if has_ramp && largest > 0.0 {
                let name = "λ of chaotic points";
                let axis = Axis::linear(name, unit, [0.0, largest]);
                let bottom = HEIGHT[0] + 230.0;
                bar(&mut canvas, MARGIN, [HEIGHT[0], bottom], &axis);
                y = bottom + 26.0;
            }
            let bottom = HEIGHT[1] - 50.0;
            // The entry of hatching comes first, because a key with many kinds leaves out the last ones.
            let hatched = others
                .extract_if(.., |motion, _| motion.is_hatched())
                .collect();
            for kinds in [hatched, others] {
                y += cell_key(&mut canvas, [MARGIN, y], bottom, &kinds, sample);
            }
            notes(&mut canvas, y + 2.0, cells_drawn);
            canvas
        },
    )
}

/// The style of a kind of motion in a cell.
fn class_cell(motion: Motion) -> PointStyle {
    PointStyle {
        hatched: motion.is_hatched(),
        ..PointStyle::plain(motion.colour(), &motion.mark())
    }
}

/// Draws the kind of motion over two axes, one picture per slice.
pub(super) fn draw_classes(results: &Results, cells: &Cells<'_>) -> Drawn {
    results.by_slice(
        PictureKind::Classes,
        results.slices(&cells.free()),
        |slice| {
            let title = format!("class of motion over {}", cells.words());
            let mut canvas = results.canvas(&title, &[&slice.words]);
            let cells_drawn = cells.draw(&mut canvas, slice, |point| class_cell(Motion::of(point)));
            let class_counts = counts(slice.points.iter().copied());
            let [top, bottom] = [HEIGHT[0], HEIGHT[1] - 50.0];
            let used = cell_key(
                &mut canvas,
                [MARGIN, top],
                bottom,
                &class_counts,
                class_cell,
            );
            notes(&mut canvas, top + used + 2.0, cells_drawn);
            canvas
        },
    )
}
