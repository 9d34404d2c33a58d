//! One periodic orbit, next to a guess: by Newton's method at given parameters, or with one of them
//! free and a plane that the orbit lies on instead.
//!
//! ```text
//! | M − I   P_p | | Δu |     | P(u, p) − u |
//! | cᵀ      c_p | | Δp |  = −| c·(u − u₀) + c_p (p − p₀) |
//! ```

use super::map::{At, CycleMap, Details, Image, MapError};
use super::multipliers::{Multipliers, shifted};
use crate::numerics::linalg::{Factors, solve};
use faer::Mat;
use std::sync::Arc;

/// Most Newton steps; a good guess needs two or three.
const MOST_STEPS: u32 = 10;

/// Part of a residual that a step leaves from which its derivative is made anew.
const WORN: f64 = 0.1;

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
    pub monodromy: Arc<Mat<f64>>,
    /// Its eigenvalues ([`Self::multipliers`]).
    pub multipliers: Multipliers,
    /// What it is like on its way.
    pub details: Details,
}

impl Orbit {
    /// Multipliers outside the unit circle.
    pub fn unstable(&self) -> usize {
        self.multipliers().iter().filter(|m| m.norm() > 1.0).count()
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
            monodromy: &*self.monodromy * &*self.monodromy,
        };
        let twice = twice.of_period(2 * self.period);
        twice.with_multipliers()?.with_details(map)
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

/// Seeks the orbit next to a guess; `near` is the derivative of the map at an orbit near it, where one is known.
///
/// At given parameters `near` serves for as long as each step with it leaves less than a tenth, and so does the derivative of the last
/// step but one: steps with them take a trajectory alone, and count as one.
///
/// # Errors
/// [`NoOrbit`].
pub fn correct(
    map: &mut impl CycleMap,
    guess: &[f64],
    at: At,
    period: u32,
    border: &Border,
    near: Option<&Mat<f64>>,
) -> Result<Bare, NoOrbit> {
    match near.filter(|_| matches!(border, Border::Parameters)) {
        None => newton(map, guess, at, period, border, None),
        // What leads astray with the derivative of another orbit may not with its own.
        near => newton(map, guess, at, period, border, near)
            .or_else(|_| newton(map, guess, at, period, border, None)),
    }
}

/// Newton's method, the first steps with `near` where that is given.
fn newton(
    map: &mut impl CycleMap,
    guess: &[f64],
    at: At,
    period: u32,
    border: &Border,
    near: Option<&Mat<f64>>,
) -> Result<Bare, NoOrbit> {
    let n = map.dimension();
    let (mut u, mut here) = (guess.to_vec(), at);
    let (mut steps, mut last) = (0, f64::INFINITY);
    let mut factors = near.map(|m| Factors::new(shifted(m, 1.0)));
    // Whether steps are made with a derivative from elsewhere.
    let mut is_chord = near.is_some();
    let keeps = matches!(border, Border::Parameters);
    while steps < MOST_STEPS {
        let (end, mut monodromy) = match keeps && factors.is_some() {
            true => (map.end(&u, here, period)?, None),
            false => {
                let Image { end, monodromy } = map.image(&u, here, period)?;
                (end, Some(monodromy))
            }
        };
        let defect: Vec<f64> = end.iter().zip(&u).map(|(end, start)| end - start).collect();
        let residual = length(&defect);
        // Round-off goes with the state, wherever its gaps are.
        let size = length(&u).max(length(&end));
        if residual.is_nan() || residual > 2.0 * last.max(size) {
            return Err(NoOrbit::Newton { residual });
        }
        let stagnates = !is_chord && residual <= STAGNANT * size && residual > 0.5 * last;
        let found = residual <= CONVERGED * size || stagnates;
        let next = residual * (residual / last).powi(2);
        let was_chord = is_chord;
        is_chord = match is_chord {
            true => residual <= WORN * last || last.is_infinite(),
            // A derivative of its own would end the search with the next step: some steps with the last one do as well.
            false => keeps && last.is_finite() && next <= CONVERGED * size,
        };
        if (found || !is_chord) && monodromy.is_none() {
            monodromy = Some(map.image(&u, here, period)?.monodromy);
        }
        let right: Vec<f64> = defect.iter().map(|d| -d).collect();
        let step = match (&monodromy, keeps) {
            (Some(matrix), false) => step_on_plane(matrix, right, (&u, here), (guess, at), border),
            (matrix, _) => {
                let own = matrix.as_ref().map(|m| Factors::new(shifted(m, 1.0)));
                factors = own.or(factors);
                factors
                    .as_ref()
                    .map_or(right.clone(), |own| own.solve(&right))
            }
        };
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
        if let (true, Some(monodromy)) = (found, monodromy) {
            return Ok(Bare {
                u,
                at: here,
                residual,
                steps,
                monodromy,
            });
        }
        steps += u32::from(!is_chord || !was_chord);
        last = residual;
    }
    Err(NoOrbit::Newton { residual: last })
}

/// A step with one parameter free, on the plane.
fn step_on_plane(
    monodromy: &Mat<f64>,
    mut right: Vec<f64>,
    (u, here): (&[f64], At),
    (guess, at): (&[f64], At),
    border: &Border,
) -> Vec<f64> {
    let Border::Plane {
        axis,
        scale,
        normal,
        along,
        column,
    } = border
    else {
        return right;
    };
    let n = right.len();
    let off: f64 = normal
        .iter()
        .zip(u)
        .zip(guess)
        .map(|((c, u), g)| c * (u - g))
        .sum();
    right.push(-off - along * (here[*axis] - at[*axis]) / scale);
    let system = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
        (true, true) => monodromy[(i, j)] - f64::from(u8::from(i == j)),
        (true, false) => column[i],
        (false, true) => normal[j],
        (false, false) => *along,
    });
    solve(system.as_ref(), &right)
}

