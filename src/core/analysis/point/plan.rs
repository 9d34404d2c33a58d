//! How many trajectories of a motion that does not settle are measured, and over how many cycles?
//!
//! The coverage of error bars was measured with these constants (docs/theory/exponents.md). A late first look and few
//! looks matter more than conditions on the record itself. A record that meets such conditions by chance is
//! probably a record without bursts.

use crate::analysis::config::{Effort, PointConfig};

/// Number of trajectories for a verified error bar.
const TRAJECTORIES: usize = 8;

/// Displacement of a new branch, in half gaps.
pub(super) const DISPLACEMENT: f64 = 1e-3;

/// Number of intervals between branches within the cycles at the first look.
const GAPS: u64 = 40;

/// Cycles of the pilot between two branches, divided by the discarded cycles of a branch.
const GAP_OVER_PART: u64 = 5;

/// The plan of a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// Number of trajectories.
    pub(super) trajectories: usize,
    /// Cycles of all trajectories at the first look; each later look follows at twice as many.
    pub(super) first: u64,
    /// Cycles of the pilot between two branches.
    pub(super) gap: u64,
    /// Discarded cycles of a branch, in which it separates from the pilot.
    pub(super) part: u64,
    /// Maximum number of measured cycles of all trajectories.
    pub(super) budget: u64,
}

impl Plan {
    /// The plan for the requested analyses. There are several trajectories only if the first look is within the
    /// budget and exponents or NVH statistics are requested.
    pub(super) fn of(config: &PointConfig) -> Self {
        let effort = config.effort();
        let (first, budget) = (effort.first_look(), config.cycles);
        let averages = config.lyapunov.is_some() || config.nvh.is_some();
        let several = effort == Effort::Verified && budget >= first && averages;
        let gap = first / GAPS;
        Self {
            trajectories: if several { TRAJECTORIES } else { 1 },
            first,
            gap,
            part: gap / GAP_OVER_PART,
            budget,
        }
    }

    /// Cycles of the pilot after which the others may branch off.
    pub(super) fn branching(&self) -> u64 {
        self.gap * (self.trajectories as u64 - 1)
    }
}
