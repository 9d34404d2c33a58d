//! How fast do nearby trajectories separate?
//!
//! Tangent vectors are integrated beside the trajectory (saltations included). Once per mesh cycle they
//! are orthonormalised in the energy norm, without the neutral pair (Benettin et al. 1980, Shimada &
//! Nagashima 1979). The logarithms of their lengths average to the exponents. Standard errors come from
//! block averages.
//!
//! A slip of a dry slider removes a dimension from the tangents. A rigid stop that begins to hold the
//! structure removes two. The last exponents are then −∞, because orthogonalisation leaves only round-off of
//! these tangents. The number of tangents that may count as round-off is the number that sliders and stops
//! can remove. Other tangents can also be that short, because a strong damper contracts them.

use super::averages::CycleAverages;
use super::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::Stream;
use crate::numerics::statistics::mean;
use crate::propagate::Tangents;

/// Length, relative to the tangent, below which the rest after orthogonalisation is round-off: some hundreds
/// of units in the last place.
const ROUND_OFF: f64 = 1e-13;

/// Tangent vectors and their growth.
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

    /// Forgets all growth and keeps the directions.
    pub fn restart(&mut self) {
        self.averages.fill_with(CycleAverages::default);
    }

    /// Records the growth over an integrated cycle, and orthonormalises the tangents. Returns the growth of the
    /// first tangent. Must be called after every cycle.
    pub fn cycle(&mut self, norm: &EnergyNorm) -> f64 {
        self.orthonormalise(norm, |_| {})
    }

    /// As [`Self::cycle`], and appends the upper triangle of the factor R, column by column. The tangents
    /// before orthonormalisation are the orthonormal tangents times R.
    pub fn factor(&mut self, norm: &EnergyNorm, triangle: &mut Vec<f64>) {
        self.orthonormalise(norm, |entry| triangle.push(entry));
    }

    /// Appends the growth of another trajectory.
    pub fn append(&mut self, other: &Self) {
        for (averages, behind) in self.averages.iter_mut().zip(&other.averages) {
            averages.append(behind);
        }
    }

    /// Keeps only the growth of the first `cycles`.
    pub fn cut(&mut self, cycles: u64) {
        self.averages
            .iter_mut()
            .for_each(|averages| averages.cut(cycles));
    }

    /// Averages of the growth of the first tangent, which give the largest exponent.
    pub fn averages(&self) -> &CycleAverages {
        &self.averages[0]
    }

    /// The exponents per mesh cycle, largest first; `None` before the first average over ten cycles.
    pub fn exponents(&self) -> Option<Vec<f64>> {
        let series = self.series();
        (!series[0].is_empty()).then(|| series.iter().map(|a| mean(a)).collect())
    }

    /// Averages of every exponent over the same stretches, largest exponent first.
    pub fn series(&self) -> Vec<&[f64]> {
        let mut series: Vec<&[f64]> = self.averages.iter().map(CycleAverages::values).collect();
        series.sort_by(|a, b| mean(b).total_cmp(&mean(a)));
        series
    }

    /// Modified Gram–Schmidt. Adds the logarithms of the lengths to the averages, passes every entry of the
    /// triangular factor to `record`, and returns the first logarithm.
    fn orthonormalise(&mut self, norm: &EnergyNorm, mut record: impl FnMut(f64)) -> f64 {
        let mut first = 0.0;
        let left = norm.dimension_when_stuck();
        for i in 0..self.tangents.count() {
            norm.project(self.tangents.vector_mut(i));
            let noise =
                if i < left { 0.0 } else { ROUND_OFF * norm.length(self.tangents.vector(i)) };
            for j in 0..i {
                let along = norm.product(self.tangents.vector(j), self.tangents.vector(i));
                record(along);
                let (other, tangent) = self.tangents.pair_mut(j, i);
                for (x, y) in tangent.iter_mut().zip(other) {
                    *x -= along * y;
                }
            }
            let length = norm.length(self.tangents.vector(i));
            record(length);
            let growth = if length > noise { length.ln() } else { f64::NEG_INFINITY };
            self.averages[i].push(growth);
            if i == 0 {
                first = growth;
            }
            // A tangent that is only round-off is normalised too. It grows like any other direction once no
            // slider slips.
            if length > 0.0 {
                for x in self.tangents.vector_mut(i) {
                    *x /= length;
                }
            }
        }
        first
    }
}

/// A random direction with equal mean energy in each component.
pub fn random_direction(norm: &EnergyNorm, stream: &mut Stream, x: &mut [f64]) {
    for (x, w) in x.iter_mut().zip(norm.weights()) {
        let deviate = stream.normal();
        *x = if *w > 0.0 { deviate / w } else { 0.0 };
    }
}

/// A trajectory displaced by `half_gaps` in a random direction; unchanged if no component has a weight.
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
