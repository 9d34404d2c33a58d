#![allow(clippy::unwrap_used)]
use super::*;
use crate::shaft::flexible::tests::{damped, drive};
use crate::shaft::{Drag, FlexibleDrive};
use crate::structure::ModalStructure;

const MODES: usize = 24;

/// The flank of a further mesh; its force law does not matter here.
fn law() -> ContactLaw {
    ContactLaw {
        gap: 10e-6,
        stiffness: vec![(1.0, [2e8, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
        damping: 100.0,
        ..ContactLaw::default()
    }
}

/// The damped flexible drive with elements of 10 mm, the shaft of its wheel hollow.
fn flexible() -> FlexibleDrive {
    let mut drive = FlexibleDrive {
        elements: [3, 6, 9],
        damping_overrides: Vec::new(),
        ..damped()
    };
    drive.shafts[1].inner_diameter = 15e-3;
    drive
}

/// The same drive as a train, each shaft in one section.
fn train(of: &FlexibleDrive) -> TrainDrive {
    let mut train = of.train().unwrap();
    for shaft in &mut train.shafts {
        shaft.sections = vec![ShaftSection {
            length: shaft.length(),
            element: None,
            ..shaft.sections[0]
        }];
        shaft.element = Some(10e-3);
    }
    train
}

fn assert_close(name: &str, a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len(), "{name}");
    let scale = b.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!(
            (a - b).abs() <= 1e-7 * scale,
            "{name} {i}: {a} {b} of {scale}"
        );
    }
}

/// The position of the train in space does not matter.
#[test]
fn a_train_may_lie_anywhere() {
    let mut train = train(&flexible());
    let expected = train.modes(MODES, MODES, false).unwrap();
    // Rotate by an arbitrary angle about an oblique axis.
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(1.0, 2.0, -0.5));
    let turn = nalgebra::Rotation3::from_axis_angle(&axis, 1.1);
    // Bearings equal in x and y, whose frame rotates.
    let bearings = |train: &mut TrainDrive| {
        for (_, bearing) in train.shafts.iter_mut().flat_map(|s| &mut s.bearings) {
            bearing.y = bearing.x;
            bearing.damping = [[200.0, 0.0], [0.0, 200.0]];
        }
    };
    bearings(&mut train);
    let upright = train.modes(MODES, MODES, false).unwrap();
    for shaft in &mut train.shafts {
        shaft.origin = (turn * nalgebra::Vector3::from(shaft.origin)).into();
        shaft.direction = (turn * nalgebra::Vector3::z()).into();
    }
    let askew = train.modes(MODES, MODES, false).unwrap();
    assert_close("frequency", &askew.frequency, &upright.frequency);
    assert!((expected.frequency[2] / upright.frequency[2] - 1.0).abs() > 1e-4);
    // Modes come in pairs now; the sum of the participations over a pair does not depend on its basis.
    let projection = |s: &ModalStructure, a: &[f64], b: &[f64]| -> f64 {
        let parts = a.iter().zip(b).zip(&s.frequency);
        parts
            .filter(|(_, f)| **f > 0.0)
            .map(|((a, b), f)| a * b / (f * f))
            .sum()
    };
    let coast = |s: &ModalStructure| s.coast.clone().unwrap().mesh;
    for (a, b) in [
        (
            projection(&askew, &askew.mesh, &askew.mesh),
            projection(&upright, &upright.mesh, &upright.mesh),
        ),
        (
            projection(&askew, &askew.mesh, &coast(&askew)),
            projection(&upright, &upright.mesh, &coast(&upright)),
        ),
        (
            projection(&askew, &askew.mesh, &askew.friction),
            projection(&upright, &upright.mesh, &upright.friction),
        ),
    ] {
        assert!((a / b - 1.0).abs() < 1e-8, "{a} {b}");
    }
}

