//! The bifurcation diagram: Poincaré samples over one axis, and λ in a panel at the bottom. Sweeps in two
//! directions have a panel each, with the kind of motion as a strip below it.

use std::collections::{BTreeMap, BTreeSet};

use super::axis::{Axis, padded, range};
use super::canvas::{Canvas, Colour, INK};
use super::error::PlotError;
use super::evidence::Evidence;
use super::hatch::hatch;
use super::lambda_curve;
use super::motion::{Motion, cell_sample, counts, key, marker_sample};
use super::over_axis::{MARGIN, RIGHT, Sweep, across, sweeps};
use super::panel::{LEFT, Panel, TOP};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::point_style::PointStyle;
use super::ramp::ink_on;
use super::results::Results;
use super::section::{Quantity, Section};
use crate::report::PointSummary;
use crate::store::TableKind;

/// Height of the strip that shows the kind of motion \[px\].
const STRIP_HEIGHT: f64 = 9.0;

/// Colour of lines at changes of motion.
const CHANGE: Colour = Colour(0x8c, 0x8c, 0x8c);

/// Poincaré samples of all points.
struct Samples {
    /// By `point_id`.
    values: BTreeMap<u64, Vec<f64>>,
    unit: String,
    /// Name of the vertical axis.
    label: String,
    /// Short name of the vertical axis.
    symbol: String,
}

impl Samples {
    fn read(results: &Results) -> Result<Self, PlotError> {
        let table = results.needed(TableKind::Poincare, PictureKind::Bifurcation)?;
        let section = Section::of(&table)?;
        let Quantity {
            column,
            name,
            symbol,
        } = section.plane[1];
        let mut values: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
        for (id, value) in table.u64("point_id")?.into_iter().zip(table.f64(column)?) {
            if let (Some(id), Some(value)) = (id, value) {
                values.entry(id).or_default().push(value);
            }
        }
        if values.is_empty() {
            return Err(PictureKind::Bifurcation.unfit("poincare.parquet has no samples"));
        }
        Ok(Self {
            values,
            unit: table.units()?.remove(column).unwrap_or_default(),
            label: format!("{name} {}", section.words),
            symbol: format!("{symbol} {}", section.words),
        })
    }

    fn of<'s>(&'s self, point: &PointSummary) -> impl Iterator<Item = f64> + use<'s> {
        let values = self.values.get(&point.point_id);
        values.into_iter().flatten().copied()
    }
}

