//! The structured kernel: a scalar Volterra equation for the mesh force, no dense operators.
//!
//! On a window `[0, Δ]` with constant (k, c) write `H(t) = Σ w e^{At} g` for the response of
//! the deflection to a unit impulse of mesh force. Then
//!
//! ```text
//! δ(t) = δ_free(t) − ∫₀ᵗ H(t−τ) F(τ) dτ,      F = k (δ − s b) + c δ'
//! ```
//!
//! is a scalar Volterra equation of the second kind. All functions of a window are carried
//! as Legendre series with P = 16 terms (Galerkin projection), so that the same numbers
//! serve the solution and the event certificates:
//!
//! ```text
//! d = R x + …                    free deflection (and R' x its rate)
//! f = S (k d + c d' − k s b e₀),  S = (I + k B + c B')⁻¹, one per distinct (k, c)
//! δ = d − B f
//! x⁺ = D x + E f + …
//! ```
//!
//! R, R', E, B follow in closed form from the Legendre series of the block exponentials
//! ([`crate::numerics::exponential`]) and a universal convolution table
//! ([`crate::numerics::convolution`]). They depend on (Ω, Δ) only: loads, contact states
//! and segments share them. In free flight F = 0 and the mesh is not looked at.
//!
//! A window may start anywhere. It is cut short at an event or at a breakpoint by
//! evaluating the state there from the same force series ([`partial`]).
//!
//! Layout: the series index is the SIMD lane in R, R', B and S (16 doubles, two or four
//! vectors); the block index is the lane in D, E and the partial windows (chunks of 8).
//! At N = 40 the tables are 40 KB + 2 KB a distinct stiffness and stay in the inner caches.

mod feedback;
mod lanes;
mod length;
mod march;
mod partial;
mod tables;

pub use lanes::InstructionSet;

use crate::model::Model;
use tables::Tables;

/// Terms of every series on a window.
pub const TERMS: usize = 24;

/// The structured kernel for one model.
#[derive(Debug)]
pub struct Volterra<'m> {
    model: &'m Model,
    tables: Tables,
    event_limit: u32,
    instructions: InstructionSet,
}

impl<'m> Volterra<'m> {
    /// Builds the kernel's tables for a model.
    ///
    /// * `tolerance`: relative size of the first Legendre coefficient left out of a window,
    ///   for the fastest motion the model has; 2⁻⁵² for round-off. It sets the window length,
    ///   which the exponential series bound: above some 3·10⁻¹³ windows grow no longer.
    /// * `event_limit`: most events in a mesh cycle before marching stops.
    pub fn new(model: &'m Model, tolerance: f64, event_limit: u32) -> Self {
        Self::with_instructions(model, tolerance, event_limit, InstructionSet::best())
    }

    /// As [`Self::new`], with a given instruction set.
    pub fn with_instructions(
        model: &'m Model,
        tolerance: f64,
        event_limit: u32,
        instructions: InstructionSet,
    ) -> Self {
        Self {
            model,
            tables: Tables::new(model, tolerance),
            event_limit,
            instructions,
        }
    }

    /// Upper bound of the rates \[rad/s\] of a model in any contact state, excitation
    /// included; windows are chosen by it.
    pub fn fastest_rate(model: &Model) -> f64 {
        length::fastest_rate(model)
    }

    /// Windows a mesh cycle that the kernel would need for a model: a stiff mesh, a strong
    /// damper or a slow speed can ask for more than anyone wants to wait for.
    pub fn windows_needed(model: &Model, tolerance: f64) -> f64 {
        length::windows_needed(model, tolerance)
    }

    /// Windows a mesh cycle without events.
    pub fn windows_per_cycle(&self) -> usize {
        self.tables.cells
    }
}
