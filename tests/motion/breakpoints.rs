//! Do breakpoints that nearly coincide stop a run, or change its results? For breakpoints of any two quantities, 0,
//! 1e-16, …, 1e-6 of a cycle apart, every kernel needs about as many windows as usual, and the events are those of
//! coinciding breakpoints.

#![allow(clippy::unwrap_used)]

use crate::{program, targets};
use gearatlas::model::InitialState;
use gearatlas::propagate::KernelChoice;
use gearatlas::reference::Reference;
use program::said;
use std::fs;
use targets::breakpoints::{ALL, Case, KERNELS, Of, model, motion, passes};

/// Distances of breakpoints \[cycles\].
fn distances() -> impl Iterator<Item = f64> {
    let sizes = (-16..=-6).flat_map(|power| [1.0, 4.0].map(|digit| digit * 10.0_f64.powi(power)));
    std::iter::once(0.0).chain(sizes.flat_map(|size| [size, -size]))
}

#[test]
fn every_kernel_passes_breakpoints_that_nearly_coincide() {
    let names = KernelChoice::SETTINGS.map(|(name, _)| name);
    assert_eq!(KERNELS.map(|kernel| kernel.name()), names);
    for (kernel, name) in names.iter().enumerate() {
        for of in ALL {
            let mut taken = 0;
            for apart in distances() {
                let place = 19;
                let case = Case {
                    of,
                    place,
                    apart,
                    kernel,
                };
                taken += usize::from(passes(case));
            }
            // Closed modes require constant levels.
            let levels = [Of::Levels, Of::Flanks, Of::Further].contains(&of);
            let takes = ["volterra", "stepping"].contains(name) || levels;
            assert_eq!(taken > 0, takes, "{name} {of:?}");
            assert!(!takes || taken == distances().count(), "{name} {of:?}");
        }
    }
}

/// Events agree with those of an integrator without windows, below and above the distance at which two breakpoints
/// become one.
#[test]
fn events_are_those_of_the_reference() {
    for of in ALL {
        for apart in [0.0, -4e-12, 4e-12, 2e-11, 1e-8, -3.6e-8, 1e-6] {
            let case = Case {
                of,
                place: 12,
                apart,
                kernel: 0,
            };
            let found = motion(case).unwrap().unwrap();
            let model = model(case);
            let start = model.start(&InitialState::Static);
            let known = Reference::new(&model).advance(&start, 3).unwrap();
            assert!(known.crossings.len() > 3, "{case:?}");
            assert_eq!(found.events.len(), known.crossings.len(), "{case:?}");
            for (own, known) in found.events.iter().zip(&known.crossings) {
                let time = known.cycle as f64 + known.time / model.period();
                assert!((own.0 - time).abs() < 1e-8, "{case:?}: {} {time}", own.0);
                assert_eq!(own.1, known.contact, "{case:?}");
            }
        }
    }
}

/// A geared pair whose coast flanks have their kinks 4e-12 of a cycle off those of the drive flanks, from a symmetry of
/// twelve digits. It has the events of a symmetry of 0.27841915169, where they coincide (262 in 20 cycles). Kinks
/// farther apart are other drives, with similarly strong chaos.
#[test]
fn a_symmetry_of_twelve_digits_is_as_good_as_an_exact_one() {
    let folder = tempfile::tempdir().unwrap();
    let modal = include_str!("../manifests/geared-pair.modal.toml");
    fs::write(folder.path().join("geared-pair.modal.toml"), modal).unwrap();
    let manifest = r#"
        job.name = "mirrored"
        model = { kind = "modal", file = "geared-pair.modal.toml" }
        mesh = { half_gap = "20 um", stiffness = "continuous", mean_stiffness = 518946101.125, contact_ratio = 1.55683830338, single_pair_drop = 0.442214990094, contact_damping = "20000 N*s/m" }
        excitation.transmission_error = [{ harmonic = 5, amplitude = "20 um", phase = "-90 deg" }]
        grid = { load = 0.0, speed = "2000 rpm" }
        run = { transient = 20, cycles = 20 }
    "#;
    fs::write(folder.path().join("m.toml"), manifest).unwrap();
    // The kinks are 4e-12, 0, 3.6e-8 and 1.7e-6 of a cycle apart.
    let mut found = Vec::new();
    for symmetry in ["0.278419151688", "0.27841915169", "0.278419169", "0.27842"] {
        let set = format!("mesh.coast_symmetry={symmetry}");
        let run = [
            "run",
            "m.toml",
            "--overwrite",
            "--out",
            "out",
            "--set",
            &set,
        ];
        said(folder.path(), &run);
        let column = ["--tables", "points", "--columns", "events_per_cycle"];
        let export = ["export", "out", "--out", "csv", "--overwrite"];
        said(folder.path(), &[&export[..], &column].concat());
        let csv = fs::read_to_string(folder.path().join("csv/points.csv")).unwrap();
        let events = csv.lines().last().unwrap();
        found.push(events.parse::<f64>().unwrap());
    }
    assert!((found[0] - found[1]).abs() < 0.15, "{found:?}");
    let lively = |events: &f64| (11.0..16.0).contains(events);
    assert!(found.iter().all(lively), "{found:?}");
}
