//! Running estimates of the exponents during the measurement.

use super::outcome::ConvergenceOutcome;
use crate::numerics::statistics::{FEWEST_VALUES, mean, standard_error};

/// Running means and standard errors of each exponent over the first n cycles, for at most `places` values of
/// n. These values are evenly spaced, from the smallest one with an error bar to the whole record. `None` if
/// the record is too short for an error bar.
///
/// * `series`: averages of each exponent over successive stretches of `stretch` cycles.
pub fn convergence(series: &[&[f64]], stretch: u32, places: usize) -> Option<ConvergenceOutcome> {
    let all = series.first()?.len();
    let spans = all.checked_sub(FEWEST_VALUES)?;
    if places == 0 {
        return None;
    }
    // The last count is the whole record.
    let mut counts: Vec<usize> = (1..=places)
        .map(|place| FEWEST_VALUES + place * spans / places)
        .collect();
    counts.dedup();
    let over = |estimate: fn(&[f64]) -> f64| -> Vec<f64> {
        let of_one = |averages: &&[f64]| -> Vec<f64> {
            counts.iter().map(|n| estimate(&averages[..*n])).collect()
        };
        series.iter().flat_map(of_one).collect()
    };
    Some(ConvergenceOutcome {
        cycles: (counts.iter())
            .map(|n| (*n * stretch as usize) as f64)
            .collect(),
        exponents: over(mean),
        errors: over(standard_error),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_ends_with_the_estimate_itself() {
        let first: Vec<f64> = (0..100).map(|i| 0.5 + 0.1 * f64::from(i % 7)).collect();
        let second: Vec<f64> = first.iter().map(|a| -2.0 * a).collect();
        let found = convergence(&[&first, &second], 10, 4).unwrap();
        assert_eq!(found.cycles, [490.0, 660.0, 830.0, 1000.0]);
        assert_eq!(found.exponents.len(), 8);
        for (series, last) in [(&first, 3), (&second, 7)] {
            assert_eq!(found.exponents[last], mean(series));
            assert_eq!(found.errors[last], standard_error(series));
            assert_eq!(found.exponents[last - 3], mean(&series[..49]));
        }
    }

    #[test]
    fn a_short_record_has_as_many_places_as_stretches() {
        let series = vec![1.0; 34];
        let found = convergence(&[&series], 10, 50).unwrap();
        assert_eq!(found.cycles, [320.0, 330.0, 340.0]);
        assert!(convergence(&[&series[..31]], 10, 50).is_none());
        assert!(convergence(&[&series], 10, 0).is_none());
    }
}
