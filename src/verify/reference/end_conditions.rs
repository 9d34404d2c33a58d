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
    /// The deflection, where it reaches the surface of the contact.
    Deflection,
    /// The force of the spring and damper of the contact, at zero.
    Push,
    /// The speed of a slipping slider or of sliding dry friction, at zero.
    Slide,
    /// The depth of a passed layer of a film, at its boundary with the next layer.
    Depth,
    /// The force of a rigid stop, at zero.
    Hold,
    /// The force of sticking dry friction, at its forward or backward limit.
    Limit(SlidingDirection),
}
