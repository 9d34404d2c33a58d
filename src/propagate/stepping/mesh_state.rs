//! What do the contacts look like at one instant?

use crate::model::MOST_CONTACTS;

/// What a contact looks like at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeshState {
    pub time: f64,
    pub deflection: f64,
    pub rate: f64,
    /// Gap \[m\] and its rate \[m/s\].
    pub gap: [f64; 2],
}

/// All contacts at one instant, in order.
pub(super) type MeshStates = [MeshState; MOST_CONTACTS];
