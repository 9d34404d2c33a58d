//! Which points does a refined plane need? It is divided where points on the edges of its cells differ.
//!
//! Points are computed in rounds, starting with the undivided grid. After each round, all cells are checked at the
//! same time. An edge of a cell has points at its corners and at the corners of smaller neighbours. A cell is halved
//! along an axis if two points differ on one of its edges along this axis. So a boundary parallel to an axis divides
//! cells only along the other axis. A boundary that leaves a divided cell through an edge is followed into the next
//! cell, whatever its size. The points of a round depend only on earlier results, not on the time of their computation:
//! a journal is read first, and rounds omit its points.
//!
//! An uncertain class is not compared: not converged, transient chaos, or chaos whose exponent is within its
//! error of 0. A period longer than `longest_period` counts as quasi-periodic.

use crate::analysis::{Class, NvhStatistics};
use crate::manifest::{Criterion, Refine};
use crate::numerics::nested_grid::{Cell, NestedGrid, middle};
use crate::store::PointRow;
use std::cmp::Reverse;
use std::collections::{BTreeSet, HashMap};
use std::mem::discriminant;

/// Two numbers count as equal up to this number of standard errors of their difference.
const SIGMAS: f64 = 5.0;

/// The data by which a point is compared.
#[derive(Debug, Clone, PartialEq)]
struct ComparedData {
    /// `None` if the class is unknown or uncertain.
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
    marks: HashMap<u64, ComparedData>,
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
    pub fn record_point(&mut self, row: &PointRow) {
        let numbers = self.by.iter().filter(|criterion| criterion.is_number());
        let mark = ComparedData {
            class: verdict(row, self.longest_period),
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
        let places = leaves
            .iter()
            .filter_map(|cell| self.division(cell))
            .flatten();
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

    /// The places that halve a leaf, along its longer side if points differ along both; none if it stays undivided.
    fn division(&self, cell: &Cell) -> Option<[[usize; 2]; 2]> {
        let varies = |axis: &usize| {
            let edges = cell.edges(*axis);
            cell.sides[*axis] > 1 && edges.into_iter().any(|edge| self.varies(edge))
        };
        let axis = (0..2)
            .filter(varies)
            .max_by_key(|&axis| (cell.sides[axis], Reverse(axis)))?;
        Some(cell.edges(axis).map(|[from, to]| middle(from, to)))
    }

    /// Whether two points of an edge differ. The edge also has the corners of smaller neighbours as points.
    fn varies(&self, edge: [[usize; 2]; 2]) -> bool {
        let mut along: Vec<&ComparedData> =
            edge.iter().map(|&end| &self.marks[&self.id(end)]).collect();
        let mut open = vec![edge];
        while let Some([from, to]) = open.pop() {
            let place = middle(from, to);
            let id = self.id(place);
            if place != from && self.requested.contains(&id) {
                along.push(&self.marks[&id]);
                open.extend([[from, place], [place, to]]);
            }
        }
        (1..along.len()).any(|i| along[..i].iter().any(|a| self.differ(a, along[i])))
    }

    fn differ(&self, a: &ComparedData, b: &ComparedData) -> bool {
        let classes = a.class.zip(b.class);
        let mut numbers = a.numbers.iter().zip(&b.numbers).zip(&self.allowed);
        self.by.iter().any(|criterion| match criterion {
            Criterion::Class => classes.is_some_and(|(a, b)| discriminant(&a) != discriminant(&b)),
            Criterion::Period => classes.is_some_and(|(a, b)| a.period() != b.period()),
            _ => matches!(numbers.next(), Some(((Some(a), Some(b)), allowed))
                if (a[0] - b[0]).abs() > allowed + SIGMAS * a[1].hypot(b[1])),
        })
    }
}

/// The class of a point, if it is certain.
fn verdict(row: &PointRow, longest_period: u32) -> Option<Class> {
    let exponent = number(row, Criterion::LambdaMax);
    match row.outcome.class? {
        // Chance decides which trajectories leave chaos.
        Class::NotConverged | Class::TransientChaos => None,
        Class::Chaotic if exponent.is_some_and(|[value, error]| value <= SIGMAS * error) => None,
        Class::Periodic(period) if period > longest_period => Some(Class::QuasiPeriodic),
        class => Some(class),
    }
}

/// Value and standard error of a number of a point, if it has one; the error is 0 if the motion repeats.
fn number(row: &PointRow, criterion: Criterion) -> Option<[f64; 2]> {
    let outcome = &row.outcome;
    let nvh = |of: fn(&NvhStatistics) -> f64| {
        let found = outcome.nvh.as_ref()?;
        Some([of(&found.values), found.stderr.as_ref().map_or(0.0, of)])
    };
    let found = match criterion {
        Criterion::Class | Criterion::Period => None,
        Criterion::LambdaMax => (outcome.lyapunov.as_ref())
            .and_then(|found| Some([*found.exponents.first()?, found.stderr()])),
        Criterion::EventsPerCycle => outcome.events_per_cycle.map(|n| [n, 0.0]),
        Criterion::DeflectionMean => nvh(|of| of.deflection_mean),
        Criterion::DeflectionRms => nvh(|of| of.deflection_rms),
        Criterion::ForceStd => nvh(|of| of.force_std),
        Criterion::ImpactRate => nvh(|of| of.impact_rate),
        Criterion::ImpactVelocity => nvh(|of| of.impact_velocity),
    };
    found.filter(|[value, error]| value.is_finite() && !error.is_nan())
}

#[cfg(test)]
mod tests;
