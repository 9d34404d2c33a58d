//! What does work on the vibration?

/// What does work on the vibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::analysis) enum Cause {
    /// Mean torques, torque ripple and other loads: `∫ T·u dt`.
    Loads,
    /// What is prescribed of the length of contacts: transmission error, half gap, load centroid.
    Error,
    /// Stiffness of contacts that varies.
    Stiffness,
    /// Dampers of the contacts, and springs that are let go compressed.
    Contact,
    /// Damping of the structure, less what its cross-coupled springs feed.
    Structure,
    /// Friction of the contacts, by the speeds of vibration.
    Friction,
}

impl Cause {
    /// How many there are.
    pub const COUNT: usize = 6;
}
