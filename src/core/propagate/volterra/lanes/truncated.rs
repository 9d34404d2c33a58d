//! Do the first terms of a deflection prove that a contact is out of reach?

use super::window::Solution;
use crate::propagate::vectors::Vector;
use crate::propagate::volterra::shapes::{LANES, Row, TERMS};

/// `Σ |a[n]|` of the terms beyond the first lane group.
pub fn tail(row: &Row) -> f64 {
    row.0[LANES..].iter().map(|a| a.abs()).sum()
}

/// Adds the first terms of `Σ weights[i] rows[i]`, and bounds of the others, over whole lane groups of rows.
/// Independent sums hide the latency of the multiply-add.
#[inline(always)]
fn add<V: Vector>(
    rows: &[Row],
    tails: &[f64],
    weights: &[f64],
    heads: &mut [V; LANES],
    beyond: &mut V,
) {
    let groups = rows.chunks_exact(LANES).zip(tails.chunks_exact(LANES));
    for ((rows, tails), weights) in groups.zip(weights.chunks_exact(LANES)) {
        *beyond = V::read(tails).multiply_add(V::read(weights).size(), *beyond);
        for way in 0..LANES {
            let head = V::read(&rows[way].0);
            heads[way] = head.multiply_add(V::splat(weights[way]), heads[way]);
        }
    }
}

/// The total of independent sums.
#[inline(always)]
fn total<V: Vector>(sums: &[V; LANES]) -> V {
    let [a, b, c, d, e, f, g, h] = *sums;
    ((a.plus(b)).plus(c.plus(d))).plus((e.plus(f)).plus(g.plus(h)))
}

#[inline(always)]
pub(super) fn truncated_body<V: Vector>(
    rows: &[Row],
    tails: &[f64],
    inputs: &[f64],
    trajectory: &[f64],
    other_response: Option<(&[Row; TERMS], &Row, &Row)>,
    out: &mut Solution,
) {
    let (mut heads, mut beyond) = ([V::zero(); LANES], V::zero());
    let blocks = rows.len() - inputs.len();
    let (of_blocks, of_inputs) = rows.split_at(blocks);
    let (tails, input_tails) = tails.split_at(blocks);
    add(
        of_blocks,
        tails,
        &trajectory[..blocks],
        &mut heads,
        &mut beyond,
    );
    let mut rest = 0.0;
    for i in 0..inputs.len() {
        let head = V::read(&of_inputs[i].0);
        heads[i % LANES] = head.multiply_add(V::splat(inputs[i]), heads[i % LANES]);
        rest += input_tails[i] * inputs[i].abs();
    }
    let mut head = total(&heads);
    out.size = head.size().sum() + beyond.sum() + rest;
    if let Some((response, tails, force)) = other_response {
        let mut yielded = [V::zero(); LANES];
        add(response, &tails.0, &force.0, &mut yielded, &mut beyond);
        head = total(&yielded).multiply_add(V::splat(-1.0), head);
    }
    out.deflection = [0.0; TERMS];
    head.write(&mut out.deflection);
    out.variation = head.size().sum() - out.deflection[0].abs() + beyond.sum() + rest;
}
