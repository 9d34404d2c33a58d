//! The largest Lyapunov exponent with its standard error over one axis.

use super::axis::{Axis, padded, range};
use super::canvas::{Anchor, Canvas, Colour, INK, SOFT};
use super::motion::{Motion, counts, key};
use super::over_axis::{LEFT, MARGIN, RIGHT, Sweep, across, sweeps};
use super::panel::{Panel, TICK_SIZE};
use super::picture::{Drawn, Picture};
use super::results::Results;
use super::what::What;
use crate::report::PointSummary;

/// Half the height of the ends of an error bar's whiskers \[px\].
const WHISKER: f64 = 3.0;
const WHITE: Colour = Colour(255, 255, 255);
const PALE: Colour = Colour(0xc4, 0xc4, 0xc4);

/// λ with its standard error over one axis.
pub(super) fn draw(results: &Results, along: usize) -> Drawn {
    let name = &results.summary.axes[along].name;
    let (slices, all) = results.slices_of_both(&[along]);
    let mut drawn = Drawn::of_slices(What::Lambda, slices.len(), all);
    for slice in slices {
        let title = format!("{}: largest Lyapunov exponent λ over {name}", results.job);
        let mut canvas = Canvas::titled(&title, &results.subtitle(&[&slice.words]));
        let area = [72.0, 526.0];
        panel(&mut canvas, area, results, along, &slice.points);
        if sweeps(results, &slice.points).len() < 2 {
            let found = counts(slice.points.iter().copied());
            key(&mut canvas, [MARGIN, area[0] + 34.0], &found);
        }
        drawn
            .pictures
            .push(Picture::new(format!("lambda{}", slice.suffix), canvas));
    }
    drawn
}

fn error(point: &PointSummary) -> f64 {
    point.stderr.unwrap_or(0.0)
}

/// λ as dots with error bars: in the colour of the motion or, where there are sweeps in both
/// directions, of the direction.
pub(super) fn panel(
    canvas: &mut Canvas,
    [top, bottom]: [f64; 2],
    results: &Results,
    along: usize,
    points: &[&PointSummary],
) {
    let known = points
        .iter()
        .filter_map(|point| Some((error(point), point.lambda?)));
    let ends = known.flat_map(|(error, lambda)| [lambda - error, lambda + error]);
    let ends: Vec<f64> = ends.collect();
    let panel = Panel {
        left: LEFT,
        right: RIGHT,
        top,
        bottom,
        across: across(results, along),
        up: Axis::linear(
            "λ",
            results.unit("lambda_max"),
            padded(range(ends.iter().copied().chain([0.0])), 0.07),
        ),
    };
    panel.frame(canvas, true);
    panel.level(canvas, 0.0, "λ = 0", SOFT);
    let at = [MARGIN, panel.top + 14.0];
    let note = "bars: ± standard error";
    canvas.text(at, note, TICK_SIZE, SOFT, Anchor::Start);
    if ends.is_empty() {
        panel.note(canvas, "no exponents in these results");
    }
    let sweeps = sweeps(results, points);
    for (row, sweep) in sweeps.iter().enumerate() {
        let own = (sweeps.len() > 1).then_some(sweep.colour);
        curve(canvas, &panel, along, sweep, own);
        if let Some(colour) = own {
            let [x, y] = [MARGIN + 5.0, panel.top + 34.0 + 20.0 * row as f64];
            canvas.disc([x, y - 4.0], 3.4, colour);
            let text = format!("sweep {}", sweep.direction);
            canvas.text([x + 12.0, y], &text, TICK_SIZE, INK, Anchor::Start);
        }
    }
}

/// The points of one sweep; `own` colour where it is not the only one.
fn curve(canvas: &mut Canvas, panel: &Panel, along: usize, sweep: &Sweep<'_>, own: Option<Colour>) {
    let known = || {
        let points = sweep.points.iter();
        points.filter_map(|point| Some((*point, point.lambda?)))
    };
    let line: Vec<_> = known()
        .map(|(point, lambda)| panel.at(point.axis_values[along], lambda))
        .collect();
    canvas.line(&line, own.unwrap_or(PALE), 1.0);
    // Dots of a dense sweep would hide its line.
    let radius = (0.4 * (RIGHT - LEFT) / sweep.points.len().max(1) as f64).clamp(1.4, 3.4);
    for (point, lambda) in known() {
        let x = panel.x(point.axis_values[along]);
        let [low, high] =
            [lambda - error(point), lambda + error(point)].map(|value| panel.y(value));
        canvas.line(&[[x, low], [x, high]], own.unwrap_or(INK), 1.2);
        if low - high > 2.0 * WHISKER && own.is_none() {
            for y in [low, high] {
                canvas.line(&[[x - WHISKER, y], [x + WHISKER, y]], INK, 1.2);
            }
        }
        let centre = [x, panel.y(lambda)];
        match own {
            Some(colour) => canvas.disc(centre, radius, colour),
            None => {
                canvas.disc(centre, 4.2, INK);
                canvas.disc(centre, 3.4, Motion::of(point).colour());
            }
        }
    }
    // Points without λ stand on the lower edge, so that none is lost.
    for point in sweep.points.iter().filter(|point| point.lambda.is_none()) {
        let centre = [panel.x(point.axis_values[along]), panel.bottom];
        canvas.disc(centre, 4.2, own.unwrap_or(INK));
        canvas.disc(centre, 3.0, WHITE);
    }
}
