//! A stretch of branch: orbits in order, and guesses between and beyond them.

use super::map::CycleMap;
use super::orbit::{Border, NoOrbit, Orbit, correct, length};

/// Weight of a change by the motion's own size against the whole interval of the parameter, in the length of a branch.
const WEIGHT: f64 = 0.1;

/// Part of a unit tangent that the parameter must have for an orbit to be sought at a given
/// parameter; elsewhere it is sought on a plane across the branch.
const STEEP: f64 = 0.15;

/// Orbits that a guess is a polynomial through.
const MOST_KNOTS: usize = 4;

/// Which parameter is free, and its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// The parameter.
    pub axis: usize,
    /// Its smallest value.
    pub from: f64,
    /// Its largest value.
    pub to: f64,
}

impl Span {
    /// Length of the interval: the parameter's unit.
    pub fn scale(&self) -> f64 {
        self.to - self.from
    }

    /// Whether a value lies inside, ends included.
    pub fn holds(&self, value: f64) -> bool {
        (self.from..=self.to).contains(&value)
    }
}

/// A direction or a place: coordinates and the parameter, per unit.
#[derive(Debug, Clone)]
pub struct Vector {
    /// Coordinates.
    pub u: Vec<f64>,
    /// The parameter over its unit.
    pub p: f64,
    /// Size of the motion that coordinates are measured by.
    pub size: f64,
}

impl Vector {
    /// Its length.
    pub fn length(&self) -> f64 {
        (WEIGHT / self.size * length(&self.u)).hypot(self.p)
    }

    /// The other way.
    pub fn reversed(&self) -> Self {
        Self {
            u: self.u.iter().map(|u| -u).collect(),
            p: -self.p,
            size: self.size,
        }
    }

    /// The cosine of the angle between two.
    pub fn cosine(&self, other: &Self) -> f64 {
        let dot: f64 = self.u.iter().zip(&other.u).map(|(a, b)| a * b).sum();
        let weight = (WEIGHT / self.size).powi(2);
        let other_length = (weight.sqrt() * length(&other.u)).hypot(other.p);
        (weight * dot + self.p * other.p) / (self.length() * other_length)
    }

    /// From one orbit to another.
    pub fn between(span: &Span, a: &Orbit, b: &Orbit) -> Self {
        Self {
            u: b.u.iter().zip(&a.u).map(|(b, a)| b - a).collect(),
            p: (b.at[span.axis] - a.at[span.axis]) / span.scale(),
            size: a.size(),
        }
    }
}

/// Length of branch from one orbit to the next.
pub fn apart(span: &Span, a: &Orbit, b: &Orbit) -> f64 {
    Vector::between(span, a, b).length()
}

/// The guess at a length `s` along orbits given with theirs: the polynomial through the nearest ones. Its p is
/// the parameter itself.
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

/// What fixes the place of an orbit on a branch.
#[derive(Debug, Clone, Copy)]
pub enum Across<'v> {
    /// The parameter of the guess.
    Parameter,
    /// A plane across this direction where the branch is steep along it, the parameter elsewhere.
    Steep(&'v Vector),
    /// A plane across this direction. Whatever connects two orbits passes every plane across their chord that
    /// lies between them, where the branch turns as well.
    Always(&'v Vector),
}

/// Seeks the orbit next to a guess.
///
/// # Errors
/// [`NoOrbit`].
pub fn place(
    map: &mut impl CycleMap,
    span: &Span,
    like: &Orbit,
    guess: &Vector,
    across: Across<'_>,
) -> Result<Orbit, NoOrbit> {
    place_bare(map, span, like, guess, across)?.with_details(map)
}

/// The same without its details, but for its size.
///
/// # Errors
/// [`NoOrbit`].
pub fn place_bare(
    map: &mut impl CycleMap,
    span: &Span,
    like: &Orbit,
    guess: &Vector,
    across: Across<'_>,
) -> Result<Orbit, NoOrbit> {
    let mut at = like.at;
    at[span.axis] = guess.p;
    let border = match across {
        Across::Steep(direction) if direction.p.abs() < STEEP * direction.length() => {
            plane(map, span, like.period, (&guess.u, at), direction)?
        }
        Across::Always(direction) => plane(map, span, like.period, (&guess.u, at), direction)?,
        Across::Parameter | Across::Steep(_) => Border::Parameters,
    };
    let mut orbit =
        correct(map, &guess.u, at, like.period, &border)?.with_multipliers(like.period)?;
    orbit.details.size = like.size();
    Ok(orbit)
}

fn plane(
    map: &mut impl CycleMap,
    span: &Span,
    period: u32,
    (u, at): (&[f64], super::map::At),
    direction: &Vector,
) -> Result<Border, NoOrbit> {
    let long = direction.length();
    let weight = (WEIGHT / direction.size).powi(2) / long;
    let column = map.by_parameter(u, at, period, span.axis)?;
    Ok(Border::Plane {
        axis: span.axis,
        scale: span.scale(),
        normal: direction.u.iter().map(|u| weight * u).collect(),
        along: direction.p / long,
        column: column.iter().map(|c| c * span.scale()).collect(),
    })
}

/// The direction of a branch at an orbit, towards larger values of the parameter: from the exact
/// derivative of the map.
///
/// # Errors
/// [`NoOrbit`] where the map has none.
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
