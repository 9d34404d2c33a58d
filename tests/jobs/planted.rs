//! Are motions of known kind classified correctly? One- and two-degree oscillators with known attractors, for twenty
//! seeds each. The kind is known from a closed form or from a long integration by the reference integrator, which
//! shares no code with the kernels. Shares are known from a dense set of initial states, each integrated to the end, or
//! from a symmetry.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, advance_with, mean_equilibrium, volterra};
use gearatlas::analysis::{
    Class, EnergyNorm, MultistabilityConfig, MultistabilityOutcome, Probes, SliceConfig, SliceOf,
    probe_basins,
};
use gearatlas::model::{
    Drive, DriveShaft, MeshHarmonic, Model, OperatingPoint, TorqueRipple, TrajectoryState,
};
use gearatlas::numerics::random::PointSeed;
use gearatlas::reference::Reference;
use std::f64::consts::{PI, TAU};
use std::sync::atomic::AtomicBool;

const SEEDS: u64 = 20;

/// A rigid relative rotation with modal participation 1, and elastic modes with the same participation.
fn drive(elastic: &[f64], load: f64, speed: f64, error: f64) -> Model {
    let frequency: Vec<f64> = [0.0].iter().chain(elastic).copied().collect();
    let mesh = vec![1.0; frequency.len()];
    let structure = common::structure(&frequency, 0.01, &mesh, &mesh);
    let drive = Drive {
        damping: 1483.0,
        transmission_error: if error > 0.0 {
            vec![MeshHarmonic::new(1, error, 0.0)]
        } else {
            Vec::new()
        },
        ..common::constant_mesh(10e-6, 4e8)
    };
    Model::new(&structure, &drive, OperatingPoint { load, speed }).unwrap()
}

/// Only the relative rotation, under a transmission error of 2 µm.
fn one_degree(load: f64, speed: f64) -> Model {
    drive(&[], load, speed, 2e-6)
}

fn question(initial_conditions: u32, decades: f64) -> MultistabilityConfig {
    MultistabilityConfig {
        initial_conditions,
        decades,
        transient: 300,
        cycles: 1500,
        slice: None,
    }
}

fn probes(model: &Model, seed: u64, question: MultistabilityConfig) -> Probes {
    Probes::new(model, question, PointSeed { seed, point_id: 0 }, true).unwrap()
}

fn ask(model: &Model, seed: u64, question: MultistabilityConfig) -> MultistabilityOutcome {
    let start = mean_equilibrium(model);
    let interrupt = AtomicBool::new(false);
    let probes = probes(model, seed, question);
    probe_basins(model, &volterra(model), &start, &probes, &interrupt).unwrap()
}

fn probe(model: &Model, seed: u64, initial_conditions: u32, decades: f64) -> MultistabilityOutcome {
    ask(model, seed, question(initial_conditions, decades))
}

/// Asserts that probes find one attractor, of this class, for every seed.
fn is_called(model: &Model, class: Class) {
    for seed in 0..SEEDS {
        let found = probe(model, seed, 3, 1.0);
        let classes: Vec<Option<Class>> = found.probes.iter().map(|p| p.class).collect();
        assert_eq!(classes, [Some(class); 3], "seed {seed}: {:?}", found.probes);
        assert_eq!(
            found.attractors.len(),
            1,
            "seed {seed}: {:?}",
            found.attractors
        );
    }
}

/// Like [`is_called`], only for the motion from near static equilibrium: these drives have other attractors, which
/// probes would find.
fn is_called_near_equilibrium(model: &Model, class: Class) {
    let norm = EnergyNorm::new(model);
    for seed in 0..SEEDS {
        let mut start = mean_equilibrium(model);
        let (sin, cos) = (seed as f64).sin_cos();
        start.state[0] += 1e-2 * norm.unit() * cos / norm.weights()[0];
        start.state[1] += 1e-2 * norm.unit() * sin / norm.weights()[1];
        let interrupt = AtomicBool::new(false);
        let probes = probes(model, seed, question(1, 0.0));
        let found = probe_basins(model, &volterra(model), &start, &probes, &interrupt).unwrap();
        assert_eq!(
            found.probes[0].class,
            Some(class),
            "seed {seed}: {:?}",
            found.probes
        );
        assert_eq!(found.probes[0].basin.share, 1.0);
    }
}

