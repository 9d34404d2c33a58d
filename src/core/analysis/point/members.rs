//! How do the trajectories of a motion that does not settle start, and how do they leave the motion?
//!
//! A pilot is measured first. The other trajectories branch off it some cycles apart, with a small
//! displacement and with its tangents. They separate from it before they are measured. A trajectory leaves
//! the motion when it repeats or is found to be on a torus. Its cycles belong to the motion only up to the
//! time at which the growth of neighbours faded.

use super::instruments::{Instruments, Record};
use super::plan::{DISPLACEMENT, Plan};
use super::recorders::Recorders;
use super::run::{Interruption, PointRun};
use super::settle::{OrbitSearchTimes, PeriodicMotion, WORTH_A_SEARCH};
use crate::analysis::classify::parts_exponentially;
use crate::analysis::lyapunov::{TangentGrowth, displaced};
use crate::analysis::outcome::PointOutcome;
use crate::analysis::torus::{self, Torus, torus};
use crate::model::TrajectoryState;
use crate::numerics::statistics::{mean, standard_error};
use crate::propagate::Kernel;

/// Cycles between two checks whether a trajectory left the motion.
const BLOCK: u64 = 50;

/// Cycles per average of the growth of neighbours, to detect that it faded.
const CHUNK: u64 = 100;

/// Average growth of neighbours \[1/cycle\] up to which this growth counts as faded.
const FADED: f64 = 3e-3;

/// Number of cycles from the start of faded growth to the first search for an orbit.
const FADED_SEARCH: u64 = 300;

/// Number of standard errors by which the exponent of chaos must exceed zero.
const SIGMAS: f64 = 3.0;

/// How a trajectory left the motion.
pub(super) enum Ending {
    /// On an orbit, with its results.
    Settled(Box<PointOutcome>),
    /// On a torus.
    Torus(Torus),
}

/// The record of a trajectory up to the time at which the growth of neighbours faded, and the next search for
/// an orbit.
struct FadedGrowth {
    /// The record before the growth faded, without the last cycles, in which the motion changed.
    record: Record,
    /// Measured cycles of this record.
    cycles: u64,
    /// Measured cycles at the next search for an orbit.
    next_search: u64,
}

/// A state of the pilot from which another trajectory branches off.
struct BranchStart {
    /// Measured cycles of the pilot.
    cycle: u64,
    trajectory: TrajectoryState,
    growth: Option<TangentGrowth>,
}

/// One trajectory of the ensemble.
pub(super) struct EnsembleTrajectory {
    pub(super) trajectory: TrajectoryState,
    pub(super) instruments: Instruments,
    pub(super) ending: Option<Ending>,
    faded: Option<FadedGrowth>,
    /// Measured cycles and events at the ends of the last two stretches of [`CHUNK`] cycles.
    chunk_ends: [[u64; 2]; 2],
    /// Searches for an orbit at doubling counts of cycles, for the pilot only.
    searches: Option<OrbitSearchTimes>,
    next_torus: u64,
    branches: Vec<BranchStart>,
    /// Maximum number of branches.
    most_branches: usize,
}

impl EnsembleTrajectory {
    fn new(trajectory: TrajectoryState, instruments: Instruments) -> Self {
        Self {
            trajectory,
            instruments,
            ending: None,
            faded: None,
            chunk_ends: [[0; 2]; 2],
            searches: None,
            next_torus: torus::SHORTEST,
            branches: Vec::new(),
            most_branches: 0,
        }
    }

    /// The first trajectory of a point.
    pub(super) fn pilot(
        trajectory: TrajectoryState,
        instruments: Instruments,
        searches: Option<OrbitSearchTimes>,
        plan: &Plan,
    ) -> Self {
        Self {
            searches,
            most_branches: plan.trajectories - 1,
            ..Self::new(trajectory, instruments)
        }
    }

    /// Measured cycles.
    pub(super) fn measured(&self) -> u64 {
        self.instruments.record.measured
    }

    /// The record before the trajectory left the motion; all of it if it did not leave.
    pub(super) fn unsettled(&self) -> &Record {
        match (&self.ending, &self.faded) {
            (Some(_), Some(faded)) => &faded.record,
            _ => &self.instruments.record,
        }
    }

    /// Cycles measured before the trajectory left the motion.
    pub(super) fn unsettled_cycles(&self) -> u64 {
        match (&self.ending, &self.faded) {
            (Some(_), Some(faded)) => faded.cycles,
            _ => self.measured(),
        }
    }

    /// Whether neighbours separate exponentially. Without exponents, whether the trajectory has not left the
    /// motion.
    pub(super) fn is_chaotic(&self) -> bool {
        match self.unsettled().averages() {
            Some(averages) => is_chaotic(averages.values(), averages.stretch()),
            None => self.ending.is_none(),
        }
    }

    /// Updates the record of faded growth after every stretch of [`CHUNK`] cycles.
    fn note_growth(&mut self) {
        let record = &self.instruments.record;
        let Some(averages) = record.averages() else {
            return;
        };
        let (values, stretch) = (averages.values(), u64::from(averages.stretch()));
        let count = (CHUNK / stretch) as usize;
        if !record.measured.is_multiple_of(CHUNK) || count == 0 {
            return;
        }
        if mean(&values[values.len() - count..]) > FADED {
            self.faded = None;
        } else if self.faded.is_none() {
            let [cycles, events] = self.chunk_ends[0];
            let mut unsettled = record.clone();
            unsettled.cut(cycles, events);
            self.faded = Some(FadedGrowth {
                record: unsettled,
                cycles,
                next_search: record.measured - CHUNK + FADED_SEARCH,
            });
        }
        self.chunk_ends = [self.chunk_ends[1], [record.measured, record.events]];
    }

