//! Loops of a window cut short.
//!
//! The exponential series `ê_k` of the full window serve every part [0, τ] of it:
//!
//! ```text
//! e^{Aτ} = Σ ê_k P_k(ξ(τ)),    ∫₀^τ e^{A(τ−s)} F(s) ds = Σ ê_k ∫₀^τ P_k(ξ(τ−s)) F(s) ds
//! ```
//!
//! and the integrals know nothing of the blocks. They are taken by the Gauss rule with P
//! nodes, exact to degree 2P − 1; since its nodes lie symmetrically, `τ − s_j` is a node
//! too and one table of polynomials gives both factors.

use super::columns::{combine, in_batches, series};
use super::vectors::{accumulate, products_of_rows};
use super::{LANES, Lanes, fma};
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::tables::{BlockChunk, Row, Series};

/// Legendre series of `e^{μt} cos νt` and `e^{μt} sin νt / ν` of one chunk on a full window.
#[derive(Debug, Clone, Copy)]
pub struct ExponentialChunk(pub [[Lanes; 2]; TERMS]);

impl ExponentialChunk {
    /// All zero.
    pub const ZERO: Self = Self([[Lanes::ZERO; 2]; TERMS]);
}

/// What depends on the cut alone.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Basis {
    /// `values[n][j]` = P_n of the full window at node j of the part.
    pub values: [Row; TERMS],
    /// Weights of the part's nodes \[s\].
    pub weights: Series,
    /// P_n at the part's end.
    pub end: Series,
    /// `∫₀^τ P_n dt` \[s\].
    pub constant: Series,
}

impl Basis {
    /// Nothing yet.
    pub const ZERO: Self = Self {
        values: [Row::ZERO; TERMS],
        weights: [0.0; TERMS],
        end: [0.0; TERMS],
        constant: [0.0; TERMS],
    };
}

/// Factors of `P_{n+1} = up x P_n − down P_{n−1}`.
const fn recurrence() -> [[f64; 2]; TERMS + 1] {
    let mut table = [[0.0; 2]; TERMS + 1];
    let mut n = 0;
    while n <= TERMS {
        let k = n as f64;
        table[n] = [(2.0 * k + 1.0) / (k + 1.0), k / (k + 1.0)];
        n += 1;
    }
    table
}

const RECURRENCE: [[f64; 2]; TERMS + 1] = recurrence();

/// `1/2 / (2n+1)`.
const fn integral() -> [f64; TERMS] {
    let mut table = [0.0; TERMS];
    let mut n = 0;
    while n < TERMS {
        table[n] = 0.5 / (2 * n + 1) as f64;
        n += 1;
    }
    table
}

const INTEGRAL: [f64; TERMS] = integral();

#[inline(always)]
pub(super) fn basis_body<const SET: u8>(
    rule: Option<[&Series; 2]>,
    end: f64,
    delta: f64,
    out: &mut Basis,
) {
    // ∫₀^τ P_n dt = Δ/2 (P_{n+1} − P_{n−1})/(2n+1), with P_{−1} = −1.
    let (mut previous, mut current) = (-1.0, 1.0);
    for n in 0..TERMS {
        out.end[n] = current;
        let [up, down] = RECURRENCE[n];
        let next = fma::<SET>(up * end, current, -(down * previous));
        out.constant[n] = INTEGRAL[n] * delta * (next - previous);
        previous = current;
        current = next;
    }
    let share = 0.5 * (end + 1.0);
    let tau = share * delta;
    out.constant[0] = tau;
    let Some([nodes, weights]) = rule else {
        return;
    };
    let mut x = [0.0; TERMS];
    for j in 0..TERMS {
        x[j] = share * (1.0 + nodes[j]) - 1.0;
        out.weights[j] = 0.5 * tau * weights[j];
    }
    let (mut previous, mut current) = ([0.0; TERMS], [1.0; TERMS]);
    for n in 0..TERMS {
        out.values[n].0 = current;
        let [up, down] = RECURRENCE[n];
        for j in 0..TERMS {
            let next = fma::<SET>(up * x[j], current[j], -(down * previous[j]));
            previous[j] = current[j];
            current[j] = next;
        }
    }
}

