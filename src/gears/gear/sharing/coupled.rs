//! A face with elastically coupled slices: waves of load along it displace teeth and bodies.
//!
//! With t = z/b + ½ and the waves φ_n of [`FaceCoupling`](crate::gear::FaceCoupling) the displacements of the pairs are
//! `d_j(t) = Σ_n d_jn φ_n(t)`, and a pair j presses with the line load
//!
//! ```text
//! q_j = max(0, x − g_j − d_j)/h_j,     d = C q̂,   q̂_jn = ∫ q_j φ_n dt,     F = b Σ_j q̂_j0
//! ```
//!
//! with the compliance of the contact h_j, the only local one. There are few waves, so contact is solved on
//! the whole face at once and its borders are independent of those of slices. With `C = L Lᵀ` and `d = L y` the
//! solution is the minimum of
//!
//! ```text
//! Φ(x, y) = ½ y·y + Σ_j ∫ max(0, x − g_j − d_j)²/(2 h_j) dt − x F/b,
//! ```
//!
//! a convex function with a continuous derivative. Newton's method finds the minimum. In each step the parts
//! of the face in contact are fixed (Conry & Seireg 1973 pose the same problem as a program for the simplex
//! method).

use super::error::{MOST_PAIRS, SharingError};
use super::pairs::{ContactPair, Face};
use super::profile::{Approach, GapProfile, Interval, integrals};
use crate::numerics::plain;
use faer::Mat;

/// A step of Newton's method below this part of the deflection of the contact is followed by one last step.
const LAST_STEP: f64 = 1e-7;

/// Largest number of steps.
const ROUNDS: usize = 100;

/// Number of full steps before the line search checks Φ. From contact on the whole face more steps are rarely needed.
const WHOLE_STEPS: usize = 12;

/// Smallest part of a step in the line search.
const LEAST_PART: f64 = 1.0 / 1024.0;

/// Pairs with coupled slices, under one misalignment.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coupled {
    width: f64,
    slices: usize,
    /// Number of waves along the face, the uniform one included.
    waves: usize,
    /// Compliance of the contact of each pair, times width \[m²/N\].
    contact: Vec<f64>,
    /// L, the waves of a pair in adjacent rows.
    root: Mat<f64>,
    profile: GapProfile,
    /// Whether gaps vary along the face by misalignment only.
    straight: bool,
}

/// Solution for the pairs under a force.
#[derive(Debug, Clone)]
pub(super) struct ContactSolution {
    /// Approach of the gears \[m\].
    pub approach: f64,
    /// Tangent stiffness \[N/m\].
    pub stiffness: f64,
    /// Waves of displacement, pair by pair \[m\].
    displacement: Vec<f64>,
    /// The part of the face in contact.
    pub touching: ContactRegion,
}

/// The part of the face in contact, pair by pair.
#[derive(Debug, Clone, Default)]
pub(in crate::gear) struct ContactRegion(Vec<Vec<Interval>>);

/// The load of a pair.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PairLoad {
    /// Force \[N\].
    pub load: f64,
    /// Moment of the force about mid-face \[N m\].
    pub moment: f64,
    /// Part of the face in contact.
    pub loaded: f64,
    /// Force on each slice \[N\].
    pub pattern: Vec<f64>,
}

/// An iterate: y and x.
#[derive(Debug, Clone)]
struct Iterate {
    y: Mat<f64>,
    approach: f64,
}

/// The parts of the face in contact at an iterate, and the load while these parts are fixed: with
/// `B̃ = ∫ φ φᵀ/h dt`, `ã = ∫ φ/h dt` and `γ̃ = ∫ g φ/h dt` over these parts, `q̂ = x ã − γ̃ − B̃ d`.
struct Patch {
    touching: Vec<Vec<Interval>>,
    products: Mat<f64>,
    means: Mat<f64>,
    gaps: Mat<f64>,
}

