//! Bases of the sets that motions have reached, if there are too many sets to compute all.

use super::basis::{Basis, FoundBasis, padded};
use super::sets::Sets;
use crate::model::Model;
use crate::propagate::{SharedStorage, TableError};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Limit in bytes for the tables of a structure, or of the sets that are reached.
pub const MOST_BYTES: usize = 256_000_000;

/// Bases of the sets that the motions of a structure and its mesh have reached. Each basis depends on its set
/// only, not on the motion that reaches it first. Changes between sets go through modes: direct tables would
/// be used too seldom to stay in a cache.
#[derive(Debug, Default)]
pub struct ReachedSets(Mutex<HashMap<usize, Arc<Basis<'static>>>>);

impl ReachedSets {
    /// The bases that kernels of a structure share, or an empty collection.
    pub fn stored_in(place: Option<&SharedStorage>) -> Arc<Self> {
        let shared = place.map(|place| place.get_or_init(|| Arc::<Self>::default()).clone());
        (shared.and_then(|shared| shared.downcast().ok())).unwrap_or_default()
    }

    /// The basis of a set.
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
        // Computed without the lock, so that other threads continue. Two threads that compute the same basis
        // get the same result.
        let basis = Arc::new(FoundBasis::new(model, sets, set)?.basis(set));
        let mut bases = self.lock();
        if let Some(known) = bases.get(&set) {
            return Ok(known.clone());
        }
        // Above the limit, a basis is not shared: every kernel computes it again.
        if bases.len() * bytes(model.modes()) < MOST_BYTES {
            bases.insert(set, basis.clone());
        }
        Ok(basis)
    }

    /// Number of sets that were reached.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.lock().len()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<usize, Arc<Basis<'static>>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Bytes of the two maps of a set.
pub fn bytes(modes: usize) -> usize {
    8 * modes * padded(modes) * size_of::<f64>()
}
