//! Windows cut short, by an event or by a breakpoint of the mesh.
//!
//! The force is known as a polynomial on the full window. Re-expanded on `[0, τ]` it drives
//! the blocks to
//!
//! ```text
//! x(τ) = e^{Aτ} x − Σ_n (−1)ⁿ τ/(2n+1) f_n ê_n(τ) g,      ê_n: Legendre series of e^{At} on [0, τ]
//! ```
//!
//! which is exact for the polynomial. The exponential series are formed once a cut and
//! shared by the trajectory and its tangents.

use super::lanes::{self, ExponentialChunk};
use super::tables::{Series, moment};
use super::window::{Phases, Solution};
use super::{TERMS, Volterra};
use crate::numerics::exponential::{legendre_series, multiply};
use crate::numerics::legendre::transforms16;

/// A window cut at τ.
#[derive(Debug)]
pub struct Cut {
    /// Length τ \[s\].
    tau: f64,
    /// τ as a place on the full window, in \[−1, 1\].
    end: f64,
    /// Exponential series of all blocks on \[0, τ\].
    exponentials: Vec<ExponentialChunk>,
}

impl Cut {
    /// Room for the exponentials of `chunks` chunks of blocks.
    pub fn new(chunks: usize) -> Self {
        Self {
            tau: 0.0,
            end: -1.0,
            exponentials: vec![ExponentialChunk::ZERO; chunks],
        }
    }
}

impl Volterra<'_> {
    /// Prepares a cut at the place `end` ∈ (−1, 1\] of a full window; returns τ \[s\].
    pub(super) fn prepare_cut(&self, end: f64, cut: &mut Cut) -> f64 {
        cut.end = end;
        cut.tau = 0.5 * (end + 1.0) * self.tables.delta;
        lanes::exponentials(
            self.instructions,
            &self.tables.blocks,
            cut.tau,
            &mut cut.exponentials,
        );
        cut.tau
    }

    /// Moves the trajectory's state to the cut. `force` is the series on the full window,
    /// none in free flight.
    pub(super) fn cut_trajectory(
        &self,
        cut: &Cut,
        force: Option<&Series>,
        phases: &Phases,
        x: &mut [f64],
    ) {
        let moments = force.map(|f| force_moments(cut, f));
        lanes::cut(
            self.instructions,
            &self.tables.blocks,
            &cut.exponentials,
            cut.tau,
            moments.as_ref(),
            true,
            x,
        );
        for (ripple, phase) in self.model.ripple.iter().zip(&phases.ripple) {
            let mut series = [(0.0, 0.0); TERMS];
            legendre_series((0.0, ripple.angular_frequency), cut.tau, &mut series);
            let mut moments = [0.0; TERMS];
            for (n, m) in moments.iter_mut().enumerate() {
                *m = moment(n, cut.tau) * multiply(*phase, series[n]).0;
            }
            self.add_cut_input(cut, &moments, &ripple.input, x);
        }
    }

    /// Moves a tangent vector to the cut.
    pub(super) fn cut_tangent(&self, cut: &Cut, force: Option<&Series>, x: &mut [f64]) {
        let moments = force.map(|f| force_moments(cut, f));
        lanes::cut(
            self.instructions,
            &self.tables.blocks,
            &cut.exponentials,
            cut.tau,
            moments.as_ref(),
            false,
            x,
        );
    }

    /// `deflection` and `force` on the cut window, as the observer sees them.
    pub(super) fn cut_series(&self, cut: &Cut, solution: &Solution) -> (Series, Series) {
        let transforms = transforms16();
        (
            transforms.restrict(&solution.deflection, -1.0, cut.end),
            transforms.restrict(&solution.force, -1.0, cut.end),
        )
    }

    /// Adds `Σ moments[n] ê_n input` to the state, block by block.
    fn add_cut_input(&self, cut: &Cut, moments: &Series, input: &[[f64; 2]], x: &mut [f64]) {
        let padded = self.tables.padded;
        for (i, u) in input.iter().enumerate() {
            let (chunk, lane) = (i / lanes::LANES, i % lanes::LANES);
            let exponential = &cut.exponentials[chunk];
            let m = &self.tables.blocks[chunk].traceless;
            let (mut cosine, mut sine) = (0.0, 0.0);
            for n in 0..TERMS {
                cosine += moments[n] * exponential.cosine[n][lane];
                sine += moments[n] * exponential.sine[n][lane];
            }
            x[i] += cosine * u[0] + sine * (m[0][lane] * u[0] + m[1][lane] * u[1]);
            x[padded + i] += cosine * u[1] + sine * (m[2][lane] * u[0] + m[3][lane] * u[1]);
        }
    }
}

/// Moments of the force on the cut window, as [`lanes::cut`] wants them.
fn force_moments(cut: &Cut, force: &Series) -> Series {
    let mut moments = transforms16().restrict(force, -1.0, cut.end);
    for (n, f) in moments.iter_mut().enumerate() {
        *f *= moment(n, cut.tau);
    }
    moments
}
