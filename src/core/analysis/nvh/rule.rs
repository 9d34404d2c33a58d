//! Values of a window's series at the nodes of a Gauss rule, and its extremes from these.

use super::lanes::{self, SIZES};
use crate::analysis::modal_series::TERMS;
use crate::numerics::legendre::polynomials;
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::InstructionSet;
use crate::propagate::vectors::{LANES, Lanes, Row};
use std::sync::OnceLock;

/// Groups of positive nodes of the long rule, which suits every series: 48 nodes, exact to degree 95 ≥ 4·23, and
/// therefore for fourth powers.
const LONG: usize = 3;

/// Groups of positive nodes of the short rule, for series whose terms decrease as in a smooth motion: 32 nodes,
/// exact to degree 63.
const SHORT: usize = 2;

/// Error of the mean of a fourth power, relative to the fourth power of the series' bound, below
/// which the short rule is used.
const ROUND_OFF: f64 = 1e-16;

/// A Gauss rule on \[−1, 1\] by its positive nodes.
#[derive(Debug, Clone)]
pub struct Rule {
    /// Groups of positive nodes.
    groups: usize,
    /// P_0, P_1, … at the positive nodes, term after term.
    polynomials: Vec<Lanes>,
    /// Weights of the positive nodes, which add up to 1.
    pub(super) weights: Vec<Lanes>,
    /// The positive nodes.
    pub(super) places: Vec<Lanes>,
    /// Half the largest angle \[rad\] by which an exponential may turn over a window if the rule integrates its
    /// product with a 23rd-degree series to round-off. At this angle `(2l+1) j_l` is below 1e-16 from the first
    /// degree l that the rule does not integrate exactly: 41 for the short rule and 73 for the long one.
    pub(super) widest_turn: f64,
}

/// Even and odd part of a series at the positive nodes of a rule.
type ParityValues = [Lanes; 2 * LONG];

/// Sums over a series.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sizes {
    /// Bound on the distance of the series from its mean.
    pub(super) variation: f64,
    /// Mean square about its mean.
    pub(super) square: f64,
    /// Values at both ends.
    ends: [f64; 2],
    /// Bound on the distance of the series beyond its values at the nodes of either rule and at both ends.
    rise: f64,
    /// Sums of the sizes of the terms from the 9th, the 14th and the 16th on.
    tails: [f64; 3],
}

/// First terms of the tails.
const TAILS: [usize; 3] = [9, 14, 16];

/// Bounds on the extremes of a series, from its values at nodes and ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    /// Smallest value at nodes and ends.
    pub(super) low: f64,
    /// Largest value at nodes and ends.
    pub(super) high: f64,
    /// Bound on the distance by which the series exceeds `high` or falls below `low`.
    pub(super) rise: f64,
}

impl Range {
    /// Whether the series has one sign everywhere.
    pub(super) fn has_one_sign(&self) -> bool {
        self.low > self.rise || -self.high > self.rise
    }
}

/// A series on a window, with its values at the nodes of a rule.
#[derive(Debug)]
pub(super) struct NodeValues<'a> {
    pub(super) rule: &'a Rule,
    pub(super) series: &'a [f64; TERMS],
    sizes: Sizes,
    /// Even and odd part of the series at the nodes; a short rule leaves the last entries unused.
    parts: ParityValues,
    pub(super) range: Range,
}

/// Both rules.
#[derive(Debug, Clone)]
pub struct Rules {
    /// Rule for series whose terms decrease as in a smooth motion.
    short: Rule,
    /// Rule for every series.
    long: Rule,
    /// Weights of [`lanes::sizes`].
    weights: [Row; SIZES],
}

