//! How is a dry slider with its spring represented in a structure?

/// The three states of a dry slider in series with a spring, each a separate contact. Exactly one of them is closed.
///
/// The force of the element is `f = k (δ − s)` with the position s of its slider, but at most its limit F:
///
/// ```text
/// stick:  s' = 0                       until f = ±F
/// slip:   f = ±F,  s = δ ∓ F/k         until δ' changes its sign
/// ```
///
/// Source: Jenkins 1962; Iwan 1966 for several elements on one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum SliderPart {
    /// It slips while δ grows.
    Forwards,
    /// It slips while δ falls.
    Backwards,
    /// It sticks: its spring carries the force.
    Spring,
}

impl SliderPart {
    /// All parts in the order of their contacts, each with the end of its name.
    pub const ALL: [(Self, &'static str); 3] = [
        (Self::Forwards, "slip forwards"),
        (Self::Backwards, "slip backwards"),
        (Self::Spring, "stick"),
    ];
}
