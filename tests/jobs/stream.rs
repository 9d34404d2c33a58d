//! `atlas run --json` as a process: every line is an event, in order, for any end of the run.

#![allow(clippy::unwrap_used)]

use crate::place;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Points that take some time each.
fn long() -> String {
    OSCILLATOR
        .replace("count = 3", "count = 12")
        .replace("cycles = 300", "cycles = 8000")
        .replace("transient = 50", "transient = 2000")
}

fn events(text: &str) -> Vec<Value> {
    let event = |line: &str| serde_json::from_str(line).unwrap();
    text.lines().map(event).collect()
}

/// The events of one kind.
fn of<'a>(events: &'a [Value], kind: &str) -> Vec<&'a Value> {
    let wanted = |event: &&Value| event["event"] == kind;
    events.iter().filter(wanted).collect()
}

fn ids(events: &[Value]) -> BTreeSet<u64> {
    let points = of(events, "point");
    let ids: BTreeSet<u64> = (points.iter())
        .map(|event| event["point_id"].as_u64().unwrap())
        .collect();
    assert_eq!(ids.len(), points.len(), "each point once");
    ids
}

/// The record of a run without the checksum of its text.
fn kept(place: &Place) -> Value {
    let mut record = place.record("r");
    assert!(record.as_object_mut().unwrap().remove("blake3").is_some());
    record
}

#[test]
fn a_run_is_told_from_start_to_finish() {
    let place = Place::new(OSCILLATOR);
    let output = place.run("r", &["--json", "--quiet", "--threads", "2"]);
    assert_eq!((status(&output), stderr(&output)), (0, String::new()));
    let events = events(&stdout(&output));
    let started = &events[0];
    assert_eq!(started["event"], "started");
    assert_eq!(started["job"], "oscillator");
    assert_eq!(started["folder"], "r");
    assert_eq!([&started["points"], &started["resumed"]], [6, 0]);
    assert_eq!(ids(&events), (0..6).collect());
    for point in of(&events, "point") {
        assert_eq!(point["status"], "ok");
        let id = point["point_id"].as_u64().unwrap();
        assert_eq!(point["axes"]["load"], [0.05, 0.3][id as usize / 3]);
        assert_eq!(
            point["axes"]["speed"],
            [600.0, 1050.0, 1500.0][id as usize % 3]
        );
        assert!(point["lambda_max"].is_f64() && point["class"].is_string());
    }
    let last = of(&events, "progress").pop().unwrap();
    assert_eq!([&last["done"], &last["ok"], &last["failed"]], [6, 6, 0]);
    assert_eq!(last["eta"], 0.0);
    let on_nodes: u64 = (last["nodes"].as_array().unwrap().iter())
        .map(|node| node["points"].as_u64().unwrap())
        .sum();
    assert_eq!(on_nodes, 6);
    let finished = events.last().unwrap();
    assert_eq!(finished["event"], "finished");
    assert_eq!(finished["exit_status"], 0);
    assert_eq!(finished["record"], kept(&place));
    assert_eq!(
        (of(&events, "started").len(), of(&events, "finished").len()),
        (1, 1)
    );

    // There is nothing to do: nothing starts, but the end is reported.
    for arguments in [&["--json"][..], &["--json", "--retry", "failed"]] {
        let again = self::events(&stdout(&place.run("r", arguments)));
        assert_eq!(again.len(), 1, "{again:?}");
        assert_eq!(again[0]["event"], "finished");
        assert_eq!(again[0]["record"], kept(&place));
    }
}

#[test]
fn an_interrupted_run_tells_its_end_and_the_next_only_what_is_new() {
    let place = Place::new(&long());
    let mut child = place
        .command("r", &["--json", "--threads", "2"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut first = Vec::new();
    while of(&first, "point").len() < 3 {
        first.push(serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap());
    }
    let kill = format!("kill -s INT {}", child.id());
    assert!(
        Command::new("sh")
            .args(["-c", &kill])
            .status()
            .unwrap()
            .success()
    );
    first.extend(lines.map(|line| serde_json::from_str(&line.unwrap()).unwrap()));
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let finished = first.last().unwrap();
    assert_eq!(finished["exit_status"], 130);
    assert_eq!(finished["record"]["state"], "interrupted");

    let second = events(&stdout(&place.run("r", &["--json", "--threads", "1"])));
    let (before, after) = (ids(&first), ids(&second));
    assert_eq!(second[0]["resumed"], before.len());
    assert!(before.is_disjoint(&after));
    assert_eq!(before.len() + after.len(), 24);
    for progress in of(&second, "progress") {
        let done = progress["done"].as_u64().unwrap();
        let expected = (done - before.len() as u64) as f64 / progress["elapsed"].as_f64().unwrap();
        let rate = progress["rate"].as_f64().unwrap();
        assert!((rate - expected).abs() <= 1e-9 * expected, "{progress}");
    }
}

#[test]
fn what_goes_wrong_is_told_in_the_stream() {
    let place = Place::new(&OSCILLATOR.replace("[run]", "[run]\nevent_limit = 1"));
    let output = place.run("r", &["--json", "--quiet"]);
    assert_eq!(status(&output), 3);
    let events = events(&stdout(&output));
    let stormed = of(&events, "point");
    assert!(stormed.iter().any(|point| point["status"] == "event_storm"));
    assert_eq!(
        of(&events, "progress").pop().unwrap()["failed"],
        place.record("r")["totals"]["failed"]
    );
    assert_eq!(events.last().unwrap()["exit_status"], 3);
}

#[test]
fn a_reader_may_leave_and_a_full_output_is_said() {
    let place = Place::new(OSCILLATOR);
    let output =
        place.shell("set -o pipefail; \"$ATLAS\" run m.toml --out left --json | head -n 1");
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert_eq!(events(&stdout(&output)).len(), 1);
    assert_eq!(place.record("left")["state"], "complete");
    let output = place.shell("\"$ATLAS\" run m.toml --out full --json > /dev/full");
    assert_eq!(status(&output), 1);
    assert!(stderr(&output).contains("cannot write to standard output"));
    assert_eq!(place.record("full")["state"], "complete");
}
