//! `atlas runup` and `atlas sound` as a user runs them.

#![allow(clippy::unwrap_used)]

use crate::program::{printed, refused, said};
use gearatlas::store::{ResultTable, TableKind};
use std::path::Path;
use tempfile::TempDir;

const SPEED: &str = r#"speed = { from = "600 rpm", to = "1500 rpm", in = "0.2 s" }"#;

/// A folder with the rigid pair of the tiers, and the given run-up.
fn folder(runup: &str) -> TempDir {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/tiers/torsional.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), format!("{text}\n{runup}\n")).unwrap();
    folder
}

/// All tables exist with their expected contents, a second time with the same bytes; a sound file has the length of the
/// signal.
#[test]
fn a_run_up_has_its_tables_and_its_sound() {
    let own = format!(
        "[runup]\n{SPEED}\nsettle = 0\norders = [0, 20]\nrevolutions = 1\nsample_rate = 8000\nfrequency_step = 50\nsignals = [\"deflection\", \"force\"]"
    );
    let folder = folder(&own);
    let at = folder.path();
    let text = said(at, &["runup", "m.toml", "--out", "a"]);
    assert!(text.contains("600 to 1500 rpm in 0.2 s"), "{text}");
    said(at, &["runup", "m.toml", "--out", "b", "--threads", "1"]);
    let kinds = [
        TableKind::Signals,
        TableKind::OrderTracks,
        TableKind::Levels,
        TableKind::Spectrogram,
        TableKind::ContactChanges,
    ];
    for kind in kinds {
        let [a, b] =
            ["a", "b"].map(|out| std::fs::read(at.join(out).join(kind.file_name())).unwrap());
        assert!(a == b, "{}", kind.name());
        assert!(ResultTable::read(&at.join("a"), kind).is_ok());
    }
    let column = |kind, name: &str| -> Vec<f64> {
        let table = ResultTable::read(&at.join("a"), kind).unwrap();
        table
            .f64(name)
            .unwrap()
            .into_iter()
            .map(Option::unwrap)
            .collect()
    };
    let (times, speeds) = (
        column(TableKind::Signals, "time"),
        column(TableKind::Signals, "speed"),
    );
    assert_eq!((times.len(), times[0], times[1600]), (1601, 0.0, 0.2));
    let rpm = std::f64::consts::TAU / 60.0;
    assert!((speeds[0] / rpm - 600.0).abs() < 1e-9 && (speeds[1600] / rpm - 1500.0).abs() < 1e-9);
    // Order 0 is the mean, computed with another window.
    let (orders, amplitudes) = (
        column(TableKind::OrderTracks, "order"),
        column(TableKind::OrderTracks, "amplitude"),
    );
    let means = column(TableKind::Levels, "mean");
    let of_order = orders
        .iter()
        .zip(&amplitudes)
        .filter(|(order, _)| **order == 0.0);
    assert_eq!(of_order.clone().count(), means.len());
    for ((_, amplitude), mean) in of_order.zip(&means) {
        assert!(
            (amplitude / mean.abs() - 1.0).abs() < 0.2,
            "{amplitude} {mean}"
        );
    }
    let text = printed(at, &["sound", "a", "--signal", "force"]);
    assert!(
        text.contains("24 bit") && text.contains(" N about the mean"),
        "{text}"
    );
    let bytes = std::fs::read(at.join("a/force.wav")).unwrap();
    assert!(bytes.starts_with(b"RIFF") && bytes.len() >= 3 * 1601);
    let again = refused(at, &["sound", "a", "--signal", "force"], 2);
    assert!(again.contains("--overwrite"), "{again}");
    // The new file takes the name of the old one, whose bytes stay as they are.
    std::fs::hard_link(at.join("a/force.wav"), at.join("old.wav")).unwrap();
    let louder = [
        "sound",
        "a",
        "--signal",
        "force",
        "--full-scale=1e9",
        "--overwrite",
    ];
    printed(at, &louder);
    let [old, new] = ["old.wav", "a/force.wav"].map(|name| std::fs::read(at.join(name)).unwrap());
    assert!(old == bytes && new != bytes);
    let unknown = refused(at, &["sound", "a", "--signal", "noise"], 2);
    assert!(unknown.contains("force, deflection"), "{unknown}");
    let scale = refused(at, &["sound", "a", "--full-scale=-1", "--out", "x.wav"], 2);
    assert!(scale.contains("positive"), "{scale}");
    let occupied = refused(at, &["runup", "m.toml", "--out", "a"], 2);
    assert!(occupied.contains("--overwrite"), "{occupied}");
}

