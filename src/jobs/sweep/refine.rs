//! Which points does a refined plane take: where do corners of its cells differ?
//!
//! Points are asked for in rounds, the undivided grid first. Once all of a round are known, every
//! cell is divided, all at the same time, of whose corners, or of the points that smaller neighbours
//! have in the middle of its edges, two differ; and every cell beside which one lies of less than
//! half its side. A change that leaves a divided cell through an edge is so followed into the next,
//! however large that was. The points of a round follow from the results of those before alone, not
//! from when they were computed: a journal is learnt first, and the rounds pass over what it holds.
//!
//! Two motions without a verdict that repeats (chaotic, quasi-periodic, and what has not settled)
//! differ only where both are known; a long period is quasi-periodic for all that a map shows. A
//! point without any motion, failed for instance, is compared with nothing.

use crate::analysis::{Class, NvhErrors, NvhOutcome};
use crate::manifest::{Criterion, Refine};
use crate::numerics::nested_grid::{Cell, NestedGrid};
use crate::store::PointRow;
use std::collections::{BTreeSet, HashMap};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Standard errors of their difference that two numbers may differ by.
const SIGMAS: f64 = 5.0;

/// What a point is compared by.
#[derive(Debug, Clone, PartialEq)]
struct Mark {
    /// None where nothing is known of the motion.
    class: Option<Class>,
    /// Value and standard error of every number that is compared.
    numbers: Vec<Option<[f64; 2]>>,
}

/// A plane on its way.
#[derive(Debug)]
pub(super) struct Refinement {
    nested: NestedGrid,
    by: Vec<Criterion>,
    tolerance: f64,
    longest_period: u32,
    /// What is known, also of points that are not asked for yet.
    marks: HashMap<u64, Mark>,
    asked: BTreeSet<u64>,
    /// The largest differences that count as none, of every number; known with the first round.
    allowed: Vec<f64>,
}

impl Refinement {
    /// A plane of which nothing is known and nothing was asked for.
    pub fn new(refine: &Refine) -> Self {
        Self {
            nested: refine.nested,
            by: refine.by.clone(),
            tolerance: refine.tolerance,
            longest_period: refine.longest_period,
            marks: HashMap::new(),
            asked: BTreeSet::new(),
            allowed: Vec::new(),
        }
    }

    /// Takes note of a point.
    pub fn learn(&mut self, row: &PointRow) {
        let numbers = self.by.iter().filter(|criterion| criterion.is_number());
        let mark = Mark {
            class: row.outcome.class.map(|class| match class {
                Class::Periodic(period) if period > self.longest_period => Class::QuasiPeriodic,
                class => class,
            }),
            numbers: numbers.map(|&criterion| number(row, criterion)).collect(),
        };
        self.marks.insert(row.point_id, mark);
    }

    /// How many points were asked for.
    pub fn points(&self) -> u64 {
        self.asked.len() as u64
    }

    /// All points asked for, ascending; none are afterwards.
    pub fn take_asked(&mut self) -> BTreeSet<u64> {
        std::mem::take(&mut self.asked)
    }

    /// Asks for the points of the next round that are not known, ascending; nothing where the plane
    /// is complete, or where a point that was asked for is not known.
    pub fn next_round(&mut self) -> Vec<usize> {
        loop {
            if self.asked.iter().any(|id| !self.marks.contains_key(id)) {
                return Vec::new();
            }
            let round = self.round();
            if round.is_empty() {
                return Vec::new();
            }
            let unknown = round.iter().filter(|id| !self.marks.contains_key(id));
            let unknown: Vec<usize> = unknown.map(|&id| id as usize).collect();
            self.asked.extend(round);
            if !unknown.is_empty() {
                return unknown;
            }
        }
    }

    /// The points of the round that follows.
    fn round(&mut self) -> BTreeSet<u64> {
        let coarse = self.nested.places(0) as u64;
        if self.asked.is_empty() {
            return (0..coarse).collect();
        }
        if self.allowed.is_empty() {
            self.allowed = self.spans(coarse);
        }
        let there = |place| self.asked.contains(&self.id(place));
        let leaves = self.nested.leaves(there);
        let divided = leaves.iter().filter(|cell| self.divides(cell));
        let places = divided.flat_map(|cell| cell.middles().into_iter().chain([cell.centre()]));
        let ids = places.map(|place| self.id(place));
        ids.filter(|id| !self.asked.contains(id)).collect()
    }

