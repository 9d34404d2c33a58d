//! Scenes of the benches: drives with any number of modes, their settled trajectories, and the work of a cycle.

use crate::common::{self, Case, default_drive};
use gearatlas::gear::{Flanks, GearPair, MeshTable, MeshTableInputs, ToothForm};
use gearatlas::model::{
    Division, FlankError, InitialState, Model, OperatingPoint, Stiffness, TrajectoryState,
};
use gearatlas::propagate::{Counters, Kernel, Volterra};
use serde_json::{Value, json};

/// Mesh cycles integrated before the timing.
const TRANSIENT: u32 = 200;

/// Cycles over which work is counted.
const COUNTED: u32 = 2000;

/// The default drive with its `modes` lowest modes; beyond 40, copies of its elastic modes, slightly detuned and with a
/// small mesh participation.
pub fn drive(modes: usize, load: f64, speed: f64) -> Case {
    let (mut structure, mesh, _) = common::forty_modes();
    let known = structure.frequency.len();
    for i in known..modes {
        let like = 2 + i % (known - 2);
        let detuning = 1.0 - 5e-4 * (i / known) as f64;
        structure
            .frequency
            .push(detuning * structure.frequency[like]);
        structure.damping.push(structure.damping[like]);
        structure.mesh.push(0.05 * structure.mesh[like]);
        for column in [
            &mut structure.mesh_tilt,
            &mut structure.torque,
            &mut structure.friction,
            &mut structure.friction_lever,
        ] {
            column.push(0.0);
        }
    }
    for column in [
        &mut structure.frequency,
        &mut structure.damping,
        &mut structure.mesh,
        &mut structure.mesh_tilt,
        &mut structure.torque,
        &mut structure.friction,
        &mut structure.friction_lever,
    ] {
        column.truncate(modes);
    }
    (structure, mesh, OperatingPoint { load, speed })
}

/// Full load, no transmission error and a small step of stiffness: the mesh never opens.
pub fn quiet(modes: usize) -> Case {
    let mut case = drive(modes, 1.0, 1200.0);
    case.1.transmission_error.clear();
    case.1.mesh = Division::levels(&[3.4e8, 3.333e8], &[0.6]);
    case
}

/// Rattle with the mesh computed from the gears of the default drive, on stiff bodies: the mean stiffness of equal
/// segments, or the stiffness as it varies. Friction changes its direction at the pitch point.
pub fn computed(segments: Option<usize>) -> Case {
    let mut case = drive(40, 0.05, 1200.0);
    let gears = GearPair {
        form: ToothForm {
            bore: [Some(48e-3), Some(76e-3)],
            ..ToothForm::default()
        },
        ..default_drive::gears()
    };
    let inputs = MeshTableInputs {
        longest_piece: 0.25,
        ..MeshTableInputs::of_gears(&gears)
    };
    let flanks = Flanks::new(&gears).expect("the default gears mesh");
    let table = MeshTable::build(&flanks, &inputs, &|_, _| ()).expect("their load is shared");
    let cycle = table.cycle(0, 0);
    case.1.friction = 0.05;
    case.1.mesh = match segments {
        Some(count) => (1..)
            .zip(cycle.segment_means(count))
            .map(|(number, means)| Division {
                end: f64::from(number) / count as f64,
                stiffness: Stiffness::constant(means.stiffness),
                error: FlankError::NONE,
                load_centre: means.centre,
                friction: [means.friction, means.friction_lever],
            })
            .collect(),
        None => (cycle.pieces().iter())
            .map(|piece| Division {
                end: piece.end,
                stiffness: Stiffness::series(piece.stiffness),
                error: FlankError::NONE,
                load_centre: piece.centre,
                friction: [piece.friction, piece.friction_lever],
            })
            .collect(),
    };
    case
}

/// The structured kernel with a tolerance at round-off.
pub fn volterra(model: &Model) -> Volterra<'_> {
    Volterra::new(model, f64::EPSILON, 1000)
}

/// A trajectory past its transient.
pub fn settled(model: &Model) -> TrajectoryState {
    let mut trajectory = model.start(&InitialState::Static);
    advance(&volterra(model), &mut trajectory, TRANSIENT);
    trajectory
}

fn advance<K: Kernel>(kernel: &K, trajectory: &mut TrajectoryState, cycles: u32) -> Counters {
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    kernel
        .advance(
            u64::from(cycles),
            trajectory,
            &mut workspace,
            &mut (),
            &mut counters,
        )
        .expect("the default drive does not diverge");
    counters
}

/// Counted work of a cycle; asserts that the scene rattles, or that it does not if it should not.
pub fn work(case: &Case) -> Value {
    let model = common::model(case);
    let kernel = volterra(&model);
    let counters = advance(&kernel, &mut settled(&model), COUNTED);
    if model.transmission_errors().next().is_none() {
        assert_eq!(counters.events, 0, "leaves contact");
    } else {
        assert!(counters.events > counters.cycles, "no rattle");
    }
    let a_cycle = |count: u64| count as f64 / f64::from(COUNTED);
    json!({
        "period_ns": 1e9 * model.period(),
        "cells": kernel.windows_per_cycle(),
        "numbers_per_window": kernel.numbers_per_window(),
        "windows": a_cycle(counters.windows),
        "partial_windows": a_cycle(counters.partial_windows),
        "certified": a_cycle(counters.certified),
        "bisections": a_cycle(counters.bisections),
        "newton_steps": a_cycle(counters.newton_steps),
        "events": a_cycle(counters.events),
    })
}
