//! `atlas trace` through the real program: the contents of the files compared with the kernel, the contact law and the
//! reference integrator; and messages about a bad `--point`.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::relative_difference;
use gearatlas::manifest::{self, Job};
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::propagate::{Counters, Event, Kernel, Observer, Volterra};
use gearatlas::reference::Reference;
use gearatlas::store::{ResultTable, TableKind};
use gearatlas::structure::ModalStructure;
use gearatlas::sweep::build;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// The quickstart drive with both flanks on one line, as the tests assume, and with the structured kernel.
static QUICKSTART: LazyLock<String> = LazyLock::new(|| {
    let text = include_str!("../../manifests/quickstart.toml");
    text.replacen("[mesh]", "[mesh]\ncoast_flank = \"same_line\"\n#", 1)
        .replacen("[run]", "[run]\nkernel = \"volterra\"\n#", 1)
});

/// Light load and high speed: rattles on both flanks.
const POINT: &str = "load=0.05,speed=1200";

fn trace(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_atlas"))
        .arg("trace")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs `atlas trace` on a manifest's text, files in `out`, and returns the JSON summary.
fn traced(folder: &Path, text: &str, arguments: &[&str]) -> serde_json::Value {
    std::fs::write(folder.join("m.toml"), text).unwrap();
    let fixed = ["m.toml", "--json", "--overwrite", "--out", "out"];
    let output = trace(folder, &[&fixed, arguments].concat());
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert_eq!(message, "");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn job(text: &str) -> Job {
    manifest::parse(text, "m.toml", Path::new("")).unwrap()
}

/// Structure and model of a point of the quickstart drive.
fn model(load: f64, speed: f64) -> (ModalStructure, Model) {
    let mut point = job(&QUICKSTART).points.at(0);
    (point.load, point.speed) = (load, speed);
    let structure = build::structure(&point.model).unwrap();
    let model = common::parts().model(&point).unwrap();
    (structure.clone(), model)
}

fn kernel(model: &Model) -> Volterra<'_> {
    let run = &job(&QUICKSTART).points.at(0).run;
    Volterra::new(model, f64::EPSILON, run.event_limit)
}

/// The columns of `trace.parquet` that every trace has.
struct Samples {
    time: Vec<f64>,
    cycle: Vec<u64>,
    phase: Vec<f64>,
    deflection: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
    contact: Vec<String>,
}

fn whole<T>(column: Vec<Option<T>>) -> Vec<T> {
    column.into_iter().map(Option::unwrap).collect()
}

fn samples(folder: &Path) -> Samples {
    let table = ResultTable::read(&folder.join("out"), TableKind::Trace).unwrap();
    let number = |name: &str| whole(table.f64(name).unwrap());
    Samples {
        time: number("time"),
        cycle: whole(table.u64("cycle").unwrap()),
        phase: number("phase"),
        deflection: number("deflection"),
        velocity: number("velocity"),
        force: number("force"),
        contact: whole(table.text("contact").unwrap()),
    }
}

/// Rows of a modal column.
fn modal(folder: &Path, name: &str) -> Vec<Vec<f64>> {
    let table = ResultTable::read(&folder.join("out"), TableKind::Trace).unwrap();
    let rows = whole(table.lists(name).unwrap());
    rows.into_iter().map(whole).collect()
}

/// Events from a kernel.
#[derive(Default)]
struct Events(Vec<Event>);

impl Observer for Events {
    const WINDOWS: bool = true;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

fn advance(model: &Model, trajectory: &mut TrajectoryState, cycles: u64, events: &mut Events) {
    let kernel = kernel(model);
    let mut workspace = kernel.workspace();
    kernel
        .advance(
            cycles,
            trajectory,
            &mut workspace,
            events,
            &mut Counters::default(),
        )
        .unwrap();
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| f64::max(m, v.abs()))
}

#[test]
fn both_files_say_what_their_columns_are() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--point", POINT, "--cycles", "1", "--skip", "0", "--modal"];
    traced(folder.path(), &QUICKSTART, &arguments);
    let units = |kind| {
        let table = ResultTable::read(&folder.path().join("out"), kind).unwrap();
        let units = table.units().unwrap();
        let pairs: Vec<String> = units.iter().map(|(n, u)| format!("{n} [{u}]")).collect();
        pairs.join(", ")
    };
    assert_eq!(
        units(TableKind::Trace),
        "bearing_pinion_1_axial [N], bearing_pinion_1_x [N], bearing_pinion_1_y [N], bearing_pinion_2_x [N], \
         bearing_pinion_2_y [N], bearing_wheel_1_axial [N], bearing_wheel_1_x [N], bearing_wheel_1_y [N], \
         bearing_wheel_2_x [N], bearing_wheel_2_y [N], closed [], closed_from_65 [], contact [], cycle [mesh cycles], deflection [m], displacement [m sqrt(kg)], force [N], \
         modal_velocity [m sqrt(kg)/s], phase [1], time [s], velocity [m/s]"
    );
    assert_eq!(
        units(TableKind::Events),
        "contact [], cycle [mesh cycles], kind [], phase [1], rate [m/s], time [s]"
    );
    // Without --modal there are no modal columns.
    traced(folder.path(), &QUICKSTART, &arguments[..6]);
    let table = ResultTable::read(&folder.path().join("out"), TableKind::Trace).unwrap();
    assert!(table.lists("displacement").is_err());
}

