//! Newton's method for one periodic orbit near a guess: at given parameters, or on a given plane with one free
//! parameter.
//!
//! ```text
//! | M − I   P_p | | Δu |     | P(u, p) − u |
//! | cᵀ      c_p | | Δp |  = −| c·(u − u₀) + c_p (p − p₀) |
//! ```
//!
//! P is the map over a period, M and P_p are its derivatives with respect to u and p, and (c, c_p) is the normal of the
//! plane through the guess (u₀, p₀). Without a plane, the second row and column are absent.

use super::map::{CycleMap, Details, MapError, MapParameters};
use crate::numerics::linalg::{eigenvalues, solve};
use faer::Mat;
use num_complex::Complex64;

/// Distance of a real multiplier from 1 that is not round-off.
const CLEAR: f64 = 1e-6;

/// Largest number of Newton steps; a good guess needs two or three.
const MOST_STEPS: u32 = 10;

/// Residual, relative to the state's length, at which an orbit counts as found. One more step may follow.
const CONVERGED: f64 = 1e-11;

/// Residual, relative to the state's length, at which an orbit counts as found if the last step has not halved the
/// residual. The round-off of long periods and stiff tables can prevent smaller residuals.
const STAGNANT: f64 = 1e-8;

/// Longest step, relative to the state's length, that is still applied to a found orbit.
const LAST_STEP: f64 = 1e-8;

/// Longest step, relative to the state's length, before the iteration counts as divergent.
const LONGEST_STEP: f64 = 30.0;

/// A periodic orbit.
#[derive(Debug, Clone)]
pub struct Orbit {
    /// Coordinates at the start of the first cycle.
    pub u: Vec<f64>,
    /// The parameters.
    pub at: MapParameters,
    /// Period in cycles.
    pub period: u32,
    /// Distance between start and end of a period, before the last step \[half gaps\].
    pub residual: f64,
    /// Newton steps until that residual.
    pub steps: u32,
    /// Derivative of the map over one period.
    pub monodromy: Mat<f64>,
    /// Floquet multipliers, largest modulus first.
    pub multipliers: Vec<Complex64>,
    /// Properties of the orbit over its period.
    pub details: Details,
}

impl Orbit {
    /// Multipliers outside the unit circle.
    pub fn unstable(&self) -> usize {
        self.multipliers.iter().filter(|m| m.norm() > 1.0).count()
    }

    /// Whether an odd number of real multipliers is above 1, which gives the sign of `det(M − I)`. The parameter
    /// changes its direction along a branch where this sign changes. `None` if a multiplier is too close to 1.
    pub(super) fn sense(&self) -> Option<bool> {
        let real = || {
            self.multipliers
                .iter()
                .filter(|m| m.im == 0.0)
                .map(|m| m.re)
        };
        let is_clear = real().all(|m| (m - 1.0).abs() > CLEAR);
        is_clear.then(|| real().filter(|m| *m > 1.0).count() % 2 == 1)
    }

    /// Whether the orbit already repeats after half its period. This half must be a multiple of the
    /// excitation's period of `unit` cycles.
    pub(super) fn repeats_sooner(&self, unit: u32) -> bool {
        self.period.is_multiple_of(2 * unit)
            && length(&self.offset(self.period / 2)) < SAME_ORBIT * self.size()
    }

    /// Size of the motion ([`Details::size`]), in the unit of the states [`Self::u`]. A size of 0 is returned
    /// as 1.
    pub fn size(&self) -> f64 {
        match self.details.size {
            0.0 => 1.0,
            size => size,
        }
    }

    /// The same orbit with twice its period.
    ///
    /// # Errors
    /// [`NoOrbit`] if the orbit cannot be integrated.
    pub(super) fn doubled(&self, map: &mut impl CycleMap) -> Result<Self, NoOrbit> {
        let twice = OrbitSolution {
            u: self.u.clone(),
            at: self.at,
            residual: self.residual,
            steps: self.steps,
            monodromy: &self.monodromy * &self.monodromy,
        };
        twice.complete(map, 2 * self.period)
    }

    /// Displacement from the start after some cycles. It is zero if the orbit repeats after these cycles.
    pub fn offset(&self, cycles: u32) -> Vec<f64> {
        let later = &self.details.strobes[cycles as usize];
        later.iter().zip(&self.u).map(|(a, b)| a - b).collect()
    }
}

/// The condition that selects one orbit near a guess.
#[derive(Debug, Clone)]
pub enum OrbitCondition {
    /// The parameters are those of the guess.
    Parameters,
    /// The orbit lies on a plane through the guess, and one parameter is free.
    Plane {
        /// The free parameter.
        axis: usize,
        /// Unit of the free parameter.
        scale: f64,
        /// Coordinates of the plane's normal.
        normal: Vec<f64>,
        /// Component of the normal along the parameter, per unit.
        along: f64,
        /// Derivative of the map with respect to the parameter, per unit, near the guess.
        column: Vec<f64>,
    },
}

/// Reasons why no orbit is found near a guess.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoOrbit {
    /// The map could not be evaluated at an iterate of Newton's method.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Newton's method did not converge, or the multipliers of its result are not finite.
    #[error("Newton's method ends {residual:.0e} half gaps away from an orbit")]
    Newton {
        /// The last residual \[half gaps\].
        residual: f64,
    },
}

/// An orbit without multipliers and details.
#[derive(Debug, Clone)]
pub struct OrbitSolution {
    /// State at the start of the orbit, in the coordinates u of the map ([`super::map`]).
    pub u: Vec<f64>,
    /// Parameters of the orbit.
    pub at: MapParameters,
    /// Distance of u from its image after a period \[half gaps\].
    residual: f64,
    /// Newton steps.
    pub steps: u32,
    /// Derivative of the map.
    pub monodromy: Mat<f64>,
}

