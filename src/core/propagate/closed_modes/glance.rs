//! Between which nodes of a block may an event happen? The deflections at the nodes and bounds between them decide.

use super::lanes::{SHORT, applied, pair, read};
use super::search::{Known, rises};
use super::sets::MOST_CONTACTS;
use super::system::System;
use super::workspace::{Seen, Watched};
use crate::model::ActiveSet;
use crate::propagate::events::ROUND_OFF;
use crate::propagate::vectors::{InstructionSet, LANES, Lanes, Vector, for_each_set};

/// Rates of contacts that have just crossed their surfaces, positive away from it \[m/s\].
pub type Rates = [f64; MOST_CONTACTS];

/// Mark of a contact that is beyond its surface at the start of the block.
pub const BEYOND: u32 = 1 << LANES;

/// Inputs and outputs of the check of a block.
pub struct Glance<'a> {
    /// The system in force.
    pub system: &'a System,
    /// State of the trajectory at the start of the block.
    pub state: &'a [f64],
    /// Values of the inputs at the start of the block.
    pub inputs: &'a [f64],
    /// The lines of all contacts, each once.
    pub lines: &'a [usize],
    /// Deflections and bounds of each line of the model.
    pub seen: &'a mut [Seen],
    /// Contacts that may open or close.
    pub watched: &'a mut [Watched],
    /// Contacts that opened or closed at the start of the block.
    pub crossed: ActiveSet,
    /// Rates of these contacts at the start.
    pub rates: &'a Rates,
    /// Memory for the amplitudes of all blocks.
    pub amplitudes: &'a mut [f64],
    /// Whether bounds of an earlier block in the same system are still valid.
    pub bounded: bool,
    /// Distance between nodes \[s\].
    pub step: f64,
    /// Number of intervals between nodes in the block; the last may be partial.
    pub count: usize,
    /// The backlash half gap \[m\].
    pub half_gap: f64,
}

for_each_set! {
    /// Deflections and their rates along all lines at the present time.
    fn see_now(system: &System, state: &[f64], inputs: &[f64], lines: &[usize], seen: &mut [Seen])
        = see_now_body
}

/// Checks all lines. Returns the intervals between nodes, the first in bit 0, in which some contact may open or close,
/// and [`BEYOND`] if a contact is beyond its surface. [`Watched::open`] has the result of each contact.
#[inline(always)]
pub fn look_body<V: Vector>(glance: &mut Glance<'_>) -> u32 {
    for lines in glance.lines.chunks(2) {
        match *lines {
            [one, other] => nodes::<V, 2>(glance, [one, other]),
            _ => nodes::<V, 1>(glance, [lines[0]]),
        }
    }
    if !glance.bounded {
        bound::<V>(glance);
    }
    let open = judge::<V>(glance);
    if open == 0 || !glance.bounded {
        return open;
    }
    // Updated bounds are tighter and may prove more.
    bound::<V>(glance);
    judge::<V>(glance)
}

/// Deflections of some lines at the nodes, from one row per coordinate and input.
#[inline(always)]
fn nodes<V: Vector, const L: usize>(glance: &mut Glance<'_>, lines: [usize; L]) {
    let system = glance.system;
    let mut sums = [[V::zero(); 2]; L];
    let mut tables = [(&[] as &[[Lanes; 2]], &[] as &[[Lanes; 2]]); L];
    for l in 0..L {
        let view = &system.views[lines[l]];
        tables[l] = (view.nodes.as_chunks().0, view.drive_nodes.as_chunks().0);
    }
    for (k, places) in system.places.as_chunks::<2>().0.iter().enumerate() {
        for way in 0..2 {
            let weight = V::splat(glance.state[places[way]]);
            for l in 0..L {
                sums[l][way] = V::read(&tables[l].0[k][way].0).multiply_add(weight, sums[l][way]);
            }
        }
    }
    for (k, inputs) in glance.inputs.as_chunks::<2>().0.iter().enumerate() {
        for way in 0..2 {
            let weight = V::splat(inputs[way]);
            for l in 0..L {
                sums[l][way] = V::read(&tables[l].1[k][way].0).multiply_add(weight, sums[l][way]);
            }
        }
    }
    for l in 0..L {
        glance.seen[lines[l]].nodes = sums[l][0].plus(sums[l][1]).lanes();
    }
}

