//! The search for periodic motions: early by Newton's method, or later by waiting until they repeat.

use super::instruments::Instruments;
use super::run::{Interruption, PointRun};
use crate::analysis::config::PointConfig;
use crate::analysis::interrupt::Interrupted;
use crate::analysis::orbits::attracting::{Approach, Attracting, attracting};
use crate::analysis::orbits::floquet::{exponents, monodromy};
use crate::analysis::orbits::shooting::PeriodicOrbit;
use crate::analysis::orbits::twins;
use crate::analysis::outcome::{
    Class, KaplanYorke, LyapunovMethod, LyapunovOutcome, PointOutcome, Status,
};
use crate::analysis::recurrence::excitation_period;
use crate::analysis::spectrum::{Lines, Spectra};
use crate::model::TrajectoryState;
use crate::numerics::linalg::{EigenPair, eigenpair, eigenvalues};
use crate::numerics::product_moduli::{Logarithm, logarithms, round_off};
use crate::propagate::{Counters, Kernel};
use faer::Mat;
use num_complex::Complex64;

/// Exponent per cycle, of either sign, that counts as zero for a periodic motion. Round-off splits a double
/// multiplier 1 (free flight) by about the square root of the round-off.
const NEUTRAL: f64 = 1e-7;

/// Return distance, in half gaps, below which a Newton search is worth its time.
pub(super) const WORTH_A_SEARCH: f64 = 0.3;

/// Number of cycles before the first search. Each later search follows when the number has doubled, so that a
/// chaotic point spends little time on searches.
pub(super) const FIRST_SEARCH: u64 = 100;

/// When the next search for an orbit is due.
#[derive(Debug, Clone, Copy)]
pub(super) struct OrbitSearchTimes {
    next: u64,
}

impl OrbitSearchTimes {
    /// `None` if no orbits are sought.
    pub(super) fn new(wanted: bool) -> Option<Self> {
        wanted.then_some(Self { next: FIRST_SEARCH })
    }

    /// Whether a search is due after `cycles`; if so, the next one follows at twice that.
    pub(super) fn due(&mut self, cycles: u64) -> bool {
        let due = cycles >= self.next;
        if due {
            self.next = 2 * cycles;
        }
        due
    }
}

/// A periodic motion on which the trajectory lies.
#[derive(Debug)]
pub(super) struct PeriodicMotion {
    /// Period in mesh cycles.
    pub(super) period: u32,
    /// How the motion was found.
    pub(super) how: String,
    /// The linearised map of a period from the trajectory's state, if the search computed it.
    pub(super) turn: Option<PeriodMap>,
}

/// The linearised map of a period.
#[derive(Debug)]
pub(super) struct PeriodMap {
    monodromy: Mat<f64>,
    multipliers: Vec<Complex64>,
    /// Events in the period.
    events: u64,
}

/// Round-off of the map of a period, relative to a multiplier, above which the maps of its cycles are
/// evaluated one by one.
const LARGEST_ROUND_OFF: f64 = 1e-9;

