//! Load sharing against closed forms and against bisection of its definition.

#![allow(clippy::unwrap_used, dead_code)]

#[path = "common/flank.rs"]
mod flank;

use atlas::gear::{ContactPair, Face, Foundation, LoadSharing, SharedLoad, SharingError, pairs_at};
use flank::{FACE_WIDTH, FunctionFlank, MISALIGNMENT, STIFFNESS, default_force, path, split};

fn face(slices: usize) -> Face {
    Face {
        width: FACE_WIDTH,
        slices,
    }
}

/// A load on the pairs of a law at a mesh phase.
fn bear(
    law: &FunctionFlank,
    phase: f64,
    slices: usize,
    misalignment: f64,
    foundation: Foundation,
    force: f64,
) -> SharedLoad {
    let pairs = pairs_at(law, phase, face(slices)).unwrap();
    let sharing = LoadSharing::new(&pairs, face(slices), misalignment, foundation).unwrap();
    sharing.bear(force)
}

fn close(found: f64, exact: f64, tolerance: f64) {
    assert!(
        (found - exact).abs() <= tolerance * exact.abs(),
        "{found} against {exact}"
    );
}

#[test]
fn a_misaligned_flank_bears_on_a_wedge() {
    let force = default_force();
    let law = FunctionFlank::constant(path(1.0), STIFFNESS);
    for misalignment in [MISALIGNMENT, -MISALIGNMENT] {
        for slices in [1, 7, 64] {
            let load = bear(&law, 0.5, slices, misalignment, Foundation::Strips, force);
            let length = (2.0 * force / (STIFFNESS * MISALIGNMENT)).sqrt();
            let side = -misalignment.signum();
            close(length / FACE_WIDTH, 0.577, 1e-3);
            close(load.stiffness, STIFFNESS * length, 1e-13);
            close(load.contact_fraction, length / FACE_WIDTH, 1e-13);
            let centre = side * (0.5 * FACE_WIDTH - length / 3.0);
            close(load.centre, centre, 1e-13);
            let approach = MISALIGNMENT * (length - 0.5 * FACE_WIDTH);
            close(load.deflection, approach, 1e-13);
            let drop = 1.0 - load.stiffness / (STIFFNESS * FACE_WIDTH);
            assert!((drop - 0.42).abs() < 0.005, "{drop}");
        }
    }
}

/// Fully loaded: stiffness as if aligned, centroid by the covariance of load and place.
#[test]
fn a_slightly_misaligned_flank_is_fully_loaded() {
    let force = default_force();
    let law = FunctionFlank::constant(path(1.0), STIFFNESS);
    let load = bear(&law, 0.5, 3, 1e-4, Foundation::Strips, force);
    close(load.stiffness, STIFFNESS * FACE_WIDTH, 1e-14);
    assert_eq!(load.contact_fraction, 1.0);
    let centre = -1e-4 * STIFFNESS * FACE_WIDTH.powi(3) / 12.0 / force;
    close(load.centre, centre, 1e-12);
}