/// Bounds of the contribution of the waves to each line.
#[inline(always)]
fn bound<V: Vector>(glance: &mut Glance<'_>) {
    /// `√(x² + y²) ≤ max + (√2 − 1) min` of the sizes of two numbers; not more than 1.09 times the root.
    const SHARE: f64 = std::f64::consts::SQRT_2 - 1.0 + f64::EPSILON;
    let half = glance.amplitudes.len();
    for (index, balance) in glance.system.balances.iter().enumerate() {
        let [x, y] = applied(&read::<V>(balance), pair(glance.state, half, index));
        let (x, y) = (x.size(), y.size());
        let most = x.smaller(y).multiply_add(V::splat(SHARE), x.larger(y));
        most.write(&mut glance.amplitudes[index * LANES..]);
    }
    for &line in glance.lines {
        let view = &glance.system.views[line];
        let mut sums = [V::zero(); 2];
        let amplitudes = glance.amplitudes.chunks_exact(LANES);
        for ((a, size), curvature) in amplitudes
            .zip(view.size.chunks_exact(LANES))
            .zip(view.curvature.chunks_exact(LANES))
        {
            let a = V::read(a);
            sums[0] = V::read(size).multiply_add(a, sums[0]);
            sums[1] = V::read(curvature).multiply_add(a, sums[1]);
        }
        glance.seen[line].waves = [sums[0].sum(), sums[1].sum()];
    }
}

/// The intervals in which the bounds do not exclude an event.
#[inline(always)]
fn judge<V: Vector>(glance: &mut Glance<'_>) -> u32 {
    let (state, half) = (glance.state, glance.state.len() / 2);
    for &line in glance.lines {
        let (view, seen) = (&glance.system.views[line], &mut glance.seen[line]);
        let [size, mut curvature] = seen.waves;
        curvature += view.drive_curvature;
        for (strayed, drift) in &view.others {
            let rates = drift.rates([state[drift.lane], state[half + drift.lane]]);
            curvature += strayed[0] * rates[0].abs() + strayed[1] * rates[1].abs();
        }
        seen.known = Known {
            curvature,
            fastest: 2.0 * SHORT / glance.step,
            noise: ROUND_OFF * (size + seen.start.abs() + glance.half_gap),
        };
    }
    let mut any = 0;
    for own in glance.watched.iter_mut() {
        let seen = &glance.seen[own.line];
        let crossed = glance.crossed.holds(own.contact);
        // For a contact that has just crossed its surface, the first interval is checked by its rate.
        let looked_at = ((1 << glance.count) - 1) & !u32::from(crossed);
        own.open = looked_at & open::<V>(own, seen, glance.step, looked_at);
        if crossed {
            let end = own.value(seen.nodes.0[0]);
            let rises = rises(seen.known, glance.rates[own.contact], end, glance.step);
            own.open |= u32::from(!rises);
        } else if own.value(seen.start) < -seen.known.noise {
            own.open |= BEYOND;
        }
        any |= own.open;
    }
    any
}

/// Intervals in which a margin may fall to its round-off if its curvature bends it below the chord as far as possible:
/// the test of [`super::search::stays`] for all intervals of `looked_at`.
#[inline(always)]
fn open<V: Vector>(own: &Watched, seen: &Seen, step: f64, looked_at: u32) -> u32 {
    let sag = 0.125 * seen.known.curvature * step * step;
    let start = own.value(seen.start);
    let b = V::read(&seen.nodes.0).multiply_add(V::splat(own.scale), V::splat(own.shift));
    // A large distance from the surface at both ends is sufficient.
    let near = sag + seen.known.noise;
    let low = b.at_most(V::splat(near));
    if (low | low << 1 | u32::from(start <= near)) & looked_at == 0 {
        return 0;
    }
    let a = b.behind(start);
    let difference = b.minus(a).size();
    // The lowest point of the parabola with the largest sag, if it lies between the ends.
    let bend = V::splat(-1.0 / (16.0 * sag).max(f64::MIN_POSITIVE));
    let lowest = difference
        .times(difference)
        .multiply_add(bend, a.plus(b).multiply_add(V::splat(0.5), V::splat(-sag)));
    let zero = V::zero();
    let bends = !V::splat(4.0 * sag).at_most(difference) & 0xff;
    a.at_most(zero) | b.at_most(zero) | (bends & lowest.at_most(V::splat(seen.known.noise)))
}

/// As [`see_now`], for callers that have chosen the instruction set.
#[inline(always)]
pub fn see_now_body<V: Vector>(
    system: &System,
    state: &[f64],
    inputs: &[f64],
    lines: &[usize],
    seen: &mut [Seen],
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
        let seen = &mut seen[line];
        seen.start = sums[0].sum() + deflection;
        seen.rate = sums[1].sum() + rate;
    }
}
