//! How many dimensions does the motion fill?
//!
//! The Kaplan–Yorke dimension (Kaplan & Yorke 1979) of the states once per mesh cycle. The exponents are in
//! falling order, and k is the largest number whose sum `S_k = λ₁ + … + λ_k` is not negative:
//!
//! ```text
//! D = k + S_k / |λ_{k+1}|
//! ```
//!
//! This is the dimension of the map of a mesh cycle; the trajectory in continuous time fills one more.

use super::outcome::KaplanYorke;
use crate::numerics::statistics::standard_error;

/// The value of the formula, and its derivatives with respect to the exponents.
#[derive(Debug, Clone, PartialEq)]
struct Formula {
    value: f64,
    slopes: Vec<f64>,
}

/// The formula for exponents in falling order, in a space of `dimension` dimensions. `None` if only some
/// exponents are given and their sum is not negative, because k is then unknown.
fn formula(exponents: &[f64], dimension: usize) -> Option<Formula> {
    let mut sum = 0.0;
    let mut slopes = vec![0.0; exponents.len()];
    for (k, &next) in exponents.iter().enumerate() {
        if sum + next < 0.0 {
            slopes[..k].fill(-1.0 / next);
            slopes[k] = sum / (next * next);
            let value = k as f64 - sum / next;
            return Some(Formula { value, slopes });
        }
        sum += next;
    }
    let value = exponents.len() as f64;
    (exponents.len() == dimension).then_some(Formula { value, slopes })
}

/// The dimension and its standard error. `series` contains the averages of each exponent over the same stretches.
/// `exponents` contains the exponents in the same, falling order. The standard error comes from the blocks of
/// `Σ ∂D/∂λᵢ λᵢ`, so that the common changes of several exponents count once. `None` if the exponents do not determine
/// the dimension.
///
/// * `zero`: exponents of at most this size count as 0, as they do on a torus \[1/cycle\].
/// * `dimension`: number of all exponents.
pub fn kaplan_yorke(
    series: &[&[f64]],
    exponents: &[f64],
    zero: f64,
    dimension: usize,
) -> Option<KaplanYorke> {
    let counted: Vec<f64> = exponents
        .iter()
        .map(|e| if e.abs() <= zero { 0.0 } else { *e })
        .collect();
    let Formula { value, slopes } = formula(&counted, dimension)?;
    let stretches = series.first()?.len();
    let deviations: Vec<f64> = (0..stretches)
        .map(|t| {
            // Exponents of −∞ have no weight.
            let terms = slopes
                .iter()
                .zip(series)
                .filter(|(slope, _)| **slope != 0.0);
            terms.map(|(slope, s)| slope * s[t]).sum()
        })
        .collect();
    Some(KaplanYorke {
        value,
        stderr: standard_error(&deviations),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_is_that_of_kaplan_and_yorke() {
        let value = |exponents: &[f64], dimension| formula(exponents, dimension).map(|f| f.value);
        assert_eq!(value(&[0.5, -1.0], 2), Some(1.5));
        assert_eq!(value(&[0.5, 0.0, -2.0], 3), Some(2.25));
        assert_eq!(value(&[-0.1, -0.2], 2), Some(0.0));
        // The exponents add up to zero, so volume is conserved and the motion fills its space.
        assert_eq!(value(&[0.5, -0.5], 2), Some(2.0));
        // Two of four exponents with a positive sum do not determine the dimension.
        assert_eq!(value(&[0.5, -0.1], 4), None);
        assert_eq!(value(&[0.5, f64::NEG_INFINITY], 2), Some(1.0));
    }

    #[test]
    fn its_derivatives_are_differences_of_it() {
        let exponents = [0.4, 0.1, -0.2, -0.9, -3.0];
        let found = formula(&exponents, 5).unwrap();
        for (i, slope) in found.slopes.iter().enumerate() {
            let moved = |by: f64| {
                let mut moved = exponents;
                moved[i] += by;
                formula(&moved, 5).unwrap().value
            };
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!(
                (slope - difference).abs() < 1e-8,
                "{i}: {slope} {difference}"
            );
        }
    }

    #[test]
    fn what_exponents_share_is_no_doubt_about_a_known_sum() {
        // λ₁ fluctuates, and λ₂ = −1 − λ₁ with it: D = 1 + λ₁/(1 + λ₁), dD/dλ₁ = 1/(1 + λ₁)².
        let first: Vec<f64> = (0..64).map(|i| 0.5 + 0.1 * f64::from(i % 7 - 3)).collect();
        let second: Vec<f64> = first.iter().map(|a| -1.0 - a).collect();
        let exponents = [&first, &second].map(|s| s.iter().sum::<f64>() / 64.0);
        let found = kaplan_yorke(&[&first, &second], &exponents, 0.0, 2).unwrap();
        let exact = standard_error(&first) / (1.0 + exponents[0]).powi(2);
        assert!(
            (found.stderr / exact - 1.0).abs() < 1e-12,
            "{found:?} {exact}"
        );
    }

    /// An exponent of −∞, for example because a dry slider slips, adds no uncertainty.
    #[test]
    fn an_exponent_of_minus_infinity_leaves_no_doubt() {
        let first: Vec<f64> = (0..64).map(|i| 0.5 + 0.1 * f64::from(i % 7 - 3)).collect();
        let lost = [f64::NEG_INFINITY; 64];
        let exponents = [0.5, f64::NEG_INFINITY];
        let found = kaplan_yorke(&[&first, &lost], &exponents, 0.0, 2).unwrap();
        assert_eq!((found.value, found.stderr), (1.0, 0.0));
        let third = [-1.0; 64];
        let exponents = [0.5, -1.0, f64::NEG_INFINITY];
        let found = kaplan_yorke(&[&first, &third, &lost], &exponents, 0.0, 3).unwrap();
        assert_eq!(found.value, 1.5);
        assert!((found.stderr / standard_error(&first) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_torus_has_a_whole_dimension() {
        let series = [vec![-1e-5; 64], vec![-0.1; 64]];
        let exponents = [-1e-5, -0.1];
        let series: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        assert_eq!(
            kaplan_yorke(&series, &exponents, 0.0, 2).unwrap().value,
            0.0
        );
        assert_eq!(
            kaplan_yorke(&series, &exponents, 1e-4, 2).unwrap().value,
            1.0
        );
    }
}
