//! Windows cut short, by an event or by a breakpoint of the mesh.
//!
//! The force is known as a polynomial on the full window. Up to τ it drives the blocks to
//!
//! ```text
//! x(τ) = e^{Aτ} x − ∫₀^τ e^{A(τ−s)} g F(s) ds = Σ ê_k (P_k(ξ(τ)) x − g ∫₀^τ P_k(ξ(τ−s)) F(s) ds)
//! ```
//!
//! with ê_k the exponential series of the full window and ξ a time's place on it. The sums'
//! weights know nothing of the blocks; the exponentials at τ are formed once a cut and shared
//! by the trajectory and its tangents.

use super::lanes::{self, Basis, Lanes, Solution};
use super::tables::Series;
use super::window_table::WindowTable;
use super::{TERMS, Volterra};
use crate::numerics::exponential::multiply;
use crate::numerics::legendre::transforms24;

/// A window cut at τ.
#[derive(Debug)]
pub struct Cut {
    basis: Basis,
    /// Exponentials of all blocks at τ.
    ends: Vec<[Lanes; 2]>,
}

impl Cut {
    /// Room for the exponentials of `chunks` chunks of blocks.
    pub fn new(chunks: usize) -> Self {
        Self {
            basis: Basis::ZERO,
            ends: vec![[Lanes::ZERO; 2]; chunks],
        }
    }
}

impl Volterra<'_> {
    /// Prepares a cut at the place `end` ∈ (−1, 1\] of a full window; returns τ \[s\].
    pub(super) fn prepare_cut(&self, table: &WindowTable, end: f64, cut: &mut Cut) -> f64 {
        let set = self.instructions;
        let rule = transforms24();
        lanes::basis(
            set,
            rule.nodes(),
            rule.weights(),
            end,
            table.delta,
            &mut cut.basis,
        );
        lanes::ends(set, &cut.basis, &table.exponentials, &mut cut.ends);
        0.5 * (end + 1.0) * table.delta
    }

    /// Moves the trajectory's extended state to the cut. `force` is the series on the full
    /// window, none in free flight.
    pub(super) fn cut_trajectory(
        &self,
        table: &WindowTable,
        cut: &Cut,
        force: Option<&Series>,
        x: &mut [f64],
    ) {
        let (t, set) = (&self.tables, self.instructions);
        let moments = force.map(|f| lanes::moments(set, &cut.basis, f));
        lanes::cut(
            set,
            &t.blocks[table.direction],
            &table.exponentials,
            &cut.ends,
            moments.as_ref(),
            Some(&cut.basis.constant),
            x,
        );
        for (index, (input, series)) in t.ripple.iter().zip(&table.ripple).enumerate() {
            let at = 2 * t.layout.padded + 1 + 2 * index;
            let phase = (x[at], x[at + 1]);
            let series = series.map(|u| multiply(phase, u).0);
            let moments = lanes::moments(set, &cut.basis, &series);
            lanes::push(
                set,
                &t.blocks[table.direction],
                &table.exponentials,
                input,
                &moments,
                x,
            );
        }
    }

    /// Moves a tangent vector to the cut.
    pub(super) fn cut_tangent(
        &self,
        table: &WindowTable,
        cut: &Cut,
        force: Option<&Series>,
        x: &mut [f64],
    ) {
        let (t, set) = (&self.tables, self.instructions);
        let moments = force.map(|f| lanes::moments(set, &cut.basis, f));
        lanes::cut(
            set,
            &t.blocks[table.direction],
            &table.exponentials,
            &cut.ends,
            moments.as_ref(),
            None,
            x,
        );
    }

    /// Deflection and force on the cut window, as the observer sees them.
    pub(super) fn cut_series(&self, cut: &Cut, solution: &Solution, touching: bool) -> [Series; 2] {
        let restrict = |series: &Series| {
            let values = lanes::at_nodes(self.instructions, &cut.basis, series);
            transforms24().interpolate(&values)
        };
        let force = match touching {
            true => restrict(&solution.force),
            false => [0.0; TERMS],
        };
        [restrict(&solution.deflection), force]
    }
}
