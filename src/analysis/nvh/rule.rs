//! Values of a window's series at the nodes of a Gauss rule, and its extremes from there.

use crate::analysis::modal_series::TERMS;
use crate::numerics::legendre::{derivative, evaluate, polynomials};
use crate::numerics::quadrature::GaussLegendre;
use std::sync::OnceLock;

/// Nodes of the rule for third and fourth powers: exact to degree 95 ≥ 4·23.
pub(super) const NODES: usize = 48;

/// Legendre polynomials at the nodes, and the weights, which add up to 1.
#[derive(Debug, Clone)]
pub(super) struct Rule {
    polynomials: Box<[[f64; NODES]; TERMS]>,
    pub(super) weights: Box<[f64; NODES]>,
    /// The nodes, in (−1, 1).
    pub(super) places: Box<[f64; NODES]>,
}

impl Rule {
    /// The rule, which knows nothing of any drive and is made once.
    pub(super) fn shared() -> &'static Self {
        static RULE: OnceLock<Rule> = OnceLock::new();
        RULE.get_or_init(Self::new)
    }

    fn new() -> Self {
        let gauss = GaussLegendre::new(NODES);
        let mut table = Box::new([[0.0; NODES]; TERMS]);
        let mut weights = Box::new([0.0; NODES]);
        let mut at_node = [0.0; TERMS];
        for j in 0..NODES {
            polynomials(gauss.nodes[j], &mut at_node);
            for (row, value) in table.iter_mut().zip(at_node) {
                row[j] = value;
            }
            weights[j] = 0.5 * gauss.weights[j];
        }
        Self {
            places: Box::new(table[1]),
            polynomials: table,
            weights,
        }
    }

    /// Values of a series at the nodes: the nodes are the lanes.
    pub(super) fn values(&self, series: &[f64; TERMS]) -> [f64; NODES] {
        let mut values = [0.0; NODES];
        combine(series, &self.polynomials, &mut values);
        values
    }

    /// Largest value of a series, from its `values` at the nodes.
    pub(super) fn maximum(&self, series: &[f64; TERMS], values: &[f64; NODES]) -> f64 {
        let mut best = 0;
        for j in 1..NODES {
            if values[j] > values[best] {
                best = j;
            }
        }
        maximum(series, self.places[best])
    }

    /// Smallest value of a series, from its `values` at the nodes.
    pub(super) fn minimum(&self, series: &[f64; TERMS], values: &[f64; NODES]) -> f64 {
        -self.maximum(&series.map(|a| -a), &values.map(|v| -v))
    }
}

/// `Σ series[n] rows[n]`. The same on every instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn combine(series: &[f64; TERMS], rows: &[[f64; NODES]; TERMS], values: &mut [f64; NODES]) {
    for (a, row) in series.iter().zip(rows) {
        for (value, p) in values.iter_mut().zip(row) {
            *value += a * p;
        }
    }
}

/// Powers 1 … 4 of `(values − centre)/unit`, weighted and added up. The same on every
/// instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn powers(
    values: &[f64; NODES],
    weights: &[f64; NODES],
    centre: f64,
    unit: f64,
) -> [f64; 4] {
    const LANES: usize = 8;
    let scale = 1.0 / unit;
    let mut sums = [[0.0; LANES]; 4];
    for base in (0..NODES).step_by(LANES) {
        for i in 0..LANES {
            let u = scale * (values[base + i] - centre);
            let mut power = weights[base + i];
            for sum in &mut sums {
                power *= u;
                sum[i] += power;
            }
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}

/// Largest of a series' values at its ends and at the stationary point next to x.
fn maximum(series: &[f64; TERMS], mut x: f64) -> f64 {
    let slope = derivative(series);
    let curvature = derivative(&slope);
    let mut best = evaluate(series, x)
        .max(evaluate(series, -1.0))
        .max(evaluate(series, 1.0));
    for _ in 0..4 {
        let c = evaluate(&curvature, x);
        if c >= 0.0 {
            break;
        }
        x = (x - evaluate(&slope, x) / c).clamp(-1.0, 1.0);
        best = best.max(evaluate(series, x));
    }
    best
}
