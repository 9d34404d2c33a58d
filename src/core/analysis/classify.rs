//! The class of a motion that did not repeat within the cycle budget.
//!
//! Neighbours are trajectories from nearby states. A motion is chaotic if its neighbours separate
//! exponentially to the end of the record. On a torus they separate in proportion to time. Their distance
//! after n cycles then gives an "exponent" ln n / n, which exceeds every error bar and falls with n. The
//! growth in the last part of the record distinguishes chaos from a torus. In chaos it is `λ n/4` per quarter
//! of the record. On a torus it is a few tenths of a nat, whatever the length of the record.

use super::outcome::{Class, Status};
use crate::numerics::statistics::{mean, standard_error};

/// The measurements from which a class follows.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    /// Averages of the largest exponent over successive stretches; empty if no exponent was requested.
    pub averages: &'a [f64],
    /// Mesh cycles per average.
    pub stretch: u32,
    /// Mesh cycles in which the tangents aligned before the first average.
    pub aligned: u64,
    /// Averages of the squared strobe deflection of one trajectory over successive stretches \[m²\].
    pub strobe: &'a [f64],
    /// Smallest distance of the last strobe state from one within `longest_period` before it, in half gaps.
    pub closest_return: Option<f64>,
    /// Longest period tried in the search for a repetition, in mesh cycles.
    pub longest_period: usize,
    /// Whether the excitation repeats within this period; otherwise the motion cannot repeat.
    pub excitation_repeats: bool,
    /// Changes of contact state during the measurement.
    pub events: u64,
    /// Whether contact lasted throughout the measurement.
    pub touched_throughout: bool,
    /// Whether the motion can be on a torus.
    pub torus_is_possible: bool,
    /// Split R-hat of the growth of neighbours, if there are several trajectories.
    pub rhat: Option<f64>,
    /// Mesh cycles integrated since the start, transient included.
    pub integrated: u64,
    /// Mesh cycles measured.
    pub measured: u64,
    /// The slowest mode, counted from 1, and its period in mesh cycles, if that exceeds the measurement.
    pub slow_mode: Option<(usize, f64)>,
}

/// The class of a motion with its reason.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// How the work ended.
    pub status: Status,
    /// Kind of motion, if known.
    pub class: Option<Class>,
    /// The reason for the class or for its absence.
    pub reason: String,
}

/// Number of standard errors by which a positive exponent must exceed zero. The halves of a record may differ
/// by one standard error more.
const SIGMAS: f64 = 3.0;

/// Largest |λ| per cycle that counts as zero, as on a torus. The bound is three standard errors, but at least a
/// tenth of this value and at most this value. A decay this slow does not settle in any budget.
const NEUTRAL: f64 = 1e-3;

/// Smallest steady growth, in nats over the whole record, of neighbours that separate exponentially. In 1500
/// integrable and linear motions the growth stayed below 3.5. Growth with the square of time gives 2.7.
const EXPONENTIAL: f64 = 5.0;

/// Largest late growth, in nats over the whole record, of neighbours that separate in proportion to time.
/// Such a separation gives `4 ln 7/5 = 1.35`. A turn of the tangent's direction can add as much.
const MOST_PROPORTIONAL_GROWTH: f64 = 2.8;

/// Late growth, in nats over the whole record, below which neighbours approach each other.
const DECAYING: f64 = -1.0;

/// Contraction of neighbours since the start, in nats, after which the motion depends only on the excitation.
const FORGETTING_CONTRACTION: f64 = 14.0;

/// Contraction, in nats, after which a decaying motion should repeat: from a distance of a half gap to the
/// return distance.
const REPEATING_CONTRACTION: f64 = 23.0;

/// R-hat above which trajectories count as different motions.
pub const DIFFERENT_RHAT: f64 = 1.2;

/// Growth of the squared deflection from the first to the last quarter of a record, if it grows in every quarter, above
/// which the motion has not settled. Linear growth of the deflection gives more than 30 from rest.
const SWELLING: f64 = 2.0;

/// Growth of a tangent from one quarter of a record to the next, in nats over the whole record. It is four
/// times the difference of the means of the logarithm of the tangent's length over both quarters.
///
/// Growth by a factor e^λ per cycle gives λ n in both fields. Growth with the power p of time gives at most
/// `4 p ln 5/3` and `4 p ln 7/5`, for any n. Means are used because the length also oscillates on a torus. If
/// long free flights alternate with a stiff mesh, it oscillates by a factor of a hundred.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Growth {
    /// From the mean over the second quarter to the mean over the third.
    before: f64,
    /// From the mean over the third quarter to the mean over the last.
    late: f64,
}

