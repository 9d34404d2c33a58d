//! Sweeps that carry the state: hysteresis of a drive that loses and regains contact at speeds known in closed form,
//! the same bits for any split or interruption, and Poincaré sections compared with a trace, the reference integrator
//! and a dense search.

#![allow(clippy::unwrap_used)]

use crate::{common, results};
use common::advance::volterra;
use gearatlas::analysis::{
    ModalState, MultistabilityConfig, PoincareSample, PointConfig, Probes, SampleKind, Section,
    Signals, Surface, TraceConfig, TraceSample, TraceSink, investigate, probe_basins, trace,
};
use gearatlas::manifest::{self, Job};
use gearatlas::model::{
    ActiveSet, COAST_FLANK, DRIVE_FLANK, Drive, InitialState, MeshHarmonic, Model,
};
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::Event;
use gearatlas::reference::Reference;
use gearatlas::store::{ResultTable, TableKind};
use std::convert::Infallible;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A rigid relative rotation under load: stiff in contact, free in the gap.
const STRUCTURE: &str = include_str!("../manifests/one.modal.toml");

const MANIFEST: &str = concat!(
    r#"
[job]
name = "hysteresis"

"#,
    include_str!("../manifests/one.head.toml"),
    r#"
[grid]
load = { values = [0.5, 1.0] }
speed = { from = 800, to = 2400, count = 41 }
order = "both"

[run]
transient = 200
cycles = 1000
audit_cycles = 0

[analyses]
poincare = { samples = 4, refine = 8 }
lyapunov = { twin = false }
"#
);

/// Spacing of the speeds \[rad/s\].
const STEP: f64 = 40.0;

/// Speeds between which motion in constant contact does not exist: its amplitude `e Ω²/|k w² − Ω² + i c w² Ω|`, Ω the
/// mesh frequency, would exceed the static deflection `F/k`.
fn contact_is_lost(load: f64) -> [f64; 2] {
    let (square, k, c, e) = (1.3f64 * 1.3, 4e8, 1483.0, 1e-6);
    let excess = |speed: f64| {
        let forcing = 20.0 * speed;
        let (stiff, loss) = (k * square - forcing * forcing, c * square * forcing);
        e * forcing * forcing / stiff.hypot(loss) - 1330.0 * load / k
    };
    let resonance = (k * square).sqrt() / 20.0;
    [100.0, 5000.0].map(|outside| {
        let (mut quiet, mut loud) = (outside, resonance);
        for _ in 0..200 {
            let middle = 0.5 * (quiet + loud);
            if excess(middle) > 0.0 {
                loud = middle;
            } else {
                quiet = middle;
            }
        }
        0.5 * (quiet + loud)
    })
}

/// A separate folder with a manifest.
struct Place(TempDir);

impl Place {
    fn new(manifest: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("one.modal.toml"), STRUCTURE).unwrap();
        fs::write(folder.path().join("m.toml"), manifest).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_atlas"));
        command.current_dir(self.0.path()).args(arguments);
        command
    }

    fn atlas(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs to the end; points that do not settle or fail are allowed.
    fn run(&self, out: &str, arguments: &[&str]) -> PathBuf {
        let output = self.atlas(&[&["run", "m.toml", "--out", out, "--quiet"], arguments].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{said}");
        self.path(out)
    }
}

/// A point of the results.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    id: u64,
    load: f64,
    speed: f64,
    up: bool,
    class: String,
    reason: String,
}

fn rows(folder: &Path) -> Vec<Row> {
    let table = ResultTable::read(folder, TableKind::Points).unwrap();
    let (ids, directions) = (
        table.u64("point_id").unwrap(),
        table.text("direction").unwrap(),
    );
    let (loads, speeds) = (table.f64("load").unwrap(), table.f64("speed").unwrap());
    let (classes, reasons) = (table.text("class").unwrap(), table.text("reason").unwrap());
    (0..table.rows())
        .map(|row| Row {
            id: ids[row].unwrap(),
            load: loads[row].unwrap(),
            speed: speeds[row].unwrap(),
            up: directions[row].as_deref() == Some("up"),
            class: classes[row].clone().unwrap_or_default(),
            reason: reasons[row].clone().unwrap(),
        })
        .collect()
}

fn job(place: &Place) -> Job {
    manifest::load(&place.path("m.toml")).unwrap()
}

