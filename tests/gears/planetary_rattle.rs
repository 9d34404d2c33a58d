//! Planetary sets in rattle, compared with an independent integrator: over twenty cycles, with a set assembled by hand,
//! and with more than 64 contacts.

use crate::common;
use crate::planetary::{Plane, Set, directions, job, model};
use common::advance::{Events, advance, advance_with, volterra};
use gearatlas::analysis::EnergyNorm;
use gearatlas::model::{
    CoastFlank, Division, Drive, InitialState, MeshHarmonic, Model, OperatingPoint, TrajectoryState,
};
use gearatlas::reference::Reference;
use gearatlas::structure::{FlankParticipation, ModalStructure};
use gearatlas::sweep::build;
use gearatlas::verify::drives::disturbed;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Displacement of pins ahead of their positions \[m\].
const PINS: [f64; 4] = [8e-6, 0.0, 3e-6, 0.0];

/// Error of all meshes of the sun \[m\].
const ERROR: f64 = 5e-6;

/// Comparison after some cycles.
pub struct Compared {
    /// Distance of the states, in half gaps.
    pub apart: f64,
    /// Largest difference of the times of an event, in cycles.
    pub late: f64,
    /// Contacts that opened or closed, in order.
    pub events: Vec<usize>,
    /// Growth of a displacement.
    pub growth: f64,
}

/// Compares `volterra` with the reference, which must have the same events.
pub fn compare(model: &Model, start: &TrajectoryState, cycles: u64) -> Compared {
    let mut seen = Events::default();
    let (end, _) = advance_with(&volterra(model), start, cycles, &mut seen);
    let exact = Reference::new(model).advance(start, cycles).unwrap();
    let found: Vec<_> = (seen.0.iter())
        .map(|event| (event.cycle, event.contact, event.to))
        .collect();
    let known: Vec<_> = (exact.crossings.iter())
        .map(|crossing| (crossing.cycle, crossing.contact, crossing.to))
        .collect();
    assert_eq!(found, known);
    let late = (seen.0.iter().zip(&exact.crossings))
        .map(|(event, crossing)| (event.time - crossing.time).abs() / model.period());
    let norm = EnergyNorm::new(model);
    let mut beside = start.clone();
    let displaced = 1e-6;
    for &i in norm.weighted_components() {
        let part = displaced * norm.unit() / (norm.weighted_components().len() as f64).sqrt();
        beside.state[i] += part / norm.weights()[i];
    }
    let beside = advance(&volterra(model), &beside, cycles);
    Compared {
        apart: norm.distance(&end.state, &exact.end.state) / norm.unit(),
        late: late.fold(0.0, f64::max),
        events: seen.0.iter().map(|event| event.contact).collect(),
        growth: norm.distance(&end.state, &beside.state) / (displaced * norm.unit()),
    }
}

/// Twenty cycles in which planets separate from sun and ring, at rest and in the rotating frame.
#[test]
fn twenty_cycles_are_those_of_the_reference() {
    for (planets, gyroscopic) in [(3, false), (3, true), (4, true)] {
        let set = rattling(planets, gyroscopic);
        let model = set.model();
        let found = compare(&model, &hardly_disturbed(&model), 20);
        println!(
            "{planets} planets, gyroscopic {gyroscopic}: {} events, states {:.1e} half gaps, times {:.1e} cycles, growth {:.1e}",
            found.events.len(),
            found.apart,
            found.late,
            found.growth
        );
        assert!(found.events.len() > 20);
        assert!(found.apart < 1e-10, "{:e}", found.apart);
        // The bound is the growth of a round-off of the start.
        let grown = 1e-12 * found.growth;
        assert!(found.late < grown, "{:e} {grown:e}", found.late);
    }
}

/// A fifth of the way to the start of [`disturbed`], from which motion grows little.
pub fn hardly_disturbed(model: &Model) -> TrajectoryState {
    let rest = model.start(&InitialState::Static).state;
    let far = disturbed(model).state;
    let state = rest
        .iter()
        .zip(far)
        .map(|(rest, far)| rest + 0.2 * (far - rest));
    TrajectoryState::new(model, state.collect(), 0)
}

/// A set in which all planets rattle lightly.
fn rattling(planets: usize, gyroscopic: bool) -> Set {
    Set {
        gyroscopic,
        speed: 800.0,
        levels: true,
        more: format!("pin_errors = {:?}", &PINS[..planets]),
        ..Set::lin_parker(planets)
    }
}

