//! `atlas plan`: its forecast agrees with the run, and it leaves no files except tables.

#![allow(clippy::unwrap_used)]

use crate::place;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use serde_json::Value;
use std::fs;
use std::time::Duration;

fn planned(place: &Place, arguments: &[&str]) -> Value {
    let output = place.atlas(&[&["plan", "m.toml", "--json"], arguments].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

#[test]
fn a_plan_says_what_the_run_will_be() {
    let place = Place::new(&OSCILLATOR.replace("count = 3", "count = 12"));
    let plan = planned(&place, &["--threads", "2"]);
    let left = fs::read_dir(place.0.path()).unwrap();
    let mut left: Vec<_> = left.map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    // Tables remain for the run.
    assert_eq!(left, ["m.toml", "oscillator.modal.toml", "tables"]);
    assert_eq!(plan["points"], 24);
    let calibrated = plan["calibrated"].as_u64().unwrap();
    assert!(
        (8..=24).contains(&calibrated),
        "eight, or as many as make it sure: {calibrated}"
    );
    assert_eq!(plan["cut_short"], 0);
    assert_eq!(plan["threads"], 2);
    let time = ["low", "expected", "high"].map(|key| plan["time"][key].as_f64().unwrap());
    assert!(0.0 < time[0] && time.is_sorted(), "{time:?}");

    let out = place.whole("r", &["--threads", "2"]);
    let record = place.record("r");
    assert_eq!(plan["placement"], record["placement"]["asked"]);
    assert!(["hwloc", "/sys"].contains(&plan["topology"].as_str().unwrap()));
    assert_eq!(plan["topology"], record["machine"]["topology"]);
    let written: u64 = ["points.parquet", "poincare.parquet", "spectra.parquet"]
        .iter()
        .map(|name| fs::metadata(out.join(name)).unwrap().len())
        .sum();
    let disk = plan["disk"].as_u64().unwrap();
    assert!(disk / 2 < written && written < 2 * disk, "{disk} {written}");
}

/// Runs `m.toml`; returns the highest observed memory \[bytes\].
fn peak(place: &Place) -> u64 {
    let mut child = place.command("r", &["--threads", "2", "--quiet", "--overwrite"]);
    let mut child = child.spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let number = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        peak = peak.max(1024 * number.unwrap_or(0));
        std::thread::sleep(Duration::from_millis(2));
    }
    peak
}

#[test]
fn a_run_stays_within_the_memory_that_is_foretold() {
    let quick = OSCILLATOR
        .replace("cycles = 300", "cycles = 5")
        .replace("transient = 50", "transient = 0")
        .replace("samples = 20", "samples = 5")
        .replace("lyapunov = { exponents = 2 }", "")
        .replace(", spectrum = {}", "");
    let many = quick.replace("count = 3", "count = 4000");
    for manifest in [OSCILLATOR.to_owned(), many] {
        let place = Place::new(&manifest);
        let plan = planned(&place, &["--threads", "2"]);
        let memory = plan["memory"].as_u64().unwrap();
        let taken = peak(&place);
        assert!(
            taken > 0 && taken <= memory && memory < 4 * taken,
            "{taken} of {memory}"
        );
    }
}

#[test]
fn shards_are_planned_apart_and_chains_named() {
    let place = Place::new(&OSCILLATOR.replace("count = 3 }", "count = 3 }\norder = \"both\""));
    let shard = planned(&place, &["--shard", "1/4"]);
    assert_eq!(
        (&shard["points"], &shard["chain_length"]),
        (&3.into(), &3.into())
    );
    let output = place.atlas(&["plan", "m.toml"]);
    let text = stdout(&output);
    for words in [
        "points      12",
        "chains      4 of 3 points",
        "time ",
        "disk ",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn a_bad_manifest_has_no_plan() {
    let place = Place::new("[job]\n");
    assert_eq!(status(&place.atlas(&["plan", "m.toml"])), 2);
    assert_eq!(status(&place.atlas(&["plan", "nowhere.toml"])), 2);
}
