//! How many trajectories of how many cycles are measured of a motion that does not settle.
//!
//! The constants are those under which the coverage of error bars was measured (docs/theory.md). A first
//! look after many cycles, and few looks, matter more than any condition on the record itself:
//! conditions that a record meets by chance select records without bursts.

use crate::analysis::config::{Effort, PointConfig};

/// Trajectories that a verified error bar takes.
const TRAJECTORIES: usize = 8;

/// Displacement of a trajectory where it branches off, in half gaps.
pub(super) const DISPLACEMENT: f64 = 1e-3;

/// Cycles between two branches, as a part of the cycles at the first look.
const GAPS: u64 = 40;

/// Cycles in which a branch parts from its pilot, as a part of a gap.
const PARTS: u64 = 5;

/// What is planned for a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// Trajectories.
    pub(super) trajectories: usize,
    /// Cycles of all trajectories at the first look; each later look comes at twice as many.
    pub(super) first: u64,
    /// Cycles of the pilot between two branches.
    pub(super) gap: u64,
    /// Cycles of a branch that are not measured.
    pub(super) part: u64,
    /// Most measured cycles of all trajectories.
    pub(super) budget: u64,
}

impl Plan {
    /// For the questions asked. Several trajectories only where the first look is within the budget, and
    /// something is averaged.
    pub(super) fn of(questions: &PointConfig) -> Self {
        let effort = questions.effort();
        let (first, budget) = (effort.first_look(), questions.cycles);
        let averages = questions.lyapunov.is_some() || questions.nvh.is_some();
        let several = effort == Effort::Verified && budget >= first && averages;
        let gap = first / GAPS;
        Self {
            trajectories: if several { TRAJECTORIES } else { 1 },
            first,
            gap,
            part: gap / PARTS,
            budget,
        }
    }

    /// Cycles of the pilot at which the others may branch off.
    pub(super) fn branching(&self) -> u64 {
        self.gap * (self.trajectories as u64 - 1)
    }
}
