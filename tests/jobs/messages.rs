//! Messages must be precise: what is supported, which unit is missing, which name is similar, what to request.

#![allow(clippy::unwrap_used)]

use crate::place;
use gearatlas::manifest::{self, Diagnostic, DiagnosticKind, Job, ManifestErrors};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use std::path::Path;

fn manifests() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/manifests"))
}

fn changed(name: &str, changes: &[&str]) -> Result<Job, ManifestErrors> {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    manifest::load_changed(&manifests().join(name), &changes)
}

/// The only error of a manifest with changes.
fn fault(name: &str, changes: &[&str]) -> Diagnostic {
    let errors = changed(name, changes).unwrap_err();
    let found: Vec<&Diagnostic> = errors.errors().collect();
    let [fault] = found[..] else {
        panic!("{errors}");
    };
    fault.clone()
}

/// A helix angle belongs to a gear of a train, and its mate has the opposite one.
#[test]
fn a_helix_angle_in_a_train_is_told_its_place() {
    let angle = fault("trains/two-stage.toml", &["train.helix_angle=15 deg"]);
    assert_eq!(angle.kind, DiagnosticKind::UnknownKey);
    let other = fault(
        "trains/two-stage.toml",
        &["train.shaft.0.gears.0.helix_angle=15 deg"],
    );
    assert!(
        other
            .message
            .contains("their helix angles are 15 and 0 degrees"),
        "{}",
        other.message
    );
    let span = fault("trains/two-stage.toml", &["train.shaft.0.span=0.1"]);
    assert_eq!(span.suggestion, None);
    // For other keys the message names the table.
    let module = fault("quickstart.toml", &["mesh.module=0.004"]);
    assert_eq!(
        module.suggestion.as_deref(),
        Some("`module` belongs in [gear]")
    );
}

/// No hub is suggested for a gear that cannot have one, and no number has hundreds of digits.
#[test]
fn remedies_help_and_numbers_are_short() {
    for (gear, remedy) in [
        ("planetary.0", "remove it"),
        ("shaft.0.gears.0", "remove it, or add hub_diameter"),
    ] {
        let key = format!("train.{gear}.hub_length");
        let job = changed("trains/planetary.toml", &[&format!("{key}=10 mm")]).unwrap();
        let told = job.warnings.diagnostics.iter();
        let told: Vec<&Diagnostic> = told.filter(|word| word.key == key).collect();
        assert_eq!(told.len(), 1, "{told:?}");
        assert_eq!(told[0].remedy.as_deref(), Some(remedy));
    }
    let stiff = changed("quickstart.toml", &["mesh.mean_stiffness=1e300"]).unwrap();
    let words = manifest::advice(&stiff);
    let word = words.iter().find(|word| word.key == "mesh.mean_stiffness");
    let message = &word.unwrap().message;
    assert!(message.contains(" is 5.00e292 N/(mm um)"), "{message}");
}

/// A bare number counts as metres, and the message shows it with its unit.
#[test]
fn a_length_without_its_unit_is_shown_one() {
    let words = manifest::advice(&changed("quickstart.toml", &["gear.module=3"]).unwrap());
    let word = words.iter().find(|word| word.key == "gear.module").unwrap();
    let meant = "a bare number is in m: write the unit, such as \"3 mm\"";
    assert!(word.message.ends_with(meant), "{}", word.message);
    // With a unit, a number is not changed.
    let words = manifest::advice(&changed("quickstart.toml", &["gear.module=3 m"]).unwrap());
    let word = words.iter().find(|word| word.key == "gear.module").unwrap();
    assert!(!word.message.contains("bare"), "{}", word.message);

    let law = [
        "mesh.friction_law=schlenk",
        "mesh.oil_viscosity=20 mPa*s",
        "mesh.friction=",
    ];
    for (number, remedy) in [("0.5", Some("\"0.5 um\"")), ("0.5 mm", None), ("-1", None)] {
        let roughness = format!("mesh.roughness={number}");
        let fault = fault("flex80.toml", &[&law[..], &[roughness.as_str()]].concat());
        assert_eq!(fault.kind, DiagnosticKind::OutOfRange);
        match remedy {
            Some(remedy) => assert!(fault.remedy.unwrap().ends_with(remedy)),
            None => assert_eq!(fault.remedy, None),
        }
    }
    let train = fault("trains/two-stage.toml", &["train.shaft.0.gears.0.module=3"]);
    assert!(train.remedy.unwrap().contains("\"3 mm\""));
}

/// Oscillators with their own scales have their own gaps; a modal file of a drive does not.
#[test]
fn only_the_gap_of_a_drive_is_held_against_drives() {
    let tests = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests"));
    let abstract_one = manifest::load(&tests.join("manifests/oscillator.toml")).unwrap();
    let gap = |job: &Job| {
        let words = manifest::advice(job).into_iter();
        words.filter(|word| word.key == "mesh.half_gap").count()
    };
    assert_eq!(abstract_one.points.at(0).mesh.half_gap, 0.6);
    assert_eq!(gap(&abstract_one), 0);
    let drive = |half_gap: &str| {
        let path = tests.join("data/oscillator.toml");
        manifest::load_changed(&path, &[format!("mesh.half_gap={half_gap}")]).unwrap()
    };
    assert_eq!(gap(&drive("15 um")), 0);
    assert_eq!(gap(&drive("15 mm")), 1);
}

