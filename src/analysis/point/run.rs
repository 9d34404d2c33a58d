//! The integration of one point, step by step: how it is advanced, aligned, audited and measured,
//! and what is handed over when it ends.

use super::instruments::{Instruments, Watch};
use crate::analysis::called_off::CalledOff;
use crate::analysis::contact_jumps::ContactJumps;
use crate::analysis::energy::{EnergyAudit, objection};
use crate::analysis::lyapunov::CYCLES_PER_AVERAGE;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::orders::Orders;
use crate::analysis::outcome::{Class, LyapunovOutcome, PointOutcome, Status};
use crate::analysis::questions::Questions;
use crate::analysis::spectrum::Spectra;
use crate::model::{Model, TrajectoryState};
use crate::numerics::statistics::FEWEST_BLOCKS;
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};
use std::sync::atomic::AtomicBool;

/// Measured cycles of a twin: as many as an error bar takes. It is there to check the
/// tangents over the same cycles, which more of them would not do any better.
const TWIN_CYCLES: u64 = FEWEST_BLOCKS as u64 * CYCLES_PER_AVERAGE as u64;

/// Why an integration ended early.
pub(super) enum Halt {
    CalledOff,
    Stop(Stop),
}

impl From<Stop> for Halt {
    fn from(stop: Stop) -> Self {
        Self::Stop(stop)
    }
}

impl From<CalledOff> for Halt {
    fn from(_: CalledOff) -> Self {
        Self::CalledOff
    }
}

/// The integration of one point.
pub(super) struct PointRun<'a, K: Kernel> {
    pub(super) model: &'a Model,
    pub(super) kernel: &'a K,
    pub(super) questions: &'a Questions,
    pub(super) called_off: &'a AtomicBool,
    pub(super) norm: EnergyNorm,
    /// The norm in which tangents and twin are measured.
    pub(super) growth_norm: EnergyNorm,
    pub(super) trajectory: TrajectoryState,
    pub(super) workspace: K::Workspace,
    pub(super) counters: Counters,
    pub(super) energy_residual: Option<f64>,
}

