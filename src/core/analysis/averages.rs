//! Averages of a quantity per mesh cycle, over successive stretches of cycles.

/// Mesh cycles per stored average: short compared with the blocks of an error bar.
pub const CYCLES_PER_AVERAGE: u32 = 10;

/// Maximum number of averages per trajectory, even. It bounds the memory of long records.
const MOST_AVERAGES: usize = 1 << 16;

/// Averages over successive stretches of equal length.
///
/// If there are too many averages, neighbouring averages are joined in pairs, and the length of a stretch
/// doubles. The blocks of the error bars are far longer than a stretch.
#[derive(Debug, Clone)]
pub struct CycleAverages {
    stretch: u32,
    sum: f64,
    pending: u32,
    values: Vec<f64>,
}

impl Default for CycleAverages {
    fn default() -> Self {
        Self {
            stretch: CYCLES_PER_AVERAGE,
            sum: 0.0,
            pending: 0,
            values: Vec::new(),
        }
    }
}

impl CycleAverages {
    /// Adds the value of one mesh cycle.
    pub fn push(&mut self, value: f64) {
        self.sum += value;
        self.pending += 1;
        if self.pending == self.stretch {
            self.values.push(self.sum / f64::from(self.stretch));
            self.sum = 0.0;
            self.pending = 0;
        }
        if self.values.len() == MOST_AVERAGES {
            self.join();
        }
    }

    /// Appends the averages of another trajectory, without its incomplete stretch.
    pub fn append(&mut self, other: &Self) {
        let mut other = other.clone();
        while self.stretch < other.stretch {
            self.join();
        }
        while other.stretch < self.stretch {
            other.join();
        }
        self.values.append(&mut other.values);
    }

    /// Keeps only the complete stretches within the first `cycles`.
    pub fn cut(&mut self, cycles: u64) {
        self.values
            .truncate((cycles / u64::from(self.stretch)) as usize);
        self.sum = 0.0;
        self.pending = 0;
    }

    /// Replaces each pair of neighbouring averages by its mean.
    fn join(&mut self) {
        self.values = (self.values.chunks_exact(2))
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .collect();
        self.stretch *= 2;
    }

    /// The averages, in order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Mesh cycles per average.
    pub fn stretch(&self) -> u32 {
        self.stretch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Long records have as many averages as short ones, over longer stretches, and the same mean.
    #[test]
    fn averages_are_joined_before_they_fill_the_memory() {
        let mut averages = CycleAverages::default();
        let growth = |cycle: u32| f64::from(cycle % 7) - 2.0;
        let cycles = 10 * (1 << 16) + 80;
        for cycle in 0..cycles {
            averages.push(growth(cycle));
            assert!(averages.values().len() < MOST_AVERAGES);
        }
        assert_eq!(averages.stretch(), 20);
        assert_eq!(averages.values().len(), (1 << 15) + 4);
        for (stretch, value) in averages.values().iter().enumerate() {
            let first = 20 * stretch as u32;
            let exact = (first..first + 20).map(growth).sum::<f64>() / 20.0;
            assert!((value - exact).abs() < 1e-14, "{stretch}: {value} {exact}");
        }
    }

    /// Records of different stretches are joined at the longer stretch.
    #[test]
    fn averages_of_another_trajectory_come_behind() {
        let record = |cycles: u32, first: u32| {
            let mut averages = CycleAverages::default();
            (first..first + cycles).for_each(|cycle| averages.push(f64::from(cycle)));
            averages
        };
        let mut short = record(40, 1_000_000);
        let long = record(10 * (1 << 16), 0);
        let mut joined = long.clone();
        joined.append(&short);
        assert_eq!(
            (joined.stretch(), joined.values().len()),
            (20, (1 << 15) + 2)
        );
        assert_eq!(joined.values()[1 << 15], 1_000_009.5);
        short.append(&long);
        assert_eq!((short.stretch(), short.values().len()), (20, (1 << 15) + 2));
        assert_eq!(short.values()[2..], *long.values());
    }
}
