//! Products of a table with several columns at once: the trajectory and its tangents meet the
//! same tables, and every number that is read serves all columns of a batch. Vectors of 8 hold the
//! sums of four columns; the narrower ones have registers for one.
//!
//! The sums of one column are taken in the same order in every batch: a trajectory has the same
//! bits whatever company it keeps.

use super::vectors::accumulate;
use super::{LANES, Lanes};
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::tables::Row;

/// Calls `$batch::<SET, COLUMNS>` for all columns, as many at a time as registers hold sums for; `$first` is the
/// first column of the batch.
macro_rules! in_batches {
    ($set:ident, $count:expr, |$first:ident| $batch:ident($($arg:expr),* $(,)?)) => {{
        let count = $count;
        let mut $first = 0;
        if $set == $crate::propagate::volterra::lanes::WIDE {
            while $first + 4 <= count {
                $batch::<$set, 4>($($arg),*);
                $first += 4;
            }
            if $first + 2 <= count {
                $batch::<$set, 2>($($arg),*);
                $first += 2;
            }
        }
        while $first < count {
            $batch::<$set, 1>($($arg),*);
            $first += 1;
        }
    }};
}
pub(super) use in_batches;

/// `Σ weights[c][i] rows[i]` for every column c; all lengths are the same even number.
#[inline(always)]
pub(super) fn combine<const SET: u8, const COLUMNS: usize>(
    rows: &[Row],
    weights: &[&[f64]; COLUMNS],
) -> [Row; COLUMNS] {
    let mut sums = [[[Lanes::ZERO; TERMS / LANES]; COLUMNS]; 2];
    accumulate::<SET, _, COLUMNS, _>(rows, weights, &mut sums);
    let mut out = [Row::ZERO; COLUMNS];
    for c in 0..COLUMNS {
        for g in 0..TERMS / LANES {
            for l in 0..LANES {
                out[c].0[g * LANES + l] = sums[0][c][g].0[l] + sums[1][c][g].0[l];
            }
        }
    }
    out
}

/// The series of a batch as weights.
#[inline(always)]
pub(super) fn series<const COLUMNS: usize>(rows: &[Row; COLUMNS]) -> [&[f64]; COLUMNS] {
    let mut out: [&[f64]; COLUMNS] = [&[]; COLUMNS];
    for c in 0..COLUMNS {
        out[c] = &rows[c].0;
    }
    out
}