#[inline(always)]
pub(super) fn at_nodes_body<const SET: u8>(basis: &Basis, series: &Series) -> Series {
    let [values] = combine::<SET, 1>(&basis.values, &[series]);
    values.0
}

#[inline(always)]
pub(super) fn moments_body<const SET: u8>(basis: &Basis, forces: &mut [Row]) {
    in_batches!(SET, forces.len(), |first| moments_batch(
        basis,
        &mut forces[first..],
    ));
}

#[inline(always)]
fn moments_batch<const SET: u8, const COLUMNS: usize>(basis: &Basis, forces: &mut [Row]) {
    let Some(forces) = forces.first_chunk_mut::<COLUMNS>() else {
        return;
    };
    let values = combine::<SET, COLUMNS>(&basis.values, &series(forces));
    for (force, values) in forces.iter_mut().zip(&values) {
        let mut mirrored = Row::ZERO;
        for j in 0..TERMS {
            mirrored.0[j] = basis.weights[j] * values.0[TERMS - 1 - j];
        }
        force.0 = products_of_rows::<SET>(&basis.values, &mirrored);
    }
}

/// `Σ weights[k] ê_k` as weights of I and M, for several weights.
#[inline(always)]
fn blend<const SET: u8, const COUNT: usize>(
    exponential: &ExponentialChunk,
    weights: &[&[f64]; COUNT],
) -> [[Lanes; 2]; COUNT] {
    let mut sums = [[[Lanes::ZERO; 2]; COUNT]; 2];
    accumulate::<SET, 2, COUNT, _>(exponential.0.as_flattened(), weights, &mut sums);
    let mut out = [[Lanes::ZERO; 2]; COUNT];
    for c in 0..COUNT {
        for i in 0..2 {
            for l in 0..LANES {
                out[c][i].0[l] = sums[0][c][i].0[l] + sums[1][c][i].0[l];
            }
        }
    }
    out
}

/// `sum + (c I + s M) u`.
#[inline(always)]
fn add_applied<const SET: u8>(
    [c, s]: &[Lanes; 2],
    m: &[Lanes; 4],
    u: &[Lanes; 2],
    sum: &mut [Lanes; 2],
) {
    for l in 0..LANES {
        let mu = fma::<SET>(m[0].0[l], u[0].0[l], m[1].0[l] * u[1].0[l]);
        let mv = fma::<SET>(m[2].0[l], u[0].0[l], m[3].0[l] * u[1].0[l]);
        sum[0].0[l] = fma::<SET>(c.0[l], u[0].0[l], fma::<SET>(s.0[l], mu, sum[0].0[l]));
        sum[1].0[l] = fma::<SET>(c.0[l], u[1].0[l], fma::<SET>(s.0[l], mv, sum[1].0[l]));
    }
}

/// The components of a chunk of blocks.
#[inline(always)]
fn load(x: &[f64], padded: usize, chunk: usize) -> [Lanes; 2] {
    let mut out = [Lanes::ZERO; 2];
    out[0].0.copy_from_slice(&x[chunk * LANES..][..LANES]);
    out[1]
        .0
        .copy_from_slice(&x[padded + chunk * LANES..][..LANES]);
    out
}

#[inline(always)]
fn store(x: &mut [f64], padded: usize, chunk: usize, from: &[Lanes; 2]) {
    x[chunk * LANES..][..LANES].copy_from_slice(&from[0].0);
    x[padded + chunk * LANES..][..LANES].copy_from_slice(&from[1].0);
}

