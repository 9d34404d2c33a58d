//! All analyses of one operating point, in one integration.
//!
//! 1. The transient is integrated and discarded. Newton's method searches for an attracting periodic orbit:
//!    at the start if the motion starts in lasting contact, then at doubling counts of cycles. An orbit that
//!    the trajectory approaches ends the transient.
//! 2. This orbit is confirmed by its multipliers and measured over one period. This completes the point.
//! 3. Otherwise the energy balance is audited over a stretch. Tangents and twin are aligned, and their growth
//!    is discarded.
//! 4. The trajectory is measured. If its neighbours separate exponentially, others branch off it. After every
//!    block of cycles each is checked for a period, and at doubling counts for an orbit and a torus. If one
//!    is found, the trajectory has left the motion.
//! 5. At few looks, each after twice as many cycles, the errors of all trajectories together are evaluated.
//!    The point ends when the errors are small enough or cannot become so, or when the budget is spent.
//!
//! If every trajectory left the motion, the point has the results of the motion on which most of them ended.

mod ensemble;
mod instruments;
mod looks;
mod members;
mod outlook;
mod plan;
mod recorders;
mod run;
mod settle;
mod steady;

pub use outlook::ExpectedCycles;

use super::config::{GrowthNorm, PointConfig};
use super::divergence::Bounds;
use super::interrupt::Interrupted;
use super::norm::EnergyNorm;
use super::outcome::{PointOutcome, Status};
use super::recurrence::Recurrence;
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel};
use run::{Interruption, PointRun};
use settle::{FIRST_SEARCH, OrbitSearchTimes, PeriodicMotion, WORTH_A_SEARCH};
use std::sync::atomic::AtomicBool;
use steady::Steady;

/// Runs all analyses of one point.
///
/// # Errors
/// [`Interrupted`] if `interrupt` was raised.
pub fn investigate<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: TrajectoryState,
    config: &PointConfig,
    interrupt: &AtomicBool,
) -> Result<PointOutcome, Interrupted> {
    let mut trajectory = start;
    investigate_onward(model, kernel, &mut trajectory, config, interrupt)
}

/// As [`investigate`]; leaves `trajectory` at the end of the integration, which is unspecified after
/// divergence or an event storm.
///
/// # Errors
/// As [`investigate`].
pub fn investigate_onward<K: Kernel>(
    model: &Model,
    kernel: &K,
    trajectory: &mut TrajectoryState,
    config: &PointConfig,
    interrupt: &AtomicBool,
) -> Result<PointOutcome, Interrupted> {
    let mut run = PointRun {
        model,
        kernel,
        config,
        interrupt,
        norm: EnergyNorm::new(model),
        growth_norm: match config.lyapunov.map(|l| l.norm) {
            Some(GrowthNorm::Raw) => EnergyNorm::raw(model),
            _ => EnergyNorm::new(model),
        },
        bounds: Bounds::new(model),
        trajectory: trajectory.clone(),
        workspace: kernel.workspace(),
        counters: Counters::default(),
        energy_residual: None,
    };
    let outcome = match run.run() {
        Ok(outcome) => Ok(outcome),
        Err(Interruption::Interrupted) => Err(Interrupted),
        Err(Interruption::Stop(stop)) => run.stopped(stop),
        Err(Interruption::Runaway(runaway)) => {
            Ok(run.without_results(Status::Diverged, runaway.to_string()))
        }
    };
    *trajectory = run.trajectory;
    outcome
}

impl<K: Kernel> PointRun<'_, K> {
    fn run(&mut self) -> Result<PointOutcome, Interruption> {
        self.kernel.accepts(self.model, &self.trajectory)?;
        let mut searches = OrbitSearchTimes::new(self.config.settle);
        if let Some(found) = self.transient(&mut searches)?
            && let Some(outcome) = self.settle(found)?
        {
            return Ok(outcome);
        }
        self.audit(self.config.audit_cycles)?;
        self.unsettled(searches)
    }

    /// Advances the transient. Returns early with an orbit that attracts the trajectory, otherwise `None` at the end.
    fn transient(
        &mut self,
        searches: &mut Option<OrbitSearchTimes>,
    ) -> Result<Option<PeriodicMotion>, Interruption> {
        if searches.is_none() {
            self.pass_transient()?;
            return Ok(None);
        }
        let mut recurrence = Recurrence::new(self.model);
        let mut steady = Steady::new(&recurrence);
        if let Some(steady) = &mut steady
            && self.stays_in_contact(steady.period())
        {
            let mut orbit = self.seek_steady(steady)?;
            if !steady.attracts() {
                orbit = self.seek_orbit(&[steady.period()])?;
            }
            if orbit.is_some() {
                return Ok(orbit);
            }
        }
        while self.counters.cycles < self.config.transient {
            let events = self.counters.events;
            self.plain_cycle(&mut ())?;
            recurrence.push(&self.trajectory.state);
            let recorded = self.trajectory.cycle;
            let without_event =
                self.counters.events == events && self.model.touches(self.trajectory.contact);
            if let Some(steady) = &mut steady
                && steady.is_due(without_event, self.trajectory.cycle)
                && self.stays_in_contact(steady.period())
                && let Some(orbit) = self.seek_steady(steady)?
            {
                return Ok(Some(orbit));
            }
            let orbit_expected =
                (steady.as_ref()).is_some_and(|s| s.stayed_in_contact() && s.attracts());
            let enough = FIRST_SEARCH.max(1 + u64::from(recurrence.excitation().unwrap_or(0)));
            let has_record =
                self.trajectory.cycle == recorded && recurrence.count() as u64 >= enough;
            let due =
                has_record && (searches.as_mut()).is_some_and(|s| s.due(self.counters.cycles));
            if due && !orbit_expected {
                let candidates = recurrence.candidates(&self.norm, WORTH_A_SEARCH);
                let orbit = self.seek_orbit(&candidates)?;
                if orbit.is_some() {
                    return Ok(orbit);
                }
            }
            // A failed search has advanced the trajectory without a record of the cycles. Lags across this gap would be
            // too short.
            if self.trajectory.cycle != recorded {
                recurrence = Recurrence::new(self.model);
            }
        }
        Ok(None)
    }
}
