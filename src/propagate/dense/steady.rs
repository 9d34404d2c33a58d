//! A mesh cycle of constant contact as one affine map, and when a trajectory may take it.

use super::course::Course;
use super::exits::{Margin, Sight};
use super::exponential::bound_row;
use super::march::Piece;
use super::matrix::{Operator, dot};
use super::series::BoundRows;
use crate::model::Contact;
use crate::numerics::linalg;
use faer::Mat;

/// The map of a cycle in contact and the steady cycles on both flanks.
#[derive(Debug)]
pub(super) struct Steady {
    map: Operator,
    /// Bound of |δ| over a cycle as a row over the sizes of a state.
    reach: Vec<f64>,
    flanks: [Flank; 2],
}

/// The steady cycle on one flank, ripple left out.
#[derive(Debug)]
struct Flank {
    /// Its augmented state at the cycle's start.
    start: Vec<f64>,
    /// Its smallest margin \[m\]; negative where it leaves contact.
    margin: f64,
}

impl Steady {
    /// The map of the cycle whose cells have these propagators, by class; none where no steady
    /// cycle exists.
    pub fn new(course: &Course<'_>, propagators: &[Mat<f64>]) -> Option<Self> {
        let (layout, grid) = (&course.layout, &course.grid);
        let d = layout.dimension();
        let map = cycle(course, propagators);
        let n = layout.modes;
        let kept: Vec<usize> = (0..2 * n)
            .filter(|i| !course.model.neutral.contains(&(i % n)))
            .collect();
        let mut flanks = Vec::with_capacity(2);
        for contact in [Contact::Drive, Contact::Coast] {
            let mut start = vec![0.0; layout.padded()];
            start[layout.constant()] = 1.0;
            start[layout.side()] = contact.sign();
            for error in 0..layout.errors {
                // The cosine of a phase that is zero.
                start[layout.pairs() + 2 * (layout.ripples + error)] = 1.0;
            }
            let system = Mat::from_fn(kept.len(), kept.len(), |i, j| {
                f64::from(u8::from(i == j)) - map[(kept[i], kept[j])]
            });
            let driven: Vec<f64> = (kept.iter())
                .map(|&i| (2 * n..d).map(|j| map[(i, j)] * start[j]).sum())
                .collect();
            if !kept.is_empty() {
                for (&i, x) in kept.iter().zip(linalg::solve(system.as_ref(), &driven)) {
                    start[i] = x;
                }
            }
            if !start.iter().all(|x| x.is_finite()) {
                return None;
            }
            let margin = smallest_margin(course, propagators, contact, &start);
            flanks.push(Flank { start, margin });
        }
        if flanks.iter().all(|flank| flank.margin <= 0.0) {
            return None;
        }
        let mut reach = vec![0.0; layout.padded()];
        let mut before = Mat::<f64>::identity(d, d);
        for cell in &grid.cells {
            let generator = &course.contact[cell.class];
            let duration = grid.classes[cell.class].duration;
            let (row, through) = (&generator.deflection, Some(before.as_ref()));
            bound_row(generator, grid.rate, duration, row, through, &mut reach);
            before = &propagators[cell.class] * &before;
        }
        // The difference of two states in one contact has neither constant nor side.
        reach[layout.constant()] = 0.0;
        reach[layout.side()] = 0.0;
        let flanks: [Flank; 2] = flanks.try_into().ok()?;
        Some(Self {
            map: Operator::new(map.as_ref()),
            reach,
            flanks,
        })
    }

    /// The map of a cycle.
    pub fn map(&self) -> &Operator {
        &self.map
    }

    /// Whether the cycle that starts with a piece in a state surely keeps contact.
    pub fn holds(&self, piece: &Piece, z: &[f64]) -> bool {
        let flank = match piece.contact {
            Contact::Drive => &self.flanks[0],
            Contact::Coast => &self.flanks[1],
            Contact::Free => return false,
        };
        let sizes = self.reach.iter().zip(z).zip(&flank.start);
        let apart: f64 = sizes
            .map(|((reach, z), start)| reach * (z - start).abs())
            .sum();
        flank.margin > apart + piece.noise
    }
}

/// The map of a cycle in contact, as a matrix.
pub fn cycle(course: &Course<'_>, propagators: &[Mat<f64>]) -> Mat<f64> {
    let d = course.layout.dimension();
    let mut map = Mat::<f64>::identity(d, d);
    for cell in &course.grid.cells {
        map = &propagators[cell.class] * &map;
    }
    map
}

/// The smallest margin along a cycle in contact \[m\], or something smaller.
fn smallest_margin(
    course: &Course<'_>,
    propagators: &[Mat<f64>],
    contact: Contact,
    start: &[f64],
) -> f64 {
    let grid = &course.grid;
    let bounds: Vec<BoundRows> = (course.contact.iter().zip(&grid.classes))
        .map(|(g, class)| BoundRows::new(g, grid.rate, class.duration))
        .collect();
    let d = course.layout.dimension();
    let mut z = start.to_vec();
    let mut smallest = f64::INFINITY;
    for cell in &grid.cells {
        let generator = &course.contact[cell.class];
        let duration = grid.classes[cell.class].duration;
        let see = |z: &[f64]| {
            let sight = Sight {
                time: 0.0,
                deflection: [dot(&generator.deflection, z), 0.0, 0.0],
            };
            let margins = Margin::of(contact, course.model.half_gap);
            margins
                .map(|margin| margin.see(&sight).value)
                .fold(f64::INFINITY, f64::min)
        };
        let sag = 0.125 * duration * duration * bounds[cell.class].at(&z, 0.0).second;
        let before = see(&z);
        let next: Vec<f64> = (0..d)
            .map(|i| (0..d).map(|j| propagators[cell.class][(i, j)] * z[j]).sum())
            .collect();
        z[..d].copy_from_slice(&next);
        smallest = smallest.min(before.min(see(&z)) - sag);
    }
    smallest
}
