//! Bifurcation curves in the plane of the two followed axes. Behind them is the map of the largest exponent,
//! if the folder has points with several values on both axes.

use std::collections::BTreeMap;

use super::axis::{Axis, padded, range};
use super::axis_units::AxisUnits;
use super::branches::{suffix, words};
use super::canvas::{Canvas, Colour, INK, Place, WHITE};
use super::clip::crossing;
use super::error::PlotError;
use super::hatch::hatch;
use super::lambda_map::{largest_of, shade};
use super::marker::{OTHERS, SAMPLE, colour, entry, name};
use super::motion::Motion;
use super::panel::{LEFT, Panel};
use super::picture::{Drawn, Picture};
use super::picture_kind::PictureKind;
use super::ramp::{bar, ink_on};
use super::results::{MOST_SLICES, Results};
use crate::report::PointSummary;
use crate::report::followed::{Curve, FixedValues, Followed};
use crate::report::numbers::plural;
use crate::report::refined::Plane;

const RIGHT: f64 = 735.0;
const MARGIN: f64 = RIGHT + 20.0;

/// The kind of the curve for the onset of rattle, which has a closed form.
const ONSET: &str = "onset";

/// Width of a curve, of the onset of rattle, and of the white edge that curves get on a map \[px\].
const WIDTH: f64 = 1.8;
const ONSET_WIDTH: f64 = 3.6;
const EDGE: f64 = 2.4;

/// Draws one picture per plane.
pub(super) fn draw(
    followed: &Followed,
    shown: &AxisUnits,
    results: Option<&Results>,
) -> Result<Drawn, PlotError> {
    let second = followed.second.ok_or_else(|| {
        PictureKind::Curves.unfit(
            "there is no curves.parquet; name a `second` axis in [continuation] of the manifest",
        )
    })?;
    let planes = followed.planes(second);
    if planes.is_empty() {
        return Err(PictureKind::Curves.unfit("curves.parquet has no curve"));
    }
    let count = planes.len();
    let mut drawn = Drawn::sliced(PictureKind::Curves.name(), count.min(MOST_SLICES), count);
    for plane in planes.iter().take(MOST_SLICES) {
        let canvas = picture((followed, shown), [followed.over, second], plane, results);
        let name = format!("curves{}", suffix(followed, plane));
        drawn.pictures.push(Picture::new(name, canvas));
    }
    Ok(drawn)
}

