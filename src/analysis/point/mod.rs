//! All questions to one operating point, in one integration.
//!
//! 1. the transient is integrated and discarded; before it where motion starts in lasting
//!    contact, then at doubling counts of cycles, an attracting periodic orbit is sought by
//!    Newton's method, which ends the transient when it is found and seen to be approached;
//! 2. an orbit that was found is confirmed by its multipliers, measured over one period, and
//!    done;
//! 3. otherwise the energy balance is audited over a stretch, tangents and twin are aligned,
//!    their growth discarded;
//! 4. blocks of cycles are measured until the answers have settled or the budget is spent.
//!
//! After every block the strobe states are searched for a short period; a motion that repeats
//! is treated as in step 2. A chaotic one is done when its standard errors are small enough: those of
//! NVH statistics are looked at too where they have a stop rule, and gathering ends with the look that finds
//! them small enough.

mod instruments;
mod run;
mod settle;

use super::called_off::CalledOff;
use super::classify::{Evidence, classify, parts_exponentially};
use super::course::course;
use super::dimension::kaplan_yorke;
use super::lyapunov::GrowthAverages;
use super::norm::EnergyNorm;
use super::outcome::{Class, LyapunovMethod, LyapunovOutcome, PointOutcome, Status};
use super::questions::{GrowthNorm, LyapunovQuestion, Questions};
use super::recurrence::Recurrence;
use super::runaway::Bounds;
use super::twin::Twin;
use crate::model::{Model, TrajectoryState};
use crate::numerics::statistics::{FEWEST_BLOCKS, mean, standard_error};
use crate::propagate::{Counters, Kernel};
use instruments::Instruments;
use run::{Halt, PointRun};
use settle::{Repeating, Searches, WORTH_A_SEARCH};
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

/// Cycles between two looks at the answers.
const BLOCK: u64 = 50;

/// Answers all questions to one point.
///
/// # Errors
/// [`CalledOff`] when `called_off` was raised meanwhile.
pub fn investigate<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: TrajectoryState,
    questions: &Questions,
    called_off: &AtomicBool,
) -> Result<PointOutcome, CalledOff> {
    let mut trajectory = start;
    investigate_onward(model, kernel, &mut trajectory, questions, called_off)
}

