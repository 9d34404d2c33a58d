//! Bifurcations of codimension two between two orbits, and curves of maps with known bifurcations.

use super::*;
use crate::analysis::continuation::map::{Details, Image, MapError};
use crate::analysis::continuation::touches::{Extreme, Touches};
use faer::Mat;

/// An orbit with multipliers given by modulus and angle \[rad\]. An angle between 0 and π gives a complex
/// pair. `depths` are those of one contact at its extremes, minima and maxima in turn, a minimum first.
fn orbit(polar: &[[f64; 2]], depths: &[f64]) -> Orbit {
    let mut multipliers = Vec::new();
    for &[modulus, angle] in polar {
        if angle == 0.0 || angle == PI {
            let sign = if angle == 0.0 { 1.0 } else { -1.0 };
            multipliers.push(Complex64::new(sign * modulus, 0.0));
        } else {
            let one = Complex64::from_polar(modulus, angle);
            multipliers.extend([one, one.conj()]);
        }
    }
    Orbit {
        u: vec![0.0; multipliers.len()],
        at: [0.0; 2],
        period: 1,
        residual: 0.0,
        steps: 0,
        monodromy: Mat::zeros(0, 0),
        multipliers,
        details: Details {
            touches: Touches {
                extremes: (depths.iter().enumerate())
                    .map(|(i, &depth)| Extreme {
                        contact: 0,
                        is_minimum: i % 2 == 0,
                        time: i as f64 / depths.len() as f64,
                        depth,
                    })
                    .collect(),
                ..Touches::default()
            },
            ..Details::default()
        },
    }
}

/// The note between two orbits. Checks that it is the same in both orders.
fn found(kind: Kind, a: &[[f64; 2]], b: &[[f64; 2]]) -> Option<&'static str> {
    let [a, b] = [a, b].map(|polar| orbit(polar, &[]));
    let note = kind.codimension_two(&a, &b);
    assert_eq!(note, kind.codimension_two(&b, &a));
    note
}

/// A torus is resonant where the angle of its pair passes a third or a quarter of a turn, and nowhere else.
#[test]
fn a_torus_is_resonant_at_a_third_and_a_quarter_of_a_turn() {
    for (from, to, note) in [
        (119.0, 121.0, Some("resonance 1:3")),
        (89.0, 91.0, Some("resonance 1:4")),
        (60.0, 70.0, None),
        (95.0, 115.0, None),
        (130.0, 170.0, None),
        (1.0, 80.0, None),
    ] {
        let at = |degrees: f64| [[1.0, f64::to_radians(degrees)], [0.3, 0.0]];
        assert_eq!(found(Kind::Torus, &at(from), &at(to)), note, "{from} {to}");
    }
    // Only the pair on the unit circle decides. Without a pair there is no note.
    let two = |degrees: f64| {
        [
            [0.4, f64::to_radians(120.0)],
            [1.0, f64::to_radians(degrees)],
        ]
    };
    assert_eq!(
        found(Kind::Torus, &two(88.0), &two(92.0)),
        Some("resonance 1:4")
    );
    assert_eq!(found(Kind::Torus, &[[0.5, 0.0]], &[[0.6, 0.0]]), None);
}

/// A second multiplier passes the unit circle while the first one is on it.
#[test]
fn a_second_multiplier_that_passes_the_circle_is_told() {
    let inside = [[1.0, 0.0], [0.5, 1.0], [0.9, PI]];
    let doubled = [[1.0, 0.0], [0.5, 1.0], [1.1, PI]];
    let turning = [[1.0, 0.0], [1.1, 1.0], [0.9, PI]];
    for (other, note) in [
        (doubled, Some("fold and period doubling")),
        (turning, Some("fold and torus")),
        (inside, None),
    ] {
        assert_eq!(found(Kind::Fold, &inside, &other), note);
    }
    let inside = [[1.0, PI], [0.5, 1.0], [0.9, 0.0]];
    let folded = [[1.0, PI], [0.5, 1.0], [1.1, 0.0]];
    let turning = [[1.0, PI], [1.1, 1.0], [0.9, 0.0]];
    for (other, note) in [
        (folded, Some("fold and period doubling")),
        (turning, Some("period doubling and torus")),
        (inside, None),
    ] {
        assert_eq!(found(Kind::PeriodDoubling, &inside, &other), note);
    }
}

