//! What may end the state of a contact?

/// A direction of sliding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Way {
    Forwards,
    Backwards,
}

/// What may end a contact's state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Watched {
    /// Its deflection, at its surface.
    Deflection,
    /// The push of its spring and damper, at zero.
    Push,
    /// The velocity of its slider, at zero.
    Slide,
    /// Its depth, where the next layer of its film gives way to it.
    Depth,
    /// The force of a rigid stop, at zero.
    Hold,
    /// The force of dry friction that sticks, at its limit forwards and at that backwards.
    Limit(Way),
}