    fn id(&self, place: [usize; 2]) -> u64 {
        self.nested.number(place) as u64
    }

    /// By how much numbers may differ: a part of what they span over the first points.
    fn spans(&self, coarse: u64) -> Vec<f64> {
        let numbers = self.by.iter().filter(|c| c.is_number()).count();
        let span = |which: usize| {
            let known = (0..coarse).filter_map(|id| self.marks[&id].numbers[which]);
            let (low, high) = known
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [v, _]| {
                    (low.min(v), high.max(v))
                });
            self.tolerance * (high - low).max(0.0)
        };
        (0..numbers).map(span).collect()
    }

    /// Whether a leaf is to be divided.
    fn divides(&self, cell: &Cell) -> bool {
        if cell.side == 1 {
            return false;
        }
        let there = |place: &[usize; 2]| self.asked.contains(&self.id(*place));
        if cell.side >= 4 && cell.quarters_of_edges().iter().any(there) {
            return true;
        }
        let middles = cell.middles().into_iter().filter(there);
        let around: Vec<&Mark> = (cell.corners().into_iter().chain(middles))
            .map(|place| &self.marks[&self.id(place)])
            .collect();
        let mut pairs = (1..around.len()).flat_map(|i| around[..i].iter().map(move |a| (i, a)));
        pairs.any(|(i, a)| self.differ(a, around[i]))
    }

    fn differ(&self, a: &Mark, b: &Mark) -> bool {
        let classes = a.class.zip(b.class);
        let mut numbers = a.numbers.iter().zip(&b.numbers).zip(&self.allowed);
        self.by.iter().any(|criterion| match criterion {
            Criterion::Class => classes.is_some_and(|(a, b)| other_kind(a, b)),
            Criterion::Period => classes.is_some_and(|(a, b)| a.period() != b.period()),
            _ => matches!(numbers.next(), Some(((Some(a), Some(b)), allowed))
                if (a[0] - b[0]).abs() > allowed + SIGMAS * a[1].hypot(b[1])),
        })
    }
}

/// The plane that workers share.
pub(super) fn lock(refinement: &Mutex<Refinement>) -> MutexGuard<'_, Refinement> {
    refinement.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether two motions are of different kinds, periods aside.
fn other_kind(a: Class, b: Class) -> bool {
    let unsettled = |class: Class| class == Class::NotConverged;
    let repeats = |class: Class| matches!(class, Class::SteadyContact(_) | Class::Periodic(_));
    match unsettled(a) || unsettled(b) {
        true => repeats(a) || repeats(b),
        // Which trajectories leave chaos is chance.
        false if a.is_chaos() && b.is_chaos() => false,
        false => std::mem::discriminant(&a) != std::mem::discriminant(&b),
    }
}

/// Value and standard error of a number of a point, where it has one; the error is 0 where the
/// motion repeats.
fn number(row: &PointRow, criterion: Criterion) -> Option<[f64; 2]> {
    let outcome = &row.outcome;
    let nvh = |value: fn(&NvhOutcome) -> f64, error: fn(&NvhErrors) -> f64| {
        let found = outcome.nvh.as_ref()?;
        Some([value(found), found.stderr.as_ref().map_or(0.0, error)])
    };
    let found = match criterion {
        Criterion::Class | Criterion::Period => None,
        Criterion::LambdaMax => (outcome.lyapunov.as_ref())
            .and_then(|found| Some([*found.exponents.first()?, found.stderr()])),
        Criterion::EventsPerCycle => outcome.events_per_cycle.map(|n| [n, 0.0]),
        Criterion::DeflectionMean => nvh(|n| n.deflection_mean, |e| e.deflection_mean),
        Criterion::DeflectionRms => nvh(|n| n.deflection_rms, |e| e.deflection_rms),
        Criterion::ForceStd => nvh(|n| n.force_std, |e| e.force_std),
        Criterion::ImpactRate => nvh(|n| n.impact_rate, |e| e.impact_rate),
        Criterion::ImpactVelocity => nvh(|n| n.impact_velocity, |e| e.impact_velocity),
    };
    found.filter(|[value, error]| value.is_finite() && !error.is_nan())
}

#[cfg(test)]
mod tests;
