//! δ on a short stretch as a Taylor polynomial, and certificates from rows.

use super::exits::{Bounds, DeflectionAt, MarginAt, Verdict, earliest_exit, judge};
use super::exponential::bound_row;
use super::generator::Generator;
use super::matrix::{dot, reach};
use super::show::Taylor;
use super::state_part::{Exit, StatePart};
use crate::model::Contact;
use crate::propagate::Counters;
use crate::propagate::events::Margin;

/// Terms of the polynomial. On a stretch of 0.25 over the fastest rate, the next term is about 0.25¹⁶/16! = 10⁻²³.
pub const TERMS: usize = 16;

/// δ as a polynomial of the time since a state.
#[derive(Debug, Clone, Copy)]
pub struct Series {
    /// δ⁽ᵏ⁾/k!.
    coefficients: [f64; TERMS + 1],
}

impl Series {
    /// The polynomial of a state, up to the power `last` ≤ [`TERMS`] of the time.
    pub fn new(generator: &Generator, z: &[f64], last: usize, taylor: &mut Taylor) -> Self {
        let mut coefficients = [0.0; TERMS + 1];
        coefficients[0] = dot(&generator.deflection, z);
        taylor.terms(generator, z, last - 1, |k, term| {
            coefficients[k + 1] = dot(&generator.rate, term) / (k + 1) as f64;
        });
        Self { coefficients }
    }

    /// δ, δ', δ'' at a time.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let [mut value, mut slope, mut half_curvature] = [0.0; 3];
        for &c in self.coefficients.iter().rev() {
            half_curvature = half_curvature * time + slope;
            slope = slope * time + value;
            value = value * time + c;
        }
        [value, slope, 2.0 * half_curvature]
    }
}

/// Rows that bound δ'' and δ''' over a cell: `|δ''| ≤ Σ second |z|`.
#[derive(Debug, Clone)]
pub struct BoundRows {
    second: Vec<f64>,
    third: Vec<f64>,
}

impl BoundRows {
    /// The rows for times up to `duration` after a state.
    pub fn new(generator: &Generator, rate: f64, duration: f64) -> Self {
        let padded = generator.layout().padded();
        let (mut second, mut third) = (vec![0.0; padded], vec![0.0; padded]);
        let curvature = generator.curvature();
        let mut jerk = vec![0.0; padded];
        generator.apply_to_row(&curvature, &mut jerk);
        bound_row(generator, rate, duration, &curvature, None, &mut second);
        bound_row(generator, rate, duration, &jerk, None, &mut third);
        Self { second, third }
    }

    /// Bounds for a state.
    pub fn at(&self, z: &[f64], noise: f64) -> Bounds {
        Bounds {
            second: reach(&self.second, z),
            third: reach(&self.third, z),
            noise,
        }
    }
}

/// The verdict on all margins of a stretch between two times: [`Verdict::Split`] if several are not clear.
pub fn judge_all(
    stretch: &StatePart,
    contacts: &[Contact],
    [a, b]: [&DeflectionAt; 2],
    bounds: &Bounds,
    starts: bool,
) -> Verdict {
    let mut worst = Verdict::Clear;
    for margin in Margin::of(contacts, stretch.contact) {
        let starts_at_root = starts && stretch.crossed == Some(margin.contact);
        match judge(
            &MarginAt::of(&margin, a),
            &MarginAt::of(&margin, b),
            bounds,
            starts_at_root,
        ) {
            Verdict::Clear => {}
            found if worst == Verdict::Clear => worst = found,
            _ => worst = Verdict::Split,
        }
    }
    worst
}