/// Strobe states of the reference integrator after a transient.
fn brute(model: &Model, transient: u64, cycles: u64) -> Vec<Vec<f64>> {
    let reference = Reference::new(model);
    let start = mean_equilibrium(model);
    let mut at = reference.advance(&start, transient).unwrap().end;
    (0..cycles)
        .map(|_| {
            at = reference.advance(&at, 1).unwrap().end;
            at.state.clone()
        })
        .collect()
}

/// Distance \[half gaps\] of the last state from the one `back` cycles before.
fn apart(model: &Model, states: &[Vec<f64>], back: usize) -> f64 {
    let norm = EnergyNorm::new(model);
    let last = states.len() - 1;
    norm.distance(&states[last], &states[last - back]) / norm.unit()
}

/// Asserts that the reference integrator's motion repeats after `period` cycles and not earlier.
fn repeats(model: &Model, period: usize) {
    let states = brute(model, 400, period as u64 + 1);
    for back in 1..period {
        assert!(apart(model, &states, back) > 1e-4, "{back}");
    }
    assert!(apart(model, &states, period) < 1e-8);
}

/// Growth of the distance of two neighbours over some cycles of the reference integrator, and
/// the nearest return within 40 cycles.
fn growth_and_return(model: &Model, cycles: u64) -> (f64, f64) {
    let states = brute(model, 400, 42);
    let returns = (1..41).map(|back| apart(model, &states, back));
    let nearest = returns.fold(f64::INFINITY, f64::min);
    let norm = EnergyNorm::new(model);
    let reference = Reference::new(model);
    let end = |state: Vec<f64>| {
        let start = TrajectoryState::new(model, state, 0);
        reference.advance(&start, cycles).unwrap().end.state
    };
    let here = states.last().unwrap().clone();
    let mut there = here.clone();
    let first = 1e-7 * norm.unit();
    there[0] += first / norm.weights()[0];
    (norm.distance(&end(here), &end(there)) / first, nearest)
}

/// Without excitation: the static equilibrium, whose exponent is half the trace of the closed mesh, `−c/2` per second
/// for unit participation.
#[test]
fn a_fixed_point_is_steady_contact() {
    let model = drive(&[], 1.0, 900.0, 0.0);
    is_called(&model, Class::SteadyContact(Some(1)));
    let found = probe(&model, 0, 3, 1.0);
    let exponent = -0.5 * 1483.0 * model.period();
    let attractor = &found.attractors[0];
    assert!((attractor.lambda.unwrap() / exponent - 1.0).abs() < 1e-6);
    assert!(attractor.deflection_rms.unwrap() < 1e-15);
    let force = attractor.force_peak.unwrap();
    assert!((force / 1330.0 - 1.0).abs() < 1e-9, "{force}");
}

#[test]
fn a_cascade_of_doubled_periods_ends_in_chaos() {
    for (load, period) in [(0.5, 1), (0.4455, 2), (0.3909, 4)] {
        let model = one_degree(load, 1000.0);
        repeats(&model, period);
        is_called_near_equilibrium(&model, Class::Periodic(period as u32));
    }
    let model = one_degree(0.3727, 1000.0);
    let (growth, nearest) = growth_and_return(&model, 30);
    assert!(growth > 100.0 && nearest > 1e-4, "{growth} {nearest}");
    is_called_near_equilibrium(&model, Class::Chaotic);
}

#[test]
fn a_third_of_the_mesh_frequency_is_period_three() {
    let model = one_degree(0.3, 1430.0);
    repeats(&model, 3);
    is_called(&model, Class::Periodic(3));
}

#[test]
fn a_chaotic_band() {
    for speed in [1320.0, 1480.0] {
        let model = one_degree(0.5, speed);
        let (growth, nearest) = growth_and_return(&model, 30);
        assert!(growth > 100.0 && nearest > 1e-4, "{growth} {nearest}");
        is_called(&model, Class::Chaotic);
    }
}

