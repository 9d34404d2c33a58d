//! The integration of one point, step by step: advancing, aligning, auditing, measuring, and the outcome at
//! the end.

use super::instruments::{Instruments, Record};
use crate::analysis::averages::CYCLES_PER_AVERAGE;
use crate::analysis::config::PointConfig;
use crate::analysis::contact_jumps::ContactJumps;
use crate::analysis::divergence::{Bounds, Runaway};
use crate::analysis::energy::{EnergyAudit, imbalance_message};
use crate::analysis::interrupt::Interrupted;
use crate::analysis::lyapunov::TangentGrowth;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::orders::Orders;
use crate::analysis::outcome::{Class, LyapunovOutcome, PointOutcome, Status};
use crate::analysis::spectrum::Spectra;
use crate::analysis::twin::Twin;
use crate::model::{Model, TrajectoryState};
use crate::numerics::statistics::FEWEST_VALUES;
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};
use std::sync::atomic::AtomicBool;

/// Measured cycles of a twin: as many as an error bar needs. Twin and tangents are compared over the same
/// cycles, so a longer twin would not improve the check.
const TWIN_CYCLES: u64 = FEWEST_VALUES as u64 * CYCLES_PER_AVERAGE as u64;

/// Why an integration ended early.
pub(super) enum Interruption {
    Interrupted,
    Stop(Stop),
    Runaway(Runaway),
}

impl From<Stop> for Interruption {
    fn from(stop: Stop) -> Self {
        Self::Stop(stop)
    }
}

impl From<Interrupted> for Interruption {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// The integration of one point.
pub(super) struct PointRun<'a, K: Kernel> {
    pub(super) model: &'a Model,
    pub(super) kernel: &'a K,
    pub(super) config: &'a PointConfig,
    pub(super) interrupt: &'a AtomicBool,
    pub(super) norm: EnergyNorm,
    /// The norm for tangents and twin.
    pub(super) growth_norm: EnergyNorm,
    pub(super) bounds: Bounds,
    pub(super) trajectory: TrajectoryState,
    pub(super) workspace: K::Workspace,
    pub(super) counters: Counters,
    pub(super) energy_residual: Option<f64>,
}

