//! Meshes computed from the drawing of the gears, at work: what their stiffness does to the
//! default drive, how segments converge to the course, what misalignment and friction change.

#![allow(clippy::unwrap_used)]

mod common;

use atlas::manifest::{self, Job};
use atlas::model::{InitialState, Model};
use atlas::propagate::{Counters, Kernel, Tangents};
use atlas::sweep::build::Parts;
use common::march::{march, volterra};
use common::relative_difference;
use std::path::Path;

/// The manifest of the default drive with its mesh from a table, edited.
fn job(edits: &[(&str, &str)]) -> Job {
    let mut text = include_str!("../manifests/flex80-table.toml").to_owned();
    for (from, to) in edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    manifest::parse(&text, "m.toml", Path::new("")).unwrap()
}

const COURSE: [(&str, &str); 2] = [
    ("stiffness = \"table\" ", "stiffness = \"continuous\" "),
    ("segments = 60", "#"),
];

fn model(parts: &Parts, job: &Job, load: f64, speed: f64) -> Model {
    let mut point = job.points[0].clone();
    (point.load, point.speed) = (load, speed);
    parts.model(&point).unwrap()
}

/// Events a cycle after a transient, from static equilibrium.
fn events_per_cycle(model: &Model) -> f64 {
    let kernel = volterra(model);
    let mut trajectory = march(&kernel, &model.start(&InitialState::Static), 300);
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    for _ in 0..200 {
        kernel
            .march(
                &mut trajectory,
                &mut Tangents::none(),
                &mut workspace,
                &mut (),
                &mut counters,
            )
            .unwrap();
    }
    counters.events as f64 / 200.0
}

/// Stiffness alone keeps the flanks together away from the mesh resonance; 5 µm of transmission
/// error opens them.
#[test]
fn what_opens_the_gap() {
    let parts = common::parts();
    let quiet = job(&[
        COURSE[0],
        COURSE[1],
        ("amplitude = \"5 um\"", "amplitude = 0"),
    ]);
    let shaken = job(&COURSE);
    for load in [0.05, 0.3] {
        let mut open = Vec::new();
        for step in 0..=32 {
            let speed = 400.0 + 50.0 * f64::from(step);
            let events = events_per_cycle(&model(&parts, &quiet, load, speed));
            if events > 0.0 {
                open.push((speed, events));
            }
        }
        println!("load {load}: open at {open:?}");
        assert!(open.is_empty(), "load {load}: {open:?}");
        let events = events_per_cycle(&model(&parts, &shaken, load, 1200.0));
        assert!(
            events > 1.0,
            "load {load}: {events} events a cycle with an error of 5 um"
        );
    }
}

/// Segment means converge to the course with the square of their number (an even one of a
/// straddled step): after one cycle of rattle.
#[test]
fn segments_converge_to_the_course() {
    let parts = common::parts();
    let course = model(&parts, &job(&COURSE), 0.05, 1200.0);
    let start = march(&volterra(&course), &course.start(&InitialState::Static), 60);
    let exact = march(&volterra(&course), &start, 1);
    let errors = ["60", "120", "240", "480"].map(|count| {
        let segments = job(&[("segments = 60", &format!("segments = {count}"))]);
        let model = model(&parts, &segments, 0.05, 1200.0);
        let end = march(&volterra(&model), &start, 1);
        relative_difference(&end.state, &exact.state)
    });
    println!("segments against the course: {errors:?}");
    assert!(
        errors[0] < 1e-2 && errors[3] < errors[0] / 4.0,
        "{errors:?}"
    );
}
