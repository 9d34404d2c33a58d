//! Inner loops of a cut window.
//!
//! The exponential series `ê_k` of the full window serve every part [0, τ] of it:
//!
//! ```text
//! e^{Aτ} = Σ ê_k P_k(ξ(τ)),    ∫₀^τ e^{A(τ−s)} F(s) ds = Σ ê_k ∫₀^τ P_k(ξ(τ−s)) F(s) ds
//! ```
//!
//! and the integrals do not depend on the blocks. They are computed by the Gauss rule with P nodes, exact to degree
//! 2P − 1. Since its nodes are symmetric, `τ − s_j` is a node too, and one table of polynomials gives both factors.

use super::columns::{GROUPS, add_terms, combine, in_batches, load, series, store};
use crate::propagate::vectors::Vector;
use crate::propagate::volterra::shapes::{BlockChunk, LANES, Lanes, Row, Series, TERMS};

/// Legendre series of `e^{μt} cos νt` and `e^{μt} sin νt / ν` of one chunk on a full window.
#[derive(Debug, Clone, Copy)]
pub struct ExponentialChunk {
    /// Coefficients.
    pub series: [[Lanes; 2]; TERMS],
    /// Number of significant coefficients, an even number.
    pub terms: usize,
}

impl ExponentialChunk {
    /// All zero.
    pub const ZERO: Self = Self {
        series: [[Lanes::ZERO; 2]; TERMS],
        terms: TERMS,
    };
}

/// Quantities that depend on the cut alone.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Basis {
    /// `values[n][j]` = P_n of the full window at node j of the part.
    pub values: [Row; TERMS],
    /// Weights of the part's nodes \[s\].
    pub weights: Series,
    /// P_n at the part's end.
    pub end: Row,
    /// `∫₀^τ P_n dt` \[s\].
    pub constant: Row,
}