/// The first exit between two times, whose deflections are `ends`; `None` without one. `guard` gives δ, δ', δ'' at any
/// time between them; `starts`: the stretch starts at the first.
pub fn locate(
    stretch: &StatePart,
    contacts: &[Contact],
    ends: [&DeflectionAt; 2],
    bounds: &Bounds,
    starts: bool,
    guard: &mut impl FnMut(f64) -> [f64; 3],
    counters: &mut Counters,
) -> Option<Exit> {
    let [first, mut last] = [*ends[0], *ends[1]];
    let mut exit: Option<Exit> = None;
    for margin in Margin::of(contacts, stretch.contact) {
        let starts_at_root = starts && stretch.crossed == Some(margin.contact);
        let found = earliest_exit(
            &margin,
            [&first, &last],
            bounds,
            starts_at_root,
            guard,
            counters,
        );
        if let Some(time) = found {
            exit = Some(Exit {
                time,
                contact: margin.contact,
            });
            if time <= first.time {
                break;
            }
            last = DeflectionAt {
                time,
                deflection: guard(time),
            };
        }
    }
    exit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ActiveSet, Release};
    use std::f64::consts::TAU;

    #[test]
    fn a_polynomial_has_its_derivatives() {
        let mut coefficients = [0.0; TERMS + 1];
        coefficients[..4].copy_from_slice(&[1.0, -2.0, 3.0, 0.5]);
        let series = Series { coefficients };
        let t = 0.7;
        let exact = [
            1.0 - 2.0 * t + 3.0 * t * t + 0.5 * t * t * t,
            -2.0 + 6.0 * t + 1.5 * t * t,
            6.0 + 3.0 * t,
        ];
        for (found, exact) in series.at(t).iter().zip(exact) {
            assert!((found - exact).abs() < 1e-15);
        }
    }

    /// If there are two open contacts, the first one reached counts, in any order of the list.
    #[test]
    fn the_first_of_two_surfaces_is_met() {
        let contacts = [1.0, -1.0].map(|side| Contact {
            band: f64::INFINITY,
            side,
            half_gap: 1.0,
            cycles: Vec::new(),
            release: Release::Deflection,
        });
        let stretch = StatePart {
            cell: 0,
            contact: ActiveSet::FREE,
            duration: 1.0,
            whole: true,
            crossed: None,
            noise: 1e-15,
        };
        let found = |size: f64, start: f64, stretch: &StatePart| {
            let mut guard = |t: f64| {
                let (sin, cos) = (TAU * t).sin_cos();
                [
                    start + size * sin,
                    TAU * size * cos,
                    -TAU * TAU * size * sin,
                ]
            };
            let ends = [0.0, 1.0].map(|time| DeflectionAt {
                time,
                deflection: guard(time),
            });
            let bounds = Bounds {
                second: TAU.powi(2) * size.abs(),
                third: TAU.powi(3) * size.abs(),
                noise: 1e-15,
            };
            let mut counters = Counters::default();
            let [first, last] = [&ends[0], &ends[1]];
            let crossing = locate(
                stretch,
                &contacts,
                [first, last],
                &bounds,
                true,
                &mut guard,
                &mut counters,
            );
            crossing.map(|exit| (exit.time, exit.contact))
        };
        let first = (2.0f64 / 3.0).asin() / TAU;
        for (size, contact) in [(1.5, 0), (-1.5, 1)] {
            let (time, crossing) = found(size, 0.0, &stretch).unwrap();
            assert!(
                (time - first).abs() < 1e-13 && crossing == contact,
                "{time} {crossing}"
            );
        }
        assert_eq!(found(0.9, 0.0, &stretch), None);
        // The deflection is beyond a surface from the start.
        assert_eq!(found(0.1, 1.5, &stretch), Some((0.0, 0)));
        assert_eq!(found(0.1, -1.5, &stretch), Some((0.0, 1)));
        // After leaving a surface, the next one is met.
        let crossed = StatePart {
            crossed: Some(0),
            ..stretch
        };
        let (time, crossing) = found(-1.2, 1.0, &crossed).unwrap();
        assert!(
            (time - 0.5).abs() < 1e-13 && crossing == 0,
            "{time} {crossing}"
        );
    }
}
