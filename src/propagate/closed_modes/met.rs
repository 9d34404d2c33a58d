//! Bases of the sets that some motion met, where there are too many sets to make them all.

use super::bases::{Basis, Found, Map, columns, padded};
use super::sets::Sets;
use crate::model::Model;
use crate::propagate::DenseError;
use faer::Mat;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most bytes that are kept for other points; what is met beyond is made by each for itself.
const MOST_BYTES: usize = 256_000_000;

/// Bases of the sets that the motions of a structure and its mesh have met: each a function of its set alone, whoever
/// meets it first.
#[derive(Debug, Default)]
pub struct MetSets {
    bases: Kept<usize, Basis<'static>>,
    changes: Kept<[usize; 2], Map<'static>>,
}

/// Things made once, as long as there is room.
type Kept<K, T> = Mutex<HashMap<K, Arc<T>>>;

impl MetSets {
    /// That of a set.
    ///
    /// # Errors
    /// Its eigenvectors are too nearly parallel.
    pub fn basis(
        &self,
        model: &Model,
        sets: &Sets,
        set: usize,
    ) -> Result<Arc<Basis<'static>>, DenseError> {
        if let Some(known) = lock(&self.bases).get(&set) {
            return Ok(known.clone());
        }
        // Not under the lock: others go on meanwhile, and what two make at once is the same.
        let made = Arc::new(Found::new(model, sets, set)?.basis(set));
        Ok(keep(&self.bases, set, made, 2 * bytes(model.modes())))
    }

    /// How many sets were met.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        lock(&self.bases).len()
    }

    /// What leads from a closed set to another one; none where they are the same.
    pub fn change(
        &self,
        sets: [usize; 2],
        [own, behind]: [&Basis<'_>; 2],
    ) -> Option<Arc<Map<'static>>> {
        if let Some(known) = lock(&self.changes).get(&sets) {
            return Some(known.clone());
        }
        let (to, from) = (own.to_modes()?, behind.of_modes()?);
        let modes = own.modes();
        let made = Arc::new(columns(&(matrix(from, modes) * matrix(to, modes))));
        let bytes = size_of_val(&made[..]);
        Some(keep(&self.changes, sets, made, bytes))
    }
}

/// Bytes of a map of so many modes.
pub fn bytes(modes: usize) -> usize {
    4 * modes * padded(modes) * size_of::<f64>()
}

/// A map between padded states of so many modes as a matrix.
fn matrix(map: &Map<'_>, modes: usize) -> Mat<f64> {
    let padded = padded(modes);
    Mat::from_fn(2 * modes, 2 * modes, |i, j| {
        let row = if i < modes { i } else { padded + i - modes };
        map[2 * padded * j + row]
    })
}

/// Keeps something, of so many bytes each, unless another was faster.
fn keep<K: std::hash::Hash + Eq, T>(
    all: &Kept<K, T>,
    key: K,
    made: Arc<T>,
    bytes: usize,
) -> Arc<T> {
    let mut all = lock(all);
    if let Some(known) = all.get(&key) {
        return known.clone();
    }
    if all.len() * bytes < MOST_BYTES {
        all.insert(key, made.clone());
    }
    made
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
