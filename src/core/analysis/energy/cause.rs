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
    /// Dampers of the contacts, springs released while compressed, slipping dry sliders, and impacts on rigid stops.
    Contact,
    /// Damping and cross-coupled springs of the structure.
    Structure,
    /// Friction on the flanks at the speeds of vibration, and dry friction.
    Friction,
}

impl Cause {
    /// Number of causes.
    pub const COUNT: usize = 6;
}
