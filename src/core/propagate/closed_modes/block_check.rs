//! Between which nodes of a block may an event happen? The deflections at the nodes and bounds between them decide.

use super::lanes::{applied, pair, read};
use super::search::{MarginBounds, rises};
use super::sets::MOST_CONTACTS;
use super::system::System;
use super::workspace::{LineState, WatchedContact};
use crate::model::ActiveSet;
use crate::propagate::events::ROUND_OFF;
use crate::propagate::vectors::{InstructionSet, LANES, Lanes, Vector, for_each_set};

/// Rates of the margins of contacts that have just crossed their surfaces, positive if the margin grows
/// \[m/s\].
pub type Rates = [f64; MOST_CONTACTS];

/// Bit of [`WatchedContact::open`] for a contact that is beyond its surface at the start of the block.
pub const BEYOND: u32 = 1 << LANES;

/// Inputs and outputs of the check of a block.
pub struct BlockCheck<'a> {
    /// The present system.
    pub system: &'a System,
    /// State of the trajectory at the start of the block.
    pub state: &'a [f64],
    /// Values of the inputs at the start of the block.
    pub inputs: &'a [f64],
    /// The lines of all contacts, each once.
    pub lines: &'a [usize],
    /// Deflections and bounds of each line of the model.
    pub line_states: &'a mut [LineState],
    /// Contacts that may open or close.
    pub watched: &'a mut [WatchedContact],
    /// Contacts that opened or closed at the start of the block.
    pub crossed: ActiveSet,
    /// Rates of the margins of these contacts at the start \[m/s\].
    pub rates: &'a Rates,
    /// Memory for the amplitudes of all blocks.
    pub amplitudes: &'a mut [f64],
    /// Whether bounds of an earlier block in the same system are still valid.
    pub bounded: bool,
    /// Distance between nodes \[s\].
    pub step: f64,
    /// Fastest rate \[1/s\].
    pub fastest: f64,
    /// Number of intervals between nodes in the block; the last may be partial.
    pub count: usize,
    /// The backlash half gap \[m\].
    pub half_gap: f64,
}

for_each_set! {
    /// Deflections and their rates along all lines at the present time.
    fn evaluate_line_states(system: &System, state: &[f64], inputs: &[f64], lines: &[usize], line_states: &mut [LineState])
        = evaluate_line_states_body
}

/// Checks all lines. Returns the intervals (the first in bit 0) in which some contact may open or close, and
/// [`BEYOND`] if a contact starts beyond its surface. [`WatchedContact::open`] has the result of each contact.
#[inline(always)]
pub fn check_block_body<V: Vector>(check: &mut BlockCheck<'_>) -> u32 {
    for lines in check.lines.chunks(2) {
        match *lines {
            [one, other] => nodes::<V, 2>(check, [one, other]),
            _ => nodes::<V, 1>(check, [lines[0]]),
        }
    }
    if !check.bounded {
        bound::<V>(check);
    }
    let open = open_intervals::<V>(check);
    if open == 0 || !check.bounded || is_crossed_first(check, open) {
        return open;
    }
    // Updated bounds are tighter and may prove more.
    bound::<V>(check);
    open_intervals::<V>(check)
}

/// Whether a contact is beyond its surface at the end of the first open interval: no bound can prove this interval.
#[inline(always)]
fn is_crossed_first(check: &BlockCheck<'_>, open: u32) -> bool {
    let first = open.trailing_zeros() as usize;
    first < LANES
        && check.watched.iter().any(|watched| {
            let end = check.line_states[watched.line].nodes.0[first];
            watched.open >> first & 1 == 1 && watched.value(end) < 0.0
        })
}

/// Deflections along these lines at the nodes of a block: sums of table rows times coordinates and inputs.
#[inline(always)]
fn nodes<V: Vector, const L: usize>(check: &mut BlockCheck<'_>, lines: [usize; L]) {
    let system = check.system;
    let mut sums = [[V::zero(); 2]; L];
    let mut tables = [(&[] as &[[Lanes; 2]], &[] as &[[Lanes; 2]]); L];
    for l in 0..L {
        let view = &system.views[lines[l]];
        tables[l] = (view.nodes.as_chunks().0, view.drive_nodes.as_chunks().0);
    }
    for (k, places) in system.places.as_chunks::<2>().0.iter().enumerate() {
        for way in 0..2 {
            let weight = V::splat(check.state[places[way]]);
            for l in 0..L {
                sums[l][way] = V::read(&tables[l].0[k][way].0).multiply_add(weight, sums[l][way]);
            }
        }
    }
    for (k, inputs) in check.inputs.as_chunks::<2>().0.iter().enumerate() {
        for way in 0..2 {
            let weight = V::splat(inputs[way]);
            for l in 0..L {
                sums[l][way] = V::read(&tables[l].1[k][way].0).multiply_add(weight, sums[l][way]);
            }
        }
    }
    for l in 0..L {
        check.line_states[lines[l]].nodes = sums[l][0].plus(sums[l][1]).lanes();
    }
}

