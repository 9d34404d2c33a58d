//! Weighted Birkhoff averages (Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111).
//!
//! The mean `Σ w(tᵢ) xᵢ / Σ w(tᵢ)` over a record of n values has the weights
//!
//! ```text
//! w(t) = exp(−1/(t (1 − t))),   tᵢ = (i + 1/2)/n
//! ```
//!
//! For quasi-periodic motion its error falls faster than any power of n. For chaotic motion it falls like
//! `n^{−1/2}`, as the error of the plain mean does.

use super::statistics::is_constant;
use num_complex::{Complex64, c64};
use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Length of the shortest series whose [`frequency`] is computed.
pub const FEWEST_VALUES: usize = 64;

/// Largest number of steps in the refinement of a frequency. Newton's method takes a few.
const MOST_STEPS: usize = 60;

/// Weights of a record of `length` values; their sum is 1.
fn weights(length: usize) -> Vec<f64> {
    let mut weights: Vec<f64> = (0..length)
        .map(|i| {
            let t = (i as f64 + 0.5) / length as f64;
            (-1.0 / (t * (1.0 - t))).exp()
        })
        .collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    weights
}

/// Weighted mean of a series; NaN without values.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let weights = weights(values.len());
    values.iter().zip(&weights).map(|(x, w)| w * x).sum()
}

/// Frequency of the strongest line of a series about its weighted mean, in turns per value,
/// within (0, 1/2].
///
/// It maximises the modulus of `S(f) = Σ wᵢ (xᵢ − x̄) e^{−2πi f i}`. A Fourier transform gives the
/// neighbourhood of the maximum, and Newton's method on `d|S|²/df` the frequency. On a
/// quasi-periodic series the result is exact nearly to round-off.
///
/// `None` if the series is shorter than [`FEWEST_VALUES`], constant to round-off, or contains a
/// value that is not finite.
pub fn frequency(values: &[f64]) -> Option<f64> {
    let finite = values.iter().all(|x| x.is_finite());
    if values.len() < FEWEST_VALUES || !finite || is_constant(values) {
        return None;
    }
    let weights = weights(values.len());
    let centre: f64 = values.iter().zip(&weights).map(|(x, w)| w * x).sum();
    let weighted: Vec<f64> = (values.iter().zip(&weights))
        .map(|(x, w)| w * (x - centre))
        .collect();
    let (coarse, step) = coarse_peak(&weighted)?;
    let refined = refine(&weighted, coarse, step);
    // A real series has the same line at f and at 1 − f.
    let folded = refined.min(1.0 - refined);
    (folded > 0.0).then_some(folded)
}

/// Frequency of the largest Fourier coefficient at a frequency above 0, and the distance between
/// coefficients. Zero padding halves this distance. The maximum therefore lies between the neighbouring
/// coefficients.
fn coarse_peak(weighted: &[f64]) -> Option<(f64, f64)> {
    let length = 2 * weighted.len().next_power_of_two();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let mut input = transform.make_input_vec();
    input[..weighted.len()].copy_from_slice(weighted);
    let mut output = transform.make_output_vec();
    transform.process(&mut input, &mut output).ok()?;
    let (place, _) = (output.iter().enumerate().skip(1))
        .max_by(|(_, a), (_, b)| a.norm_sqr().total_cmp(&b.norm_sqr()))?;
    let step = 1.0 / length as f64;
    Some((place as f64 * step, step))
}

/// Position of the maximum of |S| within one `step` of `start`, by Newton's method for a zero of the slope of
/// |S|². A step that leaves the bracket is replaced by a bisection.
fn refine(weighted: &[f64], start: f64, step: f64) -> f64 {
    let (mut low, mut high) = (start - step, start + step);
    let mut at = start;
    for _ in 0..MOST_STEPS {
        let [slope, curvature] = slope_of_square(weighted, at);
        if slope > 0.0 {
            low = at;
        } else {
            high = at;
        }
        let newton = at - slope / (TAU * curvature);
        let next = if curvature < 0.0 && low < newton && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let moved = (next - at).abs();
        at = next;
        if moved <= f64::EPSILON * step.max(1e-3 * at) {
            break;
        }
    }
    at
}

