//! Jumps over constant contact compared with step-by-step integration: equal to round-off while contact lasts, and not
//! used otherwise.

#![allow(clippy::unwrap_used)]

use crate::common;
use crate::leaps::{agrees, loaded, skip};
use common::advance::{advance, advance_with, mean_equilibrium, volterra};
use common::state_difference;
use gearatlas::model::{Division, InitialState};
use std::f64::consts::{PI, TAU};
use std::path::Path;

#[test]
fn a_jump_is_where_marching_comes_to() {
    for (name, case) in common::drives() {
        let case = loaded(case);
        let model = common::model(&case);
        let cycles = 1000 + 50 * model.modes() as u64;
        agrees(name, &model, &volterra(&model), cycles);
    }
}

/// Coast flanks on a separate line, through the blocks, and a drive that coasts.
#[test]
fn flanks_of_their_own_line_and_coasting_drives() {
    let text = include_str!("../../manifests/quickstart.toml");
    let job = gearatlas::manifest::parse(text, "m.toml", Path::new("")).unwrap();
    for load in [3.0, -3.0] {
        let mut point = job.points.at(0);
        point.load = load;
        let model = common::parts().model(&point).unwrap();
        assert!(model.lines.len() > 1);
        let cycles = 1000 + 50 * model.modes() as u64;
        agrees("mirrored", &model, &volterra(&model), cycles);
    }
}

/// A million cycles end at the fixed point.
#[test]
fn a_million_cycles_end_on_the_orbit() {
    let model = common::model(&loaded(common::twenty_modes()));
    let kernel = volterra(&model);
    let (end, jumped) = skip(&model, &kernel, &mean_equilibrium(&model), 1_000_000);
    assert!(jumped > 990_000, "{jumped}");
    let again = advance(&kernel, &end, 1);
    let norm = gearatlas::analysis::EnergyNorm::new(&model);
    let off = norm.distance(&again.state, &end.state) / norm.unit();
    assert!(off < 1e-11, "{off:e}");
}

/// Contact is lost long after the first attempt: every cycle is integrated, to the bit. In resonance with an error e an
/// undamped deflection grows by π e per cycle.
#[test]
fn contact_that_is_lost_later_is_not_jumped() {
    let mut case = common::one_degree();
    case.1.mesh = Division::levels(&[4e8], &[]);
    (case.1.damping, case.2.load) = (2.0, 1.0);
    case.1.transmission_error.truncate(1);
    case.1.transmission_error[0].amplitude = 0.0;
    let model = common::model(&case);
    let gain = model.first_gains()[0];
    let natural = (4e8 * gain.deflection[0] * gain.mesh_input[1]).abs().sqrt();
    let still = model.start(&InitialState::Static);
    let pressed = model.deflection(&still.state, 0.0).0 - model.half_gap;
    case.2.speed *= natural * model.period() / TAU;
    case.1.transmission_error[0].amplitude = pressed / (300.0 * PI);
    let model = common::model(&case);
    let kernel = volterra(&model);
    let start = model.start(&InitialState::Static);
    let (_, early) = advance_with(&kernel, &start, 200, &mut ());
    let (marched, late) = advance_with(&kernel, &start, 1000, &mut ());
    assert!(early.events == 0 && late.events > 0, "{early:?} {late:?}");
    let (found, jumped) = skip(&model, &kernel, &start, 1000);
    assert_eq!(jumped, 0);
    assert_eq!(found, marched);
}

/// One oscillator about its equilibrium: the bound of its amplitude is about 1.9 times the amplitude. At 0.45 of the
/// limit of contact the first attempt jumps, and at 0.7 a jump is possible only after the amplitude has decayed.
#[test]
fn how_far_an_oscillator_swings_is_bounded_closely() {
    let mut case = common::one_degree();
    case.1.mesh = Division::levels(&[4e8], &[]);
    (case.1.damping, case.2.load) = (0.5, 1.0);
    case.1.transmission_error.clear();
    let model = common::model(&case);
    let kernel = volterra(&model);
    let still = model.start(&InitialState::Static);
    let pressed = model.deflection(&still.state, 0.0).0 - model.half_gap;
    for (part, expected) in [(0.45, 1000 - 64), (0.7, 0)] {
        let mut start = still.clone();
        start.state[0] += part * pressed / model.first_gains()[0].deflection[0];
        let (found, jumped) = skip(&model, &kernel, &start, 1000);
        assert_eq!(jumped, expected, "{part}");
        let marched = advance(&kernel, &start, 1000);
        let off = state_difference(&model, &found.state, &marched.state);
        assert!(off < 1e-11, "{off:e}");
    }
}

/// Drives in rattle are integrated without jumps.
#[test]
fn rattle_is_not_jumped() {
    for (name, case) in common::drives() {
        let model = common::model(&case);
        let kernel = volterra(&model);
        let start = mean_equilibrium(&model);
        let (found, jumped) = skip(&model, &kernel, &start, 3000);
        assert_eq!(jumped, 0, "{name}");
        assert_eq!(found, advance(&kernel, &start, 3000), "{name}");
    }
}