fn model_of(job: &Job, index: usize) -> Model {
    let point = &job.points.at(index);
    common::parts().model(point).unwrap()
}

/// The chains: other axes outermost, then the direction, then the speed in the order of integration.
#[test]
fn chains_are_ranges_of_ids_in_sweep_order() {
    let place = Place::new(MANIFEST);
    let job = job(&place);
    assert_eq!((job.points.len(), job.chain_length()), (164, 41));
    for (index, point) in job.points.iter().enumerate() {
        let (chain, along) = (index / 41, index % 41);
        let steps = if chain % 2 == 0 { along } else { 40 - along };
        assert_eq!(point.point_id, index as u64);
        assert_eq!(point.load, [0.5, 1.0][chain / 2]);
        assert!((point.speed - (800.0 + STEP * steps as f64)).abs() < 1e-9);
        let direction = point.direction.unwrap().name();
        assert_eq!(direction, ["up", "down"][chain % 2]);
        assert_eq!(point.axis_values, [point.load, point.speed]);
    }
    let said = String::from_utf8(place.atlas(&["check", "m.toml"]).stdout).unwrap();
    let line =
        "4 chains of 41 points, carried along speed (up, then down); chains run side by side";
    assert!(said.contains(line), "{said}");
    let json = place.atlas(&["check", "m.toml", "--json"]).stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["carried"]["chain_length"], 41);
    assert_eq!(json["carried"]["along"], "speed");

    // Along the slower axis the chains have its length.
    let along = MANIFEST.replace(
        "order = \"both\"",
        "order = \"sweep-down\"\nalong = \"load\"",
    );
    let job = self::job(&Place::new(&along));
    assert_eq!((job.points.len(), job.chain_length()), (82, 2));
    let points: Vec<_> = job.points.iter().collect();
    for (index, pair) in points.chunks(2).enumerate() {
        assert_eq!([pair[0].load, pair[1].load], [1.0, 0.5]);
        assert!(
            pair.iter()
                .all(|p| (p.speed - 800.0 - STEP * index as f64).abs() < 1e-9)
        );
    }
}

#[test]
fn up_and_down_differ_where_two_motions_coexist() {
    let place = Place::new(MANIFEST);
    let rows = rows(&place.run("r", &[]));
    let job = job(&place);
    let table = ResultTable::read(&place.path("r"), TableKind::Transitions).unwrap();
    let (at, from) = (
        table.u64("point_id").unwrap(),
        table.text("from_class").unwrap(),
    );
    let to = table.text("to_class").unwrap();
    let (lower, upper) = (table.f64("lower").unwrap(), table.f64("upper").unwrap());
    for load in [0.5, 1.0] {
        let [lost, regained] = contact_is_lost(load);
        let sweep = |up: bool| -> Vec<&Row> {
            let own = rows.iter().filter(|row| row.load == load && row.up == up);
            own.collect()
        };
        let locked = |row: &Row| row.class == "steady_contact";
        // Upwards, the motion is in constant contact wherever such motion exists.
        for row in sweep(true) {
            let inside = (lost..regained).contains(&row.speed);
            assert_eq!(locked(row), !inside, "{row:?} {lost} {regained}");
        }
        // Downwards: rattling continues below the speed at which contact was lost.
        let mut coexisting = 0;
        for row in sweep(false) {
            let other = rows
                .iter()
                .find(|r| r.load == load && r.up && r.speed == row.speed);
            if locked(row) != locked(other.unwrap()) {
                assert!(row.speed < lost && !locked(row), "{row:?}");
                coexisting += 1;
            } else if row.speed > lost {
                assert_eq!(locked(row), row.speed > regained, "{row:?}");
            }
        }
        assert!(coexisting >= 2, "load {load}: {coexisting}");
        // Probes from other states find both motions at the coexisting speeds, and one motion at other speeds.
        let lowest = lost - STEP * coexisting as f64;
        for row in sweep(false) {
            let differs = row.speed < lost && row.speed > lowest;
            let sure = [lost, lowest]
                .iter()
                .all(|edge| (row.speed - edge).abs() > STEP);
            if sure && row.speed < lost {
                let model = model_of(&job, row.id as usize);
                let found = probes(&model);
                assert_eq!(found > 1, differs, "{row:?}: {found} attractors");
            }
        }
        // The change is bracketed to the requested width, with its closed form inside.
        let first = sweep(true)
            .into_iter()
            .find(|row| row.speed > lost)
            .unwrap();
        let row = at.iter().position(|id| *id == Some(first.id)).unwrap();
        assert_eq!(from[row].as_deref(), Some("steady_contact"));
        assert_ne!(to[row].as_deref(), Some("steady_contact"));
        let (lower, upper) = (lower[row].unwrap(), upper[row].unwrap());
        assert!(lower < lost && lost < upper, "{lower} {lost} {upper}");
        assert!(
            (upper - lower - STEP / 256.0).abs() < 1e-9,
            "{lower} {upper}"
        );
    }
}