#[test]
fn samples_are_even_and_start_where_the_transient_ends() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--point", POINT, "--cycles", "3", "--samples-per-cycle"];
    let summary = traced(
        folder.path(),
        &QUICKSTART,
        &[&arguments[..], &["7"]].concat(),
    );
    let (_, model) = model(0.05, 1200.0);
    let transient = job(&QUICKSTART).points.at(0).run.transient;
    let s = samples(folder.path());
    assert_eq!(s.time.len(), 21);
    assert_eq!(summary["samples"], 21);
    for row in 0..21 {
        assert_eq!(s.cycle[row], transient + row as u64 / 7);
        assert_eq!(s.phase[row], (row % 7) as f64 / 7.0);
        let exact = (transient as f64 + row as f64 / 7.0) * model.period();
        assert!((s.time[row] - exact).abs() < 1e-14 * exact);
    }
}

#[test]
fn events_are_those_of_the_kernel() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--point", POINT, "--cycles", "15", "--skip", "10"];
    let summary = traced(folder.path(), &QUICKSTART, &arguments);
    let table = ResultTable::read(&folder.path().join("out"), TableKind::Events).unwrap();
    let number = |name: &str| whole(table.f64(name).unwrap());
    let (time, phase, rate) = (number("time"), number("phase"), number("rate"));
    let cycle = whole(table.u64("cycle").unwrap());
    let text = |name: &str| whole(table.text(name).unwrap());
    let (kind, contact) = (text("kind"), whole(table.u64("contact").unwrap()));

    let (_, model) = model(0.05, 1200.0);
    let mut trajectory = model.start(&gearatlas::model::InitialState::Static);
    advance(&model, &mut trajectory, 10, &mut Events::default());
    let mut events = Events::default();
    advance(&model, &mut trajectory, 15, &mut events);
    let events = events.0;
    assert!(events.len() > 30, "{} events: no rattle", events.len());
    assert_eq!(summary["events"], events.len());
    assert_eq!(time.len(), events.len());
    for (row, event) in events.iter().enumerate() {
        assert_eq!((cycle[row], rate[row]), (event.cycle, event.rate));
        assert_eq!(phase[row], event.time / model.period());
        let exact = event.cycle as f64 * model.period() + event.time;
        assert!((time[row] - exact).abs() < 1e-15 * exact);
        let kinds = format!("{}>{}", event.from.name(), event.to.name());
        let wanted = match kinds.as_str() {
            "free>drive" => ("drive_entry", 1, 1.0),
            "drive>free" => ("drive_release", 1, -1.0),
            "free>coast" => ("coast_entry", 2, -1.0),
            "coast>free" => ("coast_release", 2, 1.0),
            other => panic!("{other}"),
        };
        assert_eq!((kind[row].as_str(), contact[row]), (wanted.0, wanted.1));
        assert_eq!(rate[row].signum(), wanted.2, "{}", kind[row]);
    }
    for wanted in [
        "drive_entry",
        "drive_release",
        "coast_entry",
        "coast_release",
    ] {
        assert!(kind.iter().any(|k| k == wanted), "no {wanted}");
    }
}

