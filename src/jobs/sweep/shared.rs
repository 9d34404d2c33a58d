//! Data that the workers of a run share, behind locks.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks a value, even if a thread has panicked while it held the lock.
pub(super) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Values in memory by their description. Their number is bounded, because every sampled drive has separate values. A
/// forgotten value is computed or read again, with the same bits.
#[derive(Debug)]
pub(super) struct SharedValues<V> {
    most: usize,
    values: Mutex<HashMap<String, V>>,
}

impl<V: Clone> SharedValues<V> {
    /// Room for `most` values.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            values: Mutex::default(),
        }
    }

    /// The value kept for a description.
    pub fn get(&self, description: &str) -> Option<V> {
        lock(&self.values).get(description).cloned()
    }

    /// Keeps a value. If there is no room, all others are forgotten.
    pub fn keep(&self, description: String, value: &V) {
        let mut values = lock(&self.values);
        if values.len() >= self.most {
            values.clear();
        }
        values.insert(description, value.clone());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_beyond_the_room_replace_the_others() {
        let shared = SharedValues::new(3);
        for value in 0..10 {
            shared.keep(value.to_string(), &value);
            assert_eq!(shared.get(&value.to_string()), Some(value));
            assert!(lock(&shared.values).len() <= 3);
        }
        assert_eq!(shared.get("0"), None);
    }
}
