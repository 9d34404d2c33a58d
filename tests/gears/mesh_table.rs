//! Mesh tables compared with their load sharing and with closed forms.

#![allow(clippy::unwrap_used, dead_code)]

use crate::{fixtures, flank};
use flank::{FACE_WIDTH, FunctionFlank, MISALIGNMENT, STIFFNESS, default_force, path, split};
use gearatlas::gear::{
    Contact, Face, FaceLaw, Flanks, GearPair, LoadSharing, MeshTable, MeshTableCycle,
    MeshTableError, MeshTableInputs, NODES, Relief, SecantContact, SharingError, StiffnessLaw,
    ToothForm, pairs_at,
};
use std::f64::consts::{PI, TAU};
use std::sync::Mutex;

fn inputs() -> MeshTableInputs {
    MeshTableInputs {
        stiffness: StiffnessLaw::Tangent,
        face_width: FACE_WIDTH,
        base_radius: 0.04 * 20f64.to_radians().cos(),
        misalignment: vec![0.0],
        torque: vec![50.0],
        longest_piece: 1.0 / 12.0,
        tolerance: 1e-9,
        slices: 4,
        face: FaceLaw::Coupled,
        contact: Contact::Linear,
        pattern: false,
    }
}

fn build(law: &FunctionFlank, inputs: &MeshTableInputs) -> MeshTable {
    MeshTable::build(law, inputs, &|_, _| {}).unwrap()
}

/// Teeth with more compliance away from the pitch point, and a body below them.
fn curved(contact_ratio: f64) -> FunctionFlank {
    let path = path(contact_ratio);
    FunctionFlank {
        compliance: Box::new(move |s| {
            let u = s / path.base_pitch;
            split(
                4e-11 * (1.0 + u * u) / (1.0 - 0.2 * u),
                2e-11 * (1.0 + 0.5 * u.sin()),
            )
        }),
        ..FunctionFlank::constant(path, STIFFNESS)
    }
}

fn close(found: f64, exact: f64, tolerance: f64) {
    assert!(
        (found - exact).abs() <= tolerance * exact.abs(),
        "{found} against {exact}"
    );
}

#[test]
fn pieces_end_where_something_changes() {
    let law = FunctionFlank {
        kinks: vec![0.45 * 11.8e-3],
        ..curved(1.6)
    };
    let table = build(&law, &inputs());
    let has = |phase: f64| table.breaks.iter().any(|b| (b - phase).abs() < 1e-12);
    // A pair leaves at 0.6, a pair passes the pitch point at 0.3, and a pair passes the kink at 0.75.
    assert!(has(0.6) && has(0.3) && has(0.75));
    assert_eq!(table.breaks[0], 0.0);
    assert_eq!(*table.breaks.last().unwrap(), 1.0);
    for ends in table.breaks.windows(2) {
        assert!(ends[1] > ends[0] && ends[1] - ends[0] <= 1.0 / 12.0 + 1e-12);
    }
    // The parts of 0.3, 0.3, 0.15 and 0.25 are divided into pieces of at most a twelfth.
    assert_eq!(table.breaks.len() - 1, 4 + 4 + 2 + 3);
    // A contact ratio that is an integer within rounding has no transition.
    let whole = build(&curved(2.0 + 1e-15), &inputs());
    assert!(whole.breaks.iter().all(|b| *b == 0.0 || *b > 1e-3));
}

#[test]
fn two_levels_have_closed_means_jumps_and_harmonics() {
    let law = FunctionFlank::constant(path(1.6), STIFFNESS);
    let table = build(&law, &inputs());
    let cycle = table.cycle(0, 0);
    let single = STIFFNESS * FACE_WIDTH;
    close(cycle.mean_stiffness(), 1.6 * single, 1e-13);
    let means = cycle.segment_means(7);
    assert_eq!(means.len(), 7);
    // The two-pair part has a length of 0.6 · 7 = 4.2 segments.
    for (segment, mean) in means.iter().enumerate() {
        let double = (4.2 - segment as f64).clamp(0.0, 1.0);
        close(mean.stiffness, (1.0 + double) * single, 1e-12);
        assert!(mean.tangent_error.abs() < 1e-18 && mean.centre.abs() < 1e-15);
    }
    let jump = cycle.force / (2.0 * single);
    close(cycle.peak_to_peak(), jump, 1e-12);
    // The error is a pulse of this height over the single-pair part, 0.6 to 1. High harmonics have several periods
    // within a piece.
    for (harmonic, amplitude, phase) in cycle.harmonics(&cycle.transmission_error, 900) {
        let m = f64::from(harmonic);
        let exact = 2.0 * jump * (PI * m * 0.4).sin() / (PI * m);
        assert!((amplitude - exact.abs()).abs() < 1e-13 * jump, "{harmonic}");
        if amplitude > 1e-10 * jump {
            let turn = phase + TAU * m * 0.8 - if exact < 0.0 { PI } else { 0.0 };
            assert!((turn - TAU * (turn / TAU).round()).abs() < 1e-9, "{turn}");
        }
    }
}