impl Coupled {
    /// The pairs on a face. `None` if no gap varies along the face, or if the law does not describe the coupling
    /// of slices.
    ///
    /// # Errors
    /// A contact without compliance, or bodies whose coupling of pairs is unphysically strong.
    pub fn new(
        pairs: &[ContactPair],
        face: Face,
        misalignment: f64,
    ) -> Result<Option<Self>, SharingError> {
        let even = |pair: &ContactPair| pair.gap.windows(2).all(|gap| gap[0] == gap[1]);
        let straight = pairs.iter().all(even);
        if straight && misalignment == 0.0 {
            return Ok(None);
        }
        let Some(face_coupling) = pairs[0].face_coupling.as_ref() else {
            return Ok(None);
        };
        let waves = face_coupling.wave_count() + 1;
        let unknown = |pair: usize| SharingError::Coupling {
            position: pairs[pair].position(),
        };
        let mut compliance = Mat::zeros(pairs.len() * waves, pairs.len() * waves);
        for (i, pair) in pairs.iter().enumerate() {
            let single = face_coupling.of_pair(pair.position()).ok_or(unknown(i))?;
            let uniform = pair.point.compliance() - pair.point.contact;
            write_block(&mut compliance, [i, i], waves, uniform, &single);
            for (j, coupling) in (i + 1..pairs.len()).zip(&pair.point.coupling) {
                let ahead = face_coupling.coupling(pair.position(), j - i);
                let ahead = ahead.ok_or(unknown(i))?;
                write_block(&mut compliance, [i, j], waves, *coupling, &ahead);
                let behind = ahead.transpose().to_owned();
                write_block(&mut compliance, [j, i], waves, *coupling, &behind);
            }
        }
        let gaps = pairs.iter().map(|pair| {
            let gap = |border: usize| pair.gap(border) + misalignment * face.border(border);
            (0..=face.slices).map(gap).collect()
        });
        let contact: Vec<f64> = pairs.iter().map(|pair| pair.point.contact).collect();
        if let Some(pair) = pairs.iter().find(|pair| pair.point.contact <= 0.0) {
            return Err(SharingError::OutOfRange {
                name: "tangent compliance of the contact [m²/N]",
                value: pair.point.contact,
                position: pair.position(),
                accepted: "positive where slices of the face support each other",
            });
        }
        Self::of(compliance, waves, contact, gaps.collect(), face, straight)
            .map(Some)
            .ok_or(unknown(0))
    }

    /// Pairs of a compliance C, with their gaps at the borders of slices. `None` if C is not positive definite.
    fn of(
        compliance: Mat<f64>,
        waves: usize,
        contact: Vec<f64>,
        gaps: Vec<Vec<f64>>,
        face: Face,
        straight: bool,
    ) -> Option<Self> {
        Some(Self {
            width: face.width,
            slices: face.slices,
            waves,
            contact,
            root: plain::cholesky(&compliance)?,
            profile: GapProfile::new(gaps, waves),
            straight,
        })
    }

    /// The minimum of Φ under a force > 0 \[N\]. The approach is NaN if the search does not converge.
    pub fn solve(&self, force: f64) -> ContactSolution {
        self.solve_from(force, &ContactRegion::default())
    }

    /// As [`Self::solve`], starting from the contact `near` or from the whole face.
    pub fn solve_from(&self, force: f64, near: &ContactRegion) -> ContactSolution {
        let mean = force / self.width;
        let scale = mean * self.contact.iter().copied().fold(0.0, f64::max);
        let pairs = self.contact.len();
        let known = near.0.len() == pairs && near.0.iter().any(|pair| !pair.is_empty());
        let start = if known { near.0.clone() } else { vec![vec![Interval::WHOLE]; pairs] };
        let (mut point, _) = self.minimum(&self.patch(start), mean);
        let mut patch = self.patch_at(&point);
        let mut last = false;
        for round in 0..ROUNDS {
            let (target, stiffness) = self.minimum(&patch, mean);
            if last {
                return self.solution_at(&target, stiffness, patch.touching);
            }
            let step = Iterate {
                y: &target.y - &point.y,
                approach: target.approach - point.approach,
            };
            let moved = plain::product(self.root.as_ref(), step.y.as_ref());
            last = moved.norm_max().max(step.approach.abs()) <= LAST_STEP * scale;
            if last || round < WHOLE_STEPS {
                point = target;
                patch = self.patch_at(&point);
                continue;
            }
            let falls = self.slope(&point, &patch, &step, mean);
            let mut part = 1.0;
            (point, patch) = loop {
                let next = Iterate {
                    y: &point.y + &step.y * faer::Scale(part),
                    approach: point.approach + part * step.approach,
                };
                let there = self.patch_at(&next);
                let rises = self.slope(&next, &there, &step, mean) > 0.5 * falls.abs();
                if !rises || part < LEAST_PART {
                    break (next, there);
                }
                part *= 0.5;
            };
        }
        let nowhere = Iterate {
            approach: f64::NAN,
            ..point
        };
        self.solution_at(&nowhere, f64::NAN, patch.touching)
    }