fn picture(
    (followed, units): (&Followed, &AxisUnits),
    axes: [usize; 2],
    plane: &FixedValues,
    results: Option<&Results>,
) -> Canvas {
    let holds = |curve: &&Curve| curve.points.iter().all(|(at, _)| plane.holds(at));
    let curves: Vec<&Curve> = followed.curves.values().filter(holds).collect();
    let map = results.and_then(|results| Map::of(followed, axes, plane, results));
    let spans = axes.map(|axis| {
        let inner = curves.iter().filter(|curve| curve.kind != ONSET);
        let points = inner.flat_map(|curve| &curve.points);
        let met = followed.axes[axis].values.iter().copied();
        range(points.map(|(at, _)| at[axis]).chain(met))
    });
    let frame = [0, 1].map(|i| {
        let cells = map.as_ref().map(|map| map.edges(i));
        range(spans[i].into_iter().chain(cells.into_iter().flatten()))
    });
    let room = if map.is_some() { 0.0 } else { 0.02 };
    let frame = frame.map(|span| padded(span, room));
    let [across, up] = [0, 1].map(|i| {
        let axis = &followed.axes[axes[i]];
        units.axis(axis, |name, unit| Axis::linear(name, unit, frame[i]))
    });
    let panel = Panel::new([LEFT, RIGHT], [72.0, 526.0], across, up);
    let job = followed.job.as_deref().unwrap_or("job unknown");
    let [over, second] = axes.map(|axis| &followed.axes[axis].name);
    let title = format!("{job}: bifurcations over {over} and {second}");
    let mut parts = vec![words(followed, units, plane), plural(curves.len(), "curve")];
    if let Some(map) = &map {
        parts.push(format!("behind: {}", plural(map.points.len(), "point")));
        parts.extend(map.direction.map(|direction| format!("sweep {direction}")));
    }
    parts.retain(|words| !words.is_empty());
    let mut canvas = Canvas::titled(&title, &parts.join("  ·  "));
    panel.frame(&mut canvas, true);
    if let Some(map) = &map {
        map.draw(&mut canvas, &panel);
        panel.frame(&mut canvas, true);
    }
    let place = |at: Place| panel.at(at[0], at[1]);
    // The onset comes last, so that no other curve covers this boundary of the region of rattle.
    let mut order = curves.clone();
    order.sort_by_key(|curve| curve.kind == ONSET);
    let mut kinds: BTreeMap<&str, CurveCounts> = BTreeMap::new();
    for curve in order {
        let shown = kinds.entry(&curve.kind).or_default();
        shown.curves += 1;
        let width = width(&curve.kind);
        for (dashed, path) in strokes(followed, axes, curve) {
            for part in clipped(&path, frame) {
                let part: Vec<Place> = part.into_iter().map(place).collect();
                shown.visible = true;
                if map.is_some() {
                    canvas.line(&part, WHITE, width + EDGE);
                }
                if dashed {
                    canvas.dashed_line(&part, colour(&curve.kind), width)
                } else {
                    canvas.line(&part, colour(&curve.kind), width)
                }
            }
        }
    }
    let mut notes: BTreeMap<&str, Vec<Place>> = BTreeMap::new();
    for (at, note) in curves.iter().flat_map(|curve| curve.codimension_two()) {
        let at = place(axes.map(|axis| at[axis]));
        notes.entry(note).or_default().push(at);
    }
    for (index, places) in notes.values().enumerate() {
        (places.iter()).for_each(|at| symbol(&mut canvas, *at, index));
    }
    key(&mut canvas, &kinds, &notes, map.as_ref());
    canvas
}

/// Explains curves and symbols beside the picture.
fn key(
    canvas: &mut Canvas,
    kinds: &BTreeMap<&str, CurveCounts>,
    notes: &BTreeMap<&str, Vec<Place>>,
    map: Option<&Map<'_>>,
) {
    let mut y = 84.0;
    let mut line = |canvas: &mut Canvas, text: &str| {
        let at = [MARGIN, y];
        y += entry(canvas, at, text);
        at
    };
    for (kind, shown) in kinds {
        let text = match (*kind, shown.visible) {
            (ONSET, true) => name(kind),
            (ONSET, false) => format!("{} (beyond)", name(kind)),
            (kind, _) => format!("{} ({})", name(kind), shown.curves),
        };
        let [x, y] = line(canvas, &text);
        canvas.line(&[[x, y], [x + SAMPLE, y]], colour(kind), width(kind));
    }
    for (index, (note, places)) in notes.iter().enumerate() {
        let [x, y] = line(canvas, &format!("{note} ({})", places.len()));
        symbol(canvas, [x + 11.0, y], index);
    }
    if let Some(map) = map {
        map.key(canvas, y + 8.0);
    }
}

/// Counts of a kind of curve.
#[derive(Default)]
struct CurveCounts {
    curves: usize,
    /// Whether any part of these curves lies in the frame.
    visible: bool,
}

fn width(kind: &str) -> f64 {
    if kind == ONSET { ONSET_WIDTH } else { WIDTH }
}

