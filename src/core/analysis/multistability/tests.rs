//! Initial conditions and shares. `tests/motion/multistability.rs` tests known attractors.

use super::*;
use crate::analysis::outcome::Class;
use crate::model::fixtures::{constant_mesh, structure};
use crate::model::{InitialState, OperatingPoint};
use crate::structure::ModalStructure;

fn probes(seed: u64, initial_conditions: u32, decades: f64) -> Probes {
    let config = MultistabilityConfig {
        initial_conditions,
        decades,
        transient: 0,
        cycles: 320,
        slice: None,
    };
    let point = PointSeed { seed, point_id: 3 };
    Probes::new(&model(), config, point, true).unwrap()
}

pub(super) fn model() -> Model {
    let mesh = [0.8, -0.6, 0.5, 0.1];
    let structure = ModalStructure {
        rated_force: 1.0,
        ..structure(&[0.0, 0.0, 2.0, 3.0], 0.1, &mesh, &mesh)
    };
    let drive = constant_mesh(1.0, 1.0);
    let point = OperatingPoint {
        load: 1.0,
        speed: 1.0,
    };
    Model::new(&structure, &drive, point).unwrap()
}

#[test]
fn energies_fill_their_strata_and_the_neutral_pair_is_left_alone() {
    let model = model();
    let norm = EnergyNorm::new(&model);
    let start = model.start(&InitialState::Static);
    let probes = probes(7, 33, 4.0);
    for probe_id in 0..33 {
        let (amplitude, state) = initial_condition(&model, &norm, &start, &probes, probe_id);
        let distance = norm.distance(&state.state, &start.state) / norm.unit();
        assert!((distance - amplitude).abs() <= 1e-12 * amplitude);
        if probe_id == 0 {
            assert_eq!(state, start);
            continue;
        }
        let stratum = 8.0 * (amplitude.powi(2).log10() + 2.0);
        assert_eq!(stratum.floor() as u32 + 1, probe_id, "{amplitude}");
        let &[neutral] = model.neutral.as_slice() else {
            panic!("{:?}", model.neutral)
        };
        for i in [neutral, neutral + model.modes()] {
            assert_eq!(state.state[i], start.state[i]);
        }
    }
}

#[test]
fn directions_differ_by_seed_and_probe() {
    let model = model();
    let norm = EnergyNorm::new(&model);
    let start = model.start(&InitialState::Static);
    let state = |seed, probe_id| {
        let probes = probes(seed, 8, 0.0);
        initial_condition(&model, &norm, &start, &probes, probe_id).1
    };
    assert_eq!(state(1, 4), state(1, 4));
    assert_ne!(state(1, 4), state(1, 5));
    assert_ne!(state(1, 4), state(2, 4));
}

#[test]
fn shares_add_up_to_one_over_all_endings() {
    let endings = [
        (Some(0), Status::Ok),
        (Some(1), Status::Ok),
        (Some(0), Status::Ok),
        (None, Status::NotConverged),
        (None, Status::Diverged),
        (None, Status::NotConverged),
        (None, Status::EventStorm),
        (Some(0), Status::Ok),
    ];
    let probes: Vec<ProbeOutcome> = endings
        .into_iter()
        .zip(0..)
        .map(|((attractor, status), probe_id)| ProbeOutcome {
            probe_id,
            amplitude: 1.0,
            attractor,
            status,
            reason: String::new(),
            class: None,
            lambda: None,
            lambda_stderr: None,
            deflection_rms: None,
            force_peak: None,
            events_per_cycle: None,
            cycles: 0,
            basin: BasinShare::default(),
        })
        .collect();
    let attractor = AttractorOutcome {
        class: Class::SteadyContact(Some(1)),
        lambda: None,
        lambda_stderr: None,
        chaos_lifetime_low: None,
        deflection_rms: None,
        force_peak: None,
        events_per_cycle: None,
        probes: 0,
        basin: BasinShare::default(),
        cells: None,
        strobe: Vec::new(),
    };
    let mut found = MultistabilityOutcome {
        attractors: vec![attractor; 3],
        probes,
        cells: Vec::new(),
    };
    found.share_out();
    let eighths: Vec<f64> = found.probes.iter().map(|p| 8.0 * p.basin.share).collect();
    assert_eq!(eighths, [3.0, 1.0, 3.0, 2.0, 1.0, 2.0, 1.0, 3.0]);
    let counts: Vec<u32> = found.attractors.iter().map(|a| a.probes).collect();
    // Only a cell of the slice is on the third attractor. No probe is on it, but its true share may be
    // positive.
    assert_eq!(counts, [3, 1, 0]);
    assert_eq!(found.attractors[2].basin.share, 0.0);
    assert!(found.attractors[2].basin.high > 0.3);
    for probe in &found.probes {
        assert!(probe.basin.low < probe.basin.share && probe.basin.share < probe.basin.high);
    }
}