impl Basis {
    /// All zero.
    pub const ZERO: Self = Self {
        values: [Row::ZERO; TERMS],
        weights: [0.0; TERMS],
        end: Row::ZERO,
        constant: Row::ZERO,
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

/// Sets term n at the part's end from P_n and P_{n−1} there; returns P_{n+1} and P_n. Numbers are written one at a
/// time, as they are read later: a vector read after single writes waits for all of them.
#[inline(always)]
fn at_end<V: Vector>(
    n: usize,
    end: f64,
    delta: f64,
    [now, before]: [f64; 2],
    out: &mut Basis,
) -> [f64; 2] {
    let [up, down] = RECURRENCE[n];
    let next = V::fma(up * end, now, -(down * before));
    out.end.0[n] = now;
    // ∫₀^τ P_n dt = Δ/2 (P_{n+1} − P_{n−1})/(2n+1).
    out.constant.0[n] = INTEGRAL[n] * delta * (next - before);
    [next, now]
}

#[inline(always)]
pub(super) fn basis_body<V: Vector>(
    rule: Option<[&Series; 2]>,
    end: f64,
    delta: f64,
    out: &mut Basis,
) {
    let share = 0.5 * (end + 1.0);
    let tau = share * delta;
    // P_n and P_{n−1} at the end of the part.
    let (mut now, mut before) = (1.0, 0.0);
    if let Some([nodes, weights]) = rule {
        let mut x = [V::zero(); GROUPS];
        for g in 0..GROUPS {
            let at = g * LANES;
            // Accurate for a short part, because 1 + x involves no cancellation.
            let from_start = V::read(&nodes[at..]).plus(V::splat(1.0));
            x[g] = from_start.times(V::splat(share)).plus(V::splat(-1.0));
            let weights = V::read(&weights[at..]).times(V::splat(0.5 * tau));
            weights.write(&mut out.weights[at..]);
        }
        let (mut previous, mut current) = ([V::zero(); GROUPS], [V::splat(1.0); GROUPS]);
        for n in 0..TERMS {
            // The recurrences of the nodes and of the end are independent, so their latencies overlap.
            [now, before] = at_end::<V>(n, end, delta, [now, before], out);
            let [up, down] = RECURRENCE[n];
            for g in 0..GROUPS {
                current[g].write(&mut out.values[n].0[g * LANES..]);
                let early = previous[g].times(V::splat(-down));
                previous[g] = current[g];
                current[g] = x[g].times(V::splat(up)).multiply_add(current[g], early);
            }
        }
    } else {
        for n in 0..TERMS {
            [now, before] = at_end::<V>(n, end, delta, [now, before], out);
        }
    }
    out.constant.0[0] = tau;
}

#[inline(always)]
pub(super) fn node_values_body<V: Vector>(basis: &Basis, series: &mut [Row]) {
    in_batches!(V, series.len(), |first| node_values_batch(
        basis,
        &mut series[first..],
    ));
}

#[inline(always)]
fn node_values_batch<V: Vector, const COLUMNS: usize>(basis: &Basis, rows: &mut [Row]) {
    if let Some(rows) = rows.first_chunk_mut::<COLUMNS>() {
        *rows = combine::<V, COLUMNS>(&basis.values, &series(rows));
    }
}

#[inline(always)]
pub(super) fn restrict_body<V: Vector>(
    basis: &Basis,
    interpolation: &[Row; TERMS],
    parts: &mut [Row],
) {
    in_batches!(V, parts.len(), |first| restrict_batch(
        basis,
        interpolation,
        &mut parts[first..],
    ));
}

#[inline(always)]
fn restrict_batch<V: Vector, const COLUMNS: usize>(
    basis: &Basis,
    interpolation: &[Row; TERMS],
    rows: &mut [Row],
) {
    if let Some(rows) = rows.first_chunk_mut::<COLUMNS>() {
        let values = combine::<V, COLUMNS>(&basis.values, &series(rows));
        *rows = combine::<V, COLUMNS>(interpolation, &series(&values));
    }
}

/// Clenshaw's recurrence at the part's nodes.
#[inline(always)]
pub(super) fn restrict_to_body<V: Vector>(
    nodes: &Series,
    interpolation: &[Row; TERMS],
    end: f64,
    series: &mut Row,
) {
    let share = V::splat(0.5 * (end + 1.0));
    let mut x = [V::zero(); GROUPS];
    for g in 0..GROUPS {
        let from_start = V::read(&nodes[g * LANES..]).plus(V::splat(1.0));
        x[g] = from_start.times(share).plus(V::splat(-1.0));
    }
    let (mut above, mut now) = ([V::zero(); GROUPS], [V::zero(); GROUPS]);
    for n in (0..TERMS).rev() {
        let up = RECURRENCE[n][0];
        let down = V::splat(-RECURRENCE[n + 1][1]);
        for g in 0..GROUPS {
            let early = above[g].multiply_add(down, V::splat(series.0[n]));
            above[g] = now[g];
            now[g] = x[g].times(V::splat(up)).multiply_add(now[g], early);
        }
    }
    let mut values = Row::ZERO;
    for g in 0..GROUPS {
        now[g].write(&mut values.0[g * LANES..]);
    }
    [*series] = combine::<V, 1>(interpolation, &[&values.0]);
}

#[inline(always)]
pub(super) fn moments_body<V: Vector>(basis: &Basis, values: &mut [Row]) {
    for values in values {
        let mut mirrored = Row::ZERO;
        for g in 0..GROUPS {
            let weights = V::read(&basis.weights[g * LANES..]);
            let opposite = V::read(&values.0[(GROUPS - 1 - g) * LANES..]).reversed();
            (weights.times(opposite)).write(&mut mirrored.0[g * LANES..]);
        }
        // Opaque, so that the compiler does not keep all polynomials from one column to the next.
        let polynomials = std::hint::black_box(&basis.values);
        values.0 = V::products_of_rows(polynomials, &mirrored);
    }
}

/// `Σ weights[k] ê_k` as factors of I and M, for several weights.
#[inline(always)]
fn blend<V: Vector, const COUNT: usize>(
    exponential: &ExponentialChunk,
    weights: &[&Row; COUNT],
) -> [[V; 2]; COUNT] {
    let mut sums = [[[V::zero(); 2]; COUNT]; 2];
    let terms = &exponential.series[..exponential.terms];
    add_terms::<V, COUNT>(terms, weights, &mut sums);
    let mut out = [[V::zero(); 2]; COUNT];
    for c in 0..COUNT {
        for i in 0..2 {
            out[c][i] = sums[0][c][i].plus(sums[1][c][i]);
        }
    }
    out
}

/// `sum + (c I + s M) u`.
#[inline(always)]
fn add_applied<V: Vector>([c, s]: [V; 2], m: &[Lanes; 4], u: [V; 2], sum: [V; 2]) -> [V; 2] {
    let mut out = sum;
    for i in 0..2 {
        let cross = V::read(&m[2 * i + 1].0).times(u[1]);
        let mu = V::read(&m[2 * i].0).multiply_add(u[0], cross);
        out[i] = c.multiply_add(u[i], s.multiply_add(mu, sum[i]));
    }
    out
}

/// A pair of lane groups.
#[inline(always)]
fn pair<V: Vector>(lanes: &[Lanes; 2]) -> [V; 2] {
    [V::read(&lanes[0].0), V::read(&lanes[1].0)]
}

#[inline(always)]
pub(super) fn cut_body<V: Vector>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    basis: &Basis,
    moments: &[Row],
    ends: &mut [[Lanes; 2]],
    columns: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    let (trajectory, tangents) = columns.split_at_mut(2 * padded);
    let tables = blocks.iter().zip(exponentials);
    for (chunk, ((block, exponential), end)) in tables.zip(&mut *ends).enumerate() {
        let m = &block.traceless;
        let rest = pair::<V>(&block.rest);
        let mut sum = rest;
        let propagator = match moments.first() {
            Some(force) => {
                let [propagator, force] = blend::<V, 2>(exponential, &[&basis.end, force]);
                sum = add_applied(force, m, pair(&block.mesh_pull), sum);
                propagator
            }
            None => blend::<V, 1>(exponential, &[&basis.end])[0],
        };
        if block.drifts {
            let [constant] = blend::<V, 1>(exponential, &[&basis.constant]);
            sum = add_applied(constant, m, pair(&block.static_input), sum);
        }
        let x = load::<V>(trajectory, padded, chunk);
        let less = V::splat(-1.0);
        let from_rest = [
            rest[0].multiply_add(less, x[0]),
            rest[1].multiply_add(less, x[1]),
        ];
        sum = add_applied(propagator, m, from_rest, sum);
        store(trajectory, padded, chunk, sum);
        let [a, b] = propagator;
        *end = [a.lanes(), b.lanes()];
    }
    in_batches!(V, tangents.len() / (2 * padded), |first| cut_batch(
        blocks,
        exponentials,
        ends,
        moments.get(1 + first..).unwrap_or(&[]),
        &mut tangents[2 * first * padded..],
    ));
}

/// Moves a batch of tangents to the end of a part.
#[inline(always)]
fn cut_batch<V: Vector, const COLUMNS: usize>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    ends: &[[Lanes; 2]],
    moments: &[Row],
    columns: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    let moments = moments.first_chunk::<COLUMNS>();
    let tables = blocks.iter().zip(exponentials);
    for (chunk, ((block, exponential), end)) in tables.zip(ends).enumerate() {
        let (m, end) = (&block.traceless, pair(end));
        let mut sums = [[V::zero(); 2]; COLUMNS];
        if let Some(moments) = moments {
            let weights = blend::<V, COLUMNS>(exponential, &moments.each_ref());
            for c in 0..COLUMNS {
                sums[c] = add_applied(weights[c], m, pair(&block.mesh_pull), sums[c]);
            }
        }
        for c in 0..COLUMNS {
            let x = &mut columns[2 * c * padded..][..2 * padded];
            let moved = add_applied(end, m, load(x, padded, chunk), sums[c]);
            store(x, padded, chunk, moved);
        }
    }
}

