//! A system of a kernel with all that its operating point makes of it.

use super::basis::Basis;
use super::series::Series;
use super::system::System;
use std::sync::{Arc, OnceLock};

/// A system at an operating point.
#[derive(Debug)]
pub struct Slot<'m> {
    /// State of each contact.
    pub states: Vec<usize>,
    /// Its coordinates.
    pub basis: Arc<Basis<'m>>,
    /// How they move.
    pub system: System,
    /// Series of what it sees along each line on a block, where windows are shown.
    pub series: OnceLock<Vec<Series>>,
}
