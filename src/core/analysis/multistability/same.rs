//! Did two probes settle on the same attractor?
//!
//! Periodic motions are the same if their strobe states agree point by point in the energy norm, from any
//! state of the period on. Other motions are the same if class, largest exponent and averages over the strobe
//! samples agree within their standard errors. A coarse bound on RMS and events per cycle covers differences
//! between the strobes.

use crate::analysis::norm::EnergyNorm;
use crate::analysis::outcome::{Class, LyapunovMethod, PointOutcome};
use crate::model::{ActiveSet, Model, TrajectoryState};
use crate::numerics::statistics::{mean, standard_error};
use crate::propagate::{Counters, Kernel, Stop};

/// Distance \[half gaps\] below which two orbits are the same. It is far above the error of a settled orbit,
/// 1e-10 divided by its decay per cycle.
const SAME_ORBIT: f64 = 1e-4;

/// Decay of neighbours per cycle below which a motion counts as undamped.
const NEUTRAL: f64 = 1e-7;

/// Number of standard errors of their difference by which averages of one attractor may differ. With
/// thousands of comparisons per job, three would split attractors by chance.
const SIGMAS: f64 = 5.0;

/// Relative difference of averages that is always allowed. The block averages of nearly regular motion give
/// too small an error.
const SAME_AVERAGE: f64 = 1e-3;

/// Difference of exponents \[1/cycle\] that counts as zero whatever its error.
const NEAR_EXPONENT: f64 = 1e-3;

/// Largest relative difference of RMS and events per cycle, which have no error bar, on one attractor.
const COARSE: f64 = 0.25;

/// Properties that identify an attractor.
#[derive(Debug, Clone)]
pub(super) struct Attractor {
    class: Class,
    mark: Mark,
    /// The contacts that stay closed, for a motion that has no events and does not decay.
    continuum: Option<ActiveSet>,
}

#[derive(Debug, Clone)]
enum Mark {
    /// Start of an orbit, and its strobe states from there over one period.
    Orbit(TrajectoryState, Vec<Vec<f64>>),
    Statistics(Box<Statistics>),
}

#[derive(Debug, Clone)]
struct Statistics {
    /// Largest exponent.
    exponent: Average,
    /// Averages of δ/b, (δ/b)² and (δ'T/b)² at the strobe.
    strobe: [Average; 3],
    /// RMS of the deflection \[m\], and events per cycle.
    rms_and_event_rate: [f64; 2],
}

/// A mean and its standard error.
#[derive(Debug, Clone, Copy)]
struct Average {
    mean: f64,
    error: f64,
}

impl Average {
    fn of(series: &[f64]) -> Self {
        Self {
            mean: mean(series),
            error: standard_error(series),
        }
    }

    fn agrees(self, other: Self, near: f64) -> bool {
        let difference = (self.mean - other.mean).abs();
        difference <= SIGMAS * self.error.hypot(other.error) + near
    }

    fn agrees_relative(self, other: Self) -> bool {
        self.agrees(other, SAME_AVERAGE * self.mean.abs().max(other.mean.abs()))
    }
}