/// Three bodies in a row that only rotate: all results have closed forms.
fn row(teeth: [u32; 4]) -> TrainDrive {
    let mut train = train(&drive());
    let radius = |z: u32| 0.5 * 3e-3 * f64::from(z);
    let gear = |name: &str, at: f64, teeth: u32| TrainGear {
        name: name.to_owned(),
        at,
        teeth,
        body: Disc {
            mass: 1.0,
            transverse_inertia: 1.0,
            polar_inertia: 1e-4 * f64::from(teeth),
        },
        ..train.shafts[0].gears[0].clone()
    };
    let [a, b, c, d] = teeth;
    let gears = [
        vec![gear("a", 0.0, a)],
        vec![gear("b", 0.0, b), gear("c", 0.05, c)],
        vec![gear("d", 0.05, d)],
    ];
    let first = radius(a) + radius(b);
    let x = [0.0, first, first + radius(c) + radius(d)];
    train.shafts = (gears.into_iter().zip(x).enumerate())
        .map(|(index, (gears, x))| TrainShaft {
            name: ["input", "counter", "output"][index].to_owned(),
            origin: [x, 0.0, 0.0],
            sections: Vec::new(),
            motion: Motion::Rotation,
            discs: Vec::new(),
            gears,
            bearings: Vec::new(),
            torque_at: 0.0,
            output: [0.0, 0.0, 1.0][index],
            drag: Drag::default(),
            ..train.shafts[0].clone()
        })
        .collect();
    train.pair.teeth = [a, b];
    train.damping_overrides = Vec::new();
    train.meshes = vec![TrainMesh {
        gears: [
            GearPlace { shaft: 1, gear: 1 },
            GearPlace { shaft: 2, gear: 0 },
        ],
        pressure_angle: 20f64.to_radians(),
        law: MeshLaw::Own(Box::new([law(), law()])),
    }];
    train.gyroscopic = false;
    train
}

#[test]
fn two_stages_turn_as_their_teeth_say() {
    let train = row([20, 30, 18, 27]);
    let layout = train.layout().unwrap();
    assert_eq!(layout.speeds, [1.0, -2.0 / 3.0, 4.0 / 9.0]);
    // A body at rest counts as rotating forwards.
    assert_eq!([-0.5, 0.0, 2.0].map(speeds::sense), [-1.0, 1.0, 1.0]);
    // 18/30 of the first mesh's cycles.
    assert_eq!(layout.cycles, [[1, 1], [3, 5]]);
    let structure = train.modes(3, 3, false).unwrap();
    assert_eq!(structure.frequency, [0.0; 3]);
    assert_eq!(structure.neutral_modes(), 1);

    let inertia = [20e-4, 48e-4, 27e-4];
    let base = |z: f64| 0.5 * 3e-3 * z * 20f64.to_radians().cos();
    // Inverse mass of each mesh and their coupling through the shaft between.
    let [first, second] = [
        base(20.0).powi(2) / inertia[0] + base(30.0).powi(2) / inertia[1],
        base(18.0).powi(2) / inertia[1] + base(27.0).powi(2) / inertia[2],
    ];
    // δ₁ = r_a θ_a + r_b θ_b grows with θ_b > 0. The counter shaft rotates backwards, which determines
    // the drive flanks of the second mesh: δ₂ = −r_c θ_c − r_d θ_d.
    let across = -base(30.0) * base(18.0) / inertia[1];
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let [drive, coast] = [0, 1].map(|i| &structure.contacts[i]);
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    close(dot(&structure.mesh, &structure.mesh), first);
    close(dot(&drive.participation, &drive.participation), second);
    close(dot(&structure.mesh, &drive.participation), across);
    let sum: f64 = (drive.participation.iter().zip(&coast.participation))
        .map(|(a, b)| (a + b).abs())
        .sum();
    assert!(sum < 1e-12, "{sum}");

    // In balance every mesh carries the force of its torque: torque = mesh F₁ + contact F₂ with F₁ = 1
    // and F₂ the ratio of the lever arms.
    let ratio = base(30.0) / base(18.0);
    for i in 0..3 {
        let rest = structure.torque[i] - structure.mesh[i] - ratio * drive.participation[i];
        assert!(rest.abs() < 1e-12, "{i} {rest}");
    }
}

