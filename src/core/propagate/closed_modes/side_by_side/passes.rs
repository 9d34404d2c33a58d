//! The vector loops: eight points, one in each lane.
//!
//! A lane advances in steps as long as its margins are certain to stay positive. The cubic with the values and rates of a
//! margin at both ends of a step is near the margin: the bound of the difference is in a table ([`super::tables`]). The
//! cubic lies between its Bernstein coefficients. A lane stops before a step for which this is not certain, or in which it
//! reaches its limit: the next breakpoint or the end of the pass. The Taylor series from the nearer end of that step then
//! leads to the event or to the limit.
//!
//! No operation mixes lanes, so a point has the same results beside any others.

use super::cubics::{Cubic, FROM_ZERO, falls, guess, is_clear, parts};
use super::tables::{MOST_FREQUENCIES, MOST_LENGTH, MOST_MODES, MOST_WATCHED, PointTables, Shape};
use crate::propagate::vectors::{InstructionSet, LANES, Lanes, Vector, for_each_set};

/// Terms of the Taylor series over half a step.
const TERMS: usize = 15;

/// Largest number of Newton's steps.
const MOST_STEPS: u32 = 40;

/// Newton's step, as a part of the step, after which a root is exact to round-off.
const CONVERGED: f64 = 1e-9;

/// The numbers of eight lanes.
#[derive(Debug)]
pub struct LaneNumbers {
    pub shape: Shape,
    /// The system of each lane whose tables are loaded, and these tables.
    pub sets: [Option<usize>; LANES],
    pub columns: Vec<Lanes>,
    /// Each frequency \[rad/s\], and the cosine and sine of its turn over a step.
    pub turns: Vec<[Lanes; 3]>,
    /// z.
    pub z: Vec<Lanes>,
    /// z at the end of the step.
    pub next: Vec<Lanes>,
    /// Tangents, one after the other.
    pub tangents: Vec<Lanes>,
    /// Number of tangents that some lane has.
    pub tangent_count: usize,
    /// Step \[s\].
    pub step: Lanes,
    /// Time left until a lane's limit \[s\].
    pub left: Lanes,
    /// Margins and their rates.
    pub margins: [Lanes; MOST_WATCHED],
    pub rates: [Lanes; MOST_WATCHED],
    /// Lanes in which each watched contact has just opened or closed.
    pub crossed: [u32; MOST_WATCHED],
    /// Margins and rates at the end of the step, and the bound of the error in between.
    pub ends: [Lanes; MOST_WATCHED],
    pub end_rates: [Lanes; MOST_WATCHED],
    pub errors: [Lanes; MOST_WATCHED],
    /// Row of the margin whose root a lane moves to.
    root_row: Vec<Lanes>,
    /// Terms of the series of z.
    terms: Vec<Lanes>,
}

impl LaneNumbers {
    /// Numbers of lanes without points.
    pub fn new(shape: Shape) -> Self {
        let zeros = |count: usize| vec![Lanes::ZERO; count];
        let one = Lanes([1.0; LANES]);
        Self {
            sets: [None; LANES],
            columns: zeros(shape.numbers()),
            turns: vec![[Lanes::ZERO; 3]; shape.frequencies],
            z: zeros(shape.length()),
            next: zeros(shape.length()),
            tangents: zeros(shape.state() * shape.state()),
            tangent_count: 0,
            step: one,
            left: one,
            margins: [one; MOST_WATCHED],
            rates: [Lanes::ZERO; MOST_WATCHED],
            crossed: [0; MOST_WATCHED],
            ends: [one; MOST_WATCHED],
            end_rates: [Lanes::ZERO; MOST_WATCHED],
            errors: [Lanes::ZERO; MOST_WATCHED],
            root_row: zeros(shape.length()),
            terms: zeros(TERMS * shape.length()),
            shape,
        }
    }

    /// Loads the step and the turns of a point into a lane.
    pub fn load(&mut self, index: usize, tables: &PointTables) {
        self.sets[index] = None;
        self.step.0[index] = tables.step;
        for (to, turn) in self.turns.iter_mut().zip(&tables.turns) {
            for (to, value) in to.iter_mut().zip(turn) {
                to.0[index] = *value;
            }
        }
    }

