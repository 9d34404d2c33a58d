//! The rigid-body tiers from manifests: the shipped manifests of all tiers, keys that a kind may omit, and the
//! exactness of their motion.
// Helpers outside the test functions may also unwrap.
#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, settled, volterra};
use gearatlas::manifest::{self, Job, PointSpec, StructureSource};
use gearatlas::model::{InitialState, Model};
use gearatlas::reference::Reference;
use gearatlas::shaft::{RigidDrive, Tier};
use gearatlas::sweep::build;
use std::f64::consts::PI;
use std::path::Path;

fn text(kind: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/tiers");
    std::fs::read_to_string(folder.join(format!("{kind}.toml"))).unwrap()
}

fn job(text: &str) -> Job {
    manifest::parse(text, "test.toml", Path::new("")).unwrap_or_else(|errors| panic!("{errors}"))
}

fn rigid(job: &Job) -> RigidDrive {
    match &job.points.at(0).model.source {
        StructureSource::Rigid(drive) => RigidDrive::clone(drive),
        other => panic!("not rigid: {}", other.kind()),
    }
}

/// Drops the lines of some keys.
fn without(text: &str, keys: &[&str]) -> String {
    let kept = text.lines().filter(|line| {
        let key = line.split('=').next().unwrap_or_default().trim();
        !keys.contains(&key)
    });
    kept.map(|line| format!("{line}\n")).collect()
}

fn model(job: &Job, point: usize) -> Model {
    let point = &job.points.at(point);
    common::parts().model(point).unwrap()
}

#[test]
fn shipped_manifests_are_a_ladder_over_one_grid() {
    let flexible = job(&text("flexible"));
    let StructureSource::Flexible(machine) = &flexible.points.at(0).model.source else {
        panic!("not flexible");
    };
    assert_eq!(flexible.points.at(0).model.retained, 40);
    let mut hashes = vec![flexible.hash.clone()];
    for (tier, modes) in Tier::ALL.into_iter().zip([2, 6, 12, 20]) {
        let job = job(&text(tier.name()));
        let drive = rigid(&job);
        assert_eq!(drive.tier, tier);
        assert_eq!(
            (&drive.gears, &drive.shafts),
            (&machine.gears, &machine.shafts)
        );
        assert_eq!(drive.pedestals.is_some(), tier == Tier::Pedestal);
        assert_eq!(job.axes, flexible.axes);
        let model = &job.points.at(0).model;
        assert_eq!(
            (model.source.kind(), model.modes, model.retained),
            (tier.name(), modes, modes)
        );
        assert!(!hashes.contains(&job.hash));
        hashes.push(job.hash);
    }
}

/// The drawing of a flexible drive is valid for every tier without changes.
#[test]
fn the_kind_alone_takes_a_drive_from_tier_to_tier() {
    let flexible = without(&text("flexible"), &["modes", "damping"]);
    for tier in [Tier::Torsional, Tier::Translational, Tier::Tilting] {
        let kind = format!("kind = \"{}\"", tier.name());
        let taken = job(&flexible.replace("kind = \"flexible\"", &kind));
        let own = job(&text(tier.name()));
        assert_eq!(rigid(&taken), rigid(&own));
        // The name of the job is not hashed.
        assert_eq!(taken.hash, own.hash);
    }
}

#[test]
fn what_a_kind_does_not_feel_may_be_left_out() {
    let structure = |text: &str| build::structure(&job(text).points.at(0).model).unwrap();
    let translational = text("translational");
    let bare = without(&translational, &["tilt", "axial", "gear_position"]);
    assert_eq!(structure(&bare), structure(&translational));
    let torsional = text("torsional");
    let keys = ["x", "y", "tilt", "axial", "gear_position"];
    let bare = without(&torsional, &keys);
    let (header, rest) = bare.split_once("[shafts.bearings]").unwrap();
    let (_, rest) = rest.split_once('\n').unwrap();
    assert_eq!(structure(&format!("{header}{rest}")), structure(&torsional));
}

#[test]
fn pedestals_of_one_shaft_override_what_both_share() {
    let pedestal = text("pedestal");
    let own = pedestal.replace(
        "[shafts.pedestals]",
        "[shafts.wheel.pedestals]\nmass = [\"2 kg\", \"5000 g\"]\ny = 2e8\n\n[shafts.pedestals]",
    );
    let [pinion, wheel] = rigid(&job(&own)).pedestals.unwrap();
    assert_eq!(pinion.map(|p| p.mass), [3.0, 3.0]);
    assert_eq!(wheel.map(|p| p.mass), [2.0, 5.0]);
    assert_eq!(wheel.map(|p| p.y), [2e8, 2e8]);
    assert_eq!(wheel.map(|p| p.x), [4e8, 4e8]);
    assert_ne!(job(&own).hash, job(&pedestal).hash);
}

#[test]
fn fewer_modes_and_fewer_retained_are_accepted() {
    let reduced = text("tilting").replace(
        "kind = \"tilting\"",
        "kind = \"tilting\"\nmodes = 10\nretained = 2\nmta = true",
    );
    let structure = build::structure(&job(&reduced).points.at(0).model).unwrap();
    assert_eq!(structure.modes(), 2);
    assert!(structure.residual_flexibility > 0.0);
}