fn probes(model: &Model) -> u32 {
    let asked = MultistabilityConfig {
        initial_conditions: 24,
        decades: 5.0,
        transient: 200,
        cycles: 1000,
        slice: None,
    };
    let point = PointSeed {
        seed: 3,
        point_id: 0,
    };
    let probes = Probes::new(model, asked, point, true).unwrap();
    let start = model.start(&InitialState::Static);
    let interrupt = AtomicBool::new(false);
    let found = probe_basins(model, &volterra(model), &start, &probes, &interrupt);
    found.unwrap().attractors.len() as u32
}

/// A change is refined along any axis that can be swept, including keys of the mesh.
#[test]
fn changes_are_refined_along_a_key_of_the_mesh() {
    let manifest = MANIFEST
        .replace(
            "load = { values = [0.5, 1.0] }",
            "load = 0.5\n\"mesh.mean_stiffness\" = { from = 3e8, to = 12e8, count = 10 }",
        )
        .replace("{ from = 800, to = 2400, count = 41 }", "1100.0")
        .replace("order = \"both\"", "order = \"sweep-down\"");
    let place = Place::new(&manifest);
    let out = place.run("r", &[]);
    // If the sweep starts from a stiff mesh, contact is lost at equal amplitude and static deflection.
    let excess = |k: f64| {
        let (square, forcing) = (1.69, 22_000.0_f64);
        let (stiff, loss) = (k * square - forcing * forcing, 1483.0 * square * forcing);
        1e-6 * forcing * forcing / stiff.hypot(loss) - 665.0 / k
    };
    let (mut quiet, mut loud) = (12e8, 2.9e8);
    assert!(excess(quiet) < 0.0 && excess(loud) > 0.0);
    for _ in 0..100 {
        let middle = 0.5 * (quiet + loud);
        if excess(middle) < 0.0 {
            quiet = middle;
        } else {
            loud = middle;
        }
    }
    let table = ResultTable::read(&out, TableKind::Transitions).unwrap();
    assert_eq!(
        table.text("axis").unwrap()[0].as_deref(),
        Some("mesh.mean_stiffness")
    );
    assert_eq!(table.units().unwrap()["lower"], "N/m");
    let (lower, upper) = (table.f64("lower").unwrap(), table.f64("upper").unwrap());
    let inside = (0..table.rows())
        .filter(|&row| lower[row].unwrap() < quiet && quiet < upper[row].unwrap())
        .count();
    assert_eq!(inside, 1, "{quiet} {lower:?} {upper:?}");
}

