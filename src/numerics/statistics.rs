//! Standard errors of averages over correlated series.

/// Fewest blocks from which a standard error is taken: its own relative error is then
/// about 1/√(2·31), one in eight.
pub const FEWEST_BLOCKS: usize = 32;

/// Mean of a series.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Largest lag-one correlation that the coarsest blocks are corrected for: beyond it the
/// series is too short to say how long it remembers.
const MOST_CORRELATION: f64 = 0.95;

/// Standard error of the mean of a correlated series, by blocking (Flyvbjerg & Petersen
/// 1989): neighbours are averaged in pairs again and again, until 32 to 63 blocks are left.
/// Infinity where the series is shorter than [`FEWEST_BLOCKS`]; no number where a value is none.
///
/// The larger of the two coarsest levels is returned. Finer ones would only count where
/// neighbours undo each other (a mean force, which momentum ties to the load): there they
/// are far too large. Blocks that still remember their neighbours make the coarsest level
/// too small; its lag-one correlation ρ > 0 stands for the levels that the series is too
/// short for: `√((1 + ρ)/(1 − ρ))`, the factor of a memory that fades exponentially, with
/// the bias −1/n of an estimated ρ taken back. docs/theory.md says what intervals cover.
pub fn standard_error(values: &[f64]) -> f64 {
    if values.len() < FEWEST_BLOCKS {
        return f64::INFINITY;
    }
    let mut level = values.to_vec();
    let mut finer: f64 = 0.0;
    loop {
        let (naive, correlation) = naive_error(&level);
        if level.len() < 2 * FEWEST_BLOCKS {
            // A maximum leaves out what is no number.
            return match naive.is_nan() {
                true => f64::NAN,
                false => finer.max(naive * ((1.0 + correlation) / (1.0 - correlation)).sqrt()),
            };
        }
        finer = naive;
        level = level
            .chunks_exact(2)
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .collect();
    }
}

/// Standard error of the mean of values without memory, and their lag-one correlation,
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

/// Student's two-sided 95 % quantile of some degrees of freedom, one at least; beyond a table its
/// expansion in 1/ν.
pub fn student(degrees: usize) -> f64 {
    const QUANTILES: [f64; 10] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    ];
    let degrees = degrees.max(1);
    let inverse = 1.0 / degrees as f64;
    let expansion = 1.96 + 2.37 * inverse + 2.8 * inverse * inverse;
    QUANTILES.get(degrees - 1).copied().unwrap_or(expansion)
}

/// The quantile at `share` of a series in time, and its standard error; `None` without
/// values.
///
/// The error is half the distance of the quantiles at `share ± e`, with `e` the standard
/// error of the share of values below the quantile (Woodruff 1952), taken by blocking, so
/// that memory counts. Infinity where the series is too short for `e`.
pub fn quantile(values: &[f64], share: f64) -> Option<(f64, f64)> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    // Linear between order statistics, the first at share 0 and the last at share 1.
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

    #[test]
    fn independent_values_have_the_textbook_error() {
        let mut stream = Stream::new(1, 2, 3);
        let values: Vec<f64> = (0..4096).map(|_| stream.normal()).collect();
        let error = standard_error(&values);
        assert!((error * 64.0 - 1.0).abs() < 0.35, "{error}");
    }

    #[test]
    fn correlation_is_seen() {
        // AR(1) with a = 0.9: the error of the mean is √((1+a)/(1−a)) = 4.36 times the naive.
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

    /// Share of 95 % intervals that hold the mean, over 2000 series of a process with
    /// lag-one correlation `a`.
    fn coverage(a: f64, length: usize) -> f64 {
        let hits = (0..2000).filter(|&series| {
            let mut stream = Stream::new(7, series, 0);
            let mut x = stream.normal() / (1.0 - a * a).sqrt();
            let values: Vec<f64> = (0..length)
                .map(|_| {
                    x = a * x + stream.normal();
                    x
                })
                .collect();
            mean(&values).abs() < 1.96 * standard_error(&values)
        });
        hits.count() as f64 / 2000.0
    }

    #[test]
    fn intervals_cover_what_they_promise_even_where_memory_outlasts_the_blocks() {
        // Without the correction of the coarsest level: 0.73, 0.75 and 0.90.
        for (a, length, least) in [(0.5, 32, 0.86), (0.8, 128, 0.91), (0.9, 1024, 0.92)] {
            let share = coverage(a, length);
            assert!((least..0.97).contains(&share), "{a} {length}: {share}");
        }
        for length in [32, 128, 1024] {
            let share = coverage(0.0, length);
            assert!((0.94..0.98).contains(&share), "{length}: {share}");
        }
        // The largest of all levels covered 0.999.
        let share = coverage(-0.5, 1024);
        assert!((0.94..0.985).contains(&share), "{share}");
    }

    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        let mut stream = Stream::new(8, 9, 10);
        let values: Vec<f64> = (0..20_000).map(|_| stream.normal()).collect();
        // Value and √(p(1−p)/n)/density.
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
