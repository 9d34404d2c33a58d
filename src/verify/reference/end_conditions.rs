//! Which quantities may end the state of a contact?

/// A direction of sliding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SlidingDirection {
    Forwards,
    Backwards,
}

/// A quantity that may end the state of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum EndCondition {
    /// Its deflection, at its surface.
    Deflection,
    /// The force of its spring and damper, at zero.
    Push,
    /// The velocity of its slider, at zero.
    Slide,
    /// Its depth, where the next layer of its film replaces it.
    Depth,
    /// The force of a rigid stop, at zero.
    Hold,
    /// The force of sticking dry friction, at its forward or backward limit.
    Limit(SlidingDirection),
}