/// Asserts `F = k (δ − s b) + c δ'` for every sample; counts those in drive, free and coast.
fn assert_contact_law(s: &Samples, model: &Model) -> [u64; 3] {
    let b = model.half_gap;
    let largest_force = largest(&s.force);
    let mut seen = [0; 3];
    for row in 0..s.time.len() {
        let (d, v, f) = (s.deflection[row], s.velocity[row], s.force[row]);
        let holds = |g: &&gearatlas::model::Segment| g.end > s.phase[row] + 1e-11;
        let segment = model.first_cycle().segments.iter().find(holds).unwrap();
        let (side, index) = match s.contact[row].as_str() {
            "drive" => (1.0, 0),
            "free" => (0.0, 1),
            "coast" => (-1.0, 2),
            other => panic!("contact state {other}"),
        };
        seen[index] += 1;
        if side == 0.0 {
            assert!(d.abs() <= b * (1.0 + 1e-12), "free at {d}");
            assert_eq!(f, 0.0);
        } else {
            assert!(side * d >= b * (1.0 - 1e-12), "{} at {d}", s.contact[row]);
            let law = segment.stiffness.mean() * (d - side * b) + segment.damping * v;
            assert!(
                (f - law).abs() < 1e-9 * largest_force,
                "row {row}: {f} {law}"
            );
        }
    }
    seen
}

#[test]
fn deflection_velocity_and_force_fit_together() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--point", POINT, "--cycles", "12", "--skip", "20"];
    let fine = ["--samples-per-cycle", "1024"];
    let summary = traced(
        folder.path(),
        &QUICKSTART,
        &[&arguments[..], &fine].concat(),
    );
    let (_, model) = model(0.05, 1200.0);
    let s = samples(folder.path());
    let step = model.period() / 1024.0;
    let fastest = largest(&s.velocity);
    let largest_force = largest(&s.force);
    for row in 0..s.time.len() {
        // Between samples the deflection changes according to the velocity, across borders of windows and events:
        // acceleration may jump, by c w² δ' at an entry.
        if row > 0 {
            let mean = 0.5 * (s.velocity[row - 1] + s.velocity[row]);
            let moved = (s.deflection[row] - s.deflection[row - 1]) / step;
            assert!(
                (moved - mean).abs() < 1e-3 * fastest,
                "row {row}: {moved} {mean}"
            );
        }
    }
    let seen = assert_contact_law(&s, &model);
    assert!(seen.iter().all(|n| *n > 100), "{seen:?}");
    // The summary's fractions come from the windows; samples only approximate them.
    for (name, count) in ["fraction_drive", "fraction_free", "fraction_coast"]
        .iter()
        .zip(seen)
    {
        let fraction = summary[name].as_f64().unwrap();
        let counted = count as f64 / s.time.len() as f64;
        assert!(
            (fraction - counted).abs() < 2e-3,
            "{name}: {fraction} {counted}"
        );
    }
    let peak = summary["force_peak"].as_f64().unwrap();
    assert!(peak >= largest_force * (1.0 - 1e-12));
    assert!(peak < largest_force * 1.01, "{peak} {largest_force}");
}

#[test]
fn a_sample_on_a_stiffness_step_shows_the_new_stiffness() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--point", POINT, "--cycles", "200", "--skip", "20"];
    // Every step of the quickstart's mesh is at a multiple of a fifth of the cycle.
    let coarse = ["--samples-per-cycle", "5"];
    traced(
        folder.path(),
        &QUICKSTART,
        &[&arguments[..], &coarse].concat(),
    );
    let (_, model) = model(0.05, 1200.0);
    let steps = &model.first_cycle().segments;
    assert!(steps.len() == 2 && steps[0].end == 0.6);
    let seen = assert_contact_law(&samples(folder.path()), &model);
    assert!(seen[0] > 100 && seen[2] > 100, "{seen:?}");
}