    /// The load of each pair.
    pub fn pairs(&self, solution: &ContactSolution) -> Vec<PairLoad> {
        (solution.touching.0.iter().enumerate())
            .map(|(pair, touching)| {
                let press = self.approach_at(solution, pair);
                let scale = self.width / self.contact[pair];
                let (slices, first) = self.profile.sums(pair, touching, &press);
                let pattern: Vec<f64> = slices.iter().map(|sum| scale * sum).collect();
                let moment = scale * self.width * first;
                PairLoad {
                    load: pattern.iter().sum(),
                    moment,
                    loaded: touching.iter().map(Interval::length).sum(),
                    pattern,
                }
            })
            .collect()
    }

    /// Lengths \[m\] whose signs are constant while the same formula holds: the depths of each
    /// pair at the borders of slices, and its largest depth. If only misalignment varies along the face, the ends
    /// of the face replace the borders.
    pub fn margins(&self, solution: &ContactSolution) -> Vec<f64> {
        let step = if self.straight { self.slices } else { 1 };
        (0..self.contact.len())
            .flat_map(|pair| {
                let press = self.approach_at(solution, pair);
                let mut margins: Vec<f64> = (0..=self.slices)
                    .step_by(step)
                    .map(|border| self.profile.at_border(pair, border, &press))
                    .collect();
                margins.push(self.profile.largest_depth(pair, &press));
                margins
            })
            .collect()
    }

    fn solution_at(
        &self,
        point: &Iterate,
        stiffness: f64,
        touching: Vec<Vec<Interval>>,
    ) -> ContactSolution {
        ContactSolution {
            approach: point.approach,
            stiffness,
            displacement: self.displacement(point),
            touching: ContactRegion(touching),
        }
    }

    fn approach_at(&self, solution: &ContactSolution, pair: usize) -> Approach {
        let waves = &solution.displacement[pair * self.waves..][..self.waves];
        Approach::new(solution.approach, waves)
    }

    fn displacement(&self, point: &Iterate) -> Vec<f64> {
        let moved = plain::product(self.root.as_ref(), point.y.as_ref());
        (0..moved.nrows()).map(|row| moved[(row, 0)]).collect()
    }

    fn patch_at(&self, point: &Iterate) -> Patch {
        let displacement = self.displacement(point);
        let touching = (displacement.chunks(self.waves).enumerate())
            .map(|(pair, waves)| {
                let press = Approach::new(point.approach, waves);
                self.profile.touching(pair, &press)
            })
            .collect();
        self.patch(touching)
    }

    fn patch(&self, touching: Vec<Vec<Interval>>) -> Patch {
        let (waves, size) = (self.waves, self.root.nrows());
        let mut products = Mat::zeros(size, size);
        let mut means = Mat::zeros(size, 1);
        let mut gaps = Mat::zeros(size, 1);
        for (pair, touching) in touching.iter().enumerate() {
            let (first, scale) = (pair * waves, 1.0 / self.contact[pair]);
            let cosines = integrals(touching, 2 * waves - 1);
            let gap = self.profile.gap_waves(pair, touching);
            for n in 0..waves {
                let one = amplitude(n) * scale;
                means[(first + n, 0)] = one * cosines[n];
                gaps[(first + n, 0)] = one * gap[n];
                for m in 0..waves {
                    products[(first + n, first + m)] =
                        one * amplitude(m) * 0.5 * (cosines[n.abs_diff(m)] + cosines[n + m]);
                }
            }
        }
        Patch {
            touching,
            products,
            means,
            gaps,
        }
    }

