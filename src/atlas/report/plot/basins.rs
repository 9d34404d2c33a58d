//! Basins of attraction: a slice of initial states, each in the colour of the attractor to which it leads.

use std::collections::BTreeMap;

use super::axis::{Axis, value_words};
use super::canvas::{Canvas, INK, Place, SOFT, WHITE};
use super::categories::{colour, lost};
use super::error::PlotError;
use super::panel::{LEFT, Panel, TOP};
use super::picture::{Drawn, Picture};
use super::picture_kind::PictureKind;
use super::request::PlotRequest;
use super::results::{MOST_SLICES, Results};
use crate::report::branches::{Attractor, read_attractors};
use crate::store::{ResultTable, TableKind};

/// Side of the slice \[px\].
const SIDE: f64 = 600.0;
const MARGIN: f64 = LEFT + SIDE + 28.0;
/// Largest number of entries in the key.
const MOST_ENTRIES: usize = 10;

/// The end of the motion from a cell: the number of its attractor, or the status of a motion that reached
/// none.
type Ending = Result<u64, String>;

/// A cell of a slice.
struct Cell {
    /// Column and row.
    at: [u64; 2],
    /// Centre \[m; in a phase plane, the second coordinate in m/s\].
    centre: Place,
    ending: Ending,
}

/// Draws one picture per point, or only the picture of the requested point.
pub(super) fn draw(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let table = results.needed(TableKind::Basins, PictureKind::Basins)?;
    let axes = slice_axes(&table);
    let mut slices = cells(&table)?;
    if let Some(id) = request.point {
        results.point(id)?;
        slices.retain(|point_id, _| *point_id == id);
        if slices.is_empty() {
            return Err(PictureKind::Basins.unfit(format!("point {id} has no cell")));
        }
    }
    slices.retain(|_, cells| cells.iter().any(|cell| cell.at[0] > 0));
    if slices.is_empty() {
        return Err(PictureKind::Basins.unfit("no slice of basins.parquet has two cells per side"));
    }
    let attractors = read_attractors(&results.folder)?;
    let single = results.summary.all.len() == 1;
    let mut drawn = Drawn::sliced(
        PictureKind::Basins.name(),
        slices.len().min(MOST_SLICES),
        slices.len(),
    );
    for (point_id, cells) in slices.into_iter().take(MOST_SLICES) {
        let of_point: Vec<&Attractor> = attractors
            .iter()
            .filter(|a| a.point_id == point_id)
            .collect();

        let words = results.point_words(results.point(point_id)?);
        let mut canvas = results.canvas("basins of attraction on a slice", &[&words]);
        draw_slice(&mut canvas, &axes, &cells, &of_point);
        key(&mut canvas, &cells, &of_point);
        canvas.height = TOP + SIDE + 66.0;
        let name = if single { "basins".to_owned() } else { format!("basins-point={point_id}") };
        drawn.pictures.push(Picture::new(name, canvas));
    }
    Ok(drawn)
}

/// Name and unit of both axes of the slices of a table of cells.
pub(in crate::report) fn slice_axes(table: &ResultTable) -> [[String; 2]; 2] {
    table
        .metadata("slice")
        .and_then(|text| serde_json::from_str(text).ok())
        .unwrap_or_else(|| ["x", "y"].map(|name| [name, "m"].map(str::to_owned)))
}

/// The cells of each point.
fn cells(table: &ResultTable) -> Result<BTreeMap<u64, Vec<Cell>>, PlotError> {
    let (ids, i, j) = (table.u64("point_id")?, table.u64("i")?, table.u64("j")?);
    let (x, y) = (table.f64("x")?, table.f64("y")?);
    let (attractors, statuses) = (table.u64("attractor_id")?, table.text("status")?);
    let mut slices: BTreeMap<u64, Vec<Cell>> = BTreeMap::new();
    for row in 0..table.rows() {
        let cell = || {
            Some(Cell {
                at: [i[row]?, j[row]?],
                centre: [x[row]?, y[row]?],
                ending: match attractors[row] {
                    Some(id) => Ok(id),
                    None => Err(statuses[row].clone().unwrap_or_default()),
                },
            })
        };
        if let (Some(id), Some(cell)) = (ids[row], cell()) {
            slices.entry(id).or_default().push(cell);
        }
    }
    Ok(slices)
}

