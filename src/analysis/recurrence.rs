//! Does the motion repeat?
//!
//! Strobe states of the last mesh cycles are kept; the shortest period is sought for which
//! a whole stretch of them comes back, in the energy norm without the neutral pair.

use super::norm::EnergyNorm;

/// Longest period looked for, in mesh cycles.
pub const LONGEST_PERIOD: usize = 32;

/// Return distance, in units of the half gap, below which a motion counts as repeating.
/// A slow decay rate λ leaves an error of this over |λ|.
pub const TOLERANCE: f64 = 1e-10;

/// Strobe states of the last cycles.
#[derive(Debug, Clone, Default)]
pub struct Recurrence {
    states: Vec<Vec<f64>>,
    next: usize,
}

impl Recurrence {
    /// States kept: a stretch as long as the longest period, and its image.
    const KEPT: usize = 2 * LONGEST_PERIOD + 1;

    /// Notes the state at the end of a cycle.
    pub fn push(&mut self, state: &[f64]) {
        if self.states.len() < Self::KEPT {
            self.states.push(state.to_vec());
        } else {
            self.states[self.next].copy_from_slice(state);
        }
        self.next = (self.next + 1) % Self::KEPT;
    }

    /// The state `back` cycles ago.
    fn past(&self, back: usize) -> &[f64] {
        let newest = self.next + Self::KEPT - 1;
        &self.states[(newest - back) % Self::KEPT]
    }

    /// The shortest period that repeats to [`TOLERANCE`], if the store is full.
    pub fn period(&self, norm: &EnergyNorm) -> Option<u32> {
        if self.states.len() < Self::KEPT {
            return None;
        }
        let close = |back: usize, period: usize| {
            norm.distance(self.past(back), self.past(back + period)) <= TOLERANCE * norm.unit()
        };
        (1..=LONGEST_PERIOD)
            .find(|&period| (0..LONGEST_PERIOD).all(|back| close(back, period)))
            .map(|period| period as u32)
    }

    /// The smallest distance, in units of the half gap, between the newest state and an
    /// earlier one kept.
    pub fn closest_return(&self, norm: &EnergyNorm) -> Option<f64> {
        (1..self.states.len().min(LONGEST_PERIOD + 1))
            .map(|back| norm.distance(self.past(0), self.past(back)) / norm.unit())
            .min_by(f64::total_cmp)
    }
}
