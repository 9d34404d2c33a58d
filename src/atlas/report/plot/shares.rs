//! Basin shares over one axis: one colour per branch, with 95 % intervals.

use std::collections::{BTreeMap, HashMap};

use super::axis::{Axis, range, span_words};
use super::canvas::{Anchor, Canvas, Colour, INK, Place, SOFT, WIDTH};
use super::categories::colour;
use super::error::PlotError;
use super::lettering::{fitted, wrapped};
use super::marker::OTHERS;
use super::over_axis::across;
use super::panel::{BOTTOM, LEFT, Panel, TICK_SIZE};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::results::Results;
use crate::report::PointSummary;
use crate::report::branches::{Attractor, branches, read_attractors};
use crate::report::numbers::plural;

const RIGHT: f64 = 690.0;
const MARGIN: f64 = RIGHT + 24.0;
/// Half the width of the whiskers of the first branch \[px\].
const WHISKER: f64 = 3.0;
/// Increase of the half width of whiskers from one branch to the next \[px\].
const WIDER: f64 = 2.0;

/// Draws the shares of every slice of the grid.
pub(super) fn draw(results: &Results, along: usize) -> Result<Drawn, PlotError> {
    let attractors = read_attractors(&results.folder)?;
    if attractors.is_empty() {
        return Err(PictureKind::Shares.unfit(
            "there are no attractors; add `multistability = {}` to [analyses] of the manifest",
        ));
    }
    let summary = &results.summary;
    let fixed_axes = summary.tied.fixed_axes(summary.axes.len(), &[along]);
    let followed = branches(&attractors, &summary.all, &summary.axes, along, &fixed_axes);
    let name = &summary.axes[along].name;
    let slices = results.slices(&[along]);
    let drawn = results.by_slice(PictureKind::Shares, slices, |slice| {
        let title = format!("basin shares over {name}");
        let mut canvas = results.canvas(&title, &[&slice.words]);
        let points = slice.points.iter().map(|point| (point.point_id, *point));
        let points: HashMap<u64, &PointSummary> = points.collect();
        // Colours follow the order of the branches within the slice.
        let mut by_branch: BTreeMap<usize, Vec<(&PointSummary, &Attractor)>> = BTreeMap::new();
        for (attractor, branch) in attractors.iter().zip(&followed) {
            if let Some(&point) = points.get(&attractor.point_id) {
                by_branch
                    .entry(*branch)
                    .or_default()
                    .push((point, attractor));
            }
        }
        let panel = Panel::new(
            [LEFT, RIGHT],
            [72.0, BOTTOM],
            across(results, along),
            Axis::linear("share of probes", "1", [-0.03, 1.03]),
        );
        panel.frame(&mut canvas, true);
        // Intervals of branches at one point overlap: draw them below all lines and symbols.
        for (place, line) in by_branch.values().enumerate() {
            intervals(&mut canvas, &panel, along, place, line);
        }
        for (place, line) in by_branch.values().enumerate() {
            let points: Vec<&PointSummary> = line.iter().map(|(point, _)| *point).collect();
            for part in results.lines(&[along], &points) {
                let part: Vec<_> = part.into_iter().map(|index| line[index]).collect();
                draw_branch(&mut canvas, &panel, along, place, &part);
            }
        }
        key(&mut canvas, along, &by_branch);
        canvas
    });
    Ok(drawn)
}

/// Draws the 95 % intervals of the shares of a branch. Whiskers of different branches have different widths,
/// so that they can be distinguished where they overlap.
fn intervals(
    canvas: &mut Canvas,
    panel: &Panel,
    along: usize,
    place: usize,
    line: &[(&PointSummary, &Attractor)],
) {
    let half = WHISKER + WIDER * (place % 4) as f64;
    for (point, attractor) in line {
        let x = panel.x(point.axis_values[along]);
        let [low, high] = attractor.interval.map(|share| panel.y(share));
        canvas.line(&[[x, low], [x, high]], colour(place), 1.2);
        for y in [low, high] {
            canvas.line(&[[x - half, y], [x + half, y]], colour(place), 1.2);
        }
    }
}

fn draw_branch(
    canvas: &mut Canvas,
    panel: &Panel,
    along: usize,
    place: usize,
    line: &[(&PointSummary, &Attractor)],
) {
    let dots: Vec<Place> = line
        .iter()
        .map(|(point, attractor)| panel.at(point.axis_values[along], attractor.share))
        .collect();
    canvas.line(&dots, colour(place), 1.6);
    for dot in dots {
        OTHERS[place % OTHERS.len()].filled(canvas, dot, colour(place));
    }
}

/// Draws the key: for each branch, its kinds of motion, number of points and RMS.
fn key(
    canvas: &mut Canvas,
    along: usize,
    by_branch: &BTreeMap<usize, Vec<(&PointSummary, &Attractor)>>,
) {
    let at = [MARGIN, 84.0];
    let width = WIDTH - 6.0 - MARGIN;
    let (head, size) = fitted("branches; bars: 95 % interval", TICK_SIZE, 8.0, width);
    canvas.text(at, &head, size, SOFT, Anchor::Start);
    let mut y = 98.0;
    let mut named = 0;
    for (place, line) in by_branch.values().enumerate() {
        let (words, numbers) = described(line, along);
        let inks = [(words, INK), (numbers, SOFT)];
        let lines: Vec<(String, Colour)> = inks
            .into_iter()
            .flat_map(|(text, ink)| {
                let lines = wrapped(&text, TICK_SIZE, width - 21.0).into_iter();
                lines.map(move |line| (line, ink))
            })
            .collect();
        let height = 16.0 * lines.len() as f64 + 8.0;
        if y + height > BOTTOM - 16.0 && by_branch.len() > place + 1 {
            break;
        }
        OTHERS[place % OTHERS.len()].filled(canvas, [MARGIN + 7.0, y + 7.0], colour(place));
        for (row, (text, ink)) in lines.iter().enumerate() {
            canvas.label([MARGIN + 21.0, y + 12.0 + 16.0 * row as f64], text, *ink);
        }
        y += height;
        named += 1;
    }
    if by_branch.len() > named {
        let text = format!("… and {} more", by_branch.len() - named);
        canvas.label([MARGIN, y + 12.0], &text, SOFT);
    }
}

/// Two texts about a branch: its kinds of motion in the order along the axis, and its number of points with
/// the range of their RMS.
fn described(line: &[(&PointSummary, &Attractor)], along: usize) -> (String, String) {
    let mut line = line.to_vec();
    line.sort_by(|a, b| a.0.axis_values[along].total_cmp(&b.0.axis_values[along]));
    let mut kinds: Vec<String> = line.iter().map(|(_, attractor)| attractor.kind()).collect();
    kinds.dedup();
    let mut words = kinds.join(" → ");
    if kinds.len() > 3 {
        let [first, last] = [&kinds[0], &kinds[kinds.len() - 1]];
        words = format!("{first} → … → {last}");
    }
    let rms: Vec<f64> = (line.iter())
        .filter_map(|(_, attractor)| attractor.deflection_rms)
        .collect();
    let points = plural(line.len(), "point");
    let numbers = if rms.is_empty() {
        points
    } else {
        format!("{points}, RMS {}", span_words(range(rms.into_iter()), "m"))
    };
    (words, numbers)
}