#[test]
fn modal_rows_are_the_trajectory() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--point", POINT, "--cycles", "4", "--skip", "0", "--modal"];
    traced(folder.path(), &QUICKSTART, &arguments);
    let s = samples(folder.path());
    let displacement = modal(folder.path(), "displacement");
    let velocity = modal(folder.path(), "modal_velocity");
    let (structure, model) = model(0.05, 1200.0);
    // In the structure's own basis the mesh deflection is Σ mesh·q − e.
    let product =
        |values: &[f64]| -> f64 { values.iter().zip(&structure.mesh).map(|(q, w)| q * w).sum() };
    let (far, fast) = (largest(&s.deflection), largest(&s.velocity));
    for row in 0..s.time.len() {
        let (error, rate) = model.lines[0].transmission_error_at(0, s.phase[row] * model.period());
        let d = product(&displacement[row]) - error;
        let v = product(&velocity[row]) - rate;
        assert!((d - s.deflection[row]).abs() < 1e-12 * far, "row {row}");
        assert!((v - s.velocity[row]).abs() < 1e-9 * fast, "row {row}");
    }
    // Bearing forces follow the modes: the omitted modes beyond the first twelve add only their static share.
    let table = ResultTable::read(&folder.path().join("out"), TableKind::Trace).unwrap();
    let sum = |gain: &[f64], of: &[f64]| gain.iter().zip(of).map(|(g, x)| g * x).sum::<f64>();
    for bearing in &structure.bearings {
        let name = format!("bearing_{}", bearing.name.replace(' ', "_"));
        let column = whole(table.f64(&name).unwrap());
        let of_modes = |row: usize| {
            sum(&bearing.gain, &displacement[row]) + sum(&bearing.rate_gain, &velocity[row])
        };
        // The contribution of omitted modes is proportional to the force of the mesh.
        let [mut slope, mut square] = [0.0; 2];
        let first = column[0] - of_modes(0);
        for row in 0..s.time.len() {
            let force = s.force[row] - s.force[0];
            slope += force * (column[row] - of_modes(row) - first);
            square += force * force;
        }
        let far = largest(&column);
        assert!(far > 0.0, "{name}");
        for row in 0..s.time.len() {
            let added = first + slope / square * (s.force[row] - s.force[0]);
            let expected = of_modes(row) + added;
            assert!(
                (column[row] - expected).abs() < 1e-8 * far,
                "{name}, row {row}"
            );
        }
    }
    assert_eq!(structure.bearings.len(), 8 + 2);
    // At mesh phase 0 the sample equals the state of an independent integrator.
    let start = model.start(&gearatlas::model::InitialState::Static);
    let reference = Reference::new(&model);
    for cycle in 1..4 {
        let passage = reference.advance(&start, cycle as u64).unwrap();
        let row = 64 * cycle;
        assert_eq!(s.phase[row], 0.0);
        let state = (model.basis).state(&displacement[row], &velocity[row]);
        let difference = relative_difference(&state, &passage.end.state);
        assert!(difference < 1e-9, "cycle {cycle}: {difference:e}");
    }
}

#[test]
fn a_modal_row_starts_the_same_motion_again() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--point", POINT, "--cycles", "6", "--skip", "0", "--modal"];
    traced(folder.path(), &QUICKSTART, &arguments);
    let whole_trace = samples(folder.path());
    let row = 3 * 64;
    let initial = format!(
        "initial = {{ displacement = {:?}, velocity = {:?} }}\ntransient = ",
        modal(folder.path(), "displacement")[row],
        modal(folder.path(), "modal_velocity")[row]
    );
    let text = QUICKSTART.replacen("transient = ", &initial, 1);
    assert_ne!(text, *QUICKSTART);
    traced(
        folder.path(),
        &text,
        &["--point", POINT, "--cycles", "2", "--skip", "0"],
    );
    let again = samples(folder.path());
    let far = largest(&again.deflection);
    for (i, deflection) in again.deflection.iter().enumerate() {
        let difference = (deflection - whole_trace.deflection[row + i]).abs();
        assert!(difference < 1e-9 * far, "sample {i}: {difference:e}");
    }
}

