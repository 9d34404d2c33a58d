//! A film of oil between approaching flanks: its closed form at the borders of layers and where it stops a mass,
//! restitution compared with the smooth law, the integrator that shares only the model, and tangents compared with
//! differences.

use crate::common;
use common::advance::{Events, advance, advance_with, mean_equilibrium, volterra};
use common::{constant_mesh, drives, relative_difference, structure};
use gearatlas::model::{
    ActiveSet, COAST_FLANK, CoastFlank, DRIVE_FLANK, Division, Drive, Film, FlankError,
    InitialState, Model, OperatingPoint, Release, TrajectoryState,
};
use gearatlas::propagate::varying_speed::{
    MotionObserver, MovingEvent, SpeedInterval, VaryingSpeed,
};
use gearatlas::propagate::{ClosedModes, Counters, InstructionSet, Kernel, TableError, Tangents};
use gearatlas::reference::Reference;

/// Mass \[kg\], half gap \[m\], stiffness \[N/m\] and damping \[N s/m\] of the flanks.
const MASS: f64 = 0.785;
const HALF_GAP: f64 = 80e-6;
const STIFFNESS: f64 = 4e8;
const DAMPING: f64 = 1483.0;

/// Oil of 0.05 Pa s between cylinders of 20 mm, R = 12.8 mm, from 50 to 1 µm.
fn film(layers: usize) -> Film {
    Film {
        coefficient: Film::squeeze_coefficient(0.05, 12.8e-3, 20e-3),
        thickness: [50e-6, 1e-6],
        layers,
    }
}

/// A mass between two flanks with films, under a force \[N\].
fn mass_between(film: Film, force: f64) -> Model {
    let drive = Drive {
        damping: DAMPING,
        film: Some(film),
        ..constant_mesh(HALF_GAP, STIFFNESS)
    };
    let w = MASS.sqrt().recip();
    let mut structure = structure(&[0.0], 0.0, &[w], &[w]);
    structure.rated_force = 1.0;
    let point = OperatingPoint {
        load: force,
        speed: 5.0,
    };
    Model::new(&structure, &drive, point).unwrap()
}

/// The state of the mass at a film thickness \[m\] on the drive side, approaching at some speed \[m/s\].
fn approaching(model: &Model, thickness: f64, speed: f64) -> TrajectoryState {
    let deflection = HALF_GAP - (thickness - 1e-6);
    let state = [deflection, speed].map(|x| x * MASS.sqrt());
    TrajectoryState::new(model, state.to_vec(), 0)
}

/// Remaining speed at a thickness \[m\] according to the law, from 50 µm on.
fn remaining_speed(film: &Film, speed: f64, thickness: f64) -> f64 {
    let lost = thickness.sqrt().recip() - film.thickness[0].sqrt().recip();
    speed - 2.0 * film.coefficient / MASS * lost
}

#[test]
fn speeds_at_the_borders_of_layers_are_those_of_the_law() {
    for layers in [1, 2, 5, 12] {
        let film = film(layers);
        let model = mass_between(film, 0.0);
        let start = approaching(&model, 60e-6, 0.1);
        let mut seen = Events::default();
        advance_with(&volterra(&model), &start, 1, &mut seen);
        let mut thickness = film
            .layers(HALF_GAP)
            .into_iter()
            .map(|own| own.distance[0] + 1e-6);
        for event in &seen.0[..layers] {
            let exact = remaining_speed(&film, 0.1, thickness.next().unwrap());
            assert!(
                (event.rate - exact).abs() < 1e-13,
                "{layers}: {} {exact}",
                event.rate
            );
            assert_eq!(event.to.count(), 1);
        }
        let flank = seen.0[layers];
        assert_eq!((flank.contact, flank.to), (DRIVE_FLANK, ActiveSet::DRIVE));
        assert!((flank.rate - remaining_speed(&film, 0.1, 1e-6)).abs() < 1e-13);
        // No film acts while the mass leaves the flank. The mass then meets the film of the coast flank.
        let [opened, next] = [1, 2].map(|later| seen.0[layers + later]);
        assert_eq!((opened.contact, opened.to), (DRIVE_FLANK, ActiveSet::FREE));
        assert_eq!(next.contact, COAST_FLANK + 2);
        assert!((next.rate - opened.rate).abs() < 1e-13);
    }
}