impl<K: Kernel> PointRun<'_, K> {
    /// Searches for an attracting orbit near the trajectory with one of the periods `candidates`. If the
    /// trajectory approaches one, it is put on this orbit.
    pub(super) fn seek_orbit(
        &mut self,
        candidates: &[u32],
    ) -> Result<Option<PeriodicMotion>, Interruption> {
        let unit = excitation_period(self.model).unwrap_or(1) as u32;
        for &period in candidates {
            Interrupted::check(self.interrupt)?;
            let before = self.counters.cycles;
            let orbit = attracting(
                self.model,
                self.kernel,
                &self.norm,
                &mut self.trajectory,
                [period, unit],
                &mut self.workspace,
                &mut self.counters,
            )?;
            if let Some(orbit) = orbit {
                return Ok(Some(self.move_to_orbit(orbit, before)));
            }
        }
        Ok(None)
    }

    /// Puts the trajectory on an orbit that it approached; `before` counts the cycles before the search.
    pub(super) fn move_to_orbit(&mut self, attracting: Attracting, before: u64) -> PeriodicMotion {
        let Attracting {
            orbit,
            doubled,
            approach,
        } = attracting;
        let from = if doubled { " from near the unstable orbit of half its period" } else { "" };
        let observed_cycles = self.counters.cycles - before;
        let approached = match approach {
            Approach::AsPredicted => {
                format!("approached{from} as its multipliers predict over {observed_cycles} cycles")
            }
            Approach::AlongALine => format!(
                "approached{from} along its slowest direction, and near it as its multipliers predict over {observed_cycles} cycles"
            ),
            Approach::InContact => {
                format!(
                    "contact certain to last until the orbit after {observed_cycles} more cycles"
                )
            }
        };
        let how = format!(
            "orbit found by Newton's method after {before} cycles (residual {:.0e} half gaps), {approached}",
            orbit.residual
        );
        let cycle = self.trajectory.cycle;
        let PeriodicOrbit {
            start,
            period,
            monodromy,
            multipliers,
            events,
            ..
        } = orbit;
        self.trajectory = TrajectoryState::new(self.model, start.state, cycle);
        PeriodicMotion {
            period,
            how,
            turn: Some(PeriodMap {
                monodromy,
                multipliers,
                events,
            }),
        }
    }

    /// Confirms a periodic motion by its multipliers and measures one period, which describes it completely.
    /// `None` if the multipliers cannot be computed, or if one lies outside the unit circle (a long stay near an
    /// unstable orbit). A multiplier on the circle shows an undamped motion.
    pub(super) fn settle(
        &mut self,
        motion: PeriodicMotion,
    ) -> Result<Option<PointOutcome>, Interruption> {
        let PeriodicMotion { period, how, turn } = motion;
        let start = self.trajectory.clone();
        let mut end = start.clone();
        let Some(turn) = (match turn {
            Some(turn) => {
                match turn.events {
                    // While contact lasts, the maps do not depend on the state.
                    0 => end.cycle += u64::from(period),
                    _ => self.go_round(&mut end, period)?,
                }
                Some(turn)
            }
            None => self.turn(&mut end, period)?,
        }) else {
            return Ok(None);
        };
        let (first, leading) = (&turn.monodromy, turn.multipliers.first());
        let leading = leading.copied().unwrap_or(f64::NAN.into());
        let Some(exponents) = self.exponents(&turn, &mut end, period)? else {
            return Ok(None);
        };
        let largest = exponents
            .first()
            .map_or(f64::NAN, |exponent| exponent.value);
        if largest.is_nan() || largest > NEUTRAL {
            return Ok(None);
        }
        let lyapunov = match self.config.lyapunov {
            Some(config) => {
                // A multiplier within round-off has no direction.
                let is_resolved = round_off(first, leading.norm()) <= LARGEST_ROUND_OFF;
                let direction = if config.twin && is_resolved {
                    eigenpair(first.as_ref(), leading)
                } else {
                    None
                };
                Some(self.multiplier_outcome(&start, period, &exponents, direction)?)
            }
            None => None,
        };
        if self.energy_residual.is_none() {
            self.audit(u64::from(period))?;
        }
        let mut instruments = self.measure_period(period)?;
        let record = &mut instruments.record;
        let events = record.events;
        let class = if events == 0 && self.model.touches(self.trajectory.contact) {
            Class::SteadyContact(Some(period))
        } else {
            Class::Periodic(period)
        };
        let reason = match class {
            Class::SteadyContact(_) if period == 1 => {
                format!("repeats every cycle and never leaves contact; {how}")
            }
            Class::SteadyContact(_) => {
                format!("repeats after {period} cycles and never leaves contact; {how}")
            }
            _ => format!(
                "repeats after {} with {events} events in {}; {how}",
                cycles(period.into()),
                cycles(record.measured)
            ),
        };
        Ok(Some(self.outcome(
            Status::Ok,
            reason,
            Some(class),
            lyapunov,
            record,
        )))
    }

    /// Exponents of an orbit from its multipliers, and from a twin that starts along an eigenvector.
    fn multiplier_outcome(
        &mut self,
        start: &TrajectoryState,
        period: u32,
        exponents: &[Logarithm],
        direction: Option<EigenPair>,
    ) -> Result<LyapunovOutcome, Interruption> {
        let twin = match direction {
            Some(pair) => twins::leading_exponent(
                self.model,
                self.kernel,
                &self.norm,
                start,
                period,
                &pair.vector,
                &mut self.workspace,
            )?,
            None => None,
        };
        let largest = exponents
            .first()
            .map_or(f64::NAN, |exponent| exponent.value);
        // Exponents within round-off are the smallest, and are omitted.
        let known = exponents
            .iter()
            .take_while(|exponent| exponent.error.is_finite());
        let (exponents, errors) = known
            .map(|exponent| (exponent.value, exponent.error))
            .unzip();
        Ok(LyapunovOutcome {
            exponents,
            errors,
            // States that converge to a periodic orbit end on a finite number of points, whose dimension is
            // 0.
            dimension: (largest < -NEUTRAL).then_some(KaplanYorke {
                value: 0.0,
                stderr: 0.0,
            }),
            twin: twin.map(|t| t.exponent),
            twin_stderr: twin.map(|t| t.error),
            twin_agrees: twin.map(|t| t.agrees),
            method: LyapunovMethod::Multipliers,
            convergence: None,
        })
    }

    /// Measures one period of a periodic motion.
    fn measure_period(&mut self, period: u32) -> Result<Instruments, Interruption> {
        // The multipliers give the exponents, so tangents and twin are not needed.
        let config = PointConfig {
            lyapunov: None,
            ..self.config.clone()
        };
        let mut instruments = Instruments::new(self.model, &self.norm, &config, &self.trajectory);
        let k = u64::from(period);
        if instruments.record.watch.poincare.needs_windows() {
            // Extremes and crossings at the start of the period are detected from the cycles before it.
            for _ in 0..k {
                self.plain_cycle(&mut instruments.record.watch.poincare)?;
            }
        }
        instruments.restart();
        if let Some(all) = self.config.nvh
            && let Some(config) = all.spectrum
        {
            let lines = Lines::new(self.model, &config, all.computed(), period);
            instruments.record.watch.spectra = Some(Spectra::Lines(lines));
        }
        self.measure(&mut instruments, k)?;
        let record = &mut instruments.record;
        if let Some(nvh) = &mut record.watch.nvh {
            nvh.repeats(period);
        }
        if let Some(power) = &mut record.watch.power {
            power.repeats();
        }
        if let Some(orders) = &mut record.watch.orders {
            orders.repeats(period);
        }
        Ok(instruments)
    }

    /// The requested exponents (at least one) of an orbit with this map of a period, largest first, with
    /// their errors; `None` if their iteration fails. `at` is on the orbit at the start of a period, and is
    /// advanced by whole periods.
    fn exponents(
        &mut self,
        turn: &PeriodMap,
        at: &mut TrajectoryState,
        period: u32,
    ) -> Result<Option<Vec<Logarithm>>, Interruption> {
        let (monodromy, multipliers) = (&turn.monodromy, &turn.multipliers);
        let count = self.config.lyapunov.map_or(1, |l| l.exponents.max(1));
        // A second, independent period along the orbit shows the error of the first. While contact lasts it
        // does not, because the map of a period has the same bits each time.
        let second = match turn.events {
            0 => monodromy.clone(),
            _ => self.monodromy(at, period, &mut Counters::default())?,
        };
        let again = match (count, multipliers.first()) {
            (1, Some(leading)) => eigenpair(second.as_ref(), *leading).map(|pair| vec![pair.value]),
            _ => eigenvalues(second.as_ref()),
        };
        let blurs: Vec<f64> = (multipliers.iter().take(count))
            .map(|multiplier| round_off(monodromy, multiplier.norm()))
            .collect();
        let blurred = |blur: &f64| blur.is_nan() || *blur > LARGEST_ROUND_OFF;
        let Some(again) = again.or_else(|| blurs.first().is_some_and(blurred).then(Vec::new))
        else {
            return Ok(None);
        };
        let again = exponents(&again, period);
        let cycles = f64::from(period);
        let mut found: Vec<Logarithm> = exponents(multipliers, period)
            .into_iter()
            .zip(&blurs)
            .enumerate()
            .map(|(i, (value, blur))| {
                let round_off = Logarithm::blurred(1.0, *blur).error / cycles;
                let apart = again.get(i).map_or(0.0, |again| (value - again).abs());
                Logarithm {
                    value,
                    error: round_off.max(apart),
                }
            })
            .collect();
        if period > 1 && blurs.iter().any(blurred) {
            let mut maps = Vec::with_capacity(period as usize);
            for _ in 0..period {
                maps.push(self.monodromy(at, 1, &mut Counters::default())?);
            }
            let apart = logarithms(&maps, count, LARGEST_ROUND_OFF).unwrap_or_default();
            for ((logarithm, blur), apart) in found.iter_mut().zip(&blurs).zip(apart) {
                if blurred(blur) {
                    *logarithm = Logarithm {
                        value: apart.value / cycles,
                        error: apart.error / cycles,
                    };
                }
            }
        }
        Ok(Some(found))
    }

    /// The linearised map of a period from `start`, which is advanced by it; `None` if its multipliers cannot
    /// be computed.
    fn turn(
        &mut self,
        start: &mut TrajectoryState,
        period: u32,
    ) -> Result<Option<PeriodMap>, Interruption> {
        let mut counters = Counters::default();
        let monodromy = self.monodromy(start, period, &mut counters)?;
        Ok(
            eigenvalues(monodromy.as_ref()).map(|multipliers| PeriodMap {
                monodromy,
                multipliers,
                events: counters.events,
            }),
        )
    }

    /// The monodromy matrix of a period from `start`, which is advanced by it.
    fn monodromy(
        &mut self,
        start: &mut TrajectoryState,
        period: u32,
        counters: &mut Counters,
    ) -> Result<Mat<f64>, Interruption> {
        Ok(monodromy(
            self.model,
            self.kernel,
            &self.norm,
            start,
            period,
            &mut self.workspace,
            counters,
        )?)
    }

    /// Advances a state by a period, without counting.
    fn go_round(&mut self, state: &mut TrajectoryState, period: u32) -> Result<(), Interruption> {
        self.kernel.advance(
            u64::from(period),
            state,
            &mut self.workspace,
            &mut (),
            &mut Counters::default(),
        )?;
        Ok(())
    }
}

/// A number of cycles in words.
pub(super) fn cycles(number: u64) -> String {
    format!("{number} {}", if number == 1 { "cycle" } else { "cycles" })
}
