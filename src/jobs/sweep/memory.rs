//! How much memory a run takes at most, from what a few of its points took.

use crate::store::{GROUP_BYTES, GROUP_ROWS};
use serde::Serialize;

/// Most memory of a run, by what takes it \[bytes\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Memory {
    /// The program, structures and tables at hand, and what workers integrate with.
    pub work: u64,
    /// Finished points that wait for one before them.
    pub waiting: u64,
    /// Row groups of the result files that are not full.
    pub row_groups: u64,
}

/// A long run over a short one: memory that is free but in pieces.
const IN_PIECES: f64 = 1.25;

/// A row in memory over the same in the journal, where a small number takes a byte.
const UNPACKED: f64 = 2.0;

/// A row that is being encoded over the same in the journal: beside each number stand its places
/// in a dictionary and in a page.
const ENCODED: f64 = 4.0;

/// A row without lists in the journal \[bytes\].
const FIXED: f64 = 600.0;

/// A row of a table beside the points in the journal \[bytes\], at most.
const SIDE_ROW: f64 = 100.0;

/// What is kept of a measured cycle, until its point is finished, an estimate \[bytes\]: runs of
/// shipped manifests with a budget of 160 000 cycles hold 18 to 44 MB more than a plan that tries their points out.
const CYCLE: u64 = 300;

/// Cycles beyond which no growth is counted. Records of one trajectory do not grow from 10⁵ to 10⁷ cycles
/// (docs/robustness.md); where those of eight stop was not measured.
const JOINED: u64 = 160_000;

/// Most that is kept of so many measured cycles of a point \[bytes\].
pub(super) fn record_bytes(cycles: u64) -> u64 {
    CYCLE * cycles.min(JOINED)
}

/// What is known of the rows of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    /// How many points.
    pub points: u64,
    /// Most that wait for others.
    pub waiting: u64,
    /// Size of a row in the journal \[bytes\].
    pub row: f64,
    /// Of this, what goes to the table of points \[bytes\].
    pub own: f64,
    /// Tables beside that of points.
    pub beside: usize,
}

impl Memory {
    /// Of a run that took `peak` so far.
    pub(super) fn of(peak: u64, rows: Rows) -> Self {
        let (all, group_rows) = (rows.points as f64, GROUP_ROWS as f64);
        // A group is written when its rows or its lists are many.
        let most = GROUP_BYTES as f64 + group_rows * rows.own.min(FIXED);
        let points = (all.min(group_rows) * rows.own).min(most);
        let most = rows.beside as f64 * group_rows * SIDE_ROW;
        let beside = (all * (rows.row - rows.own)).min(most);
        Self {
            work: (IN_PIECES * peak as f64) as u64,
            waiting: (UNPACKED * rows.row * rows.points.min(rows.waiting) as f64) as u64,
            row_groups: (ENCODED * (points + beside)) as u64,
        }
    }

    /// All of it.
    pub fn total(&self) -> u64 {
        self.work + self.waiting + self.row_groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_ends_where_row_groups_do() {
        let of = |points, row, own| {
            let waiting = 4096;
            let beside = 1;
            Memory::of(
                1 << 20,
                Rows {
                    points,
                    waiting,
                    row,
                    own,
                    beside,
                },
            )
        };
        let few = of(80, 500.0, 400.0);
        assert_eq!((few.waiting, few.row_groups), (80_000, 160_000));
        let (many, more) = (of(1_000_000, 5e4, 2e4), of(100_000_000, 5e4, 2e4));
        assert_eq!(many, more, "however many points there are");
        assert!(
            many.row_groups < 16 * (GROUP_BYTES as u64),
            "however long their lists are"
        );
        assert_eq!(many.total(), many.work + many.waiting + many.row_groups);
    }
}
