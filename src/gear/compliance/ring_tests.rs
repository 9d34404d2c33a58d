use super::*;

const TRANSVERSE: RootLoad = RootLoad([1.0, 0.0, 0.0]);
const MOMENT: RootLoad = RootLoad([0.0, 1.0, 0.0]);
const RADIAL: RootLoad = RootLoad([0.0, 0.0, 1.0]);

/// An arc that is short against the radius stands on a half plane: a moment turns it by
/// 18/(π E S²) (Weber 1949; half the sum of j₁²(x)/x in closed form).
#[test]
fn a_short_arc_turns_as_on_a_half_plane() {
    let turn = |half_angle: f64| {
        let ring = RingCompliance::with_harmonics(half_angle, 3.0, 0.3, 0.0, 40_000);
        ring.between(MOMENT, MOMENT) * (2.0 * half_angle).powi(2) * PI / 18.0 - 1.0
    };
    let (wide, narrow) = (turn(0.02), turn(0.01));
    assert!(narrow.abs() < 0.01, "{narrow}");
    assert!(narrow.abs() < wide.abs(), "{narrow} {wide}");
}

/// The fit's P* and P* Q* are the compliances by transverse and radial force.
#[test]
fn the_ring_is_the_one_of_the_published_fit() {
    for (half_angle, ratio) in [(0.03, 2.0), (0.05, 3.0), (0.1, 2.0), (0.1, 4.0), (0.1, 6.0)] {
        let ring = RingCompliance::with_harmonics(half_angle, ratio, 0.3, 0.0, 4000);
        let [_, _, p, q] = crate::gear::compliance::foundation::coefficients(half_angle, ratio);
        let transverse = ring.between(TRANSVERSE, TRANSVERSE) / p - 1.0;
        let radial = ring.between(RADIAL, RADIAL) / (p * q) - 1.0;
        assert!(
            transverse.abs() < 0.04,
            "{half_angle} {ratio}: {transverse}"
        );
        assert!(radial.abs() < 0.08, "{half_angle} {ratio}: {radial}");
    }
}

/// What one tooth does to another, the other does to the one; round the whole gear the twist
/// and the breathing of the ring remain.
#[test]
fn neighbours_are_symmetric_and_sum_to_the_ring_s_own() {
    let (z, half_angle, ratio) = (24, 0.12, 3.0);
    let pitch = 2.0 * PI / f64::from(z);
    let at = |j: u32| RingCompliance::new(half_angle, ratio, 0.3, f64::from(j) * pitch);
    let one = RootLoad::new(0.3, 0.1);
    let two = RootLoad::new(0.2, 0.05);
    let there = at(1).between(one, two);
    let back = at(z - 1).between(two, one);
    assert!((there / back - 1.0).abs() < 1e-12, "{there} {back}");
    // Of all teeth loaded alike only harmonics of order 0, z, 2 z ... are left; all of them but
    // 0 decay within a pitch of the root, so that a wider bore changes them not at all.
    let all = |ratio: f64| -> f64 {
        (0..z)
            .map(|j| RingCompliance::new(half_angle, ratio, 0.3, f64::from(j) * pitch))
            .map(|ring| ring.between(TRANSVERSE, TRANSVERSE))
            .sum()
    };
    let twist = |ratio: f64| f64::from(z) * (ratio * ratio - 1.0) * 2.6 / (4.0 * PI);
    let difference = all(4.0) - all(3.0);
    let expected = twist(4.0) - twist(3.0);
    assert!(
        (difference / expected - 1.0).abs() < 1e-9,
        "{difference} {expected}"
    );
}

/// Whether enough harmonics are taken.
#[test]
fn the_coupling_of_neighbours_has_converged() {
    let (half_angle, ratio) = (0.15, 3.2);
    let load = RootLoad::new(0.3, 0.1);
    let value = |harmonics: u32| {
        RingCompliance::with_harmonics(half_angle, ratio, 0.3, PI / 10.0, harmonics)
            .between(load, load)
    };
    let (taken, more) = (value(HARMONICS), value(8 * HARMONICS));
    assert!((taken / more - 1.0).abs() < 1e-4, "{taken} {more}");
}
