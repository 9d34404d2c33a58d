//! A mesh cycle of constant contact as one affine map. When may a trajectory use it?

use super::cell_model::CellModel;
use super::exits::{DeflectionAt, MarginAt};
use super::exponential::{self, bound_row};
use super::matrix::{Operator, dot};
use super::series::BoundRows;
use super::state_part::StatePart;
use crate::model::ActiveSet;
use crate::numerics::linalg;
use crate::propagate::events::Margin;
use faer::Mat;

/// The map of a cycle in contact, for any load and gap.
#[derive(Debug)]
pub(super) struct CycleMap {
    pub map: Operator,
    /// Row whose product with the absolute values of a difference of states bounds |δ| of this difference over a cycle.
    reach: Vec<f64>,
}

impl CycleMap {
    /// The map of a cycle of cells; `increments` are their propagators minus the identity, by class.
    pub fn new(cell_model: &CellModel<'_>, increments: &[Mat<f64>]) -> Self {
        let (layout, grid) = (&cell_model.layout, &cell_model.grid);
        let d = layout.dimension();
        let mut reach = vec![0.0; layout.padded()];
        let mut before = Mat::<f64>::zeros(d, d);
        for cell in &grid.cells {
            let generator = &cell_model.contact_generators[cell.class];
            let duration = grid.classes[cell.class].duration;
            let through = exponential::plus_one(before.clone());
            let (row, through) = (&generator.deflection, Some(through.as_ref()));
            bound_row(generator, grid.rate, duration, row, through, &mut reach);
            before = exponential::after(&increments[cell.class], &before);
        }
        // The difference of two states in one contact state has neither load nor side.
        reach[layout.constant()] = 0.0;
        reach[layout.side()] = 0.0;
        Self {
            map: Operator::new(exponential::plus_one(before).as_ref()),
            reach,
        }
    }
}

/// The map of a cycle in contact and the steady cycles on both flanks, if there are any.
#[derive(Debug)]
pub(super) struct Steady {
    cycle: CycleMap,
    flanks: Option<[Flank; 2]>,
}

/// The steady cycle on one flank, without ripple.
#[derive(Debug)]
struct Flank {
    /// Augmented state at the start of the steady cycle.
    start: Vec<f64>,
    /// Smallest margin of the steady cycle \[m\]; negative if it leaves contact.
    margin: f64,
}

impl Steady {
    /// The steady cycles under the model's load; `cells`: the propagator of a cell of each class.
    pub fn new(cell_model: &CellModel<'_>, cycle: CycleMap, cells: &[&Operator]) -> Self {
        let [drive, coast] = [ActiveSet::DRIVE, ActiveSet::COAST]
            .map(|contact| Flank::new(cell_model, &cycle.map, cells, contact));
        let flanks = (drive.zip(coast)).map(|(drive, coast)| [drive, coast]);
        Self {
            cycle,
            flanks: flanks.filter(|flanks| flanks.iter().any(|flank| flank.margin > 0.0)),
        }
    }

    /// The cycle's map.
    pub fn cycle(&self) -> &CycleMap {
        &self.cycle
    }

    /// Whether contact certainly persists over the cycle that starts with this stretch and state.
    pub fn holds(&self, stretch: &StatePart, z: &[f64]) -> bool {
        let Some([drive, coast]) = &self.flanks else {
            return false;
        };
        let flank = match stretch.contact {
            ActiveSet::DRIVE => drive,
            ActiveSet::COAST => coast,
            _ => return false,
        };
        let sizes = self.cycle.reach.iter().zip(z).zip(&flank.start);
        let bound: f64 = sizes
            .map(|((reach, z), start)| reach * (z - start).abs())
            .sum();
        flank.margin > bound + stretch.noise
    }
}

impl Flank {
    /// The steady cycle in a contact state; `None` if it does not exist.
    fn new(
        cell_model: &CellModel<'_>,
        map: &Operator,
        cells: &[&Operator],
        contact: ActiveSet,
    ) -> Option<Self> {
        let (layout, model) = (&cell_model.layout, cell_model.model);
        let (n, d) = (layout.modes, layout.dimension());
        let kept: Vec<usize> = (0..2 * n)
            .filter(|i| !model.neutral.contains(&(i % n)))
            .collect();
        let mut start = vec![0.0; layout.padded()];
        start[layout.constant()] = model.load;
        start[layout.side()] = contact.sign() * model.half_gap;
        for error in 0..layout.errors {
            // The cosine of a zero phase.
            start[layout.pairs() + 2 * (layout.ripples + error)] = 1.0;
        }
        let system = Mat::from_fn(kept.len(), kept.len(), |i, j| {
            f64::from(u8::from(i == j)) - map.entry(kept[i], kept[j])
        });
        let driven: Vec<f64> = (kept.iter())
            .map(|&i| (2 * n..d).map(|j| map.entry(i, j) * start[j]).sum())
            .collect();
        if !kept.is_empty() {
            for (&i, x) in kept.iter().zip(linalg::solve(system.as_ref(), &driven)) {
                start[i] = x;
            }
        }
        start.iter().all(|x| x.is_finite()).then(|| Self {
            margin: smallest_margin(cell_model, cells, contact, &start),
            start,
        })
    }
}

/// The map of a cycle in contact minus the identity; `increments` are the maps of cells minus the identity, by class.
pub fn cycle(cell_model: &CellModel<'_>, increments: &[Mat<f64>]) -> Mat<f64> {
    let d = cell_model.layout.dimension();
    let mut map = Mat::<f64>::zeros(d, d);
    for cell in &cell_model.grid.cells {
        map = exponential::after(&increments[cell.class], &map);
    }
    map
}

/// A lower bound of the margin along a cycle in contact \[m\].
fn smallest_margin(
    cell_model: &CellModel<'_>,
    cells: &[&Operator],
    contact: ActiveSet,
    start: &[f64],
) -> f64 {
    let grid = &cell_model.grid;
    let bounds: Vec<BoundRows> = (cell_model.contact_generators.iter().zip(&grid.classes))
        .map(|(g, class)| BoundRows::new(g, grid.rate, class.duration))
        .collect();
    let mut z = start.to_vec();
    let mut next = vec![0.0; z.len()];
    let mut smallest = f64::INFINITY;
    for cell in &grid.cells {
        let generator = &cell_model.contact_generators[cell.class];
        let duration = grid.classes[cell.class].duration;
        let see = |z: &[f64]| {
            let here = DeflectionAt {
                time: 0.0,
                deflection: [dot(&generator.deflection, z), 0.0, 0.0],
            };
            let margins = Margin::of(&cell_model.model.contacts, contact);
            margins
                .map(|margin| MarginAt::of(&margin, &here).value)
                .fold(f64::INFINITY, f64::min)
        };
        let sag = 0.125 * duration * duration * bounds[cell.class].at(&z, 0.0).second;
        let before = see(&z);
        cells[cell.class].apply(&z, &mut next);
        std::mem::swap(&mut z, &mut next);
        smallest = smallest.min(before.min(see(&z)) - sag);
    }
    smallest
}