/// An engine ahead of the first shaft, in line with it and joined to it by a coupling \[N m/rad\].
fn with_engine(mut train: TrainDrive, twist: f64) -> TrainDrive {
    let inertia = Disc {
        polar_inertia: 0.15,
        ..Disc::default()
    };
    train.shafts.push(TrainShaft {
        name: "engine".to_owned(),
        sections: Vec::new(),
        motion: Motion::Rotation,
        discs: vec![(0.0, inertia)],
        gears: Vec::new(),
        bearings: Vec::new(),
        torque_at: 0.0,
        ..train.shafts[0].clone()
    });
    train.driver = train.shafts.len() - 1;
    train.couplings = vec![ShaftCoupling {
        shafts: [train.driver, 0],
        at: [0.0; 2],
        stiffness: [0.0, 0.0, 0.0, twist],
        damping: 0.0,
        stages: Vec::new(),
        hysteresis: Vec::new(),
    }];
    train
}

/// m_red of both gears in closed form; the engine and the third shaft do not add to it.
#[test]
fn the_mass_of_a_mesh_is_that_of_its_two_shafts() {
    let base = |z: f64| 0.5 * 3e-3 * z * 20f64.to_radians().cos();
    let expected = 1.0 / (base(20.0).powi(2) / 20e-4 + base(30.0).powi(2) / 48e-4);
    let alone = row([20, 30, 18, 27]);
    let structure = alone.modes(3, 3, false).unwrap();
    assert_eq!(structure.mesh_mass, None);
    for twist in [20.0, 1e5] {
        let coupled = with_engine(alone.clone(), twist).modes(4, 4, false);
        let mass = coupled.unwrap().mesh_mass.unwrap();
        assert!((mass / expected - 1.0).abs() < 1e-12, "{mass} {expected}");
    }
    // A loose gear counts without its shaft.
    let mut loose = alone;
    loose.meshes.clear();
    loose.shafts.truncate(2);
    loose.shafts[1].motion = Motion::None;
    loose.shafts[1].gears[0].loose = Some(LooseGear {
        bearing: Bearing::default(),
        drag: Drag::default(),
    });
    let structure = with_engine(loose, 20.0).modes(3, 3, false).unwrap();
    let mass = structure.mesh_mass.unwrap();
    let expected = 1.0 / (base(20.0).powi(2) / 20e-4 + base(30.0).powi(2) / 30e-4);
    assert!((mass / expected - 1.0).abs() < 1e-12, "{mass} {expected}");

    // Beams rotate as a rigid body, as in the rigid modes without an engine.
    let flexible = train(&flexible());
    let structure = flexible.modes(MODES, MODES, false).unwrap();
    let sum: f64 = structure.mesh[..2].iter().map(|w| w * w).sum();
    let coupled = with_engine(flexible, 20.0).modes(MODES, MODES, false);
    let mass = coupled.unwrap().mesh_mass.unwrap();
    assert!((mass * sum - 1.0).abs() < 1e-8, "{mass} {sum}");
}

#[test]
fn a_loose_gear_turns_for_itself_and_is_braked_by_its_shaft() {
    let mut train = row([20, 30, 18, 27]);
    train.shafts[2].motion = Motion::Lateral;
    train.shafts[2].discs = vec![(
        0.0,
        Disc {
            mass: 1.0,
            transverse_inertia: 1.0,
            polar_inertia: 1.0,
        },
    )];
    train.shafts[2].output = 0.0;
    let bearing = Bearing {
        x: 1e8,
        y: 1e8,
        axial: 1e8,
        tilt: 1e4,
        ..Bearing::default()
    };
    train.shafts[2].bearings = vec![(0.0, bearing)];
    train.shafts[2].gears[0].loose = Some(LooseGear {
        bearing,
        drag: Drag {
            viscous: 2e-3,
            constant: 0.3,
        },
    });
    assert_eq!(train.rotations(), 3);
    let structure = train.modes(8, 8, false).unwrap();
    assert_eq!(structure.rigid_modes(), 3);
    assert!(structure.torque.iter().all(|&t| t == 0.0));
    // The drag loads the second mesh: F₂ = T/r_d, F₁ = F₂ r_c/r_b, and the motor's torque.
    let base = |z: f64| 0.5 * 3e-3 * z * 20f64.to_radians().cos();
    let drive = &structure.contacts[0].participation;
    for (load, torque) in [
        (&structure.constant_load, 0.3),
        (&structure.load_by_speed, 2e-3 * 4.0 / 9.0),
    ] {
        let second = torque / base(27.0);
        let first = second * base(18.0) / base(30.0);
        for i in 0..3 {
            let rest = load[i] - first * structure.mesh[i] - second * drive[i];
            assert!(rest.abs() < 1e-10 * torque / base(27.0), "{i} {rest}");
        }
    }
}

