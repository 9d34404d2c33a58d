//! Motions that repeat: found early by Newton's method, or by waiting until they do.

use super::instruments::Instruments;
use super::{Halt, March};
use crate::analysis::lyapunov::{CYCLES_PER_AVERAGE, agree};
use crate::analysis::orbits::floquet;
use crate::analysis::orbits::shooting::{approaches, shoot, shortest};
use crate::analysis::outcome::{Class, LyapunovMethod, LyapunovOutcome, PointOutcome, Status};
use crate::analysis::spectrum::CYCLES_PER_SEGMENT;
use crate::model::TrajectoryState;
use crate::numerics::statistics::{FEWEST_BLOCKS, mean, standard_error};
use crate::propagate::{Counters, Kernel};

/// Fewest cycles a settled periodic motion is measured over.
const SETTLED_CYCLES: u64 = 128;

/// Exponent per cycle up to which a repeating motion counts as neutral: round-off splits a
/// double multiplier 1 (free flight) by its square root.
const NEUTRAL: f64 = 1e-7;

/// Return distance, in half gaps, from which a Newton search is worth its cost.
pub(super) const WORTH_A_SEARCH: f64 = 0.3;

/// Cycles marched before the first search; the next ones follow at doubled counts, so that
/// a chaotic point spends little on them.
const FIRST_SEARCH: u64 = 100;

/// When the next search for an orbit is due.
#[derive(Debug, Clone, Copy)]
pub(super) struct Searches {
    next: u64,
}

impl Searches {
    /// None when orbits are not to be sought.
    pub(super) fn new(wanted: bool) -> Option<Self> {
        wanted.then_some(Self { next: FIRST_SEARCH })
    }

    /// Whether a search is due after so many cycles; if so, the next one comes at twice
    /// that.
    pub(super) fn due(&mut self, cycles: u64) -> bool {
        let due = cycles >= self.next;
        if due {
            self.next = 2 * cycles;
        }
        due
    }
}

impl<K: Kernel> March<'_, K> {
    /// Seeks an attracting orbit next to the trajectory. Where one is found and the
    /// trajectory is seen to approach it, the trajectory is put on it; returned are its
    /// period and how it was found.
    pub(super) fn seek_orbit(&mut self, candidates: &[u32]) -> Result<Option<(u32, String)>, Halt> {
        for &period in candidates {
            self.look_up()?;
            let found = shoot(
                self.model,
                self.kernel,
                &self.norm,
                &self.trajectory,
                period,
                &mut self.workspace,
            );
            // An iterate that diverges or storms is no orbit, and no fault of the point.
            let Ok(Some(orbit)) = found else { continue };
            if orbit.spectral_radius() >= 1.0 {
                continue;
            }
            // The first candidate is the excitation's own period.
            let orbit = shortest(
                self.model,
                self.kernel,
                &self.norm,
                orbit,
                candidates[0],
                &mut self.workspace,
            )?;
            let before = self.counters.cycles;
            let near = approaches(
                self.kernel,
                &self.norm,
                &orbit,
                &mut self.trajectory,
                &mut self.workspace,
                &mut self.counters,
            )?;
            if near {
                let watched = self.counters.cycles - before;
                let how = format!(
                    "orbit found by Newton's method after {before} cycles (residual {:.0e} half gaps), approached as its multipliers predict over {watched} cycles",
                    orbit.residual
                );
                let cycle = self.trajectory.cycle;
                self.trajectory =
                    TrajectoryState::new(self.model, orbit.start.state.clone(), cycle);
                return Ok(Some((orbit.period, how)));
            }
        }
        Ok(None)
    }

    /// Candidate periods at the trajectory's present place.
    pub(super) fn candidates(&self, instruments: &Instruments) -> Vec<u32> {
        instruments
            .recurrence
            .candidates(&self.norm, WORTH_A_SEARCH)
    }

    /// A motion that repeats after `period` cycles: confirms it by its multipliers and
    /// measures it over whole periods. None where a multiplier lies outside the unit circle
    /// (a long stay near an unstable orbit); one on it is a motion that nothing damps.
    pub(super) fn settle(
        &mut self,
        instruments: &mut Instruments,
        period: u32,
        how: &str,
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
        let error_bar = u64::from(CYCLES_PER_AVERAGE) * FEWEST_BLOCKS as u64;
        let wanted = SETTLED_CYCLES
            .max(self.questions.poincare_samples as u64)
            .max(error_bar * u64::from(instruments.twin.is_some()))
            .max(spectral);
        self.measure(instruments, wanted.div_ceil(k) * k)?;
        if let Some(nvh) = &mut instruments.watch.nvh {
            nvh.repeats(period);
        }
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
                format!("repeats every cycle and never leaves contact; {how}")
            }
            Class::Locked => {
                format!("repeats after {period} cycles and never leaves contact; {how}")
            }
            _ => format!(
                "repeats after {period} {} with {events} events in {} cycles; {how}",
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
}