    /// The minimum of Φ for a fixed contact, and the stiffness there \[N/m\]. With `(1 + Lᵀ B̃ L) [r, o] = Lᵀ [ã, γ̃]`
    /// the minimum is at `y = x r − o`, and x follows from the force F that the pairs carry.
    fn minimum(&self, patch: &Patch, mean: f64) -> (Iterate, f64) {
        let size = self.root.nrows();
        let transposed = self.root.transpose();
        let matrix = self.hessian(patch);
        let [means, gaps] =
            [&patch.means, &patch.gaps].map(|side| plain::product(transposed, side.as_ref()));
        let mut sides = Mat::from_fn(size, 2, |row, side| match side {
            0 => means[(row, 0)],
            _ => gaps[(row, 0)],
        });
        // 1 plus a positive semidefinite matrix: the factorisation fails only for values that are not finite.
        let Some(lower) = plain::cholesky(&matrix) else {
            let nowhere = Iterate {
                y: Mat::zeros(size, 1),
                approach: f64::NAN,
            };
            return (nowhere, f64::NAN);
        };
        plain::solve_lower(&lower, &mut sides);
        plain::solve_upper(&lower, &mut sides);
        let even = |side: &Mat<f64>| -> f64 {
            (0..self.contact.len())
                .map(|pair| side[(pair * self.waves, 0)])
                .sum()
        };
        let along = |side: usize| -> f64 {
            (0..size)
                .map(|row| means[(row, 0)] * sides[(row, side)])
                .sum()
        };
        let stiffness = even(&patch.means) - along(0);
        let approach = (mean + even(&patch.gaps) - along(1)) / stiffness;
        let y = Mat::from_fn(size, 1, |row, _| {
            approach * sides[(row, 0)] - sides[(row, 1)]
        });
        (Iterate { y, approach }, self.width * stiffness)
    }

    /// The lower triangle of `1 + Lᵀ B̃ L`: B̃ is block diagonal in pairs, and columns of L begin at the diagonal.
    fn hessian(&self, patch: &Patch) -> Mat<f64> {
        let (waves, size) = (self.waves, self.root.nrows());
        let mut matrix = Mat::zeros(size, size);
        let mut carried = vec![0.0; size];
        for j in 0..size {
            let column = self.root.col_as_slice(j);
            for first in (j / waves * waves..size).step_by(waves) {
                let (range, out) = (first..first + waves, &mut carried[first..first + waves]);
                out.fill(0.0);
                for (k, factor) in range.clone().zip(&column[range.clone()]) {
                    let products = &patch.products.col_as_slice(k)[range.clone()];
                    for (out, product) in out.iter_mut().zip(products) {
                        *out += product * factor;
                    }
                }
            }
            let rows = &mut matrix.col_as_slice_mut(j)[j..];
            for (i, out) in (j..size).zip(rows) {
                let pairs = self.root.col_as_slice(i)[i..].iter().zip(&carried[i..]);
                *out = pairs.map(|(l, c)| l * c).sum::<f64>() + f64::from(u8::from(i == j));
            }
        }
        matrix
    }

    /// Derivative of Φ at a point along a step.
    fn slope(&self, point: &Iterate, patch: &Patch, step: &Iterate, mean: f64) -> f64 {
        let moved = plain::product(self.root.as_ref(), point.y.as_ref());
        let carried = plain::product(patch.products.as_ref(), moved.as_ref());
        let load = Mat::from_fn(moved.nrows(), 1, |row, _| {
            point.approach * patch.means[(row, 0)] - patch.gaps[(row, 0)] - carried[(row, 0)]
        });
        let pulled = plain::product(self.root.transpose(), load.as_ref());
        let bent: f64 = (0..moved.nrows())
            .map(|row| (point.y[(row, 0)] - pulled[(row, 0)]) * step.y[(row, 0)])
            .sum();
        let pressed: f64 = (0..self.contact.len())
            .map(|pair| load[(pair * self.waves, 0)])
            .sum();
        bent + (pressed - mean) * step.approach
    }
}

/// Amplitude c_n of the wave n.
fn amplitude(n: usize) -> f64 {
    if n == 0 { 1.0 } else { std::f64::consts::SQRT_2 }
}

/// Writes the block of two pairs: the response to the uniform wave, and that to the other waves.
fn write_block(
    matrix: &mut Mat<f64>,
    [row, column]: [usize; 2],
    waves: usize,
    uniform: f64,
    others: &Mat<f64>,
) {
    let (row, column) = (row * waves, column * waves);
    matrix[(row, column)] = uniform;
    for j in 1..waves {
        for i in 1..waves {
            matrix[(row + i, column + j)] = others[(i - 1, j - 1)];
        }
    }
}

impl PairLoad {
    /// Forces \[N\], total moment \[N m\] and loaded parts of the pairs.
    pub fn sums(pairs: &[Self]) -> ([f64; MOST_PAIRS], f64, [f64; MOST_PAIRS]) {
        let of = |value: fn(&Self) -> f64| -> [f64; MOST_PAIRS] {
            std::array::from_fn(|pair| pairs.get(pair).map_or(0.0, value))
        };
        let moment = pairs.iter().map(|pair| pair.moment).sum();
        (of(|pair| pair.load), moment, of(|pair| pair.loaded))
    }
}

#[cfg(test)]
#[path = "coupled_tests.rs"]
mod tests;
