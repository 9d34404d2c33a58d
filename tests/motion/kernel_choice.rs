//! Which kernel does `run.kernel = "auto"` take, what do `atlas check` and `run.json` report about it, and what happens
//! to tables of closed modes that cannot be used or kept? With the real program.

#![allow(clippy::unwrap_used)]

use crate::{place, results};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use results::{assert_same, physics};
use serde_json::{Value, json};
use std::fmt::Write;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A free rotation and an undamped mode.
const TWO_MODES: &str = "teeth = 20\nrated_force = 1330.0\nfrequency = [0.0, 5000.0]\ndamping = [0.0, 0.0]\n\
                         mesh = [0.8, 0.6]\ntorque = [0.8, 0.0]\n";

/// Two speeds on that structure: at 250 rad/s the mesh frequency is that of the mode.
const DRIVE: &str = r#"
[job]
name = "two-modes"
[model]
kind = "modal"
file = "two.modal.toml"
[mesh]
half_gap = "15 um"
stiffness = "constant"
mean_stiffness = "1.6e7 N/m"
contact_damping = "600 N*s/m"
[excitation]
transmission_error = [{ harmonic = 1, amplitude = "5 um" }]
[grid]
load = 0.1
speed = { values = [250, 300] }
[run]
kernel = "auto"
transient = 20
cycles = 50
[analyses]
lyapunov = { exponents = 2 }
"#;

const POINTS: [&str; 1] = ["points.parquet"];

fn two_modes(manifest: &str) -> Place {
    let place = Place::new(manifest);
    fs::write(place.path("two.modal.toml"), TWO_MODES).unwrap();
    place
}

/// The oscillator with a kernel.
fn oscillator(kernel: &str) -> Place {
    Place::new(&OSCILLATOR.replace("[run]", &format!("[run]\nkernel = \"{kernel}\"")))
}

/// The line of a kernel that `atlas check` prints.
fn checked(place: &Place, arguments: &[&str]) -> String {
    let output = place.atlas(&[&["check", "m.toml"], arguments].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(!place.path("tables").is_dir(), "check writes no file");
    let text = stdout(&output);
    let line = text.lines().find_map(|line| line.strip_prefix("kernel "));
    line.unwrap_or_default().trim().to_owned()
}

fn kernel_record(kernel: &str, points: u64, first: u64, why: &str) -> Value {
    json!({ "kernel": kernel, "points": points, "first_point": first, "why": why })
}

/// The results of a point as text.
fn row(folder: &Path, id: usize) -> String {
    let text = physics(folder, "points.parquet");
    text.split("point_id=")
        .nth(1 + id)
        .unwrap()
        .trim()
        .to_owned()
}

/// A small drive gets closed modes: the results are those of this kernel, on any number of threads, in shards, and with
/// an existing table. Record and `atlas check` give the reason.
#[test]
fn a_small_drive_gets_closed_modes() {
    let place = oscillator("auto");
    let why = "1 mode, 9 sets of closed contacts, 0.012 MB of tables";
    assert_eq!(checked(&place, &[]), format!("closed_modes (auto: {why})"));
    let auto = place.whole("auto", &["--threads", "1"]);
    let expected = json!([kernel_record("closed_modes", 6, 0, why)]);
    assert_eq!(place.record("auto")["kernels"], expected);
    let again = place.whole("again", &["--threads", "2"]);
    let named = place.whole("named", &["--set", "run.kernel=closed_modes"]);
    assert_eq!(place.record("named").get("kernels"), None);
    for shard in ["1/2", "2/2"] {
        place.whole("parts", &["--shard", shard]);
    }
    let merged = place.atlas(&["merge", "parts", "--out", "merged"]);
    assert_eq!(status(&merged), 0, "{}", stderr(&merged));
    assert_eq!(place.record("merged")["kernels"], expected);
    for other in [again, named, place.path("merged")] {
        assert_same(&POINTS, &auto, &other);
    }
    let json = stdout(&place.atlas(&["check", "m.toml", "--json"]));
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&json["kernel"], &json["kernel_why"]),
        (&json!("closed_modes"), &json!(why))
    );
}