impl Growth {
    /// `None` if the record is too short to have quarters.
    fn of(averages: &[f64], stretch: u32) -> Option<Self> {
        let quarter = (averages.len() + 1) / 4;
        if quarter == 0 {
            return None;
        }
        let mut logarithm = 0.0;
        let mut course = vec![logarithm];
        for average in averages {
            logarithm += average * f64::from(stretch);
            course.push(logarithm);
        }
        // Quarter 0 is the last one.
        let level = |back: usize| {
            let end = course.len() - back * quarter;
            mean(&course[end - quarter..end])
        };
        Some(Self {
            before: 4.0 * (level(1) - level(2)),
            late: 4.0 * (level(0) - level(1)),
        })
    }

    /// Persistent growth: the smaller of `before` and `late`.
    fn steady(self) -> f64 {
        self.before.min(self.late)
    }
}

/// Whether neighbours separate exponentially to the end of the record.
pub fn parts_exponentially(averages: &[f64], stretch: u32) -> bool {
    Growth::of(averages, stretch).is_some_and(|growth| growth.steady() >= EXPONENTIAL)
}

/// Determines the class of a motion that did not repeat within the budget.
pub fn classify(evidence: &Evidence<'_>) -> Verdict {
    if evidence.averages.is_empty() {
        return Verdict {
            status: Status::Ok,
            class: None,
            reason: "does not repeat; add analyses.lyapunov to determine its class".to_owned(),
        };
    }
    let (lambda, error) = (mean(evidence.averages), standard_error(evidence.averages));
    let growth = Growth::of(evidence.averages, evidence.stretch);
    let (true, Some(growth)) = (error.is_finite(), growth) else {
        return not_converged(format!(
            "{} measured cycles are too few for an error bar; raise run.cycles",
            evidence.measured
        ));
    };
    let found = Found {
        evidence,
        lambda,
        error,
        growth,
    };
    found.driven().unwrap_or_else(|| {
        let positive = lambda > SIGMAS * error && lambda > NEUTRAL;
        if evidence.events > 0 && positive && growth.steady() >= EXPONENTIAL {
            found.chaotic()
        } else if let Some(reason) = found.on_a_torus() {
            Verdict {
                status: Status::Ok,
                class: Some(Class::QuasiPeriodic),
                reason: reason + &found.slow_mode(),
            }
        } else {
            not_converged(found.undecided() + &found.slow_mode())
        }
    })
}

fn not_converged(reason: String) -> Verdict {
    Verdict {
        status: Status::NotConverged,
        class: Some(Class::NotConverged),
        reason,
    }
}

/// The measurements and the quantities derived from them.
struct Found<'a> {
    evidence: &'a Evidence<'a>,
    lambda: f64,
    error: f64,
    growth: Growth,
}