/// As [`investigate`]; leaves `trajectory` where the integration ended, which is unspecified where
/// it diverged or ended in an event storm.
///
/// # Errors
/// As [`investigate`].
pub fn investigate_onward<K: Kernel>(
    model: &Model,
    kernel: &K,
    trajectory: &mut TrajectoryState,
    questions: &Questions,
    called_off: &AtomicBool,
) -> Result<PointOutcome, CalledOff> {
    let mut run = PointRun {
        model,
        kernel,
        questions,
        called_off,
        norm: EnergyNorm::new(model),
        growth_norm: match questions.lyapunov.map(|l| l.norm) {
            Some(GrowthNorm::Raw) => EnergyNorm::raw(model),
            _ => EnergyNorm::new(model),
        },
        trajectory: trajectory.clone(),
        workspace: kernel.workspace(),
        counters: Counters::default(),
        energy_residual: None,
    };
    let outcome = match run.run() {
        Ok(outcome) => Ok(outcome),
        Err(Halt::CalledOff) => Err(CalledOff),
        Err(Halt::Stop(stop)) => run.stopped(stop),
    };
    *trajectory = run.trajectory;
    outcome
}
impl<K: Kernel> PointRun<'_, K> {
    fn run(&mut self) -> Result<PointOutcome, Halt> {
        self.kernel.accepts(self.model, &self.trajectory)?;
        let mut searches = Searches::new(self.questions.settle);
        if let Some(found) = self.transient(&mut searches)?
            && let Some(outcome) = self.settle(found)?
        {
            return Ok(outcome);
        }
        self.audit(self.questions.audit_cycles)?;
        let mut instruments = self.align()?;
        let bounds = Bounds::new(self.model);
        while instruments.measured < self.questions.cycles {
            let block = BLOCK.min(self.questions.cycles - instruments.measured);
            self.measure(&mut instruments, block)?;
            let states = instruments.recurrence.states();
            if let Some(runaway) = bounds.left_by(self.model, states) {
                return Ok(self.unanswered(Status::Diverged, runaway.to_string()));
            }
            if let Some(period) = instruments.recurrence.period(&self.norm)
                && let Some(outcome) = self.settle(Repeating {
                    period,
                    how: "integrated to the end".into(),
                    turn: None,
                })?
            {
                return Ok(outcome);
            }
            instruments.look();
            if self.precise_enough(&instruments) {
                break;
            }
            if searches
                .as_mut()
                .is_some_and(|s| s.due(self.counters.cycles))
            {
                let candidates = self.candidates(&instruments);
                let before = self.counters.cycles;
                if let Some(found) = self.seek_orbit(&candidates)?
                    && let Some(outcome) = self.settle(found)?
                {
                    return Ok(outcome);
                }
                if self.counters.cycles > before {
                    // The trajectory was moved on: measure afresh.
                    instruments = self.align()?;
                }
            }
        }
        Ok(self.aperiodic(instruments))
    }

    /// Advances the transient; ends early on an attracting orbit.
    fn transient(&mut self, searches: &mut Option<Searches>) -> Result<Option<Repeating>, Halt> {
        if searches.is_none() {
            self.pass_transient()?;
            return Ok(None);
        }
        let mut recurrence = Recurrence::new(self.model);
        if let Some(period) = self.starts_locked(&recurrence)
            && let Some(orbit) = self.seek_orbit(&[period])?
        {
            return Ok(Some(orbit));
        }
        while self.counters.cycles < self.questions.transient {
            self.plain_cycle(&mut ())?;
            recurrence.push(&self.trajectory.state);
            if searches
                .as_mut()
                .is_some_and(|s| s.due(self.counters.cycles))
            {
                let candidates = recurrence.candidates(&self.norm, WORTH_A_SEARCH);
                let orbit = self.seek_orbit(&candidates)?;
                if orbit.is_some() {
                    return Ok(orbit);
                }
            }
        }
        Ok(None)
    }

    /// Whether everything that is asked of a motion that does not repeat is known well enough; never
    /// where nothing has a stop rule.
    fn precise_enough(&self, instruments: &Instruments) -> bool {
        match (&self.questions.lyapunov, instruments.enough()) {
            (Some(asked), nvh) => nvh.unwrap_or(true) && self.exponent_known(asked, instruments),
            (None, nvh) => nvh.unwrap_or(false),
        }
    }

    /// Whether the largest exponent is known well enough; never where it has no stop rule.
    fn exponent_known(&self, asked: &LyapunovQuestion, instruments: &Instruments) -> bool {
        let Some(target) = asked.stop_at_stderr else {
            return false;
        };
        let Some(growth) = instruments.averages() else {
            return false;
        };
        let averages = growth.values();
        if averages.len() < 4 * FEWEST_BLOCKS {
            return false;
        }
        let error = standard_error(averages);
        error <= target
            && mean(averages) > 5.0 * error
            && parts_exponentially(averages, growth.stretch())
    }

    /// The slowest mode that turns at all, counted from 1, and the mesh cycles of one of its
    /// turns, where these are more than so many.
    fn slow_mode(&self, cycles: u64) -> Option<(usize, f64)> {
        let turn = |mode: usize| {
            let frequency = self.model.blocks[mode].natural_frequency();
            TAU / (frequency * self.model.period())
        };
        (0..self.model.modes())
            .map(|mode| (mode + 1, turn(mode)))
            .filter(|(_, turn)| turn.is_finite() && *turn > cycles as f64)
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The outcome of a motion that did not repeat.
    fn aperiodic(&mut self, mut instruments: Instruments) -> PointOutcome {
        let growth = instruments.averages();
        let events = self.counters.events - instruments.events_before;
        let evidence = Evidence {
            averages: growth.map_or(&[], GrowthAverages::values),
            stretch: growth.map_or(1, GrowthAverages::stretch),
            aligned: self.questions.lyapunov.map_or(0, |l| l.align),
            closest_return: instruments.recurrence.closest_return(&self.norm),
            longest_period: instruments.recurrence.longest(),
            excitation_repeats: instruments.recurrence.excitation_repeats(),
            events,
            touched_throughout: events == 0 && self.trajectory.contact.touching(),
            target: self.questions.lyapunov.and_then(|l| l.stop_at_stderr),
            integrated: self.counters.cycles,
            measured: instruments.measured,
            slow_mode: self.slow_mode(instruments.measured),
        };
        let mut verdict = classify(&evidence);
        if verdict.status == Status::Ok
            && let Some((target, loosest)) = instruments.missed()
        {
            verdict.status = Status::NotConverged;
            verdict.reason += &format!(
                "; {loosest}, but analyses.nvh.stop_at_stderr is {target}; raise run.cycles"
            );
        }
        let twin = instruments.twin.as_ref();
        let lyapunov = instruments.growth.as_ref().and_then(|growth| {
            let exponents = growth.exponents()?;
            let series = growth.series();
            let errors: Vec<f64> = series.iter().map(|s| standard_error(s)).collect();
            // On a torus exponents are 0 as well as their averages tell.
            let torus = verdict.class == Some(Class::QuasiPeriodic);
            let zero = match torus {
                true => 2.0 * errors[0] + 5.0 / instruments.measured as f64,
                false => 0.0,
            };
            let dimension = self.growth_norm.dimension();
            let filled = kaplan_yorke(&series, &exponents, zero, dimension);
            Some(LyapunovOutcome {
                exponents,
                errors,
                dimension: filled,
                twin: twin.map(|t| mean(t.averages())),
                twin_stderr: twin.map(|t| standard_error(t.averages())),
                twin_agrees: twin.and_then(Twin::agrees),
                method: LyapunovMethod::Tangent,
                course: (self.questions.lyapunov)
                    .and_then(|asked| course(&series, growth.averages().stretch(), asked.course)),
            })
        });
        self.outcome(
            verdict.status,
            verdict.reason,
            verdict.class,
            lyapunov,
            &mut instruments,
        )
    }
}
