//! Reaction time to Ctrl-C: in any stage of a command, the process ends soon after the signal, with the status of an
//! interruption, and keeps finished results.

#![allow(clippy::unwrap_used)]

use crate::place;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use std::fmt::Write;
use std::fs::{self, File};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time limit for the end of a process: a second, plus the delay on a busy machine.
const SOON: Duration = Duration::from_secs(5);

/// Time of the signal: the work has begun by then, and is far from finished.
const BEGUN: Duration = Duration::from_millis(1500);

/// Starts a command, sends it SIGINT after [`BEGUN`] and returns its standard error.
fn interrupted(place: &Place, arguments: &[&str]) -> String {
    let clock = Instant::now();
    interrupted_once(place, arguments, || clock.elapsed() >= BEGUN)
}

/// Starts a command, sends it SIGINT as soon as `begun` is true, and returns its standard error.
fn interrupted_once(place: &Place, arguments: &[&str], begun: impl Fn() -> bool) -> String {
    let said = place.path("said");
    let mut command = Command::new(env!("CARGO_BIN_EXE_atlas"));
    command.current_dir(place.path("")).args(arguments);
    command.args(["--tables", "tables"]).stdout(Stdio::null());
    if ["check", "verify", "machine"].contains(&arguments[0]) {
        command = Command::new(env!("CARGO_BIN_EXE_atlas"));
        command
            .current_dir(place.path(""))
            .args(arguments)
            .stdout(Stdio::null());
    }
    let mut process = command
        .stderr(File::create(&said).unwrap())
        .spawn()
        .unwrap();
    let words = || fs::read_to_string(&said).unwrap();
    let mut early = None;
    while early.is_none() && !begun() {
        sleep(Duration::from_millis(20));
        early = process.try_wait().unwrap();
    }
    assert_eq!(early, None, "{arguments:?} has ended already: {}", words());
    let pid = process.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().unwrap();
    assert!(sent.success());
    let clock = Instant::now();
    let ended = loop {
        if let Some(ended) = process.try_wait().unwrap() {
            break ended;
        }
        if clock.elapsed() > SOON {
            process.kill().unwrap();
            process.wait().unwrap();
            panic!("{arguments:?} did not end within {SOON:?}: {}", words());
        }
        sleep(Duration::from_millis(20));
    };
    assert_eq!(ended.code(), Some(130), "{arguments:?}: {}", words());
    words()
}

/// A gear pair with crowned flanks, whose mesh tables take seconds each, at forty loads.
const GEARS: &str = r#"
[job]
name = "gears"
[model]
kind = "torsional"
[gear]
teeth = [50, 50]
module = "3 mm"
face_width = "120 mm"
body_length = ["20 mm", "20 mm"]
bore = "60 mm"
lead_crowning = "5 um"
rated_torque = "340 N*m"
centre_distance = "150 mm"
thinning = "72 um"
[shafts]
density = "7850 kg/m^3"
span = "120 mm"
overhang = "40 mm"
pinion = { diameter = "30 mm", end_inertia = 0 }
wheel = { diameter = "30 mm", end_inertia = 0 }
[mesh]
stiffness = "table"
segments = 48
misalignment = 1e-4
contact_damping = 0.03
[grid]
load = { from = 0.1, to = 1.0, count = 40 }
speed = { values = [500] }
[run]
transient = 20
cycles = 60
[analyses]
"#;

#[test]
fn mesh_tables() {
    let place = Place::new(GEARS);
    let said = interrupted(&place, &["run", "m.toml", "--out", "r"]);
    assert!(!said.contains("panicked"), "{said}");
    let torques: Vec<String> = (1..=40).map(|i| format!("{i} N*m")).collect();
    interrupted(&place, &["table", "m.toml", "--torque", &torques.join(",")]);
    // A plan needs the tables of a few points only.
    let clock = Instant::now();
    let begun = || clock.elapsed() >= BEGUN / 4;
    interrupted_once(&place, &["plan", "m.toml"], begun);
}

