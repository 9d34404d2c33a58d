//! The inner loops, compiled for several instruction sets and chosen at run time.
//!
//! Every loop is written once, generic over the vectors of the instruction sets ([`window`] for whole windows,
//! [`cut`] for cut ones), for a trajectory and its tangents together ([`columns`]). A call does everything that one
//! window needs, so the choice of the set costs little. Results differ between instruction sets within rounding
//! (fused or separate multiply-add). Runs with one instruction set give the same bits.

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
    /// Deflection of a full window and, in contact, the force of every column. The columns are the trajectory and its
    /// tangents, one after the other; `inputs` drive the trajectory. The contact comes with the gap s b [m] of its
    /// side and its gap error s e [m], if any. With an error, the resulting deflection omits it: δ − s e. `rows` are
    /// those of the blocks and inputs.
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
    /// The leading Legendre coefficients of the trajectory's deflection on an uncut window. The omitted
    /// coefficients are bounded with `tails`, the bounds for `rows`. `other_response` has B, the bounds for
    /// its rows, and f of the deflection `−B f` that the force f on another line of action causes.
    fn truncated(
        rows: &[Row],
        tails: &[f64],
        inputs: &[f64],
        trajectory: &[f64],
        other_response: Option<(&[Row; TERMS], &Row, &Row)>,
        out: &mut Solution,
    ) = truncated_body
}

for_each_set! {
    /// `out − B f` for every column: subtracts the response to forces from deflections.
    fn yielded(response: &[Row; TERMS], forces: &[Row], out: &mut [Row]) = yielded_body
}

for_each_set! {
    /// The force of every column. Its deflections are `free` without any force and `next` under the forces of other
    /// contacts; the first column has the side's gap s b \[m\]. Returns the largest change of a deflection since
    /// `deflections`, relative to the sizes of `free` and `next`, and stores `next` in `deflections`.
    fn close(
        closed: ContactSolve<'_>,
        gap: f64,
        free: &[Row],
        next: &[Row],
        deflections: &mut [Row],
        forces: &mut [Row],
    ) -> f64 = close_body
}

for_each_set! {
    /// Factorises a window's system; `places` are the positions of its nodes in the segment with the varying
    /// `stiffness`.
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
    fn deflection(nodal: &Nodal, free: &Row, force: &Row) -> Row = deflection_columns
}

for_each_set! {
    /// `x = D x + E f + …` for a full window and every column x. `forces` has one series per column, and none in free
    /// flight. `inputs` are the weights of the constant and harmonic inputs, which act on the first column.
    fn advance(windows: &Windows, forces: &[Row], inputs: &[f64], columns: &mut [f64])
        = advance_body
}

for_each_set! {
    /// The saltation of an event for every column: `x += damping δ(x) (−g)`. `damping` is that of the contact on
    /// entry, and its negative on release.
    fn apply_saltation(blocks: &[BlockChunk], damping: f64, columns: &mut [f64]) = salt_body
}

for_each_set! {
    /// Legendre polynomials of the full window at the end of its part up to `end` ∈ (−1, 1]. If the `nodes` and
    /// weights of a rule are given, also at the nodes of the part.
    fn basis(rule: Option<[&Series; 2]>, end: f64, delta: f64, out: &mut Basis) = basis_body
}

for_each_set! {
    /// Replaces every series on the full window by its values at the nodes of the part.
    fn node_values(basis: &Basis, series: &mut [Row]) = node_values_body
}

for_each_set! {
    /// Replaces series on the full window by series on the part; `interpolation` is that from the part's nodes.
    fn restrict(basis: &Basis, interpolation: &[Row; TERMS], series: &mut [Row]) = restrict_body
}

for_each_set! {
    /// As [`restrict`], for the part up to `end` ∈ (−1, 1] without a basis, if no other series needs one.
    fn restrict_to(
        nodes: &Series,
        interpolation: &[Row; TERMS],
        end: f64,
        series: &mut Row,
    ) = restrict_to_body
}

for_each_set! {
    /// `∫₀^τ P_k(ξ(τ−s)) F(s) ds` for every k, in place of every F's values at the nodes. Separate from
    /// [`node_values`], so that the compiler does not keep all polynomials for both.
    fn moments(basis: &Basis, values: &mut [Row]) = moments_body
}

for_each_set! {
    /// The state at the end of a part for every column, in place: `x = e^{Aτ} x − Σ moments[k] ê_k g`. The torques
    /// act on the first column too: `r + e^{Aτ} (x − r)` about the blocks' rest position r, or
    /// `+ Σ constant[k] ê_k s` if there is none. `moments` is empty in free flight. Sets `ends` to `e^{μτ} cos ντ`
    /// and `e^{μτ} sin ντ / ν` of all blocks.
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
    /// `x += Σ weights[k] ê_k input` for an input with separate gains.
    fn push(
        blocks: &[BlockChunk],
        exponentials: &[ExponentialChunk],
        input: &[[Lanes; 2]],
        weights: &Row,
        x: &mut [f64],
    ) = push_body
}

for_each_set! {
    /// As [`crate::propagate::events::first_crossing`], with the vectors of the set.
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
use varying::{deflection_columns, factorise_body, force_body};
use window::{advance_body, close_body, free_body, solve_body, yielded_body};

#[cfg(test)]
mod tests;