/// The model of a set by hand, with constant stiffness and without gyroscopic terms: modes, loads and flanks of
/// [`Plane`].
fn by_hand(set: &Set, of_train: &ModalStructure, load: f64) -> Model {
    let Plane {
        mass,
        stiffness,
        flanks,
        neutral,
        ..
    } = Plane::of(set);
    let n = mass.nrows();
    let roots = mass.diagonal().map(f64::sqrt);
    let scaled = DMatrix::from_fn(n, n, |i, j| stiffness[(i, j)] / (roots[i] * roots[j]));
    let SymmetricEigen {
        eigenvalues,
        eigenvectors,
    } = SymmetricEigen::new(scaled);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigenvalues[a].total_cmp(&eigenvalues[b]));
    let is_rigid = |mode: &&usize| eigenvalues[**mode] < 1e-6 * eigenvalues.amax();
    let rigid = order.iter().filter(is_rigid).count();
    // The neutral rotation comes first, then the other rigid motions.
    let mut shapes: Vec<DVector<f64>> = vec![neutral.component_mul(&roots).normalize()];
    for &mode in &order {
        let mut own = eigenvectors.column(mode).into_owned();
        for known in &shapes {
            own -= known * known.dot(&own);
        }
        if own.norm() > 1e-6 {
            shapes.push(own.normalize());
        }
    }
    assert_eq!(shapes.len(), n);
    let felt = |along: &DVector<f64>| -> Vec<f64> {
        let along = along.component_div(&roots);
        let mut parts: Vec<f64> = shapes.iter().map(|shape| shape.dot(&along)).collect();
        parts[0] = 0.0;
        parts
    };
    let frequency: Vec<f64> = (order.iter().enumerate())
        .map(|(place, &mode)| if place < rigid { 0.0 } else { eigenvalues[mode].sqrt() })
        .collect();
    let [zs, _, zr] = set.teeth.map(f64::from);
    let ratio = zs / (zs + zr);
    let mut torque = DVector::zeros(n);
    (torque[2], torque[5]) = (100.0, -100.0 / ratio);
    let [drive, coast] = flanks[0].each_ref().map(felt);
    let mut structure = ModalStructure {
        teeth: set.teeth[0],
        rated_force: 1.0,
        ..ModalStructure::of_modes(&frequency, 0.01, &drive, &felt(&torque))
    };
    structure.frame.rolling = 1.0 - ratio;
    structure.coast = Some(FlankParticipation {
        mesh: coast,
        tilt: vec![0.0; n],
        friction: vec![0.0; n],
        lever: vec![0.0; n],
        residual_flexibility: 0.0,
    });
    // The contacts have the train's laws, but not its participations.
    structure.contacts = of_train.contacts.clone();
    let further = flanks[1..]
        .iter()
        .flat_map(|[drive, coast]| [drive.clone(), -coast]);
    for (contact, along) in structure.contacts.iter_mut().zip(further) {
        (contact.participation, contact.force) = (felt(&along), felt(&along));
        (contact.tilt, contact.rubbing) = (Vec::new(), Default::default());
    }
    structure.constant_load = felt(&pin_forces(set));
    let mesh = Division::levels(&[set.stiffness], &[]);
    let error = vec![MeshHarmonic::new(1, ERROR, 0.0)];
    let drive = Drive {
        damping: 300.0,
        coast: Some(CoastFlank {
            mesh: Division::mirrored(&mesh, 0.0),
            transmission_error: error.clone(),
            further: Vec::new(),
        }),
        transmission_error: error,
        ..common::constant_mesh(20e-6, set.stiffness)
    };
    let speed = set.speed;
    Model::new(&structure, &drive, OperatingPoint { load, speed }).unwrap()
}

/// Forces of the springs of pins that are ahead of their positions.
fn pin_forces(set: &Set) -> DVector<f64> {
    let mut forces = DVector::zeros(3 * (3 + set.planets));
    for (planet, error) in PINS[..set.planets].iter().enumerate() {
        let [_, t] = directions(set, planet);
        let force = set.planet.0[2] * error;
        for axis in 0..2 {
            forces[9 + 3 * planet + axis] += force * t[axis];
            forces[3 + axis] -= force * t[axis];
        }
        forces[5] -= force * set.radius;
    }
    forces
}