/// A torus: neighbours stay neighbours, and no state returns.
#[test]
fn two_degrees_on_a_torus_are_quasi_periodic() {
    let model = drive(&[20_000.0], 0.5, 700.0, 2e-6);
    let (growth, nearest) = growth_and_return(&model, 100);
    assert!(growth < 10.0 && nearest > 1e-4, "{growth} {nearest}");
    // A long record is needed: the torus attracts slowly, and the average of its exponent converges slowly.
    let long = |question| MultistabilityConfig {
        transient: 1000,
        cycles: 3000,
        ..question
    };
    for seed in 0..SEEDS {
        let found = ask(&model, seed, long(question(2, 1.0)));
        for probe in &found.probes {
            assert_eq!(
                probe.class,
                Some(Class::QuasiPeriodic),
                "seed {seed}: {probe:?}"
            );
        }
        assert_eq!(
            found.attractors.len(),
            1,
            "seed {seed}: {:?}",
            found.attractors
        );
    }
}

/// Shares of the final motions from dense initial states with the probes' measure. Motions are distinguished by the
/// events of the last twelve cycles and by whether they repeat every cycle.
fn brute_shares(model: &Model, decades: f64) -> Vec<((u64, bool), f64)> {
    const ENERGIES: usize = 40;
    const DIRECTIONS: usize = 30;
    let norm = EnergyNorm::new(model);
    let start = mean_equilibrium(model);
    let kernel = volterra(model);
    let mut counts: Vec<((u64, bool), usize)> = Vec::new();
    for energy in 0..ENERGIES {
        let position = (energy as f64 + 0.5) / ENERGIES as f64;
        let amplitude = 10f64.powf(0.5 * decades * (position - 0.5)) * norm.unit();
        for direction in 0..DIRECTIONS {
            // Directions are shifted from ring to ring, so that rays are not aligned.
            let shift = 0.618 * energy as f64;
            let angle = TAU * (direction as f64 + shift) / DIRECTIONS as f64;
            let mut state = start.state.clone();
            state[0] += amplitude * angle.cos() / norm.weights()[0];
            state[1] += amplitude * angle.sin() / norm.weights()[1];
            let settled = advance(&kernel, &TrajectoryState::new(model, state, 0), 400);
            let (end, counters) = advance_with(&kernel, &settled, 12, &mut ());
            let next = advance(&kernel, &end, 1);
            let repeats = norm.distance(&next.state, &end.state) < 1e-6 * norm.unit();
            let ending = (counters.events, repeats);
            match counts.iter_mut().find(|(known, _)| *known == ending) {
                Some((_, count)) => *count += 1,
                None => counts.push((ending, 1)),
            }
        }
    }
    let all = (ENERGIES * DIRECTIONS) as f64;
    let shares = counts
        .into_iter()
        .map(|(ending, n)| (ending, n as f64 / all));
    shares.collect()
}

/// Asserts that the shares found by the probes of twenty seeds equal those of the dense set.
fn has_shares(model: &Model, attractors: usize) {
    const PROBES: u32 = 24;
    let shares = brute_shares(model, 4.0);
    assert_eq!(shares.len(), attractors, "{shares:?}");
    let mut on = vec![0_u32; attractors];
    let mut covering = vec![0_u32; attractors];
    for seed in 0..SEEDS {
        let found = probe(model, seed, PROBES, 4.0);
        // A few probes may miss a small basin, but must not find anything else.
        let mut met = 0;
        for (place, ((events, repeats), share)) in shares.iter().enumerate() {
            let same = found.attractors.iter().find(|a| {
                let per_cycle = *events as f64 / 12.0;
                (a.events_per_cycle.unwrap() - per_cycle).abs() < 0.02
                    && (a.class.period() == Some(1)) == *repeats
            });
            let basin = same.map(|a| (a.probes, a.basin.low, a.basin.high));
            met += usize::from(basin.is_some());
            let (count, low, high) = basin.unwrap_or((0, 0.0, 0.14));
            on[place] += count;
            covering[place] += u32::from((low..=high).contains(share));
        }
        assert_eq!(
            met,
            found.attractors.len(),
            "seed {seed}: {:?}",
            found.attractors
        );
    }
    let trials = SEEDS as f64 * f64::from(PROBES);
    for (place, (_, share)) in shares.iter().enumerate() {
        let deviation = (share * (1.0 - share) / trials).sqrt();
        let found = f64::from(on[place]) / trials;
        // Probe 0 is not random: bias of 1/24.
        let bias = 1.0 / f64::from(PROBES);
        assert!(
            (found - share).abs() < 4.0 * deviation + bias,
            "{found} {share}"
        );
        assert!(covering[place] >= 16, "{covering:?} {shares:?}");
    }
}

