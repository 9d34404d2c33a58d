//! Sizes and alignment of series and lane groups.

use crate::numerics::legendre::transforms24;
use std::sync::OnceLock;

/// Terms of every series on a window.
pub const TERMS: usize = 24;

/// A series on a window.
pub type Series = [f64; TERMS];

/// A series in a table, aligned to cache lines.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub Series);

impl Row {
    /// All zero.
    pub const ZERO: Self = Self([0.0; TERMS]);
}

/// Number of blocks that one vector operation processes.
pub const LANES: usize = 8;

/// One lane group, aligned to a cache line, so that a vector load never spans two lines.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self([0.0; LANES]);
}

/// Row j is the Legendre series of the polynomial that is 1 at node j of [`transforms24`] and 0 at its other
/// nodes.
pub fn interpolation() -> &'static [Row; TERMS] {
    static ROWS: OnceLock<[Row; TERMS]> = OnceLock::new();
    ROWS.get_or_init(|| {
        std::array::from_fn(|node| {
            let mut values = [0.0; TERMS];
            values[node] = 1.0;
            Row(transforms24().interpolate(&values))
        })
    })
}
