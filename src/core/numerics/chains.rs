//! Do several chains sample the same motion, and how many independent values do they correspond to?
//!
//! Both figures equal those of ArviZ 0.23 (arviz/stats/diagnostics.py) without ranks. The first is the split
//! R̂ of Gelman et al. (2013, Bayesian Data Analysis, 11.4). The second is the effective sample size by
//! Geyer's initial monotone sequence (Geyer 1992; Vehtari et al. 2021). All chains are cut to the length of
//! the shortest one. Each is split into its first and last half.

use super::plain;
use super::statistics::{is_constant, mean};

/// Smallest number of values of a half.
const FEWEST_VALUES: usize = 4;

/// Halves of chains with n values each.
struct Halves<'a> {
    halves: Vec<&'a [f64]>,
    /// Number of values of each half.
    length: f64,
    means: Vec<f64>,
    /// W, the mean variance within a half.
    within: f64,
    /// B/n, the variance of the means.
    between: f64,
}

impl<'a> Halves<'a> {
    fn new(chains: &[&'a [f64]]) -> Option<Self> {
        let shortest = chains.iter().map(|chain| chain.len()).min()?;
        let half = shortest / 2;
        let halves: Vec<&[f64]> = (chains.iter())
            .flat_map(|chain| [&chain[..half], &chain[shortest - half..shortest]])
            .collect();
        let finite = halves.iter().all(|h| h.iter().all(|x| x.is_finite()));
        if half < FEWEST_VALUES || !finite || halves.iter().all(|h| is_constant(h)) {
            return None;
        }
        let means: Vec<f64> = halves.iter().map(|half| mean(half)).collect();
        let variances: Vec<f64> = halves.iter().map(|half| variance(half)).collect();
        Some(Self {
            length: half as f64,
            within: mean(&variances),
            between: variance(&means),
            halves,
            means,
        })
    }
}

/// Variance of values about their mean, `Σ (x − x̄)² / (n − 1)`.
fn variance(values: &[f64]) -> f64 {
    let centre = mean(values);
    let square: f64 = values.iter().map(|x| (x - centre).powi(2)).sum();
    square / (values.len() as f64 - 1.0)
}

/// Split R̂: `√((B/W + n − 1)/n)` over halves of n values, with the variance B/n of their means
/// and their mean variance W. It is near 1 if all halves sample the same motion. ArviZ gives
/// the same as `rhat(method="split")`, but requires two chains.
///
/// `None` if a half has fewer than 4 values, all halves are constant, or a value is not finite.
pub fn rhat(chains: &[&[f64]]) -> Option<f64> {
    let halves = Halves::new(chains)?;
    let n = halves.length;
    Some(((n * halves.between / halves.within + n - 1.0) / n).sqrt())
}

/// Effective sample size of the mean: `N/τ` with the N values of all halves and
/// `τ = −1 + 2 Σ ρ_t`, summed by Geyer's initial monotone sequence. ArviZ gives the same as
/// `ess(method="mean")`.
///
/// * `ρ_t = 1 − (W − c_t)/(W (n − 1)/n + B/n)`, with `c_t = Σ (x_i − x̄)(x_{i+t} − x̄)/n`
///   averaged over halves.
/// * `τ ≥ 1/log₁₀ N`, the bound of Vehtari et al.
///
/// The work is one pass over the values for each lag until the sequence ends.
///
/// `None` if a half has fewer than 4 values, all halves are constant, or a value is not finite.
pub fn ess(chains: &[&[f64]]) -> Option<f64> {
    let halves = Halves::new(chains)?;
    let n = halves.length;
    let centred: Vec<Vec<f64>> = (halves.halves.iter().zip(&halves.means))
        .map(|(half, centre)| half.iter().map(|x| x - centre).collect())
        .collect();
    let total = halves.within * (n - 1.0) / n + halves.between;
    let correlation = |lag| 1.0 - (halves.within - autocovariance(&centred, lag)) / total;

    let mut correlations = initial_sequence(correlation, halves.halves[0].len());
    let last = correlations.len() - 2;
    make_monotone(&mut correlations, last);
    let sum: f64 = correlations[..last].iter().sum();
    let all = n * centred.len() as f64;
    let time = (2.0 * sum + correlations[last] - 1.0).max(1.0 / all.log10());
    let size = all / time;
    size.is_finite().then_some(size)
}

/// Correlations at lags 0, 1, …, until a pair of neighbours has a negative sum (Geyer's initial positive
/// sequence). Of the last pair only the first value counts. It is set to 0 if it and the sum of the pair are
/// negative.
fn initial_sequence(correlation: impl Fn(usize) -> f64, length: usize) -> Vec<f64> {
    let mut correlations = vec![1.0, correlation(1)];
    let mut pair = [correlations[0], correlations[1]];
    while correlations.len() < length - 2 && pair[0] + pair[1] > 0.0 {
        pair = [
            correlation(correlations.len()),
            correlation(correlations.len() + 1),
        ];
        correlations.extend(if pair[0] + pair[1] >= 0.0 { pair } else { [pair[0].max(0.0), 0.0] });
    }
    correlations
}

/// Lowers the sum of each pair of correlations below lag `last` to that of the pair before it (Geyer's
/// initial monotone sequence).
fn make_monotone(correlations: &mut [f64], last: usize) {
    for t in (2..last.saturating_sub(1)).step_by(2) {
        let before = correlations[t - 2] + correlations[t - 1];
        if correlations[t] + correlations[t + 1] > before {
            correlations[t] = 0.5 * before;
            correlations[t + 1] = 0.5 * before;
        }
    }
}

/// `Σ d_i d_{i+lag} / n`, averaged over series d from which their means have been subtracted.
fn autocovariance(centred: &[Vec<f64>], lag: usize) -> f64 {
    let sums = centred.iter().map(|series| {
        let length = series.len();
        plain::dot(&series[..length - lag], &series[lag..]) / length as f64
    });
    sums.sum::<f64>() / centred.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The series `x ← a x + u − 1/2` plus an offset, with u in [0, 1) from Knuth's generator.
    fn series(seed: u64, length: usize, a: f64, offset: f64) -> Vec<f64> {
        let (mut state, mut x) = (seed, 0.0);
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            x = a * x + (state >> 11) as f64 * (-53f64).exp2() - 0.5;
            x + offset
        };
        (0..length).map(|_| next()).collect()
    }

