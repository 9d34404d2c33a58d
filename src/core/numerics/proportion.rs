//! How accurately does a count determine a proportion?
//!
//! The score interval of Wilson (1927) for `k` successes in `n` independent trials with
//! `p = k/n` and the normal quantile `z`:
//!
//! ```text
//! (p + z²/2n ± z √(p(1−p)/n + z²/4n²)) / (1 + z²/n)
//! ```
//!
//! Unlike `p ± z √(p(1−p)/n)` it is valid for few trials and near 0 and 1.

/// Normal quantile of a two-sided 95 % interval.
const Z: f64 = 1.959_963_984_540_054;

/// The 95 % interval of the proportion for `successes` of `trials`; `[0, 1]` without
/// trials.
pub fn wilson_interval(successes: usize, trials: usize) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let n = trials as f64;
    let p = successes as f64 / n;
    let square = Z * Z / n;
    let centre = p + 0.5 * square;
    let half = Z * (p * (1.0 - p) / n + 0.25 * square / n).sqrt();
    // At 0 and 1 return exact ends, because the difference of the two terms has round-off.
    [
        if successes == 0 { 0.0 } else { (centre - half) / (1.0 + square) },
        if successes == trials { 1.0 } else { (centre + half) / (1.0 + square) },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe, Statistics in Medicine 17 (1998) 857–872, table I, method 3.
    #[test]
    fn published_intervals() {
        for (successes, trials, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = wilson_interval(successes, trials);
            assert!((found[0] - low).abs() < 5.1e-5, "{successes}: {found:?}");
            assert!((found[1] - high).abs() < 5.1e-5, "{successes}: {found:?}");
        }
    }
}