    /// Rows of a watched contact: its margin, the rate, and the bound of the error.
    #[inline(always)]
    fn rows(&self, watched: usize) -> [&[Lanes]; 3] {
        let length = self.shape.length();
        let from = &self.columns[self.shape.rows(watched)..];
        [
            &from[..length],
            &from[length..2 * length],
            &from[2 * length..3 * length],
        ]
    }
}

/// Masks of the lanes that have stopped, and why.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stops {
    /// Lanes that have moved to an event, to their limit or to the end of a step.
    pub moved: u32,
    /// Lanes in which each watched margin has fallen to zero.
    pub fallen: [u32; MOST_WATCHED],
    /// Lanes whose next event is not certain.
    pub lost: u32,
}

/// Moves of lanes within their steps.
#[derive(Clone, Copy)]
struct Moves<V> {
    /// The lanes.
    lanes: u32,
    /// Lanes that move to a root of a margin.
    roots: u32,
    /// Times \[s\] to which the lanes move, from the start of the step. For roots, these are estimates.
    time: V,
    /// Largest times \[s\].
    most: V,
}

for_each_set! {
    /// Advances the running lanes by whole steps until most of them have stopped, and moves these within their steps.
    fn advance(of: &mut LaneNumbers, running: u32) -> Stops = advance_body
}

for_each_set! {
    /// Margins of lanes at their present states.
    fn margins(of: &mut LaneNumbers, lanes: u32) = margins_body
}

/// Calls a function with the numbers of modes and frequencies of a shape as constants.
macro_rules! for_shape {
    ($shape:expr, $function:ident($($argument:expr),*)) => {
        match ($shape.modes, $shape.frequencies) {
            (1, 1) => $function::<V, 1, 1>($($argument),*),
            (1, _) => $function::<V, 1, MOST_FREQUENCIES>($($argument),*),
            (2, 1) => $function::<V, 2, 1>($($argument),*),
            (2, _) => $function::<V, 2, MOST_FREQUENCIES>($($argument),*),
            (_, 1) => $function::<V, MOST_MODES, 1>($($argument),*),
            _ => $function::<V, MOST_MODES, MOST_FREQUENCIES>($($argument),*),
        }
    };
}

#[inline(always)]
fn advance_body<V: Vector>(of: &mut LaneNumbers, running: u32) -> Stops {
    for_shape!(of.shape, advance_of(of, running))
}

#[inline(always)]
fn margins_body<V: Vector>(of: &mut LaneNumbers, lanes: u32) {
    for_shape!(of.shape, margins_of(of, lanes));
}

#[inline(always)]
fn advance_of<V: Vector, const N: usize, const F: usize>(
    of: &mut LaneNumbers,
    running: u32,
) -> Stops {
    let stopped = steps_of::<V, N, F>(of, running);
    let (mut stops, moves) = decide::<V>(of, stopped);
    if moves.lanes == 0 {
        return stops;
    }
    let lost = finish_of::<V, N, F>(of, &moves);
    stops.lost |= lost;
    stops.moved = moves.lanes & !lost;
    stops
}

#[inline(always)]
fn read<V: Vector>(from: &[Lanes], count: usize) -> [V; MOST_LENGTH] {
    let (mut out, from) = ([V::zero(); MOST_LENGTH], &from[..count]);
    for j in 0..count {
        out[j] = V::read(&from[j].0);
    }
    out
}

/// Length of z.
const fn length(modes: usize, frequencies: usize) -> usize {
    2 * modes + 1 + 2 * frequencies
}

/// `row z` for a z whose constant is `constant`.
#[inline(always)]
fn along<V: Vector, const N: usize, const F: usize>(
    row: &[Lanes],
    z: &[V; MOST_LENGTH],
    constant: V,
) -> V {
    let row = &row[..length(N, F)];
    let mut sum = V::read(&row[2 * N].0).times(constant);
    for j in 0..2 * N {
        sum = V::read(&row[j].0).multiply_add(z[j], sum);
    }
    for j in 2 * N + 1..length(N, F) {
        sum = V::read(&row[j].0).multiply_add(z[j], sum);
    }
    sum
}

