//! Values in order of time, in bounded memory, for quantiles.

/// Maximum number of values per record of one kind, even.
const MOST_VALUES: usize = 1 << 16;

/// A sample in order of time. It contains every value if there are at most [`MOST_VALUES`], otherwise
/// every second, every fourth, and so on, evenly over the whole record.
#[derive(Debug, Clone)]
pub(super) struct Sample<T> {
    values: Vec<T>,
    stride: u64,
    skipped: u64,
}

impl<T: Copy> Sample<T> {
    pub(super) fn new() -> Self {
        Self {
            values: Vec::new(),
            stride: 1,
            skipped: 0,
        }
    }

    pub(super) fn restart(&mut self) {
        *self = Self::new();
    }

    pub(super) fn push(&mut self, value: T) {
        if self.skipped > 0 {
            self.skipped -= 1;
            return;
        }
        if self.values.len() >= MOST_VALUES {
            self.thin(2 * self.stride);
        }
        self.values.push(value);
        self.skipped = self.stride - 1;
    }

    /// Appends the record of another trajectory. Both records are thinned to the larger stride, so that each
    /// has a weight in proportion to its length.
    pub(super) fn append(&mut self, other: &Self) {
        let stride = self.stride.max(other.stride);
        self.thin(stride);
        let step = (stride / other.stride) as usize;
        self.values.extend(other.values.iter().step_by(step));
        self.skipped = 0;
    }

    /// Keeps the values of the sample that are among the first `count` pushed values.
    pub(super) fn cut(&mut self, count: u64) {
        self.values.truncate(count.div_ceil(self.stride) as usize);
    }

    /// Drops values evenly until they are `stride` apart, a multiple of the present stride.
    fn thin(&mut self, stride: u64) {
        let step = (stride / self.stride) as usize;
        self.stride = stride;
        if step == 1 {
            return;
        }
        let mut place = 0;
        self.values.retain(|_| {
            place += 1;
            (place - 1) % step == 0
        });
    }

    /// The values in order of time.
    pub(super) fn values(&self) -> &[T] {
        &self.values
    }

    /// Whether no value was dropped.
    pub(super) fn is_whole(&self) -> bool {
        self.stride == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(count: usize) -> Sample<f64> {
        let mut sample = Sample::new();
        for i in 0..count {
            sample.push(i as f64);
        }
        sample
    }

    #[test]
    fn a_full_sample_is_thinned_evenly() {
        let count = 5 * MOST_VALUES / 2;
        let sample = counted(count);
        assert_eq!(sample.stride, 4);
        assert!(sample.values.len() > MOST_VALUES / 2);
        let even = sample.values.iter().enumerate();
        assert!(
            even.clone()
                .all(|(place, value)| *value == 4.0 * place as f64)
        );
        assert!(count - 4 * sample.values.len() < 4);
    }

    #[test]
    fn samples_are_joined_at_the_coarser_stride() {
        let long = counted(5 * MOST_VALUES / 2);
        let short = counted(10);
        for (first, second) in [(&long, &short), (&short, &long)] {
            let mut both = first.clone();
            both.append(second);
            assert_eq!(both.stride, 4);
            assert!(!both.is_whole());
            let expected = [first, second].into_iter().flat_map(|own| {
                let every_fourth = own.values.iter().filter(|value| *value % 4.0 == 0.0);
                every_fourth.copied()
            });
            assert!(both.values.iter().copied().eq(expected));
        }
    }
}
