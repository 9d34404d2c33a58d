//! Data that a kernel stores for the sets of closed contacts that have occurred, by the number of the set.

use std::sync::OnceLock;

/// A cell of the table: the number of a set, and its data.
type Cell<S> = OnceLock<(usize, Box<S>)>;

/// A table that only grows, so that readers take no lock.
#[derive(Debug)]
pub struct Slots<S> {
    cells: Vec<Cell<S>>,
    /// Whether every set has a fixed cell. If not, the search for a set starts at the hash of its number and
    /// ends at the first free cell.
    direct_cells: bool,
}

impl<S> Slots<S> {
    /// A table with one cell per set.
    pub fn of_all(sets: usize) -> Self {
        Self {
            cells: (0..sets).map(|_| OnceLock::new()).collect(),
            direct_cells: true,
        }
    }

    /// A table for at most `most` sets with any numbers. It has twice as many cells, so that searches are
    /// short.
    pub fn hashed(most: usize) -> Self {
        Self {
            direct_cells: false,
            ..Self::of_all(2 * most.max(1))
        }
    }

    /// The cells in which a set may be, in the order of the search.
    fn cells(&self, set: usize) -> impl Iterator<Item = &Cell<S>> {
        /// 2⁶⁴ divided by the golden ratio: neighbouring numbers fall far apart.
        const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;
        let spread = (set as u64).wrapping_mul(SPREAD) >> 32;
        let home = if self.direct_cells { set } else { spread as usize % self.cells.len() };
        self.cells[home..].iter().chain(&self.cells[..home])
    }

    /// The data of a set, if it has occurred.
    #[inline(always)]
    pub fn get(&self, set: usize) -> Option<&S> {
        if self.direct_cells {
            return match self.cells[set].get() {
                Some((_, kept)) => Some(kept),
                None => None,
            };
        }
        self.search(set)
    }

    fn search(&self, set: usize) -> Option<&S> {
        for cell in self.cells(set) {
            let (number, kept) = cell.get()?;
            if *number == set {
                return Some(kept);
            }
        }
        None
    }

    /// Stores the data of a set, unless another thread has stored them. Returns the stored data and whether this call
    /// stored them, or `None` if the table is full.
    pub fn put(&self, set: usize, new: S) -> Option<(&S, bool)> {
        let mut new = Some((set, Box::new(new)));
        for cell in self.cells(set) {
            if let Some(made) = new.take() {
                new = cell.set(made).err();
            }
            if let Some((number, kept)) = cell.get()
                && *number == set
            {
                return Some((kept, new.is_none()));
            }
        }
        None
    }

    /// Number of sets that have occurred.
    pub fn count(&self) -> usize {
        self.cells
            .iter()
            .filter(|cell| cell.get().is_some())
            .count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Two threads store the same sets in opposite order. Each set has one entry with its data, and the table accepts
    /// no more than its capacity.
    #[test]
    fn every_set_is_kept_once() {
        let most = 1000;
        // Neighbours, and numbers that differ only in their high digits.
        let set = |number: usize| {
            if number.is_multiple_of(2) { number } else { number << 40 }
        };
        let slots = Slots::hashed(most);
        let stored = AtomicUsize::new(0);
        let fill = |numbers: &mut dyn Iterator<Item = usize>| {
            for number in numbers {
                let Some((kept, is_first)) = slots.put(set(number), number) else {
                    panic!("no room for {number}")
                };
                assert_eq!(kept, &number);
                stored.fetch_add(usize::from(is_first), Ordering::Relaxed);
                assert_eq!(slots.get(set(number)), Some(&number));
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(|| fill(&mut (0..most)));
            scope.spawn(|| fill(&mut (0..most).rev()));
        });
        assert_eq!((slots.count(), stored.into_inner()), (most, most));
        assert_eq!(slots.get(set(most)), None);
        let all = (0..2 * most).filter(|number| slots.put(set(*number), *number).is_some());
        assert_eq!(all.count(), 2 * most);
        assert_eq!(slots.put(set(2 * most), 0), None);
    }
}
