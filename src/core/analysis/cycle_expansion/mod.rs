//! What are averages over a chaotic set, from its unstable periodic orbits?
//!
//! The trajectory is advanced, orbits up to some period are sought from where it nearly returns
//! ([`census`]), and averages over the set follow from them order by order ([`series`]). Beside
//! them stand averages over as many mesh cycles of the trajectory as the orbits took.

mod census;
mod closing;
mod observables;
mod series;

use super::averages::CYCLES_PER_AVERAGE;
use super::called_off::CalledOff;
use super::lyapunov::TangentGrowth;
use super::norm::EnergyNorm;
use super::recurrence::Recurrence;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::numerics::statistics::{FEWEST_VALUES, mean, standard_error};
use crate::propagate::{Counters, Kernel, Stop};
use census::{Census, Found, Set};
pub use observables::ExpansionQuantity;
use observables::{Cycles, GROWTH, SUMS, Sums};
use serde::{Deserialize, Serialize};
use series::{Order, Prime, expand};
use std::sync::atomic::AtomicBool;

/// The stream of a point that the tangent of the time averages starts with; those below belong to
/// its own tangents, its probes and its twins.
const STREAM: u64 = 1 << 34;

/// Cycles in which that tangent turns into the direction of growth, discarded.
const ALIGN: u64 = 100;

/// How averages over unstable orbits are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ExpansionQuestion {
    /// Longest period of the orbits \[mesh cycles\], the last order of the expansions.
    pub longest: u32,
    /// Most Newton searches for each period.
    pub guesses: u32,
    /// Mesh cycles that guesses are taken from.
    pub cycles: u32,
}

/// A number with its error, where that is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its error.
    pub error: Option<f64>,
}

/// An average over the set by several ways. The error of those by orbits is the change from the
/// order before plus the change where orbits that a single search found are left out; that of the
/// time average is its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExpansionAverage {
    /// Of what.
    pub quantity: ExpansionQuantity,
    /// By the dynamical zeta function.
    pub zeta: Option<Estimate>,
    /// By the spectral determinant.
    pub determinant: Option<Estimate>,
    /// By the sum over the points of one period.
    pub plain: Option<Estimate>,
    /// Over time.
    pub time: Estimate,
}

/// What the orbits of up to a period say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpansionOrder {
    /// The period \[mesh cycles\].
    pub order: u32,
    /// Prime orbits of this very period, all unstable.
    pub orbits: u32,
    /// How many more there may be, by how often each was found.
    pub unseen: f64,
    /// Orbits of this period that the trajectory does not come near, left out.
    pub apart: u32,
    /// Newton searches for this period.
    pub searches: u64,
    /// Those that ended on an orbit.
    pub closed: u64,
    /// Growth rate of the number of points that return \[1/cycle\].
    pub entropy: Option<f64>,
    /// Sum of `1/|det(1 − M)|` over the points of this period: 1 where all are there.
    pub conservation: f64,
    /// Escape rate by the dynamical zeta function \[1/cycle\]: 0 where all orbits are there.
    pub escape_zeta: Option<f64>,
    /// The same by the spectral determinant.
    pub escape_determinant: Option<f64>,
    /// The averages.
    pub averages: Vec<ExpansionAverage>,
}

/// What the orbits of a chaotic set say of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpansionOutcome {
    /// By order.
    pub orders: Vec<ExpansionOrder>,
    /// Mesh cycles of the trajectory that guesses were taken from, and of all Newton searches;
    /// the time averages are over as many.
    pub cycles: u64,
}

/// Why there are no averages over orbits.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ExpansionError {
    /// Nobody waits for them.
    #[error(transparent)]
    CalledOff(#[from] CalledOff),
    /// The trajectory diverged or met an event storm.
    #[error(transparent)]
    Stop(#[from] Stop),
    /// What drives the motion does not repeat soon enough.
    #[error(
        "what drives the motion does not repeat within {longest} mesh cycles; raise \
         analyses.cycle_expansion.longest, or leave out ripples"
    )]
    LongerDrive {
        /// Longest period asked for.
        longest: u32,
    },
}

/// Averages over the unstable orbits of the set that `trajectory` moves on.
///
/// # Errors
/// [`ExpansionError`].
pub fn cycle_expansion<K: Kernel>(
    model: &Model,
    kernel: &K,
    trajectory: &TrajectoryState,
    question: &ExpansionQuestion,
    seed: PointSeed,
    called_off: &AtomicBool,
) -> Result<ExpansionOutcome, ExpansionError> {
    let longest = question.longest;
    // Nothing repeats sooner than what drives it.
    let unit = Recurrence::new(model).excitation();
    let unit = unit.filter(|unit| *unit <= longest);
    let unit = unit.ok_or(ExpansionError::LongerDrive { longest })?;
    let norm = EnergyNorm::new(model);
    let mut trajectory = trajectory.clone();
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    let mut path = vec![trajectory.clone()];
    for _ in 0..question.cycles / unit {
        CalledOff::check(called_off)?;
        let cycles = u64::from(unit);
        kernel.advance(
            cycles,
            &mut trajectory,
            &mut workspace,
            &mut (),
            &mut counters,
        )?;
        path.push(trajectory.clone());
    }
    let set = Set {
        model,
        kernel,
        norm: &norm,
        path: &path,
        unit,
    };
    let census = set.census(
        (longest / unit) as usize,
        question.guesses as usize,
        called_off,
    )?;
    let cycles = counters.cycles + census.cycles;
    let time = TimeAverages::over(
        cycles,
        model,
        kernel,
        &norm,
        &mut trajectory,
        seed,
        called_off,
    )?;
    Ok(ExpansionOutcome {
        orders: orders(&census, unit, &time, model.half_gap),
        cycles,
    })
}

