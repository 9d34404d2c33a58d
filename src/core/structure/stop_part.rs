//! Which contacts does a rigid stop have?

/// The two contacts of a rigid one-sided stop with a coefficient of restitution ε.
///
/// Newton's law of impact reverses the speed δ' of approach. If infinitely many impacts accumulate, the stop
/// then holds δ at its gap by a force λ that only pushes:
///
/// ```text
/// impact:  δ = b, δ' > 0:   δ' → −ε δ'
/// rest:    δ = b, δ' = 0    until λ = 0
/// ```
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum StopPart {
    /// The structure hits the stop. The contact closes and opens at the same instant.
    Impact {
        /// ε, from 0 to 1.
        restitution: f64,
    },
    /// The stop holds the structure.
    Rest,
}

impl StopPart {
    /// Suffix of the name of the second contact.
    pub const REST: &str = "rest";
}
