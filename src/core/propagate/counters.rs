//! How much work did a kernel do?

/// Work done by a kernel. Tests snapshot it, so that a change of an algorithm becomes visible.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Mesh cycles integrated.
    pub cycles: u64,
    /// Windows (or steps) solved.
    pub windows: u64,
    /// Windows cut by an event or a breakpoint.
    pub partial_windows: u64,
    /// Checks in which bounds exclude an event without a search. A window has one, or one per line or contact.
    pub certified: u64,
    /// Series bisections while isolating roots.
    pub bisections: u64,
    /// Newton steps of root finding.
    pub newton_steps: u64,
    /// Contact-state changes.
    pub events: u64,
    /// Tangencies: a surface touched within round-off without crossing.
    pub grazings: u64,
    /// Moves of one tangent vector over a window or over a part of it.
    pub tangent_windows: u64,
    /// Windows in contact with a varying stiffness that is in no table.
    pub factorised: u64,
    /// Products of a dense operator with a state or tangent (only kernels with dense tables).
    pub matvecs: u64,
    /// Evaluations of a margin at one time (only kernels with dense tables).
    pub guard_evaluations: u64,
}

impl std::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.cycles += other.cycles;
        self.windows += other.windows;
        self.partial_windows += other.partial_windows;
        self.certified += other.certified;
        self.bisections += other.bisections;
        self.newton_steps += other.newton_steps;
        self.events += other.events;
        self.grazings += other.grazings;
        self.tangent_windows += other.tangent_windows;
        self.factorised += other.factorised;
        self.matvecs += other.matvecs;
        self.guard_evaluations += other.guard_evaluations;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_count_adds_to_its_own() {
        let counted = |times: u64| Counters {
            cycles: times,
            windows: 2 * times,
            partial_windows: 3 * times,
            certified: 4 * times,
            bisections: 5 * times,
            newton_steps: 6 * times,
            events: 7 * times,
            grazings: 8 * times,
            tangent_windows: 9 * times,
            factorised: 10 * times,
            matvecs: 11 * times,
            guard_evaluations: 12 * times,
        };
        let mut sum = counted(3);
        sum += counted(4);
        assert_eq!(sum, counted(7));
    }
}
