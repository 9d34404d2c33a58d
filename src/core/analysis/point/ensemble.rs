//! The measurement of a motion that does not become periodic, with an ensemble of trajectories.

use super::instruments::{Instruments, Record};
use super::looks::LookResult;
use super::members::{Ending, EnsembleTrajectory, is_chaotic};
use super::plan::Plan;
use super::run::{Interruption, PointRun};
use super::settle::{OrbitSearchTimes, cycles};
use crate::analysis::classify::{Evidence, Verdict, classify};
use crate::analysis::config::Effort;
use crate::analysis::convergence::convergence;
use crate::analysis::dimension::kaplan_yorke;
use crate::analysis::evidence::{ChaosAverages, ChaosOutcome, EvidenceOutcome, GrowthRecord};
use crate::analysis::outcome::{
    Class, LyapunovMethod, LyapunovOutcome, NvhStatistics, PointOutcome, Status,
};
use crate::analysis::torus::{self, Torus};
use crate::analysis::twin::Twin;
use crate::numerics::statistics::{mean, standard_error};
use crate::propagate::Kernel;
use std::f64::consts::TAU;

/// The cycles of each of several trajectories are a multiple of this number, so that their averages are
/// complete.
const CYCLE_MULTIPLE: u64 = 100;

/// Measured cycles for the statistics of a torus that a trajectory reached from chaos.
const ON_TORUS: u64 = 2_000;

