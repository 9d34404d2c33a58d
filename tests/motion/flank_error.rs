//! The error of loaded flanks in the default drive: relieved or misaligned pairs compared with the load sharing behind
//! the error.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use common::advance::{Events, advance, advance_with, mean_equilibrium, volterra};
use common::{relative_difference, state_difference};
use gearatlas::analysis::EnergyAudit;
use gearatlas::gear::{Face, Flanks, LoadSharing, pairs_at};
use gearatlas::manifest::{self, Job, StiffnessSpec};
use gearatlas::model::{ActiveSet, InitialState, Model, TrajectoryState};
use gearatlas::numerics::legendre::evaluate;
use gearatlas::propagate::{ClosedModes, InstructionSet, Observer, Window};
use gearatlas::reference::{Extended, Reference};
use gearatlas::sweep::Prepared;
use std::path::Path;
use std::process::Command;

/// The default drive with its mesh from a table, its tips relieved by 10 µm over 3 mm.
fn text(edits: &[(&str, &str)]) -> String {
    let text = include_str!("../../manifests/flex80-table.toml");
    let mut text = text.replace("[mesh]", "[mesh]\ncontact = \"linear\"");
    let relieved = (
        "rated_torque =",
        "tip_relief = { amount = \"10 um\", length = \"3 mm\" }\nrated_torque =",
    );
    for (from, to) in [relieved].iter().chain(edits) {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text
}

fn job(edits: &[(&str, &str)]) -> Job {
    manifest::parse(&text(edits), "m.toml", Path::new("")).unwrap()
}

const COURSE: [(&str, &str); 2] = [
    ("stiffness = \"table\" ", "stiffness = \"continuous\" "),
    ("segments = 60", "#"),
];
const FRICTIONLESS: (&str, &str) = ("friction = 0.05", "friction = 0.0");
const QUIET: (&str, &str) = ("amplitude = \"5 um\"", "amplitude = 0");
const MISALIGNED: (&str, &str) = (
    "friction = 0.05",
    "friction = 0.05\nmisalignment = \"0.3 mrad\"",
);

fn model(parts: &Prepared, job: &Job, load: f64, speed: f64) -> Model {
    let mut point = job.points.at(0);
    (point.load, point.speed) = (load, speed);
    parts.model(&point).unwrap()
}

/// Approach of the gears under a mesh force at a mesh phase, by direct load sharing.
fn shared(job: &Job, phase: f64, force: f64) -> f64 {
    let point = job.points.at(0);
    let StiffnessSpec::Table(spec) = &point.mesh.stiffness else {
        panic!("no table");
    };
    let flanks = Flanks::new(&spec.gears).unwrap();
    let face = Face {
        width: spec.gears.face_width,
        slices: 64,
    };
    let pairs = pairs_at(&flanks, phase, face).unwrap();
    let sharing = LoadSharing::new(&pairs, face, point.mesh.misalignment).unwrap();
    sharing.distribute(force).deflection
}

/// Approach in static equilibrium under a mesh force, without half gap, at a mesh phase.
fn approach(model: &Model, phase: f64, force: f64) -> f64 {
    let time = phase * model.period();
    let segment = model.first_cycle().segment_at(time);
    let [gap, _] = model.contacts[0].gap(segment, time);
    force / segment.stiffness_at(phase) + gap - model.half_gap
}

fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    high - low
}