/// Draws the cells of a slice and the strobe states of the attractors. `axes` has the name and the unit of
/// each axis.
fn draw_slice(
    canvas: &mut Canvas,
    axes: &[[String; 2]; 2],
    cells: &[Cell],
    attractors: &[&Attractor],
) {
    // The edge lies half a cell beyond the centres of the outermost cells. The slice is symmetric about zero.
    let count = cells.iter().map(|cell| cell.at[0]).max().unwrap_or(0) as f64 + 1.0;
    let extent = [0, 1].map(|axis| {
        let centres = cells.iter().map(|cell| cell.centre[axis]);
        centres.fold(0.0_f64, f64::max) * count / (count - 1.0)
    });
    let axis = |i: usize| {
        let [name, unit] = &axes[i];
        Axis::linear(name, unit, [-extent[i], extent[i]])
    };
    let panel = Panel::new([LEFT, LEFT + SIDE], [TOP, TOP + SIDE], axis(0), axis(1));
    // Ticks and grid lines come first, so that the cells cover the grid lines.
    panel.frame(canvas, true);
    let side = SIDE / count;
    let mut start = 0;
    while start < cells.len() {
        let first = &cells[start];
        // Cells without a value are missing in the list: a run ends at such a gap.
        let continues = |(cell, column): &(&Cell, u64)| {
            cell.at == [*column, first.at[1]] && cell.ending == first.ending
        };
        let columns = cells[start..].iter().zip(first.at[0]..);
        let run = columns.take_while(continues).count();
        let [column, row] = first.at.map(|place| place as f64);
        let [x, y] = [LEFT + side * column, TOP + SIDE - side * (row + 1.0)];
        // Slightly enlarged, because abutting edges show as seams in some viewers.
        let right = (x + side * run as f64 + 0.3).min(panel.right);
        let bottom = (y + side + 0.3).min(panel.bottom);
        canvas.rectangle([x, y], [right, bottom], shade(&first.ending));
        start += run;
    }
    panel.outline(canvas);
    for attractor in attractors {
        for [x, y] in &attractor.strobe {
            if x.abs() < extent[0] && y.abs() < extent[1] {
                mark(canvas, panel.at(*x, *y), attractor.attractor_id as usize);
            }
        }
    }
}

fn shade(ending: &Ending) -> super::canvas::Colour {
    match ending {
        Ok(id) => colour(*id as usize),
        Err(status) => lost(status),
    }
}

/// Draws a mark at the strobe state of an attractor.
fn mark(canvas: &mut Canvas, at: Place, attractor: usize) {
    canvas.disc(at, 7.0, INK);
    canvas.disc(at, 5.6, WHITE);
    canvas.disc(at, 3.6, colour(attractor));
}

fn key(canvas: &mut Canvas, cells: &[Cell], attractors: &[&Attractor]) {
    let mut counts: BTreeMap<Ending, usize> = BTreeMap::new();
    for cell in cells {
        *counts.entry(cell.ending.clone()).or_insert(0) += 1;
    }
    let share = |count: usize| {
        format!(
            "{:.1} % of cells",
            100.0 * count as f64 / cells.len() as f64
        )
    };
    let mut y = TOP;
    for (ending, count) in counts.iter().take(MOST_ENTRIES) {
        let known = attractors.iter().find(|a| Ok(a.attractor_id) == *ending);
        let (name, numbers) = match (ending, known) {
            (Ok(id), Some(attractor)) => {
                let rms = attractor
                    .deflection_rms
                    .map(|rms| format!(", RMS {}", value_words(rms, "m")));
                (
                    format!("attractor {id}: {}", attractor.kind()),
                    format!("{}{}", share(*count), rms.unwrap_or_default()),
                )
            }
            (Ok(id), None) => (format!("attractor {id}"), share(*count)),
            (Err(status), _) => (
                format!("no attractor: {}", status.replace('_', " ")),
                share(*count),
            ),
        };
        canvas.rectangle([MARGIN, y], [MARGIN + 16.0, y + 16.0], shade(ending));
        canvas.outline([MARGIN, y], [MARGIN + 16.0, y + 16.0], SOFT, 1.0);
        canvas.label([MARGIN + 25.0, y + 13.0], &name, INK);
        canvas.label([MARGIN + 25.0, y + 30.0], &numbers, SOFT);
        y += 42.0;
    }
    if counts.len() > MOST_ENTRIES {
        let text = format!("… and {} more", counts.len() - MOST_ENTRIES);
        canvas.label([MARGIN, y + 13.0], &text, SOFT);
        y += 24.0;
    }
    if attractors
        .iter()
        .any(|attractor| !attractor.strobe.is_empty())
    {
        mark(
            canvas,
            [MARGIN + 8.0, y + 12.0],
            attractors.first().map_or(0, |a| a.attractor_id as usize),
        );
        for (line, text) in ["attractor at mesh phase 0,", "projected on the slice"]
            .into_iter()
            .enumerate()
        {
            canvas.label([MARGIN + 25.0, y + 16.0 + 17.0 * line as f64], text, SOFT);
        }
    }
}