/// Samples over one axis, and λ below.
pub(super) fn draw(results: &Results, along: usize) -> Result<Drawn, PlotError> {
    let samples = Samples::read(results)?;
    let name = &results.summary.axes[along].name;
    let slices = results.slices_of_both(&[along]);
    let drawn = results.by_slice(PictureKind::Bifurcation, slices, |slice| {
        let title = format!("bifurcation diagram over {name}");
        let with_lambda = slice.points.iter().any(|point| point.lambda.is_some());
        let errors = Evidence::of(slice.points.iter().copied()).words();
        let mut canvas = results.canvas(&title, &[&slice.words, &errors]);
        let sweeps = sweeps(results, &slice.points);
        let all = slice.points.iter().flat_map(|point| samples.of(point));
        let up = padded(range(all), 0.05);
        let (both, height) = match (sweeps.len() > 1, with_lambda) {
            (true, true) => (true, 206.0),
            (true, false) => (true, 216.0),
            (false, true) => (false, 278.0),
            (false, false) => (false, 454.0),
        };
        let mut top = TOP;
        for (row, sweep) in sweeps.iter().enumerate() {
            let label = if both {
                format!("{}: {}", sweep.direction, samples.symbol)
            } else {
                samples.label.clone()
            };
            let named = !with_lambda && row + 1 == sweeps.len();
            let panel = Panel::new(
                [LEFT, RIGHT],
                [top, top + height],
                across(results, along),
                Axis::linear(&label, &samples.unit, up),
            );
            panel.frame(&mut canvas, named);
            strobe_panel(&mut canvas, &panel, results, along, sweep, &samples);
            if both {
                strip(&mut canvas, &panel, along, sweep);
            }
            top = panel.bottom + 22.0;
        }
        if with_lambda {
            let area = if both { [top, top + 176.0] } else { [370.0, 526.0] };
            lambda_curve::panel(&mut canvas, area, results, along, &slice.points);
            top = area[1];
        }
        if both {
            canvas.height = top + 74.0;
        }
        let class_counts = counts(slice.points.iter().copied());
        // With one panel of samples, the key of λ begins higher than with two, and leaves this key less room.
        let room = if with_lambda && !both { 358.0 } else { 446.0 };
        let used = key(
            &mut canvas,
            [MARGIN, TOP],
            room - 40.0,
            &class_counts,
            |canvas, at, motion| {
                if with_lambda && !both {
                    marker_sample(canvas, at, motion)
                } else {
                    let hatched = motion.is_hatched();
                    let plain = PointStyle::plain(motion.colour(), "");
                    cell_sample(canvas, at, &PointStyle { hatched, ..plain })
                }
            },
        );
        if !results.summary.transitions.is_empty() {
            let y = TOP + used + 10.0;
            canvas.dashes([MARGIN + 7.0, y], [MARGIN + 7.0, y + 26.0], CHANGE, 1.2);
            canvas.label([MARGIN + 21.0, y + 17.0], "change of motion", INK);
        }
        canvas
    });
    Ok(drawn)
}

fn strobe_panel(
    canvas: &mut Canvas,
    panel: &Panel,
    results: &Results,
    along: usize,
    sweep: &Sweep<'_>,
    samples: &Samples,
) {
    for change in &results.summary.transitions {
        if sweep.points.iter().any(|p| p.point_id == change.point_id) {
            let [lower, upper] = change.bracket;
            let x = panel.x(0.5 * (lower + upper));
            canvas.dashes([x, panel.top], [x, panel.bottom], CHANGE, 0.8);
        }
    }
    let count = sweep.points.len() as f64;
    let radius = (0.14 * (RIGHT - LEFT) / count.max(1.0)).clamp(0.8, 2.0);
    // Samples on the same half pixel are drawn once. Otherwise a periodic motion would have hundreds of equal
    // dots.
    let mut taken = BTreeSet::new();
    for point in &sweep.points {
        for value in samples.of(point) {
            let place = panel.at(point.axis_values[along], value);
            let cell = place.map(|coordinate| (2.0 * coordinate).round() as i64);
            if taken.insert(cell) {
                canvas.disc(place, radius, sweep.colour);
            }
        }
    }
    if taken.is_empty() {
        panel.note(canvas, "no samples in this slice");
    }
}

/// Draws the kind of motion of every point as a strip below a panel. The colour of a point reaches halfway to
/// its neighbours.
fn strip(canvas: &mut Canvas, panel: &Panel, along: usize, sweep: &Sweep<'_>) {
    let mut points: Vec<(f64, Motion)> = (sweep.points.iter())
        .map(|point| (panel.x(point.axis_values[along]), Motion::of(point)))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [top, bottom] = [panel.bottom + 1.0, panel.bottom + STRIP_HEIGHT];
    for (index, &(x, motion)) in points.iter().enumerate() {
        let neighbour = |other: Option<usize>| {
            let other = other.and_then(|other| points.get(other));
            other.map(|(other, _)| 0.5 * (x + other))
        };
        let left = neighbour(index.checked_sub(1)).unwrap_or(panel.left);
        let right = neighbour(Some(index + 1)).unwrap_or(panel.right);
        canvas.rectangle([left, top], [right, bottom], motion.colour());
        if motion.is_hatched() {
            hatch(
                canvas,
                [left, top],
                [right, bottom],
                ink_on(motion.colour()),
            );
        }
    }
}
