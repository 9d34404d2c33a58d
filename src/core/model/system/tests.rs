use super::*;
use crate::model::{Division, DriveShaft, FlankError, TorqueRipple};
use crate::model::{InitialState, MeshHarmonic, fixtures};
use crate::structure::{BearingGain, Coupling, OmittedModeForces};

fn structure(frequency: &[f64], mesh: &[f64]) -> ModalStructure {
    ModalStructure {
        rated_force: 1000.0,
        ..fixtures::structure(frequency, 0.02, mesh, mesh)
    }
}

fn drive() -> Drive {
    Drive {
        mesh: Division::levels(&[4e8, 4e8, 3e8], &[]),
        damping: 1000.0,
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, 0.3)],
        ..fixtures::constant_mesh(1e-5, 4e8)
    }
}

const POINT: OperatingPoint = OperatingPoint {
    load: 0.2,
    speed: 100.0,
};

#[test]
fn rigid_rotations_are_split_into_neutral_and_relative() {
    let s = structure(&[0.0, 0.0, 5000.0], &[0.52, -0.43, 0.31]);
    let model = Model::new(&s, &drive(), POINT).unwrap();
    assert_eq!(model.neutral, vec![0]);
    assert_eq!(model.relative_rotation(), Some(1));
    assert_eq!(model.first_gains()[0].deflection[0], 0.0);
    let norm = 0.52f64.hypot(0.43);
    assert!((model.first_gains()[1].deflection[0] - norm).abs() < 1e-15);
    // The balanced torques do not drive the neutral rotation.
    assert!(model.blocks[0].static_input[1].abs() < 1e-12);
    // An orthogonal change of basis keeps lengths and the deflection.
    let q = [0.3, 0.7, -0.2];
    let r = model.basis.state(&q, &[0.0; 3])[..3].to_vec();
    let [back, _] = model.basis.modes(&[&r[..], &[0.0; 3]].concat());
    assert!(back.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-15));
    let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    assert!((length(&q) - length(&r)).abs() < 1e-15);
    let deflection = |v: &[f64], w: &[f64]| -> f64 { v.iter().zip(w).map(|(a, b)| a * b).sum() };
    let w: Vec<f64> = model
        .first_gains()
        .iter()
        .map(|gain| gain.deflection[0])
        .collect();
    assert!((deflection(&q, &s.mesh) - deflection(&r, &w)).abs() < 1e-15);
}

#[test]
fn static_equilibrium_balances_every_block() {
    let constant = Drive {
        mesh: Division::levels(&[4e8], &[]),
        transmission_error: Vec::new(),
        ..drive()
    };
    for s in [
        structure(&[0.0, 0.0, 5000.0], &[0.52, -0.43, 0.31]),
        structure(&[3000.0, 5000.0], &[0.52, 0.31]),
    ] {
        for load in [0.3, -0.3] {
            let point = OperatingPoint { load, ..POINT };
            let model = Model::new(&s, &constant, point).unwrap();
            let start = model.start(&InitialState::Static);
            assert!(start.contact.touching());
            let mut out = vec![f64::NAN; 2 * model.modes()];
            let segments = model.segments_at(0, 0.0);
            model.derivative(&segments, start.contact, 0, 0.0, &start.state, &mut out);
            // Accelerations relative to the largest single contribution, the mesh force.
            let scale = s.rated_force * load.abs();
            for value in out {
                assert!(value.abs() < 1e-9 * scale, "{value}");
            }
        }
    }
}

#[test]
fn deflection_rate_is_the_derivative_of_the_deflection() {
    let s = structure(&[0.0, 4000.0], &[0.5, 0.3]);
    let model = Model::new(&s, &drive(), POINT).unwrap();
    let state = [1e-5, 2e-5, 0.1, -0.2];
    let (t, h) = (1e-3, 1e-7);
    let moved = |dt: f64| {
        let x = [
            state[0] + state[2] * dt,
            state[1] + state[3] * dt,
            state[2],
            state[3],
        ];
        model.deflection(&x, t + dt).0
    };
    let (_, rate) = model.deflection(&state, t);
    assert!(((moved(h) - moved(-h)) / (2.0 * h) - rate).abs() < 1e-6 * rate.abs());
}

#[test]
fn residual_flexibility_softens_the_mesh_in_series() {
    let mut s = structure(&[0.0, 4000.0], &[0.5, 0.3]);
    s.residual_flexibility = 1e-10;
    let model = Model::new(&s, &drive(), POINT).unwrap();
    assert!((model.first_cycle().segments[0].stiffness.bound() - 4e8 / 1.04).abs() < 1e-6);
}

