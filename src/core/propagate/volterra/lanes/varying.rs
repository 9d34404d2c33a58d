//! Inner loops of a full window with a varying stiffness.

use super::columns::{GROUPS, combine, series};
use crate::model::STIFFNESS_TERMS;
use crate::propagate::vectors::Vector;
use crate::propagate::volterra::shapes::{LANES, Row, Series, TERMS};
use crate::propagate::volterra::varying::{Factors, Nodal};

/// Values of a Legendre series at positions in lanes, by Clenshaw's recurrence.
#[inline(always)]
fn clenshaw<V: Vector>(stiffness: &[f64; STIFFNESS_TERMS], x: &Series) -> Row {
    let (mut b1, mut b2) = (Row([0.0; TERMS]), Row([0.0; TERMS]));
    for n in (0..STIFFNESS_TERMS).rev() {
        let k = n as f64;
        let (up, down) = ((2.0 * k + 1.0) / (k + 1.0), (k + 1.0) / (k + 2.0));
        for j in 0..TERMS {
            let b0 = V::fma(up * x[j], b1.0[j], V::fma(-down, b2.0[j], stiffness[n]));
            b2.0[j] = b1.0[j];
            b1.0[j] = b0;
        }
    }
    b1
}

#[inline(always)]
pub(super) fn factorise_body<V: Vector>(
    nodal: &Nodal,
    stiffness: &[f64; STIFFNESS_TERMS],
    places: &Series,
    damping: f64,
    out: &mut Factors,
) {
    let k = clenshaw::<V>(stiffness, places);
    let mut matrix = [Row::ZERO; TERMS];
    for j in 0..TERMS {
        for g in 0..GROUPS {
            let at = g * LANES;
            let rate = V::read(&nodal.response_rate[j].0[at..]);
            let one = V::read(&DIAGONAL[TERMS - 1 - j + at..]);
            let damped = rate.multiply_add(V::splat(damping), one);
            let k = V::read(&k.0[at..]);
            let entry = V::read(&nodal.response[j].0[at..]).multiply_add(k, damped);
            entry.write(&mut matrix[j].0[at..]);
        }
    }
    eliminate::<V, 0>(&mut matrix, out);
    eliminate::<V, 1>(&mut matrix, out);
    eliminate::<V, 2>(&mut matrix, out);
    for j in 0..TERMS {
        for g in 0..GROUPS {
            let at = g * LANES;
            let above = V::read(&ABOVE_DIAGONAL[TERMS - 1 - j + at..]).times(V::splat(-1.0));
            let scaled = V::read(&matrix[j].0[at..]).times(V::read(&out.pivots.0[at..]));
            scaled.times(above).write(&mut out.upper[j].0[at..]);
        }
    }
    out.stiffness = k;
    out.damping = damping;
}

/// 1 for entry i of column j, at index `TERMS − 1 − j + i`, if it is on, above or below the diagonal;
/// otherwise 0.
const DIAGONAL: [f64; 2 * TERMS - 1] = places(TERMS - 1, TERMS);
const ABOVE_DIAGONAL: [f64; 2 * TERMS - 1] = places(0, TERMS - 1);
const BELOW_DIAGONAL: [f64; 2 * TERMS - 1] = places(TERMS, 2 * TERMS - 1);

const fn places(from: usize, to: usize) -> [f64; 2 * TERMS - 1] {
    let mut out = [0.0; 2 * TERMS - 1];
    let mut at = from;
    while at < to {
        out[at] = 1.0;
        at += 1;
    }
    out
}

