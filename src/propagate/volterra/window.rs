//! The solution of one full window: deflection and force as series.

use super::lanes::{InstructionSet, combine};
use super::tables::{Feedback, Harmonic, Series, Tables};
use super::{TERMS, Volterra};
use crate::numerics::exponential::{Complex, multiply};

/// Phases of the excitation at a window's start, as unit complex numbers.
#[derive(Debug, Clone, Default)]
pub struct Phases {
    /// One a harmonic of the transmission error.
    pub transmission_error: Vec<Complex>,
    /// One a harmonic of the torque ripple.
    pub ripple: Vec<Complex>,
}

/// Deflection and force on a window.
#[derive(Debug, Clone, Copy)]
pub struct Solution {
    /// Series of δ \[m\].
    pub deflection: Series,
    /// Series of F \[N\]; zero in free flight.
    pub force: Series,
    /// Round-off of `deflection` \[m\].
    pub noise: f64,
}

/// Round-off of a sum of a hundred terms, in units of the sum of their sizes.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

impl Volterra<'_> {
    /// Sets the excitation's phases for a window that starts at a time \[s\] within a mesh
    /// cycle.
    pub(super) fn set_phases(&self, cycle: u64, time: f64, phases: &mut Phases) {
        for (phase, h) in phases
            .transmission_error
            .iter_mut()
            .zip(&self.tables.transmission_error)
        {
            let (sin, cos) = (h.angular_frequency * time).sin_cos();
            *phase = (cos, sin);
        }
        for (phase, r) in phases.ripple.iter_mut().zip(&self.model.ripple) {
            let (sin, cos) = r.phase_at(cycle, time).sin_cos();
            *phase = (cos, sin);
        }
    }

    /// Solves a full window from state `x` (padded): free flight where `contact` is none, else
    /// contact on a segment with the given side s = ±1.
    pub(super) fn solve(
        &self,
        x: &[f64],
        phases: &Phases,
        contact: Option<(&Feedback, f64)>,
    ) -> Solution {
        let t = &self.tables;
        let set = self.instructions;
        let mut deflection = combine(set, &t.deflection, x);
        add(&mut deflection, &t.static_deflection);
        add_harmonics(&mut deflection, t, phases, |h| &h.deflection);
        let size: f64 = deflection.iter().map(|a| a.abs()).sum();
        let noise = ROUND_OFF * (size + self.model.half_gap);
        let mut force = [0.0; TERMS];
        if let Some((feedback, side)) = contact {
            let mut rate = combine(set, &t.rate, x);
            add(&mut rate, &t.static_rate);
            add_harmonics(&mut rate, t, phases, |h| &h.rate);
            force = feed_back(
                set,
                feedback,
                &deflection,
                &rate,
                side * self.model.half_gap,
            );
            subtract_response(set, t, &force, &mut deflection);
        }
        Solution {
            deflection,
            force,
            noise,
        }
    }

    /// The force series of a tangent vector on a contact window.
    pub(super) fn solve_tangent(&self, x: &[f64], feedback: &Feedback) -> Series {
        let deflection = combine(self.instructions, &self.tables.deflection, x);
        let rate = combine(self.instructions, &self.tables.rate, x);
        feed_back(self.instructions, feedback, &deflection, &rate, 0.0)
    }

    /// Adds what mean torques and ripple do to the state over a full window.
    pub(super) fn add_inputs(&self, phases: &Phases, x: &mut [f64]) {
        for (x, s) in x.iter_mut().zip(&self.tables.static_state) {
            *x += s;
        }
        for (h, phase) in self.tables.ripple.iter().zip(&phases.ripple) {
            for (x, s) in x.iter_mut().zip(&h.state) {
                *x += multiply(*phase, *s).0;
            }
        }
    }
}

/// `f = S (k d + c d' − k gap e₀)`.
fn feed_back(
    set: InstructionSet,
    feedback: &Feedback,
    deflection: &Series,
    rate: &Series,
    gap: f64,
) -> Series {
    let (k, c) = (feedback.stiffness, feedback.damping);
    let mut load = [0.0; TERMS];
    for n in 0..TERMS {
        load[n] = k * deflection[n] + c * rate[n];
    }
    load[0] -= k * gap;
    combine(set, &feedback.solution, &load)
}

/// `δ = d − B f`.
fn subtract_response(
    set: InstructionSet,
    tables: &Tables,
    force: &Series,
    deflection: &mut Series,
) {
    let response = combine(set, &tables.response, force);
    for (d, r) in deflection.iter_mut().zip(response) {
        *d -= r;
    }
}

fn add(target: &mut Series, source: &Series) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += s;
    }
}

/// Adds the real parts of all excitation harmonics at their present phases.
fn add_harmonics<'t>(
    target: &mut Series,
    tables: &'t Tables,
    phases: &Phases,
    part: impl Fn(&'t Harmonic) -> &'t [Complex; TERMS],
) {
    let error = tables
        .transmission_error
        .iter()
        .zip(&phases.transmission_error);
    let ripple = tables.ripple.iter().zip(&phases.ripple);
    for (harmonic, phase) in error.chain(ripple) {
        for (t, u) in target.iter_mut().zip(part(harmonic)) {
            *t += multiply(*phase, *u).0;
        }
    }
}