#[test]
fn values_take_units_and_other_axes_the_grids_values() {
    let folder = tempfile::tempdir().unwrap();
    let two_gaps = QUICKSTART.replacen(
        "[grid]",
        "[grid]\n\"mesh.half_gap\" = { values = [\"6 um\", \"10 um\"] }\n",
        1,
    );
    let point = "speed = 11459.155902616465 rpm, load=5%, mesh.half_gap=6um";
    let arguments = ["--cycles", "5", "--skip", "10", "--point"];
    let summary = traced(
        folder.path(),
        &two_gaps,
        &[&arguments[..], &[point]].concat(),
    );
    assert_eq!(summary["point"]["mesh.half_gap"], 6e-6);
    assert_eq!(summary["point"]["load"], 0.05);
    let speed = summary["point"]["speed"].as_f64().unwrap();
    assert!((speed - 1200.0).abs() < 1e-9, "{speed}");
    let s = samples(folder.path());
    let free = s
        .contact
        .iter()
        .zip(&s.deflection)
        .filter(|(c, _)| *c == "free");
    let widest = free.fold(0.0, |m, (_, d)| f64::max(m, d.abs()));
    assert!((3e-6..=6e-6).contains(&widest), "{widest}");
    // An omitted axis takes its only value.
    let one_point = QUICKSTART
        .replacen("{ from = \"10 %\", to = \"30 %\", count = 3 }", "0.05", 1)
        .replacen(
            "{ from = \"6000 rpm\", to = \"12000 rpm\", count = 4 }",
            "1200",
            1,
        );
    let summary = traced(folder.path(), &one_point, &["--cycles", "1"]);
    assert_eq!(summary["point"]["speed"], 1200.0);
}

#[test]
fn files_lie_below_the_jobs_results_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), QUICKSTART.as_str()).unwrap();
    let point = "load=0.05,speed=11460 rpm";
    let output = trace(
        folder.path(),
        &["m.toml", "--point", point, "--cycles", "2"],
    );
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    let place = Path::new("results/quickstart/trace-load-0.05-speed-11460rpm");
    for file in ["trace.parquet", "events.parquet"] {
        let path = place.join(file);
        assert!(folder.path().join(&path).is_file(), "{}", path.display());
        assert!(text.contains(path.to_str().unwrap()), "{text}");
    }
    assert!(text.contains("2 mesh cycles"), "{text}");
    let transient = job(&QUICKSTART).points.at(0).run.transient;
    let from = format!("from cycle {transient} on; 128 samples");
    assert!(text.contains(&from), "{text}");
}

#[test]
fn a_trace_that_ends_early_keeps_what_came_before() {
    let folder = tempfile::tempdir().unwrap();
    let text = QUICKSTART.replacen("transient = ", "event_limit = 2\ntransient = ", 1);
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let fixed = ["m.toml", "--json", "--out", "out", "--skip", "0", "--point"];
    let output = trace(folder.path(), &[&fixed[..], &[POINT]].concat());
    assert_eq!(output.status.code(), Some(3));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("more than 2 events in mesh cycle"),
        "{message}"
    );
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let s = samples(folder.path());
    assert_eq!(summary["samples"], s.time.len());
    let cycles = usize::try_from(summary["cycles"].as_u64().unwrap()).unwrap();
    assert!((64 * cycles..64 * (cycles + 1)).contains(&s.time.len()));
}

#[test]
fn a_bad_point_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let axes = "[grid]\n\"mesh.half_gap\" = { values = [\"6 um\", \"10 um\"] }\n\
                \"mesh.contact_damping\" = { values = [0.05] }\n";
    let text = QUICKSTART.replacen("[grid]", axes, 1);
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let mut report = String::new();
    for point in [
        "",
        "load=0.05",
        "load=0.05,speed=1200 rad/s",
        "load=0.05,speed=1200,mesh.half_gap=7um",
        "load=0,05,speed=1200,mesh.half_gap=6um",
        "load=0.05,sped=1200,mesh.half_gap=6um",
        "load=0.05,load=0.1,speed=1200,mesh.half_gap=6um",
        "load=-0.05,speed=0,mesh.half_gap=6um",
        "load=0.05 N,speed=1200 um,mesh.half_gap=thick",
        "load=inf,speed=1200,mesh.half_gap=6um",
        "load=0.05,speed=1200,mesh.half_gap=6um,mesh.contact_damping=0.06",
    ] {
        let output = trace(folder.path(), &["m.toml", "--point", point]);
        assert_eq!(output.status.code(), Some(2), "{point}");
        assert!(output.stdout.is_empty(), "{point}");
        let message = String::from_utf8(output.stderr).unwrap();
        report += &format!("--point \"{point}\"\n{message}\n");
    }
    insta::assert_snapshot!(report);
    let left: Vec<PathBuf> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    assert_eq!(left, [folder.path().join("m.toml")]);
}

