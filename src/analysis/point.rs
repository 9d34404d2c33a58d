//! All questions to one operating point, in one march.
//!
//! 1. the transient is marched and discarded;
//! 2. the energy balance is audited over a stretch;
//! 3. tangents and twin are aligned, their growth discarded;
//! 4. blocks of cycles are measured until the answers have settled or the budget is spent.
//!
//! After every block the strobe states are searched for a short period. A motion that
//! repeats is confirmed by its multipliers, measured once over whole periods, and done.
//! A chaotic one is done when its standard error is small enough.

use super::classify::{Evidence, classify};
use super::energy::EnergyAudit;
use super::lyapunov::{TangentGrowth, agree};
use super::norm::EnergyNorm;
use super::nvh::Nvh;
use super::orbits::floquet;
use super::outcome::{Class, LyapunovMethod, LyapunovOutcome, PointOutcome, Status};
use super::poincare::Poincare;
use super::questions::Questions;
use super::recurrence::Recurrence;
use super::spectrum::{CYCLES_PER_SEGMENT, Welch};
use super::twin::Twin;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::Stream;
use crate::numerics::statistics::{FEWEST_BLOCKS, mean, standard_error};
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Tangents, Window};
use std::sync::atomic::{AtomicBool, Ordering};

/// The work was called off; nothing is known of the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("called off before the point was finished")]
pub struct CalledOff;

/// Cycles between two looks at the answers.
const BLOCK: u64 = 50;

/// Fewest cycles a settled periodic motion is measured over.
const SETTLED_CYCLES: u64 = 128;

/// Exponent per cycle up to which a repeating motion counts as neutral: round-off splits a
/// double multiplier 1 (free flight) by its square root.
const NEUTRAL: f64 = 1e-7;

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

/// As [`investigate`]; leaves `trajectory` where the march ended.
pub(super) fn investigate_onward<K: Kernel>(
    model: &Model,
    kernel: &K,
    trajectory: &mut TrajectoryState,
    questions: &Questions,
    called_off: &AtomicBool,
) -> Result<PointOutcome, CalledOff> {
    let mut march = March {
        model,
        kernel,
        questions,
        called_off,
        norm: EnergyNorm::new(model),
        trajectory: trajectory.clone(),
        workspace: kernel.workspace(),
        counters: Counters::default(),
        energy_residual: None,
    };
    let outcome = match march.run() {
        Ok(outcome) => Ok(outcome),
        Err(Halt::CalledOff) => Err(CalledOff),
        Err(Halt::Stop(stop)) => Ok(march.stopped(stop)),
    };
    *trajectory = march.trajectory;
    outcome
}

/// Why a march ended early.
enum Halt {
    CalledOff,
    Stop(Stop),
}

impl From<Stop> for Halt {
    fn from(stop: Stop) -> Self {
        Self::Stop(stop)
    }
}

/// The march of one point.
struct March<'a, K: Kernel> {
    model: &'a Model,
    kernel: &'a K,
    questions: &'a Questions,
    called_off: &'a AtomicBool,
    norm: EnergyNorm,
    trajectory: TrajectoryState,
    workspace: K::Workspace,
    counters: Counters,
    energy_residual: Option<f64>,
}

/// What is measured beside the trajectory.
struct Instruments {
    growth: Option<TangentGrowth>,
    twin: Option<Twin>,
    watch: Watch,
    poincare: Poincare,
    recurrence: Recurrence,
    measured: u64,
    events_before: u64,
}

/// The observers of measured cycles.
struct Watch {
    nvh: Option<Nvh>,
    welch: Option<Welch>,
}

impl Observer for Watch {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        if let Some(nvh) = &mut self.nvh {
            nvh.window(window);
        }
        if let Some(welch) = &mut self.welch {
            welch.window(window);
        }
    }

    fn event(&mut self, event: &Event) {
        if let Some(nvh) = &mut self.nvh {
            nvh.event(event);
        }
    }
}

impl Instruments {
    fn restart(&mut self, counters: &Counters) {
        if let Some(growth) = &mut self.growth {
            growth.restart();
        }
        if let Some(twin) = &mut self.twin {
            twin.restart();
        }
        if let Some(nvh) = &mut self.watch.nvh {
            nvh.restart();
        }
        if let Some(welch) = &mut self.watch.welch {
            welch.restart();
        }
        self.poincare.restart();
        self.measured = 0;
        self.events_before = counters.events;
    }

    fn averages(&self) -> &[f64] {
        self.growth.as_ref().map_or(&[], |g| g.averages())
    }
}

