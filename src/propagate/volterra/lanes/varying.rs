//! Loops of a full window on which the stiffness varies.

use super::window::{add_row, combine, size};
use super::{Solution, fma};
use crate::model::STIFFNESS_TERMS;
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::tables::{Row, Series};
use crate::propagate::volterra::varying::{Factors, Nodal};

/// Values of a Legendre series at places in lanes, by Clenshaw's recurrence.
#[inline(always)]
fn clenshaw<const SET: u8>(series: &[f64; STIFFNESS_TERMS], x: &Series) -> Row {
    let (mut b1, mut b2) = (Row([0.0; TERMS]), Row([0.0; TERMS]));
    for n in (0..STIFFNESS_TERMS).rev() {
        let k = n as f64;
        let (up, down) = ((2.0 * k + 1.0) / (k + 1.0), (k + 1.0) / (k + 2.0));
        for j in 0..TERMS {
            let b0 = fma::<SET>(up * x[j], b1.0[j], fma::<SET>(-down, b2.0[j], series[n]));
            b2.0[j] = b1.0[j];
            b1.0[j] = b0;
        }
    }
    b1
}

#[inline(always)]
pub(super) fn factorise_body<const SET: u8>(
    nodal: &Nodal,
    stiffness: &[f64; STIFFNESS_TERMS],
    places: &Series,
    damping: f64,
    out: &mut Factors,
) {
    let k = clenshaw::<SET>(stiffness, places);
    let mut matrix = [Row([0.0; TERMS]); TERMS];
    for j in 0..TERMS {
        let (b, rate) = (&nodal.response[j], &nodal.response_rate[j]);
        let column = &mut matrix[j].0;
        for i in 0..TERMS {
            column[i] = fma::<SET>(k.0[i], b.0[i], damping * rate.0[i]);
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
                column.0[i] = fma::<SET>(-weight, lower[i], column.0[i]);
            }
        }
    }
    out.stiffness = k;
    out.damping = damping;
}

/// `Σ columns[j] weights[j]`, two sums in flight.
#[inline(always)]
fn product<const SET: u8>(columns: &[Row; TERMS], weights: &Series) -> Series {
    let (mut even, mut odd) = ([0.0; TERMS], [0.0; TERMS]);
    for (pair, weight) in columns.chunks_exact(2).zip(weights.chunks_exact(2)) {
        add_row::<SET>(&mut even, &pair[0], weight[0]);
        add_row::<SET>(&mut odd, &pair[1], weight[1]);
    }
    for j in 0..TERMS {
        even[j] += odd[j];
    }
    even
}

/// Force series from the series of the free deflection; `gap` is s b \[m\].
#[inline(always)]
pub(super) fn force_body<const SET: u8>(
    nodal: &Nodal,
    factors: &Factors,
    free: &Series,
    gap: f64,
) -> Series {
    let mut y = product::<SET>(&nodal.values, free);
    let slopes = product::<SET>(&nodal.slopes, free);
    for i in 0..TERMS {
        y[i] = fma::<SET>(
            factors.stiffness.0[i],
            y[i] - gap,
            factors.damping * slopes[i],
        );
    }
    for step in 0..TERMS {
        let weight = -y[step];
        add_row::<SET>(&mut y, &factors.lower[step], weight);
    }
    for step in (0..TERMS).rev() {
        let value = y[step] * factors.pivots.0[step];
        y[step] = value;
        add_row::<SET>(&mut y, &factors.upper[step], -value);
    }
    product::<SET>(&nodal.series, &y)
}

/// Deflection series from those of the free deflection and the force.
#[inline(always)]
pub(super) fn deflection_body<const SET: u8>(
    nodal: &Nodal,
    free: &Series,
    force: &Series,
) -> Series {
    let yielded = product::<SET>(&nodal.series_response, force);
    let mut out = *free;
    for j in 0..TERMS {
        out[j] -= yielded[j];
    }
    out
}

#[inline(always)]
pub(super) fn solve_varying_body<const SET: u8>(
    rows: &[Row],
    x: &[f64],
    nodal: &Nodal,
    factors: &Factors,
    gap: f64,
    out: &mut Solution,
) {
    let free = combine::<SET>(rows, x);
    out.size = size(&free);
    out.force = force_body::<SET>(nodal, factors, &free, gap);
    out.deflection = deflection_body::<SET>(nodal, &free, &out.force);
    out.variation = size(&out.deflection) - out.deflection[0].abs();
}

#[inline(always)]
pub(super) fn respond_varying_body<const SET: u8>(
    rows: &[Row],
    x: &[f64],
    nodal: &Nodal,
    factors: &Factors,
) -> Series {
    force_body::<SET>(nodal, factors, &combine::<SET>(rows, x), 0.0)
}
