//! How accurate is a Rayleigh quotient?

#![allow(clippy::unwrap_used)]
use super::*;

/// For a diagonal pair the sum has a closed form, `16 ε Σ (k + σ m) φ²`. Entries off the diagonal
/// count by their modulus, in dense matrices and in banded ones.
#[test]
fn the_rounding_of_a_quotient_is_that_of_the_moduli_it_sums() {
    let (elastic, inertial) = ([3e8, 2e5, 7e6], [2.0, 5.0, 0.5]);
    let (shift, shape) = (400.0, [0.3, -1.2, 2.0]);
    for beside in [0.0, 1e5, -1e5] {
        let tridiagonal = |diagonal: [f64; 3], beside: f64| {
            Mat::from_fn(3, 3, |i, j| match i.abs_diff(j) {
                0 => diagonal[i],
                1 => beside,
                _ => 0.0,
            })
        };
        let [mass, stiffness] = [tridiagonal(inertial, 0.1), tridiagonal(elastic, beside)];
        let mut sum = 0.0;
        for i in 0..3 {
            sum += (elastic[i] + shift * inertial[i]) * shape[i] * shape[i];
        }
        for i in 0..2 {
            let factor: f64 = beside.abs() + shift * 0.1;
            sum += 2.0 * factor * (shape[i] * shape[i + 1]).abs();
        }
        let exact = 16.0 * f64::EPSILON * sum;
        let [banded_mass, banded_stiffness] = [&mass, &stiffness].map(|m| Banded::of(m, 1));
        for pencil in [
            Pencil::Dense(&mass, &stiffness),
            Pencil::Banded(&banded_mass, &banded_stiffness),
        ] {
            let found = rounding_of_quotient(pencil, shift, &shape);
            assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
        }
    }
}

/// A spring of a hundred-millionth of the others' stiffness still counts as one; without it there is a rigid motion.
#[test]
fn a_soft_spring_is_no_rigid_motion() {
    let rigid = |soft: f64| {
        let stiffness = Mat::from_fn(3, 3, |i, j| match (i, j) {
            (0, 0) => soft,
            (i, j) if i == j => 1e8,
            _ => 0.0,
        });
        let mass = Mat::<f64>::identity(3, 3);
        [0, 1].map(|expected| Modes::lowest(&mass, &stiffness, 2, expected).is_ok())
    };
    assert_eq!(rigid(0.0), [false, true]);
    assert_eq!(rigid(1.0), [true, false]);
}
