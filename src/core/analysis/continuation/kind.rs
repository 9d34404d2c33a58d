//! The kinds of bifurcations, and the functions whose zeros are bifurcations. M is the monodromy matrix of an orbit.

use super::map::CycleMap;
use super::orbit::{Orbit, SAME_ORBIT, length};
use super::path::Span;
use super::touches::Extreme;
use crate::numerics::linalg::eigenpair;
use num_complex::Complex64;
use std::f64::consts::TAU;
use strum::IntoStaticStr;

/// Part of the derivative P_p of the map with respect to the parameter that lies outside the range of M − I,
/// relative to the length of P_p. Above this value, a multiplier +1 is a fold.
const OUT_OF_RANGE: f64 = 1e-6;

/// Distance from the unit circle, or from ±1, below which a multiplier counts as lying there.
pub(super) const ON_CIRCLE: f64 = 1e-4;

/// The kind of a bifurcation.
#[derive(Debug, Clone, Copy, PartialEq, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Kind {
    /// Two orbits of the branch meet, and the parameter reverses.
    Fold,
    /// A multiplier +1 without a reversal of the parameter: another branch crosses.
    BranchPoint,
    /// A multiplier −1: an orbit of twice the period begins.
    PeriodDoubling,
    /// A pair on the unit circle: a torus begins.
    Torus,
    /// An extreme of a contact's depth is zero: the orbit touches the contact's surface.
    Graze {
        /// The extreme.
        extreme: Extreme,
    },
    /// Multipliers jump across the unit circle where the derivative of the map jumps. The branch does not
    /// turn.
    Jump,
    /// The contact sequence changes, although no extreme of a depth is zero.
    Sequence,
    /// The branch merges into orbits of half its period, at their period doubling.
    Merging {
        /// Period of the other orbit, in cycles.
        period: u32,
    },
}

impl Kind {
    /// The word stored in result files.
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// The bifurcation of codimension two between two points of a curve, if any.
    pub fn codimension_two(&self, a: &Orbit, b: &Orbit) -> Option<&'static str> {
        let radius = 1.0 + 1e-6;
        // Round-off puts the critical multiplier on either side of the circle.
        let outside = |orbit: &Orbit| {
            let critical = critical(self, orbit);
            let is_outside = |m: &&Complex64| m.norm() > radius && Some(**m) != critical;
            orbit.multipliers.iter().filter(is_outside).count()
        };
        // Two real multipliers outside the circle that become a pair are no bifurcation.
        let pair_crosses = pairs_outside(a, radius) != pairs_outside(b, radius)
            && outside(a).abs_diff(outside(b)) >= 2;
        match self {
            Self::Fold => {
                if Test::MinusOne.changes(a, b) {
                    return Some("fold and period doubling");
                }
                pair_crosses.then_some("fold and torus")
            }
            Self::PeriodDoubling => {
                if Test::PlusOne.changes(a, b) {
                    return Some("fold and period doubling");
                }
                pair_crosses.then_some("period doubling and torus")
            }
            Self::Torus => {
                let angle = |orbit: &Orbit| critical(self, orbit).map(|m| m.arg());
                let (a, b) = (angle(a)?, angle(b)?);
                let passes = |turn: f64| (a - turn) * (b - turn) < 0.0;
                if passes(TAU / 3.0) {
                    return Some("resonance 1:3");
                }
                passes(TAU / 4.0).then_some("resonance 1:4")
            }
            Self::Graze { extreme } => {
                if Test::PlusOne.changes(a, b) {
                    return Some("graze and fold");
                }
                if Test::MinusOne.changes(a, b) {
                    return Some("graze and period doubling");
                }
                let [a, b] =
                    [a, b].map(|orbit| orbit.details.touches.changes_besides_graze(extreme));
                (a != b).then_some("another graze")
            }
            Self::BranchPoint | Self::Jump | Self::Sequence | Self::Merging { .. } => None,
        }
    }
}

/// The multiplier of an orbit nearest to the critical value of a kind.
pub(super) fn critical(kind: &Kind, orbit: &Orbit) -> Option<Complex64> {
    let near = |wanted: f64| {
        let real = orbit.multipliers.iter().filter(|m| m.im == 0.0);
        real.min_by(|a, b| (a.re - wanted).abs().total_cmp(&(b.re - wanted).abs()))
            .copied()
    };
    match kind {
        Kind::Fold | Kind::BranchPoint => near(1.0),
        Kind::PeriodDoubling => near(-1.0),
        Kind::Torus => {
            let pairs = orbit.multipliers.iter().filter(|m| m.im > 0.0);
            pairs
                .min_by(|a, b| (a.norm() - 1.0).abs().total_cmp(&(b.norm() - 1.0).abs()))
                .copied()
        }
        Kind::Graze { .. } | Kind::Jump | Kind::Sequence | Kind::Merging { .. } => None,
    }
}