impl<K: Kernel> PointRun<'_, K> {
    /// Instruments at the trajectory's present place, tangents and twin aligned.
    pub(super) fn align(&mut self) -> Result<Instruments, Halt> {
        let mut instruments = Instruments::new(
            self.model,
            &self.growth_norm,
            self.questions,
            &self.trajectory,
        );
        if let Some(lyapunov) = &self.questions.lyapunov {
            for _ in 0..lyapunov.align {
                self.cycle(&mut instruments, &mut ())?;
            }
        }
        instruments.restart(&self.counters);
        Ok(instruments)
    }

    /// One cycle of the trajectory alone.
    pub(super) fn plain_cycle<O: Observer>(&mut self, observer: &mut O) -> Result<(), Halt> {
        CalledOff::check(self.called_off)?;
        self.kernel.advance(
            1,
            &mut self.trajectory,
            &mut self.workspace,
            observer,
            &mut self.counters,
        )?;
        Ok(())
    }

    /// Advances the transient, at once where contact is certain to last.
    pub(super) fn pass_transient(&mut self) -> Result<(), Halt> {
        let mut jumps = ContactJumps::new(self.model);
        while self.counters.cycles < self.questions.transient {
            let left = self.questions.transient - self.counters.cycles;
            let leap = jumps.jump(self.kernel, &mut self.trajectory, left, &mut self.workspace);
            self.counters.cycles += leap;
            if leap < left {
                self.plain_cycle(&mut ())?;
                jumps.marched();
            }
        }
        Ok(())
    }

    /// Audits the energy balance over some cycles, where it is to be audited at all.
    pub(super) fn audit(&mut self, cycles: u64) -> Result<(), Halt> {
        let mut audit = EnergyAudit::new(self.model);
        for _ in 0..cycles.min(self.questions.audit_cycles) {
            self.plain_cycle(&mut audit)?;
        }
        self.energy_residual = audit.residual(&self.trajectory);
        Ok(())
    }

    /// One cycle of the trajectory, its tangents and its twin.
    fn cycle<O: Observer>(
        &mut self,
        instruments: &mut Instruments,
        observer: &mut O,
    ) -> Result<(), Halt> {
        CalledOff::check(self.called_off)?;
        let mut none = Tangents::none();
        let tangents = match &mut instruments.growth {
            Some(growth) => growth.tangents(),
            None => &mut none,
        };
        self.kernel.advance_cycle(
            &mut self.trajectory,
            tangents,
            &mut self.workspace,
            observer,
            &mut self.counters,
        )?;
        let Some(growth) = &mut instruments.growth else {
            return Ok(());
        };
        let tangent = growth.cycle(&self.growth_norm);
        // Nothing is measured while it is aligned, however long that takes.
        if let Some(twin) = &mut instruments.twin
            && instruments.measured < TWIN_CYCLES
        {
            // The twin's work is not the point's: its events and grazings are not counted.
            let mut uncounted = Counters::default();
            self.kernel.advance(
                1,
                twin.trajectory(),
                &mut self.workspace,
                &mut (),
                &mut uncounted,
            )?;
            twin.cycle(self.model, &self.growth_norm, &self.trajectory, tangent);
        }
        Ok(())
    }

    /// Measures some cycles.
    pub(super) fn measure(
        &mut self,
        instruments: &mut Instruments,
        cycles: u64,
    ) -> Result<(), Halt> {
        for _ in 0..cycles {
            if instruments.watch.watches() {
                let mut watch =
                    std::mem::replace(&mut instruments.watch, Watch::of_nothing(self.model));
                let result = self.cycle(instruments, &mut watch);
                instruments.watch = watch;
                result?;
            } else {
                self.cycle(instruments, &mut ())?;
            }
            instruments.measured += 1;
            instruments
                .watch
                .poincare
                .push(self.model, &self.trajectory);
            instruments.recurrence.push(&self.trajectory.state);
        }
        Ok(())
    }

    pub(super) fn outcome(
        &self,
        status: Status,
        reason: String,
        class: Option<Class>,
        lyapunov: Option<LyapunovOutcome>,
        instruments: &mut Instruments,
    ) -> PointOutcome {
        let events = self.counters.events - instruments.events_before;
        let (status, reason) = match self.objection() {
            Some(objection) => (Status::Inaccurate, format!("{objection}; {reason}")),
            None => (status, reason),
        };
        PointOutcome {
            status,
            reason,
            class,
            lyapunov: lyapunov.filter(|l| l.stderr().is_finite()),
            nvh: instruments.watch.statistics(),
            spectra: (instruments.watch.spectra.as_ref())
                .map(Spectra::spectra)
                .unwrap_or_default(),
            orders: (instruments.watch.orders.as_ref())
                .map(Orders::outcome)
                .unwrap_or_default(),
            poincare: instruments.watch.poincare.take(),
            events_per_cycle: (instruments.measured > 0)
                .then(|| events as f64 / instruments.measured as f64),
            energy_residual: self.energy_residual,
            grazing_count: self.counters.grazings,
            cycles: self.counters.cycles,
            measured_cycles: instruments.measured,
        }
    }

    /// Why the answers cannot be relied on, where the energy balance says so. A kernel that
    /// approximates leaves a residual by design.
    fn objection(&self) -> Option<String> {
        let residual = self.energy_residual.filter(|_| self.kernel.exact())?;
        objection(residual)
    }

    /// The outcome of an integration that a kernel ended.
    pub(super) fn stopped(&self, stop: Stop) -> Result<PointOutcome, CalledOff> {
        Ok(self.unanswered(Status::try_from(stop)?, stop.to_string()))
    }

    /// The outcome of an integration without answers.
    pub(super) fn unanswered(&self, status: Status, reason: String) -> PointOutcome {
        PointOutcome {
            energy_residual: self.energy_residual,
            grazing_count: self.counters.grazings,
            cycles: self.counters.cycles,
            ..PointOutcome::unanswered(status, reason)
        }
    }
}
