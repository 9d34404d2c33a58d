//! The largest Lyapunov exponent with its standard error over one axis.

use super::axis::{Axis, padded, range};
use super::canvas::{Canvas, Colour, INK, Place, SOFT};
use super::evidence::Evidence;
use super::marker::{Marker, SAMPLE, entry};
use super::motion::{Motion, counts, key, marker_sample};
use super::over_axis::{MARGIN, RIGHT, Sweep, across, sweeps};
use super::panel::{LEFT, Panel};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::results::Results;
use crate::report::PointSummary;

/// Half the width of the whiskers at the ends of an error bar \[px\].
const WHISKER: f64 = 3.0;
const PALE: Colour = Colour(0xc4, 0xc4, 0xc4);

/// Draws λ with its standard error over one axis, one picture per slice.
pub(super) fn draw(results: &Results, along: usize) -> Drawn {
    let name = &results.summary.axes[along].name;
    results.by_slice(
        PictureKind::Lambda,
        results.slices_of_both(&[along]),
        |slice| {
            let title = format!("largest Lyapunov exponent λ over {name}");
            let joins = results.lines_words(&[along], &slice.points);
            let errors = Evidence::of(slice.points.iter().copied()).words();
            let parts = [&*slice.words, &joins, &errors];
            let mut canvas = results.canvas(&title, &parts);
            let area = [72.0, 526.0];
            let y = panel(&mut canvas, area, results, along, &slice.points);
            if sweeps(results, &slice.points).len() < 2 {
                let class_counts = counts(slice.points.iter().copied());
                key(
                    &mut canvas,
                    [MARGIN, y],
                    area[1],
                    &class_counts,
                    marker_sample,
                );
            }
            canvas
        },
    )
}

fn error(point: &PointSummary) -> f64 {
    point.stderr.unwrap_or(0.0)
}

/// Draws a panel of λ with error bars, and its key. Points have the symbol of their motion. If there are sweeps in
/// two directions, points have dots in the colour of the direction, or of a marked motion ([`Motion::is_marked`]).
/// Returns the lower end of the key \[px\].
pub(super) fn panel(
    canvas: &mut Canvas,
    [top, bottom]: [f64; 2],
    results: &Results,
    along: usize,
    points: &[&PointSummary],
) -> f64 {
    let known = points
        .iter()
        .filter_map(|point| Some((error(point), point.lambda?)));
    let ends = known.flat_map(|(error, lambda)| [lambda - error, lambda + error]);
    let ends: Vec<f64> = ends.collect();
    let panel = Panel::new(
        [LEFT, RIGHT],
        [top, bottom],
        across(results, along),
        Axis::linear(
            "λ",
            results.unit("lambda_max"),
            padded(range(ends.iter().copied().chain([0.0])), 0.07),
        ),
    );
    panel.frame(canvas, true);
    let zero = panel.y(0.0);
    canvas.dashes([panel.left, zero], [panel.right, zero], SOFT, 1.2);
    if ends.is_empty() {
        panel.note(canvas, "no exponents in these results");
    }
    let sweeps = sweeps(results, points);
    for sweep in &sweeps {
        let sweep_colour = (sweeps.len() > 1).then_some(sweep.colour);
        for line in results.lines(&[along], &sweep.points) {
            let points = line.into_iter().map(|place| sweep.points[place]);
            let known =
                points.filter_map(|point| Some(panel.at(point.axis_values[along], point.lambda?)));
            let line: Vec<Place> = known.collect();
            canvas.line(&line, sweep_colour.unwrap_or(PALE), 1.0);
        }
        symbols(canvas, &panel, along, sweep, sweep_colour);
    }
    legend(canvas, &sweeps, points, top + 12.0)
}

