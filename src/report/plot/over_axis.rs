//! Pictures over one axis: the bifurcation diagram of the strobed deflection, and the
//! largest Lyapunov exponent with its standard error.

use std::collections::{BTreeMap, BTreeSet};

use super::axis::{Axis, padded, range};
use super::canvas::{Anchor, BLUE, Canvas, Colour, INK, SOFT};
use super::error::PlotError;
use super::motion::{Motion, counts, key};
use super::panel::{Panel, TICK_SIZE};
use super::results::{Results, Slice};
use super::{Drawn, Picture, What};
use crate::report::PointSummary;
use crate::store::TableKind;

const LEFT: f64 = 92.0;
const RIGHT: f64 = 775.0;
const MARGIN: f64 = RIGHT + 18.0;
/// Half the height of the ends of an error bar's whiskers \[px\].
const WHISKER: f64 = 3.0;
const WHITE: Colour = Colour(255, 255, 255);

pub(super) fn across(results: &Results, along: usize) -> Axis {
    let axis = &results.summary.axes[along];
    Axis::for_grid(&axis.name, &axis.unit, &axis.values)
}

/// λ with its standard error over one axis.
pub(super) fn draw_lambda(results: &Results, along: usize) -> Drawn {
    let name = &results.summary.axes[along].name;
    let (slices, all) = results.slices(&[along]);
    let mut drawn = Drawn::of_slices(What::Lambda, slices.len(), all);
    for slice in slices {
        let title = format!("{}: largest Lyapunov exponent λ over {name}", results.job);
        let mut canvas = Canvas::titled(&title, &results.subtitle(&[&slice.words]));
        let area = [72.0, 526.0];
        lambda_panel(&mut canvas, area, results, along, &slice.points);
        let found = counts(slice.points.iter().copied());
        key(&mut canvas, [MARGIN, area[0] + 34.0], &found);
        drawn
            .pictures
            .push(Picture::new(format!("lambda{}", slice.suffix), canvas));
    }
    drawn
}

/// λ as dots in the colour of the motion, with error bars.
fn lambda_panel(
    canvas: &mut Canvas,
    [top, bottom]: [f64; 2],
    results: &Results,
    along: usize,
    points: &[&PointSummary],
) {
    let error = |point: &PointSummary| point.stderr.unwrap_or(0.0);
    let known: Vec<(&PointSummary, f64)> = points
        .iter()
        .filter_map(|point| Some((*point, point.lambda?)))
        .collect();
    let ends = known
        .iter()
        .flat_map(|(point, lambda)| [lambda - error(point), lambda + error(point)]);
    let up = Axis::linear(
        "λ",
        results.unit("lambda_max"),
        padded(range(ends.chain([0.0])), 0.07),
    );
    let panel = Panel {
        left: LEFT,
        right: RIGHT,
        top,
        bottom,
        across: across(results, along),
        up,
    };
    panel.frame(canvas, true);
    panel.level(canvas, 0.0, "λ = 0", SOFT);
    let at = [MARGIN, panel.top + 14.0];
    let note = "bars: ± standard error";
    canvas.text(at, note, TICK_SIZE, SOFT, Anchor::Start);
    if known.is_empty() {
        panel.note(canvas, "no exponents in these results");
    }
    let line: Vec<_> = known
        .iter()
        .map(|(point, lambda)| panel.at(point.axis_values[along], *lambda))
        .collect();
    canvas.line(&line, Colour(0xc4, 0xc4, 0xc4), 1.0);
    for (point, lambda) in known {
        let x = panel.x(point.axis_values[along]);
        let [low, high] = [lambda - error(point), lambda + error(point)].map(|v| panel.y(v));
        canvas.line(&[[x, low], [x, high]], INK, 1.2);
        if low - high > 2.0 * WHISKER {
            for y in [low, high] {
                canvas.line(&[[x - WHISKER, y], [x + WHISKER, y]], INK, 1.2);
            }
        }
        let centre = [x, panel.y(lambda)];
        canvas.disc(centre, 4.2, INK);
        canvas.disc(centre, 3.4, Motion::of(point).colour());
    }
    // Points without λ stand on the lower edge, so that none is lost.
    for point in points.iter().filter(|point| point.lambda.is_none()) {
        let centre = [panel.x(point.axis_values[along]), panel.bottom];
        canvas.disc(centre, 4.2, INK);
        canvas.disc(centre, 3.0, WHITE);
    }
}

