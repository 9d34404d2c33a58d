//! A deflection by its first terms: enough to see that a contact is out of reach.

use super::vector::Vector;
use super::window::Solution;
use crate::propagate::volterra::shapes::{LANES, Row, TERMS};

/// Sums in flight of a product: they hide the latency of the multiply-add.
const WAYS: usize = 4;

/// `Σ |a[n]|` of the terms beyond the first lane group.
pub fn tail(row: &Row) -> f64 {
    row.0[LANES..].iter().map(|a| a.abs()).sum()
}

/// Adds the first terms of `sign Σ weights[i] rows[i]`, and what bounds the others.
#[inline(always)]
fn add<V: Vector>(
    rows: &[Row],
    tails: &[f64],
    weights: &[f64],
    sign: f64,
    heads: &mut [V; WAYS],
    beyond: &mut [f64; WAYS],
) {
    for (i, rows) in rows.chunks_exact(WAYS).enumerate() {
        for way in 0..WAYS {
            let (weight, tail) = (weights[WAYS * i + way], tails[WAYS * i + way]);
            let head = V::read(&rows[way].0);
            heads[way] = head.multiply_add(V::splat(sign * weight), heads[way]);
            beyond[way] += tail * weight.abs();
        }
    }
}

#[inline(always)]
pub(super) fn glimpse_body<V: Vector>(
    rows: &[Row],
    tails: &[f64],
    inputs: &[f64],
    trajectory: &[f64],
    felt: Option<(&[Row; TERMS], &Row, &Row)>,
    out: &mut Solution,
) {
    let (mut heads, mut beyond) = ([V::zero(); WAYS], [0.0; WAYS]);
    let blocks = rows.len() - inputs.len();
    let (of_blocks, of_inputs) = rows.split_at(blocks);
    let (tails, input_tails) = tails.split_at(blocks);
    add(
        of_blocks,
        tails,
        &trajectory[..blocks],
        1.0,
        &mut heads,
        &mut beyond,
    );
    add(of_inputs, input_tails, inputs, 1.0, &mut heads, &mut beyond);
    let head = |heads: &[V; WAYS]| (heads[0].plus(heads[1])).plus(heads[2].plus(heads[3]));
    let total = |a: &[f64; WAYS]| (a[0] + a[1]) + (a[2] + a[3]);
    let size = head(&heads).size().sum() + total(&beyond);
    if let Some((response, tails, force)) = felt {
        add(response, &tails.0, &force.0, -1.0, &mut heads, &mut beyond);
    }
    let head = head(&heads);
    out.deflection = [0.0; TERMS];
    head.write(&mut out.deflection);
    out.variation = head.size().sum() - out.deflection[0].abs() + total(&beyond);
    out.size = size;
}