/// Bounds of the contributions of all blocks to each deflection, and of waves to its second derivative.
#[inline(always)]
fn bound<V: Vector>(check: &mut BlockCheck<'_>) {
    /// `√(x² + y²) ≤ max + (√2 − 1) min` of the sizes of two numbers; not more than 1.09 times the root.
    const BOUND_SHARE: f64 = std::f64::consts::SQRT_2 - 1.0 + f64::EPSILON;
    let half = check.amplitudes.len();
    for (index, balance) in check.system.balances.iter().enumerate() {
        let [x, y] = applied(&read::<V>(balance), pair(check.state, half, index));
        let (x, y) = (x.size(), y.size());
        let most = x
            .smaller(y)
            .multiply_add(V::splat(BOUND_SHARE), x.larger(y));
        most.write(&mut check.amplitudes[index * LANES..]);
    }
    for &line in check.lines {
        let view = &check.system.views[line];
        let mut sums = [V::zero(); 2];
        let amplitudes = check.amplitudes.chunks_exact(LANES);
        for ((a, size), curvature) in amplitudes
            .zip(view.size.chunks_exact(LANES))
            .zip(view.curvature.chunks_exact(LANES))
        {
            let a = V::read(a);
            sums[0] = V::read(size).multiply_add(a, sums[0]);
            sums[1] = V::read(curvature).multiply_add(a, sums[1]);
        }
        check.line_states[line].waves = [sums[0].sum(), sums[1].sum()];
    }
}

/// The intervals in which the bounds do not exclude an event.
#[inline(always)]
fn open_intervals<V: Vector>(check: &mut BlockCheck<'_>) -> u32 {
    let (state, half) = (check.state, check.state.len() / 2);
    for &line in check.lines {
        let (view, line_state) = (&check.system.views[line], &mut check.line_states[line]);
        let [size, mut curvature] = line_state.waves;
        curvature += view.drive_curvature;
        for (variation_bounds, drift) in &view.others {
            let rates = drift.rates([state[drift.lane], state[half + drift.lane]]);
            curvature +=
                variation_bounds[0] * rates[0].abs() + variation_bounds[1] * rates[1].abs();
        }
        line_state.bounds = MarginBounds {
            curvature,
            fastest: check.fastest,
            noise: ROUND_OFF * (size + line_state.start.abs() + check.half_gap),
        };
    }
    let mut any = 0;
    for watched in check.watched.iter_mut() {
        let line_state = &check.line_states[watched.line];
        let crossed = check.crossed.holds(watched.contact);
        // A contact that has just crossed its surface has margin 0 at the start. `rises` therefore tests the first
        // interval, with the rate of the margin at the start.
        let looked_at = ((1 << check.count) - 1) & !u32::from(crossed);
        watched.open = looked_at & open::<V>(watched, line_state, check.step, looked_at);
        if crossed {
            let end = watched.value(line_state.nodes.0[0]);
            let rises = rises(
                line_state.bounds,
                check.rates[watched.contact],
                end,
                check.step,
            );
            watched.open |= u32::from(!rises);
        } else if watched.value(line_state.start) < -line_state.bounds.noise {
            watched.open |= BEYOND;
        }
        any |= watched.open;
    }
    any
}

/// Intervals in which a margin may fall to its round-off if its curvature bends it below the chord as far as possible:
/// the test of [`super::search::stays`] for all intervals of `looked_at`.
#[inline(always)]
fn open<V: Vector>(
    contact_margin: &WatchedContact,
    line_state: &LineState,
    step: f64,
    looked_at: u32,
) -> u32 {
    let sag = 0.125 * line_state.bounds.curvature * step * step;
    let start = contact_margin.value(line_state.start);
    let b = V::read(&line_state.nodes.0).multiply_add(
        V::splat(contact_margin.scale),
        V::splat(contact_margin.shift),
    );
    // A large distance from the surface at both ends is sufficient.
    let near = sag + line_state.bounds.noise;
    let low = b.at_most(V::splat(near));
    if (low | low << 1 | u32::from(start <= near)) & looked_at == 0 {
        return 0;
    }
    let a = b.shifted_in(start);
    let difference = b.minus(a).size();
    // The parabola with the largest sag has its lowest point `(a + b)/2 − s − (a − b)²/16 s` between the ends. Without a
    // quotient, this point is within round-off of the surface if `(a − b)² ≥ 16 s ((a + b)/2 − s − noise)`.
    let above = (a.plus(b))
        .multiply_add(V::splat(0.5), V::splat(-near))
        .times(V::splat(16.0 * sag));
    let zero = V::zero();
    let bends = !V::splat(4.0 * sag).at_most(difference) & 0xff;
    a.at_most(zero) | b.at_most(zero) | (bends & above.at_most(difference.times(difference)))
}

/// As [`evaluate_line_states`], for callers that have chosen the instruction set.
#[inline(always)]
pub fn evaluate_line_states_body<V: Vector>(
    system: &System,
    state: &[f64],
    inputs: &[f64],
    lines: &[usize],
    line_states: &mut [LineState],
) {
    for &line in lines {
        let view = &system.views[line];
        let mut sums = [V::zero(); 2];
        let [row, rate, _] = &view.rows;
        for ((x, row), rate) in (state.chunks_exact(LANES))
            .zip(row.chunks_exact(LANES))
            .zip(rate.chunks_exact(LANES))
        {
            let x = V::read(x);
            sums[0] = V::read(row).multiply_add(x, sums[0]);
            sums[1] = V::read(rate).multiply_add(x, sums[1]);
        }
        let [deflection, rate, _] = view.driven(inputs);
        let line_state = &mut line_states[line];
        line_state.start = sums[0].sum() + deflection;
        line_state.rate = sums[1].sum() + rate;
    }
}
