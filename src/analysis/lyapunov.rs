//! How fast do nearby trajectories part?
//!
//! Tangent vectors are integrated beside the trajectory (saltations included) and
//! orthonormalised once a mesh cycle in the energy norm, the neutral pair projected out
//! (Benettin et al. 1980, Shimada & Nagashima 1979); the logarithms of their lengths average
//! to the exponents. Standard errors come from block averages.

use super::norm::EnergyNorm;
use crate::numerics::random::Stream;
use crate::numerics::statistics::mean;
use crate::propagate::Tangents;

/// Mesh cycles in one stored average of tangents and twin; short against the blocks of an
/// error bar.
pub const CYCLES_PER_AVERAGE: u32 = 10;

/// Most averages that are kept of one rate, even: memory does not grow with the cycles beyond.
const MOST_AVERAGES: usize = 1 << 16;

/// Averages of a rate of growth \[1/cycle\] over successive stretches of as many cycles.
///
/// Where they grow too many neighbours are joined in pairs, and stretches are twice as long from then on. Error
/// bars take blocks that are longer by far.
#[derive(Debug, Clone)]
pub struct GrowthAverages {
    stretch: u32,
    sum: f64,
    pending: u32,
    values: Vec<f64>,
}

impl Default for GrowthAverages {
    fn default() -> Self {
        Self {
            stretch: CYCLES_PER_AVERAGE,
            sum: 0.0,
            pending: 0,
            values: Vec::new(),
        }
    }
}

impl GrowthAverages {
    /// Adds the growth of a cycle.
    pub fn push(&mut self, growth: f64) {
        self.sum += growth;
        self.pending += 1;
        if self.pending == self.stretch {
            self.values.push(self.sum / f64::from(self.stretch));
            self.sum = 0.0;
            self.pending = 0;
        }
        if self.values.len() == MOST_AVERAGES {
            self.values = (self.values.chunks_exact(2))
                .map(|pair| 0.5 * (pair[0] + pair[1]))
                .collect();
            self.stretch *= 2;
        }
    }

    /// The averages, in order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Mesh cycles of one.
    pub fn stretch(&self) -> u32 {
        self.stretch
    }
}

/// Growth of tangent vectors.
#[derive(Debug, Clone)]
pub struct TangentGrowth {
    tangents: Tangents,
    averages: Vec<GrowthAverages>,
}

impl TangentGrowth {
    /// `count` tangents in random directions.
    pub fn new(norm: &EnergyNorm, modes: usize, count: usize, stream: &mut Stream) -> Self {
        let mut tangents = Tangents::zeros(modes, count);
        for i in 0..count {
            random_direction(norm, stream, tangents.vector_mut(i));
        }
        let mut growth = Self {
            tangents,
            averages: vec![GrowthAverages::default(); count],
        };
        growth.orthonormalise(norm, |_| {});
        growth.restart();
        growth
    }

    /// The tangents, to be integrated by a kernel.
    pub fn tangents(&mut self) -> &mut Tangents {
        &mut self.tangents
    }

    /// The direction of strongest growth.
    pub fn leading(&self) -> &[f64] {
        self.tangents.vector(0)
    }

    /// Forgets all growth so far, keeps the directions.
    pub fn restart(&mut self) {
        self.averages.fill_with(GrowthAverages::default);
    }

    /// To be called after every integrated cycle; the growth of the first tangent in it.
    pub fn cycle(&mut self, norm: &EnergyNorm) -> f64 {
        self.orthonormalise(norm, |_| {})
    }

    /// As [`Self::cycle`]; appends what orthonormalising took, the upper triangle of the factor R that
    /// the orthonormal tangents have to be multiplied by, column by column.
    pub fn factor(&mut self, norm: &EnergyNorm, triangle: &mut Vec<f64>) {
        self.orthonormalise(norm, |entry| triangle.push(entry));
    }

    /// Averages of the largest exponent.
    pub fn averages(&self) -> &GrowthAverages {
        &self.averages[0]
    }

    /// The exponents per mesh cycle, largest first; none before ten cycles.
    pub fn exponents(&self) -> Option<Vec<f64>> {
        let series = self.series();
        (!series[0].is_empty()).then(|| series.iter().map(|a| mean(a)).collect())
    }

    /// Averages of every exponent over the same stretches, that of the largest first.
    pub fn series(&self) -> Vec<&[f64]> {
        let mut series: Vec<&[f64]> = self.averages.iter().map(GrowthAverages::values).collect();
        series.sort_by(|a, b| mean(b).total_cmp(&mean(a)));
        series
    }

    /// Modified Gram–Schmidt; adds the logarithms of the lengths to the averages and tells every entry of
    /// the triangular factor. That of the first length is returned.
    fn orthonormalise(&mut self, norm: &EnergyNorm, mut tell: impl FnMut(f64)) -> f64 {
        let mut first = 0.0;
        for i in 0..self.tangents.count() {
            norm.project(self.tangents.vector_mut(i));
            for j in 0..i {
                let along = norm.product(self.tangents.vector(j), self.tangents.vector(i));
                tell(along);
                let other = self.tangents.vector(j).to_vec();
                for (x, y) in self.tangents.vector_mut(i).iter_mut().zip(&other) {
                    *x -= along * y;
                }
            }
            let length = norm.length(self.tangents.vector(i));
            tell(length);
            let growth = length.ln();
            self.averages[i].push(growth);
            if i == 0 {
                first = growth;
            }
            for x in self.tangents.vector_mut(i) {
                *x /= length;
            }
        }
        first
    }
}

/// A random direction, each component of the same energy on average.
pub fn random_direction(norm: &EnergyNorm, stream: &mut Stream, x: &mut [f64]) {
    for (x, w) in x.iter_mut().zip(norm.weights()) {
        let deviate = stream.normal();
        *x = if *w > 0.0 { deviate / w } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Long records are kept in as many averages as short ones, over longer stretches, and have the same mean.
    #[test]
    fn averages_are_joined_before_they_fill_the_memory() {
        let mut averages = GrowthAverages::default();
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
}
