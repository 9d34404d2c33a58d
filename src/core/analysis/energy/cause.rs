//! Which causes do work on the vibration?

/// A cause of work on the vibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::analysis) enum Cause {
    /// Mean torques, torque ripple and other loads: `∫ T·u dt`.
    Loads,
    /// Prescribed changes of a contact's geometry: transmission error, flank error, half gap, load centroid.
    Error,
    /// Varying stiffness of contacts.
    Stiffness,
    /// Dampers of the contacts, springs released while compressed, and impacts on rigid stops.
    Contact,
    /// Damping of the structure, minus the input by its cross-coupled springs.
    Structure,
    /// Friction of the contacts at the speeds of vibration.
    Friction,
}

impl Cause {
    /// Number of causes.
    pub const COUNT: usize = 6;
}