/// At the load of its point the law has the deflection of the flanks, phase by phase.
#[test]
fn static_deflection_is_that_of_shared_load() {
    let parts = common::parts();
    for (name, edits) in [
        ("segments", vec![]),
        ("course", COURSE.to_vec()),
        ("misaligned segments", vec![MISALIGNED]),
        ("misaligned course", [&COURSE[..], &[MISALIGNED]].concat()),
    ] {
        let job = job(&edits);
        for load in [0.2, 1.0] {
            let model = model(&parts, &job, load, 1000.0);
            let force = load * job.points.at(0).model.source.gears().unwrap().rated_force();
            let phases = || (0..400).map(|i| (f64::from(i) + 0.5) / 400.0);
            let truth: Vec<f64> = phases().map(|phase| shared(&job, phase, force)).collect();
            let law: Vec<f64> = phases()
                .map(|phase| approach(&model, phase, force))
                .collect();
            let span = range(truth.iter().copied());
            let off = range(law.iter().zip(&truth).map(|(a, b)| a - b));
            println!(
                "{name}, load {load}: {:.3} um against {:.3} um, off by {:.1e} of it",
                1e6 * range(law.iter().copied()),
                1e6 * span,
                off / span
            );
            // Means of the stiffness over a sixtieth of the cycle are a staircase.
            let bound = match name {
                "segments" => 0.03,
                "misaligned segments" => 0.25,
                // Pieces are joined if the load centroid deviates from its mean by less than 2.5e-4 of a cycle.
                "misaligned course" => 1e-3,
                _ => 1e-9,
            };
            assert!(
                off < bound * span,
                "{name}, load {load}: {off:e} of {span:e}"
            );
        }
    }
}

/// Extremes of δ on the windows.
#[derive(Default)]
struct Seen(Vec<f64>);

impl Observer for Seen {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        for i in 0..=8 {
            let x = f64::from(i) / 4.0 - 1.0;
            self.0.push(evaluate(window.deflection, x));
        }
    }
}

/// A drive in very slow rotation follows the loaded transmission error of its gears; without the error it follows the
/// stiffness alone, two thirds too far.
#[test]
fn a_slow_drive_follows_the_loaded_flanks() {
    let parts = common::parts();
    let moved = |edits: &[(&str, &str)]| {
        let job = job(&[edits, &[FRICTIONLESS, QUIET]].concat());
        let model = model(&parts, &job, 1.0, 10.0);
        let start = advance(&volterra(&model), &model.start(&InitialState::Static), 6);
        let mut seen = Seen::default();
        advance_with(&volterra(&model), &start, 1, &mut seen);
        range(seen.0.into_iter())
    };
    let whole = job(&[]);
    let force = whole
        .points
        .at(0)
        .model
        .source
        .gears()
        .unwrap()
        .rated_force();
    let truth = range((0..400).map(|i| shared(&whole, (f64::from(i) + 0.5) / 400.0, force)));
    let (segments, course) = (moved(&[]), moved(&COURSE));
    let without = moved(&[("torque_ripple =", "table_harmonics = 0\ntorque_ripple =")]);
    println!("{truth:e} {segments:e} {course:e} {without:e}");
    assert!(
        (segments / truth - 1.0).abs() < 0.06,
        "{segments:e} of {truth:e}"
    );
    assert!(
        (course / truth - 1.0).abs() < 0.03,
        "{course:e} of {truth:e}"
    );
    assert!(without > 1.3 * truth, "{without:e} of {truth:e}");
}

/// The kernel compared with both integrators, over cycles of rattle of relieved and misaligned flanks.
#[test]
fn kernels_follow_the_error_to_round_off() {
    let parts = common::parts();
    for edits in [
        vec![],
        COURSE.to_vec(),
        vec![MISALIGNED],
        [&COURSE[..], &[MISALIGNED]].concat(),
    ] {
        let model = model(&parts, &job(&edits), 0.1, 1200.0);
        assert!(model.first_cycle().has_error());
        let kernel = volterra(&model);
        let (reference, extended) = (Reference::new(&model), Extended::new(&model));
        let mut start = advance(&kernel, &model.start(&InitialState::Static), 40);
        let (mut off, mut events) = ([0.0f64; 2], 0);
        for cycle in 0..6 {
            let mut seen = Events::default();
            let (end, _) = advance_with(&kernel, &start, 1, &mut seen);
            let exact = reference.advance(&start, 1).unwrap();
            assert_eq!(seen.0.len(), exact.crossings.len());
            for (a, b) in seen.0.iter().zip(&exact.crossings) {
                assert_eq!((a.from, a.to), (b.from, b.to));
            }
            off[0] = off[0].max(state_difference(&model, &end.state, &exact.end.state));
            if cycle < 2 {
                let exact = extended.advance(&start, 1).unwrap().end();
                off[1] = off[1].max(state_difference(&model, &end.state, &exact.state));
            }
            events += seen.0.len();
            start = end;
        }
        println!("{edits:?}: {off:?}, {events} events");
        assert!(off[0] < 1e-13 && off[1] < 1e-13, "{edits:?}: {off:?}");
        assert!(events > 4, "{edits:?} does not rattle");

        let mut audit = EnergyAudit::new(&model);
        let (end, _) = advance_with(&kernel, &start, 50, &mut audit);
        let residual = audit.residual(&end).unwrap();
        assert!(residual < 1e-11, "{edits:?}: {residual:e}");
    }
}

