//! Rigid stops in modal files: accepted and refused keys.

#![allow(clippy::unwrap_used)]

use crate::common;
use gearatlas::manifest::{self, Job};
use gearatlas::model::Release;
use gearatlas::propagate::Why;
use std::path::Path;

const MODAL: &str = include_str!("../manifests/modal.toml");
const STRUCTURE: &str = include_str!("../manifests/oscillator.modal.toml");

const STOP: &str = "\n[[contact]]\nname = \"buffer\"\nparticipation = [0.1, 0.2, 0.3]\ngap = \"20 um\"\nrestitution = 0.8\n";

fn modal(stop: &str, manifest: &str) -> Result<Job, String> {
    let folder = tempfile::tempdir().unwrap();
    let content = format!("{STRUCTURE}\n{stop}");
    std::fs::write(folder.path().join("oscillator.modal.toml"), content).unwrap();
    manifest::parse(manifest, "test.toml", folder.path()).map_err(|errors| errors.to_string())
}

#[test]
fn stops_are_read() {
    for restitution in ["0.8", "0", "1", "\"80 %\""] {
        let text = STOP.replacen("= 0.8", &format!("= {restitution}"), 1);
        let job = modal(&text, MODAL).unwrap();
        let point = job.points.at(0);
        let model = common::parts().model(&point).unwrap();
        let [stop] = model.stops[..] else {
            panic!("{}", model.stops.len())
        };
        let own: f64 = if restitution.contains('8') { 0.8 } else { restitution.parse().unwrap() };
        assert!((stop.restitution - own).abs() < 1e-15);
        let parts = [stop.impact, stop.rest()].map(|contact| model.contacts[contact].release);
        assert_eq!(parts, [Release::Impact, Release::Rest]);
        assert!((model.contacts[stop.impact].half_gap - 20e-6).abs() < 1e-18);
        assert!((stop.push - 0.14).abs() < 1e-15, "{}", stop.push);
        // Table kernels do not support rigid stops, and `auto` takes a kernel that does.
        assert!(matches!(Why::of(&model, false), Why::Refused(_)));
    }
}

#[test]
fn faulty_stops_are_refused() {
    for (from, to, told) in [
        ("restitution = 0.8", "restitution = 1.01", "at most 1"),
        ("restitution = 0.8", "restitution = -0.1", "at least 0"),
        (
            "restitution = 0.8",
            "restitution = 0.8\nstiffness = 1e6",
            "both say how the contact returns",
        ),
        (
            "restitution = 0.8",
            "restitution = 0.8\nlevels = [1e6]",
            "both say how the contact returns",
        ),
        (
            "restitution = 0.8",
            "restitution = 0.8\ndamping = 3",
            "both say how the contact returns",
        ),
        ("restitution = 0.8", "", "contact.0.stiffness"),
        ("gap = \"20 um\"\n", "", "contact.0.gap"),
    ] {
        let said = modal(&STOP.replacen(from, to, 1), MODAL).unwrap_err();
        println!("{said}\n");
        assert!(said.contains(told), "{said}");
    }
    let many = STOP.repeat(64);
    let said = modal(&many, MODAL).unwrap_err();
    assert!(
        said.contains("128 contacts") && said.contains("at most 126"),
        "{said}"
    );
}

/// A force that pulls a stop shut is reported when the model is built.
#[test]
fn a_force_that_closes_its_stop_is_refused() {
    let text = STOP.replacen("gap =", "force = [-0.1, 0.0, 0.0]\ngap =", 1);
    let job = modal(&text, MODAL).unwrap();
    let said = common::parts()
        .model(&job.points.at(0))
        .unwrap_err()
        .to_string();
    assert!(said.contains("rigid stop"), "{said}");
}

#[test]
fn what_excludes_stops_is_refused() {
    for (added, key) in [
        ("[run]\nkernel = \"closed_modes\"\n", "run.kernel"),
        ("[run]\nkernel = \"stepping\"\n", "run.kernel"),
        (
            "[continuation]\nstarts = 5\n",
            "`continuation` is not available",
        ),
        (
            "[analyses.lyapunov]\n[analyses.covariant]\n",
            "analyses.covariant",
        ),
    ] {
        let said = modal(STOP, &format!("{MODAL}\n{added}")).unwrap_err();
        println!("{said}\n");
        assert!(
            said.contains(key) && said.contains("1 rigid stops"),
            "{said}"
        );
    }
    assert!(modal(STOP, &format!("{MODAL}\n[run]\nkernel = \"volterra\"\n")).is_ok());
}

/// The shipped manifest.
#[test]
fn the_shipped_oscillator_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/oscillators");
    let text = std::fs::read_to_string(folder.join("impact.toml")).unwrap();
    let job = manifest::parse(&text, "impact.toml", &folder).map_err(|errors| errors.to_string());
    let model = common::parts().model(&job.unwrap().points.at(0)).unwrap();
    assert_eq!(model.stops.len(), 1);
    assert_eq!(model.first_cycle().period, std::f64::consts::TAU / 2.3);
}
