//! In what groups do numbers lie?

/// Terms of every series on a window.
pub const TERMS: usize = 24;

/// A series on a window.
pub type Series = [f64; TERMS];

/// A series of a table, on cache lines of its own.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub Series);

impl Row {
    /// All zero.
    pub const ZERO: Self = Self([0.0; TERMS]);
}

/// Blocks carried side by side.
pub const LANES: usize = 8;

/// One lane group, on a cache line of its own: a vector load never straddles two.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self([0.0; LANES]);
}
