//! What are a dry slider and its spring to a structure?

/// The three states of a dry slider in series with a spring, each a contact of its own. Exactly one of them is closed.
///
/// The element bears `f = k (δ − s)` with the place s of its slider, but never more than its limit F:
///
/// ```text
/// stick:  s' = 0                       until f = ±F
/// slip:   f = ±F,  s = δ ∓ F/k         until δ' changes its sign
/// ```
///
/// Source: Jenkins 1962; Iwan 1966 for several elements on one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum SliderPart {
    /// It slips in the direction in which δ grows.
    Forwards,
    /// It slips in the other direction.
    Backwards,
    /// It sticks: its spring bears.
    Spring,
}

impl SliderPart {
    /// All parts in the order of their contacts, each with what its name ends in.
    pub const ALL: [(Self, &'static str); 3] = [
        (Self::Forwards, "slip forwards"),
        (Self::Backwards, "slip backwards"),
        (Self::Spring, "stick"),
    ];
}