/// Eliminates below the diagonal of a lane group's columns. The rows above the group are already eliminated.
#[inline(always)]
fn eliminate<V: Vector, const GROUP: usize>(matrix: &mut [Row; TERMS], out: &mut Factors) {
    for step in GROUP * LANES..(GROUP + 1) * LANES {
        let pivot = 1.0 / matrix[step].0[step];
        out.pivots.0[step] = pivot;
        let mut lower = [V::zero(); GROUPS];
        for g in 0..GROUPS {
            let at = g * LANES;
            let below = V::read(&BELOW_DIAGONAL[TERMS - 1 - step + at..]).times(V::splat(-pivot));
            lower[g] = V::read(&matrix[step].0[at..]).times(below);
            lower[g].write(&mut out.lower[step].0[at..]);
        }
        for column in &mut matrix[step + 1..] {
            let weight = V::splat(column.0[step]);
            for g in GROUP..GROUPS {
                let entries = &mut column.0[g * LANES..];
                let left = lower[g].multiply_add(weight, V::read(entries));
                left.write(entries);
            }
        }
    }
}

/// `y += Σ columns[i] y[i]`, one column after the other, in ascending (`upwards`) or descending order. The columns of
/// a lane group only affect this group and the groups ahead.
#[inline(always)]
fn substitute<V: Vector, const COLUMNS: usize>(
    columns: &[Row; TERMS],
    upwards: bool,
    y: &mut [[V; GROUPS]; COLUMNS],
) {
    for i in 0..GROUPS {
        let group = if upwards { i } else { GROUPS - 1 - i };
        for j in 0..LANES {
            let lane = if upwards { j } else { LANES - 1 - j };
            let column = &columns[group * LANES + lane].0;
            let ahead = if upwards { group..GROUPS } else { 0..group + 1 };
            for c in 0..COLUMNS {
                let weight = y[c][group].lane(lane);
                for g in ahead.clone() {
                    let entries = V::read(&column[g * LANES..]);
                    y[c][g] = entries.multiply_add(weight, y[c][g]);
                }
            }
        }
    }
}

/// Force series from the series of the free deflections; `gap` is s b \[m\] of the first column.
#[inline(always)]
pub(super) fn force_columns<V: Vector, const COLUMNS: usize>(
    nodal: &Nodal,
    factors: &Factors,
    free: &[Row; COLUMNS],
    gap: f64,
) -> [Row; COLUMNS] {
    let values = combine::<V, COLUMNS>(&nodal.maps.values, &series(free));
    let slopes = combine::<V, COLUMNS>(&nodal.maps.slopes, &series(free));
    let mut y = [[V::zero(); GROUPS]; COLUMNS];
    for c in 0..COLUMNS {
        let gap = V::splat(if c == 0 { -gap } else { 0.0 });
        for g in 0..GROUPS {
            let at = g * LANES;
            let damped = V::read(&slopes[c].0[at..]).times(V::splat(nodal.pace * factors.damping));
            let k = V::read(&factors.stiffness.0[at..]);
            let beyond = V::read(&values[c].0[at..]).plus(gap);
            y[c][g] = k.multiply_add(beyond, damped);
        }
    }
    substitute::<V, COLUMNS>(&factors.lower, true, &mut y);
    for c in 0..COLUMNS {
        for g in 0..GROUPS {
            y[c][g] = y[c][g].times(V::read(&factors.pivots.0[g * LANES..]));
        }
    }
    substitute::<V, COLUMNS>(&factors.upper, false, &mut y);
    let mut forces = [Row::ZERO; COLUMNS];
    for c in 0..COLUMNS {
        for g in 0..GROUPS {
            y[c][g].write(&mut forces[c].0[g * LANES..]);
        }
    }
    combine::<V, COLUMNS>(&nodal.maps.series, &series(&forces))
}

/// Deflection series from those of the free deflection and the force.
#[inline(always)]
pub(super) fn deflection_columns<V: Vector>(nodal: &Nodal, free: &Row, force: &Row) -> Row {
    let [yielded] = combine::<V, 1>(&nodal.series_response, &[&force.0]);
    let mut out = *free;
    for j in 0..TERMS {
        out.0[j] -= yielded.0[j];
    }
    out
}

#[inline(always)]
pub(super) fn force_body<V: Vector>(nodal: &Nodal, factors: &Factors, free: &Row, gap: f64) -> Row {
    let [force] = force_columns::<V, 1>(nodal, factors, &[*free], gap);
    force
}