    /// Keeps the latest states from which others may branch off.
    fn note_branch(&mut self, gap: u64) {
        let record = &self.instruments.record;
        if self.most_branches == 0 || !record.measured.is_multiple_of(gap) {
            return;
        }
        if self.branches.len() == self.most_branches {
            self.branches.remove(0);
        }
        let growth = record.growth.clone().map(|mut growth| {
            growth.restart();
            growth
        });
        self.branches.push(BranchStart {
            cycle: record.measured,
            trajectory: self.trajectory.clone(),
            growth,
        });
    }

    /// Whether a search for an orbit is due after `cycles` of the whole simulation.
    fn search_is_due(&mut self, cycles: u64) -> bool {
        let measured = self.measured();
        let faded = (self.faded.as_mut()).is_some_and(|faded| {
            let due = measured >= faded.next_search;
            if due {
                faded.next_search = faded.cycles + 2 * (measured - faded.cycles);
            }
            due
        });
        (self.searches.as_mut()).is_some_and(|searches| searches.due(cycles)) || faded
    }

    /// Whether a search for a torus is due.
    fn torus_is_due(&mut self) -> bool {
        let due = self.measured() >= self.next_torus;
        if due {
            self.next_torus *= 2;
        }
        due
    }
}

/// Whether averages of growth over stretches of cycles are those of chaos.
pub(super) fn is_chaotic(averages: &[f64], stretch: u32) -> bool {
    mean(averages) > SIGMAS * standard_error(averages) && parts_exponentially(averages, stretch)
}

impl<K: Kernel> PointRun<'_, K> {
    /// Measures a trajectory until it has `until` cycles or leaves the motion.
    pub(super) fn follow(
        &mut self,
        member: &mut EnsembleTrajectory,
        until: u64,
        plan: &Plan,
    ) -> Result<(), Interruption> {
        while member.ending.is_none() && member.measured() < until {
            let block = BLOCK.min(until - member.measured());
            std::mem::swap(&mut self.trajectory, &mut member.trajectory);
            let measured = self.measure(&mut member.instruments, block);
            std::mem::swap(&mut self.trajectory, &mut member.trajectory);
            measured?;
            let states = member.instruments.recurrence.states();
            if let Some(runaway) = self.bounds.runaway_in(self.model, states) {
                return Err(Interruption::Runaway(runaway));
            }
            member.note_growth();
            member.note_branch(plan.gap);
            self.leaves(member)?;
        }
        Ok(())
    }

    /// Ends a trajectory if it left the motion.
    fn leaves(&mut self, member: &mut EnsembleTrajectory) -> Result<(), Interruption> {
        if let Some(period) = member.instruments.recurrence.period(&self.norm) {
            let motion = PeriodicMotion {
                period,
                how: "integrated to the end".into(),
                turn: None,
            };
            return self.settles(member, |_| Ok(Some(motion)));
        }
        let torus_is_due = member.torus_is_due();
        let search_is_due = member.search_is_due(self.counters.cycles);
        if self.config.settle && (search_is_due || torus_is_due) {
            let recurrence = &member.instruments.recurrence;
            let candidates = recurrence.candidates(&self.norm, WORTH_A_SEARCH);
            self.settles(member, |run| run.seek_orbit(&candidates))?;
        }
        let series = &member.instruments.series;
        if torus_is_due
            && member.ending.is_none()
            && self.config.lyapunov.is_some()
            && series.is_whole(member.measured())
            && torus::is_possible(self.model, &self.norm)
        {
            member.ending = torus(&series.growth, &series.strobe).map(Ending::Torus);
        }
        Ok(())
    }

    /// Ends a trajectory if `find` finds an orbit near it and this orbit attracts it. Otherwise the trajectory stays
    /// unchanged.
    fn settles(
        &mut self,
        member: &mut EnsembleTrajectory,
        find: impl FnOnce(&mut Self) -> Result<Option<PeriodicMotion>, Interruption>,
    ) -> Result<(), Interruption> {
        self.trajectory = member.trajectory.clone();
        if let Some(found) = find(self)?
            && let Some(outcome) = self.settle(found)?
        {
            member.trajectory = self.trajectory.clone();
            member.ending = Some(Ending::Settled(Box::new(outcome)));
        }
        Ok(())
    }

    /// Starts other trajectories at states of the pilot on the motion, and lets them separate from it.
    pub(super) fn branch_off(
        &mut self,
        pilot: &EnsembleTrajectory,
        plan: &Plan,
    ) -> Result<Vec<EnsembleTrajectory>, Interruption> {
        let places: Vec<&BranchStart> = (pilot.branches.iter())
            .filter(|branch| branch.cycle <= pilot.unsettled_cycles())
            .collect();
        let mut members = Vec::new();
        if places.is_empty() {
            return Ok(members);
        }
        for number in 1..plan.trajectories {
            let place = places[(number - 1) % places.len()];
            let mut stream = self.config.point.stream(number as u64);
            let trajectory = displaced(
                self.model,
                &self.norm,
                &place.trajectory,
                DISPLACEMENT,
                &mut stream,
            );
            let nvh = pilot.instruments.record.watch.nvh.as_ref();
            let watch = Recorders::for_branch(self.model, self.config, nvh);
            let growth = place.growth.clone();
            let mut instruments = Instruments::of(self.model, growth, None, watch);
            self.trajectory = trajectory;
            for _ in 0..plan.part {
                self.cycle(&mut instruments.record.growth, None, &mut ())?;
            }
            instruments.restart();
            members.push(EnsembleTrajectory::new(
                self.trajectory.clone(),
                instruments,
            ));
        }
        Ok(members)
    }
}