impl Attractor {
    /// The attractor of a probe that ended at `end`; `None` if it settled on none.
    ///
    /// # Errors
    /// [`Stop`] as for any integration: an orbit is integrated once more.
    pub fn of<K: Kernel>(
        model: &Model,
        kernel: &K,
        outcome: &PointOutcome,
        end: TrajectoryState,
    ) -> Result<Option<Self>, Stop> {
        let Some(class) = outcome.class.filter(|class| *class != Class::NotConverged) else {
            return Ok(None);
        };
        let lyapunov = outcome.lyapunov.as_ref();
        let largest = lyapunov.and_then(|l| l.exponents.first());
        let neutral = class == Class::QuasiPeriodic || largest.is_some_and(|l| *l > -NEUTRAL);
        let continuum = (neutral && outcome.events_per_cycle == Some(0.0)).then_some(end.contact);
        // A periodic motion that rests on a stop may have no finite exponent.
        let by_multipliers = lyapunov.is_none_or(|l| l.method == LyapunovMethod::Multipliers);
        if let Some(period) = class.period().filter(|_| by_multipliers) {
            let start = end.clone();
            let mark = Mark::Orbit(start, orbit(kernel, period, end)?);
            return Ok(Some(Self {
                class,
                mark,
                continuum,
            }));
        }
        let Some(lyapunov) = lyapunov else {
            return Ok(None);
        };
        let scale = 1.0 / model.half_gap;
        let series = |f: &dyn Fn(f64, f64) -> f64| {
            let samples = outcome.poincare.iter();
            let values: Vec<f64> = samples.map(|s| f(s.deflection, s.velocity)).collect();
            Average::of(&values)
        };
        let statistics = Statistics {
            exponent: Average {
                mean: lyapunov.exponents[0],
                error: lyapunov.stderr(),
            },
            strobe: [
                series(&|deflection, _| scale * deflection),
                series(&|deflection, _| (scale * deflection).powi(2)),
                series(&|_, velocity| (scale * model.period() * velocity).powi(2)),
            ],
            rms_and_event_rate: [
                outcome
                    .nvh
                    .as_ref()
                    .map_or(0.0, |nvh| nvh.values.deflection_rms),
                outcome.events_per_cycle.unwrap_or(0.0),
            ],
        };
        let mark = Mark::Statistics(Box::new(statistics));
        Ok(Some(Self {
            class,
            mark,
            continuum,
        }))
    }

    /// Kind of motion.
    pub fn class(&self) -> Class {
        self.class
    }

    /// Start of its orbit and its period in mesh cycles, if it repeats.
    pub fn orbit(&self) -> Option<(&TrajectoryState, u32)> {
        match &self.mark {
            Mark::Orbit(start, states) => Some((start, states.len() as u32)),
            Mark::Statistics(_) => None,
        }
    }

    /// Strobe states over one period; empty if it does not repeat.
    pub fn strobe(&self) -> &[Vec<f64>] {
        match &self.mark {
            Mark::Orbit(_, states) => states,
            Mark::Statistics(_) => &[],
        }
    }

    /// Whether two probes of one point settled on the same attractor. Undamped motions that stay in one
    /// contact state solve the same linear system. They form a continuum, which counts as one attractor.
    pub fn is_same(&self, other: &Self, norm: &EnergyNorm) -> bool {
        if let (Some(a), Some(b)) = (self.continuum, other.continuum) {
            return a == b;
        }
        self.class == other.class
            && match (&self.mark, &other.mark) {
                (Mark::Orbit(_, a), Mark::Orbit(_, b)) => same_orbit(norm, a, b),
                (Mark::Statistics(a), Mark::Statistics(b)) => same_statistics(a, b),
                _ => false,
            }
    }
}

/// Strobe states over one period from `end` on.
fn orbit<K: Kernel>(
    kernel: &K,
    period: u32,
    mut end: TrajectoryState,
) -> Result<Vec<Vec<f64>>, Stop> {
    let mut workspace = kernel.workspace();
    let mut states = Vec::new();
    for _ in 0..period {
        states.push(end.state.clone());
        kernel.advance(
            1,
            &mut end,
            &mut workspace,
            &mut (),
            &mut Counters::default(),
        )?;
    }
    Ok(states)
}

fn same_orbit(norm: &EnergyNorm, a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    let near = |x: &[f64], y: &[f64]| norm.distance(x, y) <= SAME_ORBIT * norm.unit();
    a.len() == b.len()
        && (0..b.len()).any(|shift| {
            let shifted = b[shift..].iter().chain(&b[..shift]);
            a.iter().zip(shifted).all(|(x, y)| near(x, y))
        })
}

