//! Guesses and corrected orbits between and beyond consecutive orbits of a branch.

use super::map::{CycleMap, MapParameters};
use super::orbit::{NoOrbit, Orbit, OrbitCondition, OrbitSolution, correct, length};

/// Weight of the orbit in the arclength. It multiplies a change of the orbit in sizes of its motion. A change
/// of the parameter by its whole interval has the weight 1.
pub(super) const WEIGHT: f64 = 0.1;

/// Smallest parameter component of a unit tangent for a search at a fixed parameter. If the component is smaller, the
/// search uses a plane across the branch.
const STEEP: f64 = 0.15;

/// Largest distance of an orbit from its guess or from the chord of its bracket, relative to the step or the chord. A
/// more distant orbit belongs to another branch.
pub(super) const LARGEST_DISTANCE: f64 = 0.5;

/// Step of difference quotients of the map, relative to the parameter's interval.
const DIFFERENCE: f64 = 1e-7;

/// Largest number of orbits in a polynomial guess.
const MOST_KNOTS: usize = 4;

/// The free parameter and its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// The parameter.
    pub axis: usize,
    /// Smallest value of the parameter.
    pub from: f64,
    /// Largest value of the parameter.
    pub to: f64,
}

impl Span {
    /// Length of the interval, the unit of the parameter.
    pub fn scale(&self) -> f64 {
        self.to - self.from
    }

    /// Whether a value lies in the interval, including its ends.
    pub fn contains(&self, value: f64) -> bool {
        (self.from..=self.to).contains(&value)
    }
}

/// A direction or a point: coordinates, and the parameter in its unit.
#[derive(Debug, Clone)]
pub struct Vector {
    /// Coordinates.
    pub u: Vec<f64>,
    /// The parameter divided by the length of its interval, unless stated otherwise.
    pub p: f64,
    /// Size of the motion, the unit of the coordinates in lengths.
    pub size: f64,
}

impl Vector {
    /// Length of the vector.
    pub fn length(&self) -> f64 {
        (WEIGHT / self.size * length(&self.u)).hypot(self.p)
    }

    /// The opposite direction.
    pub fn reversed(&self) -> Self {
        Self {
            u: self.u.iter().map(|u| -u).collect(),
            p: -self.p,
            size: self.size,
        }
    }

    /// The cosine of the angle between two directions.
    pub fn cosine(&self, other: &Self) -> f64 {
        let dot: f64 = self.u.iter().zip(&other.u).map(|(a, b)| a * b).sum();
        let weight = (WEIGHT / self.size).powi(2);
        let other_length = (weight.sqrt() * length(&other.u)).hypot(other.p);
        (weight * dot + self.p * other.p) / (self.length() * other_length)
    }

    /// The vector from one orbit to another.
    pub fn between(span: &Span, a: &Orbit, b: &Orbit) -> Self {
        Self::to(span, a, &b.u, b.at)
    }

    /// The vector from an orbit to a point.
    pub fn to(span: &Span, from: &Orbit, u: &[f64], at: MapParameters) -> Self {
        Self {
            u: u.iter().zip(&from.u).map(|(u, from)| u - from).collect(),
            p: (at[span.axis] - from.at[span.axis]) / span.scale(),
            size: from.size(),
        }
    }
}

/// Arclength from one orbit to the next.
pub fn apart(span: &Span, a: &Orbit, b: &Orbit) -> f64 {
    Vector::between(span, a, b).length()
}

/// The guess at an arclength `s`: the polynomial through the nearest orbits, given with their arclengths. Its `p` is
/// the parameter itself, not divided by the length of its interval.
pub fn guess(span: &Span, knots: &[(f64, &Orbit)], s: f64) -> Vector {
    let mut near: Vec<&(f64, &Orbit)> = knots.iter().collect();
    near.sort_by(|a, b| (a.0 - s).abs().total_cmp(&(b.0 - s).abs()));
    near.truncate(MOST_KNOTS);
    let mut u = vec![0.0; near[0].1.u.len()];
    let mut p = 0.0;
    for (i, (own, orbit)) in near.iter().enumerate() {
        let others = near.iter().enumerate().filter(|(j, _)| *j != i);
        let weight: f64 = others
            .map(|(_, (other, _))| (s - other) / (own - other))
            .product();
        for (sum, value) in u.iter_mut().zip(&orbit.u) {
            *sum += weight * value;
        }
        p += weight * orbit.at[span.axis];
    }
    let size = near[0].1.size();
    Vector { u, p, size }
}

