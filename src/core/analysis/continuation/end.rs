//! Why does a branch of orbits end?

use super::orbit::NoOrbit;

/// Reasons for the end of a branch.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The branch reaches the end of the parameter's interval.
    Interval,
    /// The branch returns to its first orbit.
    Closed,
    /// The branch merges into orbits of half its period, at their period doubling.
    Merged {
        /// Period of the orbits that the branch meets.
        period: u32,
    },
    /// The limit on the number of orbits is reached.
    Full,
    /// No orbit is found beyond, however small the step.
    Lost {
        /// The reason.
        reason: NoOrbit,
    },
    /// Every step is rejected, however small, although orbits are found. For example, the branch turns by more than the
    /// largest angle, or the orbits lie on another branch.
    Corner,
    /// The branch is followed in one direction only, and this is its first orbit.
    Start,
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Interval => f.write_str("the interval ends"),
            Self::Closed => f.write_str("back at the first orbit"),
            Self::Merged { period } => write!(f, "merges into the orbits of period {period}"),
            Self::Full => f.write_str("the limit of continuation.orbits is reached"),
            Self::Lost { reason } => write!(f, "no orbit beyond: {reason}"),
            Self::Corner => f.write_str("the curve has a corner that no step size resolves"),
            Self::Start => f.write_str("its first orbit"),
        }
    }
}
