//! One cycle of a mesh table and its derived quantities: means, segments, extremes, harmonics.

use super::NODES;
use crate::gear::sharing::MOST_PAIRS;
use crate::model::{Division, FlankError, Stiffness};
use crate::numerics::legendre::{at_end, at_start, derivative, evaluate, transforms8};
use crate::numerics::quadrature::GaussLegendre;
use crate::numerics::roots::sign_changes;
use std::f64::consts::TAU;

/// A tangent error below this part of the transmission error is round-off of flanks without error.
const NO_ERROR: f64 = 1e-12;

/// The mesh cycle at one misalignment and torque. Values are `[piece][node]`.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshTableCycle {
    /// Mesh force F \[N\].
    pub force: f64,
    /// Ends of the pieces in mesh phase, 0 first and 1 last.
    pub breaks: Vec<f64>,
    /// Mesh stiffness \[N/m\], tangent or secant as in [`MeshTable::stiffness`](super::MeshTable::stiffness).
    pub stiffness: Vec<[f64; NODES]>,
    /// Load centroid \[m\].
    pub centre: Vec<[f64; NODES]>,
    /// Loaded static transmission error \[m\].
    pub transmission_error: Vec<[f64; NODES]>,
    /// Friction direction Λ₀.
    pub friction: Vec<[f64; NODES]>,
    /// Friction lever Λ₁ \[m\].
    pub friction_lever: Vec<[f64; NODES]>,
    /// Loaded part of the lines of contact.
    pub contact_fraction: Vec<[f64; NODES]>,
    /// Pairs of teeth that carry load.
    pub loaded_pairs: Vec<[f64; NODES]>,
    /// `[pair][piece][node]`: share of each pair in the load.
    pub share: [Vec<[f64; NODES]>; MOST_PAIRS],
}

/// A piece of the cycle for a run: polynomials of stiffness and tangent error, means of the other quantities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshTablePiece {
    /// Mesh phase at its start.
    pub start: f64,
    /// Mesh phase at its end.
    pub end: f64,
    /// Legendre coefficients of the stiffness on the piece \[N/m\].
    pub stiffness: [f64; NODES],
    /// Legendre coefficients of the tangent error `x − F/k` \[m\].
    pub tangent_error: [f64; NODES],
    /// Mean load centroid \[m\].
    pub centre: f64,
    /// Mean friction direction Λ₀.
    pub friction: f64,
    /// Mean friction lever Λ₁ \[m\].
    pub friction_lever: f64,
}

impl MeshTablePiece {
    /// The piece as a division of the mesh cycle.
    pub fn division(&self) -> Division {
        Division {
            end: self.end,
            stiffness: Stiffness::series(self.stiffness),
            error: FlankError::series(self.tangent_error),
            load_centre: self.centre,
            friction: [self.friction, self.friction_lever],
        }
    }
}

/// Means over an interval of the mesh cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentMeans {
    /// Mesh stiffness \[N/m\], tangent or secant as in [`MeshTable::stiffness`](super::MeshTable::stiffness).
    pub stiffness: f64,
    /// Tangent error `x − F/k` \[m\].
    pub tangent_error: f64,
    /// Load centroid \[m\].
    pub centre: f64,
    /// Friction direction Λ₀.
    pub friction: f64,
    /// Friction lever Λ₁ \[m\].
    pub friction_lever: f64,
}

impl MeshTableCycle {
    /// `x − F/k` \[m\], `[piece][node]`: the transmission error e with which the linear law `F = k (Σ w q − e)` meets
    /// the true law at the load of this cycle, as its tangent or its secant. 0 for flanks without misalignment, relief
    /// and deviation.
    pub fn tangent_error(&self) -> Vec<[f64; NODES]> {
        let pieces = self.transmission_error.iter().zip(&self.stiffness);
        pieces
            .map(|(x, k)| std::array::from_fn(|node| x[node] - self.force / k[node]))
            .collect()
    }

    /// Mean over the cycle of one of this cycle's quantities.
    pub fn mean(&self, values: &[[f64; NODES]]) -> f64 {
        let pieces = self.breaks.windows(2).zip(values);
        pieces
            .map(|(ends, values)| (ends[1] - ends[0]) * piece_mean(values))
            .sum()
    }

    /// One of this cycle's quantities at a mesh phase in \[0, 1\]; on a break below 1, its value to
    /// the right.
    pub fn value(&self, values: &[[f64; NODES]], phase: f64) -> f64 {
        let after = self.breaks.partition_point(|&end| end <= phase);
        let piece = after.clamp(1, values.len()) - 1;
        let (start, end) = (self.breaks[piece], self.breaks[piece + 1]);
        let x = (2.0 * phase - (start + end)) / (end - start);
        evaluate(&series(&values[piece]), x)
    }

    /// This cycle with its stiffness scaled to another mean \[N/m\]. The linear law still has the force F at the
    /// transmission error x.
    pub fn with_mean_stiffness(mut self, mean: f64) -> Self {
        let factor = mean / self.mean_stiffness();
        for value in self.stiffness.as_flattened_mut() {
            *value *= factor;
        }
        self
    }

    /// Mean stiffness \[N/m\].
    pub fn mean_stiffness(&self) -> f64 {
        self.mean(&self.stiffness)
    }

    /// Mean load centroid \[m\].
    pub fn mean_centre(&self) -> f64 {
        self.mean(&self.centre)
    }

    /// Mean number of pairs of teeth that carry load anywhere on the face: the contact ratio under load.
    pub fn mean_loaded_pairs(&self) -> f64 {
        self.mean(&self.loaded_pairs)
    }

