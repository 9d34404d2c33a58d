//! Are the results of a motion that does not settle precise enough, and if not, what is missing?
//!
//! The errors are evaluated at few looks, each after twice as many cycles as the one before. A look ends the
//! measurement if the requested errors are met and the record is long compared with its correlation time. In
//! a record of less than 90 % of [`SKEWED`] cycles, the distributions of the statistics must not be skewed. Skewness
//! indicates rare bursts to one side, which the record may not contain yet.

use super::instruments::Record;
use super::run::PointRun;
use crate::analysis::classify::{DIFFERENT_RHAT, parts_exponentially};
use crate::analysis::config::Effort;
use crate::numerics::chains::{ess, rhat};
use crate::numerics::statistics::{correlation_time, mean, skewness, standard_error};
use crate::propagate::Kernel;

/// Minimum length of a record, as a multiple of its correlation time.
const MEMORIES: f64 = 20.0;

/// Number of measured cycles after which skewed statistics are accepted. 90 % of them are enough, because cycles after
/// a trajectory left the motion also count against the budget.
pub(super) const SKEWED: u64 = 80_000;

/// Largest accepted skewness of means over [`SKEW_CYCLES`] cycles in records of less than 90 % of [`SKEWED`] cycles.
const SKEWNESS: f64 = 0.8;

/// Cycles per mean in the check of skewness.
const SKEW_CYCLES: u64 = 100;

/// Number of standard errors by which an exponent must exceed zero.
pub(super) const SIGMAS: f64 = 5.0;

/// Result of one evaluation of the records of all trajectories.
#[derive(Debug, Clone, Default)]
pub(super) struct LookResult {
    /// Why the error bars are not verified; `None` if they are.
    pub(super) unverified: Option<String>,
    /// Why the requested errors or life of chaos are not met, if they are not.
    pub(super) missed: Option<String>,
    /// Why NVH statistics do not meet their requested errors, if they do not.
    pub(super) statistics_missed: Option<String>,
    /// Whether NVH statistics have a stop rule and meet it, with verified error bars or in a survey.
    pub(super) statistics_enough: bool,
    /// Whether the requested errors need more cycles than the budget.
    pub(super) futile: bool,
    /// Whether there is a stop rule and all of its conditions are met.
    pub(super) can_stop: bool,
    /// Effective sample size of the growth of neighbours.
    pub(super) ess: Option<f64>,
    /// Split R-hat of the growth of neighbours.
    pub(super) rhat: Option<f64>,
    /// Correlation time of the growth of neighbours \[mesh cycles\].
    pub(super) memory: Option<f64>,
}

impl LookResult {
    /// R-hat, if it shows that trajectories do not share one motion.
    pub(super) fn apart(&self) -> Option<f64> {
        self.rhat.filter(|rhat| *rhat > DIFFERENT_RHAT)
    }
}

/// A statistic as a series of averages.
struct AveragedStatistic {
    name: &'static str,
    values: Vec<f64>,
    /// Cycles per average.
    stretch: u64,
}

impl AveragedStatistic {
    /// Correlation time of the statistic \[mesh cycles\].
    fn memory(&self) -> f64 {
        correlation_time(&self.values) * self.stretch as f64
    }

    /// Skewness of the means of the statistic over [`SKEW_CYCLES`] cycles.
    fn skewness(&self) -> f64 {
        let count = (SKEW_CYCLES / self.stretch).max(1) as usize;
        let means: Vec<f64> = self.values.chunks_exact(count).map(mean).collect();
        skewness(&means)
    }
}