/// A measured speed over time goes up, rests and goes down, with torques. Speed and load equal those of the file at its
/// times, and are linear in between.
#[test]
fn a_bench_gives_the_course() {
    const REST: &str = "settle = 0\nsample_rate = 1000\nrevolutions = 1\nfrequency_step = 50\nsignals = [\"force\"]";
    let folder = folder(&format!("[runup]\npoints = \"bench.csv\"\n{REST}"));
    let at = folder.path();
    let bench =
        "time [ms];speed [rpm];torque [N m]\n1200;600;5\n1400;1500;15\n1500;1500;15\n1700;900;10\n";
    std::fs::write(at.join("bench.csv"), bench).unwrap();
    let text = said(at, &["runup", "m.toml", "--out", "a"]);
    assert!(
        text.contains("600 to 900 rpm in 0.5 s, load 0.1 to 0.2"),
        "{text}"
    );
    let column = |out: &str, name: &str| -> Vec<f64> {
        let table = ResultTable::read(&at.join(out), TableKind::Signals).unwrap();
        let column = table.f64(name).unwrap();
        column.into_iter().map(Option::unwrap).collect()
    };
    let rpm = std::f64::consts::TAU / 60.0;
    let (speeds, loads) = (column("a", "speed"), column("a", "load"));
    for (sample, speed, load) in [
        (0, 600.0, 0.1),
        (200, 1500.0, 0.3),
        (250, 1500.0, 0.3),
        (500, 900.0, 0.2),
    ] {
        assert!((speeds[sample] / rpm - speed).abs() < 1e-9, "{sample}");
        assert!((loads[sample] - load).abs() < 1e-12, "{sample}");
    }
    let run = |out: &str, section: &str| {
        let text = std::fs::read_to_string(at.join("m.toml")).unwrap();
        let (head, _) = text.split_once("[runup]").unwrap();
        std::fs::write(
            at.join("n.toml"),
            format!("{head}[runup]\n{section}\n{REST}"),
        )
        .unwrap();
        said(at, &["runup", "n.toml", "--out", out]);
        column(out, "force")
    };
    let line = run("line", &format!("{SPEED}\nload = [0.1, 0.3]"));
    let through =
        "points = [{ time = 3, speed = \"600 rpm\" }, { time = 3.2, speed = \"1500 rpm\" }]";
    let over_speed = "[{ speed = \"600 rpm\", torque = 5 }, { speed = \"1500 rpm\", torque = 15 }]";
    for (out, load) in [
        (
            "over-time",
            "[{ time = 3, load = 0.1 }, { time = 3.2, load = 0.3 }]",
        ),
        ("over-speed", over_speed),
    ] {
        let found = run(out, &format!("{through}\nload_points = {load}"));
        for (a, b) in line.iter().zip(&found) {
            assert!((a - b).abs() < 1e-6 * (1.0 + a.abs()), "{out}: {a} {b}");
        }
    }
}

