//! Dry friction and softening contacts in modal files: accepted and refused keys.

#![allow(clippy::unwrap_used)]

use crate::common;
use gearatlas::manifest::{self, Job};
use gearatlas::model::Release;
use gearatlas::propagate::Why;
use std::path::Path;

const MODAL: &str = include_str!("../manifests/modal.toml");
const STRUCTURE: &str = include_str!("../manifests/oscillator.modal.toml");

const BELT: &str = "\n[[dry_friction]]\nname = \"belt\"\nparticipation = [0.1, 0.2, 0.3]\nforce = \"20 N\"\n\
     static_force = \"25 N\"\nbelt_speed = \"10 mm/s\"\n";

fn modal(friction: &str, manifest: &str) -> Result<Job, String> {
    let folder = tempfile::tempdir().unwrap();
    let content = format!("{STRUCTURE}\n{friction}");
    std::fs::write(folder.path().join("oscillator.modal.toml"), content).unwrap();
    manifest::parse(manifest, "test.toml", folder.path()).map_err(|errors| errors.to_string())
}

#[test]
fn elements_are_read() {
    let plain = BELT.replacen("static_force = \"25 N\"\nbelt_speed = \"10 mm/s\"\n", "", 1);
    for (text, numbers) in [(BELT, [20.0, 25.0, 0.01]), (&plain, [20.0, 20.0, 0.0])] {
        let job = modal(text, MODAL).unwrap();
        let model = common::parts().model(&job.points.at(0)).unwrap();
        let [own] = model.frictions[..] else {
            panic!("{}", model.frictions.len())
        };
        assert_eq!([own.force, own.static_force, own.belt_speed], numbers);
        assert!((own.push - 0.14).abs() < 1e-15, "{}", own.push);
        let laws = [own.forwards, own.forwards + 1, own.stick()];
        let laws = laws.map(|contact| model.contacts[contact].release);
        assert_eq!(laws, [Release::Rub, Release::Rub, Release::Grip]);
        // Table kernels do not support dry friction, and `auto` takes a kernel that does.
        assert!(matches!(Why::of(&model, false), Why::Refused(_)));
    }
}

#[test]
fn faulty_elements_are_refused() {
    let positive = "greater than 0";
    for (from, to, told) in [
        ("force = \"20 N\"", "force = \"-20 N\"", positive),
        ("force = \"20 N\"", "force = 0", positive),
        ("force = \"20 N\"\n", "", "dry_friction.0.force"),
        ("\"25 N\"", "\"19 N\"", "dry_friction.0.static_force"),
        ("\"25 N\"", "\"19 N\"", "raise static_force"),
        ("\"10 mm/s\"", "nan", "dry_friction.0.belt_speed"),
        ("\"10 mm/s\"", "\"10 N\"", "dry_friction.0.belt_speed"),
        ("name = \"belt\"\n", "", "dry_friction.0.name"),
        ("[0.1, 0.2, 0.3]", "[0.1, 0.2]", "2 entries"),
    ] {
        assert!(BELT.contains(from), "{from}");
        let said = modal(&BELT.replacen(from, to, 1), MODAL).unwrap_err();
        println!("{said}\n");
        assert!(said.contains(told), "{said}");
    }
    let said = modal(&BELT.repeat(43), MODAL).unwrap_err();
    assert!(
        said.contains("129 contacts") && said.contains("at most 126"),
        "{said}"
    );
    let twice = modal(&BELT.repeat(2), MODAL).unwrap_err();
    assert!(
        twice.contains("two elements of dry friction have the name `belt`"),
        "{twice}"
    );
    // Faults that only the model can detect.
    let stop = "\n[[contact]]\nname = \"buffer\"\nparticipation = [0.1, 0.2, 0.3]\ngap = \"20 um\"\nrestitution = 0.8\n";
    for (text, told) in [
        (
            format!("{BELT}{stop}"),
            "dry friction and rigid stops exclude each other",
        ),
        (
            format!("{BELT}{}", BELT.replacen("\"belt\"", "\"other\"", 1)),
            "element 2 of dry friction",
        ),
    ] {
        let job = modal(&text, MODAL).unwrap();
        let said = common::parts().model(&job.points.at(0)).unwrap_err();
        assert!(said.to_string().contains(told), "{said}");
    }
}

#[test]
fn what_excludes_dry_friction_is_refused() {
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
        let said = modal(BELT, &format!("{MODAL}\n{added}")).unwrap_err();
        println!("{said}\n");
        assert!(
            said.contains(key) && said.contains("1 elements of dry friction"),
            "{said}"
        );
    }
    assert!(modal(BELT, &format!("{MODAL}\n[run]\nkernel = \"volterra\"\n")).is_ok());
}

/// A stiffness may be negative if it is constant.
#[test]
fn contacts_may_soften() {
    let contact = |law: &str| {
        format!(
            "\n[[contact]]\nname = \"soft\"\nparticipation = [0.1, 0.2, 0.3]\ngap = \"20 um\"\n{law}\n"
        )
    };
    let job = modal(&contact("stiffness = \"-1e5 N/m\""), MODAL).unwrap();
    let model = common::parts().model(&job.points.at(0)).unwrap();
    assert!(model.has_negative_stiffness());
    assert!(matches!(Why::of(&model, false), Why::Refused(_)));
    for law in [
        "stiffness = 0",
        "stiffness = \"-1e5 N/m\"\nstiffness_harmonics = [{ harmonic = 1, amplitude = \"1e4 N/m\" }]",
    ] {
        let said = modal(&contact(law), MODAL).unwrap_err();
        assert!(said.contains("the stiffness must stay above 0"), "{said}");
    }
}

/// The manifests that are shipped.
#[test]
fn the_shipped_oscillators_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/oscillators");
    for (name, frictions, stops) in [
        ("belt", 1, 0),
        ("den-hartog", 1, 0),
        ("rigid-rattle", 0, 2),
        ("preloaded", 0, 0),
    ] {
        let text = std::fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap();
        let job =
            manifest::parse(&text, "shipped.toml", &folder).map_err(|errors| errors.to_string());
        let model = common::parts().model(&job.unwrap().points.at(0)).unwrap();
        assert_eq!(
            (model.frictions.len(), model.stops.len()),
            (frictions, stops),
            "{name}"
        );
    }
}