/// Finds the orbit near a guess.
///
/// # Errors
/// [`NoOrbit`].
pub fn correct(
    map: &mut impl CycleMap,
    guess: &[f64],
    at: MapParameters,
    period: u32,
    condition: &OrbitCondition,
) -> Result<OrbitSolution, NoOrbit> {
    let n = map.dimension();
    let (mut u, mut here) = (guess.to_vec(), at);
    let mut last = f64::INFINITY;
    for steps in 0..MOST_STEPS {
        let image = map.image(&u, here, period)?;
        let defect: Vec<f64> = image
            .end
            .iter()
            .zip(&u)
            .map(|(end, start)| end - start)
            .collect();
        let residual = length(&defect);
        // Round-off is proportional to the state, whatever the gaps are.
        let size = length(&u).max(length(&image.end));
        if residual.is_nan() || residual > 2.0 * last.max(size) {
            return Err(NoOrbit::Newton { residual });
        }
        let found =
            residual <= CONVERGED * size || residual <= STAGNANT * size && residual > 0.5 * last;
        let step = newton_step(
            &image.monodromy,
            &defect,
            (&u, here),
            (guess, at),
            condition,
        );
        let long = length(&step[..n]);
        if !found && (long.is_nan() || long > LONGEST_STEP * size) {
            return Err(NoOrbit::Newton { residual });
        }
        // A last short step is cheap, because its matrix is known. Near a fold this step would be long and
        // consist of round-off, so it is omitted.
        if !found || long <= LAST_STEP * size {
            for (u, step) in u.iter_mut().zip(&step) {
                *u += step;
            }
            if let OrbitCondition::Plane { axis, scale, .. } = condition {
                here[*axis] += scale * step[n];
            }
        }
        if found {
            return Ok(OrbitSolution {
                u,
                at: here,
                residual,
                steps,
                monodromy: image.monodromy,
            });
        }
        last = residual;
    }
    Err(NoOrbit::Newton { residual: last })
}

fn newton_step(
    monodromy: &Mat<f64>,
    defect: &[f64],
    (u, here): (&[f64], MapParameters),
    (guess, at): (&[f64], MapParameters),
    condition: &OrbitCondition,
) -> Vec<f64> {
    let n = defect.len();
    let entry = |i: usize, j: usize| monodromy[(i, j)] - f64::from(u8::from(i == j));
    let mut right: Vec<f64> = defect.iter().map(|d| -d).collect();
    match condition {
        OrbitCondition::Parameters => solve(Mat::from_fn(n, n, entry).as_ref(), &right),
        OrbitCondition::Plane {
            axis,
            scale,
            normal,
            along,
            column,
        } => {
            let off: f64 = normal
                .iter()
                .zip(u)
                .zip(guess)
                .map(|((c, u), g)| c * (u - g))
                .sum();
            right.push(-off - along * (here[*axis] - at[*axis]) / scale);
            let system = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
                (true, true) => entry(i, j),
                (true, false) => column[i],
                (false, true) => normal[j],
                (false, false) => *along,
            });
            solve(system.as_ref(), &right)
        }
    }
}

impl OrbitSolution {
    /// Adds the multipliers and the details.
    ///
    /// # Errors
    /// [`NoOrbit`] if the multipliers are not finite, or if the orbit cannot be integrated.
    pub fn complete(self, map: &mut impl CycleMap, period: u32) -> Result<Orbit, NoOrbit> {
        self.with_multipliers(period)?.with_details(map)
    }

    /// Adds the multipliers.
    ///
    /// # Errors
    /// [`NoOrbit`] if the multipliers are not finite.
    pub fn with_multipliers(self, period: u32) -> Result<Orbit, NoOrbit> {
        let multipliers = eigenvalues(self.monodromy.as_ref()).ok_or(NoOrbit::Newton {
            residual: self.residual,
        })?;
        Ok(Orbit {
            u: self.u,
            at: self.at,
            period,
            residual: self.residual,
            steps: self.steps,
            monodromy: self.monodromy,
            multipliers,
            details: Details::default(),
        })
    }
}

impl Orbit {
    /// Adds the details.
    ///
    /// # Errors
    /// [`NoOrbit`] if the orbit cannot be integrated.
    pub fn with_details(mut self, map: &mut impl CycleMap) -> Result<Self, NoOrbit> {
        self.details = map.details(&self.u, self.at, self.period)?;
        Ok(self)
    }
}

/// Finds the orbit near a guess, with its multipliers and details.
///
/// # Errors
/// [`NoOrbit`].
pub fn find(
    map: &mut impl CycleMap,
    guess: &[f64],
    at: MapParameters,
    period: u32,
    condition: &OrbitCondition,
) -> Result<Orbit, NoOrbit> {
    correct(map, guess, at, period, condition)?.complete(map, period)
}

/// Euclidean length.
pub fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Euclidean distance.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b) * (a - b))
        .sum::<f64>()
        .sqrt()
}

/// Distance, in sizes of the motion, below which two orbits are the same.
pub(super) const SAME_ORBIT: f64 = 1e-6;

/// Whether two orbits are the same, at any cycle of `a`.
pub fn same(a: &Orbit, b: &Orbit) -> bool {
    let meets = |u: &Vec<f64>| distance(u, &b.u) < SAME_ORBIT * b.size();
    a.period == b.period && a.details.strobes.iter().any(meets)
}
