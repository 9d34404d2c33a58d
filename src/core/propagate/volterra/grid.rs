//! Where do windows start in a cycle without events?

use super::length::fewest_windows;
use crate::model::{MOST_PARTS, Model, SAME_PHASE, equal_parts};
use crate::propagate::SAME_LENGTH;

/// Round-off of sums of times, relative to the mesh period.
pub(super) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Largest number of window lengths of a cycle, if equal parts of the cycle can replace them. It limits the tables.
const MOST_LENGTHS: usize = 4;

/// Windows on equal parts of the whole cycle share one table. They are worth it up to this multiple of the number of
/// windows fitted to each segment.
const WORTH_SHARING: f64 = 1.25;

/// Smallest number of cells per cycle, before they are fitted. On a longer cell, the deflection has several extrema,
/// and bisecting its series to find the events costs more than another window.
pub(super) const FEWEST: f64 = 4.0;

/// The mesh cycle of a contact, divided into stretches and cells. On a stretch the contact keeps its segment,
/// and no contact's line or gap jumps. A stretch has a whole number of equal cells. A cell is a window without a cut.
#[derive(Debug)]
pub struct Grid {
    /// Start of every cell \[s\], and the period.
    pub time: Vec<f64>,
    /// Stretch of every cell.
    pub stretch_of_cell: Vec<usize>,
    /// First cell after each stretch.
    pub stretch_end_cell: Vec<usize>,
    /// First cell after each stretch and after all following stretches with the same lines and gaps. Free
    /// flight does not distinguish these stretches.
    pub flight_end_cell: Vec<usize>,
    /// Segment of the contact on every stretch.
    pub segment_of_stretch: Vec<usize>,
    /// Whether a line or a gap changes at the start of a stretch, so that a contact may open or close there.
    pub turned: Vec<bool>,
    /// Length Δ of every stretch's cells \[s\].
    pub lengths: Vec<f64>,
}

/// A part of a mesh cycle on which a contact keeps its segment, and no contact's line or gap jumps.
struct GridSection {
    /// Mesh phase at its end.
    end: f64,
    /// Segment of the contact.
    segment: usize,
    /// Whether a line or a gap changes at its start, so that a contact may open or close there.
    turned: bool,
}

/// The stretches of a contact in a mesh cycle.
fn stretches(model: &Model, contact: usize, cycle: u64) -> Vec<GridSection> {
    let mesh_cycle = model.contacts[contact].cycle(cycle);
    let starts: Vec<f64> = mesh_cycle
        .segments
        .iter()
        .map(|segment| segment.start)
        .collect();
    let mut turns: Vec<f64> = Vec::new();
    for contact in &model.contacts {
        let segments = contact.cycle(cycle).segments.iter().enumerate();
        let turned = segments.filter(|(index, _)| model.changes_direction(contact, cycle, *index));
        turns.extend(turned.map(|(_, segment)| segment.start));
    }
    let near = |list: &[f64], phase: f64| list.iter().any(|p| (p - phase).abs() < SAME_PHASE);
    let apart = |phase: &&f64| !near(&starts, **phase);
    let mut all: Vec<f64> = starts
        .iter()
        .chain(turns.iter().filter(apart))
        .copied()
        .collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < SAME_PHASE);
    let ends = all.iter().skip(1).copied().chain([1.0]);
    (all.iter().zip(ends))
        .map(|(&start, end)| GridSection {
            end,
            segment: starts.partition_point(|s| *s < start + SAME_PHASE) - 1,
            turned: near(&turns, start),
        })
        .collect()
}

