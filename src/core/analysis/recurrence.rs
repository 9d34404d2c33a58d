//! Does the motion repeat?
//!
//! The strobe states of the last mesh cycles are kept. The period is the shortest one after which a whole
//! stretch of them returns, in the energy norm without the neutral pair.
//!
//! No motion repeats sooner than its excitation. Torque ripple of a shaft order repeats after as many mesh
//! cycles as the shaft has teeth. Ripple of both shafts repeats after the common multiple. The period of
//! the motion is a multiple of this.

use super::norm::EnergyNorm;
use crate::model::Model;

/// Every period up to this number of mesh cycles is tried, and a return is checked over as many cycles. If
/// the excitation's period is longer, it replaces this number.
const LONGEST_TRIED: usize = 32;

/// Longest period of a motion, and longest period of an excitation, in mesh cycles.
const LONGEST: usize = 1024;

/// Largest distance of the turns of a ripple from a whole number at which the ripple counts as repeated
/// \[1\].
const PHASE_TOLERANCE: f64 = 1e-9;

/// Return distance, in units of the half gap, below which a motion repeats. With a slow decay rate λ, the
/// state can still differ from the orbit by this distance divided by |λ|.
pub const TOLERANCE: f64 = 1e-10;

/// Return distance, in units of the half gap, below which a shorter period is accepted as that of the motion.
/// A decaying oscillation with angle θ per cycle returns closest after a lag k with kθ near a whole turn. The
/// orbit that it approaches may have a shorter period. Different points of an orbit are much further apart
/// than this distance.
const SAME_POINT: f64 = 1e-7;

/// Distance of a return after a longer lag, relative to that of the closest return after a short lag, below
/// which the longer lag may be the period. Otherwise it is only a repetition of the shorter lag.
const MUCH_CLOSER: f64 = 1e-3;

/// Strobe states of the last cycles.
#[derive(Debug, Clone)]
pub struct Recurrence {
    /// Every period up to this is tried; beyond it, multiples of the excitation's period.
    longest_tried: usize,
    excitation: usize,
    excitation_repeats: bool,
    /// Maximum number of kept states: one more than two of the longest periods.
    kept: usize,
    /// The states, one after another.
    states: Vec<f64>,
    /// Length of a state.
    length: usize,
    next: usize,
}

impl Recurrence {
    /// An empty record of states. The longest period that is always tried depends on the model's excitation.
    pub fn new(model: &Model) -> Self {
        let excitation = excitation_period(model);
        Self {
            longest_tried: LONGEST_TRIED.max(excitation.unwrap_or(1)),
            excitation: excitation.unwrap_or(1),
            excitation_repeats: excitation.is_some(),
            kept: 2 * LONGEST + 1,
            states: Vec::new(),
            length: 2 * model.modes(),
            next: 0,
        }
    }

    /// Longest period that is tried, in mesh cycles: at least `longest_tried`, otherwise the longest one that the
    /// available states cover twice.
    pub fn longest(&self) -> usize {
        let seen = (self.count().saturating_sub(1) / 2).min(LONGEST);
        self.longest_tried
            .max(seen / self.excitation * self.excitation)
    }

    /// Period of the excitation, in mesh cycles; `None` if it is above 1024 or does not exist.
    pub fn excitation(&self) -> Option<u32> {
        self.excitation_repeats.then_some(self.excitation as u32)
    }

    /// Whether the excitation repeats within the longest period; otherwise the motion cannot repeat.
    pub fn excitation_repeats(&self) -> bool {
        self.excitation_repeats
    }

    /// Records the state at the end of a cycle.
    pub fn push(&mut self, state: &[f64]) {
        if self.count() < self.kept {
            self.states.extend_from_slice(state);
        } else {
            self.states[self.next * self.length..][..self.length].copy_from_slice(state);
        }
        self.next = (self.next + 1) % self.kept;
    }

    /// Number of states.
    pub fn count(&self) -> usize {
        self.states.len() / self.length
    }

    fn state(&self, place: usize) -> &[f64] {
        &self.states[place * self.length..][..self.length]
    }

    /// The states kept, the oldest first.
    pub fn states(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        let count = self.count();
        let oldest = self.next % count.max(1);
        (0..count).map(move |i| self.state((oldest + i) % count))
    }

    /// The state `back` cycles ago.
    fn past(&self, back: usize) -> &[f64] {
        let newest = self.next + self.kept - 1;
        self.state((newest - back) % self.kept)
    }

    /// The period of the motion, once the motion repeats to [`TOLERANCE`] over a long enough stretch. The
    /// stretch is as long as `longest_tried`, or as the period itself if that is longer.
    pub fn period(&self, norm: &EnergyNorm) -> Option<u32> {
        if self.count() < 2 * self.longest_tried + 1 {
            return None;
        }
        let repeats = |period: usize, tolerance: f64| {
            (0..self.longest_tried.max(period)).all(|back| {
                let limit = tolerance * norm.unit();
                norm.is_within(limit, self.past(back), self.past(back + period))
            })
        };
        let beyond =
            (self.longest_tried / self.excitation + 1..).map(|times| times * self.excitation);
        let shortest = (1..=self.longest_tried)
            .chain(beyond.take_while(|&period| period <= self.longest()))
            .find(|&period| repeats(period, TOLERANCE))?;
        (1..=shortest)
            .find(|&period| shortest.is_multiple_of(period) && repeats(period, SAME_POINT))
            .map(|period| period as u32)
    }