    /// The pieces, in order.
    pub fn pieces(&self) -> Vec<MeshTablePiece> {
        let error = self.tangent_error();
        (self.breaks.windows(2).enumerate())
            .map(|(piece, ends)| MeshTablePiece {
                start: ends[0],
                end: ends[1],
                stiffness: series(&self.stiffness[piece]),
                tangent_error: series(&error[piece]),
                centre: piece_mean(&self.centre[piece]),
                friction: piece_mean(&self.friction[piece]),
                friction_lever: piece_mean(&self.friction_lever[piece]),
            })
            .collect()
    }

    /// Means over `count` equal segments of the cycle, in order.
    pub fn segment_means(&self, count: usize) -> Vec<SegmentMeans> {
        (0..count)
            .map(|segment| self.means([segment, segment + 1].map(|i| i as f64 / count as f64)))
            .collect()
    }

    /// Means between two mesh phases in \[0, 1\].
    pub fn means(&self, ends: [f64; 2]) -> SegmentMeans {
        SegmentMeans {
            stiffness: self.mean_between(&self.stiffness, ends),
            tangent_error: self.mean_between(&self.tangent_error(), ends),
            centre: self.mean_between(&self.centre, ends),
            friction: self.mean_between(&self.friction, ends),
            friction_lever: self.mean_between(&self.friction_lever, ends),
        }
    }

    /// Whether the flanks have an error under load: `x` and `F/k` differ by more than round-off.
    pub fn has_error(&self) -> bool {
        let largest = |values: &[[f64; NODES]]| {
            let all = values.as_flattened().iter();
            all.fold(0.0_f64, |most, value| most.max(value.abs()))
        };
        largest(&self.tangent_error()) > NO_ERROR * largest(&self.transmission_error)
    }

    /// Mean between two mesh phases, from the first Legendre coefficient of the part of each piece between
    /// them.
    fn mean_between(&self, values: &[[f64; NODES]], [from, to]: [f64; 2]) -> f64 {
        let transforms = transforms8();
        let mut sum = 0.0;
        for (ends, values) in self.breaks.windows(2).zip(values) {
            let (low, high) = (ends[0].max(from), ends[1].min(to));
            if low < high {
                let place = |phase: f64| 2.0 * (phase - ends[0]) / (ends[1] - ends[0]) - 1.0;
                let part = transforms.restrict(&series(values), place(low), place(high));
                sum += part[0] * (high - low);
            }
        }
        sum / (to - from)
    }

    /// Difference of the largest and the smallest loaded transmission error \[m\], jumps between pieces included.
    pub fn peak_to_peak(&self) -> f64 {
        self.range(&self.transmission_error)
    }

    /// Difference of the largest and the smallest value of one of this cycle's quantities, jumps between pieces
    /// included.
    pub fn range(&self, values: &[[f64; NODES]]) -> f64 {
        let [lowest, highest] = self.extremes(values);
        highest - lowest
    }

    /// Smallest and largest value of one of this cycle's quantities, jumps between pieces included.
    pub fn extremes(&self, values: &[[f64; NODES]]) -> [f64; 2] {
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut meet = |value: f64| {
            lowest = lowest.min(value);
            highest = highest.max(value);
        };
        for values in values {
            let series = series(values);
            meet(at_start(&series));
            meet(at_end(&series));
            let slope = derivative(&series);
            // Round-off of differences of the values, times the amplification by a derivative of degree
            // seven.
            let scale = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let noise = 64.0 * f64::EPSILON * scale;
            let turn = |x, _| meet(evaluate(&series, x));
            sign_changes(transforms8(), &slope, noise, &mut None, turn);
        }
        [lowest, highest]
    }

    /// The first `count` harmonics of one of this cycle's quantities,
    /// `mean + Σ A_m cos(2π m φ + ψ_m)`: (m, A_m, ψ_m \[rad\]).
    pub fn harmonics(&self, values: &[[f64; NODES]], count: u32) -> Vec<(u32, f64, f64)> {
        // Enough nodes for a polynomial times an oscillation over the longest piece.
        let longest = (self.breaks.windows(2)).fold(0.0_f64, |m, ends| m.max(ends[1] - ends[0]));
        let turns = f64::from(count) * longest;
        let rule = GaussLegendre::new(16 + (8.0 * turns).ceil() as usize);
        let mut sums = vec![[0.0; 2]; count as usize];
        for (ends, values) in self.breaks.windows(2).zip(values) {
            let half = 0.5 * (ends[1] - ends[0]);
            let series = series(values);
            for (x, weight) in rule.nodes.iter().zip(&rule.weights) {
                let value = half * weight * evaluate(&series, *x);
                let phase = ends[0] + half * (x + 1.0);
                for (harmonic, sum) in (1..).zip(&mut sums) {
                    let (sin, cos) = (TAU * f64::from(harmonic) * phase).sin_cos();
                    sum[0] += value * cos;
                    sum[1] += value * sin;
                }
            }
        }
        (1..)
            .zip(sums)
            .map(|(harmonic, [cos, sin])| (harmonic, 2.0 * cos.hypot(sin), (-sin).atan2(cos)))
            .collect()
    }
}

fn series(values: &[f64; NODES]) -> [f64; NODES] {
    transforms8().interpolate(values)
}

fn piece_mean(values: &[f64; NODES]) -> f64 {
    let terms = values.iter().zip(transforms8().weights());
    0.5 * terms.map(|(value, weight)| weight * value).sum::<f64>()
}
