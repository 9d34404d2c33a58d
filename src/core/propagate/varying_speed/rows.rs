//! Per-block numbers as rows of lanes.

use crate::propagate::vectors::{Aligned, LANES};

/// Pairs of numbers, one pair per block, as two rows of lanes.
pub type Rows = [Aligned; 2];

/// Pairs as rows.
pub fn rows(pairs: impl ExactSizeIterator<Item = [f64; 2]>) -> Rows {
    let padded = pairs.len().next_multiple_of(LANES);
    let mut rows = [0, 1].map(|_| Aligned::zeros(padded));
    for (i, [first, second]) in pairs.enumerate() {
        (rows[0][i], rows[1][i]) = (first, second);
    }
    rows
}
