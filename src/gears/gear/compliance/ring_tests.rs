use super::*;

const NU: f64 = 0.3;

/// Compliance of a single foot in its modes: one foot per turn has one wave.
fn alone(half_angle: f64, ratio: f64, most: f64) -> Mat<f64> {
    let ring = Ring::new(ratio, NU);
    waves(1, half_angle, &ring, 8, most).swap_remove(0)
}

/// A foot that is short compared with the radius behaves as on a half plane. A unit moment from a linear
/// stress rotates the foot by 18/(π E S²) (Weber 1949; half the sum of j₁²(x)/x in closed form).
#[test]
fn a_short_foot_turns_as_on_a_half_plane() {
    let turn = |half_angle: f64| {
        // The moment of the mode is √(2 θ³/3). Its work is this moment times the rotation.
        let turn = alone(half_angle, 3.0, 800.0)[(1, 1)] * 1.5 / half_angle.powi(3);
        turn * (2.0 * half_angle).powi(2) * PI / 18.0 - 1.0
    };
    let (wide, narrow) = (turn(0.02), turn(0.01));
    assert!(narrow.abs() < 0.01, "{narrow}");
    assert!(narrow.abs() < wide.abs(), "{narrow} {wide}");
}

/// A bore far below does not affect harmonics that decay above it. At the order at which the closed form of the disc
/// replaces that of the ring, both are equal.
#[test]
fn a_high_harmonic_is_that_of_a_disc() {
    // With the ratio 4 the bore changes order 13 by 169/4²⁶ = 4e-14, and order 20 by less than round-off.
    let ring = Ring::new(4.0, NU);
    let disc = Ring::new(1e9, NU);
    for (order, least) in [(13, 1e-14), (20, 0.0)] {
        let (one, other) = (ring.harmonic(order), disc.harmonic(order));
        for (one, other) in one.iter().flatten().zip(other.iter().flatten()) {
            let difference = (one / other - 1.0).abs();
            assert!(
                (least..1e-12).contains(&difference),
                "{order}: {difference:e}"
            );
        }
    }
    // Compliances of high orders are those of a half plane: 2/n, and (1 − ν)/n between directions.
    let [[like, cross], _] = ring.harmonic(1_000_000);
    assert!((like * 1e6 / 2.0 - 1.0).abs() < 1e-5, "{like}");
    assert!((cross * 1e6 / (1.0 - NU) - 1.0).abs() < 1e-5, "{cross}");
}

/// A thick ring loaded from inside is a hole in an infinite plate: breathing and twist by `(1 + ν)/E` (Lamé),
/// high harmonics in closed form, and at very high orders those of a half plane seen from the other side.
#[test]
fn a_thick_ring_is_a_hole_in_a_plate() {
    let plate = Ring::new(1e-9, NU);
    for value in [plate.breathing(), plate.twist()] {
        assert!((value / (1.0 + NU) - 1.0).abs() < 1e-12, "{value}");
    }
    let thick = Ring::new(0.25, NU);
    for (order, least) in [(13, 1e-14), (20, 0.0)] {
        let (one, other) = (thick.harmonic(order), plate.harmonic(order));
        for (one, other) in one.iter().flatten().zip(other.iter().flatten()) {
            let difference = (one / other - 1.0).abs();
            assert!(
                (least..1e-11).contains(&difference),
                "{order}: {difference:e}"
            );
        }
    }
    let [[like, cross], _] = plate.harmonic(1_000_000);
    assert!((like * 1e6 / 2.0 - 1.0).abs() < 1e-5, "{like}");
    assert!((cross * 1e6 / (NU - 1.0) - 1.0).abs() < 1e-5, "{cross}");
}

/// The transverse compliance under a uniform stress is P* of Sainsot, Velex & Duverger (2004), within the error of
/// their fit. The radial compliance is P* Q*.
#[test]
fn the_ring_is_the_one_of_the_published_fit() {
    let polynomial = |[a, b, c, d, e, f]: [f64; 6], theta: f64, ratio: f64| {
        a / theta.powi(2) + b * ratio.powi(2) + c * ratio / theta + d / theta + e * ratio + f
    };
    for (theta, ratio) in [(0.03, 2.0), (0.05, 3.0), (0.1, 2.0), (0.1, 4.0), (0.1, 6.0)] {
        let p = [-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236];
        let q = [
            -6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904,
        ];
        let (p, q) = (polynomial(p, theta, ratio), polynomial(q, theta, ratio));
        let foot = alone(theta, ratio, 400.0);
        // A unit force is a stress of 1/(2 θ): the mode times 1/√(2 θ).
        let transverse = foot[(8, 8)] / (2.0 * theta) / p - 1.0;
        let radial = foot[(0, 0)] / (2.0 * theta) / (p * q) - 1.0;
        assert!(transverse.abs() < 0.04, "{theta} {ratio}: {transverse}");
        assert!(radial.abs() < 0.08, "{theta} {ratio}: {radial}");
    }
}

/// The mean of the waves round several feet, in both directions, is the compliance of a single foot.
#[test]
fn waves_sum_to_one_foot() {
    let (teeth, half_angle) = (9, 0.2);
    let ring = Ring::new(2.0, NU);
    let all = waves(teeth, half_angle, &ring, 8, 100.0);
    let one = alone(half_angle, 2.0, 100.0);
    for i in 0..16 {
        for j in 0..16 {
            // Waves in opposite directions are mirror images: modes an odd number of quarter
            // turns apart cancel.
            let even = (quarter_turns(i, 8) + quarter_turns(j, 8)).is_multiple_of(2);
            let sum: f64 = (all.iter().enumerate())
                .map(|(order, wave)| match (order, even) {
                    (0, _) => wave[(i, j)],
                    (_, true) => 2.0 * wave[(i, j)],
                    (_, false) => 0.0,
                })
                .sum();
            let mean = sum / f64::from(teeth);
            assert!(
                (mean - one[(i, j)]).abs() < 1e-13,
                "{i} {j}: {mean} {}",
                one[(i, j)]
            );
        }
    }
}
