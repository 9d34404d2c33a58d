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

/// Return distance below which a period is the motion's own. A decaying oscillation of
/// angle θ a cycle comes back best after some lag with kθ near a turn; the orbit it decays
/// to repeats sooner. Points of a genuine orbit lie apart by far more than this.
const SAME_POINT: f64 = 1e-7;

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

    /// The period of the motion, once it repeats to [`TOLERANCE`] and the store is full.
    pub fn period(&self, norm: &EnergyNorm) -> Option<u32> {
        if self.states.len() < Self::KEPT {
            return None;
        }
        let repeats = |period: usize, tolerance: f64| {
            (0..LONGEST_PERIOD).all(|back| {
                norm.distance(self.past(back), self.past(back + period)) <= tolerance * norm.unit()
            })
        };
        let longest = (1..=LONGEST_PERIOD).find(|&period| repeats(period, TOLERANCE))?;
        (1..=longest)
            .find(|&period| longest.is_multiple_of(period) && repeats(period, SAME_POINT))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Drive, Model, OperatingPoint};
    use crate::shaft::ModalStructure;

    fn norm() -> EnergyNorm {
        let structure = ModalStructure {
            teeth: 20,
            wheel_teeth: None,
            rated_force: 1.0,
            frequency: vec![1.0],
            damping: vec![0.1],
            mesh: vec![1.0],
            mesh_tilt: vec![0.0],
            torque: vec![1.0],
            pinion_torque: None,
            wheel_torque: None,
            friction: vec![0.0],
            friction_lever: vec![0.0],
            residual_flexibility: 0.0,
        };
        let drive = Drive {
            half_gap: 1.0,
            stiffness: vec![1.0],
            damping: 0.0,
            friction: 0.0,
            transmission_error: Vec::new(),
            torque_ripple: Vec::new(),
        };
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        EnergyNorm::new(&Model::new(&structure, &drive, point).unwrap())
    }

    fn period(cycles: usize, state: impl Fn(f64) -> [f64; 2]) -> Option<u32> {
        let mut recurrence = Recurrence::default();
        for n in 0..cycles {
            recurrence.push(&state(n as f64));
        }
        recurrence.period(&norm())
    }

    #[test]
    fn short_periods_are_told_apart_and_irrational_ones_have_none() {
        for k in [1.0, 2.0, 3.0, 7.0, 32.0] {
            let turn = std::f64::consts::TAU / k;
            let found = period(100, |n| [(turn * (n % k)).cos(), (turn * (n % k)).sin()]);
            assert_eq!(found, Some(k as u32));
        }
        assert_eq!(period(100, |n| [n.sin(), n.cos()]), None);
        // Too few cycles to tell.
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
        let mut recurrence = Recurrence::default();
        let norm = norm();
        let mut first = None;
        for n in 0..400 {
            recurrence.push(&decay(f64::from(n)));
            first = first.or(recurrence.period(&norm));
        }
        assert_eq!(first, Some(1));
    }
}