/// What the orbits of a census say at every order.
fn orders(census: &Census, unit: u32, time: &TimeAverages, half_gap: f64) -> Vec<ExpansionOrder> {
    let count = census.efforts.len();
    let by_hits = |least: u64| {
        let known = census.orbits.iter().filter(|o| o.belongs);
        let primes: Vec<Prime<'_>> = known
            .filter(|orbit| orbit.hits >= least)
            .map(|orbit| Prime {
                length: orbit.points.len(),
                multipliers: &orbit.multipliers,
                sums: &orbit.sums,
            })
            .collect();
        expand(&primes, count, SUMS)
    };
    let (all, again) = (by_hits(1), by_hits(2));
    let per_cycle = |rate: f64| rate / f64::from(unit);
    let mut out = Vec::with_capacity(count);
    for (place, order) in all.iter().enumerate() {
        let own = || {
            let own = census.orbits.iter();
            own.filter(move |orbit| orbit.points.len() == place + 1)
        };
        let on = |hits: u64| own().filter(|o| o.belongs && o.hits == hits).count() as f64;
        let (once, twice) = (on(1), on(2));
        let sums =
            |averages: &Vec<f64>| -> Sums { std::array::from_fn(|i| per_cycle(averages[i])) };
        let estimate = |quantity: ExpansionQuantity, of: Way| {
            let value = |order: &Order| Some(quantity.of(&sums(of(order)?), half_gap));
            let found = value(order)?;
            let away = |other: Option<f64>| Some((found - other?).abs());
            let before = place.checked_sub(1).and_then(|before| value(&all[before]));
            let error = away(before).zip(away(value(&again[place])));
            Some(Estimate {
                value: found,
                error: error.map(|(step, missing)| step + missing),
            })
        };
        let averages = ExpansionQuantity::ALL.map(|quantity| ExpansionAverage {
            quantity,
            zeta: estimate(quantity, |order| Some(&order.zeta.as_ref()?.averages)),
            determinant: estimate(quantity, |order| {
                Some(&order.determinant.as_ref()?.averages)
            }),
            plain: estimate(quantity, |order| order.plain.as_ref()),
            time: time.of(quantity, half_gap),
        });
        let effort = census.efforts[place];
        let number = |belongs: bool| own().filter(|o: &&Found| o.belongs == belongs).count() as u32;
        out.push(ExpansionOrder {
            order: unit * (place as u32 + 1),
            orbits: number(true),
            unseen: 0.5 * once * (once - 1.0).max(0.0) / (twice + 1.0),
            apart: number(false),
            searches: effort.searches,
            closed: effort.closed,
            entropy: order.entropy.map(per_cycle),
            conservation: order.conservation,
            escape_zeta: order.zeta.as_ref().map(|r| per_cycle(r.escape)),
            escape_determinant: order.determinant.as_ref().map(|r| per_cycle(r.escape)),
            averages: averages.to_vec(),
        });
    }
    out
}

/// One of the ways to an average: its averages per iteration at an order.
type Way = fn(&Order) -> Option<&Vec<f64>>;

/// Averages over a stretch of trajectory.
struct TimeAverages {
    /// Averages over successive stretches of [`CYCLES_PER_AVERAGE`] mesh cycles.
    stretches: Vec<Sums>,
}

impl TimeAverages {
    /// Averages over so many mesh cycles from where `trajectory` stands, a tangent beside it; over
    /// as many as an error bar takes where that is more.
    fn over<K: Kernel>(
        cycles: u64,
        model: &Model,
        kernel: &K,
        norm: &EnergyNorm,
        trajectory: &mut TrajectoryState,
        seed: PointSeed,
        called_off: &AtomicBool,
    ) -> Result<Self, ExpansionError> {
        let mut workspace = kernel.workspace();
        let mut counters = Counters::default();
        let mut growth = TangentGrowth::new(norm, model.modes(), 1, &mut seed.stream(STREAM));
        let mut watch = Cycles::new(model);
        let mut advance = |growth: &mut TangentGrowth| -> Result<Sums, ExpansionError> {
            CalledOff::check(called_off)?;
            let tangents = growth.tangents();
            kernel.advance_cycle(
                trajectory,
                tangents,
                &mut workspace,
                &mut watch,
                &mut counters,
            )?;
            let mut sums = watch.close();
            sums[GROWTH] = growth.cycle(norm);
            Ok(sums)
        };
        for _ in 0..ALIGN {
            advance(&mut growth)?;
        }
        let length = u64::from(CYCLES_PER_AVERAGE);
        let count = cycles.div_ceil(length).max(FEWEST_VALUES as u64);
        let mut stretches = Vec::with_capacity(count as usize);
        for _ in 0..count {
            let mut average = [0.0; SUMS];
            for _ in 0..length {
                for (sum, x) in average.iter_mut().zip(advance(&mut growth)?) {
                    *sum += x / length as f64;
                }
            }
            stretches.push(average);
        }
        Ok(Self { stretches })
    }

    /// A quantity's average and its standard error.
    fn of(&self, quantity: ExpansionQuantity, half_gap: f64) -> Estimate {
        let column = |i: usize| -> Vec<f64> { self.stretches.iter().map(|s| s[i]).collect() };
        let about: Sums = std::array::from_fn(|i| mean(&column(i)));
        let linear: Vec<f64> = (self.stretches.iter())
            .map(|sums| quantity.linear(sums, &about, half_gap))
            .collect();
        Estimate {
            value: quantity.of(&about, half_gap),
            error: Some(standard_error(&linear)),
        }
    }
}