impl Grid {
    /// The grid of a contact in a mesh cycle. It has the fewest cells that the tolerance allows, or somewhat
    /// more cells of one length.
    pub fn new(model: &Model, tolerance: f64, contact: usize, cycle: u64) -> Self {
        let period = model.period();
        let stretches = stretches(model, contact, cycle);
        let ends: Vec<f64> = stretches.iter().map(|stretch| stretch.end).collect();
        let cells: Vec<_> = (cells(model, tolerance, &ends).into_iter())
            .map(|count| count as usize)
            .collect();
        let mut grid = Self {
            time: Vec::new(),
            stretch_of_cell: Vec::new(),
            stretch_end_cell: Vec::new(),
            flight_end_cell: Vec::new(),
            segment_of_stretch: stretches.iter().map(|stretch| stretch.segment).collect(),
            turned: stretches.iter().map(|stretch| stretch.turned).collect(),
            lengths: Vec::new(),
        };
        for (index, &count) in cells.iter().enumerate() {
            let start = if index == 0 { 0.0 } else { ends[index - 1] };
            let (start, end) = (period * start, period * ends[index]);
            let place = |cell: usize| start + (end - start) * (cell as f64 / count as f64);
            grid.time.extend((0..count).map(place));
            grid.stretch_of_cell.extend((0..count).map(|_| index));
            grid.stretch_end_cell.push(grid.stretch_of_cell.len());
            grid.lengths.push((end - start) / count as f64);
        }
        grid.time.push(period);
        grid.flight_end_cell = grid.stretch_end_cell.clone();
        for index in (1..cells.len()).rev() {
            if !stretches[index].turned {
                grid.flight_end_cell[index - 1] = grid.flight_end_cell[index];
            }
        }
        grid
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.stretch_of_cell.len()
    }

    /// The stretch of a cell; `None` at the end of the cycle.
    pub fn stretch_from(&self, cell: usize) -> Option<usize> {
        self.stretch_of_cell.get(cell).copied()
    }
}

/// Cells of a mesh cycle of the first contact. The number is a float because a slow cycle may need very many.
pub fn cells_needed(model: &Model, tolerance: f64) -> f64 {
    let stretches = stretches(model, 0, 0);
    let ends: Vec<f64> = stretches.iter().map(|stretch| stretch.end).collect();
    cells(model, tolerance, &ends).iter().sum()
}

/// Number of cells of each stretch, a whole number. `ends` are the mesh phases at which the stretches end.
fn cells(model: &Model, tolerance: f64, ends: &[f64]) -> Vec<f64> {
    let starts = || std::iter::once(&0.0).chain(ends);
    let fewest = fewest_windows(model, tolerance).max(FEWEST);
    let fitted: Vec<f64> = (starts().zip(ends))
        .map(|(start, end)| (fewest * (end - start)).ceil().max(1.0))
        .collect();
    let total: f64 = fitted.iter().sum();
    let period = model.period();
    let lengths = (starts().zip(ends).zip(&fitted))
        .map(|((start, end), count)| period * (end - start) / count);
    let few = distinct(lengths).0.len() <= MOST_LENGTHS;
    let most = if few { WORTH_SHARING * total } else { f64::INFINITY };
    let Some(parts) = equal_parts(ends, most.min(MOST_PARTS as f64) as usize) else {
        return fitted;
    };
    let parts = parts as f64;
    let cells = parts * (fewest / parts).ceil().max(1.0);
    if cells > most {
        return fitted;
    }
    let shared: Vec<f64> = (starts().zip(ends))
        .map(|(start, end)| (cells * (end - start)).round())
        .collect();
    // Breakpoints at a small distance may lie on one boundary.
    if shared.contains(&0.0) { fitted } else { shared }
}

