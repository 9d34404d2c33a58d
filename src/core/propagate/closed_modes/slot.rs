//! A system of a kernel with all data that depend on the operating point.

use super::basis::Basis;
use super::series::Series;
use super::system::System;
use std::sync::{Arc, OnceLock};

/// A system with its coordinates and tables at an operating point.
#[derive(Debug)]
pub struct Slot<'m> {
    /// State of each contact.
    pub states: Vec<usize>,
    /// Its coordinates.
    pub basis: Arc<Basis<'m>>,
    /// Tables that advance the coordinates of `basis`.
    pub system: System,
    /// Series of the deflections along each line on a block, if windows are shown.
    pub series: OnceLock<Vec<Series>>,
}
