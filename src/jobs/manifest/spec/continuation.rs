//! Parameters and settings for following orbits.

use crate::analysis::continuation::explore::GivenState;

/// The contents of `[continuation]`.
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuationSpec {
    /// The axis that orbits are followed over, an index into [`Job::axes`](crate::manifest::Job::axes).
    pub over: usize,
    /// A second axis over which bifurcations are followed.
    pub second: Option<usize>,
    /// Whether bifurcations of unstable orbits are followed over both axes, too.
    pub all_curves: bool,
    /// Number of values of the axis at which orbits are searched for.
    pub starts: usize,
    /// Cycles before the search for returns.
    pub transient: u64,
    /// Cycles of the search for returns.
    pub cycles: u64,
    /// Largest period of an orbit that is searched for \[mesh cycles\].
    pub longest_period: u32,
    /// Number of Newton searches for each period.
    pub guesses: usize,
    /// Largest number of orbits of a branch, in each direction.
    pub orbits: usize,
    /// Largest number of branches for each combination of the other axes.
    pub branches: usize,
    /// Largest step along a branch, as a fraction of the axis's length.
    pub step: f64,
    /// Given states near orbits, from which branches start.
    pub states: Vec<GivenState>,
}
