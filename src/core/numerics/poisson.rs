//! Exact confidence intervals of the rate of rare events.

/// Probability beyond each end of a 95 % interval.
const TAIL: f64 = 0.025;

/// Largest number of steps of Newton's method. It takes about five.
const MOST_STEPS: usize = 50;

/// Largest number of events for which the sums over the Poisson distribution are computed.
const MOST_SUMMED: f64 = 1e9;

/// Exact 95 % interval of the rate of a Poisson process with k = `count` events in T = `exposure`
/// (Garwood 1936):
///
/// ```text
/// [χ²(0.025; 2k)/2T, χ²(0.975; 2k + 2)/2T]
/// ```
///
/// Without events the lower end is 0. The exposure must be positive. The work grows as √k. For more than 10⁹
/// events the ends are those of Wilson and Hilferty, which are then exact to 10⁻¹².
pub fn rate_interval(count: u64, exposure: f64) -> [f64; 2] {
    let k = count as f64;
    let lower = if count == 0 { 0.0 } else { lower_mean(k) };
    [lower / exposure, upper_mean(k) / exposure]
}

/// The lower end: the mean μ at which k or more events have the probability 0.025,
/// `Σ_{j ≥ k} p(j; μ) = 0.025`.
fn lower_mean(k: f64) -> f64 {
    let guess = quantile_guess(k, -1.0);
    if k > MOST_SUMMED {
        return guess;
    }
    solve(guess, |mean| {
        // p(j + 1) = p(j) μ/(j + 1).
        let sum = sum_of_products((1..).map(|i| mean / (k + f64::from(i))));
        [log_probability(k, mean) + sum.ln(), k / (mean * sum)]
    })
}

/// The upper end: the mean μ at which k or fewer events have the probability 0.025,
/// `Σ_{j ≤ k} p(j; μ) = 0.025`.
fn upper_mean(k: f64) -> f64 {
    let guess = quantile_guess(k + 1.0, 1.0);
    if k > MOST_SUMMED {
        return guess;
    }
    solve(guess, |mean| {
        // p(j − 1) = p(j) j/μ.
        let sum = sum_of_products((0..).map(|i| (k - f64::from(i)) / mean));
        [log_probability(k, mean) + sum.ln(), -1.0 / sum]
    })
}

/// Solves `ln P(μ) = ln 0.025` by Newton's method for a function that returns ln P and its
/// derivative. ln P is concave, so the iterates approach the root from one side.
fn solve(start: f64, log_tail: impl Fn(f64) -> [f64; 2]) -> f64 {
    let mut mean = start;
    for _ in 0..MOST_STEPS {
        let [value, slope] = log_tail(mean);
        let next = (mean - (value - TAIL.ln()) / slope).clamp(0.1 * mean, 10.0 * mean);
        let moved = (next - mean).abs();
        mean = next;
        if moved <= 4.0 * f64::EPSILON * mean {
            break;
        }
    }
    mean
}

/// Approximate χ²(2k)/2 at the lower (`sign` −1) or upper (+1) 2.5 % (Wilson & Hilferty 1931).
fn quantile_guess(k: f64, sign: f64) -> f64 {
    let ninth = 1.0 / (9.0 * k);
    k * (1.0 - ninth + sign * 1.959_963_984_540_054 * ninth.sqrt())
        .max(0.1)
        .powi(3)
}

/// `1 + r₀ + r₀ r₁ + …` for decreasing factors r, until the terms are negligible.
fn sum_of_products(factors: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for factor in factors {
        term *= factor;
        sum += term;
        if term <= 1e-17 * sum {
            break;
        }
    }
    sum
}

/// `ln(μᵏ e^{−μ}/k!)` by Loader's saddle point (2000), which does not cancel for large k.
fn log_probability(k: f64, mean: f64) -> f64 {
    if k == 0.0 {
        return -mean;
    }
    let x = (mean - k) / k;
    -stirling_error(k) - k * (x - x.ln_1p()) - 0.5 * (std::f64::consts::TAU * k).ln()
}

/// `ln k! − (k + 1/2) ln k + k − ln √(2π)`.
fn stirling_error(k: f64) -> f64 {
    if k < 16.0 {
        let factorial: f64 = (2..=k as u32).map(f64::from).product();
        let root = 0.5 * std::f64::consts::TAU.ln();
        return factorial.ln() - (k + 0.5) * k.ln() + k - root;
    }
    let square = 1.0 / (k * k);
    let series = [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0];
    series.iter().rev().fold(0.0, |sum, a| a + square * sum) / k
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `scipy.stats.chi2.ppf(0.025, 2k)/2` and `chi2.ppf(0.975, 2k + 2)/2` of SciPy 1.17.1. The
    /// first six agree with the table of Garwood (1936) to all its digits.
    const ENDS: [(u64, f64, f64); 9] = [
        (0, 0.0, 3.6888794541139354),
        (1, 0.025317807984289876, 5.571643390938898),
        (2, 0.24220927854396496, 7.22468766772396),
        (5, 1.6234863901184207, 11.66833207932267),
        (10, 4.7953886961324335, 18.39035604201778),
        (17, 9.903126469607294, 27.218646815906613),
        (100, 81.36399125092314, 121.62679379242638),
        (1000, 938.9730184076952, 1063.952136016302),
        (123_456, 122768.28869851555, 124146.60839534459),
    ];

    #[test]
    fn ends_are_those_of_published_tables() {
        // Four decimals, as printed.
        let printed = [(0, 0.0, 3.6889), (1, 0.0253, 5.5716), (10, 4.7954, 18.3904)];
        for (count, lower, upper) in printed {
            let [low, high] = rate_interval(count, 1.0);
            assert!((low - lower).abs() < 5e-5 && (high - upper).abs() < 5e-5);
        }
        for (count, lower, upper) in ENDS {
            let [low, high] = rate_interval(count, 1.0);
            assert!((low - lower).abs() <= 1e-12 * lower, "{count}: {low}");
            assert!((high - upper).abs() <= 1e-12 * upper, "{count}: {high}");
        }
    }

    #[test]
    fn rates_are_per_exposure() {
        let [whole, tenth] = [rate_interval(3, 1.0), rate_interval(3, 10.0)];
        for (a, b) in whole.into_iter().zip(tenth) {
            assert!((a - 10.0 * b).abs() < 1e-14 * a);
        }
    }

    #[test]
    fn ends_grow_with_the_count() {
        let ends: Vec<[f64; 2]> = (0..2000).map(|k| rate_interval(k, 1.0)).collect();
        for (k, pair) in ends.windows(2).enumerate() {
            assert!(pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1], "{k}");
            assert!(pair[0][0] <= k as f64 && pair[0][1] > k as f64, "{k}");
        }
    }

    #[test]
    fn both_ways_agree_at_the_most_that_are_summed() {
        let most = MOST_SUMMED as u64;
        let [summed, guessed] = [rate_interval(most, 1.0), rate_interval(most + 1, 1.0)];
        for (a, b) in summed.into_iter().zip(guessed) {
            assert!(((b - a - 1.0) / a).abs() < 1e-10, "{a} {b}");
        }
        let largest = rate_interval(u64::MAX, 1.0);
        assert!(largest.iter().all(|end| end.is_finite()));
    }
}