/// Along a curve of grazes, a multiplier passes ±1, or another extreme grazes.
#[test]
fn what_happens_on_a_graze_besides_is_told() {
    let kind = Kind::Graze {
        extreme: Extreme {
            contact: 0,
            is_minimum: true,
            time: 0.5,
            depth: 0.0,
        },
    };
    let inside = [[0.9, 0.0], [0.8, PI]];
    assert_eq!(found(kind, &inside, &inside), None);
    let folded = [[1.1, 0.0], [0.8, PI]];
    assert_eq!(found(kind, &inside, &folded), Some("graze and fold"));
    let doubled = [[0.9, 0.0], [1.2, PI]];
    assert_eq!(
        found(kind, &inside, &doubled),
        Some("graze and period doubling")
    );
    // Round-off in the depth of the graze itself is not another graze. Neither is an extreme while the
    // contact is closed.
    let touching = |depths: &[f64]| orbit(&inside, depths);
    let [inward, outward] = [1e-15, -1e-15].map(|depth| touching(&[depth, 0.5]));
    assert_eq!(kind.codimension_two(&inward, &outward), None);
    let undulating = touching(&[1e-15, 0.5, 0.4, 0.5]);
    assert_eq!(kind.codimension_two(&inward, &undulating), None);
    let leaving = touching(&[1e-15, 0.5, -0.1, 0.5]);
    assert_eq!(
        kind.codimension_two(&undulating, &leaving),
        Some("another graze")
    );
    for kind in [Kind::BranchPoint, Kind::Jump, Kind::Merging { period: 1 }] {
        assert_eq!(found(kind, &inside, &doubled), None);
    }
}

/// The plane includes its borders, and lengths in it are relative to its sides.
#[test]
fn places_in_a_plane_are_parts_of_its_sides() {
    let plane = CurveSettings {
        from: [1.0, 100.0],
        to: [3.0, 500.0],
        longest: 0.1,
        most: 10,
    };
    assert!(plane.contains([1.0, 500.0]) && plane.contains([2.0, 300.0]));
    assert!(!plane.contains([0.999, 300.0]) && !plane.contains([2.0, 500.1]));
    let apart = plane.distance_between([1.2, 220.0], [1.8, 380.0]);
    assert!((apart - 0.5).abs() < 1e-14, "{apart}");
}

/// `y' = y + p₀ − g(p₁) − x²` with `x = y − 1`. Its folds lie on the hyperbola `p₀ = g(p₁) = √(p₁² + w²)`.
struct Hyperbola {
    width: f64,
}

impl CycleMap for Hyperbola {
    fn dimension(&self) -> usize {
        1
    }

    fn image(&mut self, u: &[f64], at: MapParameters, _: u32) -> Result<Image, MapError> {
        let x = u[0] - 1.0;
        Ok(Image {
            end: vec![u[0] + at[0] - at[1].hypot(self.width) - x * x],
            monodromy: Mat::from_fn(1, 1, |_, _| 1.0 - 2.0 * x),
        })
    }

    fn by_parameter(
        &mut self,
        _: &[f64],
        at: MapParameters,
        _: u32,
        axis: usize,
    ) -> Result<Vec<f64>, MapError> {
        Ok(vec![[1.0, -at[1] / at[1].hypot(self.width)][axis]])
    }

    fn details(&mut self, _: &[f64], _: MapParameters, _: u32) -> Result<Details, MapError> {
        Ok(Details::default())
    }
}

