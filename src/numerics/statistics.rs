//! Standard errors of averages over correlated series.

/// Fewest blocks from which a standard error is taken: its own relative error is then
/// about 1/√(2·31), one in eight.
pub const FEWEST_BLOCKS: usize = 32;

/// Mean of a series.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard error of the mean of a correlated series, by blocking (Flyvbjerg & Petersen
/// 1989): neighbours are averaged in pairs again and again; the naive standard error grows
/// until blocks are longer than the memory. The largest over all levels with at least
/// [`FEWEST_BLOCKS`] blocks is returned; infinity where the series is shorter.
pub fn standard_error(values: &[f64]) -> f64 {
    if values.len() < FEWEST_BLOCKS {
        return f64::INFINITY;
    }
    let mut level = values.to_vec();
    let mut largest: f64 = 0.0;
    while level.len() >= FEWEST_BLOCKS {
        let n = level.len() as f64;
        let centre = mean(&level);
        let variance = level.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / (n - 1.0);
        largest = largest.max((variance / n).sqrt());
        level = level
            .chunks_exact(2)
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .collect();
    }
    largest
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

    #[test]
    fn too_short_a_series_has_no_error_bar() {
        assert_eq!(standard_error(&[1.0; 31]), f64::INFINITY);
        assert_eq!(standard_error(&[1.0; 64]), 0.0);
    }
}
