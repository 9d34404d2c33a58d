//! The inner loops of closed modes. States are padded: first components in whole lane groups, then second ones.

use super::series::{AT_ONCE, GROUPS, Terms};
use crate::propagate::vectors::{InstructionSet, LANES, Lanes, Row, Vector, for_each_set};

/// What a lane group of blocks is made of: `G = μ I + M`, `M² = s I`.
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
pub type Move = [Lanes; 4];

/// Terms of cos, sin, cosh and sinh.
const TERMS: usize = 8;

/// Largest `(|μ| + √|s|) t` of short times, for which these series are exact to round-off.
pub const SHORT: f64 = 0.47;

/// Terms for times that are shorter still.
const FEW_TERMS: usize = 4;

/// Part of a short time up to which these are exact to round-off.
pub const NEAR: f64 = 0.06;

for_each_set! {
    /// `out = map x`, one padded state after another; the map has a column of as many numbers for
    /// each of the `modes` first and second components. The first state moves by `Σ input · response` with the first
    /// responses before that, and back with the others behind it.
    fn map(
        columns: &[f64],
        modes: usize,
        responses: [&[f64]; 2],
        inputs: &[f64],
        states: &mut [f64],
        out: &mut [f64],
    ) = shifted_map_body
}

for_each_set! {
    /// Adds `factor Σ input · response` to a state, of one response after another.
    fn shift(responses: &[f64], inputs: &[f64], factor: f64, state: &mut [f64]) = shift_body
}

for_each_set! {
    /// Amplitudes of all blocks.
    fn amplitudes(balances: &[Move], state: &[f64], out: &mut [f64]) = amplitudes_body
}

for_each_set! {
    /// What a line sees on a block: deflections at the nodes by `nodes`, a row for each coordinate and input; and
    /// `Σ amplitude · bound` for both bounds.
    fn see(
        nodes: &[Lanes],
        bounds: [&[f64]; 2],
        state: &[f64],
        inputs: &[f64],
        amplitudes: &[f64],
        out: &mut Lanes,
    ) -> [f64; 2] = see_body
}

for_each_set! {
    /// A series as the sum of those of all coordinates and inputs, each times its weight.
    fn series(of: &[Terms; GROUPS], weights: &[f64], out: &mut Row) = series_body
}

for_each_set! {
    /// Intervals between nodes, the first one in bit 0, on which the margin `scale δ + shift` may come to the round-off
    /// `noise`, if its curvature bends it by `sag` below a chord at most: [`super::search::stays`] for all of them.
    fn open(start: f64, nodes: &Lanes, margin: [f64; 2], sag: f64, noise: f64) -> u32 = open_body
}

for_each_set! {
    /// `Σ a[i] b[i]` and `Σ a[i] c[i]`, lengths of whole lane groups.
    fn two_products(a: &[f64], b: &[f64], c: &[f64]) -> [f64; 2] = two_products_body
}

for_each_set! {
    /// The same with `e^{Gt}` of a state instead of it, for a time of which few terms are enough.
    fn products_near(chunks: &[Chunk], time: f64, state: &[f64], rows: [&[f64]; 2]) -> [f64; 2]
        = products_near_body
}

for_each_set! {
    /// `x = e^{Gt} x` of all states by a table.
    fn advance(moves: &[Move], states: &mut [f64]) = advance_body
}

for_each_set! {
    /// `out = e^{Gt} x` of all states for a short time, behind `before` where there is one.
    fn advance_by(
        chunks: &[Chunk],
        before: Option<&[Move]>,
        time: f64,
        states: &[f64],
        out: &mut [f64],
    ) = advance_by_body
}

for_each_set! {
    /// `x = e^{Gt} x` of all states, for a time of which few terms are enough.
    fn advance_near(chunks: &[Chunk], time: f64, states: &mut [f64]) = advance_near_body
}

#[inline(always)]
fn shifted_map_body<V: Vector>(
    columns: &[f64],
    modes: usize,
    [before, behind]: [&[f64]; 2],
    inputs: &[f64],
    states: &mut [f64],
    out: &mut [f64],
) {
    let length = columns.len() / (2 * modes);
    shift_body::<V>(before, inputs, 1.0, &mut states[..length]);
    map_body::<V>(columns, modes, states, out);
    shift_body::<V>(behind, inputs, -1.0, &mut out[..length]);
}

#[inline(always)]
fn map_body<V: Vector>(columns: &[f64], modes: usize, states: &[f64], out: &mut [f64]) {
    let length = columns.len() / (2 * modes);
    let count = states.len() / length;
    let mut first = 0;
    while first < count {
        let (own, out) = (&states[first * length..], &mut out[first * length..]);
        first += match count - first {
            4.. if V::WIDE => map_states::<V, 4, 3>(columns, modes, own, out),
            2.. if V::WIDE => map_states::<V, 2, 5>(columns, modes, own, out),
            _ => map_states::<V, 1, 5>(columns, modes, own, out),
        };
    }
}