/// Strobed deflections over one axis, and λ below.
pub(super) fn draw_bifurcation(results: &Results, along: usize) -> Result<Drawn, PlotError> {
    let unfit = |reason: &str| PlotError::Unfit {
        what: What::Bifurcation,
        reason: reason.into(),
    };
    let table = results.table(TableKind::Poincare)?.ok_or_else(|| {
        unfit("there is no poincare.parquet; ask for `poincare` in the manifest's [analyses]")
    })?;
    let unit = table.units()?.remove("deflection").unwrap_or_default();
    let mut strobes: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for (id, deflection) in table
        .u64("point_id")?
        .into_iter()
        .zip(table.f64("deflection")?)
    {
        if let (Some(id), Some(deflection)) = (id, deflection) {
            strobes.entry(id).or_default().push(deflection);
        }
    }
    if strobes.is_empty() {
        return Err(unfit("poincare.parquet holds no sample"));
    }
    let name = &results.summary.axes[along].name;
    let (slices, all) = results.slices(&[along]);
    let mut drawn = Drawn::of_slices(What::Bifurcation, slices.len(), all);
    for slice in slices {
        let title = format!("{}: bifurcation diagram over {name}", results.job);
        let mut canvas = Canvas::titled(&title, &results.subtitle(&[&slice.words]));
        let with_lambda = slice.points.iter().any(|point| point.lambda.is_some());
        let bottom = if with_lambda { 350.0 } else { 526.0 };
        strobe_panel(&mut canvas, bottom, results, along, &slice, &strobes, &unit);
        if with_lambda {
            lambda_panel(&mut canvas, [370.0, 526.0], results, along, &slice.points);
        }
        let found = counts(slice.points.iter().copied());
        key(&mut canvas, [MARGIN, 72.0], &found);
        drawn
            .pictures
            .push(Picture::new(format!("bifurcation{}", slice.suffix), canvas));
    }
    Ok(drawn)
}

fn strobe_panel(
    canvas: &mut Canvas,
    bottom: f64,
    results: &Results,
    along: usize,
    slice: &Slice<'_>,
    strobes: &BTreeMap<u64, Vec<f64>>,
    unit: &str,
) {
    let samples = |point: &&PointSummary| strobes.get(&point.point_id).into_iter().flatten();
    let all = slice.points.iter().flat_map(samples).copied();
    let panel = Panel {
        left: LEFT,
        right: RIGHT,
        top: 72.0,
        bottom,
        across: across(results, along),
        up: Axis::linear("deflection at mesh phase 0", unit, padded(range(all), 0.05)),
    };
    panel.frame(canvas, bottom > 400.0);
    let count = slice.points.len() as f64;
    let radius = (0.14 * (RIGHT - LEFT) / count.max(1.0)).clamp(0.8, 2.0);
    // Samples on the same half pixel are drawn once: a settled orbit is a dot or two.
    let mut taken = BTreeSet::new();
    for point in &slice.points {
        for deflection in samples(point) {
            let place = panel.at(point.axis_values[along], *deflection);
            let cell = place.map(|coordinate| (2.0 * coordinate).round() as i64);
            if taken.insert(cell) {
                canvas.disc(place, radius, BLUE);
            }
        }
    }
    if taken.is_empty() {
        panel.note(canvas, "no samples in this slice");
    }
}
