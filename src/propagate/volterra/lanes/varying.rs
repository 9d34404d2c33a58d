//! Loops of a full window on which the stiffness varies.

use super::columns::{combine, series};
use super::vector::Vector;
use super::window::add_row;
use crate::model::STIFFNESS_TERMS;
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::tables::{Row, Series};
use crate::propagate::volterra::varying::{Factors, Nodal};

/// Values of a Legendre series at places in lanes, by Clenshaw's recurrence.
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
    let mut matrix = [Row([0.0; TERMS]); TERMS];
    for j in 0..TERMS {
        let (b, rate) = (&nodal.response[j], &nodal.response_rate[j]);
        let column = &mut matrix[j].0;
        for i in 0..TERMS {
            column[i] = V::fma(k.0[i], b.0[i], damping * rate.0[i]);
        }
        column[j] += 1.0;
    }
    for step in 0..TERMS {
        let mut pivot_column = matrix[step];
        let pivot = 1.0 / pivot_column.0[step];
        let lower = &mut out.lower[step].0;
        for i in 0..TERMS {
            // A choice, not a shorter loop: whole vectors have no ragged ends.
            let below = if i > step { pivot_column.0[i] } else { 0.0 };
            lower[i] = below * pivot;
            if i >= step {
                pivot_column.0[i] = 0.0;
            }
        }
        out.pivots.0[step] = pivot;
        out.upper[step] = pivot_column;
        for column in &mut matrix[step + 1..] {
            let weight = column.0[step];
            for i in 0..TERMS {
                column.0[i] = V::fma(-weight, lower[i], column.0[i]);
            }
        }
    }
    out.stiffness = k;
    out.damping = damping;
}

/// Force series from the series of the free deflections; `gap` is s b \[m\] of the first column.
#[inline(always)]
pub(super) fn force_columns<V: Vector, const COLUMNS: usize>(
    nodal: &Nodal,
    factors: &Factors,
    free: &[Row; COLUMNS],
    gap: f64,
) -> [Row; COLUMNS] {
    let mut y = combine::<V, COLUMNS>(&nodal.values, &series(free));
    let slopes = combine::<V, COLUMNS>(&nodal.slopes, &series(free));
    for c in 0..COLUMNS {
        let gap = if c == 0 { gap } else { 0.0 };
        for i in 0..TERMS {
            y[c].0[i] = V::fma(
                factors.stiffness.0[i],
                y[c].0[i] - gap,
                factors.damping * slopes[c].0[i],
            );
        }
    }
    for step in 0..TERMS {
        for column in &mut y {
            let weight = -column.0[step];
            add_row::<V>(&mut column.0, &factors.lower[step], weight);
        }
    }
    for step in (0..TERMS).rev() {
        for column in &mut y {
            let value = column.0[step] * factors.pivots.0[step];
            column.0[step] = value;
            add_row::<V>(&mut column.0, &factors.upper[step], -value);
        }
    }
    combine::<V, COLUMNS>(&nodal.series, &series(&y))
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

#[inline(always)]
pub(super) fn deflection_body<V: Vector>(nodal: &Nodal, free: &Row, force: &Row) -> Row {
    deflection_columns::<V>(nodal, free, force)
}