/// A curve is followed through a bend that is much sharper than its steps. The steps become shorter there and
/// grow again afterwards. At a corner, the curve ends.
#[test]
fn a_sharp_bend_is_followed_in_shorter_steps() {
    let plane = CurveSettings {
        from: [-1.0, -1.0],
        to: [1.5, 1.0],
        longest: 0.1,
        most: 500,
    };
    for (width, end) in [
        (1e-2, "the interval ends"),
        (1e-4, "the interval ends"),
        (0.0, "the curve turns sharply"),
    ] {
        let mut map = Hyperbola { width };
        let at = [f64::hypot(-0.5, width), -0.5];
        let orbit = (correct(&mut map, &[1.0], at, 1, &OrbitCondition::Parameters).unwrap())
            .with_multipliers(1)
            .unwrap();
        let start = Bifurcation {
            kind: Kind::Fold,
            orbit,
            after: 0,
            length: 0.0,
            bracket: [at[0]; 2],
            unfollowed_branch: None,
        };
        let curve = follow(&mut map, &plane, &start).unwrap();
        assert_eq!(curve.ends, ["the interval ends", end], "{width}");
        let places: Vec<MapParameters> = curve.points.iter().map(|point| point.orbit.at).collect();
        for at in &places {
            assert!((at[0] - at[1].hypot(width)).abs() < 1e-9, "{width}: {at:?}");
        }
        let steps: Vec<f64> = places
            .windows(2)
            .map(|pair| plane.distance_between(pair[0], pair[1]))
            .collect();
        let shortest = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let longest = steps.iter().copied().fold(0.0, f64::max);
        assert!(
            shortest < 2.0 * width.max(1e-5) && longest > 0.03,
            "{width}: {steps:?}"
        );
        let nearest = places
            .iter()
            .map(|at| at[1].abs())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < width.max(1e-4), "{width}: {nearest:e}");
    }
}

/// `y' = m y`, where m passes −1 on the line p₀ = p₁ / 2: smoothly for p₁ below 1/2, and by a jump of 0.6 beyond.
struct Jumping;

impl Jumping {
    fn multiplier(at: MapParameters) -> f64 {
        let beyond = at[0] - 0.5 * at[1];
        let step = if at[1] < 0.5 { beyond } else { f64::copysign(0.3, beyond) };
        -1.0 - step
    }
}

impl CycleMap for Jumping {
    fn dimension(&self) -> usize {
        1
    }

    fn image(&mut self, u: &[f64], at: MapParameters, _: u32) -> Result<Image, MapError> {
        let m = Self::multiplier(at);
        Ok(Image {
            end: vec![m * u[0]],
            monodromy: Mat::from_fn(1, 1, |_, _| m),
        })
    }

    fn by_parameter(
        &mut self,
        _: &[f64],
        _: MapParameters,
        _: u32,
        _: usize,
    ) -> Result<Vec<f64>, MapError> {
        Ok(vec![0.0])
    }

    fn details(&mut self, _: &[f64], _: MapParameters, _: u32) -> Result<Details, MapError> {
        Ok(Details::default())
    }
}

/// A curve of period doublings ends where the multiplier jumps past −1 instead of passing it.
#[test]
fn a_multiplier_that_jumps_past_its_value_is_no_bifurcation() {
    let plane = CurveSettings {
        from: [-1.0, -1.0],
        to: [1.0, 1.0],
        longest: 0.02,
        most: 500,
    };
    let mut map = Jumping;
    let orbit = (correct(&mut map, &[0.0], [0.0; 2], 1, &OrbitCondition::Parameters).unwrap())
        .with_multipliers(1)
        .unwrap();
    let start = Bifurcation {
        kind: Kind::PeriodDoubling,
        orbit,
        after: 0,
        length: 0.0,
        bracket: [0.0; 2],
        unfollowed_branch: None,
    };
    let curve = follow(&mut map, &plane, &start).unwrap();
    assert_eq!(curve.ends[0], "the interval ends");
    assert!([JUMPS, "the bifurcation is not found nearby"].contains(&curve.ends[1]));
    let last = curve.points.last().unwrap().orbit.at;
    assert!((0.49..0.5).contains(&last[1]), "{last:?}");
    for CurvePoint { orbit, .. } in &curve.points {
        assert!(
            (Jumping::multiplier(orbit.at) + 1.0).abs() < 1e-8,
            "{:?}",
            orbit.at
        );
    }
}