/// A matrix over z times a modal state.
#[inline(always)]
fn mapped<V: Vector, const N: usize, const F: usize>(
    rows: &[Lanes],
    x: &[V; MOST_LENGTH],
) -> [V; MOST_LENGTH] {
    let rows = &rows[..2 * N * length(N, F)];
    let mut out = [V::zero(); MOST_LENGTH];
    for i in 0..2 * N {
        let mut sum = V::read(&rows[i * length(N, F)].0).times(x[0]);
        for j in 1..2 * N {
            sum = V::read(&rows[i * length(N, F) + j].0).multiply_add(x[j], sum);
        }
        out[i] = sum;
    }
    out
}

#[inline(always)]
fn steps_of<V: Vector, const N: usize, const F: usize>(of: &mut LaneNumbers, running: u32) -> u32 {
    let length = length(N, F);
    let (step, third) = (
        V::read(&of.step.0),
        V::read(&of.step.0).times(V::splat(1.0 / 3.0)),
    );
    let mut z = read::<V>(&of.z, length);
    let mut left = V::read(&of.left.0);
    let enough = (3 * running.count_ones()).div_ceil(4);
    loop {
        let mut next = [V::zero(); MOST_LENGTH];
        for i in 0..2 * N {
            next[i] = along::<V, N, F>(&of.columns[i * length..][..length], &z, V::splat(1.0));
        }
        next[2 * N] = V::splat(1.0);
        let turns = &of.turns[..F];
        for h in 0..F {
            let [_, cos, sin] = &turns[h];
            let (at, cos, sin) = (2 * N + 1 + 2 * h, V::read(&cos.0), V::read(&sin.0));
            next[at] = cos.times(z[at]).minus(sin.times(z[at + 1]));
            next[at + 1] = cos.multiply_add(z[at + 1], sin.times(z[at]));
        }
        let mut sizes = [V::zero(); MOST_LENGTH];
        for j in 0..length {
            sizes[j] = z[j].size();
        }
        let mut clear = running;
        for w in 0..of.shape.watched {
            let [margin, rate, bound] = of.rows(w);
            let end = along::<V, N, F>(margin, &next, V::splat(1.0));
            let end_rate = along::<V, N, F>(rate, &next, V::splat(1.0));
            let error = along::<V, N, F>(bound, &sizes, V::splat(1.0));
            let cubic = cubic(of, w, third, [end, end_rate]);
            let scaled = error.times(V::splat(FROM_ZERO));
            clear &= is_clear(&cubic, of.crossed[w], error, scaled);
            end.write(&mut of.ends[w].0);
            end_rate.write(&mut of.end_rates[w].0);
            error.write(&mut of.errors[w].0);
        }
        let goes = clear & !left.at_most(step);
        for j in 0..length {
            next[j].write(&mut of.next[j].0);
            z[j] = next[j].chosen(goes, z[j]);
        }
        left = left.minus(step).chosen(goes, left);
        for w in 0..of.shape.watched {
            let (end, rate) = (V::read(&of.ends[w].0), V::read(&of.end_rates[w].0));
            put(end, goes, &mut of.margins[w]);
            put(rate, goes, &mut of.rates[w]);
            of.crossed[w] &= !goes;
        }
        for tangent in of.tangents.chunks_exact_mut(2 * N).take(of.tangent_count) {
            let x = read::<V>(tangent, 2 * N);
            let y = mapped::<V, N, F>(&of.columns, &x);
            for i in 0..2 * N {
                y[i].chosen(goes, x[i]).write(&mut tangent[i].0);
            }
        }
        let stopped = running & !goes;
        if stopped.count_ones() >= enough {
            for j in 0..length {
                z[j].write(&mut of.z[j].0);
            }
            left.write(&mut of.left.0);
            return stopped;
        }
    }
}