impl Rules {
    /// The rules, which do not depend on the drive and are computed once.
    pub fn shared() -> &'static Self {
        static RULES: OnceLock<Rules> = OnceLock::new();
        RULES.get_or_init(|| {
            let (short, long) = (Rule::new(SHORT, 12.0), Rule::new(LONG, 28.0));
            let rises = [&short, &long].map(|rule| rises(&rule.nodes()));
            let from = |first: usize| move |n: usize| f64::from(u8::from(n >= first));
            let row = |of: &dyn Fn(usize) -> f64| Row(std::array::from_fn(of));
            Self {
                weights: [
                    row(&|n| from(1)(n) - from(TAILS[0])(n)),
                    row(&from(TAILS[0])),
                    row(&from(TAILS[1])),
                    row(&from(TAILS[2])),
                    row(&|n| rises[0][n].max(rises[1][n])),
                    row(&|n| from(1)(n) / (2 * n + 1) as f64),
                    row(&|n| ((n + 1) % 2) as f64),
                    row(&|n| (n % 2) as f64),
                ],
                short,
                long,
            }
        })
    }

    /// Evaluates a series at the nodes of the short rule, if that is sufficient, or of the long rule. The
    /// rule integrates to round-off the fourth power of the series' distance from `centre`. It also
    /// integrates the product of the series with an exponential. `turn` \[rad\] is half the angle by which
    /// this exponential turns over the window.
    pub(super) fn evaluate_at_nodes<'a>(
        &'a self,
        set: InstructionSet,
        series: &'a [f64; TERMS],
        centre: f64,
        turn: f64,
    ) -> NodeValues<'a> {
        let sizes = self.sizes(set, series);
        let short = turn <= self.short.widest_turn && sizes.falls_off(series[0] - centre);
        let rule = if short { &self.short } else { &self.long };
        rule.evaluate_at_nodes(set, series, sizes)
    }

    /// Sums over a series.
    pub(super) fn sizes(&self, set: InstructionSet, series: &[f64; TERMS]) -> Sizes {
        let [low, ninth, fourteenth, sixteenth, rise, square, even, odd] =
            lanes::sizes(set, &self.weights, series);
        Sizes {
            variation: low + ninth,
            square,
            ends: [even - odd, even + odd],
            rise,
            tails: [ninth, fourteenth, sixteenth],
        }
    }
}

impl Sizes {
    /// Whether the short rule, exact to degree 63, integrates the fourth power of the series to round-off,
    /// about a centre that is `about` below its mean. With `t_m = Σ_{n≥m} |a_n|` and s the sum of all: four
    /// degrees up to 23 that add up to 64 or more contain one of at least 16, another of at least 14 and another of
    /// at least 9, so that the error is about `24 t₁₆ t₁₄ t₉ s`. Squares are exact.
    pub(super) fn falls_off(&self, about: f64) -> bool {
        let all = self.variation + about.abs();
        24.0 * self.tails.iter().product::<f64>() <= ROUND_OFF * all * all * all
    }
}

impl Rule {
    fn new(groups: usize, widest_turn: f64) -> Self {
        let half = groups * LANES;
        let gauss = GaussLegendre::new(2 * half);
        let positive = |of: &dyn Fn(usize) -> f64| -> Vec<Lanes> {
            let all: Vec<f64> = (0..2 * half)
                .filter(|&j| gauss.nodes[j] > 0.0)
                .map(of)
                .collect();
            (all.as_chunks::<LANES>().0.iter())
                .map(|&eight| Lanes(eight))
                .collect()
        };
        let polynomial = |j: usize, n: usize| {
            let mut values = [0.0; TERMS];
            polynomials(gauss.nodes[j], &mut values);
            values[n]
        };
        Self {
            groups,
            polynomials: (0..TERMS)
                .flat_map(|n| positive(&|j| polynomial(j, n)))
                .collect(),
            weights: positive(&|j| gauss.weights[j]),
            places: positive(&|j| gauss.nodes[j]),
            widest_turn,
        }
    }

    /// All nodes.
    fn nodes(&self) -> Vec<f64> {
        let positive = self.places.iter().flat_map(|eight| eight.0);
        positive.flat_map(|x| [x, -x]).collect()
    }