/// The message about a picture of a missing signal says what to request.
#[test]
fn pictures_say_what_they_need() {
    let place = Place::new(&OSCILLATOR.replace("cycles = 300", "cycles = 100"));
    let run = |out: &str, nvh: &str| {
        let set = format!("analyses={{ nvh = {nvh} }}");
        place.whole(
            out,
            &["--set", &set, "--set", "run.audit_cycles=5", "-j", "1"],
        );
    };
    run("plain", "{}");
    run("orders", "{ orders = { signals = [\"force\"] } }");
    run("spectra", "{ spectrum = {} }");
    let plot = |arguments: &[&str]| place.atlas(&[&["plot"][..], arguments].concat());
    let refused = |arguments: &[&str], parts: &[&str]| {
        let output = plot(arguments);
        assert_eq!(status(&output), 2, "{arguments:?}");
        for part in parts {
            assert!(
                stderr(&output).contains(part),
                "{part}: {}",
                stderr(&output)
            );
        }
    };
    let cut = |folder, signal| [folder, "--what", "orders", "--signal", signal];
    refused(&cut("plain", "force"), &["`nvh = { spectrum = {} }`"]);
    refused(
        &cut("plain", "bearing pinion 1 x"),
        &["`nvh = { spectrum = { signals = [\"bearings\"] } }`"],
    );
    refused(
        &cut("plain", "froce"),
        &["`froce` is not a signal", "deflection, force"],
    );
    refused(
        &cut("spectra", "froce"),
        &["did you mean force", "deflection, force"],
    );
    refused(
        &cut("spectra", "torque input"),
        &["spectra.parquet has no lines", "name \"torques\""],
    );
    // Without a spectrum, orders come from the table of orders.
    refused(
        &cut("orders", "bearing pinion 1 x"),
        &["orders.parquet has no lines", "force"],
    );
    let drawn = plot(&[&cut("orders", "force")[..], &["--format", "svg"]].concat());
    assert_eq!(status(&drawn), 0, "{}", stderr(&drawn));
    assert!(
        stdout(&drawn).contains("force-amplitude"),
        "{}",
        stdout(&drawn)
    );

    refused(
        &["plain", "--what", "lamda"],
        &["`lamda`", "did you mean lambda"],
    );
    refused(&["plain", "--what", "spectum"], &["did you mean spectrum"]);
    refused(
        &["plain", "--what", "deflection_rsm"],
        &["did you mean deflection_rms"],
    );
    // The message about a trace, which has no columns, says what to request too.
    let trace = place.atlas(&[
        "trace",
        "m.toml",
        "--point",
        "load=0.3,speed=1050",
        "--cycles",
        "2",
        "--out",
        "t",
    ]);
    assert_eq!(status(&trace), 0, "{}", stderr(&trace));
    refused(&["t", "--what", "lamda"], &["did you mean lambda"]);
    refused(
        &["t", "--what", "deflection_rms"],
        &["has no columns to draw"],
    );
}

/// A drive of 17 and 38 teeth of 3 mm, with teeth of both thinner by 60 um.
fn small_pinion(changes: &[&str]) -> Result<Job, ManifestErrors> {
    let text = r#"
[job]
name = "small"
[model]
kind = "flexible"
modes = 12
[gear]
teeth = [17, 38]
module = "3 mm"
face_width = "15 mm"
body_length = ["15 mm", "15 mm"]
bore = ["20 mm", "20 mm"]
rated_torque = "10 N*m"
thinning = "60 um"
[shafts]
young_modulus = "206 GPa"
shear_modulus = "79 GPa"
density = "7850 kg/m^3"
span = "150 mm"
overhang = "50 mm"
gear_position = 0.5
elements = [3, 4, 4]
[shafts.pinion]
diameter = "20 mm"
end_inertia = "5e-3 kg*m^2"
[shafts.wheel]
diameter = "20 mm"
end_inertia = "4.5e-3 kg*m^2"
[shafts.bearings]
x = "1.9e8 N/m"
y = "1.9e8 N/m"
tilt = "1e4 N*m/rad"
axial = ["1e8 N/m", 0]
[mesh]
stiffness = "table"
contact_damping = 0.05
[excitation.pitch_deviation]
pinion = [0,0,0,0,0,0,0,"20 um",0,0,0,0,0,0,0,0,0]
[grid]
load = 0.4
speed = "40 Hz"
"#;
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    let changes = &changes[..];
    manifest::ManifestText { text, changes }.job("small.toml", Path::new(""))
}

/// A standard pinion of 17 teeth is slightly undercut, below the contact. Deeper undercut is refused, once. The teeth
/// of a structure with faults are not reported.
#[test]
fn a_little_undercut_is_one_warning() {
    let job = small_pinion(&[]).unwrap_or_else(|errors| panic!("{errors}"));
    let [warning] = &job.warnings.diagnostics[..] else {
        panic!("{:?}", job.warnings);
    };
    assert_eq!(
        (warning.kind, &*warning.key),
        (DiagnosticKind::Unusual, "gear.thinning")
    );
    // x = −0.06/(2 · 3 tan 20°), and h_f − ρ (1 − sin α) − z/2 sin² α.
    assert!(
        warning
            .message
            .contains("is -0.0275; at least 0.0057 avoids undercut"),
        "{warning:?}"
    );
    assert!(
        warning.message.contains("undercut by 0.0331 modules"),
        "{warning:?}"
    );
    assert!(
        small_pinion(&["gear.profile_shift=[0.04, 0]"])
            .unwrap()
            .warnings
            .is_empty()
    );

    let errors = small_pinion(&["gear.profile_shift=[-0.5, 0.5]"]).unwrap_err();
    let [fault] = &errors.diagnostics[..] else {
        panic!("{errors}");
    };
    assert_eq!(fault.key, "gear.profile_shift");
    assert!(
        fault.message.contains("its mate touches it from"),
        "{errors}"
    );
}
