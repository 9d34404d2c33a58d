//! How does a window that an event or a breakpoint of the mesh cuts move the state?
//!
//! The force is known as a polynomial on the full window. Up to τ, it moves the blocks to
//!
//! ```text
//! x(τ) = e^{Aτ} x − ∫₀^τ e^{A(τ−s)} g F(s) ds = Σ ê_k (P_k(ξ(τ)) x − g ∫₀^τ P_k(ξ(τ−s)) F(s) ds)
//! ```
//!
//! with ê_k the exponential series of the full window and ξ the position of a time in it. The weights in the sums do
//! not depend on the blocks. The exponentials at τ are formed once per cut and shared by the trajectory and its
//! tangents.

use super::Volterra;
use super::lanes::{self, Basis};
use super::shapes::{Lanes, Row, Series, interpolation};
use super::window_table::WindowTable;
use crate::numerics::legendre::transforms24;
use num_complex::c64;

/// A window cut at τ.
#[derive(Debug)]
pub struct Cut {
    basis: Basis,
    /// Exponentials of all blocks at τ.
    ends: Vec<[Lanes; 2]>,
}

impl Cut {
    /// Memory for the exponentials of `chunks` chunks of blocks.
    pub fn new(chunks: usize) -> Self {
        Self {
            basis: Basis::ZERO,
            ends: vec![[Lanes::ZERO; 2]; chunks],
        }
    }
}

impl Volterra<'_> {
    /// Prepares a cut at the position `end` ∈ (−1, 1\] of a full window; returns τ \[s\]. `with_nodes` adds values at
    /// the nodes of the part, which forces and observers need.
    pub(super) fn prepare_cut(
        &self,
        table: &WindowTable,
        end: f64,
        with_nodes: bool,
        cut: &mut Cut,
    ) -> f64 {
        let rule = transforms24();
        let with_nodes = with_nodes || !self.tables.ripple.is_empty();
        lanes::basis(
            self.instructions,
            with_nodes.then_some([rule.nodes(), rule.weights()]),
            end,
            table.delta,
            &mut cut.basis,
        );
        0.5 * (end + 1.0) * table.delta
    }

    /// Moves trajectory and tangents to the cut. `forces` are the series on the full window, empty in free flight,
    /// and are overwritten.
    pub(super) fn cut(
        &self,
        table: &WindowTable,
        cut: &mut Cut,
        forces: &mut [Row],
        inputs: &[f64],
        columns: &mut [f64],
    ) {
        let (t, set) = (&self.tables, self.instructions);
        let (blocks, exponentials) = (&t.blocks[table.direction], &table.exponentials);
        self.moments(&cut.basis, forces);
        let (basis, ends) = (&cut.basis, &mut cut.ends);
        lanes::cut(set, blocks, exponentials, basis, forces, ends, columns);
        let phases = inputs[1..].chunks_exact(2);
        for ((input, series), phase) in t.ripple.iter().zip(&table.ripple).zip(phases) {
            let mut moments = [Row(series.map(|u| (c64(phase[0], phase[1]) * u).re))];
            self.moments(basis, &mut moments);
            let trajectory = &mut columns[..2 * t.layout.padded];
            lanes::push(set, blocks, exponentials, input, &moments[0], trajectory);
        }
    }

    /// Adds the effect of another contact's force on all columns up to the cut. `forces` are its series on the full
    /// window, and are overwritten.
    pub(super) fn add_force_of_contact(
        &self,
        table: &WindowTable,
        cut: &Cut,
        forces: &mut [Row],
        columns: &mut [f64],
    ) {
        let t = &self.tables;
        let (blocks, pull) = (&t.blocks[table.direction], &t.pulls[table.direction]);
        self.moments(&cut.basis, forces);
        let length = 2 * t.layout.padded;
        for (moments, column) in forces.iter().zip(columns.chunks_exact_mut(length)) {
            let exponentials = &table.exponentials;
            lanes::push(
                self.instructions,
                blocks,
                exponentials,
                pull,
                moments,
                column,
            );
        }
    }

    /// `∫₀^τ P_k(ξ(τ−s)) F(s) ds` for every k, in place of every series F on the full window.
    fn moments(&self, basis: &Basis, series: &mut [Row]) {
        lanes::node_values(self.instructions, basis, series);
        lanes::moments(self.instructions, basis, series);
    }

    /// A window's series on its part up to the cut, for the observer.
    pub(super) fn cut_series<const COUNT: usize>(
        &self,
        cut: &Cut,
        series: [&Series; COUNT],
    ) -> [Series; COUNT] {
        let mut parts = series.map(|series| Row(*series));
        lanes::restrict(self.instructions, &cut.basis, interpolation(), &mut parts);
        parts.map(|part| part.0)
    }
}