#[test]
fn two_attractors_have_their_shares() {
    has_shares(&one_degree(0.5, 880.0), 2);
}

#[test]
fn three_attractors_have_their_shares() {
    has_shares(&one_degree(0.5, 600.0), 3);
}

/// Between symmetric stops without load, `x → −x` maps the drive to the one with opposite excitation, an orbit to its
/// mirror image, and a cell of a slice to the opposite cell. Exactly half the cells of both drives end on either orbit.
#[test]
fn mirror_images_share_the_cells() {
    const COUNT: u32 = 16;
    let found = [0.0, PI].map(|phase| {
        let model = shaken(phase);
        let slice = SliceConfig {
            modes: [0, 1],
            of: SliceOf::Displacement,
            extent: 9e-6,
            speed: None,
            count: COUNT,
        };
        let config = MultistabilityConfig {
            slice: Some(slice),
            ..question(8, 4.0)
        };
        ask(&model, 0, config)
    });
    let [ahead, behind] = &found;
    assert_eq!([ahead.attractors.len(), behind.attractors.len()], [2, 2]);
    let place =
        |outcome: &MultistabilityOutcome, id: u32| outcome.attractors[id as usize].strobe[0];
    let opposite = |id: u32| {
        let [x, y] = place(ahead, id);
        let near = |other: &u32| {
            let [u, v] = place(behind, *other);
            (x + u).abs().max((y + v).abs()) < 1e-9 * x.abs().max(y.abs())
        };
        (0..2).find(near).unwrap()
    };
    assert_ne!(opposite(0), opposite(1));
    for (cell, mirrored) in ahead.cells.iter().zip(behind.cells.iter().rev()) {
        assert_eq!(
            [cell.column, cell.row],
            [mirrored.column, mirrored.row].map(|i| COUNT - 1 - i)
        );
        assert_eq!(mirrored.attractor, cell.attractor.map(opposite), "{cell:?}");
    }
    // The upper orbit in one drive corresponds to the lower orbit in the other.
    let upper = |outcome: &MultistabilityOutcome| -> u32 {
        let above = |id: u32| place(outcome, id)[0] > place(outcome, 1 - id)[0];
        let ids = (0..2).filter(|id| above(*id));
        ids.map(|id| outcome.attractors[id as usize].cells.unwrap())
            .sum()
    };
    assert_eq!(upper(ahead) + upper(behind), COUNT * COUNT);
    assert!(upper(ahead) > 10 && upper(behind) > 10);
}

/// Two modes between stops, with excitation of the first at the mesh frequency.
fn shaken(phase: f64) -> Model {
    let mesh = [1.0, 0.2];
    let mut structure = common::structure(&[4000.0, 30_000.0], 0.02, &mesh, &[0.0; 2]);
    structure.pinion_torque = Some(vec![56.0, 0.0]);
    let drive = Drive {
        damping: 480.0,
        // Order 20 of a shaft with 20 teeth: the mesh frequency.
        torque_ripple: vec![TorqueRipple {
            shaft: DriveShaft::Pinion,
            order: 20.0,
            amplitude: 1.0,
            phase,
        }],
        ..common::constant_mesh(3e-6, 1.44e8)
    };
    let point = OperatingPoint {
        load: 1.0,
        speed: 160.0,
    };
    Model::new(&structure, &drive, point).unwrap()
}