/// The mesh from the drawing is that of the operating point, so that the load of the run-up may start at zero.
#[test]
fn the_mesh_is_that_of_the_operating_point() {
    let folder = folder(&format!(
        "[runup]\n{SPEED}\nsettle = 0\nload = [0, 0.3]\nsignals = [\"force\"]"
    ));
    let path = folder.path().join("m.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let given = ["mean_stiffness", "contact_ratio", "single_pair_drop"];
    let kept = text
        .lines()
        .filter(|line| !given.iter().any(|key| line.starts_with(key)));
    let drawn = kept
        .collect::<Vec<_>>()
        .join("\n")
        .replace("\"piecewise\"", "\"table\"");
    std::fs::write(path, drawn).unwrap();
    let text = said(folder.path(), &["runup", "m.toml", "--out", "a"]);
    assert!(text.contains("load 0 to 0.3"), "{text}");
}

/// A modal file must tell where the torque acts that accelerates the drive.
#[test]
fn the_accelerating_torque_needs_a_position() {
    let folder = tempfile::tempdir().unwrap();
    let write = |more: &str| {
        let file = format!(
            "teeth = 20\nrated_force = 1000.0\nfrequency = [0.0, 0.0]\ndamping = [0.0, 0.0]\n\
             mesh = [0.6, 0.5]\ntorque = [0.6, 0.5]\n{more}"
        );
        std::fs::write(folder.path().join("a.modal.toml"), file).unwrap();
    };
    let manifest = format!(
        "[job]\nname = \"m\"\n[model]\nkind = \"modal\"\nfile = \"a.modal.toml\"\n[mesh]\nhalf_gap = \"10 um\"\n\
         stiffness = \"constant\"\nmean_stiffness = \"4e8 N/m\"\ncontact_damping = \"1000 N*s/m\"\n\
         [grid]\nload = 0.5\nspeed = 150\n[run]\ntransient = 1\ncycles = 10\n[runup]\n{SPEED}\nsignals = [\"force\"]\n"
    );
    std::fs::write(folder.path().join("m.toml"), manifest).unwrap();
    let arguments = ["runup", "m.toml", "--out", "a"];
    write("torque_wheel = [0.0, -20.0]");
    let text = refused(folder.path(), &arguments, 2);
    assert!(
        text.contains("accelerates the drive") && text.contains("torque_pinion"),
        "{text}"
    );
    write("torque_pinion = [30.0, 0.0]");
    said(folder.path(), &arguments);
}

/// Invalid run-ups are refused with a remedy, and nothing is written.
#[test]
fn what_is_no_run_up_is_refused() {
    for (own, parts) in [
        ("", ["no table [runup]", "speed = {"]),
        (
            "[runup]\nspeed = { from = 0, to = 20, in = 1 }",
            ["runup.speed.from", "greater than 0"],
        ),
        (
            "[runup]\nspeed = { from = 20, to = 20, in = 1 }",
            ["both speeds", "atlas trace"],
        ),
        (
            "[runup]\nspeed = { from = 10, to = 20, in = 5000 }",
            ["too long", "sample_rate"],
        ),
        (
            "[runup]\nspeed = { from = 10, in = 1 }",
            ["runup.speed.to", "missing"],
        ),
        ("[runup]\nload = 0.1", ["runup.speed", "missing"]),
        (
            "[runup]\npoints = [{ time = 0, speed = 10 }, { time = 2, speed = 20 }, { time = 1, speed = 30 }]",
            ["`time` goes back or stays, from 2 to 1", "increasing order"],
        ),
        (
            "[runup]\npoints = [{ time = 0, speed = 10 }, { time = 1, speed = 0 }]",
            ["greater than 0", "runup.points.speed"],
        ),
        (
            "[runup]\npoints = [{ time = 0, speed = 10 }]",
            ["needs two", "increasing order"],
        ),
        (
            "[runup]\npoints = [{ time = 0, rpm = 10 }, { time = 1, rpm = 12 }]",
            ["`rpm` is not a column", "time, speed, load, torque"],
        ),
        (
            "[runup]\npoints = [{ time = 0, load = 0.1 }, { time = 1, load = 0.2 }]",
            ["needs a column `speed`", "time [s],speed [rpm]"],
        ),
        (
            "[runup]\nspeed = { from = 10, to = 20, in = 1 }\npoints = \"a.csv\"",
            ["both give the same course", "keep one"],
        ),
        (
            "[runup]\nload = 0.1\npoints = [{ time = 0, speed = 10, load = 0.1 }, { time = 1, speed = 20, load = 0.2 }]",
            ["both give the load", "keep one"],
        ),
        (
            "[runup]\npoints = \"absent.csv\"",
            ["cannot be read", "check the path"],
        ),
        (
            "[runup]\nspeed = { from = 10, to = 20, in = 1 }\nload_points = [{ speed = 0, load = 0.1 }, { speed = 1, torque = 0.2 }]",
            ["point 2 has `torque`", "same keys"],
        ),
    ] {
        let folder = folder(own);
        let text = refused(folder.path(), &["runup", "m.toml", "--out", "a"], 2);
        for part in parts {
            assert!(text.contains(part), "{own}: {text}");
        }
        assert!(!folder.path().join("a").exists(), "{own}");
    }
    let folder = tempfile::tempdir().unwrap();
    let text = refused(folder.path(), &["sound", "."], 2);
    assert!(text.contains("atlas runup"), "{text}");
}

/// Drive and coast flanks of a further mesh act along separate lines. While a train coasts, the forces of both meshes are
/// negative, and balance the torques on the middle shaft.
#[test]
fn further_meshes_coast_with_a_negative_force() {
    const TRAIN: &str = r#"
[job]
name = "coasting"
[model]
kind = "train"
damping = 0.0
[train]
gears = ["a", "b"]
rated_torque = "50 N*m"
[[train.shaft]]
name = "in"
motion = "rotation"
discs = [{ at = 0, polar_inertia = 0.01 }]
gears = [{ name = "a", at = 0, teeth = 20, module = "3 mm", width = "20 mm", body = { polar_inertia = 2e-3 } }]
[[train.shaft]]
name = "middle"
motion = "rotation"
origin = ["105.1 mm", 0, 0]
gears = [
    { name = "b", at = 0, teeth = 50, module = "3 mm", width = "20 mm", body = { polar_inertia = 0.02 } },
    { name = "c", at = "50 mm", teeth = 22, module = "4 mm", width = "20 mm", body = { polar_inertia = 0.003 } },
]
[[train.shaft]]
name = "out"
motion = "rotation"
output = 1
origin = ["105.1 mm", "150.2 mm", 0]
gears = [{ name = "d", at = "50 mm", teeth = 53, module = "4 mm", width = "20 mm", body = { polar_inertia = 0.05 } }]
[[train.mesh]]
gears = ["c", "d"]
stiffness = "4e8 N/m"
damping = "2000 N*s/m"
[mesh]
stiffness = "constant"
mean_stiffness = "3e8 N/m"
contact_damping = "1500 N*s/m"
[excitation]
transmission_error = [{ harmonic = 1, amplitude = "0.1 um" }]
[grid]
load = -0.5
speed = 200
[runup]
speed = { from = 200, to = 200.1, in = "0.1 s" }
load = -0.5
settle = "1 s"
signals = ["force", "meshes"]
"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), TRAIN).unwrap();
    said(folder.path(), &["runup", "m.toml", "--out", "a"]);
    let table = ResultTable::read(&folder.path().join("a"), TableKind::Signals).unwrap();
    let mean = |name: &str| {
        let values: Vec<f64> = table.f64(name).unwrap().into_iter().flatten().collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let [first, second] = ["force", "mesh_force_c_and_d"].map(mean);
    // Base radii of b and c.
    let ratio = (50.0 * 3.0) / (22.0 * 4.0);
    assert!(first < -100.0, "{first}");
    assert!(
        (second / (first * ratio) - 1.0).abs() < 0.02,
        "{first} {second}"
    );
}
