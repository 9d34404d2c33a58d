//! Bifurcations of maps with known normal forms.

use super::*;
use crate::analysis::continuation::branch::{StepSettings, follow, follow_away};
use crate::analysis::continuation::end::End;
use crate::analysis::continuation::map::{Details, Image, MapError, MapParameters};
use crate::analysis::continuation::orbit::{OrbitCondition, find};
use crate::analysis::continuation::switch::branches;
use faer::Mat;

/// A map of the plane that depends on one parameter.
struct PlanarMap<F: Fn([f64; 2], f64) -> ([f64; 2], [[f64; 2]; 2], [f64; 2])> {
    /// Image of a point, its derivative with respect to the point, and that with respect to the parameter.
    image: F,
    /// Period of the excitation in cycles.
    unit: u32,
}

impl<F: Fn([f64; 2], f64) -> ([f64; 2], [[f64; 2]; 2], [f64; 2])> PlanarMap<F> {
    fn new(image: F) -> Self {
        Self { image, unit: 1 }
    }

    fn run(&self, u: &[f64], p: f64, period: u32) -> ([f64; 2], [[f64; 2]; 2], [f64; 2]) {
        let (mut x, mut m, mut d) = ([u[0], u[1]], [[1.0, 0.0], [0.0, 1.0]], [0.0; 2]);
        for _ in 0..period {
            let (next, j, by) = (self.image)(x, p);
            m = std::array::from_fn(|i| {
                std::array::from_fn(|k| j[i][0] * m[0][k] + j[i][1] * m[1][k])
            });
            d = std::array::from_fn(|i| j[i][0] * d[0] + j[i][1] * d[1] + by[i]);
            x = next;
        }
        (x, m, d)
    }
}

impl<F: Fn([f64; 2], f64) -> ([f64; 2], [[f64; 2]; 2], [f64; 2])> CycleMap for PlanarMap<F> {
    fn dimension(&self) -> usize {
        2
    }

    fn unit(&self) -> u32 {
        self.unit
    }

    fn image(&mut self, u: &[f64], at: MapParameters, period: u32) -> Result<Image, MapError> {
        let (end, m, _) = self.run(u, at[0], period);
        Ok(Image {
            end: end.to_vec(),
            monodromy: Mat::from_fn(2, 2, |i, j| m[i][j]),
        })
    }

    fn by_parameter(
        &mut self,
        u: &[f64],
        at: MapParameters,
        period: u32,
        _: usize,
    ) -> Result<Vec<f64>, MapError> {
        Ok(self.run(u, at[0], period).2.to_vec())
    }

    fn details(&mut self, u: &[f64], at: MapParameters, period: u32) -> Result<Details, MapError> {
        let strobes = (0..period)
            .map(|k| self.run(u, at[0], k).0.to_vec())
            .collect();
        Ok(Details {
            strobes,
            ..Details::default()
        })
    }
}

fn span(from: f64, to: f64) -> Span {
    Span { axis: 0, from, to }
}

/// `x' = x + p − x²`: orbits ±√p, a fold at p = 0 with x = 0.
#[test]
fn a_fold_is_located_and_passed() {
    let mut map = PlanarMap::new(|[x, y], p| {
        (
            [x + p - x * x, 0.5 * y + x],
            [[1.0 - 2.0 * x, 0.0], [1.0, 0.5]],
            [1.0, 0.0],
        )
    });
    let start = find(
        &mut map,
        &[0.9, 1.8],
        [0.8, 0.0],
        1,
        &OrbitCondition::Parameters,
    )
    .unwrap();
    let branch = follow(&mut map, &span(-1.0, 0.9), start, &StepSettings::default()).unwrap();
    assert_eq!(branch.ends, [End::Interval, End::Interval]);
    let folds: Vec<_> = branch
        .bifurcations
        .iter()
        .filter(|b| b.kind == Kind::Fold)
        .collect();
    assert_eq!((folds.len(), branch.bifurcations.len()), (1, 1));
    assert!(
        folds[0].orbit.at[0].abs() < 1e-10 * 2.0,
        "{:e}",
        folds[0].orbit.at[0]
    );
    let (first, last) = (&branch.orbits[0], &branch.orbits[branch.orbits.len() - 1]);
    assert!(
        (first.u[0] * last.u[0] + 0.9).abs() < 1e-9,
        "{} {}",
        first.u[0],
        last.u[0]
    );
}

/// The period of the logistic map doubles at 3, 1 + √6 and 3.544090359551922…
#[test]
fn doublings_of_the_logistic_map_are_those_of_the_textbook() {
    let mut map = PlanarMap::new(|[x, y], p| {
        (
            [p * x * (1.0 - x), 0.3 * y],
            [[p * (1.0 - 2.0 * x), 0.0], [0.0, 0.3]],
            [x * (1.0 - x), 0.0],
        )
    });
    let span = span(2.5, 3.57);
    let start = find(
        &mut map,
        &[0.6, 0.0],
        [2.8, 0.0],
        1,
        &OrbitCondition::Parameters,
    )
    .unwrap();
    let mut branch = follow(&mut map, &span, start, &StepSettings::default()).unwrap();
    for (period, exact) in [
        (1, 3.0),
        (2, 1.0 + 6f64.sqrt()),
        (4, 3.544_090_359_551_922_8),
    ] {
        let flip = branch
            .bifurcations
            .iter()
            .find(|b| b.kind == Kind::PeriodDoubling)
            .unwrap();
        assert_eq!(flip.orbit.period, period);
        assert!(
            (flip.orbit.at[0] - exact).abs() < 1e-10,
            "{period}: {:e}",
            flip.orbit.at[0] - exact
        );
        let doubled = branches(&mut map, &span, flip);
        assert_eq!(doubled.len(), 1, "{period}");
        let [first, second] = doubled.into_iter().next().unwrap().unwrap();
        branch = follow_away(&mut map, &span, first, second, &StepSettings::default());
        assert_eq!(branch.ends[1], End::Interval);
    }
}

