//! Standard errors of averages over correlated series.

/// Smallest number of blocks at the coarsest level. At ten chaotic points, 95 % intervals have a coverage of
/// 0.91 to 1.00 with 16 blocks, and of 0.86 to 1.00 with 32. The relative uncertainty of a standard error is
/// about 1/√(2·15). [`interval_factor`] takes it into account.
pub const FEWEST_BLOCKS: usize = 16;

/// Length of the shortest series whose standard error is computed: its values are averaged in pairs once.
pub const FEWEST_VALUES: usize = 2 * FEWEST_BLOCKS;

/// Mean of a series.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation of a sample.
pub fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    let square: f64 = values.iter().map(|v| (v - centre).powi(2)).sum();
    (square / (values.len() as f64 - 1.0).max(1.0)).sqrt()
}

/// Upper limit of the lag-one correlation in the correction of the coarsest blocks. With a larger correlation
/// the series is too short to determine its correlation time.
const MOST_CORRELATION: f64 = 0.95;

/// Standard error of the mean of a correlated series, by blocking (Flyvbjerg & Petersen 1989).
/// Neighbours are averaged in pairs again and again, until 16 to 31 blocks are left. The result is
/// infinite if the series is shorter than [`FEWEST_VALUES`], and NaN if a value is NaN.
///
/// The result is the larger error of the two coarsest levels. Finer levels give far too large errors if
/// neighbours compensate each other. An example is a mean force, because the momentum balance ties it to the
/// load. The coarsest level gives too small an error if its blocks are still correlated. It is therefore
/// multiplied by `√((1 + ρ)/(1 − ρ))` with its lag-one correlation ρ ≥ 0, the factor of an exponentially
/// decaying correlation. The estimate of ρ is corrected by its bias −1/n. docs/theory/exponents.md states the coverage
/// of intervals.
pub fn standard_error(values: &[f64]) -> f64 {
    if values.len() < FEWEST_VALUES {
        return f64::INFINITY;
    }
    let mut level = values.to_vec();
    let mut finer: f64 = 0.0;
    loop {
        let (naive, correlation) = naive_error(&level);
        if level.len() < 2 * FEWEST_BLOCKS {
            // `max` would drop a NaN.
            return if naive.is_nan() {
                f64::NAN
            } else {
                finer.max(naive * ((1.0 + correlation) / (1.0 - correlation)).sqrt())
            };
        }
        finer = naive;
        level = level
            .chunks_exact(2)
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .collect();
    }
}

/// Half width of the 95 % interval of a mean, in standard errors, for a series of `length` values:
/// Student's quantile of blocks − 1 degrees of freedom. It is infinite if the series is too
/// short for [`standard_error`].
pub fn interval_factor(length: usize) -> f64 {
    if length < FEWEST_VALUES {
        return f64::INFINITY;
    }
    let mut blocks = length;
    while blocks >= 2 * FEWEST_BLOCKS {
        blocks /= 2;
    }
    student(blocks - 1)
}

/// Correlation time of a series in units of one value: `τ = e² n / s²`, with the standard error
/// e of the mean and the variance s² of the values. The mean is as uncertain as that of n/τ
/// independent values (Sokal 1997, where τ is called 2 τ_int).
///
/// It is 24 % too long on average, because the standard error is the larger of two. For a constant series
/// τ is zero. The result is never NaN. It is infinite if the series is shorter than [`FEWEST_VALUES`] or
/// contains a value that is not finite.
pub fn correlation_time(values: &[f64]) -> f64 {
    let error = standard_error(values);
    if !error.is_finite() {
        return f64::INFINITY;
    }
    if is_constant(values) {
        return 0.0;
    }
    let (naive, _) = naive_error(values);
    let time = (error / naive).powi(2);
    if time.is_finite() { time } else { f64::INFINITY }
}

/// Skewness of values, `m₃ / m₂^{3/2}` with the central moments `m_k = Σ (x − x̄)^k / n`.
/// It is 0 for fewer than 3 values and for constant ones, otherwise NaN if a value is not finite.
pub fn skewness(values: &[f64]) -> f64 {
    if values.len() < 3 || is_constant(values) {
        return 0.0;
    }
    let centre = mean(values);
    let average = |f: &dyn Fn(f64) -> f64| {
        let sum: f64 = values.iter().map(|v| f(v - centre)).sum();
        sum / values.len() as f64
    };
    let deviation = average(&|d| d * d).sqrt();
    average(&|d| (d / deviation).powi(3))
}

