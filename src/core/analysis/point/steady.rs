//! Motions that come to steady contact.
//!
//! While no contact opens or closes, the map of a period of the excitation is affine, whatever the state. Its
//! fixed point, where contact lasts on it, is the only steady motion of the point. It is solved for once,
//! when a trajectory first stays in contact for a period; later trajectories in contact are held against it.

use super::run::{Interruption, PointRun};
use super::settle::Repeating;
use crate::analysis::called_off::CalledOff;
use crate::analysis::orbits::attracting::{Attracting, comes};
use crate::analysis::orbits::shooting::{PeriodicOrbit, shoot_without_event};
use crate::analysis::recurrence::Recurrence;
use crate::propagate::{Counters, Kernel};

/// Longest period of an excitation, in mesh cycles, over which contact is watched.
const LONGEST_LOOK: u32 = 64;

/// What is known of the steady motion of a point.
pub(super) struct Steady {
    /// Of the excitation \[mesh cycles\].
    period: u32,
    /// Cycles in contact since the last event.
    quiet: u64,
    /// As many at the next search; those after it come at doubled counts.
    next: u64,
    /// None until it was sought; then none where contact does not last.
    orbit: Option<Option<PeriodicOrbit>>,
}

impl Steady {
    /// Nothing known. None where the excitation does not repeat soon.
    pub(super) fn new(recurrence: &Recurrence) -> Option<Self> {
        let period = recurrence.excitation()?;
        (period <= LONGEST_LOOK).then(|| Self {
            period,
            quiet: 0,
            next: period.into(),
            orbit: None,
        })
    }

    /// The period of the excitation \[mesh cycles\].
    pub(super) fn period(&self) -> u32 {
        self.period
    }

    /// Whether there is a motion in steady contact that attracts what is next to it.
    pub(super) fn attracts(&self) -> bool {
        let orbit = self.orbit.iter().flatten().next();
        orbit.is_some_and(|orbit| orbit.spectral_radius() < 1.0)
    }

    /// Takes note of a cycle up to mesh cycle `cycle`, with or without an event; whether a search is due.
    pub(super) fn is_due(&mut self, quiet: bool, cycle: u64) -> bool {
        self.quiet = if quiet { self.quiet + 1 } else { 0 };
        let start = |orbit: &PeriodicOrbit| orbit.start.cycle;
        let start = self.orbit.iter().flatten().next().map_or(cycle, start);
        let due = self.quiet >= self.next && (cycle - start).is_multiple_of(self.period.into());
        if due {
            self.next = 2 * self.quiet;
        }
        due
    }

    /// Whether the trajectory has stayed in contact for a period.
    pub(super) fn is_quiet(&self) -> bool {
        self.quiet >= self.period.into()
    }
}

impl<K: Kernel> PointRun<'_, K> {
    /// Whether the trajectory stays in contact over the period ahead.
    pub(super) fn stays_locked(&mut self, period: u32) -> bool {
        let mut ahead = self.trajectory.clone();
        let mut counters = Counters::default();
        (0..period).all(|_| {
            let integrated =
                self.kernel
                    .advance(1, &mut ahead, &mut self.workspace, &mut (), &mut counters);
            integrated.is_ok() && counters.events == 0 && self.model.touches(ahead.contact)
        })
    }

    /// The motion in steady contact, if the trajectory, in contact over the period ahead, is seen to come to it;
    /// it is put there. Otherwise the trajectory is where it was seen not to, within the transient.
    pub(super) fn seek_steady(
        &mut self,
        steady: &mut Steady,
    ) -> Result<Option<Repeating>, Interruption> {
        CalledOff::check(self.called_off)?;
        let orbit = steady.orbit.get_or_insert_with(|| {
            // An iterate that diverges is no motion in contact.
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
        let (mut ahead, mut counters) = (self.trajectory.clone(), self.counters);
        let approach = comes(
            self.model,
            self.kernel,
            &self.norm,
            orbit,
            &mut ahead,
            &mut self.workspace,
            &mut counters,
        )?;
        let before = self.counters.cycles;
        if approach.is_some() || counters.cycles < self.questions.transient {
            (self.trajectory, self.counters) = (ahead, counters);
        }
        if approach.is_none() {
            steady.quiet = 0;
        }
        Ok(approach.map(|approach| {
            let found = Attracting {
                orbit: orbit.clone(),
                doubled: false,
                approach,
            };
            self.put_on(found, before)
        }))
    }
}