    fn chains(count: usize, length: usize, a: f64, apart: f64) -> Vec<Vec<f64>> {
        (0..count)
            .map(|j| series(j as u64 + 1, length, a, apart * j as f64))
            .collect()
    }

    fn slices(chains: &[Vec<f64>]) -> Vec<&[f64]> {
        chains.iter().map(Vec::as_slice).collect()
    }

    /// Number of chains, values per chain, a, difference of offsets; then `arviz.rhat(x, method="split")` and
    /// `arviz.ess(x, method="mean")` of ArviZ 0.23.4. For the single chain, R̂ is
    /// `arviz.stats.diagnostics._rhat(_split_chains(x))`, because the public function requires two chains.
    #[rustfmt::skip]
    const ARVIZ: [(usize, usize, f64, f64, f64, f64); 11] = [
        (4, 1000, 0.9, 0.0, 1.0082785264532859, 211.7458491125953),
        (8, 2001, 0.5, 0.0, 1.0012254947282049, 5202.207094357908),
        (2, 500, -0.7, 0.0, 0.998084475940486, 3000.0),
        (4, 300, 0.3, 0.4, 1.8522538890102065, 5.940203474580419),
        (3, 160, 0.98, 0.0, 1.1400282308921597, 14.451149010948658),
        (2, 8, 0.0, 0.0, 1.010061074457767, 19.265919722494797),
        (2, 9, 0.5, 0.0, 1.4898731689740288, 19.265919722494797),
        (1, 200, 0.6, 0.0, 0.9960538471730377, 55.89062754337468),
        (4, 400, 0.999, 3.0, 2.7927437711334164, 4.738368175608381),
        (2, 10, -0.9, 0.0, 0.9189046706937826, 26.020599913279625),
        (2, 41, -0.95, 0.0, 0.9754560285851004, 152.24719895935547),
    ];

    #[test]
    fn figures_are_those_of_arviz() {
        for (count, length, a, apart, wanted_rhat, wanted_ess) in ARVIZ {
            let chains = chains(count, length, a, apart);
            let found = [rhat, ess].map(|f| f(&slices(&chains)).unwrap());
            for (found, wanted) in found.into_iter().zip([wanted_rhat, wanted_ess]) {
                let error = (found / wanted - 1.0).abs();
                assert!(error < 1e-10, "{count} {length} {a}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn chains_are_cut_to_the_shortest() {
        let mut ragged = chains(3, 100, 0.5, 0.0);
        let cut: Vec<&[f64]> = ragged.iter().map(|c| &c[..83]).collect();
        let wanted = [rhat(&cut), ess(&cut)];
        ragged[1].truncate(83);
        assert_eq!([rhat(&slices(&ragged)), ess(&slices(&ragged))], wanted);
    }

    #[test]
    fn without_values_or_spread_there_is_no_figure() {
        let short = chains(3, 7, 0.5, 0.0);
        let constant = vec![vec![0.1; 50], vec![0.2; 50]];
        let mut holed = chains(3, 50, 0.5, 0.0);
        holed[2][17] = f64::NAN;
        for chains in [Vec::new(), short, constant, holed] {
            assert_eq!(rhat(&slices(&chains)), None);
            assert_eq!(ess(&slices(&chains)), None);
        }
    }
}
