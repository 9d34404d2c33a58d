//! Products of a table with several columns at once. The trajectory and its tangents use the same tables, and every
//! loaded number serves all columns of a batch. Vectors of 8 hold the sums of four columns; narrower ones have
//! registers for one.
//!
//! The sums of one column are formed in the same order in every batch, so the bits of a trajectory do not depend on
//! its tangents.

use crate::propagate::vectors::Vector;
use crate::propagate::volterra::shapes::{LANES, Lanes, Row, TERMS};

/// Calls `$batch::<V, COLUMNS>` for all columns, as many at a time as registers can hold sums for; `$first` is the
/// first column of the batch.
macro_rules! in_batches {
    ($vector:ident, $count:expr, |$first:ident| $batch:ident($($arg:expr),* $(,)?)) => {{
        let count = $count;
        let mut $first = 0;
        if $vector::WIDE {
            while $first + 4 <= count {
                $batch::<$vector, 4>($($arg),*);
                $first += 4;
            }
            if $first + 2 <= count {
                $batch::<$vector, 2>($($arg),*);
                $first += 2;
            }
            if $first < count {
                $batch::<$vector, 1>($($arg),*);
            }
        } else {
            while $first < count {
                $batch::<$vector, 1>($($arg),*);
                $first += 1;
            }
        }
    }};
}
pub(super) use in_batches;

/// Lane groups of a row.
pub(super) const GROUPS: usize = TERMS / LANES;

/// The sums of a batch: two per column, of the even and of the odd rows, each of `G` lane groups. Two independent
/// sums hide the latency of the multiply-add.
pub(super) type Sums<V, const G: usize, const COLUMNS: usize> = [[[V; G]; COLUMNS]; 2];

/// `Σ weights[c][i] rows[i]` for every column c; all lengths are the same even number.
#[inline(always)]
pub(super) fn combine<V: Vector, const COLUMNS: usize>(
    rows: &[Row],
    weights: &[&[f64]; COLUMNS],
) -> [Row; COLUMNS] {
    for weights in weights {
        assert_eq!(weights.len(), rows.len());
    }
    let mut sums = [[[V::zero(); GROUPS]; COLUMNS]; 2];
    for (i, pair) in rows.chunks_exact(2).enumerate() {
        for way in 0..2 {
            let mut row = [V::zero(); GROUPS];
            for g in 0..GROUPS {
                row[g] = V::read(&pair[way].0[g * LANES..]);
            }
            for c in 0..COLUMNS {
                let weight = V::splat(weights[c][2 * i + way]);
                for g in 0..GROUPS {
                    sums[way][c][g] = row[g].multiply_add(weight, sums[way][c][g]);
                }
            }
        }
    }
    let mut out = [Row::ZERO; COLUMNS];
    for c in 0..COLUMNS {
        for g in 0..GROUPS {
            let sum = sums[0][c][g].plus(sums[1][c][g]);
            sum.write(&mut out[c].0[g * LANES..]);
        }
    }
    out
}

/// `sums[k % 2][c] += weights[c][k] terms[k]` for all terms, an even number of them, each two lane
/// groups.
#[inline(always)]
pub(super) fn add_terms<V: Vector, const COLUMNS: usize>(
    terms: &[[Lanes; 2]],
    weights: &[&Row; COLUMNS],
    sums: &mut Sums<V, 2, COLUMNS>,
) {
    for (k, pair) in terms.chunks_exact(2).take(TERMS / 2).enumerate() {
        for way in 0..2 {
            let term = [V::read(&pair[way][0].0), V::read(&pair[way][1].0)];
            for c in 0..COLUMNS {
                let weight = V::splat(weights[c].0[2 * k + way]);
                for i in 0..2 {
                    sums[way][c][i] = term[i].multiply_add(weight, sums[way][c][i]);
                }
            }
        }
    }
}

/// The rows of a batch as slices, the form of the weights of [`combine`].
#[inline(always)]
pub(super) fn series<const COLUMNS: usize>(rows: &[Row; COLUMNS]) -> [&[f64]; COLUMNS] {
    let mut out: [&[f64]; COLUMNS] = [&[]; COLUMNS];
    for c in 0..COLUMNS {
        out[c] = &rows[c].0;
    }
    out
}

/// The two components of a chunk of blocks.
#[inline(always)]
pub(super) fn load<V: Vector>(x: &[f64], padded: usize, chunk: usize) -> [V; 2] {
    [
        V::read(&x[chunk * LANES..]),
        V::read(&x[padded + chunk * LANES..]),
    ]
}

/// Sets the two components of a chunk of blocks.
#[inline(always)]
pub(super) fn store<V: Vector>(x: &mut [f64], padded: usize, chunk: usize, from: [V; 2]) {
    from[0].write(&mut x[chunk * LANES..]);
    from[1].write(&mut x[padded + chunk * LANES..]);
}