#[test]
fn friction_reverses_at_the_pitch_point() {
    let law = FunctionFlank::constant(path(1.6), STIFFNESS);
    let cycle = build(&law, &inputs()).cycle(0, 0);
    let pitch = law.path.base_pitch;
    for (phase, positions) in [
        (0.1, [Some(-0.2), Some(0.8)]),
        (0.5, [Some(0.2), Some(1.2)]),
        (0.7, [Some(0.4), None]),
    ] {
        let positions: Vec<f64> = positions.into_iter().flatten().collect();
        let share = 1.0 / positions.len() as f64;
        let direction: f64 = positions.iter().map(|s| -s.signum() * share).sum();
        let lever: f64 = positions.iter().map(|s| -s.abs() * pitch * share).sum();
        let found = cycle.value(&cycle.friction, phase);
        assert!((found - direction).abs() < 1e-13, "{phase}: {found}");
        close(cycle.value(&cycle.friction_lever, phase), lever, 1e-12);
    }
}

/// All points between the nodes compared with load sharing at these points.
#[test]
fn polynomials_follow_the_law_between_their_nodes() {
    let law = curved(1.79);
    let inputs = MeshTableInputs {
        misalignment: vec![-2e-4, MISALIGNMENT],
        torque: vec![5.0, 50.0],
        ..inputs()
    };
    let table = build(&law, &inputs);
    let face = Face {
        width: FACE_WIDTH,
        slices: 4,
    };
    for (i, &misalignment) in inputs.misalignment.iter().enumerate() {
        for (j, &torque) in inputs.torque.iter().enumerate() {
            let cycle = table.cycle(i, j);
            assert_eq!(cycle, table.interpolate(misalignment, torque).unwrap());
            for step in 0..97 {
                let phase = (f64::from(step) + 0.37) / 97.0;
                let pairs = pairs_at(&law, phase, face).unwrap();
                let sharing = LoadSharing::new(&pairs, face, misalignment).unwrap();
                let load = sharing.distribute(cycle.force);
                close(cycle.value(&cycle.stiffness, phase), load.stiffness, 1e-10);
                close(cycle.value(&cycle.centre, phase), load.centre, 1e-9);
                close(
                    cycle.value(&cycle.transmission_error, phase),
                    load.deflection,
                    1e-10,
                );
                close(
                    cycle.value(&cycle.contact_fraction, phase),
                    load.contact_fraction,
                    1e-10,
                );
                for pair in 0..3 {
                    let share = cycle.value(&cycle.share[pair], phase);
                    assert!((share - load.share[pair]).abs() < 1e-10);
                }
            }
        }
    }
}

