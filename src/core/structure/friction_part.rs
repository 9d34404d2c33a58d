//! Which states does dry friction without a spring have?

/// The three states of an element of dry friction, each a separate contact. Exactly one of them is closed.
///
/// The surface that the element rubs against moves at a constant speed u along the line. With v = δ' − u,
///
/// ```text
/// slip:   v ≠ 0   f = F sgn v                    until v = 0
/// stick:  v = 0   f = λ, which keeps δ' = u      until |λ| > F_s
/// ```
///
/// F is the force of sliding friction, F_s ≥ F that of static friction. Source: Den Hartog 1931.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum FrictionPart {
    /// It slips with v > 0: δ grows faster than the surface moves.
    Forwards,
    /// It slips with v < 0.
    Backwards,
    /// It sticks.
    Stick {
        /// F_s \[N\].
        static_force: f64,
        /// u \[m/s\].
        belt_speed: f64,
    },
}