    /// Evaluates a series with known sizes at the nodes.
    pub(super) fn evaluate_at_nodes<'a>(
        &'a self,
        set: InstructionSet,
        series: &'a [f64; TERMS],
        sizes: Sizes,
    ) -> NodeValues<'a> {
        let mut parts = [Lanes::ZERO; 2 * LONG];
        let used_parts = &mut parts[..2 * self.groups];
        let [low, high] = lanes::parts(set, &self.polynomials, series, used_parts);
        let [start, end] = sizes.ends;
        let range = Range {
            low: low.min(start.min(end)),
            high: high.max(start.max(end)),
            rise: sizes.rise,
        };
        NodeValues {
            rule: self,
            series,
            sizes,
            parts,
            range,
        }
    }
}

impl NodeValues<'_> {
    /// Even part, then odd part at the positive nodes.
    pub(super) fn parts(&self) -> &[Lanes] {
        &self.parts[..2 * self.rule.groups]
    }

    /// Another series at the same nodes.
    pub(super) fn at_same_nodes<'b>(
        &'b self,
        set: InstructionSet,
        series: &'b [f64; TERMS],
    ) -> NodeValues<'b> {
        let sizes = Rules::shared().sizes(set, series);
        self.rule.evaluate_at_nodes(set, series, sizes)
    }

    /// Places and values at both ends and all nodes, in order.
    pub(super) fn values(&self) -> impl Iterator<Item = (f64, f64)> {
        let (even, odd) = self.parts().split_at(self.rule.groups);
        let (count, [start, end]) = (self.rule.groups * LANES, self.sizes.ends);
        let at = move |j: usize| {
            let of = |all: &[Lanes]| all[j / LANES].0[j % LANES];
            [of(&self.rule.places), of(even), of(odd)]
        };
        let left = (0..count).rev().map(at).map(|[x, e, o]| (-x, e - o));
        let right = (0..count).map(at).map(|[x, e, o]| (x, e + o));
        let ends = [(-1.0, start), (1.0, end)].map(std::iter::once);
        let [first, last] = ends;
        first.chain(left).chain(right).chain(last)
    }

    /// Mean square about its mean.
    pub(super) fn square(&self) -> f64 {
        self.sizes.square
    }

    /// Weighted sums of the third and fourth powers of `(value − centre)/unit`.
    pub(super) fn powers(&self, set: InstructionSet, centre: f64, unit: f64) -> [f64; 2] {
        lanes::powers(set, &self.rule.weights, self.parts(), centre, unit)
    }

    /// Start of the search for an extreme with the value `value` among nodes and ends: the node with this
    /// value, else the end.
    pub(super) fn start(&self, value: f64) -> f64 {
        let (even, odd) = self.parts().split_at(self.rule.groups);
        let node = (self.rule.places.iter().zip(even).zip(odd)).find_map(|((x, e), o)| {
            (0..LANES).find_map(|i| match (e.0[i] + o.0[i], e.0[i] - o.0[i]) {
                (right, _) if right == value => Some(x.0[i]),
                (_, left) if left == value => Some(-x.0[i]),
                _ => None,
            })
        });
        let end = if self.sizes.ends[0] == value { -1.0 } else { 1.0 };
        node.unwrap_or(end)
    }
}

