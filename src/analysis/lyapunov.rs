//! How fast do nearby trajectories part?
//!
//! Tangent vectors are integrated beside the trajectory (saltations included) and
//! orthonormalised once a mesh cycle in the energy norm, the neutral pair projected out
//! (Benettin et al. 1980, Shimada & Nagashima 1979); the logarithms of their lengths average
//! to the exponents. Standard errors come from block averages.

use super::norm::EnergyNorm;
use crate::numerics::random::Stream;
use crate::numerics::statistics::{mean, standard_error};
use crate::propagate::Tangents;

/// Mesh cycles in one stored average of tangents and twin; short against the blocks of an
/// error bar.
pub const CYCLES_PER_AVERAGE: u32 = 10;

/// Growth of tangent vectors.
#[derive(Debug, Clone)]
pub struct TangentGrowth {
    tangents: Tangents,
    sums: Vec<f64>,
    pending: u32,
    averages: Vec<Vec<f64>>,
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
            sums: vec![0.0; count],
            pending: 0,
            averages: vec![Vec::new(); count],
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
        self.sums.fill(0.0);
        self.pending = 0;
        self.averages.iter_mut().for_each(Vec::clear);
    }

    /// To be called after every integrated cycle.
    pub fn cycle(&mut self, norm: &EnergyNorm) {
        self.orthonormalise(norm, |_| {});
        self.pending += 1;
        if self.pending == CYCLES_PER_AVERAGE {
            for (sum, averages) in self.sums.iter_mut().zip(&mut self.averages) {
                averages.push(*sum / f64::from(CYCLES_PER_AVERAGE));
                *sum = 0.0;
            }
            self.pending = 0;
        }
    }

    /// As [`Self::cycle`]; appends what orthonormalising took, the upper triangle of the factor R that
    /// the orthonormal tangents have to be multiplied by, column by column.
    pub fn factor(&mut self, norm: &EnergyNorm, triangle: &mut Vec<f64>) {
        self.orthonormalise(norm, |entry| triangle.push(entry));
    }

    /// Averages of the largest exponent over successive stretches of ten cycles.
    pub fn averages(&self) -> &[f64] {
        &self.averages[0]
    }

    /// The exponents per mesh cycle, largest first; none before ten cycles.
    pub fn exponents(&self) -> Option<Vec<f64>> {
        let series = self.series();
        (!self.averages[0].is_empty()).then(|| series.iter().map(|a| mean(a)).collect())
    }

    /// Averages of every exponent over successive stretches of ten cycles, that of the largest
    /// first.
    pub fn series(&self) -> Vec<&[f64]> {
        let mut series: Vec<&[f64]> = self.averages.iter().map(Vec::as_slice).collect();
        series.sort_by(|a, b| mean(b).total_cmp(&mean(a)));
        series
    }

    /// Modified Gram–Schmidt; adds the logarithms of the lengths to the sums and tells every entry of
    /// the triangular factor.
    fn orthonormalise(&mut self, norm: &EnergyNorm, mut tell: impl FnMut(f64)) {
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
            self.sums[i] += length.ln();
            for x in self.tangents.vector_mut(i) {
                *x /= length;
            }
        }
    }
}

/// A random direction, each component of the same energy on average.
pub fn random_direction(norm: &EnergyNorm, stream: &mut Stream, x: &mut [f64]) {
    for (x, w) in x.iter_mut().zip(norm.weights()) {
        let deviate = stream.normal();
        *x = if *w > 0.0 { deviate / w } else { 0.0 };
    }
}

/// Distance of a twin unless asked otherwise, in half gaps: far above round-off, far below the gap.
pub const SEPARATION: f64 = 1e-7;

/// What a finite distance of [`SEPARATION`] may do to a twin's exponent \[1/cycle\]. Next to
/// grazing contacts 2.9e-4 was seen, in proportion to the distance: 2.5e-3 at 1e-6, 3e-5 at 1e-8. At
/// 3e-9 round-off moves the exponent of integrable motion by 2.4e-3. Half the exponent that counts
/// as none, so that no verdict hangs on it.
const FINITE_DISTANCE: f64 = 5e-4;

/// Whether two estimates of one exponent agree: the mean difference of their averages over
/// the same stretches lies within three standard errors of itself.
///
/// Differences below [`FINITE_DISTANCE`] are agreement whatever their error, of larger separations
/// in proportion. So are those of the twin's `round_off`, which do not average out where the state
/// is large.
pub fn agree(tangent: &[f64], twin: &[f64], separation: f64, round_off: f64) -> Option<bool> {
    let allowed = FINITE_DISTANCE * (separation / SEPARATION).max(1.0) + round_off;
    let differences: Vec<f64> = tangent.iter().zip(twin).map(|(a, b)| a - b).collect();
    let error = standard_error(&differences);
    error
        .is_finite()
        .then(|| mean(&differences).abs() <= 3.0 * error + allowed)
}
