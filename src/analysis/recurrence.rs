//! Does the motion repeat?
//!
//! Strobe states of the last mesh cycles are kept; the shortest period is sought for which
//! a whole stretch of them comes back, in the energy norm without the neutral pair.
//!
//! No motion repeats sooner than what drives it: torque ripple of a shaft order comes back
//! after as many mesh cycles as the shaft has teeth, of both shafts after their common
//! multiple.

use super::norm::EnergyNorm;
use crate::model::Model;

/// Longest period looked for, in mesh cycles, unless the excitation itself is longer.
const LONGEST_PERIOD: usize = 32;

/// Longest period of an excitation that is waited for, in mesh cycles.
const LONGEST_EXCITATION: usize = 1024;

/// Turns \[1\] by which a ripple's phase may miss a whole number and still count as repeating.
const PHASE_TOLERANCE: f64 = 1e-9;

/// Return distance, in units of the half gap, below which a motion counts as repeating.
/// A slow decay rate λ leaves an error of this over |λ|.
pub const TOLERANCE: f64 = 1e-10;

/// Strobe states of the last cycles.
#[derive(Debug, Clone)]
pub struct Recurrence {
    longest: usize,
    excitation_repeats: bool,
    /// A stretch as long as the longest period, and its image.
    kept: usize,
    states: Vec<Vec<f64>>,
    next: usize,
}

impl Recurrence {
    /// No states yet; how long a period is looked for depends on the model's excitation.
    pub fn new(model: &Model) -> Self {
        let excitation = excitation_period(model);
        let longest = LONGEST_PERIOD.max(excitation.unwrap_or(1));
        Self {
            longest,
            excitation_repeats: excitation.is_some(),
            kept: 2 * longest + 1,
            states: Vec::new(),
            next: 0,
        }
    }

    /// Longest period looked for, in mesh cycles.
    pub fn longest(&self) -> usize {
        self.longest
    }

    /// Whether what drives the motion repeats within the longest period; if not, the motion
    /// cannot.
    pub fn excitation_repeats(&self) -> bool {
        self.excitation_repeats
    }

    /// Notes the state at the end of a cycle.
    pub fn push(&mut self, state: &[f64]) {
        if self.states.len() < self.kept {
            self.states.push(state.to_vec());
        } else {
            self.states[self.next].copy_from_slice(state);
        }
        self.next = (self.next + 1) % self.kept;
    }

    /// The state `back` cycles ago.
    fn past(&self, back: usize) -> &[f64] {
        let newest = self.next + self.kept - 1;
        &self.states[(newest - back) % self.kept]
    }

    /// The shortest period that repeats to [`TOLERANCE`], if the store is full.
    pub fn period(&self, norm: &EnergyNorm) -> Option<u32> {
        if self.states.len() < self.kept {
            return None;
        }
        let close = |back: usize, period: usize| {
            norm.distance(self.past(back), self.past(back + period)) <= TOLERANCE * norm.unit()
        };
        (1..=self.longest)
            .find(|&period| (0..self.longest).all(|back| close(back, period)))
            .map(|period| period as u32)
    }

    /// The smallest distance, in units of the half gap, between the newest state and an
    /// earlier one kept.
    pub fn closest_return(&self, norm: &EnergyNorm) -> Option<f64> {
        (1..self.states.len().min(self.longest + 1))
            .map(|back| norm.distance(self.past(0), self.past(back)) / norm.unit())
            .min_by(f64::total_cmp)
    }
}

/// Mesh cycles after which all torque ripple starts anew; none where that takes too long or
/// never happens. The transmission error repeats every cycle.
fn excitation_period(model: &Model) -> Option<usize> {
    (1..=LONGEST_EXCITATION).find(|&period| {
        model.ripple.iter().all(|ripple| {
            let turns = ripple.turns_per_cycle * period as f64;
            (turns - turns.round()).abs() < PHASE_TOLERANCE
        })
    })
}