/// Where the film stops the mass: 3.329 µm at 20 mm/s, which layers approach with the square of their number.
#[test]
fn the_film_stops_slow_masses_where_the_law_does() {
    let root = 50e-6_f64.powf(-0.5) + 0.02 * MASS / (2.0 * film(1).coefficient);
    let exact = root.powi(-2);
    assert!((exact - 3.329e-6).abs() < 1e-9);
    let errors = [4, 8, 16].map(|layers| {
        let model = mass_between(film(layers), 0.0);
        let end = advance(&volterra(&model), &approaching(&model, 50e-6, 0.02), 1);
        let thickness = HALF_GAP + 1e-6 - end.state[0] / MASS.sqrt();
        (thickness - exact).abs()
    });
    println!("stopped off by {errors:?} m");
    assert!(errors[2] < 0.05e-6, "{errors:?}");
    assert!(errors[0] > 6.0 * errors[2], "{errors:?}");
}

/// One step of the classical Runge-Kutta method of `x'' = f(x, x')`.
fn runge_kutta([x, v]: [f64; 2], h: f64, f: &dyn Fn(f64, f64) -> f64) -> [f64; 2] {
    let (k1, l1) = (v, f(x, v));
    let (k2, l2) = (v + 0.5 * h * l1, f(x + 0.5 * h * k1, v + 0.5 * h * l1));
    let (k3, l3) = (v + 0.5 * h * l2, f(x + 0.5 * h * k2, v + 0.5 * h * l2));
    let (k4, l4) = (v + h * l3, f(x + h * k3, v + h * l3));
    [
        x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4),
        v + h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4),
    ]
}

/// Speed at which the flank releases a mass that met the smooth film at 50 µm, by Runge-Kutta steps of a thousandth of
/// the time in which the film closes.
fn rebound_of_the_law(film: &Film, speed: f64, force: f64) -> f64 {
    // x is the film thickness minus 1 µm.
    let squeezed = |x: f64, v: f64| -(film.damping(x + 1e-6) * v + force) / MASS;
    let (mut state, mut before) = ([49e-6, -speed], [0.0; 2]);
    while state[0] > 0.0 {
        before = state;
        let h = 1e-3 * (state[0] + 1e-6) / state[1].abs();
        state = runge_kutta(state, h, &squeezed);
    }
    let part = before[0] / (before[0] - state[0]);
    let mut state = [0.0, before[1] + part * (state[1] - before[1])];
    let sprung = |x: f64, v: f64| -(STIFFNESS * x + DAMPING * v + force) / MASS;
    let h = 1e-4 * (MASS / STIFFNESS).sqrt();
    while state[0] <= 0.0 {
        before = state;
        state = runge_kutta(state, h, &sprung);
    }
    let part = before[0] / (before[0] - state[0]);
    before[1] + part * (state[1] - before[1])
}

/// Under a force of 60 N, the restitution of the layers approximates that of the smooth law at every impact speed.
#[test]
fn restitution_comes_near_that_of_the_smooth_law() {
    let force = 60.0;
    for speed in [0.06, 0.1, 0.3, 1.0] {
        let exact = rebound_of_the_law(&film(1), speed, force) / speed;
        let errors = [2, 4, 8, 16].map(|layers| {
            let model = mass_between(film(layers), force);
            let mut seen = Events::default();
            advance_with(
                &volterra(&model),
                &approaching(&model, 50e-6, speed),
                1,
                &mut seen,
            );
            let opened = |e: &&gearatlas::propagate::Event| e.contact == DRIVE_FLANK && !e.closes();
            let found = -seen.0.iter().find(opened).unwrap().rate / speed;
            (found - exact).abs()
        });
        println!("{speed} m/s: restitution {exact:.4}, errors {errors:?} of 2, 4, 8, 16 layers");
        assert!(errors[3] < 5e-4, "{speed}: {errors:?}");
        assert!(
            errors[0] > 8.0 * errors[2] || errors[0] < 1e-5,
            "{speed}: {errors:?}"
        );
    }
    let fast = rebound_of_the_law(&film(1), 1.0, 0.0);
    let slow = rebound_of_the_law(&film(1), 0.05, 0.0) / 0.05;
    assert!(slow < 0.2 && fast > 0.8, "{slow} {fast}");
}

