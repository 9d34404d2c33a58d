//! How fast do nearby trajectories part?
//!
//! Tangent vectors are integrated beside the trajectory (saltations included) and
//! orthonormalised once a mesh cycle in the energy norm, the neutral pair projected out
//! (Benettin et al. 1980, Shimada & Nagashima 1979); the logarithms of their lengths average
//! to the exponents. Standard errors come from block averages.
//!
//! A slip of a dry slider takes a dimension from the tangents, and a rigid stop that comes to hold the structure takes two: the exponents of the last ones are −∞. What orthogonalisation
//! leaves of that tangent is round-off. It counts as none where no more tangents than sliders and stops may take are so short. Other
//! tangents are as short as they are: a strong damper may contract them as much.

use super::averages::CycleAverages;
use super::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::Stream;
use crate::numerics::statistics::mean;
use crate::propagate::Tangents;

/// Part of a tangent that orthogonalisation leaves of one in the span of those before: some tens of units of round-off.
const ROUND_OFF: f64 = 1e-13;

/// Growth of tangent vectors.
#[derive(Debug, Clone)]
pub struct TangentGrowth {
    tangents: Tangents,
    averages: Vec<CycleAverages>,
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
            averages: vec![CycleAverages::default(); count],
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
        self.averages.fill_with(CycleAverages::default);
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

    /// Adds the growth in another trajectory behind this one's.
    pub fn append(&mut self, other: &Self) {
        for (averages, behind) in self.averages.iter_mut().zip(&other.averages) {
            averages.append(behind);
        }
    }

    /// Keeps the growth of the first `cycles` alone.
    pub fn cut(&mut self, cycles: u64) {
        self.averages
            .iter_mut()
            .for_each(|averages| averages.cut(cycles));
    }

    /// Averages of the largest exponent.
    pub fn averages(&self) -> &CycleAverages {
        &self.averages[0]
    }

    /// The exponents per mesh cycle, largest first; none before ten cycles.
    pub fn exponents(&self) -> Option<Vec<f64>> {
        let series = self.series();
        (!series[0].is_empty()).then(|| series.iter().map(|a| mean(a)).collect())
    }

    /// Averages of every exponent over the same stretches, that of the largest first.
    pub fn series(&self) -> Vec<&[f64]> {
        let mut series: Vec<&[f64]> = self.averages.iter().map(CycleAverages::values).collect();
        series.sort_by(|a, b| mean(b).total_cmp(&mean(a)));
        series
    }

    /// Modified Gram–Schmidt; adds the logarithms of the lengths to the averages and tells every entry of
    /// the triangular factor. That of the first length is returned.
    fn orthonormalise(&mut self, norm: &EnergyNorm, mut tell: impl FnMut(f64)) -> f64 {
        let mut first = 0.0;
        let left = norm.dimension_held();
        for i in 0..self.tangents.count() {
            norm.project(self.tangents.vector_mut(i));
            let noise =
                if i < left { 0.0 } else { ROUND_OFF * norm.length(self.tangents.vector(i)) };
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
            let growth = if length > noise { length.ln() } else { f64::NEG_INFINITY };
            self.averages[i].push(growth);
            if i == 0 {
                first = growth;
            }
            // What is round-off goes on as a direction, which grows as any other where nothing slips any more.
            if length > 0.0 {
                for x in self.tangents.vector_mut(i) {
                    *x /= length;
                }
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

/// A trajectory displaced by some half gaps in a random direction; as it is where nothing feels a
/// displacement.
pub fn displaced(
    model: &Model,
    norm: &EnergyNorm,
    trajectory: &TrajectoryState,
    half_gaps: f64,
    stream: &mut Stream,
) -> TrajectoryState {
    let mut direction = vec![0.0; trajectory.state.len()];
    random_direction(norm, stream, &mut direction);
    let length = norm.length(&direction);
    let scale = if length > 0.0 { half_gaps * norm.unit() / length } else { 0.0 };
    let state = (trajectory.state.iter().zip(&direction))
        .map(|(x, d)| x + scale * d)
        .collect();
    TrajectoryState::new(model, state, trajectory.cycle)
}