/// Each point of a job decides separately: in resonance with the mode there is no steady motion as a reference.
#[test]
fn points_of_a_job_get_kernels_of_their_own() {
    let place = two_modes(DRIVE);
    let why = "an undamped mode is in resonance with the harmonic at 5.000000e3 rad/s";
    let line = checked(&place, &[]);
    assert_eq!(line, format!("volterra (auto: {why})"));
    let mixed = place.whole("mixed", &["--threads", "1"]);
    let small = "2 modes, 4 sets of closed contacts, 0.005 MB of tables";
    let records = json!([
        kernel_record("closed_modes", 1, 1, small),
        kernel_record("volterra", 1, 0, why),
    ]);
    assert_eq!(place.record("mixed")["kernels"], records);
    for (id, kernel) in ["volterra", "closed_modes"].into_iter().enumerate() {
        let named = place.whole(kernel, &["--set", &format!("run.kernel={kernel}")]);
        assert!(row(&mixed, id).contains(&format!("\"{kernel}\"")));
        assert_eq!(row(&mixed, id), row(&named, id), "{kernel}");
    }
}

/// Drives that closed modes do not support go to the structured kernel, with its bits, and with a reason.
#[test]
fn other_drives_get_the_structured_kernel() {
    let mut many = String::from("teeth = 20\nrated_force = 1330.0\n");
    for (key, first, other) in [
        ("frequency", "0.0", "1000.0"),
        ("damping", "0.0", "0.01"),
        ("mesh", "0.9", "0.01"),
        ("torque", "0.9", "0.0"),
    ] {
        let others = (1..80).map(|mode| match key {
            "frequency" => format!(", {}.0", 1000 * mode),
            _ => format!(", {other}"),
        });
        let others: String = others.collect();
        writeln!(many, "{key} = [{first}{others}]").unwrap();
    }
    let place = oscillator("auto");
    fs::write(place.path("many.modal.toml"), &many).unwrap();
    let varying = [
        "--set",
        "mesh.stiffness=fourier",
        "--set",
        "mesh.stiffness_harmonics=[{ harmonic = 1, amplitude = \"4e7 N/m\" }]",
        "--set",
        "mesh.contact_ratio=",
        "--set",
        "mesh.single_pair_drop=",
    ];
    let cannot = "the mesh stiffness varies within its segments, which tables of matrix exponentials cannot follow";
    let by_force = "tables cannot represent contacts that open when their force vanishes";
    for (set, why) in [
        (&varying[..], cannot),
        (&["--set", "mesh.release=force"], by_force),
        (
            &["--set", "run.instructions=portable"],
            "instructions = \"portable\"",
        ),
        (
            &["--set", "model.file=many.modal.toml"],
            "80 modes, more than 24",
        ),
    ] {
        assert_eq!(checked(&place, set), format!("volterra (auto: {why})"));
    }
    let set = varying;
    let auto = place.whole("auto", &set);
    let kernels = &place.record("auto")["kernels"];
    assert_eq!(kernels[0]["kernel"], "volterra", "{kernels}");
    assert!(!place.path("tables").is_dir());
    let named = [&set[..], &["--set", "run.kernel=volterra"]].concat();
    assert_same(&POINTS, &auto, &place.whole("named", &named));

    // Tables for fifteen levels and eighty modes are larger than the limit for keeping them.
    let levels: Vec<String> = (0..15).map(|k| format!("\"{}e7 N/m\"", 30 + k)).collect();
    let levels = format!("mesh.values=[{}]", levels.join(", "));
    let large = [
        "--set",
        &levels,
        "--set",
        "mesh.mean_stiffness=",
        "--set",
        "mesh.contact_ratio=",
        "--set",
        "mesh.single_pair_drop=",
        "--set",
        "mesh.contact_damping=\"1000 N*s/m\"",
        "--set",
        "model.file=many.modal.toml",
        "--set",
        "run.kernel=closed_modes",
        "--set",
        "run.transient=2",
        "--set",
        "run.cycles=30",
        "--set",
        "grid.load=0.1",
        "--set",
        "grid.speed=1200",
    ];
    let said = "the tables of the 256 sets of closed contacts need 388 MB, but at most 256 MB are kept; keep fewer modes or \
                fewer levels of stiffness";
    let line = checked(&place, &large);
    assert_eq!(
        line,
        format!("closed_modes (it does not accept this drive: {said})")
    );
    let output = place.run("large", &large);
    assert_eq!(status(&output), 3, "{}", stderr(&output));
    let rows = physics(&place.path("large"), "points.parquet");
    let remedy = "; or set run.kernel = \\\"volterra\\\", which computes this mesh cycle in";
    assert!(rows.contains(&format!("{said}{remedy}")), "{rows}");
}

