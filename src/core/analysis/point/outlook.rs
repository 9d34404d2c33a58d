//! The number of cycles that will be measured of a motion that did not settle in its first cycles.
//!
//! Looks at the error bars follow at known cycles. The errors over the first cycles show which look can meet
//! the requested errors. They do not show whether the statistics are skewed, which doubles the cycles. If
//! neighbours do not separate yet, they do not show whether the motion will settle soon. The spread covers
//! both cases.

use super::looks::{SIGMAS, SKEWED};
use super::plan::Plan;
use crate::analysis::config::{Effort, PointConfig};
use crate::analysis::outcome::PointOutcome;

/// Expected cycles, and their standard deviation, of a motion whose neighbours do not separate over the first
/// cycles. Both are relative to the cycles at the first look. Such a motion may have an orbit that is found
/// soon, or may become chaotic late. The values are estimates from the 16 points of `manifests/flex80.toml`
/// that take more than 1000 cycles and are not chaotic. These points give 0.61 and 1.04.
const UNDECIDED: [f64; 2] = [0.7, 1.0];

/// Number of standard errors by which the exponent exceeds zero if neighbours separate.
const SEPARATING_SIGMAS: f64 = 3.0;

/// Measured mesh cycles that a point is expected to take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedCycles {
    /// Expected value.
    pub expected: f64,
    /// Standard deviation.
    pub spread: f64,
}

impl ExpectedCycles {
    /// The expected cycles of a motion that did not settle over its first cycles. `outcome` has the results
    /// over these.
    pub fn of(config: &PointConfig, outcome: &PointOutcome) -> Self {
        let plan = Plan::of(config);
        let (first, budget) = (plan.first as f64, plan.budget as f64);
        let lyapunov = config.lyapunov;
        let statistics = config.nvh.and_then(|config| config.stop_at_stderr);
        let target = lyapunov.and_then(|config| config.stop_at_stderr);
        let ends_early = match lyapunov {
            Some(_) => target.is_some(),
            None => statistics.is_some(),
        };
        if !ends_early || budget <= first {
            return Self {
                expected: budget,
                spread: 0.0,
            };
        }
        let exponent = outcome
            .lyapunov
            .as_ref()
            .filter(|lyapunov| lyapunov.stderr().is_finite());
        let certain_exponent = exponent
            .filter(|lyapunov| lyapunov.exponents[0] > SEPARATING_SIGMAS * lyapunov.stderr());
        let (Some(lyapunov), Some(target)) = (certain_exponent, target) else {
            let [expected, spread] = UNDECIDED.map(|part| part * first);
            return Self { expected, spread };
        };
        let (lambda, error) = (lyapunov.exponents[0], lyapunov.stderr());
        let ratio = (error / target).max(SIGMAS * error / lambda);
        let required_cycles = outcome.measured_cycles as f64 * ratio * ratio;
        // If the required cycles exceed the budget, the first look ends the point.
        let looks = (required_cycles / first).log2().ceil().max(0.0);
        let enough = if required_cycles <= budget {
            (first * looks.exp2()).min(budget)
        } else {
            first
        };
        let skew = match config.effort() {
            Effort::Verified => enough.max(SKEWED as f64).min(budget),
            Effort::Survey => (2.0 * enough).min(budget),
        };
        Self {
            expected: 0.5 * (enough + skew),
            spread: 0.5 * (skew - enough),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::config::LyapunovConfig;
    use crate::analysis::outcome::{LyapunovMethod, LyapunovOutcome, Status};
    use crate::analysis::poincare::Section;
    use crate::numerics::random::PointSeed;

    /// Expected cycles and their spread after 400 cycles, for an exponent λ = 0.2 with an error. `target` is
    /// its stop rule.
    fn outlook(effort: Effort, target: Option<f64>, error: f64, cycles: u64) -> [f64; 2] {
        let config = PointConfig {
            point: PointSeed {
                seed: 1,
                point_id: 0,
            },
            transient: 500,
            cycles,
            settle: true,
            audit_cycles: 0,
            lyapunov: Some(LyapunovConfig {
                stop_at_stderr: target,
                effort,
                ..LyapunovConfig::default()
            }),
            poincare_samples: 0,
            section: Section::default(),
            nvh: None,
        };
        let outcome = PointOutcome {
            lyapunov: Some(LyapunovOutcome {
                exponents: vec![0.2],
                errors: vec![error],
                dimension: None,
                twin: None,
                twin_stderr: None,
                twin_agrees: None,
                method: LyapunovMethod::Tangent,
                convergence: None,
            }),
            measured_cycles: 400,
            ..PointOutcome::without_results(Status::NotConverged, String::new())
        };
        let found = ExpectedCycles::of(&config, &outcome);
        [found.expected, found.spread]
    }

    /// Looks follow after 40 000, 80 000, 160 000 cycles with verified errors, and after 2000, 4000, … in a
    /// survey. The error falls with the root of the cycles.
    #[test]
    fn looks_tell_how_many_cycles_come() {
        let verified = |target, error, cycles| outlook(Effort::Verified, target, error, cycles);
        // 400 (0.05 / 0.01)^2 = 10 000 cycles: the first look may suffice, or the second if the
        // statistics are skewed.
        assert_eq!(verified(Some(0.01), 0.05, 160_000), [60_000.0, 20_000.0]);
        // 400 (0.06 / 0.01)^2 = 14 400 cycles: the same.
        assert_eq!(verified(Some(0.01), 0.06, 160_000), [60_000.0, 20_000.0]);
        // Within three errors of zero: no separation.
        assert_eq!(verified(Some(0.01), 0.12, 160_000), [28_000.0, 40_000.0]);
        // 400 (0.05 / 0.004)^2 = 62 500 cycles: the second look for certain.
        assert_eq!(verified(Some(0.004), 0.05, 160_000), [80_000.0, 0.0]);
        // Beyond the budget, the first look is futile and ends the point.
        assert_eq!(verified(Some(0.001), 0.05, 160_000), [60_000.0, 20_000.0]);
        // Without a rule, or if the budget ends before the first look, all cycles.
        assert_eq!(verified(None, 0.05, 160_000), [160_000.0, 0.0]);
        assert_eq!(verified(Some(0.01), 0.05, 10_000), [10_000.0, 0.0]);
        let survey = outlook(Effort::Survey, Some(0.05), 0.05, 10_000);
        assert_eq!(survey, [3000.0, 1000.0]);
    }
}