impl<K: Kernel> PointRun<'_, K> {
    /// Measures a motion that has not settled, until it settles or enough is known.
    pub(super) fn unsettled(
        &mut self,
        searches: Option<OrbitSearchTimes>,
    ) -> Result<PointOutcome, Interruption> {
        let plan = Plan::of(self.config);
        let instruments = self.align()?;
        let pilot =
            EnsembleTrajectory::pilot(self.trajectory.clone(), instruments, searches, &plan);
        let mut members = vec![pilot];
        if plan.trajectories > 1 {
            self.pilot_and_branches(&mut members, &plan)?;
        }
        let mut next = plan.first;
        loop {
            let share = share(&members, next, plan.budget);
            for member in members.iter_mut() {
                self.follow(member, share, &plan)?;
            }
            let spent: u64 = members.iter().map(EnsembleTrajectory::measured).sum();
            let staying = self.staying(&members).count() as u64;
            let over = staying == 0 || spent + staying * unit(&members) > plan.budget;
            let unsettled: u64 = members
                .iter()
                .map(EnsembleTrajectory::unsettled_cycles)
                .sum();
            if !over && unsettled < next {
                continue;
            }
            let look = match staying {
                0 => LookResult::default(),
                _ => self.look_at(&members),
            };
            if over || look.can_stop || look.futile {
                return self.conclude(members, &look);
            }
            if look.statistics_enough {
                (members.iter_mut()).for_each(|m| m.instruments.record.watch.enough = true);
            }
            next *= 2;
        }
    }

    /// Measures the pilot alone until its neighbours separate exponentially, and then starts branches from it.
    fn pilot_and_branches(
        &mut self,
        members: &mut Vec<EnsembleTrajectory>,
        plan: &Plan,
    ) -> Result<(), Interruption> {
        let pilot = &mut members[0];
        let mut until = plan.branching();
        loop {
            self.follow(pilot, until.min(plan.budget), plan)?;
            if pilot.is_chaotic() {
                let branches = self.branch_off(pilot, plan)?;
                members.extend(branches);
                return Ok(());
            }
            if pilot.ending.is_some() || until >= plan.budget {
                return Ok(());
            }
            until *= 2;
        }
    }

    /// The trajectories that have not left the motion. Without exponents, the time at which a trajectory left
    /// is unknown. The list is then empty if any trajectory left.
    fn staying<'m>(
        &self,
        members: &'m [EnsembleTrajectory],
    ) -> impl Iterator<Item = &'m EnsembleTrajectory> + use<'m, K> {
        let blind = self.config.lyapunov.is_none();
        let left = blind && members.iter().any(|member| member.ending.is_some());
        (members.iter()).filter(move |member| !left && member.ending.is_none())
    }

    /// Evaluates the records of all trajectories for a look at the error bars.
    fn look_at(&self, members: &[EnsembleTrajectory]) -> LookResult {
        let parts: Vec<&Record> = members.iter().map(EnsembleTrajectory::unsettled).collect();
        let staying: Vec<&Record> = self
            .staying(members)
            .map(EnsembleTrajectory::unsettled)
            .collect();
        let exits = members.len() - staying.len();
        self.look(&joined(&parts), &staying, exits)
    }

    /// Computes all results of the point from the ensemble.
    fn conclude(
        &mut self,
        mut members: Vec<EnsembleTrajectory>,
        look: &LookResult,
    ) -> Result<PointOutcome, Interruption> {
        let parts: Vec<&Record> = members.iter().map(EnsembleTrajectory::unsettled).collect();
        let mut all = joined(&parts);
        let chaotic = (all.averages())
            .is_some_and(|averages| is_chaotic(averages.values(), averages.stretch()));
        let parted = Plan::of(self.config).part * (members.len() as u64 - 1);
        let chaos = chaotic.then(|| chaos(&members, parted));
        let chains = self.config.lyapunov.filter(|config| config.chains);
        let evidence = EvidenceOutcome {
            trajectories: members.len() as u32,
            verified: look.unverified.is_none(),
            correlation_cycles: look.memory.filter(|memory| memory.is_finite()),
            ess: look.ess,
            rhat: look.rhat,
            rotation_number: None,
            chains: chains.map(|_| growth_record(&parts)),
        };
        if let Some(member) = self.staying(&members).next() {
            self.trajectory = member.trajectory.clone();
            let verdict = self.verdict(&all, &member.instruments, look, chaos.as_ref());
            let lyapunov = self.lyapunov_of(&all, verdict.class, None);
            let mut outcome = self.outcome(
                verdict.status,
                verdict.reason,
                verdict.class,
                lyapunov,
                &mut all,
            );
            outcome.evidence = Some(evidence);
            outcome.chaos = chaos.filter(|_| outcome.class.is_some_and(|class| class.is_chaos()));
            return Ok(outcome);
        }
        let place = most_frequent(&members);
        let member = members.swap_remove(place);
        self.trajectory = member.trajectory;
        let mut outcome = match member.ending {
            Some(Ending::Settled(outcome)) => *outcome,
            Some(Ending::Torus(found)) => {
                let mut instruments = member.instruments;
                if chaotic {
                    instruments = self.align()?;
                    self.measure(&mut instruments, ON_TORUS)?;
                }
                self.on_torus(&mut instruments, found, evidence)
            }
            None => unreachable!("every trajectory has left the motion"),
        };
        outcome.cycles = self.counters.cycles;
        outcome.grazing_count = self.counters.grazings;
        if let Some(mut chaos) = chaos {
            outcome.reason += &format!("; {}", before(&chaos));
            chaos.averages_before_exit = chaos_averages(&all);
            outcome.chaos = Some(chaos);
        }
        Ok(outcome)
    }

    /// The verdict on a motion that some trajectories have not left.
    fn verdict(
        &self,
        all: &Record,
        last: &Instruments,
        look: &LookResult,
        chaos: Option<&ChaosOutcome>,
    ) -> Verdict {
        let growth = all.averages();
        let mut verdict = classify(&Evidence {
            averages: growth.map_or(&[], |averages| averages.values()),
            stretch: growth.map_or(1, |averages| averages.stretch()),
            aligned: self.config.lyapunov.map_or(0, |l| l.align),
            strobe: last.record.strobe.values(),
            closest_return: last.recurrence.closest_return(&self.norm),
            longest_period: last.recurrence.longest(),
            excitation_repeats: last.recurrence.excitation_repeats(),
            torus_is_possible: torus::is_possible(self.model, &self.norm),
            events: all.events,
            touched_throughout: all.events == 0 && self.model.touches(self.trajectory.contact),
            rhat: look.rhat,
            integrated: self.counters.cycles,
            measured: all.measured,
            slow_mode: self.slow_mode(all.measured),
        });
        if verdict.class == Some(Class::Chaotic)
            && let Some(chaos) = chaos
        {
            verdict.reason += &format!("; {}", life(chaos));
            if chaos.exits > 0 {
                verdict.class = Some(Class::TransientChaos);
            }
        }
        let missed = if verdict.class.is_some_and(|class| class.is_chaos()) {
            let survey = self.config.effort() == Effort::Survey;
            let unverified = look.unverified.as_ref().filter(|_| !survey);
            look.missed.as_ref().or(unverified)
        } else if verdict.class == Some(Class::NotConverged) {
            look.missed.as_ref().filter(|_| look.futile)
        } else {
            look.statistics_missed.as_ref()
        };
        if matches!(verdict.status, Status::Ok | Status::NotConverged)
            && let Some(missed) = missed
        {
            verdict.status = Status::NotConverged;
            verdict.reason += &format!("; {missed}");
        }
        verdict
    }

    /// All results of a trajectory on a torus.
    fn on_torus(
        &mut self,
        instruments: &mut Instruments,
        torus: Torus,
        evidence: EvidenceOutcome,
    ) -> PointOutcome {
        let record = &mut instruments.record;
        let class = Some(Class::QuasiPeriodic);
        let lyapunov = self.lyapunov_of(record, class, Some(torus));
        let reason = format!(
            "the weighted averages of growth are zero: λ = {:.1e} ± {:.1e} per cycle; the deflection has equal \
             averages over both parts of the second half of the record",
            torus.lambda, torus.error
        );
        let mut outcome = self.outcome(Status::Ok, reason, class, lyapunov, record);
        outcome.evidence = Some(EvidenceOutcome {
            trajectories: 1,
            verified: true,
            rotation_number: torus.rotation,
            ..evidence
        });
        outcome
    }

    /// The exponents of a record.
    fn lyapunov_of(
        &self,
        all: &Record,
        class: Option<Class>,
        torus: Option<Torus>,
    ) -> Option<LyapunovOutcome> {
        let growth = all.growth.as_ref()?;
        let mut exponents = growth.exponents()?;
        let series = growth.series();
        let mut errors: Vec<f64> = series.iter().map(|s| standard_error(s)).collect();
        if let Some(torus) = torus {
            exponents[0] = torus.lambda;
            errors[0] = torus.error;
        }
        // On a torus, exponents are 0 within the accuracy of their averages.
        let zero = if class == Some(Class::QuasiPeriodic) {
            2.0 * errors[0] + 5.0 / all.measured as f64
        } else {
            0.0
        };
        let dimension = kaplan_yorke(&series, &exponents, zero, self.growth_norm.dimension());
        // Exponents of −∞ are the smallest, and are omitted.
        let lost = |exponent: &f64| *exponent == f64::NEG_INFINITY;
        let kept_count = exponents
            .iter()
            .position(lost)
            .map_or(series.len(), |count| count.max(1));
        exponents.truncate(kept_count);
        errors.truncate(kept_count);
        let twin = all.twin.as_ref().map(Twin::excess);
        Some(LyapunovOutcome {
            dimension,
            twin: twin.map(|[excess, _]| exponents[0] + excess),
            twin_stderr: twin.map(|[_, error]| error.hypot(errors[0])),
            twin_agrees: all.twin.as_ref().and_then(Twin::agrees),
            method: match torus {
                Some(_) => LyapunovMethod::Birkhoff,
                None => LyapunovMethod::Tangent,
            },
            convergence: (self.config.lyapunov).and_then(|config| {
                convergence(
                    &series[..kept_count],
                    growth.averages().stretch(),
                    config.course,
                )
            }),
            exponents,
            errors,
        })
    }

    /// The slowest mode with a frequency, counted from 1, and its period in mesh cycles, if that exceeds
    /// `cycles`. `None` if modes are coupled, so that blocks are not modes.
    fn slow_mode(&self, cycles: u64) -> Option<(usize, f64)> {
        if self.model.basis.coupled().is_some() {
            return None;
        }
        let turn = |mode: usize| {
            let frequency = self.model.blocks[mode].natural_frequency();
            TAU / (frequency * self.model.period())
        };
        (0..self.model.modes())
            .map(|mode| (mode + 1, turn(mode)))
            .filter(|(_, turn)| turn.is_finite() && *turn > cycles as f64)
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// The number of which the cycles of each trajectory are a multiple.
fn unit(members: &[EnsembleTrajectory]) -> u64 {
    match members.len() {
        1 => 1,
        _ => CYCLE_MULTIPLE,
    }
}

/// Measured cycles that each trajectory still on the motion should have. All trajectories together then have
/// `wanted` cycles of the motion, within the budget.
fn share(members: &[EnsembleTrajectory], wanted: u64, budget: u64) -> u64 {
    let faded: u64 = (members.iter())
        .map(|member| member.measured() - member.unsettled_cycles())
        .sum();
    let total = wanted.min(budget.saturating_sub(faded));
    let unit = unit(members);
    let (left, alive): (Vec<_>, Vec<_>) = members.iter().partition(|m| m.ending.is_some());
    let mut fixed: u64 = left.iter().map(|m| m.unsettled_cycles()).sum();
    let mut lengths: Vec<u64> = alive.iter().map(|m| m.measured()).collect();
    lengths.sort_unstable();
    // If a trajectory already exceeds its share, the others get fewer cycles.
    while let Some(longest) = lengths.last() {
        let even = total.saturating_sub(fixed).div_ceil(lengths.len() as u64);
        if *longest <= even {
            // At a look, the number is rounded up, but never beyond the budget.
            return if total + unit * members.len() as u64 <= budget {
                even.next_multiple_of(unit)
            } else {
                total.saturating_sub(fixed) / lengths.len() as u64 / unit * unit
            };
        }
        fixed += longest;
        lengths.pop();
    }
    0
}

/// Records of several trajectories, one after another.
fn joined(parts: &[&Record]) -> Record {
    let mut all = parts[0].clone();
    for part in &parts[1..] {
        all.append(part);
    }
    all
}

/// Life of chaos over all trajectories, and the motions on which they ended. The branches together spent
/// `parted` cycles in chaos before their measurement.
fn chaos(members: &[EnsembleTrajectory], parted: u64) -> ChaosOutcome {
    let mut endings: Vec<(String, u32)> = Vec::new();
    for name in members.iter().filter_map(ending) {
        match endings.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => endings.push((name, 1)),
        }
    }
    endings.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let text: Vec<String> = (endings.iter())
        .map(|(name, count)| format!("{name} ({count})"))
        .collect();
    ChaosOutcome {
        cycles: members
            .iter()
            .map(EnsembleTrajectory::unsettled_cycles)
            .sum::<u64>()
            + parted,
        exits: endings.iter().map(|(_, count)| count).sum(),
        trajectories: members.len() as u32,
        ended_on: (!text.is_empty()).then(|| text.join(", ")),
        averages_before_exit: None,
    }
}