impl<K: Kernel> PointRun<'_, K> {
    /// Instruments at the trajectory's present state, with aligned tangents and twin.
    pub(super) fn align(&mut self) -> Result<Instruments, Interruption> {
        let mut instruments =
            Instruments::new(self.model, &self.growth_norm, self.config, &self.trajectory);
        if let Some(lyapunov) = &self.config.lyapunov {
            for _ in 0..lyapunov.align {
                self.cycle(
                    &mut instruments.record.growth,
                    instruments.record.twin.as_mut(),
                    &mut (),
                )?;
            }
        }
        instruments.restart();
        Ok(instruments)
    }

    /// One cycle of the trajectory alone.
    pub(super) fn plain_cycle<O: Observer>(
        &mut self,
        observer: &mut O,
    ) -> Result<(), Interruption> {
        Interrupted::check(self.interrupt)?;
        self.kernel.advance(
            1,
            &mut self.trajectory,
            &mut self.workspace,
            observer,
            &mut self.counters,
        )?;
        Ok(())
    }

    /// Advances the transient, in jumps if contact is certain to last.
    pub(super) fn pass_transient(&mut self) -> Result<(), Interruption> {
        let mut jumps = ContactJumps::new(self.model);
        while self.counters.cycles < self.config.transient {
            let left = self.config.transient - self.counters.cycles;
            let leap = jumps.jump(self.kernel, &mut self.trajectory, left, &mut self.workspace);
            self.counters.cycles += leap;
            if leap < left {
                self.plain_cycle(&mut ())?;
                jumps.count_integrated_cycle();
            }
        }
        Ok(())
    }

    /// Audits the energy balance over some cycles, if an audit is requested.
    pub(super) fn audit(&mut self, cycles: u64) -> Result<(), Interruption> {
        let mut audit = EnergyAudit::new(self.model);
        for _ in 0..cycles.min(self.config.audit_cycles) {
            self.plain_cycle(&mut audit)?;
        }
        self.energy_residual = audit.residual(&self.trajectory);
        Ok(())
    }

    /// One cycle of the trajectory, its tangents and its twin. Returns the growth of the first tangent, 0
    /// without tangents.
    pub(super) fn cycle<O: Observer>(
        &mut self,
        growth: &mut Option<TangentGrowth>,
        twin: Option<&mut Twin>,
        observer: &mut O,
    ) -> Result<f64, Interruption> {
        Interrupted::check(self.interrupt)?;
        let mut none = Tangents::none();
        let tangents = match growth {
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
        let Some(growth) = growth else {
            return Ok(0.0);
        };
        let tangent = growth.cycle(&self.growth_norm);
        if let Some(twin) = twin {
            // The twin's events and grazings do not belong to the point, and are not counted.
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
        Ok(tangent)
    }

    /// Measures some cycles.
    pub(super) fn measure(
        &mut self,
        instruments: &mut Instruments,
        cycles: u64,
    ) -> Result<(), Interruption> {
        for _ in 0..cycles {
            let events = self.counters.events;
            let record = &mut instruments.record;
            let watch = &mut record.watch;
            let twin = (record.twin.as_mut()).filter(|_| record.measured < TWIN_CYCLES);
            let growth = if watch.needs_windows() {
                self.cycle(&mut record.growth, twin, watch)?
            } else {
                self.cycle(&mut record.growth, twin, &mut ())?
            };
            let (strobe, _) = self.model.deflection(&self.trajectory.state, 0.0);
            record.measured += 1;
            record.events += self.counters.events - events;
            record.strobe.push(strobe * strobe);
            record.watch.cycle(self.model, &self.trajectory);
            instruments.series.push(growth, strobe);
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
        record: &mut Record,
    ) -> PointOutcome {
        let (status, reason) = match self.unreliable_reason() {
            Some(unreliable) => (Status::Inaccurate, format!("{unreliable}; {reason}")),
            None => (status, reason),
        };
        let watch = &mut record.watch;
        PointOutcome {
            status,
            reason,
            class,
            lyapunov: lyapunov.filter(|l| l.stderr().is_finite()),
            nvh: watch.statistics(),
            spectra: (watch.spectra.as_ref())
                .map(Spectra::spectra)
                .unwrap_or_default(),
            orders: (watch.orders.as_ref())
                .map(Orders::outcome)
                .unwrap_or_default(),
            poincare: watch.poincare.take(),
            events_per_cycle: (record.measured > 0)
                .then(|| record.events as f64 / record.measured as f64),
            energy_residual: self.energy_residual,
            evidence: None,
            chaos: None,
            grazing_count: self.counters.grazings,
            cycles: self.counters.cycles,
            measured_cycles: record.measured,
        }
    }

    /// Why the results are unreliable, if the energy balance does not close. Approximate kernels are not
    /// checked, because they leave a residual by design.
    fn unreliable_reason(&self) -> Option<String> {
        let residual = self.energy_residual.filter(|_| self.kernel.exact())?;
        imbalance_message(residual)
    }

    /// The outcome of an integration that a kernel ended.
    pub(super) fn stopped(&self, stop: Stop) -> Result<PointOutcome, Interrupted> {
        Ok(self.without_results(Status::try_from(stop)?, stop.to_string()))
    }

    /// The outcome of an integration without results.
    pub(super) fn without_results(&self, status: Status, reason: String) -> PointOutcome {
        PointOutcome {
            energy_residual: self.energy_residual,
            grazing_count: self.counters.grazings,
            cycles: self.counters.cycles,
            ..PointOutcome::without_results(status, reason)
        }
    }
}