#[test]
fn shares_add_up_in_the_table() {
    let table = build(&curved(2.3), &inputs());
    let mut most = 0;
    for share in table.share.chunks(3) {
        assert!((share.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        most = most.max(share.iter().filter(|p| **p > 0.0).count());
    }
    assert_eq!(most, 3);
    let cells: usize = table.shape().iter().product();
    assert_eq!(table.stiffness.len(), cells);
    assert_eq!(table.share.len(), 3 * cells);
}

/// Shorter pieces change the mean only by round-off: there is no jump inside a piece.
#[test]
fn means_do_not_depend_on_the_pieces() {
    let mean = |longest_piece: f64| {
        let inputs = MeshTableInputs {
            longest_piece,
            ..inputs()
        };
        let cycle = build(&curved(1.6), &inputs).cycle(0, 0);
        [
            cycle.mean_stiffness(),
            cycle.mean(&cycle.friction_lever),
            cycle.peak_to_peak(),
            cycle.harmonics(&cycle.transmission_error, 3)[2].1,
        ]
    };
    let fine = mean(1.0 / 96.0);
    for (coarse, fine) in mean(1.0 / 12.0).iter().zip(fine) {
        close(*coarse, fine, 1e-11);
    }
    // Longer pieces have larger errors, which decrease with the eighth order.
    let errors = [0.3, 0.15].map(|longest| (mean(longest)[0] / fine[0] - 1.0).abs());
    assert!(errors[1] < 1e-12 && errors[0] < 1e-9, "{errors:?}");
}

#[test]
fn extremes_inside_a_piece_are_seen() {
    // x = F c has its minimum where u + 0.1 = 0, inside the single-pair part.
    let path = path(1.0);
    let law = FunctionFlank {
        compliance: Box::new(move |s| {
            let u = s / path.base_pitch;
            split(4e-11 * (1.0 + (u - 0.13).powi(2)), 0.0)
        }),
        ..FunctionFlank::constant(path, STIFFNESS)
    };
    let cycle = build(&law, &inputs()).cycle(0, 0);
    let highest = 0.57f64.powi(2);
    let exact = cycle.force * 4e-11 * highest / FACE_WIDTH;
    close(cycle.peak_to_peak(), exact, 1e-12);
}

#[test]
fn the_tangent_error_puts_the_linear_law_on_the_load() {
    let law = curved(1.6);
    let inputs = MeshTableInputs {
        misalignment: vec![MISALIGNMENT],
        torque: vec![30.0],
        ..inputs()
    };
    let cycle = build(&law, &inputs).cycle(0, 0);
    let error = cycle.tangent_error();
    for (piece, table_piece) in cycle.pieces().iter().enumerate() {
        let middle = 0.5 * (table_piece.start + table_piece.end);
        let x = cycle.value(&cycle.transmission_error, middle);
        let k = cycle.value(&cycle.stiffness, middle);
        close(k * (x - cycle.value(&error, middle)), cycle.force, 1e-9);
        let mean = cycle.stiffness[piece]
            .iter()
            .fold(0.0_f64, |m, k| m.max(*k));
        assert!(table_piece.stiffness[0] <= mean);
        close(
            table_piece.tangent_error[0],
            cycle.segment_mean_of(&error, [table_piece.start, table_piece.end]),
            1e-11,
        );
    }
}

trait SegmentMean {
    fn segment_mean_of(&self, values: &[[f64; NODES]], ends: [f64; 2]) -> f64;
}

impl SegmentMean for MeshTableCycle {
    /// Mean over a segment by Simpson's rule on many points.
    fn segment_mean_of(&self, values: &[[f64; NODES]], [from, to]: [f64; 2]) -> f64 {
        let steps = 400;
        let mut sum = 0.0;
        for step in 0..steps {
            for (weight, at) in [(1.0, 0.0), (4.0, 0.5), (1.0, 1.0)] {
                // Stay left of the break, whose value belongs to the next piece.
                let part = ((f64::from(step) + at) / f64::from(steps)).min(1.0 - 1e-13);
                sum += weight / 6.0 * self.value(values, from + (to - from) * part);
            }
        }
        sum / f64::from(steps)
    }
}

/// `k ∝ √(torque/ε)` on a partly loaded face: the documented errors between values.
#[test]
fn interpolation_keeps_to_its_documented_error() {
    let law = FunctionFlank::constant(path(1.0), STIFFNESS);
    let inputs = MeshTableInputs {
        misalignment: vec![1e-3, 2e-3],
        torque: vec![20.0, 40.0],
        ..inputs()
    };
    let table = build(&law, &inputs);
    let exact = |misalignment: f64, torque: f64| {
        let force = torque / table.base_radius;
        STIFFNESS * (2.0 * force / (STIFFNESS * misalignment)).sqrt()
    };
    let (mut torque_worst, mut misalignment_worst) = (0.0_f64, 0.0_f64);
    for step in 0..=50 {
        let part = f64::from(step) / 50.0;
        let torque = 20.0 + 20.0 * part;
        let found = table.interpolate(1e-3, torque).unwrap().mean_stiffness();
        torque_worst = torque_worst.max(1.0 - found / exact(1e-3, torque));
        let misalignment = 1e-3 + 1e-3 * part;
        let found = table
            .interpolate(misalignment, 20.0)
            .unwrap()
            .mean_stiffness();
        misalignment_worst = misalignment_worst.max(found / exact(misalignment, 20.0) - 1.0);
    }
    let r = 2f64;
    let documented = 1.0 - 2.0 * r.powf(0.25) / (1.0 + r.sqrt());
    assert!((0.9..1.001).contains(&(torque_worst / documented)));
    assert!(misalignment_worst > documented && misalignment_worst < 3.1 * documented);
}

#[test]
fn values_beyond_the_table_are_refused() {
    let table = build(&curved(1.6), &inputs());
    assert!(table.interpolate(0.0, 50.0).is_ok());
    for (misalignment, torque, axis) in [
        (1e-4, 50.0, "misalignment"),
        (0.0, 51.0, "torque"),
        (0.0, f64::NAN, "torque"),
    ] {
        let error = table.interpolate(misalignment, torque).unwrap_err();
        assert!(
            matches!(&error, MeshTableError::Outside { axis: found, .. } if *found == axis),
            "{error}"
        );
    }
}

#[test]
fn bad_inputs_are_refused() {
    let law = curved(1.6);
    let refused = |change: &dyn Fn(&mut MeshTableInputs)| {
        let mut inputs = inputs();
        change(&mut inputs);
        MeshTable::build(&law, &inputs, &|_, _| {}).unwrap_err()
    };
    for error in [
        refused(&|i| i.torque.clear()),
        refused(&|i| i.torque = vec![2.0, 1.0]),
        refused(&|i| i.misalignment = vec![f64::NAN]),
    ] {
        assert!(matches!(error, MeshTableError::Axis { .. }), "{error}");
    }
    for error in [
        refused(&|i| i.torque = vec![0.0]),
        refused(&|i| i.base_radius = 0.0),
        refused(&|i| i.longest_piece = 0.0),
    ] {
        assert!(
            matches!(error, MeshTableError::OutOfRange { .. }),
            "{error}"
        );
    }
    let face = refused(&|i| i.slices = 0);
    assert!(
        matches!(
            face,
            MeshTableError::Sharing {
                source: SharingError::NoFace { .. },
                ..
            }
        ),
        "{face}"
    );
    let short = MeshTable::build(&curved(0.9), &inputs(), &|_, _| {}).unwrap_err();
    assert!(matches!(short, MeshTableError::Path { .. }), "{short}");
    let many = MeshTable::build(&curved(3.2), &inputs(), &|_, _| {}).unwrap_err();
    assert!(many.to_string().contains("4 pairs"), "{many}");
}

#[test]
fn the_bits_do_not_depend_on_the_threads() {
    let law = curved(1.6);
    let inputs = MeshTableInputs {
        misalignment: vec![-3e-4, 0.0, 5e-4],
        torque: vec![5.0, 20.0, 50.0],
        pattern: true,
        ..inputs()
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let seen = Mutex::new(Vec::new());
        let table = pool.install(|| {
            MeshTable::build(&law, &inputs, &|done, all| {
                seen.lock().unwrap().push((done, all));
            })
        });
        let mut seen = seen.into_inner().unwrap();
        seen.sort_unstable();
        (table.unwrap(), seen)
    };
    let (one, seen) = on(1);
    assert_eq!(one, on(3).0);
    let phases = (one.breaks.len() - 1) * NODES;
    let all = seen.len();
    assert_eq!(seen, (1..=all).map(|d| (d, all)).collect::<Vec<_>>());
    assert!(all > 8 && all < one.breaks.len());
    // The pattern is the load, slice by slice.
    assert_eq!(one.pattern.len(), 9 * phases * 4);
    for (row, torque) in one
        .pattern
        .chunks(phases * 4)
        .zip(inputs.torque.iter().cycle())
    {
        for phase in row.chunks(4) {
            let load = phase.iter().sum::<f64>() * FACE_WIDTH / 4.0;
            close(load, torque / inputs.base_radius, 1e-12);
        }
    }
}

/// Flanks of one stiffness, with linear relief by `amount` at both ends of the path over `length` base pitches.
fn relieved(contact_ratio: f64, amount: f64, length: f64) -> FunctionFlank {
    let path = path(contact_ratio);
    let span = length * path.base_pitch;
    FunctionFlank {
        relief: Box::new(move |s| {
            let part = |distance: f64| amount * (1.0 - distance / span).clamp(0.0, 1.0);
            part(s - path.start) + part(path.end - s)
        }),
        kinks: vec![path.start + span, path.end - span],
        ..FunctionFlank::constant(path, STIFFNESS)
    }
}

/// The largest difference of a cycle from load sharing at points other than the nodes. Shares outside 0 to 1 and
/// stiffness above that of the law count as errors.
fn off_its_law(law: &FunctionFlank, inputs: &MeshTableInputs, places: u32) -> f64 {
    let cycle = build(law, inputs).cycle(0, 0);
    let face = Face {
        width: FACE_WIDTH,
        slices: inputs.slices,
    };
    let error = cycle.tangent_error();
    let mut worst = 0.0f64;
    for place in 0..places {
        let phase = (f64::from(place) + 0.37) / f64::from(places);
        let sharing = match inputs.contact {
            Contact::Linear => {
                let pairs = pairs_at(law, phase, face).unwrap();
                LoadSharing::new(&pairs, face, inputs.misalignment[0]).unwrap()
            }
            Contact::Secant => {
                let law = SecantContact {
                    law,
                    line_load: cycle.force / FACE_WIDTH,
                };
                let pairs = pairs_at(&law, phase, face).unwrap();
                LoadSharing::new(&pairs, face, inputs.misalignment[0]).unwrap()
            }
            Contact::LoadDependent => {
                LoadSharing::under(law, phase, face, inputs.misalignment[0], cycle.force).unwrap()
            }
        };
        let load = sharing.distribute(cycle.force);
        let deflection = cycle.force / load.stiffness;
        let off = |values: &[[f64; NODES]], exact: f64, scale: f64| {
            (cycle.value(values, phase) - exact).abs() / scale
        };
        for error in [
            off(&cycle.stiffness, load.stiffness, load.stiffness),
            off(&cycle.transmission_error, load.deflection, deflection),
            off(&error, load.deflection - deflection, deflection),
            off(&cycle.centre, load.centre, FACE_WIDTH),
            off(&cycle.contact_fraction, load.contact_fraction, 1.0),
            off(&cycle.share[0], load.share[0], 1.0),
            off(&cycle.share[1], load.share[1], 1.0),
        ] {
            worst = worst.max(error);
        }
    }
    worst
}

/// A pair comes into contact where the approach under the load of the others equals its gap.
#[test]
fn a_relieved_pair_takes_up_load_at_a_break() {
    // At most one of two pairs is on its relief at a time.
    let (amount, length) = (10e-6, 0.3);
    let law = relieved(1.6, amount, length);
    let single = STIFFNESS * FACE_WIDTH;
    for torque in [5.0, 20.0, 50.0] {
        let inputs = MeshTableInputs {
            torque: vec![torque],
            ..inputs()
        };
        let cycle = build(&law, &inputs).cycle(0, 0);
        // The remaining relief where the pair comes into contact, as a fraction of the whole.
        let left = cycle.force / single / amount;
        assert!(left < 1.0);
        let coming = length * (1.0 - left);
        let going = 0.6 - coming;
        for phase in [coming, going] {
            let off = |b: &f64| (b - phase).abs();
            let nearest = cycle.breaks.iter().map(off).fold(1.0, f64::min);
            assert!(nearest < 1e-13, "{torque}: {phase}, {nearest:e}");
            let [before, after] =
                [-1e-6, 1e-6].map(|step| cycle.value(&cycle.stiffness, phase + step) / single);
            let steps = if phase == coming { [1.0, 2.0] } else { [2.0, 1.0] };
            close(before, steps[0], 1e-12);
            close(after, steps[1], 1e-12);
        }
        close(
            cycle.mean_stiffness(),
            single * (1.0 + going - coming),
            1e-12,
        );
        // The segment in which the pair enters has the mean of its two parts.
        let count = 60.0;
        let segment = (count * coming) as usize;
        let loaded = 1.0 - (count * coming - segment as f64);
        let mean = cycle.segment_means(60)[segment].stiffness;
        close(mean, single * (1.0 + loaded), 1e-11);
    }
}

/// With misalignment a relieved pair enters at one corner first, where its stiffness has a kink.
#[test]
fn a_relieved_wedge_begins_at_a_break() {
    let (amount, length, misalignment) = (10e-6, 0.35, 1e-4);
    let law = relieved(1.6, amount, length);
    let single = STIFFNESS * FACE_WIDTH;
    for sign in [1.0, -1.0] {
        let inputs = MeshTableInputs {
            misalignment: vec![sign * misalignment],
            ..inputs()
        };
        let cycle = build(&law, &inputs).cycle(0, 0);
        // The previous pair is in contact along its whole face.
        let approach = cycle.force / single + 0.5 * misalignment * FACE_WIDTH;
        assert!(cycle.force / single > 0.5 * misalignment * FACE_WIDTH);
        let corner = length * (1.0 - approach / amount);
        let off = |b: &f64| (b - corner).abs();
        assert!(cycle.breaks.iter().map(off).fold(1.0, f64::min) < 1e-13);
        close(cycle.value(&cycle.stiffness, corner - 1e-6), single, 1e-12);
        assert!(cycle.value(&cycle.stiffness, corner + 1e-3) > 1.001 * single);
    }
}

/// Tables of relieved flanks follow their law between all nodes, for any load and misalignment.
#[test]
fn relieved_flanks_follow_their_law() {
    let law = FunctionFlank {
        relief: relieved(1.59, 12e-6, 0.3).relief,
        kinks: relieved(1.59, 12e-6, 0.3).kinks,
        ..curved(1.59)
    };
    for longest_piece in [0.25, 1.0 / 24.0] {
        for misalignment in [0.0, 1e-7, 2e-5, -2e-4, 1e-3] {
            for torque in [2.5, 10.0, 20.0, 50.0, 200.0] {
                let inputs = MeshTableInputs {
                    misalignment: vec![misalignment],
                    torque: vec![torque],
                    longest_piece,
                    ..inputs()
                };
                let worst = off_its_law(&law, &inputs, 499);
                assert!(worst < 1e-9, "{misalignment} {torque}: {worst:e}");
                let table = build(&law, &inputs);
                assert!(table.share.iter().all(|p| (0.0..=1.0).contains(p)));
                assert!(table.breaks.len() < 64, "{}", table.breaks.len());
            }
        }
    }
}

/// Tables follow their law for flanks whose contact stiffens above a limit, and for crowned flanks, whose slices all
/// have different kinks.
#[test]
fn stiffening_and_crowned_flanks_follow_their_law() {
    let stiffening = FunctionFlank {
        contact: Some(Box::new(|w| {
            let scale = 1e5;
            let compliance = 8e-12;
            let law = compliance * w * (w / scale).powf(-0.1);
            [law, 0.9 * law / w]
        })),
        ..relieved(1.6, 10e-6, 0.35)
    };
    let inputs_of = |contact| MeshTableInputs {
        contact,
        torque: vec![20.0],
        slices: 8,
        ..inputs()
    };
    let worst = off_its_law(&stiffening, &inputs_of(Contact::LoadDependent), 499);
    assert!(worst < 1e-9, "{worst:e}");
    let crowned = FunctionFlank {
        deviation: Box::new(|_, z| 4e-6 * (2.0 * z / FACE_WIDTH).powi(2)),
        ..relieved(1.6, 10e-6, 0.35)
    };
    for misalignment in [0.0, 1e-4] {
        let inputs = MeshTableInputs {
            misalignment: vec![misalignment],
            ..inputs_of(Contact::Linear)
        };
        let worst = off_its_law(&crowned, &inputs, 499);
        assert!(worst < 1e-9, "{misalignment}: {worst:e}");
    }
}

/// Beyond the path of contact the gap under a tip edge begins as a parabola. There two pairs have the same gap within
/// rounding, on slices of which both are partly in contact. A change of their order is no kink.
#[test]
fn pairs_that_part_without_a_kink_are_one_formula() {
    let relief = Relief {
        amount: 5e-6,
        length: 2e-3,
        ..Relief::default()
    };
    let form = ToothForm {
        end_relief: [relief; 2],
        bore: [Some(48e-3), Some(76e-3)],
        ..ToothForm::default()
    };
    let gears = GearPair {
        body_length: [70e-3, 40e-3],
        ..fixtures::pair([20, 30], form)
    };
    let flanks = Flanks::new(&gears).unwrap();
    for misalignment in [2.5e-4, 5e-4, 7.5e-4] {
        let inputs = MeshTableInputs {
            misalignment: vec![misalignment],
            face: FaceLaw::Independent,
            contact: Contact::Linear,
            ..MeshTableInputs::of_gears(&gears)
        };
        let cycle = MeshTable::build(&flanks, &inputs, &|_, _| {})
            .unwrap()
            .cycle(0, 0);
        assert!(cycle.breaks.len() < 200, "{}", cycle.breaks.len());
    }
}

/// A pair that touches for only a thousandth of the cycle, between two samples of a piece, is found.
#[test]
fn a_short_contact_between_the_samples_is_found() {
    let single = STIFFNESS * FACE_WIDTH;
    let approach = default_force() / single;
    let path = path(1.6);
    for middle in [0.1201, 0.1234, 0.1499, 0.1633] {
        let law = FunctionFlank {
            // Only the entering pair has a relief; its gap falls below the approach.
            relief: Box::new(move |s| {
                let phase = (s - path.start) / path.base_pitch;
                let dip = ((phase - middle) / 5e-4).powi(2) - 1.0;
                if phase < 0.6 { approach * (1.0 + 1e-3 * dip) } else { 0.0 }
            }),
            kinks: vec![path.start + 0.6 * path.base_pitch],
            ..FunctionFlank::constant(path, STIFFNESS)
        };
        let cycle = build(&law, &inputs()).cycle(0, 0);
        for phase in [middle - 5e-4, middle + 5e-4] {
            let off = |b: &f64| (b - phase).abs();
            let nearest = cycle.breaks.iter().map(off).fold(1.0, f64::min);
            assert!(nearest < 1e-9, "{phase}, {nearest:e}");
        }
        close(cycle.value(&cycle.stiffness, middle), 2.0 * single, 1e-9);
    }
}

/// A table of several loads is cut where any of them has a kink.
#[test]
fn a_table_has_the_kinks_of_all_its_loads() {
    let law = relieved(1.6, 10e-6, 0.35);
    let inputs_of = |torque: Vec<f64>| MeshTableInputs {
        torque,
        misalignment: vec![5e-5],
        ..inputs()
    };
    let both = build(&law, &inputs_of(vec![20.0, 50.0]));
    for (index, torque) in [20.0, 50.0].into_iter().enumerate() {
        let alone = build(&law, &inputs_of(vec![torque]));
        for cut in &alone.breaks {
            assert!(both.breaks.iter().any(|b| (b - cut).abs() < 1e-12), "{cut}");
        }
        let [a, b] = [both.cycle(0, index), alone.cycle(0, 0)].map(|c| c.mean_stiffness());
        close(a, b, 1e-10);
    }
}

/// Laws that no polynomial can follow are refused; means require less.
#[test]
fn a_law_that_polynomials_do_not_follow_is_refused() {
    let path = path(1.6);
    let cusped = FunctionFlank {
        compliance: Box::new(move |s| {
            let u = (s / path.base_pitch - 0.4567).abs();
            split(4e-11 * (1.0 + 0.01 * u.sqrt()), 0.0)
        }),
        ..FunctionFlank::constant(path, STIFFNESS)
    };
    let at = |tolerance: f64| {
        let inputs = MeshTableInputs {
            tolerance,
            ..inputs()
        };
        MeshTable::build(&cusped, &inputs, &|_, _| {})
    };
    let refused = at(1e-9).map(|table| table.breaks).unwrap_err();
    let MeshTableError::Unresolved { phase, error, .. } = &refused else {
        panic!("{refused}");
    };
    assert!((phase - 0.7567).abs() < 1e-6 && *error > 1e-9, "{refused}");
    assert!(refused.to_string().contains("mesh.stiffness = \"table\""));
    let kept = at(1e-6).unwrap().cycle(0, 0);
    let exact = |phase: f64| {
        let pairs = pairs_at(
            &cusped,
            phase,
            Face {
                width: FACE_WIDTH,
                slices: 1,
            },
        )
        .unwrap();
        let face = Face {
            width: FACE_WIDTH,
            slices: 1,
        };
        LoadSharing::new(&pairs, face, 0.0)
            .unwrap()
            .distribute(kept.force)
            .stiffness
    };
    for phase in [0.75, 0.7566, 0.7568, 0.8] {
        close(kept.value(&kept.stiffness, phase), exact(phase), 1e-6);
    }
}
