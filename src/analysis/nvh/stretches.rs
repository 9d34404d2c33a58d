//! Sums over successive stretches of equal length, in bounded memory: what error bars are
//! taken from.

/// Most stretches kept; twice as many as any level of an error bar needs to be of use.
const MOST: usize = 2048;

/// Something that can be added up.
pub(in crate::analysis) trait Summable: Clone {
    /// Adds another sum to this one.
    fn add(&mut self, other: &Self);
    /// Back to zero.
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

/// Sums over stretches of `length` units each. When there are [`MOST`], neighbours are
/// joined, and stretches are twice as long from then on.
#[derive(Debug, Clone)]
pub(in crate::analysis) struct Stretches<T> {
    closed: Vec<T>,
    open: T,
    filled: u64,
    first_length: u64,
    length: u64,
}

impl<T: Summable> Stretches<T> {
    /// No stretch yet; `empty` is a sum of nothing.
    pub(in crate::analysis) fn new(empty: T, length: u64) -> Self {
        Self {
            closed: Vec::new(),
            open: empty,
            filled: 0,
            first_length: length,
            length,
        }
    }

    /// Forgets everything.
    pub(in crate::analysis) fn restart(&mut self) {
        self.closed.clear();
        self.open.clear();
        self.filled = 0;
        self.length = self.first_length;
    }

    /// The sum of the present stretch.
    pub(in crate::analysis) fn open(&mut self) -> &mut T {
        &mut self.open
    }

    /// A unit is over.
    pub(in crate::analysis) fn advance(&mut self) {
        self.filled += 1;
        if self.filled < self.length {
            return;
        }
        self.closed.push(self.open.clone());
        self.open.clear();
        self.filled = 0;
        if self.closed.len() == MOST {
            self.closed = (self.closed.chunks_exact(2))
                .map(|pair| {
                    let mut sum = pair[0].clone();
                    sum.add(&pair[1]);
                    sum
                })
                .collect();
            self.length *= 2;
        }
    }

    /// Units in a whole stretch.
    pub(in crate::analysis) fn length(&self) -> u64 {
        self.length
    }

    /// The whole stretches, in time.
    pub(in crate::analysis) fn closed(&self) -> &[T] {
        &self.closed
    }

    /// The sum over everything, the present stretch included.
    pub(in crate::analysis) fn total(&self) -> T {
        let mut sum = self.open.clone();
        for stretch in &self.closed {
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
        let mut stretches = Stretches::new([0.0; 2], 3);
        let units = 3 * 5000 + 2;
        for unit in 0..units {
            stretches.open().add(&[1.0, f64::from(unit)]);
            stretches.advance();
        }
        let n = f64::from(units);
        assert_eq!(stretches.total(), [n, 0.5 * n * (n - 1.0)]);
        // 5000 stretches of three, joined twice.
        assert_eq!(stretches.closed().len(), 1250);
        assert!(stretches.closed().iter().all(|s| s[0] == 12.0));
        stretches.restart();
        stretches.open().add(&[1.0, 1.0]);
        for _ in 0..3 {
            stretches.advance();
        }
        assert_eq!(stretches.closed(), [[1.0, 1.0]]);
    }
}