/// Writes numbers to some lanes.
#[inline(always)]
fn put<V: Vector>(numbers: V, lanes: u32, to: &mut Lanes) {
    numbers.chosen(lanes, V::read(&to.0)).write(&mut to.0);
}

/// The cubic with the values and rates of a margin at both ends of a step.
#[inline(always)]
fn cubic<V: Vector>(
    of: &LaneNumbers,
    watched: usize,
    third_of_step: V,
    [end, end_rate]: [V; 2],
) -> Cubic<V> {
    let start = V::read(&of.margins[watched].0);
    let second = third_of_step.multiply_add(V::read(&of.rates[watched].0), start);
    [start, second, end.minus(third_of_step.times(end_rate)), end]
}

#[inline(always)]
fn margins_of<V: Vector, const N: usize, const F: usize>(of: &mut LaneNumbers, lanes: u32) {
    let z = read::<V>(&of.z, length(N, F));
    for w in 0..of.shape.watched {
        let [margin, rate, _] = of.rows(w);
        let margin = along::<V, N, F>(margin, &z, V::splat(1.0));
        let rate = along::<V, N, F>(rate, &z, V::splat(1.0));
        put(
            V::zero().chosen(of.crossed[w], margin),
            lanes,
            &mut of.margins[w],
        );
        put(rate, lanes, &mut of.rates[w]);
    }
}

/// What do the margins do within the steps before which lanes have stopped? Chooses the margin that falls to zero.
#[inline(always)]
fn decide<V: Vector>(of: &mut LaneNumbers, stopped: u32) -> (Stops, Moves<V>) {
    let (step, left) = (V::read(&of.step.0), V::read(&of.left.0));
    let most = step.smaller(left);
    let (part, third) = (most.divided_by(step), step.times(V::splat(1.0 / 3.0)));
    let mut moves = Moves {
        lanes: stopped,
        roots: 0,
        time: most,
        most,
    };
    let mut stops = Stops::default();
    for w in 0..of.shape.watched {
        let ends = [V::read(&of.ends[w].0), V::read(&of.end_rates[w].0)];
        let (crossed, error) = (of.crossed[w], V::read(&of.errors[w].0));
        let [cubic, _] = parts(cubic(of, w, third, ends), part);
        let [one, other] = parts(cubic, V::splat(0.5));
        let scaled = error.times(V::splat(FROM_ZERO)).times(part);
        let clear = is_clear(&cubic, crossed, error, scaled)
            | (is_clear(&one, crossed, error, scaled) & is_clear(&other, 0, error, scaled));
        let falls = falls(&cubic, crossed, error) & !clear & stopped;
        stops.lost |= stopped & !clear & (!falls | moves.roots);
        moves.roots |= falls;
        stops.fallen[w] = falls;
        moves.time = guess(&cubic, crossed).times(most).chosen(falls, moves.time);
        for j in 0..of.shape.length() {
            let row = V::read(&of.columns[of.shape.rows(w) + j].0);
            put(row, falls, &mut of.root_row[j]);
        }
    }
    moves.lanes &= !stops.lost;
    moves.roots &= !stops.lost;
    (stops, moves)
}

