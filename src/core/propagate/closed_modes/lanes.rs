//! The inner loops of closed modes. In padded states first components fill whole lane groups, then second ones.

use super::series::{AT_ONCE, GROUPS, Terms};
use crate::propagate::vectors::{InstructionSet, LANES, Lanes, Row, Vector, for_each_set};

/// The matrices of a lane group of blocks: `G = μ I + M`, `M² = s I`.
#[derive(Debug, Clone, Copy)]
pub struct Chunk {
    /// μ \[1/s\].
    pub growth: Lanes,
    /// s \[1/s²\]: −ν² of waves.
    pub square: Lanes,
    /// M, row by row \[1/s\].
    pub traceless: [Lanes; 4],
}

impl Chunk {
    /// All zero.
    pub const ZERO: Self = Self {
        growth: Lanes::ZERO,
        square: Lanes::ZERO,
        traceless: [Lanes::ZERO; 4],
    };
}

/// `e^{Gt}` of a lane group of blocks, row by row.
pub type BlockPropagator = [Lanes; 4];

/// Number of terms of the series of cos, sin, cosh and sinh.
pub const TERMS: usize = 8;

/// `1/n!`.
pub const FACTORS: [f64; 2 * TERMS] = {
    let mut factors = [1.0; 2 * TERMS];
    let (mut n, mut factorial) = (1, 1.0);
    while n < 2 * TERMS {
        factorial *= n as f64;
        factors[n] = 1.0 / factorial;
        n += 1;
    }
    factors
};

/// Largest `(|μ| + √|s|) t` of short times, for which [`TERMS`] terms of these series are exact to round-off.
pub const SHORT: f64 = 0.47;

/// Largest `(|μ| + √|s|) t` for which `e^{Gt}` is exact to round-off with three powers of G ([`Chunk`]).
pub const LITTLE: f64 = 1e-4;

/// The modes that a map between padded states mixes; it does not change the others.
#[derive(Debug)]
pub struct MixedModes {
    /// Number of modes.
    pub all: usize,
    /// The mixed modes.
    pub modes: Vec<usize>,
    /// 1 at the components of the modes that are not mixed, 0 elsewhere.
    pub alone: Vec<f64>,
}

for_each_set! {
    /// `out = map x` for each padded state. The map has one column per component. Before the map, `Σ input ·
    /// response` with the first responses is added to the first state. After the map, the sum with the second
    /// responses is subtracted.
    fn map(
        columns: &[f64],
        mixed: &MixedModes,
        responses: [&[f64]; 2],
        inputs: &[f64],
        states: &mut [f64],
        out: &mut [f64],
    ) = shifted_map_body
}

for_each_set! {
    /// Adds `factor Σ input · response` to a state.
    fn add_responses(responses: &[f64], inputs: &[f64], factor: f64, state: &mut [f64]) = add_responses_body
}

for_each_set! {
    /// The weighted sum of the series of all coordinates and inputs.
    fn series(of: &[Terms; GROUPS], weights: &[f64], out: &mut Row) = series_body
}

for_each_set! {
    /// Adds `factor (Σ row[i] x[i])` times a direction to a state x.
    fn kick(row: &[f64], direction: &[f64], factor: f64, state: &mut [f64]) = kick_body
}

#[inline(always)]
fn shifted_map_body<V: Vector>(
    columns: &[f64],
    mixed: &MixedModes,
    [before, behind]: [&[f64]; 2],
    inputs: &[f64],
    states: &mut [f64],
    out: &mut [f64],
) {
    let length = mixed.alone.len();
    add_responses_body::<V>(before, inputs, 1.0, &mut states[..length]);
    let count = states.len() / length;
    let mut first = 0;
    while first < count {
        let (rest, out) = (&states[first * length..], &mut out[first * length..]);
        first += match count - first {
            4.. if V::WIDE => map_states::<V, 4>(columns, mixed, rest, out),
            2.. if V::FUSED => map_states::<V, 2>(columns, mixed, rest, out),
            _ => map_states::<V, 1>(columns, mixed, rest, out),
        };
    }
    add_responses_body::<V>(behind, inputs, -1.0, &mut out[..length]);
}

/// Number of sums that fit into registers with a weight of each state: 32 registers of a lane group, 16 of half a
/// group, or 16 of a quarter.
const fn most_sums<V: Vector>() -> usize {
    if V::WIDE {
        20
    } else if V::FUSED {
        6
    } else {
        3
    }
}

/// Maps a batch of states. Processes as many lane groups of rows at a time as fit into registers with their
/// sums. Returns the number of states.
#[inline(always)]
fn map_states<V: Vector, const COUNT: usize>(
    columns: &[f64],
    mixed: &MixedModes,
    states: &[f64],
    out: &mut [f64],
) -> usize {
    let mut row = 0;
    while row < mixed.alone.len() {
        let left = (mixed.alone.len() - row) / LANES;
        row += match left.min(most_sums::<V>() / COUNT) {
            10.. => map_rows::<V, COUNT, 10>(columns, mixed, states, row, out),
            6.. => map_rows::<V, COUNT, 6>(columns, mixed, states, row, out),
            4.. => map_rows::<V, COUNT, 4>(columns, mixed, states, row, out),
            3 => map_rows::<V, COUNT, 3>(columns, mixed, states, row, out),
            2 => map_rows::<V, COUNT, 2>(columns, mixed, states, row, out),
            _ => map_rows::<V, COUNT, 1>(columns, mixed, states, row, out),
        };
    }
    COUNT
}