/// The oscillator of Blankenship & Kahraman (1995), `k = 1 + 0.2 cos τ` in sixty segments: from below, period 1 with a
/// small amplitude ends in a fold at 0.829, and a period 1 with almost three times its RMS follows.
#[test]
fn a_jump_at_constant_class_and_period_is_bracketed() {
    let step = std::f64::consts::PI / 60.0;
    let level = |i: u32| 1.0 + 0.2 * (step * f64::from(2 * i + 1)).cos() * step.sin() / step;
    let levels: Vec<String> = (0..60).map(|i| format!("{:.15}", level(i))).collect();
    let manifest = format!(
        r#"
[job]
name = "jump"

[model]
kind = "modal"
file = "one.modal.toml"

[mesh]
half_gap = 1
stiffness = "piecewise"
values = [{}]
contact_damping = 0.02

[excitation]
torque_ripple = [{{ shaft = "pinion", order = 1, amplitude = 0.05 }}]

[grid]
load = 0.1
speed = {{ from = 0.80, to = 0.86, count = 13 }}
order = "sweep-up"

[run]
transient = 300
cycles = 3000
audit_cycles = 0
initial = {{ displacement = [1.2], velocity = [0.0] }}

[analyses]
poincare = {{ samples = 4, refine = 6 }}
lyapunov = {{ twin = false }}
"#,
        levels.join(", ")
    );
    let place = Place::new(&manifest);
    let structure = "teeth = 1\nrated_force = 1.0\nfrequency = [0.0]\ndamping = [0.0]\n\
                     mesh = [1.0]\ntorque = [1.0]\ntorque_pinion = [1.0]\n";
    fs::write(place.path("one.modal.toml"), structure).unwrap();
    let out = place.run("r", &[]);
    let table = ResultTable::read(&out, TableKind::Transitions).unwrap();
    let text = |name: &str| -> Vec<String> {
        let column = table.text(name).unwrap();
        column.into_iter().map(Option::unwrap).collect()
    };
    assert_eq!(text("what"), ["class", "deflection"]);
    assert_eq!(text("from_class"), ["steady_contact", "periodic"]);
    assert_eq!(text("to_class"), ["periodic", "periodic"]);
    let number = |name: &str| table.f64(name).unwrap()[1].unwrap();
    let (lower, upper) = (number("lower"), number("upper"));
    assert!((upper - lower - 0.005 / 64.0).abs() < 1e-12);
    assert!(lower < 0.828_867 && 0.828_864 < upper, "{lower} {upper}");
    assert!((number("from_deflection_rms") - 0.0764).abs() < 1e-3);
    assert!((number("to_deflection_rms") - 0.2058).abs() < 1e-3);
    // A change of class has no jump, and points without requested statistics have none.
    assert_eq!(table.f64("from_deflection_rms").unwrap()[0], None);
    let points = ResultTable::read(&out, TableKind::Points).unwrap();
    let rms = points.f64("deflection_rms").unwrap();
    assert!(rms.iter().all(Option::is_none));
    let said = place.atlas(&["show", "r"]);
    let said = String::from_utf8(said.stdout).unwrap();
    assert!(said.contains("RMS of the deflection jumps"), "{said}");

    // Without refinement the jump is reported between neighbours of the grid, if the deflection is known, like any
    // other change of motion.
    let unrefined = manifest.replace(", refine = 6", "");
    fs::write(place.path("m.toml"), format!("{unrefined}nvh = {{}}\n")).unwrap();
    let coarse = place.run("coarse", &[]);
    let table = ResultTable::read(&coarse, TableKind::Transitions).unwrap();
    assert_eq!(table.rows(), 2);
    assert_eq!(
        table.text("what").unwrap()[1].as_deref(),
        Some("deflection")
    );
    assert_eq!(table.u64("trials").unwrap(), [Some(0), Some(0)]);
    let ends = ["lower", "upper"].map(|name| table.f64(name).unwrap()[1].unwrap());
    assert!(
        (ends[0] - 0.825).abs() < 1e-12 && (ends[1] - 0.83).abs() < 1e-12,
        "{ends:?}"
    );
    let said = String::from_utf8(place.atlas(&["show", "coarse"]).stdout).unwrap();
    let head = "changes of motion along speed: 1 of class, 1 by a jump of the deflection\n";
    assert!(said.contains(head), "{said}");
    let json = place.atlas(&["show", "coarse", "--json"]).stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    let counts = serde_json::json!({ "class": 1, "deflection": 1 });
    assert_eq!(json["transition_counts"], counts);
    assert_eq!(json["transitions"][1]["bracket"][1], ends[1]);

    fs::write(place.path("m.toml"), unrefined).unwrap();
    let table = ResultTable::read(&place.run("bare", &[]), TableKind::Transitions).unwrap();
    assert_eq!(table.text("what").unwrap(), [Some("class".to_owned())]);
}