/// A branch of doubled period that is followed back to its period doubling ends there.
#[test]
fn a_doubled_branch_merges_into_its_parent() {
    let mut map = PlanarMap::new(|[x, y], p| {
        (
            [p * x * (1.0 - x), 0.3 * y],
            [[p * (1.0 - 2.0 * x), 0.0], [0.0, 0.3]],
            [x * (1.0 - x), 0.0],
        )
    });
    let start = find(
        &mut map,
        &[0.51, 0.0],
        [3.2, 0.0],
        2,
        &OrbitCondition::Parameters,
    )
    .unwrap();
    let branch = follow(&mut map, &span(2.5, 3.3), start, &StepSettings::default()).unwrap();
    assert_eq!(branch.ends, [End::Merged { period: 1 }, End::Interval]);
    let merging = &branch.bifurcations[0];
    assert_eq!(merging.kind, Kind::Merging { period: 1 });
    assert!(
        (merging.orbit.at[0] - 3.0).abs() < 1e-9,
        "{:e}",
        merging.orbit.at[0] - 3.0
    );
}

/// If the excitation repeats only after two cycles, no orbit has a period of one cycle. No branch merges into
/// such an orbit.
#[test]
fn no_branch_merges_below_the_period_of_the_excitation() {
    let mut map = PlanarMap::new(|[x, y], p| {
        (
            [p * x * (1.0 - x), 0.3 * y],
            [[p * (1.0 - 2.0 * x), 0.0], [0.0, 0.3]],
            [x * (1.0 - x), 0.0],
        )
    });
    map.unit = 2;
    let guess = [0.51, 0.0];
    let start = find(&mut map, &guess, [3.2, 0.0], 2, &OrbitCondition::Parameters).unwrap();
    let branch = follow(&mut map, &span(2.5, 3.3), start, &StepSettings::default()).unwrap();
    assert!(branch.orbits.len() > 10);
    assert!(branch.bifurcations.iter().all(|b| b.merges().is_none()));
    for bifurcation in &branch.bifurcations {
        let [low, high] = bifurcation.bracket;
        let value = bifurcation.orbit.at[0];
        assert!(
            (low - 1e-6..=high + 1e-6).contains(&value),
            "{value}: {low} to {high}"
        );
    }
}

/// A rotation by an angle with growth 1 + p − r²: a torus begins at p = 0.
#[test]
fn a_torus_is_located_and_its_resonance_named() {
    for (angle, resonance) in [(1.0, None), (TAU / 3.0, Some(3)), (TAU / 4.0, Some(4))] {
        let mut map = PlanarMap::new(move |[x, y], p| {
            let (sin, cos) = f64::sin_cos(angle);
            let growth = 1.0 + p - x * x - y * y;
            let turned = [cos * x - sin * y, sin * x + cos * y];
            let along = [-2.0 * x, -2.0 * y];
            let m = [[cos, -sin], [sin, cos]];
            (
                turned.map(|t| growth * t),
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| growth * m[i][j] + turned[i] * along[j])
                }),
                turned,
            )
        });
        let start = find(
            &mut map,
            &[0.0, 0.0],
            [-0.4, 0.0],
            1,
            &OrbitCondition::Parameters,
        )
        .unwrap();
        let branch = follow(&mut map, &span(-0.5, 0.5), start, &StepSettings::default()).unwrap();
        assert_eq!(branch.bifurcations.len(), 1, "{angle}");
        let torus = &branch.bifurcations[0];
        assert_eq!((torus.kind, torus.resonance()), (Kind::Torus, resonance));
        assert!(torus.orbit.at[0].abs() < 1e-10);
        assert!((torus.critical().unwrap().arg() - angle).abs() < 1e-9);
    }
}

/// `x' = x + p x − x³`: the branch x = 0 loses its stability to ±√p.
#[test]
fn at_a_pitchfork_both_other_halves_are_found() {
    let mut map = PlanarMap::new(|[x, y], p| {
        (
            [x + p * x - x * x * x, 0.2 * y],
            [[1.0 + p - 3.0 * x * x, 0.0], [0.0, 0.2]],
            [x, 0.0],
        )
    });
    let span = span(-0.5, 0.5);
    let start = find(
        &mut map,
        &[0.0, 0.0],
        [-0.4, 0.0],
        1,
        &OrbitCondition::Parameters,
    )
    .unwrap();
    let branch = follow(&mut map, &span, start, &StepSettings::default()).unwrap();
    let point = &branch.bifurcations[0];
    assert_eq!(point.kind, Kind::BranchPoint);
    assert!(point.orbit.at[0].abs() < 1e-10);
    let halves = branches(&mut map, &span, point);
    assert_eq!(halves.len(), 2);
    for half in halves {
        let [first, second] = half.unwrap();
        let half = follow_away(&mut map, &span, first, second, &StepSettings::default());
        let last = half.orbits.last().unwrap();
        assert!((last.u[0].abs() - 0.5f64.sqrt()).abs() < 1e-9 && half.ends[1] == End::Interval);
    }
}