/// A batch of states, so many lane groups of rows after one another that the registers hold their sums. Returns their
/// count.
#[inline(always)]
fn map_states<V: Vector, const COUNT: usize, const GROUPS: usize>(
    columns: &[f64],
    modes: usize,
    states: &[f64],
    out: &mut [f64],
) -> usize {
    let length = columns.len() / (2 * modes);
    let mut row = 0;
    while row + GROUPS * LANES <= length {
        map_rows::<V, COUNT, GROUPS>(columns, modes, states, row, out);
        row += GROUPS * LANES;
    }
    while row + 2 * LANES <= length {
        map_rows::<V, COUNT, 2>(columns, modes, states, row, out);
        row += 2 * LANES;
    }
    if row < length {
        map_rows::<V, COUNT, 1>(columns, modes, states, row, out);
    }
    COUNT
}

/// Some lane groups of rows. Each state has its sums in the same order in every batch.
#[inline(always)]
fn map_rows<V: Vector, const COUNT: usize, const G: usize>(
    columns: &[f64],
    modes: usize,
    states: &[f64],
    row: usize,
    out: &mut [f64],
) {
    let length = columns.len() / (2 * modes);
    // The sums of first and second components side by side hide the latency of the multiply-add.
    let mut sums = [[[V::zero(); G]; COUNT]; 2];
    let (firsts, seconds) = columns.split_at(modes * length);
    let pairs = firsts
        .chunks_exact(length)
        .zip(seconds.chunks_exact(length));
    for (j, (first, second)) in pairs.enumerate() {
        for (way, column) in [first, second].into_iter().enumerate() {
            let column = &column[row..row + G * LANES];
            let mut numbers = [V::zero(); G];
            for g in 0..G {
                numbers[g] = V::read(&column[g * LANES..]);
            }
            for c in 0..COUNT {
                let weight = V::splat(states[c * length + way * (length / 2) + j]);
                for g in 0..G {
                    sums[way][c][g] = numbers[g].multiply_add(weight, sums[way][c][g]);
                }
            }
        }
    }
    for c in 0..COUNT {
        for g in 0..G {
            let sum = sums[0][c][g].plus(sums[1][c][g]);
            sum.write(&mut out[c * length + row + g * LANES..]);
        }
    }
}

#[inline(always)]
fn shift_body<V: Vector>(responses: &[f64], inputs: &[f64], factor: f64, state: &mut [f64]) {
    for (response, input) in responses.chunks_exact(state.len()).zip(inputs) {
        let weight = V::splat(factor * input);
        for (x, r) in state
            .chunks_exact_mut(LANES)
            .zip(response.chunks_exact(LANES))
        {
            V::read(r).multiply_add(weight, V::read(x)).write(x);
        }
    }
}

#[inline(always)]
fn amplitudes_body<V: Vector>(balances: &[Move], state: &[f64], out: &mut [f64]) {
    let (first, second) = state.split_at(out.len());
    for (index, (balance, out)) in balances.iter().zip(out.chunks_exact_mut(LANES)).enumerate() {
        let at = index * LANES;
        let pair = [V::read(&first[at..]), V::read(&second[at..])];
        let [a, b] = applied(&read(balance), pair);
        a.multiply_add(a, b.times(b)).root().write(out);
    }
}