/// The distinct lengths, and the index of each given length among them.
pub fn distinct(lengths: impl Iterator<Item = f64>) -> (Vec<f64>, Vec<usize>) {
    let mut distinct_lengths: Vec<f64> = Vec::new();
    let which = lengths
        .map(|length| {
            let same = |known: &f64| (known - length).abs() <= SAME_LENGTH * length;
            distinct_lengths.iter().position(same).unwrap_or_else(|| {
                distinct_lengths.push(length);
                distinct_lengths.len() - 1
            })
        })
        .collect();
    (distinct_lengths, which)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Division, Drive, FlankError, OperatingPoint, fixtures};

    fn model(mesh: Vec<Division>, speed: f64) -> Model {
        let structure = fixtures::structure(&[0.0, 9000.0], 0.01, &[1.0, 0.3], &[1.0, 0.3]);
        let drive = Drive {
            mesh,
            ..fixtures::two_level_mesh(1e-5)
        };
        Model::new(&structure, &drive, OperatingPoint { load: 0.1, speed }).unwrap()
    }

    /// Every stretch has a whole number of equal cells, and `cells_needed` predicts their total.
    #[test]
    fn cells_fill_their_stretches() {
        let uneven = 0.5f64.sqrt();
        let sixty: Vec<f64> = (0..60).map(|i| 3e8 + 1e6 * f64::from(i)).collect();
        for (levels, transitions) in [
            (&[4e8][..], &[][..]),
            (&[4e8, 3e8], &[0.6]),
            (&[4e8, 3e8, 3.5e8], &[0.2, uneven]),
            (&sixty, &[]),
        ] {
            for speed in [40.0, 300.0, 1200.0, 20_000.0] {
                let model = model(Division::levels(levels, transitions), speed);
                let grid = Grid::new(&model, f64::EPSILON, 0, 0);
                let count = grid.cells();
                assert_eq!(cells_needed(&model, f64::EPSILON), count as f64);
                assert_eq!((grid.time.len(), grid.time[0]), (count + 1, 0.0));
                assert_eq!(grid.time[count], model.period());
                // At least as many as the tolerance requires, and four; at most a quarter more.
                let fewest = fewest_windows(&model, f64::EPSILON).max(FEWEST);
                let most = 1.25 * (fewest + levels.len() as f64) + 1.0;
                assert!(
                    count as f64 >= fewest && count as f64 <= most,
                    "{count} {fewest}"
                );
                for (cell, &stretch) in grid.stretch_of_cell.iter().enumerate() {
                    let length = grid.time[cell + 1] - grid.time[cell];
                    assert!((length / grid.lengths[stretch] - 1.0).abs() < 1e-9);
                }
                for (stretch, &end) in grid.stretch_end_cell.iter().enumerate() {
                    let phase = model.first_cycle().segments[stretch].end;
                    assert!((grid.time[end] / model.period() - phase).abs() < 1e-15);
                    assert_eq!(grid.segment_of_stretch[stretch], stretch);
                    assert_eq!(grid.flight_end_cell[stretch], count);
                }
                assert_eq!(
                    (grid.stretch_from(0), grid.stretch_from(count)),
                    (Some(0), None)
                );
            }
        }
        let [slow, fast] = [1e-3, 10.0].map(|speed| {
            let model = model(Division::levels(&[4e8], &[]), speed);
            cells_needed(&model, f64::EPSILON)
        });
        assert!((slow / fast / 1e4 - 1.0).abs() < 0.2, "{slow} {fast}");
    }

    /// Free flight ends at steps of the gap, but not at steps of the stiffness.
    #[test]
    fn flight_ends_where_the_gap_changes() {
        let mut mesh = Division::levels(&[4e8, 3e8, 4e8, 3e8], &[]);
        mesh[2].error = FlankError::series([1e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let grid = Grid::new(&model(mesh, 1200.0), f64::EPSILON, 0, 0);
        assert_eq!(grid.turned, [false, false, true, true]);
        let ends = &grid.stretch_end_cell;
        assert_eq!(grid.flight_end_cell, [ends[1], ends[1], ends[2], ends[3]]);
    }

    /// Breakpoints that would lie on one boundary of equal parts still have a cell between them.
    #[test]
    fn no_stretch_is_without_a_cell() {
        for apart in [2e-11, 4e-10, 1e-8, 1e-6] {
            let mesh = Division::levels(&[4e8, 3e8, 2e8], &[0.6, 0.6 + apart]);
            let model = model(mesh, 1200.0);
            let grid = Grid::new(&model, f64::EPSILON, 0, 0);
            assert_eq!(grid.stretch_end_cell.len(), 3, "{apart}");
            assert!(grid.time.windows(2).all(|pair| pair[0] < pair[1]));
            let [before, within] = [0, 1].map(|stretch| grid.stretch_end_cell[stretch]);
            assert_eq!(within - before, 1, "{apart}");
        }
    }

    #[test]
    fn lengths_are_told_apart_beyond_rounding() {
        let lengths = [0.3, 0.1 + 0.2, 0.2, 0.2 * (1.0 + 1e-11), 0.3];
        let (distinct_lengths, which) = distinct(lengths.into_iter());
        assert_eq!((distinct_lengths.len(), which), (3, vec![0, 0, 1, 2, 0]));
    }
}