/// The motion on which a trajectory ended, by class and period.
fn ending(member: &EnsembleTrajectory) -> Option<String> {
    let class = match member.ending.as_ref()? {
        Ending::Settled(outcome) => outcome.class?,
        Ending::Torus(_) => Class::QuasiPeriodic,
    };
    Some(match class.period() {
        Some(period) => format!("{} {period}", class.name()),
        None => class.name().to_owned(),
    })
}

/// Index of the first trajectory with the most frequent ending.
fn most_frequent(members: &[EnsembleTrajectory]) -> usize {
    let names: Vec<Option<String>> = members.iter().map(ending).collect();
    let count = |name: &Option<String>| names.iter().filter(|other| *other == name).count();
    let ended = || names.iter().filter(|name| name.is_some());
    let most = ended().map(count).max();
    (names
        .iter()
        .position(|name| name.is_some() && Some(count(name)) == most))
    .unwrap_or(0)
}

/// A text on the life of chaos, if some trajectories have not left it.
fn life(chaos: &ChaosOutcome) -> String {
    let (low, high) = chaos.interval();
    match (chaos.lifetime(), high, &chaos.ended_on) {
        (Some(lifetime), Some(high), Some(ended_on)) => format!(
            "{} of {} trajectories left chaos within {} and ended on {ended_on}; its mean life is \
             {lifetime:.0} cycles ({low:.0} to {high:.0})",
            chaos.exits,
            chaos.trajectories,
            cycles(chaos.cycles)
        ),
        _ => format!(
            "no trajectory left chaos within {}; its mean life is at least {low:.0} cycles (95 %)",
            cycles(chaos.cycles)
        ),
    }
}

