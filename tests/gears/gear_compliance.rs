//! General laws of compliance: scaling, symmetry, sharing of the bodies.

#![allow(clippy::unwrap_used)]

use gearatlas::gear::{FlankLaw, Flanks, GearPair, Material, SecantContact, ToothForm};

fn pair(teeth: [u32; 2], module: f64) -> GearPair {
    GearPair {
        teeth,
        module,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: ToothForm {
            bore: teeth.map(|z| Some(0.4 * module * f64::from(z))),
            ..ToothForm::default()
        },
    }
}

fn flanks(pair: &GearPair) -> Flanks {
    Flanks::new(pair).unwrap_or_else(|error| panic!("{error}"))
}

fn close(value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() < 1e-10, "{value} {expected}");
}

/// Positions from one end of the path of contact to the other.
fn positions(flanks: &Flanks) -> impl Iterator<Item = f64> {
    let path = flanks.path();
    (0..=12).map(move |i| path.start + (path.end - path.start) * f64::from(i) / 12.0)
}

/// Per unit width, a gear twice as large has the same compliance, and a gear of twice the modulus has half of it.
#[test]
fn size_does_not_matter_and_stiffness_does() {
    let small = flanks(&pair([20, 30], 2e-3));
    let large = flanks(&pair([20, 30], 6e-3));
    let mut hard = pair([20, 30], 2e-3);
    for material in &mut hard.form.material {
        material.young_modulus *= 2.0;
    }
    let hard = flanks(&hard);
    for s in positions(&small) {
        let one = small.compliance(s);
        close(large.compliance(3.0 * s).total(), one.total());
        close(2.0 * hard.compliance(s).total(), one.total());
        if let Some(coupling) = small.body_coupling(s, 1) {
            close(large.body_coupling(3.0 * s, 1).unwrap()[1], coupling[1]);
            close(2.0 * hard.body_coupling(s, 1).unwrap()[0], coupling[0]);
        }
    }
}

/// Bodies couple only pairs that are in contact at the same time.
#[test]
fn only_pairs_in_contact_at_once_are_coupled() {
    let flanks = flanks(&pair([20, 30], 2e-3));
    let path = flanks.path();
    let (pitch, last) = (path.base_pitch, path.end - path.base_pitch);
    for s in [path.start, 0.5 * (path.start + last), last] {
        assert!(flanks.body_coupling(s, 1).is_some(), "{s}");
    }
    for (s, ahead) in [
        (path.start, 0),
        (path.start - 0.01 * pitch, 1),
        (last + 0.01 * pitch, 1),
        (path.start, 2),
    ] {
        assert!(flanks.body_coupling(s, ahead).is_none(), "{s} {ahead}");
    }
}

/// In reverse the wheel drives: the gears exchange their roles and positions change sign.
#[test]
fn either_gear_may_be_called_the_pinion() {
    let mut forward = pair([20, 43], 3e-3);
    forward.form.profile_shift = [0.3, -0.1];
    forward.form.material[1] = Material {
        young_modulus: 115e9,
        poisson_ratio: 0.25,
    };
    let mut backward = forward.clone();
    backward.teeth.reverse();
    backward.form.profile_shift.reverse();
    backward.form.material.reverse();
    backward.form.bore.reverse();
    let (forward, backward) = (flanks(&forward), flanks(&backward));
    for s in positions(&forward) {
        let (one, other) = (forward.compliance(s), backward.compliance(-s));
        for gear in [0, 1] {
            close(one.tooth[gear], other.tooth[1 - gear]);
            close(one.foundation[gear], other.foundation[1 - gear]);
        }
        close(one.hertz, other.hertz);
        close(
            forward.hertz_approach(s, 1e5),
            backward.hertz_approach(-s, 1e5),
        );
        let path = forward.path();
        if let Some(coupling) = forward.body_coupling(s, 1) {
            let mirrored = backward.body_coupling(-(s + path.base_pitch), 1).unwrap();
            close(coupling[0], mirrored[1]);
            close(coupling[1], mirrored[0]);
        }
    }
}

/// The compliance of shared bodies is stable: the coupling of two pairs is positive, and below the compliance of either
/// pair alone. Therefore springs of `own` and one of the coupling are equivalent.
#[test]
fn two_pairs_share_the_bodies() {
    for teeth in [[20, 30], [19, 48], [62, 62], [40, 150]] {
        let flanks = flanks(&pair(teeth, 3e-3));
        let path = flanks.path();
        let mut found = 0;
        for s in positions(&flanks) {
            let Some(coupling) = flanks.body_coupling(s, 1) else {
                assert!(s + path.base_pitch > path.end);
                continue;
            };
            found += 1;
            let (near, far) = (flanks.compliance(s), flanks.compliance(s + path.base_pitch));
            for gear in [0, 1] {
                assert!(coupling[gear] > 0.0);
                assert!(coupling[gear] < near.foundation[gear].min(far.foundation[gear]));
            }
            assert!(near.uncoupled(coupling) > near.without_bodies());
            // Share the load by the compliance matrix, and by parallel springs with one spring in series.
            let cross = coupling[0] + coupling[1];
            let (a, d) = (near.total(), far.total());
            let by_matrix = (a + d - 2.0 * cross) / (a * d - cross * cross);
            let parallel = near.uncoupled(coupling).recip() + far.uncoupled(coupling).recip();
            close(by_matrix, (parallel.recip() + cross).recip());
        }
        assert!(found > 3);
        assert_eq!(flanks.body_coupling(path.end, 1), None);
        assert_eq!(flanks.body_coupling(path.start, 2), None);
        // The pair that leaves contact when the second next pair enters still couples.
        assert!(
            flanks
                .body_coupling(path.end - path.base_pitch, 1)
                .is_some()
        );
    }
}

/// Beyond a contact ratio of 2 every other pair is also coupled, but less.
#[test]
fn three_pairs_share_the_bodies_of_high_contact_ratio_gears() {
    let mut high = pair([60, 80], 3e-3);
    high.form.rack.addendum = 1.3;
    high.form.rack.dedendum = 1.5;
    high.form.rack.tip_radius = 0.2;
    let flanks = flanks(&high);
    assert!(flanks.contact_ratio() > 2.0, "{}", flanks.contact_ratio());
    assert_eq!(flanks.path().single_pair(), None);
    let start = flanks.path().start;
    let (next, other) = (
        flanks.body_coupling(start, 1),
        flanks.body_coupling(start, 2),
    );
    for (next, other) in next.unwrap().iter().zip(other.unwrap()) {
        assert!(0.0 < other && other < *next, "{next} {other}");
    }
}

/// Only the load-dependent contact replaces the linear one.
#[test]
fn under_load_only_the_contact_changes() {
    let flanks = flanks(&pair([20, 30], 4e-3));
    for s in positions(&flanks) {
        let under_load = SecantContact {
            law: &flanks,
            line_load: 6.65e4,
        };
        let (linear, loaded) = (flanks.compliance(s), under_load.compliance(s));
        assert_eq!(
            (linear.tooth, linear.foundation),
            (loaded.tooth, loaded.foundation)
        );
        close(loaded.hertz * 6.65e4, flanks.hertz_approach(s, 6.65e4));
    }
}