/// An equilibrium keeps its position when its damping falls below 0. The state that the next point takes over is on the
/// equilibrium to round-off, and would stay there.
#[test]
fn a_chain_leaves_an_equilibrium_that_has_become_unstable() {
    let manifest = r#"
[job]
name = "left"

[model]
kind = "modal"
file = "growing.modal.toml"

[mesh]
half_gap = 0.6
stiffness = "constant"
mean_stiffness = 200
contact_damping = 0

[grid]
load = 7.5
speed = 6.283185307179586
"mesh.contact_damping" = { values = ["0.05 N*s/m", "0.003 N*s/m"] }
order = "sweep-down"

[run]
transient = 300
cycles = 2000

[analyses]
lyapunov = { twin = false }
"#;
    let place = Place::new(manifest);
    let structure = "teeth = 1\nrated_force = 1.0\nfrequency = [0.0]\ndamping = [0.0]\n\
                     damping_matrix = [[-0.02]]\nmesh = [1.0]\ntorque = [1.0]\ntorque_pinion = [1.0]\n";
    fs::write(place.path("growing.modal.toml"), structure).unwrap();
    let endings = |out: &str, arguments: &[&str]| {
        let table = ResultTable::read(&place.run(out, arguments), TableKind::Points).unwrap();
        let reasons = table.text("reason").unwrap();
        (table.text("status").unwrap(), reasons[1].clone().unwrap())
    };
    let words = |all: [&str; 2]| all.map(|word| Some(word.to_owned()));
    let (status, reason) = endings("left", &[]);
    assert_eq!(status, words(["ok", "diverged"]), "{reason}");
    let (status, reason) = endings("stayed", &["--set", "grid.displacement=0"]);
    assert_eq!(status, words(["ok", "not_converged"]), "{reason}");
    assert!(
        reason.contains("linear motion that is unstable"),
        "{reason}"
    );
    // The direction is that of the point.
    let again = place.run("again", &["--threads", "2"]);
    results::assert_same(&["points.parquet"], &place.path("left"), &again);
}

fn assert_same(a: &Path, b: &Path) {
    let tables = ["points.parquet", "poincare.parquet", "transitions.parquet"];
    results::assert_same(&tables, a, b);
}

#[test]
fn threads_and_shards_change_nothing() {
    let place = Place::new(MANIFEST);
    let one = place.run("one", &["--threads", "1"]);
    assert_same(&one, &place.run("two", &["--threads", "2"]));
    for shard in ["1/3", "2/3", "3/3"] {
        place.run("parts", &["--shard", shard]);
    }
    assert_same(&one, &place.path("parts"));
    // Chains are distributed as a whole: the first of three shards has two of the four.
    let first = place.path("parts/points.parquet/shard-1-of-3.parquet");
    let held = results::file_ids(&first);
    assert_eq!(held, (0..41).chain(123..164).collect::<Vec<u64>>());
}