#[test]
fn aligned_pairs_share_by_stiffness_and_one_body() {
    let force = default_force();
    let (tooth, foundation) = (4e-11, 2e-11);
    let law = FunctionFlank {
        compliance: Box::new(move |s| {
            let far = 1.0 + 40.0 * s.abs();
            split(tooth * far, foundation * far)
        }),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    let places = [0.2, 1.2].map(|p| law.path.start + p * law.path.base_pitch);
    let far = places.map(|s: f64| 1.0 + 40.0 * s.abs());
    let springs = far.map(|far| FACE_WIDTH / (tooth * far));
    let sum = springs[0] + springs[1];
    let shares = springs.map(|k| k / sum);
    // The bodies' mean compliance, weighted by load, behind the teeth side by side.
    let body = (shares[0] * far[0] + shares[1] * far[1]) * foundation / FACE_WIDTH;
    let stiffness = 1.0 / (1.0 / sum + body);
    for kind in [Foundation::Strips, Foundation::Body] {
        let load = bear(&law, 0.2, 16, 0.0, kind, force);
        close(load.stiffness, stiffness, 1e-13);
        close(load.deflection, force / stiffness, 1e-13);
        for pair in 0..2 {
            close(load.share[pair], shares[pair], 1e-13);
        }
        assert_eq!(load.share[2], 0.0);
        assert_eq!(load.contact_fraction, 1.0);
        assert!(load.centre.abs() < 1e-15 * FACE_WIDTH, "{}", load.centre);
    }
}

/// Counted for each pair on its own, the bodies would bear half of what they do.
#[test]
fn a_stiff_tooth_leaves_the_body_alone() {
    let law = FunctionFlank {
        compliance: Box::new(|_| split(1e-18, 2e-11)),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    for phase in [0.2, 0.8] {
        let load = bear(&law, phase, 4, 0.0, Foundation::Strips, 1000.0);
        close(load.stiffness, FACE_WIDTH / 2e-11, 1e-6);
    }
}

/// As a whole the body does not follow the teeth in their wedge: the load crowds towards the
/// edge.
#[test]
fn the_body_as_a_whole_does_not_tilt() {
    let force = default_force();
    let (tooth, foundation) = (0.6 / STIFFNESS, 0.4 / STIFFNESS);
    let law = FunctionFlank {
        compliance: Box::new(move |_| split(tooth, foundation)),
        ..FunctionFlank::constant(path(1.0), STIFFNESS)
    };
    let strips = bear(&law, 0.5, 8, MISALIGNMENT, Foundation::Strips, force);
    let length = (2.0 * force / (STIFFNESS * MISALIGNMENT)).sqrt();
    close(strips.stiffness, STIFFNESS * length, 1e-13);
    let body = bear(&law, 0.5, 8, MISALIGNMENT, Foundation::Body, force);
    let teeth = (2.0 * force / (MISALIGNMENT / tooth)).sqrt() / tooth;
    let stiffness = 1.0 / (1.0 / teeth + foundation / FACE_WIDTH);
    close(body.stiffness, stiffness, 1e-13);
    assert!(body.centre < strips.centre);
    // What that does to the stiffness is little.
    close(body.stiffness, strips.stiffness, 0.01);
}

/// A second pair behind a gap joins when the first has closed it.
#[test]
fn a_relieved_pair_joins_late() {
    let gap = 5e-6;
    let law = FunctionFlank {
        relief: Box::new(move |s| if s > 0.0 { gap } else { 0.0 }),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    let single = STIFFNESS * FACE_WIDTH;
    let closing = single * gap;
    let below = bear(&law, 0.2, 4, 0.0, Foundation::Strips, 0.9 * closing);
    close(below.stiffness, single, 1e-14);
    assert_eq!(below.share[1], 0.0);
    close(below.contact_fraction, 0.5, 1e-15);
    let above = bear(&law, 0.2, 4, 0.0, Foundation::Strips, 3.0 * closing);
    close(above.stiffness, 2.0 * single, 1e-14);
    close(above.deflection, 2.0 * gap, 1e-14);
    close(above.share[0], 2.0 / 3.0, 1e-14);
    close(above.share[1], 1.0 / 3.0, 1e-14);
}

#[test]
fn stiffness_under_misalignment_rises_with_the_load() {
    let law = FunctionFlank {
        relief: Box::new(|s| 2e-6 * (s / 5e-3).powi(2)),
        deviation: Box::new(|s, z| 3e-6 * (z / 0.01).powi(2) + 2e-4 * s),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    let pairs = pairs_at(&law, 0.3, face(16)).unwrap();
    let sharing = LoadSharing::new(&pairs, face(16), 4e-4, Foundation::Body).unwrap();
    let loads: Vec<SharedLoad> = (1..200)
        .map(|step| sharing.bear(100.0 * f64::from(step)))
        .collect();
    for pair in loads.windows(2) {
        assert!(pair[1].stiffness >= pair[0].stiffness * (1.0 - 1e-13));
        assert!(pair[1].contact_fraction >= pair[0].contact_fraction);
        assert!(pair[1].deflection > pair[0].deflection);
        // The tangent is the one of the deflection.
        let secant = 100.0 / (pair[1].deflection - pair[0].deflection);
        let [low, high] = [pair[0].stiffness, pair[1].stiffness];
        assert!(secant >= low * (1.0 - 1e-9) && secant <= high * (1.0 + 1e-9));
        assert!((pair[0].share.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
    assert!(loads[0].contact_fraction < 0.5 && loads[198].contact_fraction == 1.0);
}

#[test]
fn without_force_flanks_touch_where_least_is_missing() {
    let law = FunctionFlank {
        relief: Box::new(|_| 3e-6),
        ..FunctionFlank::constant(path(1.0), STIFFNESS)
    };
    let load = bear(&law, 0.5, 8, MISALIGNMENT, Foundation::Strips, 0.0);
    close(
        load.deflection,
        3e-6 - MISALIGNMENT * 0.5 * FACE_WIDTH,
        1e-14,
    );
    assert_eq!(load.share, [0.0; 3]);
}

#[test]
fn the_pattern_adds_up_to_the_load() {
    let law = FunctionFlank::constant(path(1.6), STIFFNESS);
    let pairs = pairs_at(&law, 0.1, face(20)).unwrap();
    let sharing = LoadSharing::new(&pairs, face(20), 5e-4, Foundation::Strips).unwrap();
    let pattern = sharing.pattern(1000.0);
    assert_eq!(pattern.len(), 2 * 20);
    let load: f64 = pattern.iter().map(|q| q * FACE_WIDTH / 20.0).sum();
    close(load, 1000.0, 1e-13);
    // A wedge: highest at the low end, falling in a straight line.
    let steps: Vec<f64> = pattern[..8].windows(2).map(|q| q[0] - q[1]).collect();
    for step in &steps {
        close(*step, STIFFNESS * 5e-4 * FACE_WIDTH / 20.0, 1e-9);
    }
    assert_eq!(pattern[19], 0.0);
}

/// Crowned flanks: `F = 4/3 k' C a³` on a contact of half length a under the gap C z².
#[test]
fn crowning_converges_with_the_square_of_the_slice() {
    let crown = 20e-6 / 0.01f64.powi(2);
    let law = FunctionFlank {
        deviation: Box::new(move |_, z| crown * z * z),
        ..FunctionFlank::constant(path(1.0), STIFFNESS)
    };
    let force = default_force();
    let half = (0.75 * force / (STIFFNESS * crown)).cbrt();
    assert!(half < 0.5 * FACE_WIDTH);
    let stiffness = 2.0 * half * STIFFNESS;
    let deflection = crown * half * half;
    let errors = |slices: usize| {
        let load = bear(&law, 0.5, slices, 0.0, Foundation::Strips, force);
        [
            load.stiffness / stiffness - 1.0,
            load.deflection / deflection - 1.0,
        ]
    };
    // Where the contact ends within a slice changes from count to count: worst of a few.
    let worst = |slices: usize| {
        let all = (slices..slices + 8).map(errors);
        all.fold([0.0_f64; 2], |m, e| {
            [m[0].max(e[0].abs()), m[1].max(e[1].abs())]
        })
    };
    let (coarse, fine) = (worst(16), worst(256));
    for quantity in 0..2 {
        let order = (coarse[quantity] / fine[quantity]).log2() / 4.0;
        assert!((1.7..2.3).contains(&order), "{quantity}: {order}");
    }
    let at_64 = worst(64);
    assert!(at_64[0] < 1e-3 && at_64[1] < 1e-3, "{at_64:?}");
}

#[test]
fn what_cannot_bear_is_refused() {
    let law = FunctionFlank::constant(path(1.0), STIFFNESS);
    let pair = ContactPair::new(&law, 0.0, face(2)).unwrap();
    let sharing = |pairs: &[ContactPair], face, misalignment| {
        LoadSharing::new(pairs, face, misalignment, Foundation::Strips).unwrap_err()
    };
    assert_eq!(sharing(&[], face(2), 0.0), SharingError::NoPair);
    let four = vec![pair.clone(); 4];
    let error = sharing(&four, face(2), 0.0);
    assert_eq!(error, SharingError::TooManyPairs { found: 4 });
    let pair = [pair];
    assert!(matches!(
        sharing(&pair, face(0), 0.0),
        SharingError::NoFace { slices: 0, .. }
    ));
    assert!(matches!(
        sharing(&pair, face(2), f64::NAN),
        SharingError::OutOfRange { name, .. } if name.starts_with("misalignment")
    ));
    for (tooth, foundation, relief, word) in [
        (0.0, 1e-11, 0.0, "teeth"),
        (f64::NAN, 1e-11, 0.0, "teeth"),
        (1e-11, -1e-11, 0.0, "bodies"),
        (1e-11, 1e-11, f64::INFINITY, "missing"),
    ] {
        let law = FunctionFlank {
            compliance: Box::new(move |_| split(tooth, foundation)),
            relief: Box::new(move |_| relief),
            ..FunctionFlank::constant(path(1.0), STIFFNESS)
        };
        let error = ContactPair::new(&law, 1e-3, face(2)).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
        assert!(error.to_string().contains("0.001 m"), "{error}");
    }
}

mod bisection {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::*;

    /// Pairs as (tooth, foundation, offset).
    type Pairs = Vec<(f64, f64, f64)>;

    /// Approach without misalignment at which the teeth have deflected by y.
    fn approach(pairs: &Pairs, y: f64) -> f64 {
        let yields = pairs.iter().map(|(c, f, o)| f * (y - o).max(0.0) / c);
        y + yields.sum::<f64>()
    }

    /// Tooth deflection at an approach, by bisection of the definition.
    fn deflection(pairs: &Pairs, u: f64) -> f64 {
        let (mut low, mut high) = (u.min(-1e-2) - 1e-2, u);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if approach(pairs, middle) > u {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// Force, moment, stiffness and the pairs' loads at approach x, integrated over the face
    /// between the places where a pair comes into contact.
    fn integrate(pairs: &Pairs, misalignment: f64, x: f64) -> (f64, f64, f64, Vec<f64>) {
        let half = 0.5 * FACE_WIDTH;
        let mut places = vec![-half, half];
        for (_, _, offset) in pairs {
            let place = (x - approach(pairs, *offset)) / misalignment;
            if place.abs() < half {
                places.push(place);
            }
        }
        places.sort_by(f64::total_cmp);
        let (mut moment, mut stiffness) = (0.0, 0.0);
        let mut loads = vec![0.0; pairs.len()];
        for ends in places.windows(2) {
            let length = ends[1] - ends[0];
            // Simpson: line loads are linear, moments quadratic.
            for (weight, z) in [
                (1.0 / 6.0, ends[0]),
                (4.0 / 6.0, 0.5 * (ends[0] + ends[1])),
                (1.0 / 6.0, ends[1]),
            ] {
                let y = deflection(pairs, x - misalignment * z);
                for ((c, _, o), load) in pairs.iter().zip(&mut loads) {
                    let q = (y - o).max(0.0) / c;
                    *load += weight * length * q;
                    moment += weight * length * q * z;
                }
            }
            let y = deflection(pairs, x - misalignment * 0.5 * (ends[0] + ends[1]));
            let touching = pairs.iter().filter(|(_, _, o)| y > *o);
            let (mut teeth, mut bodies) = (0.0, 0.0);
            for (c, f, _) in touching {
                teeth += 1.0 / c;
                bodies += f / c;
            }
            stiffness += length * teeth / (1.0 + bodies);
        }
        (loads.iter().sum(), moment, stiffness, loads)
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 200,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn finds_the_same_load(
            pairs in vec((1e-11..1e-10f64, 0.0..1e-10f64, 0.0..2e-5f64), 1..=3),
            misalignment in prop_oneof![1e-6..2e-3f64, -2e-3..-1e-6f64],
            force in 10.0..5000.0f64,
            slices in 1..20usize,
        ) {
            let law_pairs = pairs.clone();
            let path = path(pairs.len() as f64);
            let index = move |s: f64| {
                (((s - path.start) / path.base_pitch).floor() as usize).min(law_pairs.len() - 1)
            };
            let (of_compliance, of_relief) = (pairs.clone(), pairs.clone());
            let place = index.clone();
            let law = FunctionFlank {
                compliance: Box::new(move |s| {
                    let (c, f, _) = of_compliance[place(s)];
                    split(c, f)
                }),
                relief: Box::new(move |s| of_relief[index(s)].2),
                ..FunctionFlank::constant(path, STIFFNESS)
            };
            let found = bear(&law, 0.5, slices, misalignment, Foundation::Strips, force);

            let (mut low, mut high) = (-1e-3, 1e-1);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if integrate(&pairs, misalignment, middle).0 > force {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            let (total, moment, stiffness, loads) = integrate(&pairs, misalignment, low);
            // Approaches are differences of gaps of this size.
            let size = misalignment.abs() * FACE_WIDTH + 1e-4;
            prop_assert!((found.deflection - low).abs() < 1e-13 * size, "{found:?}, {low}");
            for (found, exact) in found.share.iter().zip(&loads) {
                prop_assert!((found - exact / total).abs() < 1e-10);
            }
            prop_assert!((found.centre - moment / total).abs() < 1e-10 * FACE_WIDTH);
            prop_assert!((found.stiffness / stiffness - 1.0).abs() < 1e-9);
        }
    }
}