/// Draws the names of curves and symbols, from the height `y` down; returns the lower end \[px\].
fn legend(canvas: &mut Canvas, sweeps: &[Sweep<'_>], points: &[&PointSummary], mut y: f64) -> f64 {
    canvas.dashes([MARGIN, y], [MARGIN + SAMPLE, y], SOFT, 1.2);
    y += entry(canvas, [MARGIN, y], "λ = 0");
    if points.iter().any(|point| error(point) > 0.0) {
        bar(canvas, MARGIN + 0.5 * SAMPLE, [y - 7.0, y + 7.0], INK, true);
        y += entry(canvas, [MARGIN, y], "± standard error");
    }
    if sweeps.len() > 1 {
        for sweep in sweeps {
            canvas.disc([MARGIN + 0.5 * SAMPLE, y], 3.4, sweep.colour);
            y += entry(canvas, [MARGIN, y], &format!("sweep {}", sweep.direction));
        }
    }
    // Without sweeps in two directions, the key of symbols names the marked motions.
    let mut marked = counts(points.iter().copied());
    marked.retain(|motion, _| motion.is_marked() && sweeps.len() > 1);
    for (motion, count) in marked {
        let at = [MARGIN + 0.5 * SAMPLE, y];
        Marker::Disc.sized(canvas, at, motion.colour(), 0.75);
        y += entry(canvas, [MARGIN, y], &format!("{} ({count})", motion.name()));
    }
    let without = points.iter().filter(|point| point.lambda.is_none()).count();
    if without > 0 {
        y += entry(
            canvas,
            [MARGIN, y],
            &format!("at the edge: no λ ({without})"),
        );
    }
    y
}

/// Draws an error bar between two heights, with or without whiskers at its ends.
fn bar(canvas: &mut Canvas, x: f64, ends: [f64; 2], colour: Colour, whiskers: bool) {
    canvas.line(&ends.map(|y| [x, y]), colour, 1.2);
    for y in ends.into_iter().filter(|_| whiskers) {
        canvas.line(&[[x - WHISKER, y], [x + WHISKER, y]], colour, 1.2);
    }
}

/// Draws the points of one sweep. `sweep_colour` is its colour if there are several sweeps.
fn symbols(
    canvas: &mut Canvas,
    panel: &Panel,
    along: usize,
    sweep: &Sweep<'_>,
    sweep_colour: Option<Colour>,
) {
    let known = || {
        let points = sweep.points.iter();
        points.filter_map(|point| Some((*point, point.lambda?)))
    };
    // Symbols are smaller in a dense sweep, where they would hide each other and the line.
    let room = 0.4 * (RIGHT - LEFT) / sweep.points.len().max(1) as f64;
    let symbol = |canvas: &mut Canvas, at: Place, point: &PointSummary| match sweep_colour {
        Some(_) if Motion::of(point).is_marked() => {
            let factor = (room / 4.6).clamp(0.5, 0.75);
            Marker::Disc.sized(canvas, at, Motion::of(point).colour(), factor);
        }
        Some(colour) => canvas.disc(at, room.clamp(1.4, 3.4), colour),
        None => {
            let (motion, factor) = (Motion::of(point), (room / 4.6).clamp(0.45, 1.0));
            motion.marker().sized(canvas, at, motion.colour(), factor);
        }
    };
    for (point, lambda) in known() {
        let x = panel.x(point.axis_values[along]);
        let [low, high] =
            [lambda - error(point), lambda + error(point)].map(|value| panel.y(value));
        if error(point) > 0.0 {
            let whiskers = low - high > 2.0 * WHISKER && sweep_colour.is_none() && room > WHISKER;
            bar(
                canvas,
                x,
                [high, low],
                sweep_colour.unwrap_or(INK),
                whiskers,
            );
        }
        symbol(canvas, [x, panel.y(lambda)], point);
    }
    // Points without λ are on the lower edge, so that every point is visible.
    for point in sweep.points.iter().filter(|point| point.lambda.is_none()) {
        let x = panel.x(point.axis_values[along]);
        symbol(canvas, [x, panel.bottom], point);
    }
}
