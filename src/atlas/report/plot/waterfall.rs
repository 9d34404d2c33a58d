//! Waterfall: spectral lines over an axis of the grid, such as the speed. The vertical axis has orders or
//! frequencies, and colours show levels.

use std::collections::BTreeMap;

use super::axis::{Axis, range};
use super::canvas::{Canvas, SOFT};
use super::display::Scale;
use super::error::PlotError;
use super::over_axis::{RIGHT, across};
use super::panel::{BOTTOM, LEFT, Panel, TOP};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::ramp::{bar, viridis};
use super::request::PlotRequest;
use super::results::Results;
use super::spectral::{Line, SpectralLines};

/// Height of a cell \[px\].
const ROW: f64 = 3.0;
/// Smallest width of a strip \[px\]. Narrower strips are merged, and a cell shows the largest level.
const NARROWEST: f64 = 2.0;
/// Half the width of the strip of a single spectrum \[px\].
const SINGLE_HALF_WIDTH: f64 = 30.0;
/// Largest number of shown orders.
const MOST_ORDERS: f64 = 16.0;
/// Number of distinct colours.
const SHADES: f64 = 64.0;
/// Level of the darkest colour, relative to the largest amplitude: −80 dB.
const FLOOR: f64 = 1e-4;

pub(super) fn draw(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let spectral_lines = SpectralLines::read(results, PictureKind::Waterfall, request.signal())?;
    if request.frequency && !spectral_lines.has_frequencies() {
        return Err(PictureKind::Waterfall.unfit("spectra.parquet has the frequencies; add `nvh = { spectrum = {} }` to [analyses] of the manifest"));
    }
    let place = |line: &Line| {
        if request.frequency { line.frequency } else { Some(line.order) }
    };
    let scale =
        Scale::new(&spectral_lines.name, &spectral_lines.unit, &request.display)?.in_decades();
    let shown = || {
        spectral_lines
            .lines
            .iter()
            .flatten()
            .filter(|line| line.order <= MOST_ORDERS)
    };
    let largest = shown().map(|line| line.amplitude).fold(0.0, f64::max);
    let ends = [FLOOR * largest, largest].map(|end| scale.shown(end));
    let [Some(low), Some(high)] = ends else {
        return Err(PictureKind::Waterfall.unfit("no line is above zero"));
    };
    let level = scale.axis_over([low, high]);
    let seen = |line: &&Line| {
        scale
            .shown(line.amplitude)
            .is_some_and(|level| level >= low)
    };
    let highest = 1.02 * range(shown().filter(seen).filter_map(place))[1];
    let up = if request.frequency {
        Axis::linear("frequency", "Hz", [0.0, highest])
    } else {
        Axis::linear("mesh order", "1", [0.0, highest.max(1.0)])
    };
    let along = results.along_any(request.over.as_deref(), None)?;
    let axis = &results.summary.axes[along];
    let slices = results.slices(&[along]);
    let drawn = results.by_slice(PictureKind::Waterfall, slices, |slice| {
        let title = format!("{} over {}", spectral_lines.name, axis.name);
        let mut canvas = results.canvas(&title, &[&slice.words]);
        let panel = Panel::new(
            [LEFT, RIGHT],
            [TOP, BOTTOM],
            across(results, along),
            up.clone(),
        );
        panel.frame(&mut canvas, true);
        let columns: Vec<(f64, &[Line])> = (slice.points.iter())
            .filter_map(|point| {
                let lines = &spectral_lines.lines[results.place(point.point_id)?];
                Some((panel.x(point.axis_values[along]), &lines[..]))
            })
            .filter(|(x, lines)| x.is_finite() && !lines.is_empty())
            .collect();
        for ([left, right], lines) in strips(&panel, &columns) {
            let lit = |line: &&Line| line.order <= MOST_ORDERS;
            let cells = lines.iter().flat_map(|lines| lines.iter().filter(lit));
            let cells = cells.filter_map(|line| {
                let fraction = level.fraction(scale.shown(line.amplitude)?);
                Some((panel.y(place(line)?), fraction))
            });
            strip(&mut canvas, &panel, [left, right], cells);
        }
        if columns.is_empty() {
            panel.note(&mut canvas, "no point has a spectrum");
        }
        canvas.outline([LEFT, TOP], [RIGHT, BOTTOM], super::canvas::INK, 1.0);
        bar(&mut canvas, RIGHT + 24.0, [TOP, TOP + 300.0], &level);
        for (row, text) in ["white: no spectrum", "dark: less, or none"]
            .iter()
            .enumerate()
        {
            canvas.label([RIGHT + 18.0, TOP + 330.0 + 18.0 * row as f64], text, SOFT);
        }
        canvas
    });
    Ok(drawn)
}

