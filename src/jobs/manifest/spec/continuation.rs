//! What orbits are followed over, and how.

use crate::analysis::continuation::explore::GivenState;

/// What `[continuation]` asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuationSpec {
    /// The axis that orbits are followed over, an index into [`Job::axes`](crate::manifest::Job::axes).
    pub over: usize,
    /// The axis that bifurcations are followed over besides.
    pub second: Option<usize>,
    /// Whether bifurcations of unstable orbits are followed over both axes, too.
    pub all_curves: bool,
    /// Values of the axis at which orbits are sought.
    pub starts: usize,
    /// Cycles before returns are looked at.
    pub transient: u64,
    /// Cycles among which they are looked for.
    pub cycles: u64,
    /// Longest period \[mesh cycles\].
    pub longest_period: u32,
    /// Newton searches for each period.
    pub guesses: usize,
    /// Most orbits of a branch, either way.
    pub orbits: usize,
    /// Most branches for each combination of the other axes.
    pub branches: usize,
    /// Longest step, as a part of the axis's length.
    pub step: f64,
    /// States to begin with.
    pub states: Vec<GivenState>,
}