/// The rattling drives with films as thick as their half gaps.
fn with_films() -> Vec<(&'static str, common::Case)> {
    let mut all = drives();
    for (_, (_, drive, _)) in &mut all {
        drive.film = Some(Film {
            coefficient: 0.5 * Film::squeeze_coefficient(0.02, 12.8e-3, 20e-3),
            thickness: [50e-6, 1e-6],
            layers: 5,
        });
    }
    // The flanks have two lines of action and an error on a part of the cycle, and do not pull.
    let (mut structure, mut drive, point) = all[2].1.clone();
    structure.coast = Some(common::coast_line(&structure));
    drive.release = Release::Force;
    let error = [0.4e-6, 0.0, -0.4e-6, 0.0, 0.0, 0.0, 0.0, 0.0];
    drive.mesh[1].error = FlankError::series(error);
    drive.coast = Some(CoastFlank {
        mesh: Division::mirrored(&drive.mesh, 0.4),
        further: Vec::new(),
        transmission_error: drive.transmission_error.clone(),
    });
    all.push(("two lines", (structure, drive, point)));
    all
}

/// Kernels agree with the independent integrator, cycle by cycle from the same states.
#[test]
fn kernels_follow_the_integrator_that_shares_only_the_model() {
    for (name, (structure, drive, point)) in with_films() {
        for load in [point.load, 0.2] {
            let model = Model::new(&structure, &drive, OperatingPoint { load, ..point }).unwrap();
            let (kernel, reference) = (volterra(&model), Reference::new(&model));
            let moving =
                VaryingSpeed::new(&structure, &model, 1000, InstructionSet::best()).unwrap();
            let mut state = advance(&kernel, &mean_equilibrium(&model), 20);
            let (mut worst, mut late, mut events, mut layers) = (0.0f64, 0.0f64, 0, 0);
            for _ in 0..30 {
                let mut seen = Events::default();
                let (end, _) = advance_with(&kernel, &state, 1, &mut seen);
                let passage = reference.advance(&state, 1).unwrap();
                worst = worst.max(relative_difference(&end.state, &passage.end.state));
                let changes: Vec<_> = seen.0.iter().map(|e| (e.from, e.to)).collect();
                let known: Vec<_> = passage.crossings.iter().map(|c| (c.from, c.to)).collect();
                assert_eq!(changes, known, "{name}");
                for (event, crossing) in seen.0.iter().zip(&passage.crossings) {
                    late = late.max((event.time - crossing.time).abs() / model.period());
                    layers += usize::from(model.is_of_film(event.contact));
                    for flank in [0, 1] {
                        let closed = event.to.iter().filter(|own| own % 2 == flank);
                        assert!(closed.count() <= 1, "{name}: {:?}", event.to);
                    }
                }
                let (moved, changes) = at_steady_speed(&moving, &model, &state);
                assert_eq!(changes.len(), seen.0.len(), "{name}");
                worst = worst.max(relative_difference(&moved, &passage.end.state));
                events += seen.0.len();
                state = end;
            }
            println!(
                "{name}, load {load}: states {worst:.1e}, times {late:.1e}, {events} events, {layers} of layers"
            );
            assert!(layers > 30, "{name}: {layers}");
            assert!(worst < 1e-10 && late < 1e-11, "{name}: {worst:e} {late:e}");
        }
    }
}

/// Closed contacts after each event.
#[derive(Default)]
struct Closed(Vec<ActiveSet>);

impl MotionObserver for Closed {
    fn event(&mut self, event: &MovingEvent) {
        self.0.push(event.to);
    }
}

/// A mesh cycle of the kernel of run-ups, at constant speed.
fn at_steady_speed(
    kernel: &VaryingSpeed,
    model: &Model,
    start: &TrajectoryState,
) -> (Vec<f64>, Vec<ActiveSet>) {
    let speed = 1.0 / (kernel.cycles_per_radian() * model.period());
    let stretch = SpeedInterval::steady(model.period(), speed, model.load);
    let (mut motion, mut seen) = (kernel.start(start), Closed::default());
    let (mut room, mut counters) = (kernel.workspace(), Counters::default());
    kernel
        .advance(&mut motion, &stretch, &mut room, &mut seen, &mut counters)
        .unwrap();
    (motion.state.clone(), seen.0)
}

