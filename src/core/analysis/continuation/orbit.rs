//! One periodic orbit, next to a guess: by Newton's method at given parameters, or with one of them
//! free and a plane that the orbit lies on instead.
//!
//! ```text
//! | M − I   P_p | | Δu |     | P(u, p) − u |
//! | cᵀ      c_p | | Δp |  = −| c·(u − u₀) + c_p (p − p₀) |
//! ```

use super::map::{At, CycleMap, Details, MapError};
use crate::numerics::linalg::{eigenvalues, solve};
use faer::Mat;
use num_complex::Complex64;

/// Most Newton steps; a good guess needs two or three.
const MOST_STEPS: u32 = 10;

/// Residual, as a part of the state's length, at which an orbit counts as found, but for one step more.
const CONVERGED: f64 = 1e-11;

/// The same where another step does not halve it: round-off of long periods and stiff tables.
const STAGNANT: f64 = 1e-8;

/// Longest step, as a part of the state's length, that is made from an orbit that counts as found.
const LAST_STEP: f64 = 1e-8;

/// Longest step, in lengths of the state, from one that is worth following.
const LONGEST_STEP: f64 = 30.0;

/// A periodic orbit.
#[derive(Debug, Clone)]
pub struct Orbit {
    /// Coordinates at the start of the first cycle.
    pub u: Vec<f64>,
    /// The parameters.
    pub at: At,
    /// Period in cycles.
    pub period: u32,
    /// Distance between start and end of a period before the last step \[half gaps\].
    pub residual: f64,
    /// Newton steps that it took until there.
    pub steps: u32,
    /// Derivative of the map of a period.
    pub monodromy: Mat<f64>,
    /// Floquet multipliers, largest modulus first.
    pub multipliers: Vec<Complex64>,
    /// What it is like on its way.
    pub details: Details,
}

impl Orbit {
    /// Multipliers outside the unit circle.
    pub fn unstable(&self) -> usize {
        self.multipliers.iter().filter(|m| m.norm() > 1.0).count()
    }

    /// Whether it is an orbit of half its period.
    pub(super) fn repeats_sooner(&self) -> bool {
        self.period.is_multiple_of(2)
            && length(&self.offset(self.period / 2)) < SAME_ORBIT * self.size()
    }

    /// Size of the motion, in the unit of u ([`Details::size`]).
    pub fn size(&self) -> f64 {
        match self.details.size {
            0.0 => 1.0,
            size => size,
        }
    }

    /// The same orbit as one of twice its period.
    ///
    /// # Errors
    /// [`NoOrbit`] where it cannot be integrated.
    pub(super) fn doubled(&self, map: &mut impl CycleMap) -> Result<Self, NoOrbit> {
        let twice = Bare {
            u: self.u.clone(),
            at: self.at,
            residual: self.residual,
            steps: self.steps,
            monodromy: &self.monodromy * &self.monodromy,
        };
        twice.with_multipliers(2 * self.period)?.with_details(map)
    }

    /// How far a part of a period leads away from the start: zero where the orbit's own period is
    /// shorter.
    pub fn offset(&self, cycles: u32) -> Vec<f64> {
        let later = &self.details.strobes[cycles as usize];
        later.iter().zip(&self.u).map(|(a, b)| a - b).collect()
    }
}

/// Where the orbit next to a guess is to lie.
#[derive(Debug, Clone)]
pub enum Border {
    /// At the parameters of the guess.
    Parameters,
    /// On a plane through the guess, one parameter being free.
    Plane {
        /// That parameter.
        axis: usize,
        /// Its unit.
        scale: f64,
        /// Normal of the plane, the coordinates' part.
        normal: Vec<f64>,
        /// The parameter's part, per unit.
        along: f64,
        /// Derivative of the map by the parameter, per unit, near the guess.
        column: Vec<f64>,
    },
}

/// Why there is no orbit next to a guess.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoOrbit {
    /// The map has no value where Newton's method led.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Newton's method did not converge.
    #[error("Newton's method ends {residual:.0e} half gaps away from an orbit")]
    Newton {
        /// The last residual \[half gaps\].
        residual: f64,
    },
}

/// An orbit without its multipliers and its details.
#[derive(Debug, Clone)]
pub struct Bare {
    /// Coordinates.
    pub u: Vec<f64>,
    /// Parameters.
    pub at: At,
    residual: f64,
    /// Newton steps.
    pub steps: u32,
    /// Derivative of the map.
    pub monodromy: Mat<f64>,
}

/// Seeks the orbit next to a guess.
///
/// # Errors
/// [`NoOrbit`].
pub fn correct(
    map: &mut impl CycleMap,
    guess: &[f64],
    at: At,
    period: u32,
    border: &Border,
) -> Result<Bare, NoOrbit> {
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
        // Round-off goes with the state, wherever its gaps are.
        let size = length(&u).max(length(&image.end));
        if residual.is_nan() || residual > 2.0 * last.max(size) {
            return Err(NoOrbit::Newton { residual });
        }
        let found =
            residual <= CONVERGED * size || residual <= STAGNANT * size && residual > 0.5 * last;
        let step = newton_step(&image.monodromy, &defect, (&u, here), (guess, at), border);
        let long = length(&step[..n]);
        if !found && (long.is_nan() || long > LONGEST_STEP * size) {
            return Err(NoOrbit::Newton { residual });
        }
        // A last short step costs nothing, as its matrix is at hand. Next to a fold it would be long: noise.
        if !found || long <= LAST_STEP * size {
            for (u, step) in u.iter_mut().zip(&step) {
                *u += step;
            }
            if let Border::Plane { axis, scale, .. } = border {
                here[*axis] += scale * step[n];
            }
        }
        if found {
            return Ok(Bare {
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
    (u, here): (&[f64], At),
    (guess, at): (&[f64], At),
    border: &Border,
) -> Vec<f64> {
    let n = defect.len();
    let entry = |i: usize, j: usize| monodromy[(i, j)] - f64::from(u8::from(i == j));
    let mut right: Vec<f64> = defect.iter().map(|d| -d).collect();
    match border {
        Border::Parameters => solve(Mat::from_fn(n, n, entry).as_ref(), &right),
        Border::Plane {
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

impl Bare {
    /// With multipliers, and without details.
    ///
    /// # Errors
    /// [`NoOrbit`] where its multipliers are not finite.
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
    /// With its details.
    ///
    /// # Errors
    /// [`NoOrbit`] where it cannot be integrated.
    pub fn with_details(mut self, map: &mut impl CycleMap) -> Result<Self, NoOrbit> {
        self.details = map.details(&self.u, self.at, self.period)?;
        Ok(self)
    }
}

/// Seeks the orbit next to a guess, with its multipliers and its details.
///
/// # Errors
/// [`NoOrbit`].
pub fn find(
    map: &mut impl CycleMap,
    guess: &[f64],
    at: At,
    period: u32,
    border: &Border,
) -> Result<Orbit, NoOrbit> {
    correct(map, guess, at, period, border)?
        .with_multipliers(period)?
        .with_details(map)
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

/// Distance, in sizes of the motion, at which two orbits are one.
pub(super) const SAME_ORBIT: f64 = 1e-6;

/// Whether two orbits are one, whichever cycle they start in.
pub fn same(a: &Orbit, b: &Orbit) -> bool {
    let meets = |u: &Vec<f64>| distance(u, &b.u) < SAME_ORBIT * b.size();
    a.period == b.period && a.details.strobes.iter().any(meets)
}