/// The strips of the panel, each with the spectra that it shows. A strip reaches halfway to its neighbours.
/// The first and the last strip are symmetric about their spectra.
fn strips<'a>(panel: &Panel, columns: &[(f64, &'a [Line])]) -> Vec<([f64; 2], Vec<&'a [Line]>)> {
    let mut columns = columns.to_vec();
    columns.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Merge strips that would be too narrow.
    let mut merged: Vec<(f64, Vec<&[Line]>)> = Vec::new();
    for (x, lines) in columns {
        match merged.last_mut() {
            Some((last, all)) if x - *last < NARROWEST => all.push(lines),
            _ => merged.push((x, vec![lines])),
        }
    }
    let places: Vec<f64> = merged.iter().map(|(x, _)| *x).collect();
    let [left, right] = [panel.left, panel.right];
    let edge = |i: usize| -> f64 {
        let last = places.len() - 1;
        match i {
            _ if last == 0 => places[0] + [-SINGLE_HALF_WIDTH, SINGLE_HALF_WIDTH][i.min(1)],
            0 => places[0] - 0.5 * (places[1] - places[0]),
            i if i > last => places[last] + 0.5 * (places[last] - places[last - 1]),
            i => 0.5 * (places[i - 1] + places[i]),
        }
    };
    let edges: Vec<[f64; 2]> = (0..places.len())
        .map(|i| [edge(i), edge(i + 1)].map(|x| x.clamp(left, right)))
        .collect();
    (edges.into_iter().zip(merged))
        .map(|(edges, (_, lines))| (edges, lines))
        .collect()
}

/// Draws one strip. `lines` are heights \[px\] and fractions of the ramp. Every cell shows the largest of its
/// lines. Adjacent cells of one shade become one rectangle.
fn strip(
    canvas: &mut Canvas,
    panel: &Panel,
    [left, right]: [f64; 2],
    lines: impl Iterator<Item = (f64, f64)>,
) {
    let dark = viridis(0.0);
    canvas.rectangle([left, panel.top], [right, panel.bottom], dark);
    let mut rows: BTreeMap<i64, i64> = BTreeMap::new();
    for (y, fraction) in lines.filter(|(y, _)| (panel.top..=panel.bottom).contains(y)) {
        let shade = (SHADES * fraction.clamp(0.0, 1.0)).round() as i64;
        let row = ((panel.bottom - y) / ROW).floor() as i64;
        let stored = rows.entry(row).or_insert(0);
        *stored = shade.max(*stored);
    }
    let mut rows = rows.into_iter().filter(|(_, shade)| *shade > 0).peekable();
    while let Some((first, shade)) = rows.next() {
        let mut last = first;
        while let Some((row, _)) = rows.next_if(|&(row, stored)| row == last + 1 && stored == shade)
        {
            last = row;
        }
        let y = |row: i64| (panel.bottom - ROW * row as f64).max(panel.top);
        let colour = viridis(shade as f64 / SHADES);
        canvas.rectangle([left, y(last + 1)], [right, y(first)], colour);
    }
}