/// The lines of a curve, and whether they are dashed. An onset is computed at evenly spaced values of the
/// axis that is not the load. Its line is interrupted where these values have gaps, because no onset exists
/// there. It is dashed where contact is unstable.
fn strokes(followed: &Followed, axes: [usize; 2], curve: &Curve) -> Vec<(bool, Vec<Place>)> {
    let place = |at: &[f64]| -> Place { axes.map(|axis| at[axis]) };
    if curve.kind != ONSET {
        let path = curve.points.iter().map(|(at, _)| place(at));
        return vec![(false, path.collect())];
    }
    let along = usize::from(matches!(
        followed.axes[axes[0]].name.as_str(),
        "load" | "torque"
    ));
    let step = |pair: &[(Vec<f64>, Option<String>)]| {
        (place(&pair[1].0)[along] - place(&pair[0].0)[along]).abs()
    };
    let smallest = curve
        .points
        .windows(2)
        .map(step)
        .fold(f64::INFINITY, f64::min);
    let even = curve
        .points
        .windows(2)
        .filter(|pair| step(pair) < 1.5 * smallest);
    let mut parts: Vec<(bool, Vec<Place>)> = Vec::new();
    for pair in even {
        let [from, to] = [0, 1].map(|i| place(&pair[i].0));
        let dashed = pair.iter().any(|(_, note)| note.is_some());
        match parts.last_mut() {
            Some((last, part)) if *last == dashed && part.last() == Some(&from) => part.push(to),
            _ => parts.push((dashed, vec![from, to])),
        }
    }
    parts
}