    /// Periods that justify a Newton search from the newest state. If a return is closer than `nearest` half
    /// gaps, its lag, the excitation's period and twice this period are candidates. The latter two are tried
    /// because a decaying oscillation can return closest at a lag longer than the period of its orbit. A lag
    /// above `longest_tried` is a candidate if its return is [`MUCH_CLOSER`].
    pub fn candidates(&self, norm: &EnergyNorm, nearest: f64) -> Vec<u32> {
        if !self.excitation_repeats {
            return Vec::new();
        }
        let known = self.count().saturating_sub(1);
        let distance_after = |lag: usize| norm.distance(self.past(0), self.past(lag)) / norm.unit();
        let closest = (1..=known.min(self.longest_tried))
            .filter(|lag| lag.is_multiple_of(self.excitation))
            .min_by(|a, b| distance_after(*a).total_cmp(&distance_after(*b)));
        let Some(closest) = closest else {
            return Vec::new();
        };
        let much_closer = MUCH_CLOSER * distance_after(closest).min(nearest) * norm.unit();
        let beyond = (self.longest_tried + 1..=known.min(LONGEST))
            .filter(|lag| lag.is_multiple_of(self.excitation))
            .find(|lag| norm.is_within(much_closer, self.past(0), self.past(*lag)));
        let mut candidates = Vec::new();
        if distance_after(closest) <= nearest {
            candidates.extend([self.excitation, 2 * self.excitation, closest]);
        }
        candidates.extend(beyond);
        candidates.sort_unstable();
        candidates.dedup();
        candidates.into_iter().map(|lag| lag as u32).collect()
    }

    /// The smallest distance, in units of the half gap, of the newest state from one of the [`Self::longest`] states
    /// before it.
    pub fn closest_return(&self, norm: &EnergyNorm) -> Option<f64> {
        (1..self.count().min(self.longest() + 1))
            .map(|back| norm.distance(self.past(0), self.past(back)) / norm.unit())
            .min_by(f64::total_cmp)
    }
}

/// The base period: mesh cycles after which all torque ripple, all errors and all contacts repeat; `None` if
/// it exceeds 1024 or does not exist.
pub fn excitation_period(model: &Model) -> Option<usize> {
    let ripples = model.ripple.iter().map(|ripple| ripple.turns_per_cycle);
    let errors = model.transmission_errors().map(|h| h.turns_per_cycle);
    let turns: Vec<f64> = ripples.chain(errors).collect();
    (1..=LONGEST).find(|&period| {
        let whole = |turns: &f64| {
            let turns = turns * period as f64;
            (turns - turns.round()).abs() < PHASE_TOLERANCE
        };
        period.is_multiple_of(model.base_cycles()) && turns.iter().all(whole)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::OperatingPoint;
    use crate::model::fixtures::{constant_mesh, one_mode};
    use crate::structure::ModalStructure;

    fn model() -> Model {
        let structure = ModalStructure {
            teeth: 20,
            damping: vec![0.1],
            ..one_mode(1.0)
        };
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        Model::new(&structure, &constant_mesh(1.0, 1.0), point).unwrap()
    }

    fn period(cycles: usize, state: impl Fn(f64) -> [f64; 2]) -> Option<u32> {
        let mut recurrence = Recurrence::new(&model());
        for n in 0..cycles {
            recurrence.push(&state(n as f64));
        }
        recurrence.period(&EnergyNorm::new(&model()))
    }

    #[test]
    fn short_periods_are_told_apart_and_irrational_ones_have_none() {
        for k in [1.0, 2.0, 3.0, 7.0, 32.0] {
            let turn = std::f64::consts::TAU / k;
            let found = period(100, |n| [(turn * (n % k)).cos(), (turn * (n % k)).sin()]);
            assert_eq!(found, Some(k as u32));
        }
        assert_eq!(period(100, |n| [n.sin(), n.cos()]), None);
        // Too few cycles.
        assert_eq!(period(64, |_| [1.0, 0.0]), None);
    }

    #[test]
    fn a_decaying_oscillation_is_given_the_period_of_its_orbit() {
        // Angle near 2π/5: the fifth return is the first below the tolerance.
        let decay = |n: f64| {
            let size = 3e-9 * (-0.02 * n).exp();
            let angle = 1.2566 * n;
            [1.0 + size * angle.cos(), size * angle.sin()]
        };
        let mut recurrence = Recurrence::new(&model());
        let norm = EnergyNorm::new(&model());
        let mut first = None;
        for n in 0..400 {
            recurrence.push(&decay(f64::from(n)));
            first = first.or(recurrence.period(&norm));
        }
        assert_eq!(first, Some(1));
    }
}
