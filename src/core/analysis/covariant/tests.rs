use super::ginelli::Coefficients;
use super::*;
use crate::model::{OperatingPoint, fixtures};
use crate::numerics::random::Stream;

/// The model of one mode, whose state space is a plane, with the raw norm.
fn plane() -> (EnergyNorm, usize) {
    let structure = fixtures::structure(&[0.0], 0.0, &[1.0], &[1.0]);
    let drive = fixtures::two_level_mesh(10e-6);
    let point = OperatingPoint {
        load: 0.1,
        speed: 1200.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    (EnergyNorm::raw(&model), model.modes())
}

type Jacobian = [[f64; 2]; 2];

/// The record of a planar map's tangents, and the tangents after every cycle, column by column.
fn record(
    start: [f64; 2],
    cycles: usize,
    map: impl Fn([f64; 2]) -> ([f64; 2], Jacobian),
) -> (Record, Vec<Jacobian>, Vec<Jacobian>) {
    let (norm, modes) = plane();
    let mut growth = TangentGrowth::new(&norm, modes, 2, &mut Stream::new(3, 1, 4));
    let mut record = Record::new(2, cycles);
    let (mut frames, mut jacobians) = (Vec::new(), Vec::new());
    let mut at = start;
    for cycle in 0..cycles + 100 {
        let (next, jacobian) = map(at);
        at = next;
        for i in 0..2 {
            let moved = apply(&jacobian, growth.tangents().vector(i));
            growth.tangents().vector_mut(i).copy_from_slice(&moved);
        }
        if cycle < 100 {
            growth.cycle(&norm);
            continue;
        }
        record.push(&mut growth, &norm);
        jacobians.push(jacobian);
        frames.push([0, 1].map(|i| [0, 1].map(|j| growth.tangents().vector(i)[j])));
    }
    (record, frames, jacobians)
}

fn apply(jacobian: &Jacobian, x: &[f64]) -> [f64; 2] {
    jacobian.map(|row| row[0] * x[0] + row[1] * x[1])
}

fn henon([x, y]: [f64; 2]) -> ([f64; 2], Jacobian) {
    (
        [1.0 - 1.4 * x * x + y, 0.3 * x],
        [[-2.8 * x, 1.0], [0.3, 0.0]],
    )
}

fn random() -> Coefficients {
    Coefficients::random(2, &mut Stream::new(9, 2, 6))
}

/// The matrix `[[3, 2], [1, 1]]`: constant eigenvectors `(1 ± √3, 1)`, multipliers 2 ± √3.
#[test]
fn a_linear_map_has_its_eigenvectors() {
    let matrix = [[3.0, 2.0], [1.0, 1.0]];
    let (record, ..) = record([0.1, 0.2], 1000, |at| (at, matrix));
    let found = record.back(random(), 100).unwrap();
    let root = 3f64.sqrt();
    for (found, exact) in found.exponents.iter().zip([2.0 + root, 2.0 - root]) {
        assert!((found - exact.ln()).abs() < 1e-12, "{found} {exact}");
    }
    assert!(found.spreads.iter().all(|s| *s < 1e-12), "{found:?}");
    let [a, b] = [1.0 + root, 1.0 - root];
    let exact = ((a * b + 1.0) / (a.hypot(1.0) * b.hypot(1.0))).abs().acos();
    let angle = found.angle.unwrap();
    assert!((angle.min - exact).abs() < 1e-12, "{angle:?} {exact}");
    assert!((angle.mean - exact).abs() < 1e-12 && angle.quantiles.len() == 5);
    assert_eq!((found.unstable, found.stable), (1, 1));
}

/// In every cycle the map takes each vector to the next one within round-off, and their growth agrees with
/// the results.
#[test]
fn vectors_are_taken_to_each_other() {
    let (record, frames, jacobians) = record([0.1, 0.1], 600, henon);
    let mut coefficients = random();
    let vectors = |c: &Coefficients, frame: &Jacobian| {
        [0, 1].map(|i| {
            [0, 1].map(|row| {
                (c.vector(i).iter().zip(frame))
                    .map(|(c, q)| c * q[row])
                    .sum::<f64>()
            })
        })
    };
    let mut growth = [0.0; 2];
    let mut later = vectors(&coefficients, frames.last().unwrap());
    let mut worst = 0.0f64;
    for cycle in (1..frames.len()).rev() {
        coefficients.back(&record.factors[3 * cycle..3 * cycle + 3], &mut growth);
        let now = vectors(&coefficients, &frames[cycle - 1]);
        for ((now, later), growth) in now.iter().zip(&later).zip(&growth) {
            let image = apply(&jacobians[cycle], now);
            let length = image[0].hypot(image[1]);
            let across = (image[0] * later[1] - image[1] * later[0]) / length;
            worst = worst.max(across.abs()).max((length.ln() - growth).abs());
        }
        later = now;
    }
    // Small ratios |μ₂/μ₁| in a cycle, down to 0.01, magnify round-off by their inverse.
    assert!(worst < 1e-11, "{worst:e}");
}

/// Hénon's map: each vector grows by its published exponent (0.41922 and −1.62319). Its stable and unstable
/// directions touch (Ginelli et al. 2007), unlike those of a hyperbolic map. The angle agrees with directions
/// from separate long runs: forwards, and backwards by the inverse.
#[test]
fn henons_directions_are_those_of_long_runs_and_touch() {
    let (record, frames, jacobians) = record([0.1, 0.1], 40_000, henon);
    let found = record.back(random(), 100).unwrap();
    for (found, error, published) in [
        (found.exponents[0], found.errors[0], 0.419_22),
        (found.exponents[1], found.errors[1], -1.623_19),
    ] {
        assert!(
            (found - published).abs() < 3.0 * error + 1e-4,
            "{found} {error}"
        );
    }
    let angle = found.angle.unwrap();
    assert!(angle.min < 2e-3, "{angle:?}");
    assert!(
        angle.quantiles.is_sorted() && angle.quantiles[0] >= angle.min,
        "{angle:?}"
    );

    // The stable direction at one cycle, from fifty cycles of the inverse.
    let (at, ahead) = (20_000, 50);
    let mut stable = [1.0, 0.3];
    for jacobian in jacobians[at + 1..=at + ahead].iter().rev() {
        let [[a, b], [c, d]] = *jacobian;
        let inverse = [[d, -b], [-c, a]];
        stable = apply(&inverse, &stable);
        let length = stable[0].hypot(stable[1]);
        stable = stable.map(|x| x / length);
    }
    let unstable = frames[at][0];
    let exact = (unstable[0] * stable[1] - unstable[1] * stable[0])
        .abs()
        .asin();
    let mut coefficients = random();
    let mut growth = [0.0; 2];
    for cycle in (at + 1..frames.len()).rev() {
        coefficients.back(&record.factors[3 * cycle..3 * cycle + 3], &mut growth);
    }
    let angle = coefficients.angle(1, 1).unwrap();
    assert!((angle - exact).abs() < 1e-10, "{angle} {exact}");
}

/// The angle of two planes in four dimensions is the smaller of their two principal angles.
#[test]
fn the_smallest_angle_of_planes_is_a_principal_angle() {
    // Columns of C: e₁, e₂, then directions 0.3 rad and 1.1 rad off the plane of both.
    let mut stream = Stream::new(1, 2, 3);
    let mut coefficients = Coefficients::random(4, &mut stream);
    let (a, b) = (0.3f64, 1.1f64);
    coefficients.set(&[
        1.0,
        0.0,
        1.0,
        a.cos(),
        0.0,
        a.sin(),
        0.0,
        b.cos(),
        0.0,
        b.sin(),
    ]);
    let angle = coefficients.angle(2, 2).unwrap();
    assert!((angle - a).abs() < 1e-14, "{angle}");
    let angle = coefficients.angle(2, 1).unwrap();
    assert!((angle - b).abs() < 1e-14, "{angle}");
}

#[test]
fn a_direction_that_vanishes_is_told() {
    let record = Record {
        vectors: 2,
        factors: [2.0, 0.1, 0.0].repeat(400),
    };
    assert!(record.back(random(), 10).is_none());
}

#[test]
fn memory_is_a_triangle_a_cycle() {
    let config = CovariantConfig {
        vectors: 4,
        cycles: 1000,
        align: 200,
    };
    assert_eq!(config.memory(), 8 * 10 * 1200);
}
