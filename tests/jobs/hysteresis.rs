//! Elements of dry hysteresis in manifests and modal files: accepted and refused keys.

#![allow(clippy::unwrap_used)]

use crate::common;
use gearatlas::manifest::{self, Job};
use gearatlas::model::Release;
use std::path::Path;

const CLUTCH: &str = include_str!("../../manifests/trains/clutch-hysteresis.toml");
const MODAL: &str = include_str!("../manifests/modal.toml");
const STRUCTURE: &str = include_str!("../manifests/oscillator.modal.toml");

const SLIDER: &str = "\n[[slider]]\nname = \"clutch\"\nparticipation = [0.1, 0.2, 0.3]\nstiffness = \"1e6 N/m\"\nlimit = \"20 N\"\n";

fn in_folder(folder: &Path, text: &str) -> Result<Job, String> {
    manifest::parse(text, "test.toml", folder).map_err(|errors| errors.to_string())
}

fn clutch(changes: &[(&str, &str)]) -> Result<Job, String> {
    let text = changes.iter().fold(CLUTCH.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    in_folder(Path::new("."), &text)
}

fn modal(slider: &str) -> Result<Job, String> {
    let folder = tempfile::tempdir().unwrap();
    let content = format!("{STRUCTURE}\n{slider}");
    std::fs::write(folder.path().join("oscillator.modal.toml"), content).unwrap();
    in_folder(folder.path(), MODAL)
}

#[test]
fn elements_are_read() {
    for (job, sliders, limit) in [
        (clutch(&[]).unwrap(), 2, 0.4),
        (modal(SLIDER).unwrap(), 1, 20.0),
    ] {
        let point = job.points.at(0);
        assert_eq!(point.model.source.sliders(), sliders);
        let model = common::parts().model(&point).unwrap();
        assert_eq!(model.sliders.len(), sliders);
        let forwards = &model.contacts[model.sliders[0].forwards];
        assert_eq!(forwards.release, Release::Slip);
        let force = forwards
            .constant_force(&forwards.cycles[0].segments[0])
            .unwrap();
        assert!((force - limit).abs() < 1e-12 * limit, "{force}");
        let start = model.start(&point.run.initial);
        assert!(
            model
                .sliders
                .iter()
                .all(|own| start.contact.holds(own.spring()))
        );
    }
}

#[test]
fn faulty_elements_are_refused() {
    let positive = "greater than 0";
    for (from, to, told) in [
        ("limit = \"0.4 N*m\"", "limit = \"-1 N*m\"", positive),
        ("limit = \"0.4 N*m\"", "limit = 0", positive),
        ("stiffness = \"150 N*m/rad\"", "stiffness = 0", positive),
        (
            "stiffness = \"150 N*m/rad\", ",
            "",
            "hysteresis.0.stiffness",
        ),
        (", limit = \"0.4 N*m\"", "", "hysteresis.0.limit"),
    ] {
        let said = clutch(&[(from, to)]).unwrap_err();
        println!("{said}\n");
        assert!(said.contains(told), "{said}");
    }
    for (from, to, told) in [
        ("limit = \"20 N\"", "limit = \"-20 N\"", positive),
        ("stiffness = \"1e6 N/m\"", "stiffness = 0", positive),
        ("stiffness = \"1e6 N/m\"\n", "", "slider.0.stiffness"),
        ("limit = \"20 N\"\n", "", "slider.0.limit"),
        ("name = \"clutch\"\n", "", "slider.0.name"),
        ("[0.1, 0.2, 0.3]", "[0.1, 0.2]", "2 entries"),
    ] {
        let said = modal(&SLIDER.replacen(from, to, 1)).unwrap_err();
        println!("{said}\n");
        assert!(said.contains(told), "{said}");
    }
    let many = SLIDER.repeat(43);
    let said = modal(&many).unwrap_err();
    assert!(
        said.contains("129 contacts") && said.contains("at most 126"),
        "{said}"
    );
}

#[test]
fn what_excludes_sliders_is_refused() {
    let run = "cycles = 40000";
    for (from, to, key) in [
        (
            run,
            "cycles = 40000\nkernel = \"closed_modes\"",
            "run.kernel",
        ),
        (run, "cycles = 40000\nkernel = \"stepping\"", "run.kernel"),
        (
            "exponents = 1 }",
            "exponents = 1 }\ncovariant = {}",
            "analyses.covariant",
        ),
        (
            run,
            "cycles = 40000\n[continuation]\nover = \"speed\"",
            "`continuation` is not available",
        ),
    ] {
        let said = clutch(&[(from, to)]).unwrap_err();
        println!("{said}\n");
        assert!(
            said.contains(key) && said.contains("not with 2 dry sliders"),
            "{said}"
        );
    }
    for kernel in ["volterra", "auto"] {
        clutch(&[(run, &format!("cycles = 40000\nkernel = \"{kernel}\""))]).unwrap();
    }
}
