//! Copies of data in the memory of one NUMA node, for its workers.

use super::shared::lock;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex};

/// Largest number of copies of a kind.
const MOST_COPIES: usize = 1 << 14;

/// Copies in the memory of one NUMA node.
#[derive(Debug)]
pub(super) struct NodeCopies<K, V>(Mutex<HashMap<K, Arc<V>>>);

impl<K, V> Default for NodeCopies<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Eq + Hash, V: Clone> NodeCopies<K, V> {
    /// The copy for a key. If there is none yet, it is made from the result of `far`, and other threads wait.
    pub fn get<E>(&self, key: K, far: impl FnOnce() -> Result<Arc<V>, E>) -> Result<Arc<V>, E> {
        let mut copies = lock(&self.0);
        if let Some(copy) = copies.get(&key) {
            return Ok(copy.clone());
        }
        if copies.len() == MOST_COPIES {
            copies.clear();
        }
        // The calling thread writes the copy. A clone of the pointer would leave the data on the node where `far` wrote
        // them.
        let copy = Arc::new((*far()?).clone());
        copies.insert(key, copy.clone());
        Ok(copy)
    }

    pub fn for_each(&self, mut visit: impl FnMut(&V)) {
        let copies = lock(&self.0);
        copies.values().for_each(|copy| visit(copy));
    }
}
