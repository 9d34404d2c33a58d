//! Values of a window's series at the nodes of a Gauss rule, and its extremes from there.

use crate::analysis::modal_series::TERMS;
use crate::numerics::legendre::{at_end, at_start, derivative, evaluate, polynomials};
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
    /// By term, how far a series may rise above its values at the nodes and at both ends.
    rises: Box<[f64; TERMS]>,
}

/// What the values at nodes and ends say of the extremes of a series.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    /// Smallest value at nodes and ends.
    pub(super) low: f64,
    /// Largest value at nodes and ends.
    pub(super) high: f64,
    /// The most by which the series leaves both.
    pub(super) rise: f64,
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
            rises: Box::new(rises(&gauss.nodes)),
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

    /// Between what its `values` at the nodes say the extremes of a series lie.
    pub(super) fn range(&self, series: &[f64; TERMS], values: &[f64; M]) -> Range {
        let [low, high, rise] = range(series, values, &self.rises);
        let [start, end] = [at_start(series), at_end(series)];
        Range {
            low: low.min(start.min(end)),
            high: high.max(start.max(end)),
            rise,
        }
    }

    /// Where the search for an extreme begins that is `value` at nodes and ends: at the node
    /// that has it, else at the end that has it.
    pub(super) fn place(&self, series: &[f64; TERMS], values: &[f64; M], value: f64) -> f64 {
        let node = place_of(values, &self.places, value);
        match node.is_nan() {
            true if at_start(series) == value => -1.0,
            true => 1.0,
            false => node,
        }
    }
}

/// By term, the most by which a series can rise above its values at both ends of every cell
/// between neighbouring nodes, −1 and 1: a cell of length h allows `h²/8 max|P_n''|`.
fn rises(nodes: &[f64]) -> [f64; TERMS] {
    /// Places looked at in a cell, where the curvature turns by less than three radians.
    const STEPS: usize = 8;
    /// What may lie between them.
    const MARGIN: f64 = 1.05;
    let mut ends: Vec<f64> = nodes.to_vec();
    ends.extend([-1.0, 1.0]);
    ends.sort_by(f64::total_cmp);
    let mut rises = [0.0_f64; TERMS];
    for cell in ends.windows(2) {
        let length = cell[1] - cell[0];
        for step in 0..=STEPS {
            let x = cell[0] + length * step as f64 / STEPS as f64;
            let mut values = [0.0; TERMS];
            polynomials(x, &mut values);
            // P'_{n+1} = P'_{n−1} + (2n+1) P_n, and the same once more for P''.
            let (mut slopes, mut curvatures) = ([0.0; TERMS], [0.0_f64; TERMS]);
            slopes[1] = 1.0;
            for n in 1..TERMS - 1 {
                let factor = (2 * n + 1) as f64;
                slopes[n + 1] = slopes[n - 1] + factor * values[n];
                curvatures[n + 1] = curvatures[n - 1] + factor * slopes[n];
            }
            for (rise, curvature) in rises.iter_mut().zip(curvatures) {
                *rise = rise.max(MARGIN * 0.125 * length * length * curvature.abs());
            }
        }
    }
    rises
}

/// Smallest and largest of the `values`, and `Σ |series[n]| rises[n]`. The same on every
/// instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn range<const M: usize>(
    series: &[f64; TERMS],
    values: &[f64; M],
    rises: &[f64; TERMS],
) -> [f64; 3] {
    let mut low = [f64::INFINITY; LANES];
    let mut high = [f64::NEG_INFINITY; LANES];
    for eight in values.as_chunks::<LANES>().0 {
        low = std::array::from_fn(|i| smaller(low[i], eight[i]));
        high = std::array::from_fn(|i| larger(high[i], eight[i]));
    }
    let mut rise = [0.0; LANES];
    let (terms, _) = series.as_chunks::<LANES>();
    let (rises, _) = rises.as_chunks::<LANES>();
    for (terms, rises) in terms.iter().zip(rises) {
        rise = std::array::from_fn(|i| rise[i] + terms[i].abs() * rises[i]);
    }
    [
        halved(low, smaller),
        halved(high, larger),
        halved(rise, |a, b| a + b),
    ]
}

/// Plain comparisons: `f64::min` and `f64::max` would look for values that are no numbers.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// What an operation makes of all lanes: one half with the other, three times.
#[inline(always)]
fn halved(lanes: [f64; LANES], join: impl Fn(f64, f64) -> f64) -> f64 {
    let four: [f64; 4] = std::array::from_fn(|i| join(lanes[i], lanes[i + 4]));
    let two: [f64; 2] = std::array::from_fn(|i| join(four[i], four[i + 2]));
    join(two[0], two[1])
}

/// Mean of the places at which `values` are equal to one of them; no number where none is.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn place_of<const M: usize>(values: &[f64; M], places: &[f64; M], value: f64) -> f64 {
    let [mut sum, mut count] = [[0.0; LANES]; 2];
    let (values, _) = values.as_chunks::<LANES>();
    let (places, _) = places.as_chunks::<LANES>();
    for (values, places) in values.iter().zip(places) {
        let own: [f64; LANES] = std::array::from_fn(|i| f64::from(u8::from(values[i] == value)));
        sum = std::array::from_fn(|i| sum[i] + own[i] * places[i]);
        count = std::array::from_fn(|i| count[i] + own[i]);
    }
    halved(sum, |a, b| a + b) / halved(count, |a, b| a + b)
}

/// Factors of Clenshaw's recurrence, `(2n+1)/(n+1)` and `(n+1)/(n+2)`.
const CLENSHAW: [[f64; 2]; TERMS] = {
    let mut factors = [[0.0; 2]; TERMS];
    let mut n = 0;
    while n < TERMS {
        let k = n as f64;
        factors[n] = [(2.0 * k + 1.0) / (k + 1.0), (k + 1.0) / (k + 2.0)];
        n += 1;
    }
    factors
};