impl Found<'_> {
    fn known(&self) -> String {
        format!("λ = {:.4} ± {:.4} per cycle", self.lambda, self.error)
    }

    /// Whether neighbours approach each other. Either the exponent is below zero by more than its error bar,
    /// or both growths show a strong decay. The second case is needed because oscillating tangents of a
    /// linear motion widen the error bar.
    fn decays(&self) -> bool {
        self.lambda < -SIGMAS * self.error
            || self.growth.before.max(self.growth.late) <= -EXPONENTIAL
    }

    /// Contraction of neighbours since the start, in nats.
    fn contraction(&self) -> f64 {
        -self.lambda * self.evidence.integrated as f64
    }

    /// The verdict if the motion has forgotten its start and follows an excitation without a period.
    fn driven(&self) -> Option<Verdict> {
        let decays = self.decays() && self.contraction() >= FORGETTING_CONTRACTION;
        if self.evidence.excitation_repeats || !decays {
            return None;
        }
        let driven = format!(
            "torque ripple without a period up to {} cycles drives the motion, and the motion follows the phases of the ripple",
            self.evidence.longest_period
        );
        let known = self.known();
        Some(if self.evidence.touched_throughout {
            Verdict {
                status: Status::Ok,
                class: Some(Class::SteadyContact(None)),
                reason: format!("{known}; never leaves contact; {driven}"),
            }
        } else {
            Verdict {
                status: Status::Ok,
                class: Some(Class::QuasiPeriodic),
                reason: format!("{known}; {driven}: an attracting torus"),
            }
        })
    }

    /// The verdict on a motion with a positive exponent whose neighbours separate exponentially.
    fn chaotic(&self) -> Verdict {
        let known = self.known();
        if let Some(rhat) = self.evidence.rhat {
            if rhat > DIFFERENT_RHAT {
                return not_converged(format!(
                    "{known}, but the trajectories do not share one motion (R-hat {rhat:.2}); raise \
                     run.transient or run.cycles, or add analyses.multistability"
                ));
            }
        } else if let Some(drift) = self.drift() {
            return not_converged(format!(
                "{known}, but its two halves differ by {drift:.4}: the motion has not settled; raise run.transient or run.cycles"
            ));
        }
        Verdict {
            status: Status::Ok,
            class: Some(Class::Chaotic),
            reason: format!("{known}, positive beyond its error"),
        }
    }

    /// Difference between the two halves of a single record, if it exceeds their errors.
    fn drift(&self) -> Option<f64> {
        let averages = self.evidence.averages;
        let (early, late) = averages.split_at(averages.len() / 2);
        let spread = standard_error(early).hypot(standard_error(late));
        let drift = mean(late) - mean(early);
        (spread.is_finite() && drift.abs() > (SIGMAS + 1.0) * spread).then_some(drift)
    }

    /// Whether the deflection grows through the whole record, as that of an undamped mode at resonance.
    fn swells(&self) -> bool {
        let strobe = self.evidence.strobe;
        let quarters = strobe.chunks_exact((strobe.len() / 4).max(1)).map(mean);
        let levels: Vec<f64> = quarters.take(4).collect();
        levels.len() == 4 && levels.is_sorted_by(|a, b| a < b) && levels[3] > SWELLING * levels[0]
    }

    /// The reason if the motion is on a torus, else `None`.
    fn on_a_torus(&self) -> Option<String> {
        if !self.evidence.torus_is_possible {
            return None;
        }
        if self.swells() {
            return None;
        }
        let longest = self.evidence.longest_period;
        let known = self.known();
        let separates = self.evidence.events > 0 && self.growth.steady() >= EXPONENTIAL;
        if separates && self.lambda > 0.0 {
            return None;
        }
        if self.lambda.abs() <= (SIGMAS * self.error).clamp(NEUTRAL / 10.0, NEUTRAL) {
            return Some(format!(
                "{known}, zero within its error, and no period up to {longest}"
            ));
        }
        // The largest growth on a torus is growth with the square of time from the start of the alignment.
        // Without an alignment, the first direction may grow by any amount.
        let cycles = self.evidence.averages.len() as f64 * f64::from(self.evidence.stretch);
        let most = 1.0 + 2.0 * (cycles / self.evidence.aligned as f64).ln_1p();
        let proportional = self.evidence.aligned > 0
            && (0.0..=most).contains(&(self.lambda * cycles))
            && (DECAYING..=MOST_PROPORTIONAL_GROWTH).contains(&self.growth.late);
        proportional.then(|| {
            format!(
                "{known}, but neighbouring trajectories separate at most in proportion to time (by a factor {:.1} \
                 from the third to the last quarter of the record; an exponent of {:.4} would be detected), and no \
                 period up to {longest}",
                (0.25 * self.growth.late).exp(),
                EXPONENTIAL / cycles
            )
        })
    }

    /// Why the class is unknown, and the remedy.
    fn undecided(&self) -> String {
        let known = self.known();
        let Evidence { measured, .. } = *self.evidence;
        if self.swells() {
            return format!(
                "{known}, but the deflection grows through all {measured} measured cycles: an undamped mode at \
                 resonance, or a motion that has not settled; raise run.transient or add damping"
            );
        }
        if self.lambda > 0.0 {
            if self.evidence.events > 0 && self.growth.steady() >= EXPONENTIAL {
                let why = if self.lambda > SIGMAS * self.error {
                    format!("below {NEUTRAL} per cycle")
                } else {
                    format!("within {SIGMAS} standard errors of zero")
                };
                return format!(
                    "{known}: neighbouring trajectories separate, but the exponent is {why} over {measured} measured \
                     cycles"
                );
            }
            return match self.evidence.events {
                0 if self.growth.steady() >= EXPONENTIAL => format!(
                    "{known}, without an event in {measured} cycles: linear motion that is unstable and grows; raise run.transient until it leaves its contact state"
                ),
                _ => format!(
                    "{known}, which cannot be distinguished from growth in proportion to time over \
                     {measured} measured cycles; raise run.cycles"
                ),
            };
        }
        if !self.decays() {
            return format!("{known}, neither clearly zero nor clearly negative; raise run.cycles");
        }
        let returns = (self.evidence.closest_return)
            .map(|d| format!(", closest return {d:.1e} half gaps"))
            .unwrap_or_default();
        let left = REPEATING_CONTRACTION - self.contraction();
        if left > 0.0 {
            return format!(
                "{known}{returns}: still settling after {measured} measured cycles; raise run.transient by {:.0}",
                (left / -self.lambda).ceil()
            );
        }
        format!(
            "{known}{returns}: the motion has settled, but not on a period up to {} cycles; raise \
             run.cycles to twice the expected period",
            self.evidence.longest_period
        )
    }

    fn slow_mode(&self) -> String {
        (self.evidence.slow_mode)
            .map(|(mode, cycles)| {
                format!(
                    "; mode {mode} turns once in {cycles:.0} cycles and no repetition was seen (give it \
                     frequency 0 if it is a rigid rotation)"
                )
            })
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(averages: &[f64]) -> Evidence<'_> {
        Evidence {
            averages,
            stretch: 10,
            aligned: 100,
            strobe: &[],
            closest_return: Some(1e-3),
            longest_period: 32,
            excitation_repeats: true,
            events: 1000,
            touched_throughout: false,
            torus_is_possible: true,
            rhat: None,
            integrated: 10 * averages.len() as u64 + 300,
            measured: 10 * averages.len() as u64,
            slow_mode: None,
        }
    }

    fn verdict(averages: &[f64]) -> Verdict {
        classify(&evidence(averages))
    }

    fn noisy(centre: f64, spread: f64) -> Vec<f64> {
        (0..512)
            .map(|i| centre + spread * (f64::from(i) * 2.399).sin())
            .collect()
    }

    /// Averages of the growth of a tangent over stretches of ten cycles. `length(n)` is its length n cycles
    /// after the start of its alignment, which takes a hundred cycles.
    fn growing(cycles: usize, length: impl Fn(f64) -> f64) -> Vec<f64> {
        let logarithm = |stretch: usize| length(100.0 + 10.0 * stretch as f64).ln();
        (0..cycles / 10)
            .map(|stretch| (logarithm(stretch + 1) - logarithm(stretch)) / 10.0)
            .collect()
    }

    #[test]
    fn positive_beyond_its_error_is_chaos() {
        let v = verdict(&noisy(0.8, 0.3));
        assert_eq!((v.status, v.class), (Status::Ok, Some(Class::Chaotic)));
    }

    /// A tangent that grows in proportion to time has an "exponent" of 0.004 at 320 cycles and 0.001 at 4000,
    /// with a far smaller error bar.
    #[test]
    fn growth_in_proportion_to_time_is_a_torus_however_short_the_record() {
        for cycles in [320, 400, 800, 1500, 4000] {
            for shear in [1e-3, 1e-2, 0.1, 1.0, 100.0] {
                let averages = growing(cycles, |n| (1.0 + (shear * n).powi(2)).sqrt());
                let v = verdict(&averages);
                let expected = (Status::Ok, Some(Class::QuasiPeriodic));
                assert_eq!(
                    (v.status, v.class),
                    expected,
                    "{cycles} {shear}: {}",
                    v.reason
                );
            }
        }
    }

    #[test]
    fn growth_with_the_square_of_time_is_not_chaos_either() {
        for cycles in [320, 800, 4000] {
            let averages = growing(cycles, |n| n * n);
            assert_ne!(verdict(&averages).class, Some(Class::Chaotic));
        }
    }

    /// Weak chaos is found if the record is long enough, and gets no other class in shorter records.
    #[test]
    fn an_exponent_of_a_hundredth_is_found_at_the_default_budget() {
        for (cycles, class) in [
            (400, Class::NotConverged),
            (800, Class::Chaotic),
            (4000, Class::Chaotic),
        ] {
            let averages = growing(cycles, |n| (0.01 * n + 0.1 * (0.7 * n).sin()).exp());
            let v = verdict(&averages);
            assert_eq!(v.class, Some(class), "{cycles}: {}", v.reason);
        }
    }

    #[test]
    fn linear_motion_is_not_chaotic_whatever_grows() {
        let averages = noisy(0.8, 0.3);
        let v = classify(&Evidence {
            events: 0,
            ..evidence(&averages)
        });
        assert_eq!(v.class, Some(Class::NotConverged));
        assert!(v.reason.contains("linear"), "{}", v.reason);
    }

    #[test]
    fn trajectories_that_do_not_share_one_motion_have_no_verdict() {
        let averages = noisy(0.8, 0.3);
        for (rhat, class) in [(1.19, Class::Chaotic), (1.21, Class::NotConverged)] {
            let v = classify(&Evidence {
                rhat: Some(rhat),
                ..evidence(&averages)
            });
            assert_eq!(v.class, Some(class), "{}", v.reason);
        }
    }

    #[test]
    fn where_no_torus_can_be_none_is_found() {
        let averages = noisy(2e-5, 1e-4);
        let v = classify(&Evidence {
            torus_is_possible: false,
            ..evidence(&averages)
        });
        assert_eq!(v.class, Some(Class::NotConverged));
    }

    #[test]
    fn a_drifting_exponent_is_not_settled() {
        let mut averages = noisy(0.8, 0.1);
        averages[256..].iter_mut().for_each(|a| *a -= 0.5);
        assert_eq!(verdict(&averages).class, Some(Class::NotConverged));
    }

    #[test]
    fn zero_is_quasi_periodic_and_negative_repeats_sooner_or_later() {
        assert_eq!(
            verdict(&noisy(2e-5, 1e-4)).class,
            Some(Class::QuasiPeriodic)
        );
        for (lambda, message) in [(-2e-3, "raise run.transient by 6"), (-0.1, "has settled")] {
            let v = verdict(&noisy(lambda, 1e-4));
            assert_eq!(v.class, Some(Class::NotConverged));
            assert!(v.reason.contains(message), "{}", v.reason);
        }
    }

    /// Ripple without a period: a motion that has forgotten its start is in steady contact if it never leaves
    /// contact, and on a torus if it rattles. A motion that should have repeated is neither.
    #[test]
    fn a_motion_that_follows_ripple_without_a_period_has_a_verdict() {
        let averages = noisy(-0.01, 1e-4);
        let class = |excitation_repeats, touched_throughout| {
            classify(&Evidence {
                excitation_repeats,
                touched_throughout,
                ..evidence(&averages)
            })
            .class
        };
        assert_eq!(class(false, true), Some(Class::SteadyContact(None)));
        assert_eq!(class(false, false), Some(Class::QuasiPeriodic));
        assert_eq!(class(true, true), Some(Class::NotConverged));
    }

    #[test]
    fn without_exponents_there_is_no_class_and_short_records_say_so() {
        assert_eq!(verdict(&[]).class, None);
        assert!(verdict(&[0.1; 5]).reason.contains("too few"));
    }

    #[test]
    fn a_mode_that_hardly_turns_is_named() {
        let averages = noisy(2e-5, 1e-4);
        let v = classify(&Evidence {
            slow_mode: Some((1, 1e6)),
            ..evidence(&averages)
        });
        assert!(
            v.reason.contains("mode 1 turns once in 1000000"),
            "{}",
            v.reason
        );
    }

    /// An undamped mode at resonance has neutral neighbours and a growing deflection; a beat comes back.
    #[test]
    fn a_deflection_that_grows_is_on_no_torus() {
        let neutral = noisy(0.0, 1e-5);
        let class = |strobe: &[f64]| {
            classify(&Evidence {
                strobe,
                ..evidence(&neutral)
            })
        };
        let at = |f: &dyn Fn(f64) -> f64| (0..40).map(|n| f(f64::from(n))).collect::<Vec<_>>();
        let grows = class(&at(&|n| (n + 5.0).powi(2)));
        assert_eq!(grows.class, Some(Class::NotConverged), "{}", grows.reason);
        assert!(
            grows.reason.contains("grows through all"),
            "{}",
            grows.reason
        );
        for beat in [at(&|n| 2.0 + (0.4 * n).sin()), at(&|n| 1.0 + 0.01 * n)] {
            assert_eq!(class(&beat).class, Some(Class::QuasiPeriodic));
        }
    }
}