/// Moves lanes within their steps. Returns the lanes whose roots are not found.
#[inline(always)]
fn finish_of<V: Vector, const N: usize, const F: usize>(
    of: &mut LaneNumbers,
    moves: &Moves<V>,
) -> u32 {
    let length = length(N, F);
    let step = V::read(&of.step.0);
    let at_end = step.times(V::splat(0.5)).at_most(moves.time);
    let series = series_of::<V, N, F>(of, at_end);
    let base = step.chosen(at_end, V::zero());
    let mut time = moves.time.minus(base);
    let lost = root(of, moves, &series, base, &mut time);
    for j in 0..length {
        let mut sum = V::read(&of.terms[(TERMS - 1) * length + j].0);
        for k in (0..TERMS - 1).rev() {
            sum = sum.multiply_add(time, V::read(&of.terms[k * length + j].0));
        }
        put(sum, moves.lanes, &mut of.z[j]);
    }
    let generator = of.shape.generator();
    for tangent in of.tangents.chunks_exact_mut(2 * N).take(of.tangent_count) {
        let x = read::<V>(tangent, 2 * N);
        let mut term = mapped::<V, N, F>(&of.columns, &x);
        for i in 0..2 * N {
            term[i] = term[i].chosen(at_end, x[i]);
        }
        let mut sum = term;
        for k in 1..TERMS {
            let share = time.times(V::splat(1.0 / k as f64));
            term = mapped::<V, N, F>(&of.columns[generator..], &term);
            for i in 0..2 * N {
                term[i] = term[i].times(share);
                sum[i] = sum[i].plus(term[i]);
            }
        }
        for i in 0..2 * N {
            sum[i].chosen(moves.lanes, x[i]).write(&mut tangent[i].0);
        }
    }
    put(
        V::read(&of.left.0).minus(time.plus(base)),
        moves.lanes,
        &mut of.left,
    );
    lost
}

/// The Taylor series of z from the nearer end of each lane's step, and that of the margin.
#[inline(always)]
fn series_of<V: Vector, const N: usize, const F: usize>(
    of: &mut LaneNumbers,
    at_end: u32,
) -> [V; TERMS] {
    let length = length(N, F);
    let row = read::<V>(&of.root_row, length);
    let mut term = [V::zero(); MOST_LENGTH];
    for j in 0..length {
        term[j] = V::read(&of.next[j].0).chosen(at_end, V::read(&of.z[j].0));
    }
    let mut series = [V::zero(); TERMS];
    for k in 0..TERMS {
        let mut sum = row[0].times(term[0]);
        for j in 1..length {
            term[j].write(&mut of.terms[k * length + j].0);
            sum = row[j].multiply_add(term[j], sum);
        }
        term[0].write(&mut of.terms[k * length].0);
        series[k] = sum;
        let share = V::splat(1.0 / (k + 1) as f64);
        let generator = &of.columns[of.shape.generator()..];
        let mut higher = [V::zero(); MOST_LENGTH];
        for i in 0..2 * N {
            let row = &generator[i * length..][..length];
            higher[i] = along::<V, N, F>(row, &term, term[2 * N]).times(share);
        }
        let turns = &of.turns[..F];
        for h in 0..F {
            let [omega, ..] = &turns[h];
            let (at, turn) = (2 * N + 1 + 2 * h, V::read(&omega.0).times(share));
            higher[at] = V::zero().minus(turn.times(term[at + 1]));
            higher[at + 1] = turn.times(term[at]);
        }
        term = higher;
    }
    series
}

/// Newton's method for the roots of the margins' series, within brackets. `time` is relative to the bases of the series.
/// Returns the lanes without a result.
#[inline(always)]
fn root<V: Vector>(
    of: &LaneNumbers,
    moves: &Moves<V>,
    series: &[V; TERMS],
    base: V,
    time: &mut V,
) -> u32 {
    let fine = V::read(&of.step.0).times(V::splat(CONVERGED));
    let mut low = V::zero().minus(base);
    let mut high = moves.most.minus(base);
    let (mut open, mut rising) = (moves.roots, 0);
    for _ in 0..MOST_STEPS {
        if open == 0 {
            break;
        }
        let (mut value, mut rate) = (series[TERMS - 1], V::zero());
        for k in (0..TERMS - 1).rev() {
            rate = rate.multiply_add(*time, value);
            value = value.multiply_add(*time, series[k]);
        }
        let behind = value.at_most(V::zero());
        high = time.chosen(behind & open, high);
        low = time.chosen(!behind & open, low);
        let step = value.divided_by(rate);
        let near = step.size().at_most(fine);
        let next = time.minus(step);
        let outside = next.at_most(low) | high.at_most(next);
        let middle = low.plus(high).times(V::splat(0.5));
        *time = middle.chosen(outside & !near, next).chosen(open, *time);
        rising |= open & near & V::zero().at_most(rate);
        open &= !near;
    }
    open | rising
}