#[test]
fn a_trace_that_is_there_is_replaced_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), &*QUICKSTART).unwrap();
    let arguments = ["m.toml", "--out", "out", "--skip", "0", "--cycles"];
    let run = |more: &[&str]| {
        let output = trace(
            folder.path(),
            &[&arguments[..], more, &["--point", POINT]].concat(),
        );
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), said)
    };
    let file = folder.path().join("out/trace.parquet");
    assert_eq!(run(&["2"]).0, Some(0));
    let first = std::fs::read(&file).unwrap();
    let (status, said) = run(&["3"]);
    assert_eq!(status, Some(2));
    assert_eq!(
        said,
        "error: `out/trace.parquet` already exists; choose another folder with --out, or replace the trace with --overwrite\n"
    );
    assert!(std::fs::read(&file).unwrap() == first);
    assert_eq!(run(&["3", "--overwrite"]), (Some(0), String::new()));
    assert!(std::fs::read(&file).unwrap() != first);
}

/// A point of the grid has a number, and both ways of naming it give the same trajectory.
#[test]
fn a_point_is_named_by_number_or_by_axes() {
    let folder = tempfile::tempdir().unwrap();
    let recorded = |point: &str| {
        let arguments = ["--point", point, "--skip", "0", "--cycles", "2"];
        traced(folder.path(), &QUICKSTART, &arguments);
        std::fs::read(folder.path().join("out/trace.parquet")).unwrap()
    };
    assert!(recorded("7") == recorded("load=0.2,speed=12000 rpm"));
    let refused = trace(folder.path(), &["m.toml", "--point", "12"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(
        said.contains("no point 12: this manifest has 12 points"),
        "{said}"
    );
}

/// On rigid mounts gears only rotate: `δ + e = r_b1 θ₁ − r_b2 θ₂`, both in the direction of running, and the neutral
/// rotation is at rest.
#[test]
fn rotations_of_gears_make_the_deflection() {
    let folder = tempfile::tempdir().unwrap();
    let text = include_str!("../../manifests/tiers/torsional.toml").replace("friction = 0.05", "");
    let point = "load=0.05,speed=1400";
    traced(
        folder.path(),
        &text,
        &[
            "--point",
            point,
            "--skip",
            "50",
            "--cycles",
            "20",
            "--outputs",
        ],
    );
    let table = ResultTable::read(&folder.path().join("out"), TableKind::Trace).unwrap();
    let column = |name: &str| whole(table.f64(name).unwrap());
    let [pinion, wheel] = ["rotation_pinion", "rotation_wheel"].map(column);
    let units = table.units().unwrap();
    assert_eq!(units["rotation_pinion"], "rad");
    let base = |teeth: f64| 0.5 * 4e-3 * teeth * 20f64.to_radians().cos();
    let (deflection, phase) = (column("deflection"), column("phase"));
    let rates = column("angular_acceleration_pinion");
    let largest = largest(&deflection);
    for i in 0..deflection.len() {
        let error = 5e-6 * (std::f64::consts::TAU * phase[i]).cos();
        let approach = base(20.0) * pinion[i] - base(30.0) * wheel[i];
        let off = approach - error - deflection[i];
        assert!(off.abs() < 1e-9 * largest, "{i}: {off:e}, {largest:e}");
    }
    // Angles and accelerations of one gear have the same sign: its acceleration is the second difference of its angle.
    let step = column("time")[1] - column("time")[0];
    let second: Vec<f64> = (1..pinion.len() - 1)
        .map(|i| (pinion[i + 1] - 2.0 * pinion[i] + pinion[i - 1]) / (step * step))
        .collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let inner = &rates[1..rates.len() - 1];
    let alike =
        product(&second, inner) / (product(&second, &second) * product(inner, inner)).sqrt();
    assert!(alike > 0.99, "{alike}");
}
