//! Where do windows start while nothing happens?

use super::length::fewest_windows;
use crate::model::{MeshCycle, Model};

/// Most lengths of window, so that their tables stay small.
const MOST_LENGTHS: usize = 4;

/// Windows on equal parts of the whole cycle share one table; they may be this many times
/// as many as windows that fit each segment by itself.
const WORTH_SHARING: f64 = 1.25;

/// Fewest cells a cycle, before they are fitted: the deflection turns several times on a longer
/// one, and halving its series to find the events costs more than another window.
const FEWEST: f64 = 4.0;

/// Most equal parts of the cycle on which segment boundaries are sought.
const MOST_PARTS: usize = 10_000;

/// Lengths closer than this, relative, are one.
const SAME_LENGTH: f64 = 1e-12;

/// The mesh cycle in cells: whole numbers of them in every segment, as long as one another
/// within it. A cell is the window that nothing cuts.
#[derive(Debug)]
pub struct Grid {
    /// Start of every cell \[s\], and the period.
    pub time: Vec<f64>,
    /// Mesh segment of every cell.
    pub segment_of_cell: Vec<usize>,
    /// First cell after each segment.
    pub segment_end_cell: Vec<usize>,
    /// First cell after each segment and those behind it that free flight does not feel: of the
    /// same direction and half gap.
    pub flight_end_cell: Vec<usize>,
    /// The distinct lengths of cells Δ \[s\].
    pub lengths: Vec<f64>,
    /// Which of them a segment has.
    pub length_of_segment: Vec<usize>,
}

impl Grid {
    /// The grid with the fewest cells that the tolerance allows, or one of few lengths.
    pub fn new(model: &Model, tolerance: f64) -> Self {
        let cycle = &model.cycle;
        let cells: Vec<_> = (cells_of_segments(model, tolerance).into_iter())
            .map(|count| count as usize)
            .collect();
        let (lengths, length_of_segment) = distinct_lengths(cycle, &cells);
        let mut grid = Self {
            time: Vec::new(),
            segment_of_cell: Vec::new(),
            segment_end_cell: Vec::new(),
            flight_end_cell: Vec::new(),
            lengths,
            length_of_segment,
        };
        for (index, &count) in cells.iter().enumerate() {
            let (start, end) = (cycle.start(index), cycle.end(index));
            let place = |cell: usize| start + (end - start) * (cell as f64 / count as f64);
            grid.time.extend((0..count).map(place));
            grid.segment_of_cell.extend((0..count).map(|_| index));
            grid.segment_end_cell.push(grid.segment_of_cell.len());
        }
        grid.time.push(cycle.period);
        grid.flight_end_cell = grid.segment_end_cell.clone();
        for index in (1..cells.len()).rev() {
            if !cycle.turns(index) {
                grid.flight_end_cell[index - 1] = grid.flight_end_cell[index];
            }
        }
        grid
    }

    /// Length Δ of a segment's cells \[s\].
    pub fn delta(&self, segment: usize) -> f64 {
        self.lengths[self.length_of_segment[segment]]
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.segment_of_cell.len()
    }
}

/// Cells of every segment, whole numbers; as many as a slow cycle asks for, so not counted in
/// integers.
pub fn cells_of_segments(model: &Model, tolerance: f64) -> Vec<f64> {
    let cycle = &model.cycle;
    let fewest = fewest_windows(model, tolerance).max(FEWEST);
    let share = |count: f64| -> Vec<f64> {
        (cycle.segments.iter())
            .map(|s| (count * (s.end - s.start)).ceil().max(1.0))
            .collect()
    };
    let fitted = share(fewest);
    let total: f64 = fitted.iter().sum();
    let lengths = (cycle.segments.iter().zip(&fitted))
        .map(|(s, count)| cycle.period * (s.end - s.start) / count);
    let few = distinct(lengths).0.len() <= MOST_LENGTHS;
    let most = if few {
        WORTH_SHARING * total
    } else {
        f64::INFINITY
    };
    let Some(parts) = cycle.equal_parts(most.min(MOST_PARTS as f64) as usize) else {
        return fitted;
    };
    let parts = parts as f64;
    let cells = parts * (fewest / parts).ceil().max(1.0);
    if cells > most {
        return fitted;
    }
    (cycle.segments.iter())
        .map(|s| (cells * (s.end - s.start)).round())
        .collect()
}

/// Lengths of the segments' cells \[s\], each once, and which of them each segment has.
fn distinct_lengths(cycle: &MeshCycle, cells: &[usize]) -> (Vec<f64>, Vec<usize>) {
    distinct(
        (cells.iter().enumerate())
            .map(|(index, &count)| (cycle.end(index) - cycle.start(index)) / count as f64),
    )
}

fn distinct(lengths: impl Iterator<Item = f64>) -> (Vec<f64>, Vec<usize>) {
    let mut seen: Vec<f64> = Vec::new();
    let which = lengths
        .map(|length| {
            let same = |known: &f64| (known - length).abs() <= SAME_LENGTH * length;
            seen.iter().position(same).unwrap_or_else(|| {
                seen.push(length);
                seen.len() - 1
            })
        })
        .collect();
    (seen, which)
}
