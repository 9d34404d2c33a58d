//! Values of a window's series at the nodes of a Gauss rule, and its extremes from there.

use crate::analysis::modal_series::TERMS;
use crate::numerics::legendre::{derivative, evaluate, polynomials};
use crate::numerics::quadrature::GaussLegendre;
use std::sync::OnceLock;

/// Nodes of the rule for every series: exact to degree 95 ≥ 4·23, so for fourth powers.
pub const LONG: usize = 48;

/// Nodes of the rule for series that fall off as a smooth motion's do.
pub(super) const SHORT: usize = 24;

/// Nodes worked on at a time.
pub(super) const LANES: usize = 8;

/// Error of a fourth power's mean, relative to the fourth power of the series' bound, at which
/// the short rule is as good as the long one.
const ROUND_OFF: f64 = 1e-16;

/// Legendre polynomials at M nodes, a multiple of eight, and the weights, which add up to 1.
#[derive(Debug, Clone)]
pub struct Rule<const M: usize> {
    polynomials: Box<[[f64; M]; TERMS]>,
    pub(super) weights: Box<[f64; M]>,
    /// The nodes, in (−1, 1).
    pub(super) places: Box<[f64; M]>,
}

/// Both rules.
#[derive(Debug, Clone)]
pub struct Rules {
    /// For series that fall off.
    pub(super) short: Rule<SHORT>,
    /// For every series.
    pub long: Rule<LONG>,
}

impl Rules {
    /// The rules, which know nothing of any drive and are made once.
    pub fn shared() -> &'static Self {
        static RULES: OnceLock<Rules> = OnceLock::new();
        RULES.get_or_init(|| Self {
            short: Rule::new(),
            long: Rule::new(),
        })
    }
}

/// Whether the short rule, exact to degree 47, integrates the fourth power of a series about
/// `centre` to round-off. With `t_m = Σ_{n≥m} |a_n|` and s the sum of all: four degrees that
/// add up to 48 or more hold one of 16 and another of 9, or three of 9, so that what is missed
/// is at most `12 t₁₆ t₉ s² + 4 t₉³ s`. Squares are exact.
pub(super) fn falls_off(series: &[f64; TERMS], centre: f64) -> bool {
    let sum = |terms: &[f64]| terms.iter().map(|a| a.abs()).sum::<f64>();
    let last = sum(&series[16..]);
    let late = last + sum(&series[9..16]);
    let all = late + sum(&series[1..9]) + (series[0] - centre).abs();
    12.0 * last * late * all + 4.0 * late * late * late <= ROUND_OFF * all * all * all
}

impl<const M: usize> Rule<M> {
    /// Half turn \[rad\] of an exponential over a window up to which the rule integrates it with
    /// a 23rd-degree series to round-off: the exponential's terms from degree 2M − 23 on are
    /// below 1e-16 at 4 for the short rule, and far below at 8 for the long one.
    pub(super) const WIDEST_TURN: f64 = M as f64 / 6.0;

    fn new() -> Self {
        let gauss = GaussLegendre::new(M);
        let mut table = Box::new([[0.0; M]; TERMS]);
        let mut weights = Box::new([0.0; M]);
        let mut at_node = [0.0; TERMS];
        for j in 0..M {
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
    pub fn values(&self, series: &[f64; TERMS]) -> [f64; M] {
        let mut values = [0.0; M];
        combine(series, &self.polynomials, &mut values);
        values
    }

    /// Weighted sums of powers 1 … 4 of `(values − centre)/unit`.
    pub(super) fn powers(&self, values: &[f64; M], centre: f64, unit: f64) -> [f64; 4] {
        powers(values, &self.weights, centre, unit)
    }

    /// Largest value of a series, from its `values` at the nodes.
    pub fn maximum(&self, series: &[f64; TERMS], values: &[f64; M]) -> f64 {
        let mut best = 0;
        for j in 1..M {
            if values[j] > values[best] {
                best = j;
            }
        }
        maximum(series, self.places[best])
    }

    /// Smallest value of a series, from its `values` at the nodes.
    pub(super) fn minimum(&self, series: &[f64; TERMS], values: &[f64; M]) -> f64 {
        -self.maximum(&series.map(|a| -a), &values.map(|v| -v))
    }
}

/// `Σ series[n] rows[n]`. The same on every instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn combine<const M: usize>(series: &[f64; TERMS], rows: &[[f64; M]; TERMS], values: &mut [f64; M]) {
    for (a, row) in series.iter().zip(rows) {
        for (value, p) in values.iter_mut().zip(row) {
            *value += a * p;
        }
    }
}

/// Powers 1 … 4 of `(values − centre)/unit`, weighted and added up. The same on every
/// instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn powers<const M: usize>(
    values: &[f64; M],
    weights: &[f64; M],
    centre: f64,
    unit: f64,
) -> [f64; 4] {
    let scale = 1.0 / unit;
    let mut sums = [[0.0; LANES]; 4];
    for base in (0..M).step_by(LANES) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_rules_agree_wherever_the_short_one_is_trusted() {
        let rules = Rules::shared();
        let mut trusted = 0;
        for (step, ratio) in [0.02, 0.05, 0.1, 0.12, 0.14, 0.3, 0.9]
            .into_iter()
            .enumerate()
        {
            let series: [f64; TERMS] = std::array::from_fn(|n| {
                f64::powi(ratio, n as i32) * (n as f64 + step as f64).cos()
            });
            let centre = 0.9 * series[0];
            if !falls_off(&series, centre) {
                continue;
            }
            trusted += 1;
            let short = &rules.short;
            let long = &rules.long;
            let found = short.powers(&short.values(&series), centre, 1.0);
            let exact = long.powers(&long.values(&series), centre, 1.0);
            let bound: f64 =
                series[1..].iter().map(|a| a.abs()).sum::<f64>() + (series[0] - centre).abs();
            for (j, (a, b)) in found.iter().zip(&exact).enumerate() {
                let scale = bound.powi(j as i32 + 1);
                assert!(
                    (a - b).abs() <= 2e-15 * scale,
                    "{ratio}: power {j}: {a} {b}"
                );
            }
        }
        assert!((3..7).contains(&trusted), "{trusted} of 7 trusted");
    }

    #[test]
    fn a_rough_series_is_not_trusted_to_the_short_rule() {
        let mut series = [0.0; TERMS];
        series[TERMS - 1] = 1.0;
        assert!(!falls_off(&series, 0.0));
        let rules = Rules::shared();
        let fourth = |found: [f64; 4]| found[3];
        let short = fourth(rules.short.powers(&rules.short.values(&series), 0.0, 1.0));
        let long = fourth(rules.long.powers(&rules.long.values(&series), 0.0, 1.0));
        assert!((short - long).abs() > 1e-4 * long);
    }
}
