//! What kind of motion is one that did not repeat?

use super::outcome::{Class, Status};
use crate::numerics::statistics::{mean, standard_error};

/// What is known of it.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    /// Averages of the largest exponent over successive stretches; empty when no exponent
    /// was asked for.
    pub averages: &'a [f64],
    /// Closest return of the strobe states, in units of the half gap.
    pub closest_return: Option<f64>,
    /// Longest period looked for, in mesh cycles.
    pub longest_period: usize,
    /// Whether the excitation repeats within it; if not, the motion cannot.
    pub excitation_repeats: bool,
    /// Whether contact was never left while measured.
    pub touched_throughout: bool,
    /// Standard error asked for.
    pub target: Option<f64>,
    /// Mesh cycles measured.
    pub measured: u64,
}

/// What follows from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// How the work ended.
    pub status: Status,
    /// Kind of motion, where it can be told.
    pub class: Option<Class>,
    /// Why.
    pub reason: String,
}

/// Standard errors by which a positive exponent must clear zero, and halves of a record may
/// differ.
const SIGMAS: f64 = 3.0;

/// |λ| per cycle below which a motion that does not repeat is quasi-periodic: a torus has
/// exponent 0, and a decay this slow would not settle in any budget.
const NEUTRAL: f64 = 1e-3;

/// Classes a motion that did not repeat within the budget.
pub fn classify(evidence: &Evidence<'_>) -> Verdict {
    let not_converged = |reason: String| Verdict {
        status: Status::NotConverged,
        class: Some(Class::NotConverged),
        reason,
    };
    if evidence.averages.is_empty() {
        return Verdict {
            status: Status::Ok,
            class: None,
            reason: "does not repeat; ask for analyses.lyapunov to class it".to_owned(),
        };
    }
    let (lambda, error) = (mean(evidence.averages), standard_error(evidence.averages));
    if error.is_infinite() {
        return not_converged(format!(
            "{} measured cycles are too few for an error bar; raise run.cycles",
            evidence.measured
        ));
    }
    let known = format!("λ = {lambda:.4} ± {error:.4} per cycle");
    if evidence.touched_throughout && !evidence.excitation_repeats && lambda < 0.0 {
        return Verdict {
            status: Status::Ok,
            class: Some(Class::Locked),
            reason: format!(
                "{known}; never leaves contact, driven by ripple without a period up to {}",
                evidence.longest_period
            ),
        };
    }
    if lambda > SIGMAS * error && lambda > NEUTRAL {
        let (early, late) = evidence.averages.split_at(evidence.averages.len() / 2);
        let spread = standard_error(early).hypot(standard_error(late));
        let drift = mean(late) - mean(early);
        if spread.is_finite() && drift.abs() > (SIGMAS + 1.0) * spread {
            return not_converged(format!(
                "{known}, but its two halves differ by {drift:.4}: the motion has not settled; raise run.transient or run.cycles"
            ));
        }
        let missed = evidence.target.filter(|target| error > *target);
        return Verdict {
            status: if missed.is_some() {
                Status::NotConverged
            } else {
                Status::Ok
            },
            class: Some(Class::Chaotic),
            reason: match missed {
                Some(target) => format!(
                    "{known}, positive beyond its error, but the error asked for is {target}; raise run.cycles"
                ),
                None => format!("{known}, positive beyond its error"),
            },
        };
    }
    if lambda.abs() <= (SIGMAS * error).clamp(NEUTRAL / 10.0, NEUTRAL) {
        return Verdict {
            status: Status::Ok,
            class: Some(Class::QuasiPeriodic),
            reason: format!(
                "{known}, zero within its error, and no period up to {}",
                evidence.longest_period
            ),
        };
    }
    let returns = evidence
        .closest_return
        .map(|d| format!(", closest return {d:.1e} half gaps"))
        .unwrap_or_default();
    not_converged(format!(
        "{known}{returns}: still settling after {} measured cycles; raise run.transient or run.cycles",
        evidence.measured
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(averages: &[f64], target: Option<f64>) -> Verdict {
        classify(&Evidence {
            averages,
            closest_return: Some(1e-3),
            longest_period: 32,
            excitation_repeats: true,
            touched_throughout: false,
            target,
            measured: 10 * averages.len() as u64,
        })
    }

    fn noisy(centre: f64, spread: f64) -> Vec<f64> {
        (0..512)
            .map(|i| centre + spread * (f64::from(i) * 2.399).sin())
            .collect()
    }

    #[test]
    fn positive_beyond_its_error_is_chaos() {
        let v = verdict(&noisy(0.8, 0.3), Some(0.05));
        assert_eq!((v.status, v.class), (Status::Ok, Some(Class::Chaotic)));
    }

    #[test]
    fn an_error_bar_that_missed_its_target_is_said_so() {
        let v = verdict(&noisy(0.8, 0.3), Some(1e-9));
        assert_eq!(v.class, Some(Class::Chaotic));
        assert_eq!(v.status, Status::NotConverged);
        assert!(v.reason.contains("raise run.cycles"));
    }

    #[test]
    fn a_drifting_exponent_is_not_settled() {
        let mut averages = noisy(0.8, 0.1);
        averages[256..].iter_mut().for_each(|a| *a -= 0.5);
        assert_eq!(verdict(&averages, None).class, Some(Class::NotConverged));
    }

    #[test]
    fn zero_is_quasi_periodic_and_negative_is_still_settling() {
        assert_eq!(
            verdict(&noisy(2e-5, 1e-4), None).class,
            Some(Class::QuasiPeriodic)
        );
        assert_eq!(
            verdict(&noisy(-0.01, 1e-4), None).class,
            Some(Class::NotConverged)
        );
    }

    #[test]
    fn contact_never_left_is_locked_unless_it_should_have_repeated() {
        let averages = noisy(-0.01, 1e-4);
        let class = |excitation_repeats| {
            classify(&Evidence {
                averages: &averages,
                closest_return: Some(1e-3),
                longest_period: 32,
                excitation_repeats,
                touched_throughout: true,
                target: None,
                measured: 5120,
            })
            .class
        };
        assert_eq!(class(false), Some(Class::Locked));
        assert_eq!(class(true), Some(Class::NotConverged));
    }

    #[test]
    fn without_exponents_there_is_no_class_and_short_records_say_so() {
        assert_eq!(verdict(&[], None).class, None);
        assert!(verdict(&[0.1; 5], None).reason.contains("too few"));
    }
}
