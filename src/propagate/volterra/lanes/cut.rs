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

use super::window::add_row;
use super::{LANES, Lanes, fma, products_of_rows};
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
        values: [Row([0.0; TERMS]); TERMS],
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

#[inline(always)]
pub(super) fn basis_body<const SET: u8>(
    nodes: &Series,
    weights: &Series,
    end: f64,
    delta: f64,
    out: &mut Basis,
) {
    let share = 0.5 * (end + 1.0);
    let tau = share * delta;
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
    // ∫₀^τ P_n dt = Δ/2 (P_{n+1} − P_{n−1})/(2n+1), with P_{−1} = −1.
    let (mut previous, mut current) = (-1.0, 1.0);
    let mut inverse = 0.5 * delta;
    for n in 0..TERMS {
        out.end[n] = current;
        let [up, down] = RECURRENCE[n];
        let next = fma::<SET>(up * end, current, -(down * previous));
        out.constant[n] = inverse * (next - previous);
        inverse = 0.5 * delta / (2 * n + 3) as f64;
        previous = current;
        current = next;
    }
    out.constant[0] = tau;
}

#[inline(always)]
pub(super) fn at_nodes_body<const SET: u8>(basis: &Basis, series: &Series) -> Series {
    let (mut even, mut odd) = ([0.0; TERMS], [0.0; TERMS]);
    for (rows, a) in basis.values.chunks_exact(2).zip(series.chunks_exact(2)) {
        add_row::<SET>(&mut even, &rows[0], a[0]);
        add_row::<SET>(&mut odd, &rows[1], a[1]);
    }
    for j in 0..TERMS {
        even[j] += odd[j];
    }
    even
}

#[inline(always)]
pub(super) fn moments_body<const SET: u8>(basis: &Basis, series: &Series) -> Series {
    let values = at_nodes_body::<SET>(basis, series);
    let mut mirrored = Row([0.0; TERMS]);
    for j in 0..TERMS {
        mirrored.0[j] = basis.weights[j] * values[TERMS - 1 - j];
    }
    products_of_rows::<SET>(&basis.values, &mirrored)
}

/// `Σ weights[k] ê_k` as weights of I and M.
#[inline(always)]
fn blend<const SET: u8>(exponential: &ExponentialChunk, weights: &Series) -> [Lanes; 2] {
    let mut sums = [[[0.0; LANES]; 2]; 2];
    for (terms, w) in exponential.0.chunks_exact(2).zip(weights.chunks_exact(2)) {
        for i in 0..2 {
            for l in 0..LANES {
                sums[i][0][l] = fma::<SET>(terms[i][0].0[l], w[i], sums[i][0][l]);
                sums[i][1][l] = fma::<SET>(terms[i][1].0[l], w[i], sums[i][1][l]);
            }
        }
    }
    let mut out = [Lanes::ZERO; 2];
    for (c, o) in out.iter_mut().enumerate() {
        for l in 0..LANES {
            o.0[l] = sums[0][c][l] + sums[1][c][l];
        }
    }
    out
}

#[inline(always)]
pub(super) fn ends_body<const SET: u8>(
    basis: &Basis,
    exponentials: &[ExponentialChunk],
    out: &mut [[Lanes; 2]],
) {
    for (exponential, end) in exponentials.iter().zip(out) {
        *end = blend::<SET>(exponential, &basis.end);
    }
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

#[inline(always)]
pub(super) fn cut_body<const SET: u8>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    ends: &[[Lanes; 2]],
    force: Option<&Series>,
    constant: Option<&Series>,
    x: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    let (x1, x2) = x[..2 * padded].split_at_mut(padded);
    let states = x1.chunks_exact_mut(LANES).zip(x2.chunks_exact_mut(LANES));
    let tables = blocks.iter().zip(exponentials).zip(ends);
    for (((block, exponential), end), (a, b)) in tables.zip(states) {
        let mut from = [Lanes::ZERO; 2];
        from[0].0.copy_from_slice(a);
        from[1].0.copy_from_slice(b);
        let m = &block.traceless;
        let mut sum = [Lanes::ZERO; 2];
        if let Some(force) = force {
            let weights = blend::<SET>(exponential, force);
            add_applied::<SET>(&weights, m, &block.mesh_pull, &mut sum);
        }
        if let Some(constant) = constant {
            let weights = blend::<SET>(exponential, constant);
            add_applied::<SET>(&weights, m, &block.static_input, &mut sum);
        }
        add_applied::<SET>(end, m, &from, &mut sum);
        a.copy_from_slice(&sum[0].0);
        b.copy_from_slice(&sum[1].0);
    }
}

#[inline(always)]
pub(super) fn push_body<const SET: u8>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    input: &[[Lanes; 2]],
    weights: &Series,
    x: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    let (x1, x2) = x[..2 * padded].split_at_mut(padded);
    let states = x1.chunks_exact_mut(LANES).zip(x2.chunks_exact_mut(LANES));
    let tables = blocks.iter().zip(exponentials).zip(input);
    for (((block, exponential), input), (a, b)) in tables.zip(states) {
        let mut sum = [Lanes::ZERO; 2];
        sum[0].0.copy_from_slice(a);
        sum[1].0.copy_from_slice(b);
        let weights = blend::<SET>(exponential, weights);
        add_applied::<SET>(&weights, &block.traceless, input, &mut sum);
        a.copy_from_slice(&sum[0].0);
        b.copy_from_slice(&sum[1].0);
    }
}
