//! The attractors of a point, found by integration and numbered in the order of discovery.

use super::capture::KnownOrbits;
use super::field::IntegrationContext;
use super::outcome::{AttractorOutcome, BasinShare};
use super::plane::Plane;
use super::same::Attractor;
use crate::analysis::orbits::shooting::shoot;
use crate::analysis::outcome::{Class, PointOutcome};
use crate::analysis::recurrence::excitation_period;
use crate::model::{Model, TrajectoryState};
use crate::propagate::Kernel;

/// The attractors found so far.
pub(super) struct Attractors {
    known: Vec<Attractor>,
    outcomes: Vec<AttractorOutcome>,
    orbits: KnownOrbits,
    /// Number of attractors for which an orbit has been sought.
    sought: usize,
}

impl Attractors {
    /// An empty list of attractors.
    pub fn new<K: Kernel>(field: &IntegrationContext<'_, K>) -> Self {
        Self {
            known: Vec::new(),
            outcomes: Vec::new(),
            orbits: KnownOrbits::new(excitation_period(field.model).unwrap_or(1) as u64),
            sought: 0,
        }
    }

    /// The number of the attractor of a motion: that of a known one, or the next number. `None` if the motion
    /// settled on none.
    pub fn number_of<K: Kernel>(
        &mut self,
        field: &IntegrationContext<'_, K>,
        new: Option<Attractor>,
        outcome: &PointOutcome,
    ) -> Option<u32> {
        let new = new?;
        let same = |old: &Attractor| old.is_same(&new, field.norm);
        if let Some(id) = self.known.iter().position(same) {
            return Some(id as u32);
        }
        let (nvh, lyapunov) = (outcome.nvh.as_ref(), outcome.lyapunov.as_ref());
        self.outcomes.push(AttractorOutcome {
            class: new.class(),
            lambda: lyapunov.and_then(|l| l.exponents.first().copied()),
            lambda_stderr: lyapunov.map(|l| l.stderr()),
            chaos_lifetime_low: None,
            deflection_rms: nvh.map(|n| n.values.deflection_rms),
            force_peak: nvh.map(|n| n.force_peak),
            events_per_cycle: outcome.events_per_cycle,
            probes: 0,
            basin: BasinShare::default(),
            cells: None,
            strobe: Vec::new(),
        });
        self.known.push(new);
        Some(self.known.len() as u32 - 1)
    }

    /// Computes the orbits of new periodic attractors, so that cells that approach them need no
    /// investigation. An orbit is not used if Newton's method does not find it, or if it does not attract.
    pub fn seek_orbits<K: Kernel>(&mut self, field: &IntegrationContext<'_, K>) {
        let mut workspace = field.kernel.workspace();
        for id in self.sought..self.known.len() {
            let Some((start, period)) = self.known[id].orbit() else {
                continue;
            };
            let found = shoot(
                field.model,
                field.kernel,
                field.norm,
                start,
                period,
                &mut workspace,
            );
            if let Ok(Some(orbit)) = found
                && orbit.attracts()
            {
                self.orbits.add(id as u32, orbit);
            }
        }
        self.sought = self.known.len();
    }

    /// The known orbits, for cells that approach one of them.
    pub fn orbits(&self) -> &KnownOrbits {
        &self.orbits
    }

    /// Kind of motion of an attractor.
    pub fn class(&self, id: u32) -> Class {
        self.known[id as usize].class()
    }

    /// The attractors of a model, with their strobe states on the slice.
    pub fn outcomes(
        self,
        model: &Model,
        slice: Option<(&Plane, &TrajectoryState)>,
    ) -> Vec<AttractorOutcome> {
        let mut outcomes = self.outcomes;
        if let Some((plane, start)) = slice {
            for (outcome, attractor) in outcomes.iter_mut().zip(&self.known) {
                let states = attractor.strobe().iter();
                outcome.strobe = states
                    .map(|state| plane.place(model, start, state))
                    .collect();
            }
        }
        outcomes
    }
}