#[test]
fn trains_that_cannot_run_are_told() {
    let failure = |train: TrainDrive| train.modes(3, 3, false).unwrap_err().to_string();
    let mut long = row([20, 10007, 10009, 27]);
    long.meshes[0].gears.reverse();
    assert!(failure(row([20, 10007, 10009, 27])).contains("10009 cycles in 10007"));
    let mut apart = row([20, 30, 18, 27]);
    apart.shafts[2].gears[0].at = 0.2;
    assert!(failure(apart).contains("faces are"), "faces");
    let mut motor = row([20, 30, 18, 27]);
    motor.driver = 2;
    assert!(failure(motor).contains("`output` does not turn with the first gear"));
    let mut held = row([20, 30, 18, 27]);
    held.shafts[2].motion = Motion::Lateral;
    assert!(failure(held).contains("`output` is driven"));
    // Shafts on one axis, then on two, then with a spring across the axis over a gap.
    let coupled = |at: [f64; 2], radial: f64| {
        let mut coupled = row([20, 30, 18, 32]);
        coupled.shafts[2].origin = coupled.shafts[0].origin;
        coupled.couplings.push(ShaftCoupling {
            shafts: [0, 2],
            at,
            stiffness: [radial, 0.0, 0.0, 1e3],
            damping: 0.0,
            stages: Vec::new(),
            hysteresis: Vec::new(),
        });
        coupled
    };
    assert!(failure(coupled([0.0; 2], 0.0)).contains("the train locks"));
    assert!(failure(coupled([0.1, 0.0], 0.0)).contains("the train locks"));
    assert!(failure(coupled([0.1, 0.0], 1e7)).contains("across a gap of 1.000e-1 m"));
    let mut parallel = coupled([0.0; 2], 0.0);
    parallel.shafts[2].origin = row([20, 30, 18, 32]).shafts[2].origin;
    assert!(failure(parallel).contains("on one axis"));
    let mut loose = train(&flexible());
    loose.shafts[1].bearings.pop();
    loose.shafts[1].bearings[0].1.tilt = 0.0;
    let message = loose.modes(MODES, MODES, false).unwrap_err().to_string();
    assert!(message.contains("shaft `wheel` is not held"), "{message}");
    // Which shaft, and in which direction: along its axis, across it, tilting.
    for shaft in 0..2 {
        let without = |loosen: &dyn Fn(&mut Bearing)| {
            let mut loose = train(&flexible());
            loose.shafts[shaft]
                .bearings
                .iter_mut()
                .for_each(|(_, bearing)| loosen(bearing));
            loose.modes(MODES, MODES, false).unwrap_err().to_string()
        };
        let name = ["pinion", "wheel"][shaft];
        for (message, way) in [
            (without(&|bearing| bearing.axial = 0.0), "axially"),
            (without(&|bearing| bearing.x = 0.0), "along its x axis"),
            (without(&|bearing| bearing.y = 0.0), "along its y axis"),
        ] {
            let expected = format!("shaft `{name}` is not held {way}");
            assert!(message.contains(&expected), "{message}");
        }
    }
    let mut light = row([20, 30, 18, 27]);
    light.shafts[0].gears[0].body.polar_inertia = 0.0;
    assert!(failure(light).contains("no sections and no inertia"));
}