/// Deflections of all contacts at the start of a cycle, in half gaps.
fn deflections(model: &Model, state: &TrajectoryState) -> Vec<f64> {
    let segments = model.segments_at(state.cycle, 0.0);
    (segments.iter())
        .map(|segment| {
            model
                .deflection_on(segment, state.cycle, &state.state, 0.0)
                .0
        })
        .map(|deflection| deflection / model.half_gap)
        .collect()
}

/// The train with its kernel agrees with the set by hand with the reference: assembly, modes and integration are
/// independent.
#[test]
fn twenty_cycles_are_those_of_a_set_by_hand() {
    let set = Set {
        levels: false,
        ..rattling(3, false)
    };
    let load = 0.16;
    let text = set
        .text()
        .replace("load = 1\n", &format!("load = {load}\n"))
        + &format!(
            "[excitation]\ntransmission_error = [{{ harmonic = 1, amplitude = {ERROR:e} }}]\n"
        );
    let job = job(&text);
    let of_train = build::structure(&job.points.at(0).model).unwrap();
    let (train, hand) = (model(&job), by_hand(&set, &of_train, load));
    assert!((hand.period() / train.period() - 1.0).abs() < 1e-14);
    let mut seen = Events::default();
    let start = train.start(&InitialState::Static);
    let (end, _) = advance_with(&volterra(&train), &start, 20, &mut seen);
    let start = hand.start(&InitialState::Static);
    let exact = Reference::new(&hand).advance(&start, 20).unwrap();
    let apart = (deflections(&train, &end).into_iter())
        .zip(deflections(&hand, &exact.end))
        .map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    println!("{} events, deflections {apart:.1e} half gaps", seen.0.len());
    let found: Vec<_> = seen
        .0
        .iter()
        .map(|own| (own.cycle, own.contact, own.to))
        .collect();
    let known: Vec<_> = (exact.crossings.iter())
        .map(|own| (own.cycle, own.contact, own.to))
        .collect();
    assert_eq!(found, known);
    assert!(found.len() > 20);
    assert!(apart < 1e-10, "{apart:e}");
}

/// Sixteen planets, a clutch with a stage and thrust washers: 82 contacts, of which those after the 64th open and
/// close.
#[test]
fn more_than_64_contacts_are_those_of_the_reference() {
    let set = Set {
        planets: 16,
        teeth: [94, 18, 130],
        radius: 0.12,
        // The tips of the ring stay outside the base circles of the planets.
        pressure_angle: 24.0,
        levels: true,
        speed: 300.0,
        ..Set::lin_parker(16)
    };
    let text = set
        .text()
        .replace("[train]\n", "[train]\ndriver = \"motor\"\n");
    let mut text = text.replace(
        "[[train.planetary]]\n",
        "[[train.shaft]]\nname = \"motor\"\nmotion = \"rotation\"\ndiscs = [{ at = 0, polar_inertia = 1e-3 }]\n\
         [[train.coupling]]\nshafts = [\"motor\", \"input\"]\nat = [0, 0]\ntwist = 5e3\n\
         stages = [{ gap = 0.0199, stiffness = 5e4, damping = 1 }]\n[[train.planetary]]\n",
    );
    for planet in 1..=16 {
        text += &format!(
            "[[train.stop]]\nshaft = \"planet {planet}\"\nat = 0\ndirection = [0, 0, 1]\ngap = \"{} um\"\n\
             stiffness = 1e7\ndamping = 100\n",
            if planet % 2 == 0 { 2 } else { -1 }
        );
    }
    let modes = 6 * (3 + set.planets);
    let model = model(&job(&text.replace(
        &format!("modes = {modes}"),
        &format!("modes = {}", modes + 1),
    )));
    assert_eq!(model.contacts.len(), 82);
    let found = compare(&model, &hardly_disturbed(&model), 1);
    let behind: Vec<_> = found
        .events
        .iter()
        .filter(|contact| **contact >= 64)
        .collect();
    println!(
        "{} events, {} of contacts behind the 64th, states {:.1e} half gaps, times {:.1e} cycles, growth {:.1e}",
        found.events.len(),
        behind.len(),
        found.apart,
        found.late,
        found.growth
    );
    assert!(found.events.len() > 20 && behind.len() > 4);
    assert!(found.apart < 1e-10, "{:e}", found.apart);
}