fn same_statistics(a: &Statistics, b: &Statistics) -> bool {
    let rms_and_event_rate = a.rms_and_event_rate.iter().zip(&b.rms_and_event_rate);
    a.exponent.agrees(b.exponent, NEAR_EXPONENT)
        && (0..3).all(|i| a.strobe[i].agrees_relative(b.strobe[i]))
        && rms_and_event_rate.fold(true, |same, (x, y)| {
            same && (x - y).abs() <= COARSE * x.abs().max(y.abs())
        })
}

#[cfg(test)]
mod tests {
    use super::super::tests::model;
    use super::*;
    use crate::model::InitialState;

    fn statistics(change: impl Fn(&mut Statistics)) -> Attractor {
        let average = |mean, error| Average { mean, error };
        let mut statistics = Statistics {
            exponent: average(0.8, 0.01),
            strobe: [average(0.02, 0.01), average(1.5, 0.02), average(30.0, 0.5)],
            rms_and_event_rate: [1e-5, 2.5],
        };
        change(&mut statistics);
        Attractor {
            class: Class::Chaotic,
            mark: Mark::Statistics(Box::new(statistics)),
            continuum: None,
        }
    }

    #[test]
    fn averages_may_differ_by_their_errors_and_no_more() {
        let norm = EnergyNorm::new(&model());
        let same = |change: &dyn Fn(&mut Statistics)| {
            let (a, b) = (statistics(|_| {}), statistics(change));
            assert_eq!(a.is_same(&b, &norm), b.is_same(&a, &norm));
            a.is_same(&b, &norm)
        };
        // Both exponents have the same error, so the error of their difference is √2 times as large. Five
        // standard errors are then 7.07 errors of an exponent.
        assert!(same(&|s| s.exponent.mean += 0.06) && !same(&|s| s.exponent.mean += 0.08));
        // Mirror images have equal averages of even powers of δ, so only the mean of δ distinguishes them.
        assert!(!same(&|s| s.strobe[0].mean = -0.08));
        assert!(same(&|s| s.strobe[0].mean = -0.02));
        for i in 0..3 {
            let error = statistics(|_| {});
            let Mark::Statistics(error) = error.mark else {
                unreachable!()
            };
            let error = error.strobe[i].error;
            assert!(same(&|s| s.strobe[i].mean += 6.5 * error), "{i}");
            assert!(!same(&|s| s.strobe[i].mean += 8.0 * error), "{i}");
        }
        for i in 0..2 {
            assert!(
                same(&|s| s.rms_and_event_rate[i] *= 1.3)
                    && !same(&|s| s.rms_and_event_rate[i] *= 1.4)
            );
        }
        let mut other = statistics(|_| {});
        other.class = Class::QuasiPeriodic;
        assert!(!statistics(|_| {}).is_same(&other, &norm));
    }

    #[test]
    fn orbits_are_the_same_from_any_of_their_points() {
        let model = model();
        let norm = EnergyNorm::new(&model);
        let start = model.start(&InitialState::Static).state;
        let relative = (0..model.modes()).find(|i| !model.neutral.contains(i));
        let at = |place: f64| {
            let mut state = start.clone();
            state[relative.unwrap()] += place;
            state
        };
        let orbit = |places: &[f64]| Attractor {
            class: Class::Periodic(3),
            mark: Mark::Orbit(
                model.start(&InitialState::Static),
                places.iter().map(|place| at(*place)).collect(),
            ),
            continuum: None,
        };
        let first = orbit(&[0.0, 0.5, 2.0]);
        assert!(first.is_same(&orbit(&[0.5, 2.0, 0.0]), &norm));
        assert!(first.is_same(&orbit(&[2.0, 1e-6, 0.5]), &norm));
        assert!(!first.is_same(&orbit(&[2.0, 1e-2, 0.5]), &norm));
        // The same states in reversed order are another motion.
        assert!(!first.is_same(&orbit(&[2.0, 0.5, 0.0]), &norm));
        assert!(!first.is_same(&orbit(&[0.0, 0.5]), &norm));
        assert!(!first.is_same(&statistics(|_| {}), &norm));
    }
}