/// The section at a position, the thicker one where two meet; ends are compared within rounding.
#[test]
fn a_place_has_the_thicker_of_the_sections_that_meet_there() {
    let section = |length: f64, outer: f64| ShaftSection {
        length,
        outer,
        inner: 0.0,
        element: None,
    };
    let sections = [section(0.1, 0.03), section(0.2, 0.05), section(0.1, 0.04)];
    for (at, outer) in [
        (-1e-12, Some(0.03)),
        (0.05, Some(0.03)),
        (0.1, Some(0.05)),
        (0.2, Some(0.05)),
        (0.3, Some(0.05)),
        (0.35, Some(0.04)),
        (0.4 + 1e-12, Some(0.04)),
        (-0.01, None),
        (0.41, None),
    ] {
        let found = ShaftSection::at(&sections, at).map(|own| own.outer);
        assert_eq!(found, outer, "{at}");
    }
}

/// The approach to a stop next to a bearing is the bearing's displacement, for any length of the stop's direction.
#[test]
fn a_stop_is_approached_as_its_place_moves() {
    let mut train = train(&drive());
    let (at, bearing) = train.shafts[1].bearings[0];
    let stop = |direction: [f64; 3]| Stop {
        shaft: 1,
        at,
        direction,
        law: ContactLaw { gap: 5e-6, ..law() },
    };
    train.stops = [[0.0, 0.0, -2.0], [5.0, 0.0, 0.0], [1.0, -2.0, 2.0]]
        .map(stop)
        .to_vec();
    let structure = train.modes(MODES, MODES, false).unwrap();
    let moved = |axis: &str, stiffness: f64| -> Vec<f64> {
        let name = format!("wheel 1 {axis}");
        let own = structure
            .bearings
            .iter()
            .find(|bearing| bearing.name == name);
        own.unwrap()
            .gain
            .iter()
            .map(|force| force / stiffness)
            .collect()
    };
    let [x, y] = [moved("x", bearing.x), moved("y", bearing.y)];
    let z = moved("axial", bearing.axial);
    let towards = |i: usize| [-z[i], x[i], (x[i] - 2.0 * y[i] + 2.0 * z[i]) / 3.0];
    assert_eq!(structure.contacts.len(), 3);
    for (number, contact) in structure.contacts.iter().enumerate() {
        assert_eq!(
            (contact.name.as_str(), contact.law.gap),
            ("stop of wheel", 5e-6)
        );
        assert_eq!(contact.force, contact.participation);
        let size = contact
            .participation
            .iter()
            .fold(0.0_f64, |size, w| size.max(w.abs()));
        assert!(size > 0.1, "{number}: {size}");
        for (i, found) in contact.participation.iter().enumerate() {
            let off = found - towards(i)[number];
            assert!(off.abs() < 1e-9 * size, "{number}, mode {i}: {off:e}");
        }
    }
}

/// The count of elements precedes their assembly, and agrees with it.
#[test]
fn a_train_is_refused_before_its_elements_are_made() {
    let mut train = train(&drive());
    let made = train.freedoms().unwrap();
    let length = train.shafts[1].length();
    // Two shafts with Motion::All: one more node than elements each.
    let elements = |train: &TrainDrive| -> f64 {
        (0..2)
            .flat_map(|index| {
                let places = train.places(index).unwrap();
                train.shafts[index].stretches(&places)
            })
            .map(|stretch| stretch.elements)
            .sum()
    };
    assert_eq!(6.0 * (elements(&train) + 2.0), made as f64);
    train.shafts[1].element = Some(length / 600.0);
    assert!(train.check().is_ok());
    for element in [length / 700.0, 1e-9, 1e-300, f64::MIN_POSITIVE] {
        train.shafts[1].element = Some(element);
        let Err(TrainError::TooFine {
            place,
            elements_of_section,
            freedoms,
            gigabytes,
            ..
        }) = train.check()
        else {
            panic!("{element} is taken");
        };
        assert_eq!(place, [1, 0]);
        assert!(elements_of_section >= 0.999 * length / element);
        assert!(freedoms > 4000.0 && gigabytes > 1.0);
        assert!(matches!(train.freedoms(), Err(ShaftError::Train(_))));
    }
    // The elements of a held shaft count too.
    train.shafts[1].element = Some(length / 5000.0);
    train.shafts[1].motion = Motion::None;
    assert!(matches!(
        train.check_size(),
        Err(TrainError::TooFine { .. })
    ));
}