/// A function whose zero is a bifurcation.
#[derive(Debug, Clone)]
pub enum Test {
    /// `det(M − I)`.
    PlusOne,
    /// `det(M + I)`.
    MinusOne,
    /// `Π (μ_i μ_j − 1)`.
    Pair,
    /// The depth of the extreme nearest in time to the given one.
    Depth(Extreme),
    /// The displacement after the given number of cycles, projected on the given vector: its value at the
    /// first orbit.
    Offset(u32, Vec<f64>),
}

/// The logarithm of the modulus of the smallest factor of a product, and the sign of the product. Near a zero, the
/// smallest factor is closer to linear than a product of thousands of factors.
fn product(factors: impl Iterator<Item = Complex64>) -> (f64, f64) {
    let (mut smallest, mut sign) = (f64::INFINITY, 1.0);
    for factor in factors {
        smallest = smallest.min(factor.norm_sqr());
        // Complex factors come in pairs, whose product is positive.
        if factor.im == 0.0 && factor.re < 0.0 {
            sign = -sign;
        }
    }
    (0.5 * smallest.ln(), sign)
}

impl Test {
    /// Value of the test at an orbit: the logarithm of a modulus, and a sign. For a product, the modulus is
    /// that of its smallest factor. Logarithms of different tests are not comparable. `None` if the orbit has
    /// no such extreme.
    pub fn at(&self, orbit: &Orbit) -> Option<(f64, f64)> {
        let all = &orbit.multipliers;
        Some(match self {
            Self::PlusOne => product(all.iter().map(|m| m - 1.0)),
            Self::MinusOne => product(all.iter().map(|m| m + 1.0)),
            Self::Pair => {
                let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| all[i] * all[j] - 1.0));
                let real = |z: Complex64| {
                    if z.im.abs() <= 1e-14 * z.norm() { Complex64::new(z.re, 0.0) } else { z }
                };
                product(pairs.map(real))
            }
            Self::Depth(extreme) => signed(
                orbit
                    .details
                    .touches
                    .nearest(extreme, f64::from(orbit.period))?
                    .depth,
            ),
            Self::Offset(cycles, along) => {
                let offset = orbit.offset(*cycles);
                let dot: f64 = offset.iter().zip(along).map(|(a, b)| a * b).sum();
                // The value is negative at an orbit of the shorter period, because such orbits lie beyond the
                // end of the branch.
                match dot / length(along) {
                    off if off.abs() < SAME_ORBIT * orbit.size() => signed(-SAME_ORBIT),
                    off => signed(off),
                }
            }
        })
    }

    /// Whether the signs of the test at two orbits differ.
    pub fn changes(&self, a: &Orbit, b: &Orbit) -> bool {
        matches!((self.at(a), self.at(b)), (Some(a), Some(b)) if a.1 != b.1)
    }
}

/// Number of complex multipliers, two per pair, with a modulus above `radius`.
pub(super) fn pairs_outside(orbit: &Orbit, radius: f64) -> usize {
    let outside = |m: &&Complex64| m.im != 0.0 && m.norm() > radius;
    orbit.multipliers.iter().filter(outside).count()
}

fn signed(value: f64) -> (f64, f64) {
    (value.abs().ln(), if value < 0.0 { -1.0 } else { 1.0 })
}

/// Whether P_p lies in the range of M − I, so that a multiplier +1 belongs to a branch point. With ψ the left
/// null vector of M − I, a fold has `ψ·P_p ≠ 0`.
pub(super) fn is_branch_point(map: &mut impl CycleMap, span: &Span, orbit: &Orbit) -> bool {
    let column = map.by_parameter(&orbit.u, orbit.at, orbit.period, span.axis);
    let transposed = orbit.monodromy.transpose().to_owned();
    let null = eigenpair(transposed.as_ref(), Complex64::ONE);
    let (Ok(column), Some(null)) = (column, null) else {
        return false;
    };
    let along: f64 = null.vector[0].iter().zip(&column).map(|(a, b)| a * b).sum();
    along.abs() <= OUT_OF_RANGE * length(&column)
}

/// Distance of a multiplier from its critical value at a kind of bifurcation.
pub(super) fn off_circle(kind: &Kind, multiplier: Complex64) -> f64 {
    match kind {
        Kind::PeriodDoubling => (multiplier + 1.0).norm(),
        Kind::Torus => (multiplier.norm() - 1.0).abs(),
        _ => (multiplier - 1.0).norm(),
    }
}