#[inline(always)]
pub(super) fn push_body<V: Vector>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    input: &[[Lanes; 2]],
    weights: &Row,
    x: &mut [f64],
) {
    let padded = blocks.len() * LANES;
    let tables = blocks.iter().zip(exponentials);
    for (chunk, ((block, exponential), input)) in tables.zip(input).enumerate() {
        let [weights] = blend::<V, 1>(exponential, &[weights]);
        let from = load(x, padded, chunk);
        let moved = add_applied(weights, &block.traceless, pair(input), from);
        store(x, padded, chunk, moved);
    }
}

#[inline(always)]
pub(super) fn salt_body<V: Vector>(blocks: &[BlockChunk], damping: f64, columns: &mut [f64]) {
    let padded = blocks.len() * LANES;
    for x in columns.chunks_exact_mut(2 * padded) {
        let mut sums = V::zero();
        for (chunk, block) in blocks.iter().enumerate() {
            let ([a, b], [v, w]) = (load::<V>(x, padded, chunk), pair::<V>(&block.deflection));
            sums = v.multiply_add(a, w.multiply_add(b, sums));
        }
        let kick = V::splat(damping * sums.sum());
        for (chunk, block) in blocks.iter().enumerate() {
            let ([a, b], [g, h]) = (load::<V>(x, padded, chunk), pair::<V>(&block.mesh_pull));
            let kicked = [g.multiply_add(kick, a), h.multiply_add(kick, b)];
            store(x, padded, chunk, kicked);
        }
    }
}