/// Segments with the full error converge to the stiffness and error in pieces.
#[test]
fn segments_converge_to_the_relieved_course() {
    let parts = common::parts();
    let edited = job(&[COURSE[0], COURSE[1], FRICTIONLESS]);
    let course = model(&parts, &edited, 0.3, 1200.0);
    let start = advance(&volterra(&course), &mean_equilibrium(&course), 60);
    let exact = advance(&volterra(&course), &start, 1);
    let errors = ["60", "240", "960"].map(|count| {
        let count = format!("segments = {count}");
        let segments = job(&[("segments = 60", &count), FRICTIONLESS]);
        let model = model(&parts, &segments, 0.3, 1200.0);
        let start = TrajectoryState::new(&model, start.state.clone(), start.cycle);
        relative_difference(&advance(&volterra(&model), &start, 1).state, &exact.state)
    });
    println!("segments against the relieved course: {errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.5 * pair[0], "{errors:?}");
    }
    assert!(errors[2] < 1e-4, "{errors:?}");
}

/// Table kernels refuse the error of loaded flanks with a remedy; they accept its harmonics, or no error.
#[test]
fn kernels_of_tables_want_a_choice() {
    let parts = common::parts();
    let one_line = (
        "contact_damping =",
        "coast_flank = \"same_line\"\ncontact_damping =",
    );
    let with_error = model(&parts, &job(&[one_line]), 0.1, 1200.0);
    let refused = ClosedModes::new(&with_error, 1000, InstructionSet::best())
        .err()
        .unwrap()
        .to_string();
    assert!(refused.contains("excitation.table_harmonics"), "{refused}");
    for (count, harmonics) in [("0", 0), ("7", 7)] {
        let count = format!("table_harmonics = {count}\ntorque_ripple =");
        let chosen = job(&[QUIET, ("torque_ripple =", &count)]);
        let model = model(&parts, &chosen, 0.1, 1200.0);
        assert!(!model.first_cycle().has_error());
        assert_eq!(model.lines[0].transmission_error.len(), 1 + harmonics);
    }
    // Flanks without relief touch with their tips off the path, which is also an error of the loaded flanks.
    let plain = text(&[(
        "tip_relief = { amount = \"10 um\"",
        "tip_relief = { amount = 0",
    )]);
    let plain = manifest::parse(&plain, "m.toml", Path::new("")).unwrap();
    let plain = model(&parts, &plain, 0.1, 1200.0);
    assert!(plain.first_cycle().has_error() && plain.first_cycle().segments.len() > 60);
    assert_eq!(plain.start(&InitialState::Static).contact, ActiveSet::DRIVE);
}

#[test]
fn check_says_what_excites() {
    let folder = tempfile::tempdir().unwrap();
    let check = |name: &str, text: &str, arguments: &[&str]| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
            .arg("check")
            .args(arguments)
            .arg(&file)
            .output()
            .unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    let said = check("a.toml", &text(&[]), &[]);
    for part in [
        "excited by",
        "stiffness variation of the mesh",
        "error of the loaded flanks (",
        "1 imposed harmonic of transmission error (5.000 µm)",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let left_out = text(&[("torque_ripple =", "table_harmonics = 0\ntorque_ripple =")]);
    let said = check("b.toml", &left_out, &[]);
    assert!(said.contains("table_harmonics = 0 omits"), "{said}");
    let json: serde_json::Value =
        serde_json::from_str(&check("c.toml", &text(&[]), &["--json"])).unwrap();
    let causes = json["excited_by"].as_array().unwrap();
    let error = causes.iter().find(|cause| cause["cause"] == "flank_error");
    let size = error.unwrap()["peak_to_peak"].as_f64().unwrap();
    println!("error of the loaded flanks {size:e} m");
    assert!(size > 1e-8, "{size}");
}
