//! What is to be passed in one go, and where it ends before its time?

use crate::model::{Contact, Surface};

/// A stretch of one contact state to be passed.
#[derive(Debug, Clone, Copy)]
pub struct Stretch {
    /// Cell in which it starts.
    pub cell: usize,
    /// Contact state.
    pub contact: Contact,
    /// Length \[s\].
    pub duration: f64,
    /// Whether it is the whole cell.
    pub whole: bool,
    /// Surface just crossed, when an event happened at its start.
    pub crossed: Option<Surface>,
    /// Round-off of δ \[m\].
    pub noise: f64,
}

/// The first event of a stretch.
#[derive(Debug, Clone, Copy)]
pub struct Exit {
    /// Time since the start of the stretch \[s\].
    pub time: f64,
    /// Surface crossed.
    pub surface: Surface,
}