#[inline(always)]
fn see_body<V: Vector>(
    nodes: &[Lanes],
    [size, curvature]: [&[f64]; 2],
    state: &[f64],
    inputs: &[f64],
    amplitudes: &[f64],
    out: &mut Lanes,
) -> [f64; 2] {
    let mut sums = [V::zero(); 4];
    let (own, others) = nodes.split_at(state.len());
    for (rows, weights) in own.chunks_exact(4).zip(state.chunks_exact(4)) {
        for way in 0..4 {
            sums[way] = V::read(&rows[way].0).multiply_add(V::splat(weights[way]), sums[way]);
        }
    }
    for (row, weight) in others.iter().zip(inputs) {
        sums[0] = V::read(&row.0).multiply_add(V::splat(*weight), sums[0]);
    }
    *out = sums[0].plus(sums[1]).plus(sums[2].plus(sums[3])).lanes();
    two_products_body::<V>(amplitudes, size, curvature)
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

/// Adds series of G groups of terms.
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

#[inline(always)]
fn open_body<V: Vector>(
    start: f64,
    nodes: &Lanes,
    [scale, shift]: [f64; 2],
    sag: f64,
    noise: f64,
) -> u32 {
    let b = V::read(&nodes.0).multiply_add(V::splat(scale), V::splat(shift));
    let a = b.behind(scale * start + shift);
    let difference = b.multiply_add(V::splat(-1.0), a).size();
    // The lowest point of the parabola that sags most, where it lies between the ends.
    let bend = V::splat(-1.0 / (16.0 * sag).max(f64::MIN_POSITIVE));
    let lowest = difference
        .times(difference)
        .multiply_add(bend, a.plus(b).multiply_add(V::splat(0.5), V::splat(-sag)));
    let zero = V::zero();
    let bends = !V::splat(4.0 * sag).at_most(difference) & 0xff;
    a.at_most(zero) | b.at_most(zero) | (bends & lowest.at_most(V::splat(noise)))
}

#[inline(always)]
fn two_products_body<V: Vector>(a: &[f64], b: &[f64], c: &[f64]) -> [f64; 2] {
    let mut sums = [V::zero(); 2];
    for ((a, b), c) in (a.chunks_exact(LANES))
        .zip(b.chunks_exact(LANES))
        .zip(c.chunks_exact(LANES))
    {
        let a = V::read(a);
        sums[0] = V::read(b).multiply_add(a, sums[0]);
        sums[1] = V::read(c).multiply_add(a, sums[1]);
    }
    sums.map(V::sum)
}

#[inline(always)]
fn advance_body<V: Vector>(moves: &[Move], states: &mut [f64]) {
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

/// `e^{Gt}` of a lane group for a short time, row by row, by so many terms.
#[inline(always)]
fn exponential<V: Vector, const TERMS: usize>(chunk: &Chunk, time: V) -> [V; 4] {
    let one = V::splat(1.0);
    let x = V::read(&chunk.growth.0).times(time);
    let square = V::read(&chunk.square.0).times(time).times(time);
    let x_square = x.times(x);
    // Four short chains side by side: cosh and sinh/x of μt, cos and sin/x of νt.
    let (mut even, mut odd, mut grown_even, mut grown_odd) = (one, one, one, one);
    for k in (1..TERMS).rev() {
        let (a, b) = ((2 * k - 1) * 2 * k, 2 * k * (2 * k + 1));
        let (a, b) = (V::splat(1.0 / a as f64), V::splat(1.0 / b as f64));
        even = square.times(a).multiply_add(even, one);
        odd = square.times(b).multiply_add(odd, one);
        grown_even = x_square.times(a).multiply_add(grown_even, one);
        grown_odd = x_square.times(b).multiply_add(grown_odd, one);
    }
    let grown = grown_odd.multiply_add(x, grown_even);
    let (even, odd) = (grown.times(even), grown.times(odd).times(time));
    let m = |k: usize| V::read(&chunk.traceless[k].0);
    [
        m(0).multiply_add(odd, even),
        m(1).times(odd),
        m(2).times(odd),
        m(3).multiply_add(odd, even),
    ]
}

/// A 2 × 2 matrix times a pair.
#[inline(always)]
fn applied<V: Vector>(e: &[V; 4], [x, y]: [V; 2]) -> [V; 2] {
    [
        e[1].multiply_add(y, e[0].times(x)),
        e[3].multiply_add(y, e[2].times(x)),
    ]
}

/// A table's matrix of a lane group.
#[inline(always)]
fn read<V: Vector>(own: &Move) -> [V; 4] {
    let [a, b, c, d] = own;
    [V::read(&a.0), V::read(&b.0), V::read(&c.0), V::read(&d.0)]
}

#[inline(always)]
fn products_near_body<V: Vector>(
    chunks: &[Chunk],
    time: f64,
    state: &[f64],
    [row, rate]: [&[f64]; 2],
) -> [f64; 2] {
    let half = chunks.len() * LANES;
    let t = V::splat(time);
    let mut sums = [V::zero(); 2];
    for (index, chunk) in chunks.iter().enumerate() {
        let pair = |from: &[f64]| {
            let at = index * LANES;
            [V::read(&from[at..]), V::read(&from[half + at..])]
        };
        let [x, y] = applied(&exponential::<V, FEW_TERMS>(chunk, t), pair(state));
        let ([a, b], [c, d]) = (pair(row), pair(rate));
        sums[0] = b.multiply_add(y, a.multiply_add(x, sums[0]));
        sums[1] = d.multiply_add(y, c.multiply_add(x, sums[1]));
    }
    sums.map(V::sum)
}

#[inline(always)]
fn advance_by_body<V: Vector>(
    chunks: &[Chunk],
    before: Option<&[Move]>,
    time: f64,
    states: &[f64],
    out: &mut [f64],
) {
    let half = chunks.len() * LANES;
    let t = V::splat(time);
    for (index, chunk) in chunks.iter().enumerate() {
        let own = exponential::<V, TERMS>(chunk, t);
        let at = index * LANES;
        for (state, out) in (states.chunks_exact(2 * half)).zip(out.chunks_exact_mut(2 * half)) {
            let mut x = [V::read(&state[at..]), V::read(&state[half + at..])];
            if let Some(before) = before {
                x = applied(&read(&before[index]), x);
            }
            let [x, y] = applied(&own, x);
            x.write(&mut out[at..]);
            y.write(&mut out[half + at..]);
        }
    }
}

#[inline(always)]
fn advance_near_body<V: Vector>(chunks: &[Chunk], time: f64, states: &mut [f64]) {
    let half = chunks.len() * LANES;
    let t = V::splat(time);
    for (index, chunk) in chunks.iter().enumerate() {
        let own = exponential::<V, FEW_TERMS>(chunk, t);
        let at = index * LANES;
        for state in states.chunks_exact_mut(2 * half) {
            let x = [V::read(&state[at..]), V::read(&state[half + at..])];
            let [x, y] = applied(&own, x);
            x.write(&mut state[at..]);
            y.write(&mut state[half + at..]);
        }
    }
}