/// First and second derivative of |S|²/2 with respect to 2πf.
///
/// Times are measured from the middle of the record: this choice makes the variation of S smallest.
fn slope_of_square(weighted: &[f64], frequency: f64) -> [f64; 2] {
    let middle = 0.5 * (weighted.len() as f64 - 1.0);
    // Σ v τᵏ e^{−2πi f τ}.
    let mut sums = [Complex64::ZERO; 3];
    for (i, value) in weighted.iter().enumerate() {
        let time = i as f64 - middle;
        let turns = frequency * time;
        let term = *value * Complex64::cis(-TAU * (turns - turns.round()));
        sums[0] += term;
        sums[1] += time * term;
        sums[2] += time * time * term;
    }
    // S' = −i Σ₁ and S'' = −Σ₂.
    let first = c64(sums[1].im, -sums[1].re);
    let slope = (sums[0].conj() * first).re;
    let curvature = first.norm_sqr() - (sums[0].conj() * sums[2]).re;
    [slope, curvature]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;
    use crate::numerics::statistics;

    const GOLDEN: f64 = 0.618_033_988_749_894_9;

    /// Largest error of a mean over 20 starts. The motion has two incommensurate frequencies and infinitely
    /// many spectral lines, and its exact mean is the Bessel value I₀(1).
    fn error(length: usize, average: fn(&[f64]) -> f64) -> f64 {
        let starts = (0..20).map(|start| {
            let values: Vec<f64> = (0..length)
                .map(|i| {
                    let i = f64::from(start) * 37.3 + i as f64;
                    let angles = [TAU * 0.035 * GOLDEN * i, TAU * 2f64.sqrt() * i];
                    angles[0].cos().exp() + 0.5 * (angles[0] + angles[1]).sin()
                })
                .collect();
            (average(&values) - 1.266_065_877_752_008_4).abs()
        });
        starts.fold(0.0, f64::max)
    }

    #[test]
    fn means_over_a_torus_converge_faster_than_a_power() {
        let errors = [200, 400, 800, 1600].map(|n| error(n, mean));
        let orders: Vec<f64> = (errors.windows(2))
            .map(|pair| (pair[0] / pair[1]).log2())
            .collect();
        let plain = [200, 1600].map(|n| error(n, statistics::mean));
        // The order of the power law between neighbours grows with the length: 4.1, 7.5, 10.5.
        assert!(
            orders[0] > 4.0 && orders[1] > 7.0 && orders[2] > 10.0,
            "{orders:?}"
        );
        assert!(errors[0] / errors[3] > 8f64.powi(7), "{errors:?}");
        // The weighted mean has an error of 1e-9, the plain mean of 0.01.
        assert!(errors[3] < 2e-9 && plain[1] > 5e-3, "{errors:?} {plain:?}");
    }

    #[test]
    fn means_of_noise_converge_as_plain_ones() {
        let spread = |length: usize| {
            let square: f64 = (0..400)
                .map(|series| {
                    let mut stream = Stream::new(11, series, length as u64);
                    let values: Vec<f64> = (0..length).map(|_| stream.normal()).collect();
                    mean(&values).powi(2)
                })
                .sum();
            (square / 400.0 * length as f64).sqrt()
        };
        // The factor 1.37 is √(∫w²)/∫w of the weights.
        for length in [200, 1600] {
            let found = spread(length);
            assert!((found / 1.37 - 1.0).abs() < 0.12, "{length}: {found}");
        }
    }

    #[test]
    fn the_frequency_of_a_rotation_is_exact() {
        for (rotation, length) in [(GOLDEN, 4000), (0.1 * GOLDEN, 4000), (2f64.sqrt(), 1001)] {
            let values: Vec<f64> = (0..length)
                .map(|i| {
                    let angle = TAU * (rotation * f64::from(i)).fract();
                    3.0 + angle.cos() + 0.6 * (2.0 * angle + 1.0).sin() + 0.3 * (5.0 * angle).cos()
                })
                .collect();
            let turn = rotation.fract();
            let found = frequency(&values).unwrap();
            let error = (found - turn.min(1.0 - turn)).abs();
            assert!(error < 1e-14, "{rotation}: {error:e}");
        }
    }

    #[test]
    fn the_strongest_of_two_lines_is_found() {
        for frequencies in [[0.07, 0.31], [0.46, 0.2], [0.05, 0.11]] {
            let values: Vec<f64> = (0..600)
                .map(|i| {
                    let [a, b] = frequencies.map(|f| TAU * f * f64::from(i));
                    1e-6 * ((a + 0.4).cos() + 0.8 * b.sin()) + 2.0
                })
                .collect();
            let found = frequency(&values).unwrap();
            assert!((found - frequencies[0]).abs() < 1e-9, "{found}");
        }
    }

    #[test]
    fn two_values_in_turn_have_the_highest_frequency() {
        let values: Vec<f64> = (0..64).map(|i| f64::from(i % 2)).collect();
        let found = frequency(&values).unwrap();
        assert!((0.5 - 1e-9..=0.5).contains(&found), "{found}");
    }

    #[test]
    fn series_without_a_line_have_no_frequency() {
        let values: Vec<f64> = (0..64).map(|i| f64::from(i).sin()).collect();
        assert!(frequency(&values[..63]).is_none());
        for value in [0.0, 0.1, f64::NAN, f64::INFINITY] {
            assert!(frequency(&[value; 100]).is_none(), "{value}");
        }
        let mut holed = values.clone();
        holed[7] = f64::NAN;
        assert!(frequency(&holed).is_none());
        assert!(mean(&[]).is_nan());
        assert_eq!(mean(&[2.5]), 2.5);
    }
}