/// Values, slopes and curvatures of four series, the lanes, each at a place of its own.
#[inline(always)]
fn evaluate_four(series: &[[f64; 4]; TERMS], x: &[f64; 4]) -> [[f64; 4]; 3] {
    let [mut value, mut slope, mut curvature] = [[0.0; 4]; 3];
    let [mut value_next, mut slope_next, mut curvature_next] = [[0.0; 4]; 3];
    for (a, [up, down]) in series.iter().zip(CLENSHAW).rev() {
        let step = x.map(|x| up * x);
        // What is known early is added first: the chain of waiting stays short.
        let curvature_new: [f64; 4] = std::array::from_fn(|i| {
            step[i] * curvature[i] + (2.0 * up * slope[i] - down * curvature_next[i])
        });
        let slope_new: [f64; 4] =
            std::array::from_fn(|i| step[i] * slope[i] + (up * value[i] - down * slope_next[i]));
        let value_new: [f64; 4] =
            std::array::from_fn(|i| step[i] * value[i] + (a[i] - down * value_next[i]));
        (curvature_next, curvature) = (curvature, curvature_new);
        (slope_next, slope) = (slope, slope_new);
        (value_next, value) = (value, value_new);
    }
    [value, slope, curvature]
}

/// Largest values of four series at the stationary points next to some places: Newton's method
/// on the slopes of all of them at once, as one alone waits for its own sums most of the time.
/// The same on every instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn peaks(series: [&[f64; TERMS]; 4], mut x: [f64; 4]) -> [f64; 4] {
    /// Most steps; from a node, two come close enough in a smooth series.
    const MOST_STEPS: usize = 6;
    /// Behind a step below this part of the window, the value is that of the parabola to
    /// round-off.
    const SMALL: f64 = 1e-5;
    let lanes: [[f64; 4]; TERMS] = std::array::from_fn(|n| series.map(|own| own[n]));
    let mut best = [f64::NEG_INFINITY; 4];
    for _ in 0..MOST_STEPS {
        let [values, slopes, curvatures] = evaluate_four(&lanes, &x);
        let mut goes_on = false;
        // Choices without branches: which way each series takes is hard to foretell.
        for i in 0..4 {
            let step = -slopes[i] / curvatures[i];
            let step = if curvatures[i] < 0.0 { step } else { 0.0 };
            let next = smaller(larger(x[i] + step, -1.0), 1.0);
            let small = step.abs() < SMALL;
            let inside = small & (next == x[i] + step);
            let above = if inside { 0.5 * slopes[i] * step } else { 0.0 };
            best[i] = larger(best[i], values[i] + above);
            goes_on |= !small & (next != x[i]);
            x[i] = next;
        }
        if !goes_on {
            break;
        }
    }
    best
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

    /// Series of which some fall off and some do not.
    fn some_series() -> impl Iterator<Item = [f64; TERMS]> {
        (0..200).map(|case| {
            let ratio = [0.1, 0.4, 0.7, 0.9, 1.0][case % 5];
            std::array::from_fn(|n| {
                f64::powi(ratio, n as i32) * (1.7 * (n * n + 3 * case) as f64).sin()
            })
        })
    }

    /// Largest value at even places, close by.
    fn by_search(series: &[f64; TERMS]) -> f64 {
        let places = (0..=20_000).map(|i| -1.0 + f64::from(i) / 10_000.0);
        let values = places.map(|x| evaluate(series, x));
        values.fold(f64::NEG_INFINITY, f64::max)
    }

    fn held<const M: usize>(rule: &Rule<M>) {
        for series in some_series() {
            let values = rule.values(&series);
            let Range { low, high, rise } = rule.range(&series, &values);
            let highest = by_search(&series);
            let lowest = -by_search(&series.map(|a| -a));
            assert!(highest <= high + rise, "{highest} {high} {rise}");
            assert!(lowest >= low - rise, "{lowest} {low} {rise}");
            // The search misses 1e-9 of the curvature.
            assert!(high <= highest + 1e-6 && low >= lowest - 1e-6);
        }
    }

    #[test]
    fn values_at_nodes_bound_the_extremes() {
        held(&Rules::shared().short);
        held(&Rules::shared().long);
        // Far closer than the sum of all coefficients where a series falls off.
        let mut smooth = [0.0; TERMS];
        smooth[..4].copy_from_slice(&[0.3, 0.2, -0.5, 0.1]);
        let rule = &Rules::shared().short;
        assert!(rule.range(&smooth, &rule.values(&smooth)).rise < 0.01);
    }

    #[test]
    fn peaks_are_found_to_round_off() {
        let rule = &Rules::shared().short;
        let mut count = 0;
        for series in some_series().filter(|series| falls_off(series, 0.0)) {
            let exact = by_search(&series);
            let values = rule.values(&series);
            let Range { high, .. } = rule.range(&series, &values);
            let other = series.map(|a| -a);
            let place = rule.place(&series, &values, high);
            let [first, ..] = peaks([&series, &other, &series, &other], [place, 0.3, -0.3, 0.0]);
            let found = first.max(high);
            assert!((found - exact).abs() < 1e-7, "{found} {exact}");
            count += 1;
        }
        assert!(count > 30, "{count}");
        let cosine = crate::analysis::modal_series::cosine_series(2.0, -0.9, 1.0);
        let values = rule.values(&cosine);
        let place = rule.place(&cosine, &values, rule.range(&cosine, &values).high);
        for found in peaks([&cosine; 4], [place, place - 0.1, place + 0.1, place]) {
            assert!((found - 1.0).abs() < 1e-14, "{found:e}");
        }
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