/// Whether all values are equal up to round-off: their range is at most 16 ε times the
/// largest modulus. A series with a value that is not finite is not constant.
pub fn is_constant(values: &[f64]) -> bool {
    if values.iter().any(|v| !v.is_finite()) {
        return false;
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    high - low <= 16.0 * f64::EPSILON * low.abs().max(high.abs()) || values.is_empty()
}

/// Standard error of the mean of uncorrelated values, and their lag-one correlation,
/// at least 0.
fn naive_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let centre = mean(values);
    let square: f64 = values.iter().map(|v| (v - centre).powi(2)).sum();
    let neighbours: f64 = (values.windows(2))
        .map(|pair| (pair[0] - centre) * (pair[1] - centre))
        .sum();
    let correlation = if square > 0.0 {
        (neighbours / square + 1.0 / n).clamp(0.0, MOST_CORRELATION)
    } else {
        0.0
    };
    ((square / (n - 1.0) / n).sqrt(), correlation)
}

/// Student's two-sided 95 % quantile for ν degrees of freedom; 0 counts as 1. It is from a table up to ν =
/// 10, then from an expansion in 1/ν.
pub fn student(degrees: usize) -> f64 {
    const QUANTILES: [f64; 10] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    ];
    let degrees = degrees.max(1);
    let inverse = 1.0 / degrees as f64;
    let expansion = 1.96 + 2.37 * inverse + 2.8 * inverse * inverse;
    QUANTILES.get(degrees - 1).copied().unwrap_or(expansion)
}