/// The parts of a path that lie within a frame.
fn clipped(path: &[Place], [across, up]: [[f64; 2]; 2]) -> Vec<Vec<Place>> {
    let mut parts: Vec<Vec<Place>> = Vec::new();
    for pair in path.windows(2) {
        let Some([from, to]) = crossing(pair[0], pair[1], across, up) else {
            continue;
        };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

/// The symbol of a point of codimension two.
fn symbol(canvas: &mut Canvas, at: Place, index: usize) {
    let fill = if index < OTHERS.len() { WHITE } else { INK };
    OTHERS[index % OTHERS.len()].filled(canvas, at, fill);
}

/// The map of the largest exponent behind the curves.
struct Map<'a> {
    points: Vec<&'a PointSummary>,
    /// Indices, in the grid of the points, of the horizontal and the vertical axis.
    axes: [usize; 2],
    /// Ends of the cells on both axes: halfway between neighbouring values.
    ends: [Vec<f64>; 2],
    /// For a refined grid: its plane, and the position in `axes` (0 or 1) of the axis of its columns.
    refined: Option<(Plane, usize)>,
    largest: f64,
    unit: &'a str,
    /// The direction of the sweep, if there is one.
    direction: Option<&'a str>,
}

impl<'a> Map<'a> {
    /// The map of the points in a plane; `None` if an axis is not in the grid or has a single value, or if no point
    /// has an exponent.
    fn of(
        followed: &Followed,
        axes: [usize; 2],
        plane: &FixedValues,
        results: &'a Results,
    ) -> Option<Self> {
        let grid = &results.summary.axes;
        let names: Vec<String> = grid.iter().map(|axis| axis.name.clone()).collect();
        let place = |axis: usize| {
            let found = names
                .iter()
                .position(|name| *name == followed.axes[axis].name);
            found.filter(|place| grid[*place].values.len() > 1)
        };
        let axes = [place(axes[0])?, place(axes[1])?];
        // If there are sweeps in two directions, the map shows the upward one.
        let direction = results.directions().first().copied();
        let points: Vec<&PointSummary> = (results.summary.all.iter())
            .filter(|point| plane.holds_named(&names, &point.axis_values))
            .filter(|point| direction.is_none() || point.direction.as_deref() == direction)
            .collect();
        points.iter().find(|point| point.lambda.is_some())?;
        let refined = results.summary.refined.as_ref().map(|refined| {
            let columns = usize::from(names[axes[1]] == refined.axes[1]);
            (Plane::new(refined, points.iter().copied()), columns)
        });
        Some(Self {
            points,
            axes,
            ends: axes.map(|axis| ends(&grid[axis].values)),
            refined,
            largest: largest_of(results),
            unit: results.unit("lambda_max"),
            direction,
        })
    }

    fn edges(&self, axis: usize) -> [f64; 2] {
        range(self.ends[axis].iter().copied())
    }

    fn draw(&self, canvas: &mut Canvas, panel: &Panel) {
        // Cells are slightly enlarged, because abutting edges show as seams in some viewers.
        let mut cell = |[x, y]: [[f64; 2]; 2], (colour, hatched): (Colour, bool)| {
            let [from, to] = [panel.at(x[0], y[1]), panel.at(x[1], y[0])];
            canvas.rectangle(from, [to[0] + 0.2, to[1] + 0.2], colour);
            if hatched {
                hatch(canvas, from, to, ink_on(colour));
            }
        };
        let look = |point: &PointSummary| {
            let hatched = Motion::of(point).is_hatched();
            (shade(point, self.largest), hatched)
        };
        if let Some((plane, columns)) = &self.refined {
            let shown = |index: usize| look(self.points[index]);
            for row in 0..plane.sides[0] {
                let places = (0..plane.sides[1]).map(|column| plane.at(row, column).map(shown));
                let mut start = 0;
                for run in places.collect::<Vec<_>>().chunk_by(|a, b| a == b) {
                    let end = start + run.len();
                    let mut sides = [[0.0; 2]; 2];
                    sides[*columns] = [start, end].map(|i| self.ends[*columns][i]);
                    sides[1 - columns] = [row, row + 1].map(|i| self.ends[1 - columns][i]);
                    if let Some(look) = run[0] {
                        cell(sides, look);
                    }
                    start = end;
                }
            }
            return;
        }
        for point in &self.points {
            let sides = [0, 1].map(|i| {
                let (ends, value) = (&self.ends[i], point.axis_values[self.axes[i]]);
                let cell = ends.partition_point(|end| *end <= value);
                let cell = cell.clamp(1, ends.len() - 1);
                [ends[cell - 1], ends[cell]]
            });
            cell(sides, look(point));
        }
    }

    fn key(&self, canvas: &mut Canvas, top: f64) {
        if self.largest > 0.0 {
            let axis = Axis::linear("λ of chaotic points", self.unit, [0.0, self.largest]);
            bar(canvas, MARGIN, [top, 496.0], &axis);
        }
        let at = [MARGIN, 522.0];
        canvas.label(at, "pale: not chaotic", INK);
        let is_hatched = |point: &&PointSummary| Motion::of(point).is_hatched();
        if self.points.iter().any(is_hatched) {
            let at = [MARGIN, 542.0];
            let words = "hatched: transient chaos";
            canvas.label(at, words, INK);
        }
    }
}

/// Edges of the cells around ascending values, of which there are at least two.
fn ends(values: &[f64]) -> Vec<f64> {
    let inner: Vec<f64> = values
        .windows(2)
        .map(|pair| 0.5 * (pair[0] + pair[1]))
        .collect();
    let last = values.len() - 1;
    let outer = [
        values[0] - (inner[0] - values[0]),
        values[last] + (values[last] - inner[last - 1]),
    ];
    [&outer[..1], &inner, &outer[1..]].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_cut_at_the_frame() {
        let frame = [[0.0, 10.0], [0.0, 1.0]];
        let path = [[-5.0, 0.5], [5.0, 0.5], [5.0, 2.0], [8.0, 2.0], [8.0, 0.0]];
        let wanted = vec![
            vec![[0.0, 0.5], [5.0, 0.5], [5.0, 1.0]],
            vec![[8.0, 1.0], [8.0, 0.0]],
        ];
        assert_eq!(clipped(&path, frame), wanted);
        assert!(clipped(&[[11.0, 0.0], [12.0, 0.0]], frame).is_empty());
    }

    #[test]
    fn cells_meet_halfway_between_their_values() {
        assert_eq!(ends(&[1.0, 2.0, 4.0]), [0.5, 1.5, 3.0, 5.0]);
    }
}
