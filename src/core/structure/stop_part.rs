//! What is a rigid stop to a structure?

/// The two contacts of a rigid one-sided stop with a coefficient of restitution ε.
///
/// Newton's law of impact reverses the speed δ' of approach. Where impacts accumulate, the stop holds δ at its gap by a force
/// λ that pushes only:
///
/// ```text
/// impact:  δ = b, δ' > 0:   δ' → −ε δ'
/// rest:    δ = b, δ' = 0    until λ = 0
/// ```
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum StopPart {
    /// It is hit. The contact closes and opens at the same instant.
    Impact {
        /// ε, from 0 to 1.
        restitution: f64,
    },
    /// It holds the structure.
    Rest,
}

impl StopPart {
    /// What the name of the second contact ends in.
    pub const REST: &str = "rest";
}