/// A text on the life of chaos, if every trajectory left it.
fn before(chaos: &ChaosOutcome) -> String {
    let (low, high) = chaos.interval();
    let lifetime = chaos.lifetime().unwrap_or(f64::NAN);
    let who = match chaos.trajectories {
        1 => "the trajectory left chaos".to_owned(),
        all => format!("all {all} trajectories left chaos"),
    };
    format!(
        "{who}; its mean life is {lifetime:.0} cycles ({low:.0} to {:.0})",
        high.unwrap_or(f64::INFINITY)
    )
}

/// Averages over chaos, if every trajectory left it.
fn chaos_averages(all: &Record) -> Option<ChaosAverages> {
    let averages = all.averages()?.values();
    let nvh = all.watch.statistics();
    let pair = |of: fn(&NvhStatistics) -> f64| {
        let outcome = nvh.as_ref()?;
        Some([of(&outcome.values), of(outcome.stderr.as_ref()?)])
    };
    Some(ChaosAverages {
        lambda: [mean(averages), standard_error(averages)],
        deflection_rms: pair(|of| of.deflection_rms),
        force_std: pair(|of| of.force_std),
        impact_velocity: pair(|of| of.impact_velocity),
    })
}

/// Averages of growth, trajectory after trajectory.
fn growth_record(parts: &[&Record]) -> GrowthRecord {
    let chains = parts.iter().filter_map(|part| part.averages());
    let chains: Vec<&[f64]> = chains.map(|averages| averages.values()).collect();
    GrowthRecord {
        lengths: chains.iter().map(|chain| chain.len() as f64).collect(),
        growth: chains.concat(),
    }
}