/// For each term, a bound on its rise above the values at both ends of a cell. Cells lie between neighbouring
/// nodes, −1 and 1; a cell of length h allows `h²/8 max|P_n''|`.
fn rises(nodes: &[f64]) -> [f64; TERMS] {
    /// Steps in a cell, in which the curvature turns by less than three radians.
    const STEPS: usize = 8;
    /// Factor for larger values between the steps.
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

/// The smaller of two numbers, without the check for NaN of `f64::min`.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The larger of two numbers, without the check for NaN of `f64::max`.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
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

/// Values, slopes and curvatures of four series, each at its own position.
#[inline(always)]
fn evaluate_four(series: &[[f64; 4]; TERMS], x: &[f64; 4]) -> [[f64; 4]; 3] {
    let [mut value, mut slope, mut curvature] = [[0.0; 4]; 3];
    let [mut value_next, mut slope_next, mut curvature_next] = [[0.0; 4]; 3];
    for (a, [up, down]) in series.iter().zip(CLENSHAW).rev() {
        let step = x.map(|x| up * x);
        // Terms that are known early are added first, which keeps the chain of dependencies short.
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

/// Largest values of four series at the stationary points next to given places. Newton's method treats all
/// four series at once, because the sums of a single series would wait for each other. No multiply-add is
/// fused, so that all instruction sets give the same result.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn peaks(series: [&[f64; TERMS]; 4], mut x: [f64; 4]) -> [f64; 4] {
    /// Maximum number of steps. From a node, two come close enough in a smooth series.
    const MOST_STEPS: usize = 6;
    /// After a step below this part of the window, the value is that of the parabola to round-off.
    const SMALL: f64 = 1e-5;
    let lanes: [[f64; 4]; TERMS] =
        std::array::from_fn(|n| series.map(|coefficients| coefficients[n]));
    let mut best = [f64::NEG_INFINITY; 4];
    for _ in 0..MOST_STEPS {
        let [values, slopes, curvatures] = evaluate_four(&lanes, &x);
        let mut goes_on = false;
        // No branches here, because the processor cannot predict the step of a series.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::modal_series::cosine_series;
    use crate::numerics::legendre::{at_end, at_start, evaluate, variation};

    /// Means of the third and fourth powers of `series − centre` by many nodes.
    fn by_many_nodes(series: &[f64; TERMS], centre: f64) -> [f64; 2] {
        let rule = GaussLegendre::new(60);
        [3, 4].map(|power| {
            let nodes = rule.nodes.iter().zip(&rule.weights);
            let values = nodes.map(|(x, w)| 0.5 * w * (evaluate(series, *x) - centre).powi(power));
            values.sum()
        })
    }

    #[test]
    fn powers_are_exact_wherever_a_rule_is_trusted() {
        let rules = Rules::shared();
        for set in InstructionSet::available() {
            let mut trusted = 0;
            for (step, ratio) in [0.02_f64, 0.1, 0.2, 0.3, 0.35, 0.7, 1.0]
                .into_iter()
                .enumerate()
            {
                let series: [f64; TERMS] =
                    std::array::from_fn(|n| ratio.powi(n as i32) * (n as f64 + step as f64).cos());
                let centre = 0.9 * series[0];
                let about = series[0] - centre;
                let short = rules.sizes(set, &series).falls_off(about);
                trusted += usize::from(short);
                let exact = by_many_nodes(&series, centre);
                let bound = variation(&series) + about.abs();
                let own = [short.then_some(&rules.short), Some(&rules.long)];
                for rule in own.into_iter().flatten() {
                    let sizes = rules.sizes(set, &series);
                    let found = rule
                        .evaluate_at_nodes(set, &series, sizes)
                        .powers(set, centre, 0.5);
                    for (power, (found, exact)) in [3, 4].into_iter().zip(found.iter().zip(&exact))
                    {
                        let error = found * 0.5_f64.powi(power) - exact;
                        assert!(
                            error.abs() <= 4e-15 * bound.powi(power),
                            "{ratio}: {error:e}"
                        );
                    }
                }
            }
            assert!((3..7).contains(&trusted), "{trusted} of 7 trusted");
        }
    }

    /// `∫ cos⁴` and the mean square of a cosine, and the bounds from its sizes.
    #[test]
    fn a_cosine_has_the_means_of_the_textbook() {
        let rules = Rules::shared();
        // Over two radians from a on: mean of cos² and cos⁴ by their double angles.
        let a: f64 = -0.4;
        let series = cosine_series(2.0, a, 1.0);
        let primitive = |n: f64, x: f64| (n * x).sin() / n;
        let mean = |n: f64| 0.5 * (primitive(n, a + 2.0) - primitive(n, a));
        let square = 0.5 + 0.5 * mean(2.0);
        let fourth = 0.375 + 0.5 * mean(2.0) + 0.125 * mean(4.0);
        for set in InstructionSet::available() {
            let sizes = rules.sizes(set, &series);
            assert!(sizes.falls_off(series[0]));
            assert!((sizes.square + series[0] * series[0] - square).abs() < 1e-15);
            assert!((sizes.variation - variation(&series)).abs() < 1e-15);
            let ends = [at_start(&series), at_end(&series)];
            for (found, exact) in sizes.ends.into_iter().zip(ends) {
                assert!((found - exact).abs() < 1e-15);
            }
            for rule in [&rules.short, &rules.long] {
                let [_, found] = rule
                    .evaluate_at_nodes(set, &series, sizes)
                    .powers(set, 0.0, 1.0);
                assert!((found - fourth).abs() < 1e-15, "{found} {fourth}");
            }
        }
    }

    /// Series, some of which have decreasing terms.
    fn some_series() -> impl Iterator<Item = [f64; TERMS]> {
        (0..200).map(|case| {
            let ratio = [0.1, 0.4, 0.7, 0.9, 1.0][case % 5];
            std::array::from_fn(|n| {
                f64::powi(ratio, n as i32) * (1.7 * (n * n + 3 * case) as f64).sin()
            })
        })
    }

    /// Largest value at closely and evenly spaced positions.
    fn by_search(series: &[f64; TERMS]) -> f64 {
        let places = (0..=20_000).map(|i| -1.0 + f64::from(i) / 10_000.0);
        let values = places.map(|x| evaluate(series, x));
        values.fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn values_at_nodes_bound_the_extremes() {
        let (rules, set) = (Rules::shared(), InstructionSet::best());
        for rule in [&rules.short, &rules.long] {
            for series in some_series() {
                let sizes = rules.sizes(set, &series);
                let Range { low, high, rise } = rule.evaluate_at_nodes(set, &series, sizes).range;
                let highest = by_search(&series);
                let lowest = -by_search(&series.map(|a| -a));
                assert!(highest <= high + rise, "{highest} {high} {rise}");
                assert!(lowest >= low - rise, "{lowest} {low} {rise}");
                // The search misses 1e-9 of the curvature.
                assert!(high <= highest + 1e-6 && low >= lowest - 1e-6);
            }
        }
        // If the terms of a series decrease, the bound is much smaller than the sum of all coefficients.
        let mut smooth = [0.0; TERMS];
        smooth[..4].copy_from_slice(&[0.3, 0.2, -0.5, 0.1]);
        assert!(rules.sizes(set, &smooth).rise < 0.01);
    }

    #[test]
    fn peaks_are_found_to_round_off() {
        let (rules, set) = (Rules::shared(), InstructionSet::best());
        let rule = &rules.short;
        let start = |series: &[f64; TERMS]| {
            let values = rule.evaluate_at_nodes(set, series, rules.sizes(set, series));
            (values.range.high, values.start(values.range.high))
        };
        let mut count = 0;
        for series in some_series().filter(|series| rules.sizes(set, series).falls_off(0.0)) {
            let exact = by_search(&series);
            let (high, place) = start(&series);
            let other = series.map(|a| -a);
            let [first, ..] = peaks([&series, &other, &series, &other], [place, 0.3, -0.3, 0.0]);
            let found = first.max(high);
            assert!((found - exact).abs() < 1e-7, "{found} {exact}");
            count += 1;
        }
        assert!(count > 30, "{count}");
        let cosine = cosine_series(2.0, -0.9, 1.0);
        let (_, place) = start(&cosine);
        for found in peaks([&cosine; 4], [place, place - 0.1, place + 0.1, place]) {
            assert!((found - 1.0).abs() < 1e-14, "{found:e}");
        }
    }

    #[test]
    fn a_rough_series_is_not_trusted_to_the_short_rule() {
        let (rules, set) = (Rules::shared(), InstructionSet::best());
        let mut series = [0.0; TERMS];
        series[TERMS - 1] = 1.0;
        assert!(!rules.sizes(set, &series).falls_off(0.0));
        let sizes = rules.sizes(set, &series);
        let fourth = |rule: &Rule| {
            rule.evaluate_at_nodes(set, &series, sizes)
                .powers(set, 0.0, 1.0)[1]
        };
        let (short, long) = (fourth(&rules.short), fourth(&rules.long));
        assert!((short - long).abs() > 1e-6 * long, "{short} {long}");
    }
}
