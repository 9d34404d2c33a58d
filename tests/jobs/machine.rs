//! `atlas machine` as a process: it measures everything once with little memory, files and page agree, and other
//! commands read them.

#![allow(clippy::unwrap_used)]

use crate::place;
use gearatlas::store::{Characteristics, Figure};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use serde_json::Value;
use std::process::{Command, Output};

/// Arguments for one round, which a slow and busy machine can finish too.
const LITTLE: [&str; 8] = [
    "machine", "--quick", "--rounds", "1", "--memory", "8MiB", "--budget", "240",
];

fn measured(place: &Place, out: &str, topology: Option<&str>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atlas"));
    command.current_dir(place.0.path());
    command.args(LITTLE).args(["--out", out]);
    if let Some(topology) = topology {
        command.env("HWLOC_SYNTHETIC", topology);
    }
    command.output().unwrap()
}

fn check(figure: &Figure, time: bool) {
    assert!(figure.value.is_finite() && figure.value > 0.0, "{figure:?}");
    assert_eq!((figure.rounds, figure.spread), (1, None));
    if time {
        assert!(figure.median >= figure.best)
    } else {
        assert!(figure.median <= figure.best)
    }
}

#[test]
fn a_machine_is_measured_shown_compared_and_planned_with() {
    let place = Place::new(OSCILLATOR);
    let output = measured(&place, "m", None);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let page = stdout(&output);
    let found = Characteristics::read(&place.path("m")).unwrap();

    for (what, figure) in found.figures() {
        assert_eq!(figure.value, figure.best, "{what}");
        assert!(figure.repetitions >= 3, "{what}");
        check(&figure, what.starts_with("latency, "));
    }
    assert!(!found.mountain.is_empty() && !found.latency.is_empty());
    for kernel in ["read", "copy", "triad"] {
        assert!(
            found.bandwidth.iter().any(|row| row.key.kernel == kernel),
            "{kernel}"
        );
    }
    for kernel in ["volterra", "closed_modes"] {
        assert!(
            found.solver.iter().any(|row| row.key.kernel == kernel),
            "{kernel}"
        );
        assert!(
            found.roofline.iter().any(|row| row.kernel == kernel),
            "{kernel}"
        );
    }
    // The scaling over points has one point, and the eight points of all other measurements.
    let points = |points| found.solver.iter().any(|row| row.key.points == points);
    assert!(points(1) && points(8));
    // Counted work: dense products read each number once.
    let intensity = |kernel: &str| {
        let mut rows = found.roofline.iter().filter(|row| row.kernel == kernel);
        rows.find(|row| row.modes == 20).unwrap().intensity
    };
    assert!(intensity("volterra") > 2.0 * intensity("closed_modes"));

    for table in [
        "mountain",
        "bandwidth",
        "latency",
        "arithmetic",
        "solver",
        "roofline",
    ] {
        assert!(
            place.path(&format!("m/{table}.parquet")).exists(),
            "{table}"
        );
    }
    assert!(place.path("m/pictures/machine-solver.png").exists());
    for words in [
        &*found.description.cpu,
        "integrating, 40 modes",
        "closed_modes, shared tables",
        "not measured",
    ] {
        assert!(page.contains(words), "{words}: {page}");
    }
    // With so little memory not everything can be measured, and the page reports this.
    assert!(page.contains("four times the last-level caches"), "{page}");

    let shown = place.atlas(&["machine", "show", "m"]);
    assert_eq!(stdout(&shown), page);

    let compared = place.atlas(&["machine", "compare", "m", "m", "--json"]);
    let document: Value = serde_json::from_str(&stdout(&compared)).unwrap();
    let pairs = document["pairs"].as_array().unwrap();
    assert_eq!(
        pairs.len(),
        found.figures().count(),
        "every figure has a name of its own"
    );
    assert!(pairs.iter().all(|pair| pair["ratio"] == 1.0));

    // With this machine as the other machine, the forecast is the same.
    let plan = [
        "plan",
        "m.toml",
        "--threads",
        "1",
        "--json",
        "--machine",
        "m",
        "--on",
        "m",
    ];
    let output = place.atlas(&plan);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let plan: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(plan["machine"]["threads"], 1);
    assert_eq!(plan["elsewhere"][1]["expected"], plan["time"]["expected"]);
    let text = stdout(&place.atlas(&["plan", "m.toml", "--machine", "m"]));
    assert!(text.contains("machine     "), "{text}");
}

/// Threads cannot be bound to a machine that does not exist. Its measurements are like those of a system without
/// permission to bind threads, with unreachable nodes.
#[test]
#[cfg(feature = "hwloc")]
fn without_rights_to_bind_the_rest_is_measured_and_the_lack_is_said() {
    let place = Place::new(OSCILLATOR);
    let output = measured(&place, "m", Some("package:2 [numa] core:1 pu:1"));
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let found = Characteristics::read(&place.path("m")).unwrap();
    assert_eq!(found.description.nodes.len(), 2);
    assert!(!found.bandwidth.is_empty() && !found.solver.is_empty());
    assert!(found.solver.iter().any(|row| row.key.tables == "node"));
    let said = found.missing.join("\n");
    for words in ["threads bound to cores", "is not available"] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn bad_input_is_refused() {
    let place = Place::new(OSCILLATOR);
    for arguments in [
        &["machine", "--memory", "12"][..],
        &["machine", "--budget", "0"],
        &["machine", "--quick", "--full"],
        &["machine", "show", "nowhere"],
        &["machine", "compare", "nowhere", "m"],
        &["plan", "m.toml", "--machine", "nowhere"],
        &["plan", "m.toml", "--on", "nowhere"],
    ] {
        assert_eq!(status(&place.atlas(arguments)), 2, "{arguments:?}");
    }
    assert!(!place.path("results").exists());
}
