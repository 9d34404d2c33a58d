//! Which points does a refined plane need? It is divided where corners of its cells differ.
//!
//! Points are computed in rounds, starting with the undivided grid. After each round, all cells are checked at the same
//! time. A cell is divided if two points differ among its corners and those middles of its edges that smaller
//! neighbours have. It is also divided if a neighbour has less than half its side. So a change that leaves a divided
//! cell through an edge is followed into the next cell, whatever its size. The points of a round depend only on earlier
//! results, not on the time of their computation: a journal is read first, and rounds omit its points.
//!
//! Two motions without a verdict that repeats (chaotic, quasi-periodic or not settled) differ only if both are known.
//! On a map, a long period counts as quasi-periodic. A point without motion, for instance a failed one, is compared
//! with nothing.

use crate::analysis::{Class, NvhErrors, NvhOutcome};
use crate::manifest::{Criterion, Refine};
use crate::numerics::nested_grid::{Cell, NestedGrid};
use crate::store::PointRow;
use std::collections::{BTreeSet, HashMap};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Two numbers count as equal up to this number of standard errors of their difference.
const SIGMAS: f64 = 5.0;

/// The data by which a point is compared.
#[derive(Debug, Clone, PartialEq)]
struct Mark {
    /// `None` if the motion is unknown.
    class: Option<Class>,
    /// Value and standard error of every number that is compared.
    numbers: Vec<Option<[f64; 2]>>,
}

/// A plane during its refinement.
#[derive(Debug)]
pub(super) struct Refinement {
    nested: NestedGrid,
    by: Vec<Criterion>,
    tolerance: f64,
    longest_period: u32,
    /// Known points, including those not requested yet.
    marks: HashMap<u64, Mark>,
    requested: BTreeSet<u64>,
    /// The largest differences that are ignored, one per number; known after the first round.
    allowed: Vec<f64>,
}

impl Refinement {
    /// A plane without known or requested points.
    pub fn new(refine: &Refine) -> Self {
        Self {
            nested: refine.nested,
            by: refine.by.clone(),
            tolerance: refine.tolerance,
            longest_period: refine.longest_period,
            marks: HashMap::new(),
            requested: BTreeSet::new(),
            allowed: Vec::new(),
        }
    }

    /// Records a point.
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

    /// Number of requested points.
    pub fn points(&self) -> u64 {
        self.requested.len() as u64
    }

    /// Takes all requested points, ascending.
    pub fn take_requested(&mut self) -> BTreeSet<u64> {
        std::mem::take(&mut self.requested)
    }

    /// Requests the points of the next round and returns the unknown ones, ascending. Returns nothing if the plane is
    /// complete, or if a requested point is not known yet.
    pub fn next_round(&mut self) -> Vec<usize> {
        loop {
            if self.requested.iter().any(|id| !self.marks.contains_key(id)) {
                return Vec::new();
            }
            let round = self.round();
            if round.is_empty() {
                return Vec::new();
            }
            let unknown = round.iter().filter(|id| !self.marks.contains_key(id));
            let unknown: Vec<usize> = unknown.map(|&id| id as usize).collect();
            self.requested.extend(round);
            if !unknown.is_empty() {
                return unknown;
            }
        }
    }

    /// The new points of the next round.
    fn round(&mut self) -> BTreeSet<u64> {
        let coarse = self.nested.places(0) as u64;
        if self.requested.is_empty() {
            return (0..coarse).collect();
        }
        if self.allowed.is_empty() {
            self.allowed = self.spans(coarse);
        }
        let there = |place| self.requested.contains(&self.id(place));
        let leaves = self.nested.leaves(there);
        let divided = leaves.iter().filter(|cell| self.divides(cell));
        let places = divided.flat_map(|cell| cell.middles().into_iter().chain([cell.centre()]));
        let ids = places.map(|place| self.id(place));
        ids.filter(|id| !self.requested.contains(id)).collect()
    }

    fn id(&self, place: [usize; 2]) -> u64 {
        self.nested.number(place) as u64
    }

    /// Largest ignored differences of numbers: a fraction of their range over the first points.
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

    /// Whether a leaf must be divided.
    fn divides(&self, cell: &Cell) -> bool {
        if cell.side == 1 {
            return false;
        }
        let there = |place: &[usize; 2]| self.requested.contains(&self.id(*place));
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

/// Whether two motions are of different kinds, without regard to periods.
fn other_kind(a: Class, b: Class) -> bool {
    let unsettled = |class: Class| class == Class::NotConverged;
    let repeats = |class: Class| matches!(class, Class::SteadyContact(_) | Class::Periodic(_));
    match unsettled(a) || unsettled(b) {
        true => repeats(a) || repeats(b),
        // Chance decides which trajectories leave chaos.
        false if a.is_chaos() && b.is_chaos() => false,
        false => std::mem::discriminant(&a) != std::mem::discriminant(&b),
    }
}

/// Value and standard error of a number of a point, if it has one; the error is 0 if the motion repeats.
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
