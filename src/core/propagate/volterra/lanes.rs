//! The inner loops, compiled for several instruction sets and chosen at run time.
//!
//! Every loop is written once over arrays of lanes ([`window`] for whole windows, [`cut`] for
//! those cut short), for a trajectory and its tangents together ([`columns`]); with the target features switched on the compiler turns it into the
//! machine's vectors (closures would not inherit the features, so there are none). A call
//! does all that one window needs, so that the choice of the set costs little. Results
//! differ between instruction sets within rounding (fused or separate multiply-add), never
//! between runs on one.

mod columns;
mod crossing;
mod cut;
mod truncated;
mod varying;
mod window;

pub use cut::{Basis, ExponentialChunk};
pub use truncated::tail;
pub use window::{Solution, Windows, size};

use super::feedback::ContactSolve;
use super::shapes::{BlockChunk, GapError, Lanes, Row, Series, TERMS};
use super::varying::{Factors, Nodal};
use crate::model::STIFFNESS_TERMS;
use crate::propagate::Counters;
use crate::propagate::events::{Crossing, Guard};
use crate::propagate::vectors::{InstructionSet, for_each_set};

for_each_set! {
    /// Deflection of a full window, and in contact the force of every column. The columns are
    /// the trajectory and its tangents, one after the other; `inputs` drive the trajectory, and
    /// the side's gap s b [m] comes with the contact, and with it the gap error on that side,
    /// s e [m], if anything: the deflection is then found without it, δ − s e. `rows` are those of
    /// the blocks and inputs.
    fn solve(
        rows: &[Row],
        inputs: &[f64],
        columns: &[f64],
        contact: Option<(ContactSolve<'_>, f64, Option<&GapError>)>,
        forces: &mut [Row],
        out: &mut Solution,
    ) = solve_body
}

for_each_set! {
    /// Free deflection of every column on a full window; `inputs` drive the first.
    fn free(rows: &[Row], inputs: &[f64], columns: &[f64], out: &mut [Row]) = free_body
}

for_each_set! {
    /// The trajectory's deflection on a full window by its first terms, with bounds of the others
    /// by the `tails` of `rows`; `felt` is what the force f of another line does to it, `−B f`.
    fn truncated(
        rows: &[Row],
        tails: &[f64],
        inputs: &[f64],
        trajectory: &[f64],
        felt: Option<(&[Row; TERMS], &Row, &Row)>,
        out: &mut Solution,
    ) = truncated_body
}

for_each_set! {
    /// `out − B f` for every column: what forces leave of deflections.
    fn yielded(response: &[Row; TERMS], forces: &[Row], out: &mut [Row]) = yielded_body
}

for_each_set! {
    /// The force of every column, whose deflections are `free` without any force and `next` under
    /// those of other contacts; the first has the side's gap s b \[m\]. Returns the most by which
    /// a deflection has moved from where it was `seen`, relative to the sizes of `free` and `next`,
    /// and leaves `next` there.
    fn close(
        closed: ContactSolve<'_>,
        gap: f64,
        free: &[Row],
        next: &[Row],
        seen: &mut [Row],
        forces: &mut [Row],
    ) -> f64 = close_body
}

for_each_set! {
    /// Factorises a window's system; `places` are its nodes within the segment whose
    /// `stiffness` varies.
    fn factorise(
        nodal: &Nodal,
        stiffness: &[f64; STIFFNESS_TERMS],
        places: &Series,
        damping: f64,
        out: &mut Factors,
    ) = factorise_body
}

for_each_set! {
    /// Force series from that of the free deflection; `gap` is s b [m].
    fn force(nodal: &Nodal, factors: &Factors, free: &Row, gap: f64) -> Row = force_body
}

for_each_set! {
    /// Deflection series from those of the free deflection and the force.
    fn deflection(nodal: &Nodal, free: &Row, force: &Row) -> Row = deflection_body
}

for_each_set! {
    /// `x = D x + E f + …` for a full window and every column x: `forces` one a column, none in
    /// free flight; `inputs` the weights of the constant and harmonic inputs, which act on the
    /// first.
    fn advance(windows: &Windows, forces: &[Row], inputs: &[f64], columns: &mut [f64])
        = advance_body
}

for_each_set! {
    /// The saltation of an event for every column: `x += damping δ(x) (−g)`, damping the
    /// contact's on entry, its opposite on release.
    fn apply_saltation(blocks: &[BlockChunk], damping: f64, columns: &mut [f64]) = salt_body
}

for_each_set! {
    /// Legendre polynomials of the full window at the end of its part up to `end` ∈ (−1, 1],
    /// and where a rule's `nodes` and weights are given at the part's nodes.
    fn basis(rule: Option<[&Series; 2]>, end: f64, delta: f64, out: &mut Basis) = basis_body
}

for_each_set! {
    /// Values at the nodes of the part, in place of every series on the full window.
    fn node_values(basis: &Basis, series: &mut [Row]) = node_values_body
}

for_each_set! {
    /// Series on the part, in place of those on the full window; `interpolation` is that from the
    /// part's nodes.
    fn restrict(basis: &Basis, interpolation: &[Row; TERMS], series: &mut [Row]) = restrict_body
}

for_each_set! {
    /// The same for the part up to `end` ∈ (−1, 1] without a basis, where no other series needs one.
    fn restrict_to(
        nodes: &Series,
        interpolation: &[Row; TERMS],
        end: f64,
        series: &mut Row,
    ) = restrict_to_body
}

for_each_set! {
    /// `∫₀^τ P_k(ξ(τ−s)) F(s) ds` for every k, in place of every F's values at the nodes. Apart
    /// from [`node_values`], lest the compiler hold all polynomials for both.
    fn moments(basis: &Basis, values: &mut [Row]) = moments_body
}

for_each_set! {
    /// The state at the end of a part for every column, in place: `x = e^{Aτ} x − Σ moments[k]
    /// ê_k g`. On the first act the torques too: `r + e^{Aτ} (x − r)` about the blocks' rest r, and
    /// where blocks have none `+ Σ constant[k] ê_k s`. No `moments` in free flight;
    /// `ends` is left with `e^{μτ} cos ντ` and `e^{μτ} sin ντ / ν` of all blocks.
    fn cut(
        blocks: &[BlockChunk],
        exponentials: &[ExponentialChunk],
        basis: &Basis,
        moments: &[Row],
        ends: &mut [[Lanes; 2]],
        columns: &mut [f64],
    ) = cut_body
}

for_each_set! {
    /// `x += Σ weights[k] ê_k input` for an input with its own gains.
    fn push(
        blocks: &[BlockChunk],
        exponentials: &[ExponentialChunk],
        input: &[[Lanes; 2]],
        weights: &Row,
        x: &mut [f64],
    ) = push_body
}

for_each_set! {
    /// [`crate::propagate::events::first_crossing`].
    fn first_crossing(
        deflection: &Series,
        noise: f64,
        guards: &[Guard<'_, TERMS>],
        limit: f64,
        counters: &mut Counters,
    ) -> Option<Crossing> = first_crossing_body
}

use crossing::first_crossing_body;
use cut::{
    basis_body, cut_body, moments_body, node_values_body, push_body, restrict_body,
    restrict_to_body, salt_body,
};
use truncated::truncated_body;
use varying::{deflection_body, factorise_body, force_body};
use window::{advance_body, close_body, free_body, solve_body, yielded_body};

#[cfg(test)]
mod tests;