/// Shafts with about 1900 degrees of freedom, whose modes take seconds to minutes.
const SHAFTS: &str = r#"
[job]
name = "shafts"
[model]
kind = "flexible"
modes = 1000
[gear]
teeth = [20, 30]
module = "4 mm"
pressure_angle = "20 deg"
face_width = "20 mm"
body_length = ["70 mm", "40 mm"]
rated_torque = "50 N*m"
[shafts]
young_modulus = "206 GPa"
shear_modulus = "79 GPa"
density = "7850 kg/m^3"
span = "120 mm"
overhang = "40 mm"
gear_position = 0.45
elements = [60, 60, 60]
pinion = { diameter = "22 mm", end_inertia = "2e-3 kg*m^2" }
wheel = { diameter = "26 mm", end_inertia = "5e-3 kg*m^2" }
bearings = { x = "1.25e8 N/m", y = "1e8 N/m", tilt = "2e4 N*m/rad", axial = ["1e8 N/m", 0] }
[mesh]
half_gap = "10 um"
stiffness = "piecewise"
mean_stiffness = "4e8 N/m"
contact_ratio = 1.6
single_pair_drop = 0.25
contact_damping = 0.05
[excitation]
transmission_error = [{ harmonic = 1, amplitude = "5 um" }]
[grid]
load = { values = [0.05, 0.3] }
speed = { from = 800, to = 1400, count = 4 }
[run]
transient = 50
cycles = 330
[analyses]
[continuation]
over = "speed"
"#;

#[test]
fn eigenvalue_problems() {
    let place = Place::new(SHAFTS);
    let point = ["m.toml", "--point", "load=0.05,speed=800"];
    for arguments in [
        &["run", "m.toml", "--out", "r"][..],
        &["follow", "m.toml", "--out", "f"],
        &["plan", "m.toml"],
        &[&["trace"][..], &point, &["--out", "t"]].concat(),
        &[&["sensitivity"][..], &point, &["--by", "mesh.half_gap"]].concat(),
    ] {
        let said = interrupted(&place, arguments);
        assert!(!said.contains("panicked"), "{said}");
    }
    assert!(!place.path("f/branches.parquet").exists());
}

#[test]
fn transients_of_orbits() {
    let sought = "\n[continuation]\nover = \"speed\"\nstarts = 2\ntransient = 1000000000\n";
    let place = Place::new(&format!("{OSCILLATOR}{sought}"));
    let said = interrupted(&place, &["follow", "m.toml", "--out", "f"]);
    assert_eq!(said, "error: interrupted; nothing was written\n");
    assert!(!place.path("f").exists());
}

#[test]
fn trajectories() {
    let place = Place::new(&OSCILLATOR.replace("transient = 50", "transient = 1000000000"));
    let point = "load=0.05,speed=600";
    interrupted(&place, &["trace", "m.toml", "--point", point, "--out", "t"]);
    assert!(!place.path("t/trace.parquet").exists());
}

/// A million points with three values of a key among them: the first is computed at once, and finished points are kept
/// when the run is cancelled.
#[test]
fn long_lists_of_points() {
    const POINTS: usize = 1_000_000;
    let grid =
        "load = { from = 0.05, to = 0.3, count = 2 }\nspeed = { from = 600, to = 1500, count = 3 }";
    let text = OSCILLATOR.replace(grid, "points = \"points.csv\"");
    let analyses = text.find("[analyses]").unwrap();
    let text = text[..analyses].replace("transient = 50", "transient = 0");
    let place = Place::new(&text.replace("cycles = 300", "cycles = 2\n[analyses]\n#"));
    let mut list = "load,speed,mesh.half_gap [um]\n".to_owned();
    for i in 0..POINTS {
        let load = 0.1 + 0.1 * (i % 7) as f64;
        writeln!(
            list,
            "{load:.1},{:.3},{}",
            500.0 + i as f64 * 1e-3,
            10 + i % 3
        )
        .unwrap();
    }
    fs::write(place.path("points.csv"), list).unwrap();
    let mut finished = 0;
    for _ in 0..2 {
        let journal = || fs::metadata(place.path("r/.journal")).map_or(0, |file| file.len());
        let before = journal();
        let run = ["run", "m.toml", "--out", "r", "--threads", "1"];
        interrupted_once(&place, &run, || journal() > before + 20_000);
        let shown = place.atlas(&["show", "r", "--json"]);
        assert_eq!(status(&shown), 0, "{}", stderr(&shown));
        let summary: serde_json::Value = serde_json::from_str(&stdout(&shown)).unwrap();
        let points = summary["points"].as_u64().unwrap();
        assert!(
            points > finished && points < POINTS as u64,
            "{points} after {finished}"
        );
        finished = points;
    }
}

#[test]
fn what_the_program_asks_itself() {
    let place = Place::new(OSCILLATOR);
    interrupted(&place, &["verify"]);
    interrupted(&place, &["machine", "--out", "m"]);
}