/// Maps G lane groups of rows, from `row` on, for COUNT states; returns the number of rows. The sums of each state are
/// formed in the same order for every COUNT and G, so that results have the same bits.
#[inline(always)]
fn map_rows<V: Vector, const COUNT: usize, const G: usize>(
    columns: &[f64],
    mixed: &MixedModes,
    states: &[f64],
    row: usize,
    out: &mut [f64],
) -> usize {
    let length = mixed.alone.len();
    // The columns of all first components lie before those of all second ones.
    for way in 0..2 {
        let columns = &columns[way * mixed.all * length + row..];
        let components = &states[way * (length / 2)..];
        let mut sums = [[V::zero(); G]; COUNT];
        for &j in &mixed.modes {
            let column = &columns[j * length..][..G * LANES];
            let mut weights = [V::zero(); COUNT];
            for c in 0..COUNT {
                weights[c] = V::splat(components[c * length + j]);
            }
            for g in 0..G {
                let numbers = V::read(&column[g * LANES..]);
                for c in 0..COUNT {
                    sums[c][g] = numbers.multiply_add(weights[c], sums[c][g]);
                }
            }
        }
        for c in 0..COUNT {
            for g in 0..G {
                let (at, place) = (row + g * LANES, c * length + row + g * LANES);
                let before = match way {
                    0 => V::read(&mixed.alone[at..]).times(V::read(&states[place..])),
                    _ => V::read(&out[place..]),
                };
                before.plus(sums[c][g]).write(&mut out[place..]);
            }
        }
    }
    G * LANES
}

#[inline(always)]
fn add_responses_body<V: Vector>(
    responses: &[f64],
    inputs: &[f64],
    factor: f64,
    state: &mut [f64],
) {
    let length = state.len();
    for (at, x) in (0..length)
        .step_by(LANES)
        .zip(state.chunks_exact_mut(LANES))
    {
        let mut sum = V::zero();
        for (response, input) in responses.chunks_exact(length).zip(inputs) {
            sum = V::read(&response[at..]).multiply_add(V::splat(*input), sum);
        }
        sum.multiply_add(V::splat(factor), V::read(x)).write(x);
    }
}

#[inline(always)]
fn series_body<V: Vector>(of: &[Terms; GROUPS], weights: &[f64], out: &mut Row) {
    let mut sums = [[V::zero(); GROUPS]; AT_ONCE];
    add_series::<V, 1>(&of[0], weights, &mut sums);
    add_series::<V, 2>(&of[1], weights, &mut sums);
    add_series::<V, 3>(&of[2], weights, &mut sums);
    for g in 0..GROUPS {
        let sum = (sums[0][g].plus(sums[1][g])).plus(sums[2][g].plus(sums[3][g]));
        sum.write(&mut out.0[g * LANES..]);
    }
}

/// Adds the series that have G groups of terms.
#[inline(always)]
fn add_series<V: Vector, const G: usize>(
    terms: &Terms,
    weights: &[f64],
    sums: &mut [[V; GROUPS]; AT_ONCE],
) {
    let rows = terms.rows.chunks_exact(AT_ONCE * G);
    for (places, rows) in terms.places.chunks_exact(AT_ONCE).zip(rows) {
        for way in 0..AT_ONCE {
            let weight = V::splat(weights[places[way]]);
            for g in 0..G {
                sums[way][g] = V::read(&rows[way * G + g].0).multiply_add(weight, sums[way][g]);
            }
        }
    }
}

/// `x = e^{Gt} x` of all states, with tabulated matrices.
#[inline(always)]
pub fn advance_body<V: Vector>(moves: &[BlockPropagator], states: &mut [f64]) {
    let half = moves.len() * LANES;
    for state in states.chunks_exact_mut(2 * half) {
        let (first, second) = state.split_at_mut(half);
        for ((e, a), b) in (moves.iter())
            .zip(first.chunks_exact_mut(LANES))
            .zip(second.chunks_exact_mut(LANES))
        {
            let [x, y] = applied(&read(e), [V::read(a), V::read(b)]);
            x.write(a);
            y.write(b);
        }
    }
}