impl<K: Kernel> PointRun<'_, K> {
    /// Evaluates the concatenated record `all` of all trajectories, and the record of each trajectory that is
    /// still on the motion. The number of trajectories that have left it is `exits`.
    pub(super) fn look(&self, all: &Record, staying: &[&Record], exits: usize) -> LookResult {
        let chains: Vec<&[f64]> = (staying.iter())
            .filter_map(|record| Some(record.averages()?.values()))
            .collect();
        let growth = all.averages().map(|averages| AveragedStatistic {
            name: "lambda_max",
            values: averages.values().to_vec(),
            stretch: u64::from(averages.stretch()),
        });
        let mut look = LookResult {
            ess: ess(&chains),
            rhat: if chains.len() > 1 { rhat(&chains) } else { None },
            memory: growth.as_ref().map(AveragedStatistic::memory),
            ..LookResult::default()
        };
        look.unverified = self.unverified(all, growth.as_ref());
        let statistics = self.statistics(all);
        look.statistics_missed = statistics
            .as_ref()
            .and_then(|criterion| criterion.missed.clone());
        let verified = look.unverified.is_none() || self.config.effort() == Effort::Survey;
        look.statistics_enough =
            statistics.is_some() && look.statistics_missed.is_none() && verified;
        let criteria = [
            growth
                .as_ref()
                .and_then(|growth| self.exponent(all, growth)),
            self.life(all, exits),
            statistics,
        ];
        look.futile = criteria.iter().flatten().any(|criterion| criterion.futile);
        look.missed = criteria
            .iter()
            .flatten()
            .find_map(|criterion| criterion.missed.clone());
        let lyapunov = self.config.lyapunov;
        let exponent_has_rule = lyapunov.is_none_or(|config| config.stop_at_stderr.is_some());
        let has_rule = criteria.iter().flatten().count() > 0 && exponent_has_rule;
        look.can_stop = has_rule && verified && look.missed.is_none() && look.apart().is_none();
        look
    }

    /// Why the errors of a record are not verified, if they are not.
    fn unverified(&self, all: &Record, growth: Option<&AveragedStatistic>) -> Option<String> {
        if self.config.effort() == Effort::Survey {
            return Some("errors of a survey are not verified".to_owned());
        }
        let first = Effort::Verified.first_look();
        // 90 % of the cycles are enough, because cycles after a trajectory left the motion also count against
        // the budget.
        if self.config.cycles < first || 10 * all.measured < 9 * first {
            return Some(format!(
                "{} of the {first} measured cycles that verified errors need; raise run.cycles, or set \
                 analyses.lyapunov.effort = \"survey\"",
                all.measured
            ));
        }
        let motion = statistics_of_motion(all);
        let longest = (motion.iter().chain(growth))
            .map(|statistic| (statistic.name, statistic.memory()))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((name, memory)) = longest
            && MEMORIES * memory > all.measured as f64
        {
            return Some(format!(
                "{name} is correlated over {memory:.0} cycles, and verified errors need {MEMORIES} times as many; raise run.cycles"
            ));
        }
        let most = (motion.iter())
            .map(|statistic| (statistic.name, statistic.skewness().abs()))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, skewness)| *skewness > SKEWNESS && 10 * all.measured < 9 * SKEWED);
        most.map(|(name, skewness)| {
            format!(
                "the means of {name} over {SKEW_CYCLES} cycles have a skewness of {skewness:.2}, so rare \
                 bursts may be missing; raise run.cycles to {SKEWED}"
            )
        })
    }

    /// Precision of the largest exponent, if it has a stop rule.
    fn exponent(&self, all: &Record, growth: &AveragedStatistic) -> Option<StopCriterion> {
        let target = self.config.lyapunov?.stop_at_stderr?;
        let (lambda, error) = (mean(&growth.values), standard_error(&growth.values));
        if !error.is_finite() {
            return Some(StopCriterion {
                missed: Some("lambda_max has no standard error yet; raise run.cycles".to_owned()),
                futile: false,
            });
        }
        let mut criterion = self.criterion(all, error / target, || {
            format!("the standard error of lambda_max is {error:.2e}, but analyses.lyapunov.stop_at_stderr is {target}")
        });
        if criterion.missed.is_none() && lambda <= SIGMAS * error {
            criterion = self.criterion(all, SIGMAS * error / lambda.max(0.0), || {
                format!("λ = {lambda:.2e} ± {error:.1e} is within {SIGMAS} standard errors of zero")
            });
        }
        if criterion.missed.is_none() && !parts_exponentially(&growth.values, growth.stretch as u32)
        {
            criterion.missed = Some(
                "the separation of neighbouring trajectories does not grow exponentially"
                    .to_owned(),
            );
        }
        Some(criterion)
    }

    /// Whether the record demonstrates the requested life of chaos, if one is requested.
    fn life(&self, all: &Record, exits: usize) -> Option<StopCriterion> {
        let lifetime = self.config.lyapunov?.lifetime?;
        let short = exits == 0 && all.measured < 3 * lifetime;
        Some(StopCriterion {
            missed: short.then(|| {
                format!(
                    "no trajectory left chaos in {} cycles, but evidence for a mean life of {lifetime} cycles needs {}",
                    all.measured,
                    3 * lifetime
                )
            }),
            futile: false,
        })
    }

    /// Precision of NVH statistics, if they have a stop rule.
    fn statistics(&self, all: &Record) -> Option<StopCriterion> {
        let target = self.config.nvh?.stop_at_stderr?;
        if all.watch.enough {
            return Some(StopCriterion::default());
        }
        let loosest = all.watch.loosest()?;
        Some(self.criterion(all, loosest.error / target, || {
            format!("{loosest}, but analyses.nvh.stop_at_stderr is {target}")
        }))
    }

    /// The stop criterion for an error that is `ratio` times the requested error.
    fn criterion(
        &self,
        all: &Record,
        ratio: f64,
        message: impl FnOnce() -> String,
    ) -> StopCriterion {
        if ratio <= 1.0 {
            return StopCriterion::default();
        }
        let needed = all.measured as f64 * ratio * ratio;
        let futile = needed.is_finite() && needed > self.config.cycles as f64;
        let how = if needed.is_finite() {
            format!("; this would take about {} cycles", rounded(needed))
        } else {
            String::new()
        };
        StopCriterion {
            missed: Some(message() + &how),
            futile,
        }
    }
}

/// A requested error or bound.
#[derive(Debug, Default)]
struct StopCriterion {
    /// Why the criterion is not met, if it is not.
    missed: Option<String>,
    /// Whether the criterion needs more cycles than the budget.
    futile: bool,
}

/// The statistics of motion whose correlation time and skewness are checked.
fn statistics_of_motion(all: &Record) -> Vec<AveragedStatistic> {
    let strobe = AveragedStatistic {
        name: "the squared strobe deflection",
        values: all.strobe.values().to_vec(),
        stretch: u64::from(all.strobe.stretch()),
    };
    let nvh = (all.watch.nvh.iter()).flat_map(|nvh| {
        let stretch = nvh.stretch();
        (nvh.statistics_for_stop_rule().into_iter()).map(move |(name, values)| AveragedStatistic {
            name,
            values,
            stretch,
        })
    });
    let mut statistics = vec![strobe];
    statistics.extend(nvh);
    statistics
}

/// A number of cycles, rounded up to two significant digits.
fn rounded(cycles: f64) -> u64 {
    let unit = 10f64.powf(cycles.max(1.0).log10().floor() - 1.0);
    ((cycles / unit).ceil() * unit) as u64
}
