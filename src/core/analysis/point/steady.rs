//! The search for the motion in steady contact.
//!
//! While no contact opens or closes, the map of a period of the excitation is affine, with the same matrix
//! for every state. If contact lasts over the period from its fixed point, this is the only steady motion of
//! the point. The fixed point is computed once, when a trajectory first stays in contact for a period, and
//! compared with later trajectories in contact.

use super::run::{Interruption, PointRun};
use super::settle::PeriodicMotion;
use crate::analysis::interrupt::Interrupted;
use crate::analysis::orbits::attracting::{Attracting, observe_approach};
use crate::analysis::orbits::shooting::{PeriodicOrbit, shoot_without_event};
use crate::analysis::recurrence::Recurrence;
use crate::propagate::{Counters, Kernel};

/// Longest period of an excitation, in mesh cycles, over which contact is observed.
const LONGEST_PERIOD: u32 = 64;

/// The steady motion of a point, as far as it is known.
pub(super) struct Steady {
    /// Period of the excitation \[mesh cycles\].
    period: u32,
    /// Cycles in contact since the last event.
    cycles_without_event: u64,
    /// Number of cycles without an event at which the next search is due. Later searches follow at doubled
    /// numbers.
    next: u64,
    /// `None` before a search. `Some(None)` if contact does not last over the period from the fixed point.
    orbit: Option<Option<PeriodicOrbit>>,
}

impl Steady {
    /// A record before any cycle. `None` if the excitation has no short period.
    pub(super) fn new(recurrence: &Recurrence) -> Option<Self> {
        let period = recurrence.excitation()?;
        (period <= LONGEST_PERIOD).then(|| Self {
            period,
            cycles_without_event: 0,
            next: period.into(),
            orbit: None,
        })
    }

    /// The period of the excitation \[mesh cycles\].
    pub(super) fn period(&self) -> u32 {
        self.period
    }

    /// Whether there is an attracting motion in steady contact.
    pub(super) fn attracts(&self) -> bool {
        let orbit = self.orbit.iter().flatten().next();
        orbit.is_some_and(PeriodicOrbit::attracts)
    }

    /// Records a cycle that ends at mesh cycle `cycle`, with or without an event. Returns whether a search is
    /// due.
    pub(super) fn is_due(&mut self, without_event: bool, cycle: u64) -> bool {
        self.cycles_without_event = if without_event { self.cycles_without_event + 1 } else { 0 };
        let start = |orbit: &PeriodicOrbit| orbit.start.cycle;
        let start = self.orbit.iter().flatten().next().map_or(cycle, start);
        let due = self.cycles_without_event >= self.next
            && (cycle - start).is_multiple_of(self.period.into());
        if due {
            self.next = 2 * self.cycles_without_event;
        }
        due
    }

    /// Whether the trajectory has stayed in contact for a period.
    pub(super) fn stayed_in_contact(&self) -> bool {
        self.cycles_without_event >= self.period.into()
    }
}

impl<K: Kernel> PointRun<'_, K> {
    /// Whether the trajectory stays in contact over the next period.
    pub(super) fn stays_in_contact(&mut self, period: u32) -> bool {
        let mut next_state = self.trajectory.clone();
        let mut counters = Counters::default();
        (0..period).all(|_| {
            let integrated = self.kernel.advance(
                1,
                &mut next_state,
                &mut self.workspace,
                &mut (),
                &mut counters,
            );
            integrated.is_ok() && counters.events == 0 && self.model.touches(next_state.contact)
        })
    }

    /// The motion in steady contact, if the trajectory approaches it; the trajectory is then moved to this
    /// motion. The trajectory must be in contact over the next period. If no approach is observed, the trajectory
    /// has advanced over the observation, unless that exceeds the transient.
    pub(super) fn seek_steady(
        &mut self,
        steady: &mut Steady,
    ) -> Result<Option<PeriodicMotion>, Interruption> {
        Interrupted::check(self.interrupt)?;
        let orbit = steady.orbit.get_or_insert_with(|| {
            // An iterate that diverges is not a motion in contact.
            shoot_without_event(
                self.model,
                self.kernel,
                &self.norm,
                &self.trajectory,
                steady.period,
                &mut self.workspace,
            )
            .unwrap_or(None)
        });
        let Some(orbit) = orbit else {
            return Ok(None);
        };
        let (mut next_state, mut counters) = (self.trajectory.clone(), self.counters);
        let approach = observe_approach(
            self.model,
            self.kernel,
            &self.norm,
            orbit,
            &mut next_state,
            &mut self.workspace,
            &mut counters,
        )?;
        let before = self.counters.cycles;
        if approach.is_some() || counters.cycles < self.config.transient {
            (self.trajectory, self.counters) = (next_state, counters);
        }
        if approach.is_none() {
            steady.cycles_without_event = 0;
        }
        Ok(approach.map(|approach| {
            let attracting = Attracting {
                orbit: orbit.clone(),
                doubled: false,
                approach,
            };
            self.move_to_orbit(attracting, before)
        }))
    }
}
