//! Which part of a trajectory is crossed in one step, and where does it end early?

use crate::model::ActiveSet;

/// A part of a trajectory in one contact state.
#[derive(Debug, Clone, Copy)]
pub struct StatePart {
    /// Cell in which it starts.
    pub cell: usize,
    /// Contact state.
    pub contact: ActiveSet,
    /// Duration \[s\].
    pub duration: f64,
    /// Whether the part is a whole cell.
    pub whole: bool,
    /// The contact that opened or closed at its start.
    pub crossed: Option<usize>,
    /// Round-off of δ \[m\].
    pub noise: f64,
}

/// The first event of a stretch.
#[derive(Debug, Clone, Copy)]
pub struct Exit {
    /// Time since the start of the stretch \[s\].
    pub time: f64,
    /// The contact that opens or closes.
    pub contact: usize,
}