/// Asserts that the first two of four points equal those of `volterra` and the others those of `closed_modes`.
/// `closed_modes` refuses the first point; returns its results.
fn row_of_refused_point(place: &Place, auto: &Path) -> String {
    let volterra = place.whole("volterra", &["--set", "run.kernel=volterra"]);
    let output = place.run("closed", &["--set", "run.kernel=closed_modes"]);
    assert_eq!(status(&output), 3, "{}", stderr(&output));
    let closed = place.path("closed");
    for id in 0..4 {
        let named = if id < 2 { &volterra } else { &closed };
        assert_eq!(row(auto, id), row(named, id), "{id}");
    }
    row(&closed, 0)
}

/// Closed contacts in which `λ² + 3000 λ + 1.6e7` is a double factor and the eigenvectors of both pairs are the same:
/// with w = (0.8, 0.6), k = 0.64 · 5000² and c = 1.2 · 5000 the characteristic polynomial is its square.
#[test]
fn nearly_defective_systems_go_to_the_structured_kernel() {
    let both =
        "load = 0.1\n\"mesh.contact_damping\" = { values = [\"6000 N*s/m\", \"600 N*s/m\"] }";
    let both = DRIVE.replace("load = 0.1", both);
    let place = two_modes(&both.replace("[250, 300]", "[300, 310]"));
    let why = "the eigenvectors of a mesh segment are nearly parallel";
    let line = checked(&place, &[]);
    assert_eq!(line, format!("volterra (auto: {why}; the first point)"));
    let auto = place.whole("auto", &["--threads", "2"]);
    let small = "2 modes, 4 sets of closed contacts, 0.005 MB of tables";
    let records = json!([
        kernel_record("closed_modes", 2, 2, small),
        kernel_record("volterra", 2, 0, why),
    ]);
    assert_eq!(place.record("auto")["kernels"], records);
    assert_eq!(fs::read_dir(place.path("tables")).unwrap().count(), 1);
    let refused = row_of_refused_point(&place, &auto);
    let remedy = "or set run.kernel = \\\"volterra\\\", which computes this mesh cycle in";
    assert!(
        refused.contains(why) && refused.contains(remedy),
        "{refused}"
    );
}

/// Nine contacts have 512 active sets, and a set gets its table when it first occurs. If that of the first contact is
/// nearly defective, as above, the structured kernel recomputes the point.
#[test]
fn a_point_that_meets_a_set_without_a_table_is_computed_anew() {
    let both =
        "load = 0.1\n\"mesh.contact_damping\" = { values = [\"6000 N*s/m\", \"600 N*s/m\"] }";
    let both = DRIVE.replace("load = 0.1", both);
    let place = Place::new(&both.replace("[250, 300]", "[300, 310]"));
    let mut structure = TWO_MODES.to_owned();
    for stop in 1..8 {
        writeln!(
            structure,
            "[[contact]]\nname = \"stop {stop}\"\nparticipation = [0.2, 0.{stop}]\ngap = 1.0\nstiffness = 1e7"
        )
        .unwrap();
    }
    fs::write(place.path("two.modal.toml"), structure).unwrap();
    let auto = place.whole("auto", &["--threads", "2"]);
    let met = "2 modes, 512 sets of closed contacts, with tables computed on demand";
    let records = json!([
        kernel_record("closed_modes", 2, 2, met),
        kernel_record(
            "volterra",
            2,
            0,
            "no table for a set of closed contacts in the motion"
        ),
    ]);
    assert_eq!(place.record("auto")["kernels"], records);
    let refused = row_of_refused_point(&place, &auto);
    let why = "the eigenvectors of a mesh segment are nearly parallel";
    assert!(refused.contains(why), "{refused}");
}