/// The condition that fixes the position of an orbit on a branch.
#[derive(Debug, Clone, Copy)]
pub enum PathCondition<'v> {
    /// The parameter of the guess.
    Parameter,
    /// A plane across this direction if the branch is steep along the direction, otherwise the parameter of
    /// the guess.
    Steep(&'v Vector),
    /// A plane across this direction. Between two orbits, a branch crosses every plane across their chord, even if the
    /// parameter reverses.
    Always(&'v Vector),
}

/// Finds the orbit near a guess, with the period and the other parameter of `like`.
///
/// # Errors
/// [`NoOrbit`].
pub fn place(
    map: &mut impl CycleMap,
    span: &Span,
    like: &Orbit,
    guess: &Vector,
    across: PathCondition<'_>,
) -> Result<Orbit, NoOrbit> {
    solution(map, span, like, guess, across)?.complete(map, like.period)
}

/// Finds the orbit near a guess as [`place`] does, but without details. Its size is that of `like`.
///
/// # Errors
/// [`NoOrbit`].
pub fn place_bare(
    map: &mut impl CycleMap,
    span: &Span,
    like: &Orbit,
    guess: &Vector,
    across: PathCondition<'_>,
) -> Result<Orbit, NoOrbit> {
    let mut orbit = solution(map, span, like, guess, across)?.with_multipliers(like.period)?;
    orbit.details.size = like.size();
    Ok(orbit)
}

/// Finds the orbit near a guess as [`place`] does, but without multipliers and details.
///
/// # Errors
/// [`NoOrbit`].
pub fn solution(
    map: &mut impl CycleMap,
    span: &Span,
    like: &Orbit,
    guess: &Vector,
    across: PathCondition<'_>,
) -> Result<OrbitSolution, NoOrbit> {
    let mut at = like.at;
    at[span.axis] = guess.p;
    let condition = match across {
        PathCondition::Steep(direction) if direction.p.abs() < STEEP * direction.length() => {
            plane(map, span, like.period, (&guess.u, at), direction)?
        }
        PathCondition::Always(direction) => {
            plane(map, span, like.period, (&guess.u, at), direction)?
        }
        PathCondition::Parameter | PathCondition::Steep(_) => OrbitCondition::Parameters,
    };
    correct(map, &guess.u, at, like.period, &condition)
}

fn plane(
    map: &mut impl CycleMap,
    span: &Span,
    period: u32,
    (u, at): (&[f64], MapParameters),
    direction: &Vector,
) -> Result<OrbitCondition, NoOrbit> {
    let long = direction.length();
    let weight = (WEIGHT / direction.size).powi(2) / long;
    let step = DIFFERENCE * span.scale();
    let column = map.near_derivative(u, at, period, (span.axis, step))?;
    Ok(OrbitCondition::Plane {
        axis: span.axis,
        scale: span.scale(),
        normal: direction.u.iter().map(|u| weight * u).collect(),
        along: direction.p / long,
        column: column.iter().map(|c| c * span.scale()).collect(),
    })
}

/// The direction of a branch at an orbit, towards larger values of the parameter, from the exact derivative of the
/// map.
///
/// # Errors
/// [`NoOrbit`] if the map has no derivative.
pub fn tangent(map: &mut impl CycleMap, span: &Span, orbit: &Orbit) -> Result<Vector, NoOrbit> {
    let column = map.by_parameter(&orbit.u, orbit.at, orbit.period, span.axis)?;
    let n = column.len();
    let system = faer::Mat::from_fn(n, n, |i, j| {
        f64::from(u8::from(i == j)) - orbit.monodromy[(i, j)]
    });
    let right: Vec<f64> = column.iter().map(|c| c * span.scale()).collect();
    Ok(Vector {
        u: crate::numerics::linalg::solve(system.as_ref(), &right),
        p: 1.0,
        size: orbit.size(),
    })
}

/// Coordinates at a value of the parameter, interpolated linearly between two orbits.
pub fn interpolated(span: &Span, a: &Orbit, b: &Orbit, value: f64) -> Vec<f64> {
    let (from, to) = (a.at[span.axis], b.at[span.axis]);
    let part = if from == to { 0.5 } else { (value - from) / (to - from) };
    a.u.iter()
        .zip(&b.u)
        .map(|(a, b)| a + part * (b - a))
        .collect()
}