#[inline(always)]
pub(super) fn cut_body<const SET: u8>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    basis: &Basis,
    moments: &[Row],
    ends: &mut [[Lanes; 2]],
    columns: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    // What no tangent has, and what all have.
    for (chunk, ((block, exponential), end)) in
        blocks.iter().zip(exponentials).zip(&mut *ends).enumerate()
    {
        let m = &block.traceless;
        let mut sum = [Lanes::ZERO; 2];
        let from = load(columns, padded, chunk);
        let weights = if let Some(force) = moments.first() {
            let [own, constant, force] =
                blend::<SET, 3>(exponential, &[&basis.end, &basis.constant, &force.0]);
            add_applied::<SET>(&force, m, &block.mesh_pull, &mut sum);
            [own, constant]
        } else {
            blend::<SET, 2>(exponential, &[&basis.end, &basis.constant])
        };
        add_applied::<SET>(&weights[1], m, &block.static_input, &mut sum);
        add_applied::<SET>(&weights[0], m, &from, &mut sum);
        store(columns, padded, chunk, &sum);
        *end = weights[0];
    }
    let tangents = &mut columns[2 * padded..];
    let count = tangents.len() / (2 * padded);
    in_batches!(SET, count, |first| cut_batch(
        blocks,
        exponentials,
        ends,
        moments.get(1 + first..).unwrap_or(&[]),
        &mut tangents[2 * first * padded..],
    ));
}

/// Moves a batch of tangents to the end of a part.
#[inline(always)]
fn cut_batch<const SET: u8, const COLUMNS: usize>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    ends: &[[Lanes; 2]],
    moments: &[Row],
    columns: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    let moments = moments.first_chunk::<COLUMNS>();
    for (chunk, ((block, exponential), end)) in
        blocks.iter().zip(exponentials).zip(ends).enumerate()
    {
        let m = &block.traceless;
        let mut sums = [[Lanes::ZERO; 2]; COLUMNS];
        if let Some(moments) = moments {
            let weights = blend::<SET, COLUMNS>(exponential, &series(moments));
            for c in 0..COLUMNS {
                add_applied::<SET>(&weights[c], m, &block.mesh_pull, &mut sums[c]);
            }
        }
        for c in 0..COLUMNS {
            let x = &mut columns[2 * c * padded..][..2 * padded];
            let from = load(x, padded, chunk);
            add_applied::<SET>(end, m, &from, &mut sums[c]);
            store(x, padded, chunk, &sums[c]);
        }
    }
}

#[inline(always)]
pub(super) fn push_body<const SET: u8>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    input: &[[Lanes; 2]],
    weights: &Row,
    x: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    for (chunk, ((block, exponential), input)) in
        blocks.iter().zip(exponentials).zip(input).enumerate()
    {
        let mut sum = load(x, padded, chunk);
        let [weights] = blend::<SET, 1>(exponential, &[&weights.0]);
        add_applied::<SET>(&weights, &block.traceless, input, &mut sum);
        store(x, padded, chunk, &sum);
    }
}

#[inline(always)]
pub(super) fn salt_body<const SET: u8>(blocks: &[BlockChunk], damping: f64, columns: &mut [f64]) {
    let padded = blocks.len() * LANES;
    for x in columns.chunks_exact_mut(2 * padded) {
        let mut sums = [0.0; LANES];
        for (chunk, block) in blocks.iter().enumerate() {
            let [a, b] = load(x, padded, chunk);
            let [v, w] = &block.deflection;
            for l in 0..LANES {
                sums[l] = fma::<SET>(v.0[l], a.0[l], fma::<SET>(w.0[l], b.0[l], sums[l]));
            }
        }
        let deflection = ((sums[0] + sums[4]) + (sums[2] + sums[6]))
            + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
        let kick = damping * deflection;
        for (chunk, block) in blocks.iter().enumerate() {
            let mut own = load(x, padded, chunk);
            for (component, pull) in own.iter_mut().zip(&block.mesh_pull) {
                for l in 0..LANES {
                    component.0[l] = fma::<SET>(pull.0[l], kick, component.0[l]);
                }
            }
            store(x, padded, chunk, &own);
        }
    }
}
