//! Load sharing compared with closed forms and with bisection of its definition.

#![allow(clippy::unwrap_used, dead_code)]

use crate::flank;
use flank::{FACE_WIDTH, FunctionFlank, MISALIGNMENT, STIFFNESS, default_force, path, split};
use gearatlas::gear::{ContactPair, Face, LoadSharing, SharedLoad, SharingError, pairs_at};

fn face(slices: usize) -> Face {
    Face {
        width: FACE_WIDTH,
        slices,
    }
}

/// A load on the pairs of a law at a mesh phase.
fn distribute(
    law: &FunctionFlank,
    phase: f64,
    slices: usize,
    misalignment: f64,
    force: f64,
) -> SharedLoad {
    let pairs = pairs_at(law, phase, face(slices)).unwrap();
    let sharing = LoadSharing::new(&pairs, face(slices), misalignment).unwrap();
    sharing.distribute(force)
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
            let load = distribute(&law, 0.5, slices, misalignment, force);
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

/// A fully loaded misaligned face has the stiffness of an aligned one; the centroid follows from the covariance of load
/// and position.
#[test]
fn a_slightly_misaligned_flank_is_fully_loaded() {
    let force = default_force();
    let law = FunctionFlank::constant(path(1.0), STIFFNESS);
    let load = distribute(&law, 0.5, 3, 1e-4, force);
    close(load.stiffness, STIFFNESS * FACE_WIDTH, 1e-14);
    assert_eq!(load.contact_fraction, 1.0);
    let centre = -1e-4 * STIFFNESS * FACE_WIDTH.powi(3) / 12.0 / force;
    close(load.centre, centre, 1e-12);
}

/// Two aligned pairs share the load by the compliance matrix `[[a, c], [c, d]]`.
#[test]
fn aligned_pairs_share_by_their_compliance_matrix() {
    let force = default_force();
    let (tooth, foundation) = (4e-11, 2e-11);
    let stretch = |s: f64| 1.0 + 40.0 * s.abs();
    for part in [0.0, 0.3, 0.9] {
        let law = FunctionFlank {
            compliance: Box::new(move |s| split(tooth * stretch(s), foundation * stretch(s))),
            coupling: Box::new(move |s, ahead| part * foundation * stretch(s) / ahead as f64),
            ..FunctionFlank::constant(path(1.6), STIFFNESS)
        };
        let places = [0.2, 1.2].map(|p| law.path.start + p * law.path.base_pitch);
        let [a, d] = places.map(|s| (tooth + foundation) * stretch(s));
        let c = part * foundation * stretch(places[0]);
        let stiffness = FACE_WIDTH * (a + d - 2.0 * c) / (a * d - c * c);
        let load = distribute(&law, 0.2, 16, 0.0, force);
        close(load.stiffness, stiffness, 1e-13);
        close(load.deflection, force / stiffness, 1e-13);
        close(load.share[0], (d - c) / (a + d - 2.0 * c), 1e-13);
        close(load.share[1], (a - c) / (a + d - 2.0 * c), 1e-13);
        assert_eq!(load.share[2], 0.0);
        assert_eq!(load.contact_fraction, 1.0);
        assert!(load.centre.abs() < 1e-15 * FACE_WIDTH, "{}", load.centre);
    }
}

/// Pairs of rigid teeth on a fully shared body are as stiff as a single pair.
#[test]
fn a_body_that_is_wholly_shared_counts_once() {
    let law = FunctionFlank {
        compliance: Box::new(|_| split(1e-16, 2e-11)),
        coupling: Box::new(|_, _| 2e-11),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    for phase in [0.2, 0.8] {
        let load = distribute(&law, phase, 4, 0.0, 1000.0);
        close(load.stiffness, FACE_WIDTH / 2e-11, 1e-4);
    }
}

/// No body couples pairs more strongly than its compliance under one of them.
#[test]
fn pairs_that_push_each_other_out_are_refused() {
    let law = FunctionFlank {
        compliance: Box::new(|s| split(if s > 0.0 { 5e-11 } else { 1e-12 }, 1e-11)),
        coupling: Box::new(|_, _| 2e-11),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    let pairs = pairs_at(&law, 0.2, face(2)).unwrap();
    let error = LoadSharing::new(&pairs, face(2), 0.0).unwrap_err();
    assert!(matches!(error, SharingError::Coupling { .. }), "{error}");
}

/// A second pair behind a gap comes into contact when the first has closed it.
#[test]
fn a_relieved_pair_joins_late() {
    let gap = 5e-6;
    let law = FunctionFlank {
        relief: Box::new(move |s| if s > 0.0 { gap } else { 0.0 }),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    let single = STIFFNESS * FACE_WIDTH;
    let closing = single * gap;
    let below = distribute(&law, 0.2, 4, 0.0, 0.9 * closing);
    close(below.stiffness, single, 1e-14);
    assert_eq!(below.share[1], 0.0);
    close(below.contact_fraction, 0.5, 1e-15);
    let above = distribute(&law, 0.2, 4, 0.0, 3.0 * closing);
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
    let sharing = LoadSharing::new(&pairs, face(16), 4e-4).unwrap();
    let loads: Vec<SharedLoad> = (1..200)
        .map(|step| sharing.distribute(100.0 * f64::from(step)))
        .collect();
    for pair in loads.windows(2) {
        assert!(pair[1].stiffness >= pair[0].stiffness * (1.0 - 1e-13));
        assert!(pair[1].contact_fraction >= pair[0].contact_fraction);
        assert!(pair[1].deflection > pair[0].deflection);
        // The tangent stiffness is the derivative at the deflection.
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
    let load = distribute(&law, 0.5, 8, MISALIGNMENT, 0.0);
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
    let sharing = LoadSharing::new(&pairs, face(20), 5e-4).unwrap();
    let pattern = sharing.pattern(1000.0);
    assert_eq!(pattern.len(), 2 * 20);
    let load: f64 = pattern.iter().map(|q| q * FACE_WIDTH / 20.0).sum();
    close(load, 1000.0, 1e-13);
    // The load of a misaligned face is largest at the low end and decreases linearly.
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
        let load = distribute(&law, 0.5, slices, 0.0, force);
        [
            load.stiffness / stiffness - 1.0,
            load.deflection / deflection - 1.0,
        ]
    };
    // The end of contact within a slice changes from count to count: take the worst of a few.
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
        LoadSharing::new(pairs, face, misalignment).unwrap_err()
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

/// A contact that stiffens, `a = C w^0.9` (as Palmgren's): the tangent at the load on each slice.
#[test]
fn a_stiffening_contact_is_met_where_the_load_is() {
    let force = default_force();
    let scale = 1e-10;
    let law = FunctionFlank {
        contact: Some(Box::new(move |w| {
            [scale * w.powf(0.9), 0.9 * scale * w.powf(-0.1)]
        })),
        ..FunctionFlank::constant(path(1.6), STIFFNESS)
    };
    // Without its contact a constant flank keeps four fifths of its compliance.
    let teeth = 0.8 / STIFFNESS;
    let under = |phase: f64, misalignment: f64| {
        LoadSharing::under(&law, phase, face(4), misalignment, force)
    };
    for (phase, pairs) in [(0.8, 1.0), (0.2, 2.0)] {
        let load = under(phase, 0.0).unwrap().distribute(force);
        let w = force / FACE_WIDTH / pairs;
        close(load.deflection, teeth * w + scale * w.powf(0.9), 1e-12);
        let tangent = teeth + 0.9 * scale * w.powf(-0.1);
        close(load.stiffness, pairs * FACE_WIDTH / tangent, 1e-10);
    }
    // A linear law converges at once.
    let linear = FunctionFlank::constant(path(1.6), STIFFNESS);
    let settled = LoadSharing::under(&linear, 0.2, face(4), 2e-4, force).unwrap();
    let direct = distribute(&linear, 0.2, 4, 2e-4, force);
    close(
        settled.distribute(force).deflection,
        direct.deflection,
        1e-14,
    );
    // On a partly loaded face, the contact uses the mean line load of the loaded part.
    let wedge = under(0.8, MISALIGNMENT).unwrap().distribute(force);
    let length = wedge.contact_fraction * FACE_WIDTH;
    let w = force / length;
    let tangent = teeth + 0.9 * scale * w.powf(-0.1);
    close(wedge.stiffness, length / tangent, 1e-10);
    close(length, (2.0 * force * tangent / MISALIGNMENT).sqrt(), 1e-10);
}

#[test]
fn a_contact_that_does_not_settle_is_refused() {
    let under = |contact: fn(f64) -> [f64; 2]| {
        let law = FunctionFlank {
            contact: Some(Box::new(contact)),
            relief: Box::new(|s| if s > 0.0 { 1e-6 } else { 0.0 }),
            ..FunctionFlank::constant(path(1.6), STIFFNESS)
        };
        LoadSharing::under(&law, 0.2, face(2), 0.0, 1e3).unwrap_err()
    };
    let error = under(|_| [f64::NAN, 1e-11]);
    assert!(matches!(error, SharingError::OutOfRange { .. }), "{error}");
    // The contact becomes softer with more load by a jump, so that the iteration passes the load between two pairs.
    let error = under(|w| {
        let slope = if w > 2.5e4 { 1e-9 } else { 1e-11 };
        [slope * w, slope]
    });
    assert!(matches!(error, SharingError::Unsettled { .. }), "{error}");
}

mod bisection {
    use super::*;
    use faer::linalg::solvers::Solve;
    use faer::{Col, Mat};
    use proptest::collection::vec;
    use proptest::prelude::*;

    /// Compliances [m²/N] and gaps [m] of pairs at one place of the face.
    struct Place {
        compliance: Vec<Vec<f64>>,
        gap: Vec<f64>,
    }

    impl Place {
        /// Line loads and their derivatives at an approach u: the only set of pairs, of all possible ones, that press
        /// while all others are clear.
        fn loads(&self, u: f64) -> (Vec<f64>, Vec<f64>) {
            let count = self.gap.len();
            for set in 0..1u32 << count {
                let inside: Vec<usize> = (0..count).filter(|p| set >> p & 1 == 1).collect();
                let (mut loads, mut gains) = (vec![0.0; count], vec![0.0; count]);
                let load = self.solve(&inside, &|p| u - self.gap[p]);
                let gain = self.solve(&inside, &|_| 1.0);
                for (n, &pair) in inside.iter().enumerate() {
                    loads[pair] = load[n];
                    gains[pair] = gain[n];
                }
                let fits = (0..count).all(|p| {
                    let row = self.compliance[p].iter().zip(&loads);
                    let pushed: f64 = row.map(|(c, q)| c * q).sum();
                    // If a pair just touches, rounding may exclude both cases.
                    if inside.contains(&p) {
                        loads[p] >= -1e-7
                    } else {
                        u - self.gap[p] <= pushed + 1e-17
                    }
                });
                if fits {
                    return (loads, gains);
                }
            }
            panic!("no set of pairs bears the approach {u}");
        }

        /// Solution among some pairs.
        fn solve(&self, pairs: &[usize], rhs: &dyn Fn(usize) -> f64) -> Vec<f64> {
            let n = pairs.len();
            let compliance = Mat::from_fn(n, n, |i, j| self.compliance[pairs[i]][pairs[j]]);
            let solution = (compliance.partial_piv_lu()).solve(Col::from_fn(n, |i| rhs(pairs[i])));
            solution.iter().copied().collect()
        }

        /// Approach at which a pair comes into contact, by bisection.
        fn joins(&self, pair: usize) -> f64 {
            let (mut low, mut high) = (-1e-3, 1e-2);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if self.loads(middle).0[pair] > 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            high
        }
    }

    /// Moment, stiffness and the pairs' loads at approach x, integrated over the face between the positions where pairs
    /// come into contact.
    fn integrate(place: &Place, joins: &[f64], misalignment: f64, x: f64) -> (f64, f64, Vec<f64>) {
        let half = 0.5 * FACE_WIDTH;
        let mut ends = vec![-half, half];
        let inside = joins.iter().map(|u| (x - u) / misalignment);
        ends.extend(inside.filter(|z| z.abs() < half));
        ends.sort_by(f64::total_cmp);
        let (mut moment, mut stiffness) = (0.0, 0.0);
        let mut loads = vec![0.0; joins.len()];
        for ends in ends.windows(2) {
            let (length, middle) = (ends[1] - ends[0], 0.5 * (ends[0] + ends[1]));
            // Simpson: line loads are linear, moments quadratic.
            for (weight, z) in [(1.0, ends[0]), (4.0, middle), (1.0, ends[1])] {
                let (line_loads, _) = place.loads(x - misalignment * z);
                for (q, load) in line_loads.iter().zip(&mut loads) {
                    *load += weight / 6.0 * length * q;
                    moment += weight / 6.0 * length * q * z;
                }
            }
            let (_, gains) = place.loads(x - misalignment * middle);
            stiffness += length * gains.iter().sum::<f64>();
        }
        (moment, stiffness, loads)
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
            part in 0.0..0.8f64,
            misalignment in prop_oneof![1e-6..2e-3f64, -2e-3..-1e-6f64],
            force in 10.0..5000.0f64,
            slices in 1..20usize,
        ) {
            let path = path(pairs.len() as f64);
            let count = pairs.len();
            let index = move |s: f64| {
                (((s - path.start) / path.base_pitch).floor() as usize).min(count - 1)
            };
            // Neighbouring pairs share a part of the compliance of the stiffer body. Pairs further apart share a part
            // of this.
            let bodies: Vec<f64> = pairs.iter().map(|(_, f, _)| *f).collect();
            let coupling = move |i: usize, ahead: usize| {
                part.powi(ahead as i32) * bodies[i].min(bodies[i + ahead])
            };
            let compliance = (0..count)
                .map(|i| {
                    let entry = |j: usize| match i.abs_diff(j) {
                        0 => pairs[i].0 + pairs[i].1,
                        apart => coupling(i.min(j), apart),
                    };
                    (0..count).map(entry).collect()
                })
                .collect();
            let gap = pairs.iter().map(|(_, _, gap)| *gap).collect();
            let place = Place { compliance, gap };
            let (of_compliance, of_relief) = (pairs.clone(), pairs.clone());
            let law = FunctionFlank {
                compliance: Box::new(move |s| {
                    let (c, f, _) = of_compliance[index(s)];
                    split(c, f)
                }),
                coupling: Box::new(move |s, ahead| coupling(index(s), ahead)),
                relief: Box::new(move |s| of_relief[index(s)].2),
                ..FunctionFlank::constant(path, STIFFNESS)
            };
            let found = distribute(&law, 0.5, slices, misalignment, force);

            let joins: Vec<f64> = (0..count).map(|pair| place.joins(pair)).collect();
            let (mut low, mut high) = (-1e-3, 1e-1);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let loads = integrate(&place, &joins, misalignment, middle).2;
                if loads.iter().sum::<f64>() > force {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            let (moment, stiffness, loads) = integrate(&place, &joins, misalignment, low);
            let total: f64 = loads.iter().sum();
            // Approaches are differences of gaps of this size.
            let size = misalignment.abs() * FACE_WIDTH + 1e-4;
            prop_assert!((found.deflection - low).abs() < 1e-12 * size, "{found:?}, {low}");
            for (found, exact) in found.share.iter().zip(&loads) {
                prop_assert!((found - exact / total).abs() < 1e-9);
            }
            prop_assert!((found.centre - moment / total).abs() < 1e-9 * FACE_WIDTH);
            prop_assert!((found.stiffness / stiffness - 1.0).abs() < 1e-8);
        }
    }
}