impl Bare {
    /// As an orbit of some period, without details.
    pub fn of_period(self, period: u32) -> Orbit {
        Orbit {
            u: self.u,
            at: self.at,
            period,
            residual: self.residual,
            steps: self.steps,
            monodromy: self.monodromy.into(),
            multipliers: Multipliers::default(),
            details: Details::default(),
        }
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
    correct(map, guess, at, period, border, None)?
        .of_period(period)
        .with_multipliers()?
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `u' = u² + p`, with a fixed point at `½ − √(¼ − p)`, and how often its derivative was asked for.
    struct Parabola {
        derivatives: usize,
    }

    impl CycleMap for Parabola {
        fn dimension(&self) -> usize {
            1
        }

        fn image(&mut self, u: &[f64], at: At, period: u32) -> Result<Image, MapError> {
            self.derivatives += 1;
            Ok(Image {
                end: self.end(u, at, period)?,
                monodromy: Mat::from_fn(1, 1, |_, _| 2.0 * u[0]),
            })
        }

        fn end(&mut self, u: &[f64], at: At, _: u32) -> Result<Vec<f64>, MapError> {
            Ok(vec![u[0] * u[0] + at[0]])
        }

        fn by_parameter(
            &mut self,
            _: &[f64],
            _: At,
            _: u32,
            _: usize,
        ) -> Result<Vec<f64>, MapError> {
            Ok(vec![1.0])
        }

        fn details(&mut self, _: &[f64], _: At, _: u32) -> Result<Details, MapError> {
            Ok(Details::default())
        }
    }

    /// The derivative of an orbit nearby finds the same orbit, and its own derivative is asked for once; one that leads astray
    /// does not keep the orbit from being found.
    #[test]
    fn a_derivative_from_nearby_finds_the_same_orbit() {
        let p = -0.3;
        let exact = 0.5 - f64::sqrt(0.25 - p);
        let find = |near: Option<f64>| {
            let mut map = Parabola { derivatives: 0 };
            let near = near.map(|slope| Mat::from_fn(1, 1, |_, _| slope));
            let guess = [exact + 1e-3];
            let border = Border::Parameters;
            let found = correct(&mut map, &guess, [p, 0.0], 1, &border, near.as_ref()).unwrap();
            assert!((found.u[0] - exact).abs() < 1e-15, "{:?}", found.u);
            assert!((found.monodromy[(0, 0)] - 2.0 * exact).abs() < 1e-10);
            map.derivatives
        };
        assert_eq!(find(Some(2.0 * exact - 0.05)), 1);
        assert!(find(None) >= 2);
        assert!(find(Some(1.0 + 1e-9)) >= 2);
    }
}
