//! What do the workers of one NUMA node keep copies of, in their own memory?

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

/// Copies in the memory of one NUMA node.
#[derive(Debug)]
pub(super) struct Near<K, V>(Mutex<HashMap<K, Arc<V>>>);

impl<K, V> Default for Near<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Eq + Hash, V: Clone> Near<K, V> {
    /// The copy, made from what `far` gives where there is none yet. Others wait meanwhile.
    pub fn get<E>(&self, key: K, far: impl FnOnce() -> Result<Arc<V>, E>) -> Result<Arc<V>, E> {
        let mut copies = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(copy) = copies.get(&key) {
            return Ok(copy.clone());
        }
        // Written by the calling thread: a clone of the pointer would stay where it is.
        let copy = Arc::new((*far()?).clone());
        copies.insert(key, copy.clone());
        Ok(copy)
    }

    pub fn each(&self, mut tell: impl FnMut(&V)) {
        let copies = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        copies.values().for_each(|copy| tell(copy));
    }
}