impl<K: Kernel> March<'_, K> {
    fn run(&mut self) -> Result<PointOutcome, Halt> {
        self.plain(self.questions.transient)?;
        self.audit()?;
        let mut instruments = self.instruments();
        if let Some(lyapunov) = &self.questions.lyapunov {
            for _ in 0..lyapunov.align {
                self.cycle(&mut instruments, &mut ())?;
            }
        }
        instruments.restart(&self.counters);
        while instruments.measured < self.questions.cycles {
            let block = BLOCK.min(self.questions.cycles - instruments.measured);
            self.measure(&mut instruments, block)?;
            if let Some(period) = instruments.recurrence.period(&self.norm)
                && let Some(outcome) = self.settle(&mut instruments, period)?
            {
                return Ok(outcome);
            }
            if self.precise_enough(&instruments) {
                break;
            }
        }
        Ok(self.aperiodic(instruments))
    }

    /// Marches without watching.
    fn plain(&mut self, cycles: u64) -> Result<(), Halt> {
        for _ in 0..cycles {
            self.look_up()?;
            self.kernel.march(
                &mut self.trajectory,
                &mut Tangents::none(),
                &mut self.workspace,
                &mut (),
                &mut self.counters,
            )?;
        }
        Ok(())
    }

    /// Ends the work when it was called off.
    fn look_up(&self) -> Result<(), Halt> {
        if self.called_off.load(Ordering::Relaxed) {
            Err(Halt::CalledOff)
        } else {
            Ok(())
        }
    }

    fn audit(&mut self) -> Result<(), Halt> {
        let mut audit = EnergyAudit::new(self.model);
        for _ in 0..self.questions.audit_cycles {
            self.look_up()?;
            self.kernel.march(
                &mut self.trajectory,
                &mut Tangents::none(),
                &mut self.workspace,
                &mut audit,
                &mut self.counters,
            )?;
        }
        self.energy_residual = audit.residual(&self.trajectory);
        Ok(())
    }

    fn instruments(&self) -> Instruments {
        let q = self.questions;
        let stream = |probe| Stream::new(q.seed, q.point_id, probe);
        let modes = self.model.modes();
        Instruments {
            growth: q
                .lyapunov
                .map(|l| l.exponents.min(self.norm.dimension()))
                .map(|count| TangentGrowth::new(&self.norm, modes, count, &mut stream(0))),
            twin: q
                .lyapunov
                .filter(|l| l.twin)
                .map(|_| Twin::new(self.model, &self.norm, &self.trajectory, &mut stream(1))),
            watch: Watch {
                nvh: q.nvh.map(|n| Nvh::new(self.model, n.harmonics)),
                welch: q.nvh.filter(|n| n.spectrum).map(|_| Welch::new(self.model)),
            },
            poincare: Poincare::new(q.poincare_samples),
            recurrence: Recurrence::new(self.model),
            measured: 0,
            events_before: 0,
        }
    }

    /// One cycle of the trajectory, its tangents and its twin.
    fn cycle<O: Observer>(
        &mut self,
        instruments: &mut Instruments,
        observer: &mut O,
    ) -> Result<(), Halt> {
        self.look_up()?;
        let mut none = Tangents::none();
        let tangents = match &mut instruments.growth {
            Some(growth) => growth.tangents(),
            None => &mut none,
        };
        self.kernel.march(
            &mut self.trajectory,
            tangents,
            &mut self.workspace,
            observer,
            &mut self.counters,
        )?;
        if let Some(growth) = &mut instruments.growth {
            growth.cycle(&self.norm);
        }
        if let Some(twin) = &mut instruments.twin {
            // The twin's work is not the point's: its events and grazings are not counted.
            let mut uncounted = Counters::default();
            self.kernel.march(
                twin.trajectory(),
                &mut Tangents::none(),
                &mut self.workspace,
                &mut (),
                &mut uncounted,
            )?;
            twin.cycle(self.model, &self.norm, &self.trajectory);
        }
        Ok(())
    }

    /// Measures some cycles.
    fn measure(&mut self, instruments: &mut Instruments, cycles: u64) -> Result<(), Halt> {
        for _ in 0..cycles {
            if self.questions.nvh.is_some() {
                let mut watch = std::mem::replace(
                    &mut instruments.watch,
                    Watch {
                        nvh: None,
                        welch: None,
                    },
                );
                let result = self.cycle(instruments, &mut watch);
                instruments.watch = watch;
                result?;
            } else {
                self.cycle(instruments, &mut ())?;
            }
            instruments.measured += 1;
            instruments.poincare.push(self.model, &self.trajectory);
            instruments.recurrence.push(&self.trajectory.state);
        }
        Ok(())
    }

    /// A motion that repeats after `period` cycles: confirms it by its multipliers and
    /// measures it over whole periods. None where a multiplier lies outside the unit circle
    /// (a long stay near an unstable orbit); one on it is a motion that nothing damps.
    fn settle(
        &mut self,
        instruments: &mut Instruments,
        period: u32,
    ) -> Result<Option<PointOutcome>, Halt> {
        let mut orbit = self.trajectory.clone();
        let mut exponents = [Vec::new(), Vec::new()];
        for exponents in &mut exponents {
            let Some(multipliers) = floquet::multipliers(
                self.model,
                self.kernel,
                &self.norm,
                &mut orbit,
                period,
                &mut self.workspace,
                &mut Counters::default(),
            )?
            else {
                return Ok(None);
            };
            *exponents = floquet::exponents(&multipliers, period);
        }
        let largest = exponents[0].first().copied().unwrap_or(f64::NAN);
        if largest.is_nan() || largest > NEUTRAL {
            return Ok(None);
        }
        // A second, independent turn around the orbit shows how well the first is known.
        let stderr = (largest - exponents[1][0]).abs();
        instruments.restart(&self.counters);
        let k = u64::from(period);
        let spectral = if instruments.watch.welch.is_some() {
            2 * CYCLES_PER_SEGMENT as u64
        } else {
            0
        };
        let wanted = SETTLED_CYCLES
            .max(self.questions.poincare_samples as u64)
            .max(10 * FEWEST_BLOCKS as u64 * u64::from(instruments.twin.is_some()))
            .max(spectral);
        self.measure(instruments, wanted.div_ceil(k) * k)?;
        let events = self.counters.events - instruments.events_before;
        let class = if events == 0 && self.trajectory.contact.touching() {
            Class::Locked
        } else {
            Class::Periodic(period)
        };
        let lyapunov = self.questions.lyapunov.map(|l| {
            let twin = instruments.twin.as_ref();
            LyapunovOutcome {
                exponents: exponents[0].iter().take(l.exponents).copied().collect(),
                stderr,
                twin: twin.map(|t| mean(t.averages())),
                twin_stderr: twin.map(|t| standard_error(t.averages())),
                twin_agrees: twin.and_then(|t| agree(instruments.averages(), t.averages())),
                method: LyapunovMethod::Multipliers,
            }
        });
        let reason = match class {
            Class::Locked if period == 1 => {
                "repeats every cycle and never leaves contact".to_owned()
            }
            Class::Locked => format!("repeats after {period} cycles and never leaves contact"),
            _ => format!(
                "repeats after {period} {} with {events} events in {} cycles",
                if period == 1 { "cycle" } else { "cycles" },
                instruments.measured
            ),
        };
        Ok(Some(self.outcome(
            Status::Ok,
            reason,
            Some(class),
            lyapunov,
            instruments,
        )))
    }

    /// Whether the largest exponent of a motion that does not repeat is known well enough.
    fn precise_enough(&self, instruments: &Instruments) -> bool {
        let Some(target) = self.questions.lyapunov.and_then(|l| l.stop_at_stderr) else {
            return false;
        };
        let averages = instruments.averages();
        let longest = instruments.recurrence.longest() as u64;
        if averages.len() < 4 * FEWEST_BLOCKS || instruments.measured < longest {
            return false;
        }
        let error = standard_error(averages);
        error <= target && mean(averages) > 5.0 * error
    }

    /// The outcome of a motion that did not repeat.
    fn aperiodic(&mut self, mut instruments: Instruments) -> PointOutcome {
        let averages = instruments.averages().to_vec();
        let evidence = Evidence {
            averages: &averages,
            closest_return: instruments.recurrence.closest_return(&self.norm),
            longest_period: instruments.recurrence.longest(),
            excitation_repeats: instruments.recurrence.excitation_repeats(),
            touched_throughout: self.counters.events == instruments.events_before
                && self.trajectory.contact.touching(),
            target: self.questions.lyapunov.and_then(|l| l.stop_at_stderr),
            measured: instruments.measured,
        };
        let verdict = classify(&evidence);
        let twin = instruments.twin.as_ref();
        let lyapunov = instruments.growth.as_ref().and_then(|growth| {
            Some(LyapunovOutcome {
                exponents: growth.exponents()?,
                stderr: standard_error(&averages),
                twin: twin.map(|t| mean(t.averages())),
                twin_stderr: twin.map(|t| standard_error(t.averages())),
                twin_agrees: twin.and_then(|t| agree(&averages, t.averages())),
                method: LyapunovMethod::Tangent,
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

    fn outcome(
        &self,
        status: Status,
        reason: String,
        class: Option<Class>,
        lyapunov: Option<LyapunovOutcome>,
        instruments: &mut Instruments,
    ) -> PointOutcome {
        let events = self.counters.events - instruments.events_before;
        let poincare = std::mem::replace(&mut instruments.poincare, Poincare::new(0));
        PointOutcome {
            status,
            reason,
            class,
            lyapunov: lyapunov.filter(|l| l.stderr.is_finite()),
            nvh: instruments.watch.nvh.as_ref().and_then(Nvh::outcome),
            spectra: instruments
                .watch
                .welch
                .as_ref()
                .map(Welch::spectra)
                .unwrap_or_default(),
            poincare: poincare.into_samples(),
            events_per_cycle: (instruments.measured > 0)
                .then(|| events as f64 / instruments.measured as f64),
            energy_residual: self.energy_residual,
            grazing_count: self.counters.grazings,
            cycles: self.counters.cycles,
            measured_cycles: instruments.measured,
        }
    }

    /// The outcome of a march that a kernel ended.
    fn stopped(&self, stop: Stop) -> PointOutcome {
        PointOutcome {
            status: Status::from(stop),
            reason: stop.to_string(),
            class: None,
            lyapunov: None,
            nvh: None,
            spectra: Vec::new(),
            poincare: Vec::new(),
            events_per_cycle: None,
            energy_residual: self.energy_residual,
            grazing_count: self.counters.grazings,
            cycles: self.counters.cycles,
            measured_cycles: 0,
        }
    }
}