/// In one degree of freedom states contract by the closed dampers: `ln det = −Σ c t/m`.
#[test]
fn the_map_of_a_cycle_contracts_by_the_closed_dampers() {
    let (_, case) = with_films().swap_remove(0);
    let model = common::model(&case);
    let kernel = volterra(&model);
    let mut trajectory = advance(&kernel, &mean_equilibrium(&model), 20);
    let mut in_layers = 0.0;
    for _ in 0..30 {
        let mut tangents = Tangents::zeros(1, 2);
        (0..2).for_each(|i| tangents.vector_mut(i)[i] = 1.0);
        let (mut room, mut seen) = (kernel.workspace(), Events::default());
        let mut last = (0.0, trajectory.contact);
        let mut counters = Counters::default();
        kernel
            .advance_cycle(
                &mut trajectory,
                &mut tangents,
                &mut room,
                &mut seen,
                &mut counters,
            )
            .unwrap();
        let mut exact = 0.0;
        let ends = seen.0.iter().map(|e| (e.time, e.to));
        for (time, to) in ends.chain([(model.period(), ActiveSet::FREE)]) {
            for contact in last.1.iter() {
                let damping = model.contacts[contact].cycles[0].segments[0].damping;
                let lost = damping * (time - last.0) / model.effective_mass;
                exact -= lost;
                in_layers += if model.is_of_film(contact) { lost } else { 0.0 };
            }
            last = (time, to);
        }
        let [a, b] = [0, 1].map(|i| tangents.vector(i));
        let found = (a[0] * b[1] - a[1] * b[0]).ln();
        assert!((found - exact).abs() < 1e-10, "{found} {exact}");
    }
    assert!(in_layers > 1.0, "{in_layers}");
}

/// Tangents through layers and impacts compared with differences of trajectories.
#[test]
fn tangents_are_derivatives() {
    for (name, case) in with_films().into_iter().take(3) {
        let model = common::model(&case);
        let kernel = volterra(&model);
        let mut start = advance(&kernel, &mean_equilibrium(&model), 20);
        let (dimension, mut compared) = (2 * model.modes(), 0);
        for _ in 0..10 {
            let events = |start: &TrajectoryState| {
                let mut seen = Events::default();
                let (end, _) = advance_with(&kernel, start, 1, &mut seen);
                (end, seen.0.iter().map(|e| e.to).collect::<Vec<_>>())
            };
            let (end, sequence) = events(&start);
            let mut tangents = Tangents::zeros(model.modes(), dimension);
            for i in 0..dimension {
                tangents.vector_mut(i)[i] = 1.0;
            }
            let (mut trajectory, mut room) = (start.clone(), kernel.workspace());
            kernel
                .advance_cycle(
                    &mut trajectory,
                    &mut tangents,
                    &mut room,
                    &mut (),
                    &mut Counters::default(),
                )
                .unwrap();
            assert_eq!(trajectory, end);
            for i in 0..dimension {
                let scale = if i < model.modes() { 1e-12 } else { 1e-8 };
                let beside = [-scale, scale].map(|by| {
                    let mut moved = start.clone();
                    moved.state[i] += by;
                    events(&moved)
                });
                if beside.iter().any(|own| own.1 != sequence) {
                    continue;
                }
                let difference: Vec<f64> = (beside[1].0.state.iter().zip(&beside[0].0.state))
                    .map(|(b, a)| (b - a) / (2.0 * scale))
                    .collect();
                let off = relative_difference(&difference, tangents.vector(i));
                assert!(off < 2e-3, "{name}: column {i} off by {off:e}");
                compared += 1;
            }
            start = end;
        }
        assert!(compared > 5 * dimension, "{name}: {compared}");
    }
}

#[test]
fn other_kernels_refuse_it() {
    let model = mass_between(film(5), 0.0);
    let refused = ClosedModes::new(&model, 100, InstructionSet::best()).err();
    assert_eq!(refused, Some(TableError::Film));
    let rest = model.start(&InitialState::Static);
    assert!(
        gearatlas::reference::Extended::new(&model)
            .advance(&rest, 1)
            .is_err()
    );
}
