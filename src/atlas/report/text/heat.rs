//! A character map of the largest exponent over the first two axes of the grid with several values.
//!
//! A chaotic point shows the magnitude of λ, as a character or a colour of a ramp. All other points show
//! their kind of motion. Transient chaos is a `t`; in the coloured map, it has the colour of its λ.

use super::style::Style;
use super::table::label;
use crate::report::heat::{Bins, Cell, Map};
use crate::report::numbers::number;
use crate::report::point::Axis;
use crate::report::summary::Summary;
use std::fmt::Write;

/// Marks of chaotic points, from small to large λ.
const RAMP: [char; 5] = ['-', '=', '*', '#', '@'];

/// Five steps of viridis in the 256-colour palette; dark to bright, so that the order is visible to colour-blind
/// readers.
const COLOURS: [u8; 5] = [54, 60, 31, 78, 227];

/// Text colour that is legible on each of [`COLOURS`]: white or black, in the 256-colour palette.
const INKS: [u8; 5] = [231, 231, 231, 16, 16];

/// The map as text; empty without points or varying axes, or if axes are distributions.
pub(super) fn heat_map(summary: &Summary, style: Style) -> String {
    let Some(Map {
        cells,
        down,
        across,
        further,
        rows,
        columns,
        largest,
        directions,
    }) = &summary.map
    else {
        return String::new();
    };
    let largest = *largest;
    let across = &summary.axes[*across];
    let down = down.map(|down| &summary.axes[down]);

    let mut text = String::from("largest Lyapunov exponent");
    if let Some(down) = down {
        _ = write!(text, ", {} (down)", label(down));
    }
    _ = writeln!(text, " over {}", label(across));
    for axis in further.iter().map(|axis| &summary.axes[*axis]) {
        let (first, slices) = (number(axis.values[0]), axis.values.len());
        _ = writeln!(
            text,
            "  first of {slices} slices: {} = {first}",
            label(axis)
        );
    }
    // The largest value of the slow axis is at the top, as in a diagram.
    let width = match columns.count {
        // Room for every label.
        0..=12 => 6,
        13..=32 => 2,
        _ => 1,
    };
    for (row, marks) in cells.iter().enumerate().rev() {
        let value = down.map_or_else(String::new, |axis| number(axis.values[rows.first(row)]));
        _ = write!(text, "{value:>10} |");
        for &cell in marks {
            push_cell(&mut text, cell, largest, width, style);
        }
        text.push_str("|\n");
    }
    push_ticks(&mut text, across, columns, width);
    push_legend(&mut text, cells, largest, style);
    let size = rows.size * columns.size * directions.len().max(1);
    if size > 1 {
        _ = writeln!(
            text,
            "  each mark stands for up to {size} points and shows the most irregular of them"
        );
    }
    text
}

fn push_cell(text: &mut String, cell: Cell, largest: f64, width: usize, style: Style) {
    let mark = mark(cell, largest);
    match (style, cell) {
        (Style::Colour, Cell::Chaotic(lambda)) => {
            let colour = COLOURS[step(lambda, largest)];
            _ = write!(text, "\x1b[48;5;{colour}m{:width$}\x1b[0m", "");
        }
        (Style::Colour, Cell::TransientChaos(lambda)) => {
            let step = step(lambda, largest);
            let (colour, ink) = (COLOURS[step], INKS[step]);
            _ = write!(
                text,
                "\x1b[48;5;{colour}m\x1b[38;5;{ink}m{mark:>width$}\x1b[0m"
            );
        }
        (Style::Colour, Cell::Failed | Cell::NotConverged) => {
            _ = write!(text, "\x1b[1m{mark:>width$}\x1b[0m");
        }
        _ => _ = write!(text, "{mark:>width$}"),
    }
}

/// Appends values of the horizontal axis below the map, each below its column, as many as fit.
fn push_ticks(text: &mut String, axis: &Axis, columns: &Bins, width: usize) {
    let mut line = String::new();
    for column in 0..columns.count {
        let start = (column + 1) * width - 1;
        let used = line.chars().count();
        if column == 0 || used < start {
            let value = number(axis.values[columns.first(column)]);
            _ = write!(line, "{:room$}{value}", "", room = start - used);
        }
    }
    _ = writeln!(text, "{:>10}  {line}", "");
}

fn push_legend(text: &mut String, cells: &[Vec<Cell>], largest: f64, style: Style) {
    let mut meanings: Vec<&str> = cells
        .iter()
        .flatten()
        .filter_map(|cell| meaning(*cell))
        .collect();
    meanings.sort_unstable();
    meanings.dedup();
    if cells.iter().flatten().any(|cell| match cell {
        Cell::Chaotic(_) => true,
        Cell::TransientChaos(_) => style == Style::Colour,
        _ => false,
    }) {
        let ramp: String = match style {
            Style::Plain => RAMP.iter().collect(),
            Style::Colour => COLOURS
                .iter()
                .map(|colour| format!("\x1b[48;5;{colour}m \x1b[0m"))
                .collect(),
        };
        _ = writeln!(
            text,
            "  {ramp} chaotic, λ from 0 to {} 1/cycle",
            number(largest)
        );
    }
    if !meanings.is_empty() {
        _ = writeln!(text, "  {}", meanings.join("; "));
    }
}

fn mark(cell: Cell, largest: f64) -> char {
    match cell {
        Cell::Missing => ' ',
        Cell::Unclassified => '.',
        Cell::SteadyContact => 'L',
        Cell::Periodic(period @ 1..=9) => char::from(b'0' + period as u8),
        Cell::Periodic(_) => '+',
        Cell::Failed => 'x',
        Cell::NotConverged => '?',
        Cell::QuasiPeriodic => 'q',
        Cell::TransientChaos(_) => 't',
        Cell::Chaotic(lambda) => RAMP[step(lambda, largest)],
    }
}

fn meaning(cell: Cell) -> Option<&'static str> {
    match cell {
        Cell::Missing => None,
        Cell::Unclassified => Some(". not classified"),
        Cell::SteadyContact => Some("L steady contact"),
        Cell::Periodic(1..=9) => Some("1-9 period in mesh cycles"),
        Cell::Periodic(_) => Some("+ longer period"),
        Cell::Failed => Some("x failed"),
        Cell::NotConverged => Some("? not converged"),
        Cell::QuasiPeriodic => Some("q quasi-periodic"),
        Cell::TransientChaos(_) => Some("t transient chaos"),
        Cell::Chaotic(_) => None,
    }
}

/// Step of the ramp for λ, where the ramp goes from 0 to the largest λ.
fn step(lambda: f64, largest: f64) -> usize {
    let fraction = if largest > 0.0 { (lambda / largest).clamp(0.0, 1.0) } else { 0.0 };
    ((fraction * RAMP.len() as f64) as usize).min(RAMP.len() - 1)
}