/// Parallel springs of a flank share the residual flexibility. The model is refused if the springs act on
/// different lines of action.
#[test]
fn springs_of_a_flank_share_the_residual_flexibility() {
    let mut s = structure(&[0.0, 4000.0], &[0.5, 0.3]);
    s.residual_flexibility = 1e-9;
    let mut d = drive();
    let joining = |gap: f64| Division {
        error: FlankError::series([gap, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ..Division::level(1.0, 2e8)
    };
    d.mesh = vec![joining(1e-6)];
    d.further = vec![vec![joining(3e-6)]];
    let model = Model::new(&s, &d, POINT).unwrap();
    let segment = |contact: usize| model.contacts[contact].cycles[0].segments[0];
    let [first, second] = [segment(0), segment(2)];
    assert!((first.stiffness.mean() / (2e8 / 1.2) - 1.0).abs() < 1e-14);
    let both = first.stiffness.mean() + second.stiffness.mean();
    assert!((both / (4e8 / 1.4) - 1.0).abs() < 1e-14);
    // When the second spring closes, the first one carries 400 N, which deflects the omitted modes by 0.4 µm.
    assert!((second.error_at(0.5)[0] - 3.4e-6).abs() < 1e-18);
    d.further[0][0].load_centre = 5e-3;
    let flexibility = s.residual_flexibility;
    assert_eq!(
        Model::new(&s, &d, POINT),
        Err(ModelError::SpringsApart { flexibility })
    );
}

#[test]
fn ripple_needs_a_known_shaft_and_modes_may_be_overdamped() {
    let mut s = structure(&[0.0, 4000.0], &[0.5, 0.3]);
    let mut d = drive();
    d.torque_ripple.push(TorqueRipple {
        shaft: DriveShaft::Wheel,
        order: 2.0,
        amplitude: 3.0,
        phase: 0.0,
    });
    let error = Model::new(&s, &d, POINT).unwrap_err();
    assert_eq!(error, ModelError::UnknownShaft { shaft: "wheel" });
    s.wheel_torque = Some(vec![0.1, 0.2]);
    let model = Model::new(&s, &d, POINT).unwrap();
    assert!((model.ripple[0].turns_per_cycle - 2.0 / 30.0).abs() < 1e-16);
    s.damping[1] = 1.5;
    assert!(
        Model::new(&s, &d, POINT).unwrap().blocks[1]
            .spread()
            .is_some()
    );
}

/// Under drag the rotation of the whole drive is not neutral. It is at rest at any position, unless a spring
/// restrains it.
#[test]
fn a_rotation_under_drag_rests_anywhere() {
    let mesh = [0.52, -0.43, 0.31];
    let plain = structure(&[0.0, 0.0, 5000.0], &mesh);
    let coupled = |drag: [f64; 2], spring: f64| {
        let mut s = plain.clone();
        let mut damping = vec![0.0; 9];
        (damping[0], damping[4], damping[1], damping[3]) = (drag[0], drag[0], drag[1], drag[1]);
        let mut stiffness = vec![0.0; 9];
        (stiffness[0], stiffness[4]) = (spring, spring);
        s.coupling = Some(Coupling {
            damping,
            gyroscopic: vec![0.0; 9],
            stiffness,
        });
        Model::new(&s, &drive(), POINT).unwrap()
    };
    let model = Model::new(&plain, &drive(), POINT).unwrap();
    assert_eq!(
        (
            model.neutral.len(),
            model.unrestrained_displacements().len()
        ),
        (1, 0)
    );
    for drag in [[3.0, 0.0], [3.0, 1.0], [4e4, 0.0], [4e4, 1e4]] {
        let model = coupled(drag, 0.0);
        let [state] = &model.unrestrained_displacements()[..] else {
            panic!("one displacement expected under {drag:?}");
        };
        // Along the line that does not deflect the mesh, and without velocity.
        let [place, speed] = model.basis.modes(state);
        let along: f64 = place.iter().zip(mesh).map(|(q, w)| q * w).sum();
        let size = place[0].hypot(place[1]);
        assert!(along.abs() < 1e-14 * size && place[2].abs() < 1e-14 * size);
        assert!(speed.iter().all(|v| v.abs() < 1e-12 * size), "{speed:?}");
        assert_eq!(coupled(drag, 100.0).unrestrained_displacements().len(), 0);
    }
}

/// A component of a fast mode counts as round-off if another displacement is more than a billion times as large.
#[test]
fn rounding_does_not_move_what_is_at_rest() {
    let model = Model::new(
        &structure(&[0.0, 0.0, 5000.0], &[0.52, -0.43, 0.31]),
        &drive(),
        POINT,
    );
    let model = model.unwrap();
    let elastic = |block: &Block| block.natural_frequency() > 1.0;
    let fast = model.blocks.iter().position(elastic).unwrap();
    let rigid = (0..3).find(|i| *i != fast).unwrap();
    for (part, rests) in [(0.0, true), (1e-10, true), (1e-8, false)] {
        let mut state = vec![0.0; 6];
        (state[rigid], state[fast]) = (2.0, 2.0 * part);
        assert_eq!(model.is_at_rest(&state), rests, "{part}");
    }
}

#[test]
fn contacts_recur_together_after_their_base_period() {
    let s = structure(&[0.0, 4000.0], &[0.5, 0.3]);
    let mut model = Model::new(&s, &drive(), POINT).unwrap();
    assert_eq!(model.base_cycles(), 1);
    for (contact, cycles) in [(0, 4), (1, 6)] {
        let one = model.contacts[contact].cycles[0].clone();
        model.contacts[contact].cycles = vec![one; cycles];
    }
    assert_eq!(model.base_cycles(), 12);
}

/// Critical damping of the effective mass along the line of action. The mass is that of the rigid modes, or
/// of all modes if none is rigid.
#[test]
fn damping_ratios_are_those_of_the_mass_in_the_mesh() {
    let mesh: [f64; 3] = [0.52, -0.43, 0.31];
    let [a, b, c] = mesh.map(|w| w * w);
    for (frequency, inverse_mass) in [
        ([0.0, 0.0, 5000.0], a + b),
        ([100.0, 200.0, 5000.0], a + b + c),
    ] {
        let s = structure(&frequency, &mesh);
        let critical = Model::damping_from_ratio(&s, 1.0, 4e8);
        assert!((critical - 2.0 * (4e8 / inverse_mass).sqrt()).abs() < 1e-9 * critical);
        let mass = Model::new(&s, &drive(), POINT).unwrap().effective_mass;
        assert!((mass * inverse_mass - 1.0).abs() < 1e-14);
        let known = ModalStructure {
            mesh_mass: Some(0.25),
            ..s
        };
        assert_eq!(Model::damping_from_ratio(&known, 0.1, 4e8), 2e3);
        let mass = Model::new(&known, &drive(), POINT).unwrap().effective_mass;
        assert_eq!(mass, 0.25);
    }
}

/// Compares with a new model under the other load.
#[test]
fn another_load_changes_the_forces_on_bearings() {
    let s = ModalStructure {
        bearings: vec![BearingGain {
            name: "pinion 1 x".to_owned(),
            gain: vec![2e6, -3e6],
            rate_gain: Vec::new(),
            left_out: OmittedModeForces {
                torque: 0.4,
                constant_load: 70.0,
                ..OmittedModeForces::default()
            },
        }],
        ..structure(&[0.0, 4000.0], &[0.5, 0.3])
    };
    let model = Model::new(&s, &drive(), POINT).unwrap();
    let other = OperatingPoint { load: 0.7, ..POINT };
    let exact = Model::new(&s, &drive(), other).unwrap();
    let found = model.under_load(0.7).unwrap();
    assert_eq!(exact.bearings[0].constant, 0.4 * 1000.0 * 0.7 + 70.0);
    assert!((found.bearings[0].constant - exact.bearings[0].constant).abs() < 1e-12);
}

#[test]
fn every_division_of_a_flank_has_a_stiffness() {
    let s = structure(&[0.0, 4000.0], &[0.5, 0.3]);
    let refused = |drive: &Drive| {
        let made = Model::new(&s, drive, POINT);
        matches!(
            made,
            Err(ModelError::OutOfRange {
                name: "mesh stiffness",
                ..
            })
        )
    };
    let mut unknown = drive();
    unknown.mesh[0] = Division::level(unknown.mesh[0].end, f64::NAN);
    assert!(refused(&unknown) && !refused(&drive()));
    let mut faulty = drive();
    let cycles = [faulty.mesh.clone(), Division::levels(&[0.0], &[])];
    faulty.tooth_cycles[0] = cycles.map(|first| vec![first]).to_vec();
    assert!(refused(&faulty));
}