/// `e^{Gt}` of a lane group for a short time, row by row, with [`TERMS`] terms.
#[inline(always)]
fn exponential<V: Vector>(chunk: &Chunk, time: V) -> [V; 4] {
    let x = V::read(&chunk.growth.0).times(time);
    let square = V::read(&chunk.square.0).times(time).times(time);
    let x_square = x.times(x);
    // The four series do not depend on each other: cosh and sinh/x of μt, cos and sin/x of νt.
    let a = V::splat(FACTORS[2 * TERMS - 2]);
    let b = V::splat(FACTORS[2 * TERMS - 1]);
    let (mut even, mut odd, mut grown_even, mut grown_odd) = (a, b, a, b);
    for k in (0..TERMS - 1).rev() {
        let a = V::splat(FACTORS[2 * k]);
        let b = V::splat(FACTORS[2 * k + 1]);
        even = even.multiply_add(square, a);
        odd = odd.multiply_add(square, b);
        grown_even = grown_even.multiply_add(x_square, a);
        grown_odd = grown_odd.multiply_add(x_square, b);
    }
    let grown = grown_odd.multiply_add(x, grown_even);
    let (even, odd) = (grown.times(even), grown.times(odd).times(time));
    let [a, b, c, d] = read::<V>(&chunk.traceless);
    [
        a.multiply_add(odd, even),
        b.times(odd),
        c.times(odd),
        d.multiply_add(odd, even),
    ]
}

/// A 2 × 2 matrix times a pair.
#[inline(always)]
pub fn applied<V: Vector>(e: &[V; 4], [x, y]: [V; 2]) -> [V; 2] {
    [
        e[1].multiply_add(y, e[0].times(x)),
        e[3].multiply_add(y, e[2].times(x)),
    ]
}

/// Reads the matrices of a lane group from a table.
#[inline(always)]
pub fn read<V: Vector>(propagator: &BlockPropagator) -> [V; 4] {
    let [a, b, c, d] = propagator;
    [V::read(&a.0), V::read(&b.0), V::read(&c.0), V::read(&d.0)]
}

/// A lane group of first components and the group of second ones.
#[inline(always)]
pub fn pair<V: Vector>(state: &[f64], half: usize, index: usize) -> [V; 2] {
    let at = index * LANES;
    [V::read(&state[at..]), V::read(&state[half + at..])]
}

#[inline(always)]
fn kick_body<V: Vector>(row: &[f64], direction: &[f64], factor: f64, state: &mut [f64]) {
    let mut total = V::zero();
    for (w, x) in row.chunks_exact(LANES).zip(state.chunks_exact(LANES)) {
        total = V::read(w).multiply_add(V::read(x), total);
    }
    let by = V::splat(factor * total.sum());
    for (g, x) in (direction.chunks_exact(LANES)).zip(state.chunks_exact_mut(LANES)) {
        V::read(g).multiply_add(by, V::read(x)).write(x);
    }
}

/// `out = e^{Gt} x` of all states for a short time, after `before` if given. Returns the products of three rows with the
/// new first state.
#[inline(always)]
pub fn advance_to_body<V: Vector>(
    chunks: &[Chunk],
    before: Option<&[BlockPropagator]>,
    time: f64,
    rows: &[Vec<f64>; 3],
    states: &[f64],
    out: &mut [f64],
) -> [f64; 3] {
    let half = chunks.len() * LANES;
    let t = V::splat(time);
    let mut sums = [V::zero(); 3];
    for (index, chunk) in chunks.iter().enumerate() {
        let propagator = exponential(chunk, t);
        let at = index * LANES;
        for place in 0..states.len() / (2 * half) {
            let state = &states[place * 2 * half..][..2 * half];
            let out = &mut out[place * 2 * half..][..2 * half];
            let mut x = pair::<V>(state, half, index);
            if let Some(before) = before {
                x = applied(&read(&before[index]), x);
            }
            let [x, y] = applied(&propagator, x);
            x.write(&mut out[at..]);
            y.write(&mut out[half + at..]);
            if place == 0 {
                for k in 0..3 {
                    let [a, b] = pair::<V>(&rows[k], half, index);
                    sums[k] = b.multiply_add(y, a.multiply_add(x, sums[k]));
                }
            }
        }
    }
    [sums[0].sum(), sums[1].sum(), sums[2].sum()]
}

/// `x = (I + G t + G² t² / 2 + G³ t³ / 6) x` of all states, for a time so short that this is exact to round-off.
#[inline(always)]
pub fn advance_little_body<V: Vector>(chunks: &[Chunk], time: f64, states: &mut [f64]) {
    let half = chunks.len() * LANES;
    let whole = V::splat(time);
    let half_time = V::splat(0.5 * time);
    let third = V::splat(time / 3.0);
    for (index, chunk) in chunks.iter().enumerate() {
        let mut generator = read::<V>(&chunk.traceless);
        let growth = V::read(&chunk.growth.0);
        generator[0] = generator[0].plus(growth);
        generator[3] = generator[3].plus(growth);
        let at = index * LANES;
        for state in states.chunks_exact_mut(2 * half) {
            let [x, y] = pair::<V>(state, half, index);
            let [a, b] = applied(&generator, [x, y]);
            let [c, d] = applied(&generator, [a, b]);
            let [e, f] = applied(&generator, [c, d]);
            let (c, d) = (e.multiply_add(third, c), f.multiply_add(third, d));
            let (a, b) = (c.multiply_add(half_time, a), d.multiply_add(half_time, b));
            a.multiply_add(whole, x).write(&mut state[at..]);
            b.multiply_add(whole, y).write(&mut state[half + at..]);
        }
    }
}