/// Killed in the middle of its only chain, twice, a run ends with the same bits.
#[test]
fn a_killed_chain_goes_on_where_it_was() {
    let manifest = MANIFEST
        .replace("{ values = [0.5, 1.0] }", "0.5")
        .replace("\"both\"", "\"sweep-down\"")
        .replace("transient = 200", "transient = 2000\nsettle = false");
    let place = Place::new(&manifest);
    let whole = place.run("whole", &[]);
    let journal = place.path("r/.journal");
    let length = || fs::metadata(&journal).map_or(0, |found| found.len());
    for _ in 0..2 {
        let begun = length();
        let mut child = place
            .command(&["run", "m.toml", "--out", "r", "--quiet"])
            .spawn()
            .unwrap();
        let patience = Instant::now();
        while length() < begun.max(300) + 1200 {
            assert!(patience.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!place.path("r/points.parquet").exists());
    }
    let resumed = place.run("r", &[]);
    let record = fs::read(resumed.join("run.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    let resumed_points = record["totals"]["resumed"].as_u64().unwrap();
    assert!((1..41).contains(&resumed_points), "{resumed_points}");
    assert_same(&whole, &resumed);
}

/// A point without an end state does not stop its chain.
#[test]
fn a_chain_goes_on_behind_a_point_that_stormed() {
    let manifest = MANIFEST.replace("[run]", "[run]\nevent_limit = 1");
    let place = Place::new(&manifest);
    let rows = rows(&place.run("r", &[]));
    let note = "; started from run.initial because the previous point ended in an event storm";
    let mut noted = 0;
    for pair in rows.windows(2) {
        let follows = pair[1].id % 41 != 0;
        let stormed = pair[0].class.is_empty();
        assert_eq!(
            pair[1].reason.contains(note),
            follows && stormed,
            "{pair:?}"
        );
        noted += usize::from(follows && stormed);
    }
    assert!(noted > 4, "{noted}");
}

/// A trace with a direction starts at the state of the sweep.
#[test]
fn a_trace_follows_the_sweep_asked_for() {
    let place = Place::new(MANIFEST);
    let [lost, _] = contact_is_lost(0.5);
    let speed = 800.0 + STEP * ((lost - 800.0) / STEP).floor();
    let events = |direction: &str| {
        let point = format!("load=0.5,speed={speed}{direction}");
        let options = ["--json", "--overwrite", "--out", "t"];
        let output = place.atlas(&[&["trace", "m.toml", "--point", &point], &options[..]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["events"].as_u64().unwrap()
    };
    assert_eq!(events(",direction=up"), 0);
    assert!(events(",direction=down") >= 40);
    let point = format!("load=0.5,speed={speed},direction=left");
    let output = place.atlas(&["trace", "m.toml", "--point", &point]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("direction is left, but this manifest sweeps up and down"),
        "{said}"
    );
}

/// Chaotic rattle at all speeds of interest: constant stiffness, 5 µm of error.
fn rattling(phase: f64) -> Model {
    let structure = common::structure(&[0.0], 0.0, &[1.3], &[1.3]);
    let drive = Drive {
        damping: 1483.0,
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, std::f64::consts::TAU * phase)],
        ..common::constant_mesh(10e-6, 4e8)
    };
    Model::new(&structure, &drive, common::strong_rattle()).unwrap()
}

const TRANSIENT: u64 = 60;
const MEASURED: u64 = 100;

/// Samples of a section from cycle [`TRANSIENT`] on, for [`MEASURED`] cycles.
fn samples(model: &Model, section: Section) -> Vec<PoincareSample> {
    let questions = PointConfig {
        point: PointSeed {
            seed: 1,
            point_id: 0,
        },
        transient: TRANSIENT,
        cycles: MEASURED,
        settle: false,
        audit_cycles: 0,
        lyapunov: None,
        poincare_samples: 100_000,
        section,
        nvh: None,
    };
    let start = model.start(&InitialState::Static);
    let interrupt = AtomicBool::new(false);
    let found = investigate(model, &volterra(model), start, &questions, &interrupt);
    found.unwrap().poincare
}

#[derive(Default)]
struct Kept {
    samples: Vec<TraceSample>,
    events: Vec<Event>,
}

impl TraceSink for Kept {
    type Error = Infallible;

    fn sample(&mut self, sample: TraceSample) -> Result<(), Infallible> {
        self.samples.push(sample);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), Infallible> {
        self.events.push(*event);
        Ok(())
    }
}

/// A trace of the cycles of [`samples`].
fn traced(model: &Model, samples_per_cycle: u32) -> Kept {
    let config = TraceConfig {
        skip: TRANSIENT,
        cycles: MEASURED,
        samples_per_cycle,
        modal: true,
        outputs: Signals::NONE,
    };
    let start = model.start(&InitialState::Static);
    let mut kept = Kept::default();
    trace(model, &volterra(model), start, &config, &mut kept).unwrap();
    kept
}

#[test]
fn a_strobe_at_any_phase_is_the_state_there() {
    let model = rattling(0.0);
    let phase = 0.375;
    let strobes = samples(&model, Section::Strobe { phase });
    assert_eq!(strobes.len(), MEASURED as usize);
    let traced = traced(&model, 8).samples;
    let (scale, fast) = (20e-6, 1.0);
    // From that phase on, the drive equals the one with its excitation shifted by that phase.
    let shifted = rattling(phase);
    let reference = Reference::new(&shifted);
    for (index, pair) in strobes.windows(2).enumerate() {
        let here = &traced[8 * index + 3];
        assert_eq!((pair[0].cycle, pair[0].phase), (here.cycle, here.phase));
        assert_eq!((here.phase, pair[0].kind), (phase, SampleKind::Strobe));
        assert!((pair[0].deflection - here.deflection).abs() < 1e-12 * scale);
        assert!((pair[0].velocity - here.velocity).abs() < 1e-12 * fast);
        let ModalState {
            displacement,
            velocity,
        } = here.modal.clone().unwrap();
        let start = shifted.start(&InitialState::Modal {
            displacement,
            velocity,
        });
        let there = reference.advance(&start, 1).unwrap().end;
        let (deflection, rate) = shifted.deflection(&there.state, 0.0);
        assert!((pair[1].deflection - deflection).abs() < 1e-12, "{index}");
        assert!(
            (pair[1].deflection - deflection).abs() < 1e-9 * scale,
            "{index}"
        );
        assert!((pair[1].velocity - rate).abs() < 1e-9 * fast, "{index}");
    }
    // Phase 0 from a window equals phase 0 from the trajectory.
    let least = samples(
        &model,
        Section::Strobe {
            phase: f64::MIN_POSITIVE,
        },
    );
    let zero = samples(&model, Section::default());
    assert_eq!((zero[0].cycle, least[0].cycle), (TRANSIENT + 1, TRANSIENT));
    for (read, own) in least[1..].iter().zip(&zero) {
        assert!((read.deflection - own.deflection).abs() < 1e-12 * scale);
        // An event soon after the sample leaves a short window, whose slope magnifies round-off.
        assert!((read.velocity - own.velocity).abs() < 1e-9 * fast);
    }
}

#[test]
fn entry_samples_lie_on_the_drive_flank() {
    let model = rattling(0.0);
    let found = samples(&model, Section::Entry);
    let events = traced(&model, 1).events;
    let entries: Vec<&Event> = events.iter().filter(|e| e.to == ActiveSet::DRIVE).collect();
    assert!(entries.len() > 50, "{}", entries.len());
    assert_eq!(found.len(), entries.len());
    for (sample, event) in found.iter().zip(entries) {
        assert!((sample.deflection - 10e-6).abs() < 1e-18, "{sample:?}");
        assert!(sample.velocity > 0.0 && sample.velocity == event.rate);
        assert_eq!(
            (sample.cycle, sample.kind),
            (event.cycle, SampleKind::Entry)
        );
        assert!((sample.phase - event.time / model.period()).abs() < 1e-15);
    }
    // Permanent contact has no entries.
    let quiet = common::model_at(&common::one_degree(), 50.0, 300.0);
    assert!(samples(&quiet, Section::Entry).is_empty());
}

#[test]
fn turning_samples_are_all_the_extremes() {
    let model = rattling(0.0);
    let found = samples(&model, Section::Extremum);
    let dense = traced(&model, 4000).samples;
    let fastest = dense
        .iter()
        .fold(0.0f64, |most, s| most.max(s.velocity.abs()));
    for sample in &found {
        assert!(sample.velocity.abs() < 1e-10 * fastest, "{sample:?}");
    }
    assert!(found.windows(2).all(|pair| pair[0].kind != pair[1].kind));
    let turns: Vec<(&TraceSample, bool)> = dense
        .windows(2)
        .filter(|pair| (pair[0].velocity > 0.0) != (pair[1].velocity > 0.0))
        .map(|pair| (&pair[0], pair[1].velocity > 0.0))
        .collect();
    assert_eq!(found.len(), turns.len());
    for (sample, (before, rises)) in found.iter().zip(turns) {
        let ahead = sample.cycle as f64 + sample.phase - before.cycle as f64 - before.phase;
        assert!((-1e-9..1.001 / 4000.0).contains(&ahead), "{ahead}");
        let kind = if rises { SampleKind::Minimum } else { SampleKind::Maximum };
        assert_eq!(sample.kind, kind);
    }
}

/// The picture and the summary show both directions of the sweep.
#[test]
fn sweeps_are_shown_and_drawn() {
    let place = Place::new(MANIFEST);
    place.run("r", &[]);
    let shown = String::from_utf8(place.atlas(&["show", "r"]).stdout).unwrap();
    assert!(shown.contains("changes of motion along speed"), "{shown}");
    assert!(shown.contains("steady contact   → period 1"), "{shown}");
    let drawn = place.atlas(&["plot", "r", "--format", "svg", "--quiet"]);
    assert!(
        drawn.status.success(),
        "{}",
        String::from_utf8_lossy(&drawn.stderr)
    );
    let svg = fs::read_to_string(place.path("r/pictures/bifurcation-load=0.5.svg")).unwrap();
    for text in [
        "up: δ at mesh phase 0 [µm]",
        "down: δ at mesh phase 0 [µm]",
        "sweep down",
    ] {
        assert!(svg.contains(text), "{text}");
    }
}

/// Samples at entries or releases are the events: the same times to the bit, δ on the surface to round-off, and the
/// same number.
#[test]
fn samples_at_events_are_the_events() {
    let model = rattling(0.0);
    let events = traced(&model, 1).events;
    for (section, contact, closes, kind) in [
        (Section::Release, DRIVE_FLANK, false, SampleKind::Release),
        (
            Section::CoastEntry,
            COAST_FLANK,
            true,
            SampleKind::CoastEntry,
        ),
        (
            Section::CoastRelease,
            COAST_FLANK,
            false,
            SampleKind::CoastRelease,
        ),
    ] {
        let found = samples(&model, section);
        let wanted: Vec<&Event> = (events.iter())
            .filter(|e| e.contact == contact && e.closes() == closes)
            .collect();
        assert!(wanted.len() > 20, "{kind:?}: {}", wanted.len());
        assert_eq!(found.len(), wanted.len(), "{kind:?}");
        let surface = if contact == DRIVE_FLANK { 10e-6 } else { -10e-6 };
        for (sample, event) in found.iter().zip(wanted) {
            assert_eq!((sample.cycle, sample.kind), (event.cycle, kind));
            let phase = event.time / model.period();
            assert!((sample.phase - phase).abs() < 1e-15, "{sample:?} {phase}");
            assert!((sample.deflection - surface).abs() < 1e-17, "{sample:?}");
            let rate = event.rate;
            assert!((sample.velocity - rate).abs() < 1e-9, "{sample:?} {rate}");
        }
    }
}

/// Maxima of the force compared with those of 4096 samples per cycle.
#[test]
fn maxima_of_the_force_are_those_of_a_dense_course() {
    const DENSE: u32 = 4096;
    let model = rattling(0.0);
    let found = samples(&model, Section::ForceMaximum);
    let traced = traced(&model, DENSE);
    let (course, events) = (&traced.samples, &traced.events);
    let force = |i: usize| course[i].force;
    let maxima: Vec<usize> = (1..course.len() - 1)
        .filter(|&i| force(i) > 0.0 && force(i) > force(i - 1) && force(i) >= force(i + 1))
        .collect();
    let near = |a: f64, b: f64| (a - b).abs() < 1.01 / f64::from(DENSE);
    let when = |at: usize| course[at].cycle as f64 + course[at].phase;
    let time = |sample: &PoincareSample| sample.cycle as f64 + sample.phase;
    assert!(found.len() > 50, "{}", found.len());
    for sample in &found {
        assert_eq!(sample.kind, SampleKind::ForceMaximum);
        assert!(
            maxima.iter().any(|&at| near(time(sample), when(at))),
            "{sample:?}"
        );
    }
    // Other maxima of the force over time do not count: the force jumps down with the stiffness, or at a release.
    for at in maxima {
        let phase = course[at].phase;
        let ended =
            |event: &Event| near(event.cycle as f64 + event.time / model.period(), when(at));
        let stepped =
            near(phase, 0.6) || near(phase, 0.0) || near(phase, 1.0) || events.iter().any(ended);
        assert!(
            stepped || found.iter().any(|sample| near(time(sample), when(at))),
            "{:?}",
            course[at]
        );
    }
}

/// One mode of participation w: `w q = δ + e`. A sample on `w q = 8 µm` has δ = 8 µm − e at its phase, and one on
/// `w q' = 0` has δ' = −e'.
#[test]
fn a_surface_is_where_its_combination_has_its_level() {
    const ERROR: f64 = 5e-6;
    let model = rattling(0.0);
    let surface = |displacement: f64, velocity: f64, level: f64, rising| {
        Section::Surface(Surface {
            displacement: vec![displacement],
            velocity: vec![velocity],
            level,
            rising,
        })
    };
    let both = samples(&model, surface(1.3, 0.0, 8e-6, None));
    assert!(both.len() > 80, "{}", both.len());
    for pair in both.windows(2) {
        assert_ne!(pair[0].kind, pair[1].kind);
    }
    let turn = std::f64::consts::TAU;
    for sample in &both {
        let error = ERROR * (turn * sample.phase).cos();
        let off = sample.deflection + error - 8e-6;
        assert!(off.abs() < 1e-17, "{sample:?} {off:e}");
        let rate = sample.velocity - turn / model.period() * ERROR * (turn * sample.phase).sin();
        assert_eq!(
            rate > 0.0,
            sample.kind == SampleKind::SurfaceUp,
            "{sample:?}"
        );
    }
    let rising = samples(&model, surface(1.3, 0.0, 8e-6, Some(true)));
    let up = both.iter().filter(|s| s.kind == SampleKind::SurfaceUp);
    assert!(up.eq(&rising));
    for sample in samples(&model, surface(0.0, 1.3, 0.0, None)) {
        let rate = turn / model.period() * ERROR * (turn * sample.phase).sin();
        assert!((sample.velocity - rate).abs() < 1e-9, "{sample:?} {rate}");
    }
}