/// Rattle of every tier at 1200 rad/s and 5 % load, cycle by cycle from the same states.
#[test]
fn rattle_of_every_tier_is_that_of_the_reference() {
    for tier in Tier::ALL {
        let model = model(&job(&text(tier.name())), 0);
        let (kernel, reference) = (volterra(&model), Reference::new(&model));
        let mut start = settled(&model, 20);
        let (mut events, mut worst) = (0, 0.0_f64);
        for _ in 0..8 {
            let exact = reference.advance(&start, 1).unwrap();
            let end = advance(&kernel, &start, 1);
            assert_eq!(end.contact, exact.end.contact);
            worst = worst.max(common::relative_difference(&end.state, &exact.end.state));
            events += exact.crossings.len();
            start = end;
        }
        println!("{}: {worst:.1e} over {events} events", tier.name());
        assert!(events >= 8, "{} does not rattle", tier.name());
        assert!(worst < 1e-12, "{}: {worst:e}", tier.name());
    }
}

/// In permanent contact the torsional drive is one damped oscillator under `e = a cos Ωt`:
/// `δ − b = F/k + Re(a Ω² e^{iΩt} / (k w² − Ω² + i c w² Ω))`, `w² = Σ r²/J`.
#[test]
fn a_torsional_drive_in_lasting_contact_is_one_oscillator() {
    let contact = text("torsional")
        .replace("stiffness = \"piecewise\"", "stiffness = \"constant\"")
        .replace("amplitude = \"5 um\"", "amplitude = \"0.5 um\"")
        .replace("values = [0.05, 0.30]", "values = [0.05, 1.0]");
    let keys = ["contact_ratio", "single_pair_drop", "segments", "friction"];
    let model = model(&job(&without(&contact, &keys)), 2);
    let end = settled(&model, 400);
    assert_eq!(end.contact, model.start(&InitialState::Static).contact);
    // The inertia of each body is the sum of shaft, gear and end.
    let inertia = |diameter: f64, pitch: f64, length: f64, end: f64| {
        let polar = |d: f64, l: f64| PI / 32.0 * d.powi(4) * l * 7850.0;
        polar(diameter, 0.16) + polar(pitch, length) - polar(diameter, length) + end
    };
    let cosine = 20f64.to_radians().cos();
    let square = (0.04 * cosine).powi(2) / inertia(0.022, 0.08, 0.07, 2e-3)
        + (0.06 * cosine).powi(2) / inertia(0.026, 0.12, 0.04, 5e-3);
    let (k, c, omega) = (4e8, 1483.0, 20.0 * 1200.0);
    let force = 50.0 / (0.04 * cosine);
    let (stiff, loss) = (k * square - omega * omega, c * square * omega);
    let scale = 0.5e-6 * omega * omega / (stiff * stiff + loss * loss);
    let exact = (10e-6 + force / k + scale * stiff, scale * loss * omega);
    let (deflection, rate) = model.deflection(&end.state, 0.0);
    assert!(
        (deflection / exact.0 - 1.0).abs() < 1e-11,
        "{deflection} {exact:?}"
    );
    assert!((rate / exact.1 - 1.0).abs() < 1e-9, "{rate} {exact:?}");
}

/// Windage of the wheel as an expression of the speed loads the mesh like a constant torque of its value there.
#[test]
fn windage_is_a_torque_by_an_expression_of_the_speed() {
    let plain = text("torsional");
    let loads = |key: &str, value: &str| {
        let text = plain.replace("[grid]", &format!("[grid]\n\"{key}\" = {value}"));
        let job = job(&text);
        let models = (0..job.points.len()).map(|point| job.points.at(point));
        let inputs = |point: PointSpec| -> (f64, Vec<[f64; 2]>) {
            let model = common::parts().model(&point).unwrap();
            let inputs = model.blocks.iter().map(|block| block.static_input);
            (point.speed, inputs.collect())
        };
        models.map(inputs).collect::<Vec<_>>()
    };
    let key = "shafts.wheel.drag_torque";
    let windage = loads(key, "\"3.97e-6 * (speed * 2 / 3)^1.8\"");
    let speeds = [1200.0, 1400.0];
    for speed in speeds {
        let torque = 3.97e-6 * (speed * 2.0 / 3.0_f64).powf(1.8);
        let constant = loads(key, &format!("{torque:?}"));
        let at = |all: &[(f64, Vec<[f64; 2]>)]| -> Vec<_> {
            all.iter().filter(|own| own.0 == speed).cloned().collect()
        };
        let none = loads(key, "0");
        let all = [at(&windage), at(&constant), at(&none)].map(|points| {
            let inputs = points.into_iter().flat_map(|(_, inputs)| inputs);
            inputs.flatten().collect::<Vec<f64>>()
        });
        let apart = |a: &[f64], b: &[f64]| {
            let off = a.iter().zip(b).map(|(x, y)| (x - y).abs());
            off.fold(0.0, f64::max) / a.iter().copied().fold(0.0, f64::max)
        };
        assert!(apart(&all[0], &all[1]) < 1e-12 && apart(&all[0], &all[2]) > 1e-6);
    }
}