/// A resumed run counts the points of both parts, and its results are those of an uninterrupted run.
#[test]
fn an_interrupted_run_takes_the_same_kernels() {
    // Many points, so that the interrupt comes before the last one.
    let speeds: Vec<String> = (0..1500)
        .map(|i| format!("{}", 300.0 + 0.05 * f64::from(i)))
        .collect();
    let many = DRIVE.replace("[250, 300]", &format!("[250, {}]", speeds.join(", ")));
    let place = two_modes(&many);
    let mut command = place.command("parts", &["--json", "--quiet", "--threads", "1"]);
    let mut run = command.stdout(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(run.stdout.take().unwrap()).lines();
    let mut points = 0;
    for line in lines {
        points += usize::from(line.unwrap().contains("\"event\":\"point\""));
        if points == 1 {
            let interrupt = format!("kill -s INT {}", run.id());
            Command::new("sh")
                .args(["-c", &interrupt])
                .status()
                .unwrap();
        }
    }
    run.wait().unwrap();
    let record = place.record("parts");
    assert_eq!(record["state"], "interrupted", "{record:#}");
    let parts = place.whole("parts", &["--threads", "1"]);
    let whole = place.whole("whole", &["--threads", "1"]);
    assert_same(&POINTS, &parts, &whole);
    let [parts, whole] = ["parts", "whole"].map(|out| place.record(out)["kernels"].clone());
    assert_eq!(parts, whole);
    assert_eq!(
        (&whole[0]["points"], &whole[1]["points"]),
        (&json!(1500), &json!(1))
    );
}

/// Tables of another structure, truncated tables, and tables with flipped bits or another format give one line each.
/// New tables give the same results.
#[test]
fn tables_that_cannot_be_used_are_made_anew() {
    let place = oscillator("auto");
    let first = place.whole("first", &[]);
    let entries = || fs::read_dir(place.path("tables")).unwrap();
    let files: Vec<PathBuf> = entries().map(|entry| entry.unwrap().path()).collect();
    let [file] = &files[..] else {
        panic!("{files:?}")
    };
    let whole = fs::read(file).unwrap();
    let other = two_modes(&DRIVE.replace("[250, 300]", "[300]"));
    other.whole("other", &[]);
    let mut others = fs::read_dir(other.path("tables")).unwrap();
    let foreign = fs::read(others.next().unwrap().unwrap().path()).unwrap();
    let with = |place: usize, byte: u8| {
        let mut bytes = whole.clone();
        bytes[place] ^= byte;
        bytes
    };
    for (name, bytes, said) in [
        ("foreign", foreign, "was computed from other inputs"),
        (
            "cut",
            whole[..whole.len() - 9].to_vec(),
            "is cut off or damaged",
        ),
        ("flipped", with(whole.len() - 5, 1), "is cut off or damaged"),
        (
            "older",
            with(12, 1),
            "has format version 3; this program reads version 2",
        ),
        ("empty", Vec::new(), "is cut off or damaged"),
    ] {
        fs::remove_file(file).unwrap();
        fs::write(file, bytes).unwrap();
        let output = place.run(name, &["--threads", "2"]);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let warnings = place.record(name)["warnings"].clone();
        let [warning] = &warnings.as_array().unwrap()[..] else {
            panic!("{name}: {warnings}")
        };
        let warning = warning.as_str().unwrap();
        assert!(
            warning.contains(said) && warning.ends_with("; the table is computed again"),
            "{name}: {warning}"
        );
        assert_eq!(
            stderr(&output).matches("computed again").count(),
            1,
            "{}",
            stderr(&output)
        );
        assert_same(&POINTS, &first, &place.path(name));
        assert!(fs::read(file).unwrap() == whole, "{name}");
    }
}

/// A file named `tables` prevents the folder. There is one warning, tables stay in memory, and the results are the
/// same.
#[test]
fn tables_that_cannot_be_kept_stay_in_memory() {
    let place = oscillator("auto");
    let kept = place.whole("kept", &[]);
    fs::remove_dir_all(place.path("tables")).unwrap();
    fs::write(place.path("tables"), "in the way").unwrap();
    let output = place.run("memory", &["--threads", "2"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let warnings = place.record("memory")["warnings"].clone();
    let [warning] = &warnings.as_array().unwrap()[..] else {
        panic!("{warnings}")
    };
    let said = "a computed table cannot be kept for the next run";
    assert!(warning.as_str().unwrap().starts_with(said), "{warning}");
    let told = stderr(&output);
    assert_eq!(told.matches(said).count(), 1, "{told}");
    assert_same(&POINTS, &kept, &place.path("memory"));
    assert_eq!(
        fs::read_to_string(place.path("tables")).unwrap(),
        "in the way"
    );
}
