//! Errors with the period of a gear's revolution (`excitation.gear_error`, `excitation.pitch_deviation`): their form in
//! the model, and kernels with fractional periods. Also flanks of a drawing in a manifest.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use common::advance::{advance, volterra};
use common::relative_difference;
use gearatlas::gear::{Modification, Plane};
use gearatlas::manifest;
use gearatlas::model::{InitialState, Model};
use gearatlas::propagate::{ClosedModes, InstructionSet, Kernel, Stepping};
use gearatlas::reference::Extended;
use std::f64::consts::TAU;
use std::path::Path;

const MANIFEST: &str = include_str!("../../manifests/tiers/torsional.toml");

fn model(excitation: &str, speed: f64, load: f64) -> Model {
    let text = MANIFEST
        .replace("[mesh]", "[mesh]\ncoast_flank = \"same_line\"")
        .replace("[excitation]", &format!("[excitation]\n{excitation}"));
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    let mut point = job.points.at(0);
    (point.speed, point.load) = (speed, load);
    common::parts().model(&point).unwrap()
}

/// Error of the drive flanks at the start of mesh cycles, without the mesh harmonic of the manifest.
fn errors(model: &Model, cycles: u64) -> Vec<f64> {
    let line = &model.lines[model.line(&model.first_cycle().segments[0])];
    (0..cycles)
        .map(|cycle| line.transmission_error_at(cycle, 0.0).0 - 5e-6)
        .collect()
}

/// An order of the wheel's shaft has its period in as many mesh cycles as the wheel has teeth.
#[test]
fn an_error_of_a_gear_goes_with_its_shaft() {
    let error = "gear_error = [{ shaft = \"wheel\", order = 2, amplitude = \"3 um\", phase = \"0.4 rad\" }]";
    let found = errors(&model(error, 1200.0, 0.3), 60);
    for (cycle, found) in found.iter().enumerate() {
        let exact = 3e-6 * (TAU * 2.0 * cycle as f64 / 30.0 + 0.4).cos();
        assert!((found - exact).abs() < 1e-18, "{cycle}");
    }
}

/// Mesh cycle n begins with the deviation of tooth n of either gear, relative to the mean of the gear's teeth.
#[test]
fn pitch_deviations_are_those_of_the_teeth() {
    let pinion: Vec<f64> = (0..20).map(|n| f64::from(n % 7)).collect();
    let wheel: Vec<f64> = (0..30).map(|n| f64::from(n * n % 5)).collect();
    let list = |values: &[f64]| {
        let texts: Vec<String> = values.iter().map(|v| format!("\"{v} um\"")).collect();
        texts.join(", ")
    };
    let deviation = format!(
        "pitch_deviation = {{ pinion = [{}], wheel = [{}] }}",
        list(&pinion),
        list(&wheel)
    );
    let found = errors(&model(&deviation, 1200.0, 0.3), 120);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    for (cycle, found) in found.iter().enumerate() {
        let exact = pinion[cycle % 20] - mean(&pinion) + wheel[cycle % 30] - mean(&wheel);
        assert!(
            (found - 1e-6 * exact).abs() < 1e-17,
            "{cycle}: {found} {exact}"
        );
    }
    let short = MANIFEST.replace(
        "[excitation]",
        "[excitation]\npitch_deviation = { pinion = [0, 1e-6] }",
    );
    let said = format!(
        "{:?}",
        manifest::parse(&short, "m.toml", Path::new("")).unwrap_err()
    );
    assert!(said.contains("2 values for 20 teeth"), "{said}");
}

/// Errors with a fractional number of periods per mesh cycle, through rattle: every kernel compared with thirty digits,
/// in cycles whose numbers are not multiples of the teeth.
#[test]
fn kernels_follow_fractional_turns() {
    let error = "gear_error = [{ shaft = \"pinion\", order = 1, amplitude = \"2 um\" }, \
                 { shaft = \"wheel\", order = 7, amplitude = \"1 um\", phase = \"1 rad\" }]";
    let model = model(error, 1200.0, 0.05);
    let exact = Extended::new(&model);
    let start = advance(&volterra(&model), &model.start(&InitialState::Static), 37);
    let end = exact.advance(&start, 1).unwrap();
    let off = |state: &[f64]| relative_difference(state, &end.end().state);
    fn after<K: Kernel>(kernel: &K, start: &gearatlas::model::TrajectoryState) -> Vec<f64> {
        advance(kernel, start, 1).state
    }
    let closed_modes = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
    let exact_kernels = [
        ("volterra", off(&after(&volterra(&model), &start))),
        ("closed_modes", off(&after(&closed_modes, &start))),
    ];
    for (name, off) in exact_kernels {
        println!("{name}: {off:.1e}");
        assert!(off < 1e-10, "{name}: {off:e}");
    }
    let steps =
        [4_000, 64_000].map(|steps| off(&after(&Stepping::new(&model, steps, 1000), &start)));
    println!("stepping: {steps:?}");
    // If no contact changes in the cycle, both are right to round-off.
    assert!(
        steps[1] < 1e-6 && steps[1] < steps[0].max(1e-11),
        "{steps:?}"
    );
}

/// Crowning, slopes and the plane state of `[gear]` reach the drawing; by default the plane state depends on the width.
#[test]
fn a_manifest_says_what_flanks_are() {
    let form = |gear: &str| {
        let text = MANIFEST.replace("rated_torque =", &format!("{gear}\nrated_torque ="));
        let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
        job.points.at(0).model.source.gears().unwrap().form.clone()
    };
    let given = form(
        "profile_crowning = [\"4 um\", \"2 um\"]\nprofile_slope = \"-3 um\"\nlead_crowning = \"5 um\"\nlead_slope = [0, \"6 um\"]\nplane = \"strain\"",
    );
    let of = |crowning: f64, slope: f64| Modification { crowning, slope };
    assert_eq!(given.profile, [of(4e-6, -3e-6), of(2e-6, -3e-6)]);
    assert_eq!(given.lead, [of(5e-6, 0.0), of(5e-6, 6e-6)]);
    assert_eq!(given.plane, Plane::Strain);
    assert_eq!(form("").plane, Plane::Stress);
    // This width exceeds five tooth thicknesses, 5 π/2 modules.
    let text = MANIFEST.replace("face_width = \"20 mm\"", "face_width = \"32 mm\"");
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    let wide = job.points.at(0).model.source.gears().unwrap().form.plane;
    assert_eq!(wide, Plane::Strain);
}
