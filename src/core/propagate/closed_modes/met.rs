//! Bases of the sets that some motion met, where there are too many sets to make them all.

use super::basis::{Basis, Found, padded};
use super::sets::Sets;
use crate::model::Model;
use crate::propagate::{Beside, TableError};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most bytes of the tables of a structure, or of the sets that are met.
pub const MOST_BYTES: usize = 256_000_000;

/// Bases of the sets that the motions of a structure and its mesh have met: each a function of its set alone, whoever
/// meets it first. What leads from one to another goes by way of modes: tables of its own would be used too seldom to stay in
/// a cache.
#[derive(Debug, Default)]
pub struct MetSets(Mutex<HashMap<usize, Arc<Basis<'static>>>>);

impl MetSets {
    /// Those that kernels of a structure share, or none yet.
    pub fn beside(place: Option<&Beside>) -> Arc<Self> {
        let shared = place.map(|place| place.get_or_init(|| Arc::<Self>::default()).clone());
        (shared.and_then(|shared| shared.downcast().ok())).unwrap_or_default()
    }

    /// That of a set.
    ///
    /// # Errors
    /// Its eigenvectors are too nearly parallel.
    pub fn basis(
        &self,
        model: &Model,
        sets: &Sets,
        set: usize,
    ) -> Result<Arc<Basis<'static>>, TableError> {
        if let Some(known) = self.lock().get(&set) {
            return Ok(known.clone());
        }
        // Not under the lock: others go on meanwhile, and what two make at once is the same.
        let made = Arc::new(Found::new(model, sets, set)?.basis(set));
        let mut all = self.lock();
        if let Some(known) = all.get(&set) {
            return Ok(known.clone());
        }
        // What is met beyond is made by each kernel for itself.
        if all.len() * bytes(model.modes()) < MOST_BYTES {
            all.insert(set, made.clone());
        }
        Ok(made)
    }

    /// How many sets were met.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.lock().len()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<usize, Arc<Basis<'static>>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Bytes of the two maps of a set of so many modes.
pub fn bytes(modes: usize) -> usize {
    8 * modes * padded(modes) * size_of::<f64>()
}
