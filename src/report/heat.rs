//! A character map of the largest exponent over the first two axes of the grid.
//!
//! Chaotic points show the size of λ (a ramp of characters, or of colours from viridis),
//! all others what they are. A wide grid is binned: a mark then stands for the liveliest
//! of its points. Further axes are held at their first value.

use std::fmt::Write;

use super::summary::{Axis, PointSummary, Summary};
use super::text::{Style, label, number};

/// Chaotic marks, from small to large λ.
const RAMP: [char; 5] = ['-', '=', '*', '#', '@'];
/// Five steps of viridis in the 256-colour palette; dark to bright, so that order survives
/// colour blindness.
const COLOURS: [u8; 5] = [54, 60, 31, 78, 227];
/// Most cells across and down.
const MOST: [usize; 2] = [24, 64];

/// What a cell shows. Order: of several points in a cell, the greatest is shown.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Cell {
    Missing,
    Unclassified,
    SteadyContact,
    Periodic(u64),
    Failed,
    NotConverged,
    QuasiPeriodic,
    Chaotic(f64),
}

impl Cell {
    fn of(point: &PointSummary) -> Self {
        match (point.status.as_str(), point.class.as_deref()) {
            ("diverged" | "event_storm" | "failed" | "inaccurate", _) => Self::Failed,
            (_, Some("chaotic")) => Self::Chaotic(point.lambda.unwrap_or(0.0)),
            (_, Some("quasi_periodic")) => Self::QuasiPeriodic,
            (_, Some("steady_contact")) => Self::SteadyContact,
            (_, Some("periodic")) => Self::Periodic(point.period.unwrap_or(0)),
            ("not_converged", _) | (_, Some("not_converged")) => Self::NotConverged,
            _ => Self::Unclassified,
        }
    }

    fn mark(self, largest: f64) -> char {
        match self {
            Self::Missing => ' ',
            Self::Unclassified => '.',
            Self::SteadyContact => 'L',
            Self::Periodic(period @ 1..=9) => char::from(b'0' + period as u8),
            Self::Periodic(_) => '+',
            Self::Failed => 'x',
            Self::NotConverged => '?',
            Self::QuasiPeriodic => 'q',
            Self::Chaotic(lambda) => RAMP[step(lambda, largest)],
        }
    }

    fn meaning(self) -> Option<&'static str> {
        match self {
            Self::Missing => None,
            Self::Unclassified => Some(". not classified"),
            Self::SteadyContact => Some("S steady contact"),
            Self::Periodic(1..=9) => Some("1-9 period in mesh cycles"),
            Self::Periodic(_) => Some("+ longer period"),
            Self::Failed => Some("x failed"),
            Self::NotConverged => Some("? not converged"),
            Self::QuasiPeriodic => Some("q quasi-periodic"),
            Self::Chaotic(_) => None,
        }
    }
}

/// Position of λ on a ramp from 0 to the largest.
fn step(lambda: f64, largest: f64) -> usize {
    let fraction = if largest > 0.0 {
        (lambda / largest).clamp(0.0, 1.0)
    } else {
        0.0
    };
    ((fraction * RAMP.len() as f64) as usize).min(RAMP.len() - 1)
}

/// The cells of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    cells: Vec<Vec<Cell>>,
    rows: Bins,
    columns: Bins,
    /// Largest exponent met.
    largest: f64,
}

impl Map {
    /// A map without points over some axes; none where there is no axis.
    pub(super) fn new(axes: &[Axis]) -> Option<Self> {
        let across = axes.len().min(2).checked_sub(1)?;
        let down = (across > 0).then(|| &axes[0]);
        let rows = Bins::new(down.map_or(1, |axis| axis.values.len()), MOST[0]);
        let columns = Bins::new(axes[across].values.len(), MOST[1]);
        Some(Self {
            cells: vec![vec![Cell::Missing; columns.count]; rows.count],
            rows,
            columns,
            largest: 0.0,
        })
    }

    /// Enters a point, unless it lies in another slice than the first.
    pub(super) fn add(&mut self, axes: &[Axis], point: &PointSummary) {
        let across = axes.len().min(2) - 1;
        let mut further = axes[across + 1..]
            .iter()
            .zip(&point.axis_values[across + 1..]);
        if further.any(|(axis, value)| axis.values.first() != Some(value)) {
            return;
        }
        let place = |index: usize| position(&axes[index], point.axis_values[index]);
        let column = self.columns.of(place(across));
        let row = if across > 0 {
            self.rows.of(place(0))
        } else {
            0
        };
        let cell = Cell::of(point);
        if let Cell::Chaotic(lambda) = cell {
            self.largest = self.largest.max(lambda);
        }
        let there = &mut self.cells[row][column];
        if cell >= *there {
            *there = cell;
        }
    }
}

/// The map as text; empty when the grid has no axis or no point.
pub(super) fn heat_map(summary: &Summary, style: Style) -> String {
    let Some(Map {
        cells,
        rows,
        columns,
        largest,
    }) = &summary.map
    else {
        return String::new();
    };
    let (largest, across_index) = (*largest, summary.axes.len().min(2) - 1);
    let across = &summary.axes[across_index];
    let down = (across_index > 0).then(|| &summary.axes[0]);
    let further = summary.axes.get(2..).unwrap_or_default();

    let mut text = String::from("largest Lyapunov exponent");
    if let Some(down) = down {
        _ = write!(text, ", {} (down)", label(down));
    }
    _ = writeln!(text, " over {}", label(across));
    for axis in further {
        let (first, slices) = (number(axis.values[0]), axis.values.len());
        _ = writeln!(
            text,
            "  first of {slices} slices: {} = {first}",
            label(axis)
        );
    }
    // The largest value of the slow axis on top, as in a diagram.
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
    if rows.size > 1 || columns.size > 1 {
        let size = rows.size * columns.size;
        _ = writeln!(
            text,
            "  each mark stands for up to {size} points, the liveliest of them"
        );
    }
    text
}

fn position(axis: &Axis, value: f64) -> usize {
    axis.values.partition_point(|&known| known < value)
}

/// A range of indices cut into equal bins.
#[derive(Debug, Clone, PartialEq)]
struct Bins {
    size: usize,
    count: usize,
}

impl Bins {
    fn new(length: usize, most: usize) -> Self {
        let size = length.div_ceil(most).max(1);
        Self {
            size,
            count: length.div_ceil(size),
        }
    }

    fn of(&self, index: usize) -> usize {
        index / self.size
    }

    fn first(&self, bin: usize) -> usize {
        bin * self.size
    }
}

fn push_cell(text: &mut String, cell: Cell, largest: f64, width: usize, style: Style) {
    let mark = cell.mark(largest);
    match (style, cell) {
        (Style::Colour, Cell::Chaotic(lambda)) => {
            let colour = COLOURS[step(lambda, largest)];
            _ = write!(text, "\x1b[48;5;{colour}m{:width$}\x1b[0m", "");
        }
        (Style::Colour, Cell::Failed | Cell::NotConverged) => {
            _ = write!(text, "\x1b[1m{mark:>width$}\x1b[0m");
        }
        _ => _ = write!(text, "{mark:>width$}"),
    }
}

/// Values under the map, each starting under its mark, as many as fit.
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
        .filter_map(|cell| cell.meaning())
        .collect();
    meanings.sort_unstable();
    meanings.dedup();
    if cells
        .iter()
        .flatten()
        .any(|cell| matches!(cell, Cell::Chaotic(_)))
    {
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
