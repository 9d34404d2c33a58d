//! The bases of a structure and its mesh at any speed: one per stiffness, damping and direction in contact, one per
//! direction in free flight.

use super::DenseError;
use super::basis::Basis;
use super::generator::{Generator, Layout};
use super::matrix::Operator;
use super::rates::Rates;
use crate::model::{Model, Segment};
use std::sync::Arc;

/// The basis of every segment, in contact and in free flight.
#[derive(Debug)]
struct SegmentBases {
    /// Index of one segment for each basis in contact.
    contact: Vec<usize>,
    /// Index of one segment for each basis in free flight.
    flight: Vec<usize>,
    /// Indices of the bases of every segment, in contact and in free flight.
    of: Vec<[usize; 2]>,
}

impl SegmentBases {
    fn new(model: &Model) -> Self {
        let segments = &model.first_cycle().segments;
        let turned = |a: &Segment, b: &Segment| a.direction == b.direction;
        let alike = |a: &Segment, b: &Segment| {
            turned(a, b) && a.stiffness == b.stiffness && a.damping == b.damping
        };
        let mut places = Self {
            contact: Vec::new(),
            flight: Vec::new(),
            of: Vec::new(),
        };
        for (index, segment) in segments.iter().enumerate() {
            let place = |known: &mut Vec<usize>, same: &dyn Fn(&Segment, &Segment) -> bool| {
                let found = known.iter().position(|&k| same(&segments[k], segment));
                found.unwrap_or_else(|| {
                    known.push(index);
                    known.len() - 1
                })
            };
            let contact = place(&mut places.contact, &alike);
            places
                .of
                .push([contact, place(&mut places.flight, &turned)]);
        }
        places
    }
}

/// All bases of a model.
#[derive(Debug, Clone)]
pub struct Bases {
    contact: Vec<Arc<Basis>>,
    flight: Vec<Arc<Basis>>,
    of: Vec<[usize; 2]>,
}

impl Bases {
    /// Computes the bases.
    ///
    /// # Errors
    /// The eigenvectors of a basis are nearly parallel.
    pub fn new(model: &Model) -> Result<Self, DenseError> {
        Self::computed(model, |basis| basis)
    }

    /// Computes the bases, with products in single precision.
    ///
    /// # Errors
    /// As for [`Bases::new`].
    pub fn in_single_precision(model: &Model) -> Result<Self, DenseError> {
        let states = 2 * Layout::new(model).modes;
        Self::computed(model, |basis| basis.in_single_precision(states))
    }

    fn computed(model: &Model, finish: impl Fn(Basis) -> Basis) -> Result<Self, DenseError> {
        let (rates, places) = (Rates::new(model), SegmentBases::new(model));
        let make = |segment: usize, touching| {
            let mesh_segment = &model.first_cycle().segments[segment];
            let generator = Generator::new(model, mesh_segment, touching);
            let basis = Basis::new(&generator, &rates, segment, touching)?;
            Ok(Arc::new(finish(basis)))
        };
        let all = |segments: &[usize], touching| -> Result<Vec<_>, DenseError> {
            segments
                .iter()
                .map(|&segment| make(segment, touching))
                .collect()
        };
        Ok(Self {
            contact: all(&places.contact, true)?,
            flight: all(&places.flight, false)?,
            of: places.of,
        })
    }

    /// The basis of a segment in contact or in free flight.
    pub fn of(&self, segment: usize, touching: bool) -> Arc<Basis> {
        let [contact, flight] = self.of[segment];
        if touching {
            self.contact[contact].clone()
        } else {
            self.flight[flight].clone()
        }
    }

    /// All bases, contact first.
    pub fn all(&self) -> impl Iterator<Item = &Basis> {
        self.contact
            .iter()
            .chain(&self.flight)
            .map(|basis| &**basis)
    }

    /// The operators of all bases.
    pub fn operators(&self) -> impl Iterator<Item = &Operator> {
        self.all().flat_map(|basis| [&basis.inverse, &basis.matrix])
    }
}