/// The quantile of a time series at a share of its values, and its standard error; `None` without values.
///
/// The error is half the distance of the quantiles at `share ± e`, with the standard error `e` of the share
/// of values up to the quantile (Woodruff 1952). Blocking gives `e`, so that it includes correlation. The
/// error is infinite if the series is too short.
pub fn quantile(values: &[f64], share: f64) -> Option<(f64, f64)> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    // Interpolate linearly between the sorted values. The first one has share 0, the last one share 1.
    let at = |share: f64| {
        let place = share.clamp(0.0, 1.0) * last as f64;
        let (low, part) = (place as usize, place.fract());
        sorted[low] + part * (sorted[(low + 1).min(last)] - sorted[low])
    };
    let value = at(share);
    let below: Vec<f64> = (values.iter())
        .map(|v| f64::from(u8::from(*v <= value)))
        .collect();
    let error = standard_error(&below);
    let spread = if error.is_finite() {
        0.5 * (at(share + error) - at(share - error))
    } else {
        f64::INFINITY
    };
    Some((value, spread))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;

    /// Lag-one correlation, length, and the measured coverage of 95 % intervals.
    const COVERAGE: [(f64, usize, f64); 10] = [
        (0.0, 32, 0.9665),
        (0.0, 128, 0.9685),
        (0.0, 1024, 0.973),
        (0.5, 32, 0.9115),
        (0.5, 128, 0.9495),
        (0.8, 128, 0.923),
        (0.8, 256, 0.9485),
        (0.9, 1024, 0.9615),
        (0.95, 4000, 0.952),
        (-0.5, 1024, 0.976),
    ];

    #[test]
    fn independent_values_have_the_textbook_error() {
        let mut stream = Stream::new(1, 2, 3);
        let values: Vec<f64> = (0..4096).map(|_| stream.normal()).collect();
        let error = standard_error(&values);
        assert!((error * 64.0 - 1.0).abs() < 0.35, "{error}");
    }

    #[test]
    fn correlation_is_seen() {
        // AR(1) with a = 0.9: the error of the mean is √((1+a)/(1−a)) = 4.36 times that of uncorrelated
        // values.
        let mut stream = Stream::new(4, 5, 6);
        let mut x = 0.0;
        let values: Vec<f64> = (0..16384)
            .map(|_| {
                x = 0.9 * x + stream.normal();
                x
            })
            .collect();
        let exact = 10.0 / 16384f64.sqrt();
        let ratio = standard_error(&values) / exact;
        assert!((0.8..1.6).contains(&ratio), "{ratio}");
    }

    /// A series of a process with lag-one correlation `a`.
    fn autoregressive(a: f64, length: usize, number: u64) -> Vec<f64> {
        let mut stream = Stream::new(7, number, 0);
        let mut x = stream.normal() / (1.0 - a * a).sqrt();
        let mut next = || {
            x = a * x + stream.normal();
            x
        };
        (0..length).map(|_| next()).collect()
    }

    /// Share of 95 % intervals that contain the mean, over 2000 such series.
    fn coverage(a: f64, length: usize) -> f64 {
        let hits = (0..2000).filter(|&number| {
            let values = autoregressive(a, length, number);
            mean(&values).abs() < interval_factor(length) * standard_error(&values)
        });
        hits.count() as f64 / 2000.0
    }

    #[test]
    fn intervals_cover_what_they_promise_even_where_memory_outlasts_the_blocks() {
        for (a, length, wanted) in COVERAGE {
            let share = coverage(a, length);
            assert!((share - wanted).abs() < 0.002, "{a} {length}: {share}");
        }
    }

    #[test]
    fn interval_factors_are_students() {
        assert_eq!(interval_factor(31), f64::INFINITY);
        for (length, blocks) in [(32, 16), (63, 31), (64, 16), (1000, 31), (2000, 31)] {
            assert_eq!(interval_factor(length), student(blocks - 1), "{length}");
        }
    }

    #[test]
    fn correlation_times_are_those_of_the_process() {
        // (1 + a)/(1 − a) for a long series; the larger of two levels adds 24 %.
        for (a, exact) in [(0.0, 1.0), (0.5, 3.0), (0.9, 19.0)] {
            let sum: f64 = (0..100)
                .map(|n| correlation_time(&autoregressive(a, 8192, n)))
                .sum();
            let ratio = sum / 100.0 / exact;
            assert!((1.15..1.3).contains(&ratio), "{a}: {ratio}");
        }
        assert_eq!(correlation_time(&[0.1; 100]), 0.0);
        assert_eq!(correlation_time(&[0.0; 100]), 0.0);
        assert_eq!(correlation_time(&[1.0; 31]), f64::INFINITY);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut values = autoregressive(0.0, 100, 0);
            values[50] = bad;
            assert_eq!(correlation_time(&values), f64::INFINITY, "{bad}");
            assert_eq!(correlation_time(&[bad; 100]), f64::INFINITY, "{bad}");
        }
    }

    #[test]
    fn skewness_is_the_third_standardized_moment() {
        // Moments of {0, 0, 0, 4} about 1: m₂ = 3, m₃ = 6.
        let exact = 6.0 / 27f64.sqrt();
        assert!((skewness(&[0.0, 0.0, 4.0, 0.0]) - exact).abs() < 1e-15);
        assert!((skewness(&[0.0, 0.0, -4.0, 0.0]) + exact).abs() < 1e-15);
        let mut stream = Stream::new(3, 1, 4);
        let values: Vec<f64> = (0..40_000).map(|_| -stream.uniform().ln()).collect();
        let found = skewness(&values);
        assert!((found - 2.0).abs() < 0.15, "{found}");
        for flat in [&[][..], &[1.0, 2.0], &[0.1; 7], &[0.0; 7]] {
            assert_eq!(skewness(flat), 0.0);
        }
        assert!(skewness(&[1.0, 2.0, f64::INFINITY]).is_nan());
    }

    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        let mut stream = Stream::new(8, 9, 10);
        let values: Vec<f64> = (0..20_000).map(|_| stream.normal()).collect();
        // The textbook error is √(p(1−p)/n)/density.
        for (share, exact, density) in [(0.5, 0.0, 0.398_942), (0.9, 1.281_552, 0.175_498)] {
            let (value, error) = quantile(&values, share).unwrap();
            let textbook = (share * (1.0 - share) / 2e4f64).sqrt() / density;
            assert!((error / textbook - 1.0).abs() < 0.35, "{error} {textbook}");
            assert!((value - exact).abs() < 4.0 * textbook, "{value}");
        }
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[3.0, 1.0, 2.0], 0.5), Some((2.0, f64::INFINITY)));
    }

    #[test]
    fn too_short_a_series_has_no_error_bar() {
        assert_eq!(standard_error(&[1.0; 31]), f64::INFINITY);
        assert_eq!(standard_error(&[1.0; 64]), 0.0);
        for length in [32, 63, 64, 300] {
            assert!(standard_error(&vec![f64::NAN; length]).is_nan());
        }
    }

    #[test]
    fn students_quantile_joins_its_table() {
        for (degrees, wanted) in [
            (0, 12.706),
            (10, 2.228),
            (11, 2.201),
            (30, 2.042),
            (120, 1.98),
        ] {
            assert!((student(degrees) - wanted).abs() < 5e-3, "{degrees}");
        }
    }
}
