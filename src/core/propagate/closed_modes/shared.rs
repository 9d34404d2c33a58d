//! Bases that the models of one structure and mesh share, each made when a motion first meets its set.

use super::ClosedModes;
use super::bases::{Bases, fastest, stiffest};
use super::met::MetSets;
use super::sets::Sets;
use super::suited;
use crate::model::Model;
use crate::propagate::{DenseError, InstructionSet};
use faer::Mat;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Bases of a structure and its mesh, whatever the speed, the load and the gap.
#[derive(Debug)]
pub struct SharedBases {
    like: Model,
    sets: Sets,
    /// Fastest rate of all \[1/s\].
    fastest: f64,
    met: Arc<MetSets>,
    /// What leads from the coordinates of one set to those of another.
    changes: Mutex<HashMap<[usize; 2], Arc<Mat<f64>>>>,
}

impl SharedBases {
    /// Those of a model's structure and mesh.
    ///
    /// # Errors
    /// As of [`ClosedModes::suits`], more than [`ClosedModes::FEW`] sets of closed contacts, or eigenvectors too nearly parallel.
    pub fn new(model: &Model) -> Result<Self, DenseError> {
        let (sets, _) = suited(model)?;
        if !sets.are_few() {
            return Err(DenseError::TooManySets {
                count: sets.count(),
                most: ClosedModes::FEW,
            });
        }
        Ok(Self {
            fastest: fastest(&stiffest(model, &sets)?),
            sets,
            like: model.clone(),
            met: Arc::default(),
            changes: Mutex::default(),
        })
    }

    /// Whether they serve a model too.
    pub fn serve(&self, model: &Model) -> bool {
        self.systems(model).is_some()
    }

    /// The systems of a model that they serve; none of another structure or mesh.
    fn systems(&self, model: &Model) -> Option<Sets> {
        let generators = |model: &Model| model.blocks.iter().map(|block| block.generator).collect();
        let blocks: [Vec<_>; 2] = [&self.like, model].map(generators);
        let same = blocks[0] == blocks[1]
            && self.like.basis == model.basis
            && self.like.directions.len() == model.directions.len()
            && (self.like.directions.iter().zip(&model.directions))
                .all(|(own, other)| own.gains == other.gains && own.line == other.line);
        same.then(|| Sets::new(model).ok())
            .flatten()
            .filter(|sets| *sets == self.sets)
    }

    /// What leads from the coordinates of one set to those of another, 2N × 2N; those of free flight are the states of the
    /// model's blocks.
    pub(super) fn change(
        &self,
        model: &Model,
        sets: &Sets,
        [from, to]: [usize; 2],
    ) -> Result<Arc<Mat<f64>>, DenseError> {
        let lock = || self.changes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&[from, to]) {
            return Ok(known.clone());
        }
        let n = model.modes();
        let [own, behind] = [from, to].map(|set| self.met.basis(model, sets, set));
        let [own, behind] = [own?, behind?];
        let made = match (own.to_modes(), behind.of_modes()) {
            (None, None) => Mat::identity(2 * n, 2 * n),
            (Some(map), None) | (None, Some(map)) => unpadded(map, n),
            (Some(there), Some(back)) => unpadded(back, n) * unpadded(there, n),
        };
        Ok(lock().entry([from, to]).or_insert(Arc::new(made)).clone())
    }
}

/// A map between padded states as a matrix.
fn unpadded(map: &[f64], n: usize) -> Mat<f64> {
    let padded = map.len() / (4 * n);
    Mat::from_fn(2 * n, 2 * n, |i, j| {
        let row = if i < n { i } else { padded + i - n };
        map[2 * padded * j + row]
    })
}

impl ClosedModes<'static> {
    /// The kernel of a model on shared bases, other arguments as for [`Self::new`]: a system is made when a motion first meets it.
    /// The model comes back where they do not serve it.
    ///
    /// # Errors
    /// [`DenseError`] where the kernel does not take it.
    pub fn on_shared(
        model: Model,
        event_limit: u32,
        shared: &SharedBases,
        instructions: InstructionSet,
    ) -> Result<Result<Self, Box<Model>>, DenseError> {
        let Some(sets) = shared.systems(&model) else {
            return Ok(Err(Box::new(model)));
        };
        let bases = Bases::Met {
            fastest: shared.fastest,
            met: shared.met.clone(),
        };
        Self::of_bases(Cow::Owned(model), event_limit, sets, bases, instructions).map(Ok)
    }

    /// Its model.
    pub fn model(&self) -> &Model {
        &self.model
    }
}
