//! Items arrive in any order and leave in the expected order, so that result files do not depend on the number of
//! threads.

use std::collections::BTreeMap;

use super::StoreError;

/// Holds items back until all items before them have left.
pub(super) struct Reorder<T> {
    expected: Box<dyn Iterator<Item = u64> + Send>,
    next: Option<u64>,
    waiting: BTreeMap<u64, T>,
}

impl<T> Reorder<T> {
    /// `expected`: the ids, strictly ascending.
    pub(super) fn new(expected: impl Iterator<Item = u64> + Send + 'static) -> Self {
        let mut expected: Box<dyn Iterator<Item = u64> + Send> = Box::new(expected);
        let next = expected.next();
        Self {
            expected,
            next,
            waiting: BTreeMap::new(),
        }
    }

    /// Expects these ids, strictly ascending, instead of the remaining ones.
    pub(super) fn expect(&mut self, expected: impl Iterator<Item = u64> + Send + 'static) {
        self.expected = Box::new(expected);
        self.next = self.expected.next();
    }

    /// Adds an item.
    pub(super) fn insert(&mut self, id: u64, item: T) -> Result<(), StoreError> {
        let passed = self.next.is_none_or(|next| id < next);
        if passed || self.waiting.contains_key(&id) {
            return Err(StoreError::UnexpectedPoint { point_id: id });
        }
        self.waiting.insert(id, item);
        Ok(())
    }

    /// Removes and returns the item with the next expected id, if it has arrived.
    pub(super) fn pop(&mut self) -> Option<T> {
        let item = self.waiting.remove(&self.next?)?;
        self.next = self.expected.next();
        Some(item)
    }

    /// Number of items that wait for an earlier one.
    pub(super) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Skips the next expected id; false if none is left.
    pub(super) fn skip(&mut self) -> bool {
        let skipped = self.next.is_some();
        self.next = self.expected.next();
        skipped
    }

    /// The smallest id that still waits. After all expected ids have passed, it is an unexpected one.
    pub(super) fn leftover(&self) -> Option<u64> {
        self.waiting.keys().next().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_order_in_one_order_out(order in Just((0..40_u64).collect::<Vec<_>>()).prop_shuffle()) {
            let mut reorder = Reorder::new((0..40).map(|id| 3 * id + 1));
            let mut left = Vec::new();
            for id in order {
                reorder.insert(3 * id + 1, id).unwrap();
                while let Some(id) = reorder.pop() {
                    left.push(id);
                }
            }
            prop_assert_eq!(left, (0..40).collect::<Vec<_>>());
        }
    }

    #[test]
    fn strangers_and_duplicates_are_refused() {
        let mut reorder = Reorder::new([2, 4, 6].into_iter());
        assert!(reorder.insert(0, ()).is_err(), "before the first");
        reorder.insert(4, ()).unwrap();
        assert!(reorder.insert(4, ()).is_err(), "waiting already");
        reorder.insert(2, ()).unwrap();
        assert!(reorder.pop().is_some() && reorder.pop().is_some() && reorder.pop().is_none());
        assert!(reorder.insert(4, ()).is_err(), "gone already");
        reorder.insert(7, ()).unwrap();
        assert!(reorder.skip() && !reorder.skip());
        assert_eq!(reorder.leftover(), Some(7), "never expected");
    }
}
