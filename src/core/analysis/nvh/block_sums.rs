//! Sums over successive stretches of equal length, for error bars. Their memory is bounded.

use std::borrow::Cow;

/// Maximum number of stretches: twice the number that an error bar needs.
const MOST_STRETCHES: usize = 2048;

/// Something that can be added up.
pub(in crate::analysis) trait Summable: Clone {
    /// Adds another sum to this one.
    fn add(&mut self, other: &Self);
    /// Resets to zero.
    fn clear(&mut self);
}

impl<const N: usize> Summable for [f64; N] {
    fn add(&mut self, other: &Self) {
        for (sum, value) in self.iter_mut().zip(other) {
            *sum += value;
        }
    }

    fn clear(&mut self) {
        self.fill(0.0);
    }
}

/// Sums over stretches of `length` units each; the caller chooses the unit, such as a mesh cycle. If there are
/// [`MOST_STRETCHES`] stretches, neighbouring ones are joined, and the length doubles.
#[derive(Debug, Clone)]
pub(in crate::analysis) struct BlockSums<T> {
    complete: Vec<T>,
    current: T,
    filled: u64,
    first_length: u64,
    length: u64,
}

impl<T: Summable> BlockSums<T> {
    /// Sums without stretches; `empty` is an empty sum.
    pub(in crate::analysis) fn new(empty: T, length: u64) -> Self {
        Self {
            complete: Vec::new(),
            current: empty,
            filled: 0,
            first_length: length,
            length,
        }
    }

    /// Forgets everything.
    pub(in crate::analysis) fn restart(&mut self) {
        self.complete.clear();
        self.current.clear();
        self.filled = 0;
        self.length = self.first_length;
    }

    /// The sum of the present stretch.
    pub(in crate::analysis) fn current(&mut self) -> &mut T {
        &mut self.current
    }

    /// Ends one unit. If it was the last one of the present stretch, the next stretch starts.
    pub(in crate::analysis) fn advance(&mut self) {
        self.filled += 1;
        if self.filled < self.length {
            return;
        }
        self.complete.push(self.current.clone());
        self.current.clear();
        self.filled = 0;
        if self.complete.len() >= MOST_STRETCHES {
            self.join();
        }
    }

    /// Joins neighbouring stretches in pairs. A last stretch without a neighbour counts only in the total,
    /// like the present stretch.
    fn join(&mut self) {
        let pairs = self.complete.chunks_exact(2);
        if let [single] = pairs.remainder() {
            self.current.add(single);
        }
        self.complete = pairs
            .map(|pair| {
                let mut sum = pair[0].clone();
                sum.add(&pair[1]);
                sum
            })
            .collect();
        self.length *= 2;
    }

    /// Appends the record of another trajectory. Both records get the longer stretches, and their incomplete
    /// stretches count only in the total. The sum can be evaluated but not continued.
    pub(in crate::analysis) fn append(&mut self, other: &Self) {
        debug_assert_eq!(self.first_length, other.first_length);
        while self.length < other.length {
            self.join();
        }
        let mut other = Cow::Borrowed(other);
        while other.length < self.length {
            other.to_mut().join();
        }
        self.complete.extend_from_slice(&other.complete);
        self.current.add(&other.current);
    }

    /// Keeps only the complete stretches within the first `units`.
    pub(in crate::analysis) fn cut(&mut self, units: u64) {
        self.complete.truncate((units / self.length) as usize);
        self.current.clear();
        self.filled = 0;
    }

    /// Changes every sum, including that of the present stretch.
    pub(in crate::analysis) fn each(&mut self, change: impl Fn(&mut T)) {
        self.complete.iter_mut().for_each(&change);
        change(&mut self.current);
    }

    /// Length of a complete stretch in the caller's units, such as mesh cycles. It doubles when stretches are joined.
    pub(in crate::analysis) fn length(&self) -> u64 {
        self.length
    }

    /// The complete stretches, in order of time.
    pub(in crate::analysis) fn complete(&self) -> &[T] {
        &self.complete
    }

    /// The sum over everything, including the present stretch.
    pub(in crate::analysis) fn total(&self) -> T {
        let mut sum = self.current.clone();
        for stretch in &self.complete {
            sum.add(stretch);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_when_stretches_are_joined() {
        let mut stretches = BlockSums::new([0.0; 2], 3);
        let units = 3 * 5000 + 2;
        for unit in 0..units {
            stretches.current().add(&[1.0, f64::from(unit)]);
            stretches.advance();
        }
        let n = f64::from(units);
        assert_eq!(stretches.total(), [n, 0.5 * n * (n - 1.0)]);
        // 5000 stretches of three, joined twice.
        assert_eq!(stretches.complete().len(), 1250);
        assert!(stretches.complete().iter().all(|s| s[0] == 12.0));
        stretches.restart();
        stretches.current().add(&[1.0, 1.0]);
        for _ in 0..3 {
            stretches.advance();
        }
        assert_eq!(stretches.complete(), [[1.0, 1.0]]);
    }

    /// Sums of 1 and of the number of the unit, from 0, over stretches of three units or more.
    fn counted(units: u32) -> BlockSums<[f64; 2]> {
        let mut stretches = BlockSums::new([0.0; 2], 3);
        for unit in 0..units {
            stretches.current().add(&[1.0, f64::from(unit)]);
            stretches.advance();
        }
        stretches
    }

    #[test]
    fn records_are_joined_at_the_longer_length() {
        // Lengths 12, 3 and 6, the second with an odd number of stretches.
        let records = [3 * 5000 + 2, 3 * 33 + 1, 3 * 2500].map(counted);
        for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0]] {
            let mut all = records[order[0]].clone();
            all.append(&records[order[1]]);
            all.append(&records[order[2]]);
            let total = records.iter().fold([0.0; 2], |mut sum, record| {
                sum.add(&record.total());
                sum
            });
            assert_eq!(all.total(), total);
            assert_eq!(all.length(), 12);
            assert!(all.complete().iter().all(|s| s[0] == 12.0));
            assert_eq!(all.complete().len(), 1250 + 8 + 625);
        }
    }

    #[test]
    fn records_of_one_length_lose_no_stretch() {
        let (mut all, second) = (counted(31), counted(62));
        let stretches = [all.complete(), second.complete()].concat();
        all.append(&second);
        assert_eq!(all.complete(), stretches);
        assert_eq!(all.total()[0], 93.0);
    }
}
