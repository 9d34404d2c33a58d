//! The output of `atlas check` about the structure: the whole text is a snapshot.

#![allow(clippy::unwrap_used)]

use crate::common;
use gearatlas::manifest;
use gearatlas::model::Model;
use std::path::Path;
use std::process::Command;

const QUICKSTART: &str = include_str!("../../manifests/quickstart.toml");

/// A shaft between a mesh and a stop, with drag and a heavily damped mode. A second mesh has three cycles in five
/// cycles of the first; a load has two periods in three cycles.
const MODAL_FILE: &str = r#"
teeth = 20
rated_force = 1330.0
frequency = [0.0, 0.0, 4200.0, 6000.0]
damping = [0.0, 0.0, 0.01, 0.0]
mesh = [0.0, 0.6, 0.3, 0.1]
torque = [0.0, 0.6, 0.3, 0.0]
damping_matrix = [[0.0, 0.0, 0.0, 0.0], [0.0, 12.0, 1.0, 0.0], [0.0, 1.0, 4.0, 0.0], [0.0, 0.0, 0.0, 15000.0]]

[[contact]]
name = "second mesh"
participation = [0.0, -0.4, 0.2, 0.0]
gap = "10 um"
levels = ["3e8 N/m", "2.2e8 N/m"]
cycles = [3, 5]

[[harmonic_load]]
name = "pump"
force = [0.0, 0.0, 2.0, 1.0]
amplitude = 20
cycles = [2, 3]
"#;

const MANIFEST: &str = r#"
[job]
name = "case"

[model]
kind = "modal"
file = "case.modal.toml"

[mesh]
half_gap = "15 um"
stiffness = "constant"
mean_stiffness = "4e8 N/m"
contact_damping = 0.05

[grid]
"model.retained" = { values = [4, 3] }
load = 0.1
speed = { from = 200, to = 700, count = 10 }
"#;

fn check(folder: &Path, arguments: &[&str]) -> String {
    std::fs::write(folder.join("case.modal.toml"), MODAL_FILE).unwrap();
    std::fs::write(folder.join("case.toml"), MANIFEST).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(["check", "case.toml"])
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let [said, failed] =
        [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
    assert!(output.status.success(), "{failed}");
    said
}

#[test]
fn the_structure_is_told() {
    let folder = tempfile::tempdir().unwrap();
    insta::assert_snapshot!("structure", check(folder.path(), &[]));
}

/// At these speeds the harmonics of the mesh meet the closed modes' frequencies.
#[test]
fn programs_are_told_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let told: serde_json::Value = serde_json::from_str(&check(folder.path(), &["--json"])).unwrap();
    let structure = &told["structure"];
    assert_eq!(structure["count"], 2);
    assert_eq!(structure["base_period"], 15);
    assert_eq!(structure["open"].as_array().unwrap().len(), 4);
    let closed = structure["closed"].as_array().unwrap();
    let share: f64 = (closed.iter())
        .map(|mode| mode["mesh_share"].as_f64().unwrap())
        .sum();
    // The sum of the shares is k w'(K + k w w')^-1 w, which is 1 if only the mesh restrains a rotation.
    assert!((share - 1.0).abs() < 1e-9, "{share}");
    for mode in &closed[1..] {
        let frequency = mode["frequency_hz"].as_f64().unwrap();
        for (harmonic, speed) in (1..).zip(mode["resonant_speeds"].as_array().unwrap()) {
            let mesh = 20.0 * speed.as_f64().unwrap() / std::f64::consts::TAU;
            assert!((f64::from(harmonic) * mesh / frequency - 1.0).abs() < 1e-12);
        }
    }
}

/// The quickstart drive with parts of its text replaced.
fn quickstart(changes: &[(&str, &str)]) -> String {
    let change = |text: String, (from, to): &(&str, &str)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    changes.iter().fold(QUICKSTART.to_owned(), change)
}

/// The output of `atlas check --json` for a text.
fn told(text: &str) -> serde_json::Value {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(["check", "m.toml", "--json"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value["valid"], true, "{value:#}");
    value
}

/// Keys of a kind of advice with their lines and messages.
fn words(text: &str, kind: &str) -> Vec<(String, u64, String)> {
    let value = told(text);
    let all = value["advice"].as_array().unwrap().iter();
    let of_kind = all.filter(|word| word["kind"] == kind);
    of_kind
        .map(|word| {
            let text = |key: &str| word[key].as_str().unwrap().to_owned();
            (text("key"), word["line"].as_u64().unwrap(), text("message"))
        })
        .collect()
}

#[test]
fn what_no_drive_is_built_like_is_warned_of() {
    assert!(words(QUICKSTART, "suspect").is_empty());
    let ripple = "]\ntorque_ripple = [{ shaft = \"pinion\", order = 2, amplitude = \"2 kN*m\" }]";
    for (from, to, key, said) in [
        (
            "\"10 um\"",
            "\"1.5 mm\"",
            "mesh.half_gap",
            "1.5 mm is 0.38 modules",
        ),
        (
            "\"10 um\"",
            "\"0.01 um\"",
            "mesh.half_gap",
            "less than the roughness",
        ),
        (
            "face_width = \"20 mm\"",
            "face_width = 20",
            "gear.face_width",
            "20 m is 250.0 times the pinion's diameter",
        ),
        (
            "module = \"4 mm\"",
            "module = \"200 mm\"",
            "gear.module",
            "unusual module",
        ),
        (
            "\"4e8 N/m\"",
            "\"1e5 N/m\"",
            "mesh.mean_stiffness",
            "steel gears have 10 to 25",
        ),
        (
            "contact_damping = 0.05",
            "contact_damping = 0.8",
            "mesh.contact_damping",
            "0.01 to 0.2",
        ),
        (
            "contact_damping = 0.05",
            "contact_damping = 0.05\nfriction = 0.7",
            "mesh.friction",
            "seizing",
        ),
        (
            "\"5 um\"",
            "\"5 mm\"",
            "excitation.transmission_error.0.amplitude",
            "5 mm is unusually large",
        ),
        (
            "]\n\n[grid]",
            ripple,
            "excitation.torque_ripple.0.amplitude",
            "40 times the rated torque",
        ),
        ("\"12000 rpm\"", "\"200000 rpm\"", "grid.speed", "838 m/s"),
        (
            "\"50 N*m\"",
            "\"50 kN*m\"",
            "gear.rated_torque",
            "which exceeds the strength of any steel",
        ),
        (
            "\"7850 kg/m^3\"",
            "\"7.85 kg/m^3\"",
            "shafts.density",
            "steel has 7850",
        ),
        (
            "\"206 GPa\"",
            "\"2 MPa\"",
            "shafts.young_modulus",
            "2.06e11",
        ),
        (
            "modes = 12",
            "modes = 12\ndamping = 0.5",
            "model.damping",
            "0.005 to 0.1",
        ),
        (
            "diameter = \"26 mm\"",
            "diameter = \"115 mm\"",
            "shafts.wheel.diameter",
            "tip circle of the pinion do not fit",
        ),
        (
            "diameter = \"22 mm\"",
            "diameter = \"75 mm\"",
            "shafts.pinion.diameter",
            "tip circle of the wheel do not fit",
        ),
        (
            "[\"70 mm\"",
            "[\"115 mm\"",
            "gear.body_length",
            "does not fit between bearings",
        ),
    ] {
        let to = if from.ends_with("[grid]") { format!("{to}\n\n[grid]") } else { to.to_owned() };
        let text = quickstart(&[(from, &to)]);
        let found = words(&text, "suspect");
        let word = found.iter().find(|(own, ..)| own == key);
        let (_, line, message) = word.unwrap_or_else(|| panic!("{key}: {found:?}"));
        assert!(message.contains(said), "{key}: {message}");
        // The message names the changed line.
        let name = key
            .split('.')
            .rfind(|part| part.parse::<u32>().is_err())
            .unwrap();
        let named = text.lines().nth(*line as usize - 1).unwrap();
        assert!(named.contains(name), "{key}: {named}");
    }
}

/// Advice on the drawing of a train names keys of its tables.
#[test]
fn a_train_is_advised_on_by_its_own_keys() {
    let text = include_str!("../../manifests/trains/two-stage.toml");
    assert!(text.contains("rated_torque = \"40 N*m\""));
    let text = text.replacen("\"40 N*m\"", "\"400 kN*m\"", 1);
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    let found = manifest::advice(&job);
    let word = found
        .iter()
        .find(|word| word.message.contains("any steel"))
        .unwrap();
    assert_eq!(word.key, "train.rated_torque");
    assert!(word.place.is_some());
}

/// Without a drawing, lengths and speeds have other bounds.
#[test]
fn a_modal_file_is_judged_without_a_drawing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("case.modal.toml"), MODAL_FILE).unwrap();
    let wide = MANIFEST
        .replacen("\"15 um\"", "\"5 mm\"", 1)
        .replacen("700", "70000", 1);
    let job = manifest::parse(&wide, "m.toml", folder.path()).unwrap();
    let keys: Vec<String> = manifest::advice(&job)
        .into_iter()
        .map(|word| word.key)
        .collect();
    assert_eq!(keys, ["mesh.half_gap", "grid.speed"]);
}

/// An oscillator has neither flanks nor, without `torque`, a load of the grid.
#[test]
fn what_an_oscillator_does_not_answer_to_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let modal = "frequency = [1.0]\ndamping = [0.05]\n[[contact]]\nname = \"stop\"\nparticipation = [1.0]\ngap = 0.1\nstiffness = 30.0\n";
    let torque = format!("torque = [1.0]\n{modal}");
    std::fs::write(folder.path().join("without.modal.toml"), modal).unwrap();
    std::fs::write(folder.path().join("with.modal.toml"), torque).unwrap();
    let keys = |file: &str, section: &str| -> Vec<String> {
        let text = format!(
            "job.name = \"o\"\n[model]\nkind = \"modal\"\nfile = \"{file}.modal.toml\"\nlength = 1.0\n\
             [grid]\nspeed = 2.8\nload = {{ values = [0.1, 0.2] }}\n[analyses]\npoincare = {{ section = \"{section}\" }}\n"
        );
        let job = manifest::parse(&text, "m.toml", folder.path()).unwrap();
        (manifest::advice(&job).into_iter())
            .map(|word| word.key)
            .collect()
    };
    assert_eq!(
        keys("without", "entry"),
        ["grid.load", "analyses.poincare.section"]
    );
    assert_eq!(keys("with", "extremum"), [""; 0]);
}

/// Fewer cycles than before the first reading of errors: points that do not settle would end as not_converged, and
/// errors of a survey would be too small.
#[test]
fn fewer_cycles_than_the_first_look_are_advised_on() {
    let cycles = "cycles = 160000 ";
    let rule = "lyapunov = { stop_at_stderr = 0.01 }";
    let survey = "lyapunov = { effort = \"survey\" }";
    let advice = |changes: &[(&str, &str)]| words(&quickstart(changes), "suspect");
    let [(key, line, message)] = &advice(&[(cycles, "cycles = 5000 ")])[..] else {
        panic!("one word is said");
    };
    assert_eq!(key, "run.cycles");
    assert!(message.starts_with("5000 is less than "), "{message}");
    assert!(
        message.contains("not_converged") && message.contains("\"survey\""),
        "{message}"
    );
    let text = quickstart(&[(cycles, "cycles = 5000 ")]);
    let named = text.lines().nth(*line as usize - 1).unwrap();
    assert!(named.starts_with("cycles = 5000"), "{named}");

    // A survey needs fewer, and there is no advice if no exponent is requested.
    for changes in [
        &[(cycles, "cycles = 5000 "), (rule, survey)][..],
        &[(cycles, "cycles = 5000 "), (rule, "#")],
        &[(cycles, "# ")],
    ] {
        assert!(advice(changes).is_empty(), "{changes:?}");
    }
    let [(_, _, message)] = &advice(&[(cycles, "cycles = 1000 "), (rule, survey)])[..] else {
        panic!("one word is said");
    };
    assert!(
        message.contains("less than 2000") && message.contains("too small"),
        "{message}"
    );
}

/// The model of the first point of a manifest.
fn first_model(text: &str) -> Model {
    let job = manifest::parse(text, "m.toml", Path::new("")).unwrap();
    common::parts().model(&job.points.at(0)).unwrap()
}

/// Keys that are reported as without effect have none: the system of the motion is the same without them, bit for bit.
#[test]
fn what_has_no_effect_is_told() {
    let relief = "rated_torque = \"50 N*m\"\ntip_relief = { amount = \"20 um\", length = \"2 mm\" }\nlead_crowning = \"5 um\"\n#";
    let text = quickstart(&[("rated_torque = \"50 N*m\"", relief)]);
    let keys: Vec<String> = words(&text, "no_effect")
        .into_iter()
        .map(|(key, ..)| key)
        .collect();
    assert_eq!(
        keys,
        ["gear.face_width", "gear.tip_relief", "gear.lead_crowning"]
    );
    let wider = quickstart(&[("face_width = \"20 mm\"", "face_width = \"25 mm\"")]);
    assert!(first_model(&text) == first_model(QUICKSTART));
    assert!(first_model(&wider) == first_model(QUICKSTART));

    let rigid = [
        ("kind = \"flexible\"", "kind = \"torsional\""),
        ("modes = 12", ""),
    ];
    let torsional = quickstart(&rigid);
    let keys: Vec<String> = words(&torsional, "no_effect")
        .into_iter()
        .map(|(key, ..)| key)
        .collect();
    for key in [
        "shafts.young_modulus",
        "shafts.elements",
        "shafts.bearings.x",
    ] {
        assert!(keys.iter().any(|own| own == key), "{key}: {keys:?}");
    }
    let soft = quickstart(
        &[
            &rigid[..],
            &[
                ("\"206 GPa\"", "\"106 GPa\""),
                ("\"1.25e8 N/m\"", "\"1e7 N/m\""),
            ],
        ]
        .concat(),
    );
    assert!(first_model(&soft) == first_model(&torsional));

    let silent = quickstart(&[("\"5 um\"", "0")]);
    let found = words(&silent, "no_effect");
    assert_eq!(found[1].0, "excitation.transmission_error.0.amplitude");
    let followed = words(
        include_str!("../../manifests/bifurcations.toml"),
        "no_effect",
    );
    assert!(
        followed.iter().any(|(key, ..)| key == "continuation"),
        "{followed:?}"
    );
}

/// A key that only some points do not use, or that another key activates, is not reported as without effect.
#[test]
fn what_has_an_effect_somewhere_is_not_idle() {
    let keys = |text: &str| -> Vec<String> {
        let found = words(text, "no_effect").into_iter();
        found.map(|(key, ..)| key).collect()
    };
    let load = "load = { from = \"10 %\", to = \"30 %\", count = 3 }";
    let torques =
        |values: &str| quickstart(&[(load, &format!("torque = {{ values = {values} }}"))]);
    let rated = "gear.rated_torque".to_owned();
    assert!(keys(&torques("[0]")).contains(&rated));
    assert!(!keys(&torques("[0, 10]")).contains(&rated));

    let grid = "[grid]\n\"excitation.transmission_error.0.amplitude\" = { values = [0, \"5 um\"] }";
    let found = keys(&quickstart(&[("[grid]", grid)]));
    assert_eq!(found, ["gear.face_width"]);

    let offset = |width: &str| {
        let faces = format!("face_width = [\"20 mm\", \"{width}\"]\nface_offset = [0, \"10 mm\"]");
        quickstart(&[("face_width = \"20 mm\"", &faces)])
    };
    assert!(first_model(&offset("30 mm")) != first_model(&offset("60 mm")));
    assert!(keys(&offset("30 mm")).is_empty());

    // The compliance of a cracked tooth depends on material and width, but not on the form of the flanks.
    let crack = "[mesh]\ntooth_fault = [{ gear = \"pinion\", tooth = 3, crack = \"1 mm\" }]";
    let cracked = |modulus: &str, crowning: &str| {
        let teeth =
            format!("rated_torque = \"50 N*m\"\nyoung_modulus = \"{modulus}\"\n{crowning}\n#");
        quickstart(&[("[mesh]", crack), ("rated_torque = \"50 N*m\"", &teeth)])
    };
    let [crowned, plain] = ["lead_crowning = \"5 um\"", ""].map(|line| cracked("206 GPa", line));
    assert_eq!(keys(&crowned), ["gear.lead_crowning"]);
    assert!(first_model(&crowned) == first_model(&plain));
    assert!(first_model(&cracked("100 GPa", "")) != first_model(&plain));

    // A modal file has no rated torque that could be left out.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("case.modal.toml"), MODAL_FILE).unwrap();
    let idle = MANIFEST.replacen("load = 0.1", "load = 0", 1);
    let job = manifest::parse(&idle, "m.toml", folder.path()).unwrap();
    assert!(manifest::advice(&job).is_empty());
}

/// An axis over an unused key repeats every point, and a common value that both shafts override has no effect.
#[test]
fn axes_and_shared_values_without_effect_are_told() {
    let keys = |changes: &[(&str, &str)]| -> Vec<String> {
        let words = words(&quickstart(changes), "no_effect").into_iter();
        words.map(|(key, ..)| key).collect()
    };
    let slope = "[grid]\n\"gear.lead_slope\" = { values = [1e-4, 2e-4] }\n#";
    assert_eq!(
        keys(&[("[grid]", slope)]),
        ["gear.face_width", "gear.lead_slope"]
    );

    let pinion = ("[shafts.pinion]", "[shafts.pinion]\nspan = 0.12");
    assert_eq!(keys(&[pinion]), ["gear.face_width"]);
    let wheel = ("[shafts.wheel]", "[shafts.wheel]\nspan = 0.12");
    assert_eq!(keys(&[pinion, wheel]), ["gear.face_width", "shafts.span"]);
    let axis = (
        "[grid]",
        "[grid]\n\"shafts.wheel.span\" = { values = [0.12, 0.13] }\n#",
    );
    assert_eq!(keys(&[pinion, axis]), ["gear.face_width", "shafts.span"]);
}

/// Harmonics of the stiffness with peaks at different phases have a smaller range than the sum of their amplitudes.
#[test]
fn a_fourier_series_is_told_by_its_extremes() {
    let folder = tempfile::tempdir().unwrap();
    let series =
        "mesh.stiffness_harmonics=[{harmonic=1,amplitude=2.2e8},{harmonic=2,amplitude=2.2e8}]";
    let said = check(
        folder.path(),
        &["--set", "mesh.stiffness=fourier", "--set", series],
    );
    let told = "Fourier series of 2 harmonics, 1.525e8 ... 8.4e8 N/m, mean 4e8";
    assert!(said.contains(told), "{said}");
}

/// Data of the gears from the drawing and as used are next to each other.
#[test]
fn the_gears_are_told() {
    let computed = quickstart(&[
        ("stiffness = \"piecewise\"", "stiffness = \"table\" #"),
        ("mean_stiffness", "# mean_stiffness"),
        ("contact_ratio", "# contact_ratio"),
        ("single_pair_drop", "# single_pair_drop"),
        ("half_gap = \"10 um\"", "#"),
        ("rated_torque", "thinning = \"20 um\"\nrated_torque"),
    ]);
    let value = told(&computed);
    let gears = &value["gears"];
    let number = |key: &str| {
        gears[key]
            .as_f64()
            .unwrap_or_else(|| panic!("{key}: {gears:#}"))
    };
    // 20/30 teeth of the ISO 53 rack at 20 degrees: z (tan α_a − tan α)/2π of both gears.
    let reach = |teeth: f64| {
        let alpha = 20f64.to_radians();
        let tip = (teeth * alpha.cos() / (teeth + 2.0)).acos();
        teeth * (tip.tan() - alpha.tan()) / std::f64::consts::TAU
    };
    assert!((number("contact_ratio") - reach(20.0) - reach(30.0)).abs() < 1e-12);
    assert!(number("contact_ratio_loaded") >= number("contact_ratio"));
    // The teeth of both gears are 20 um thinner on the pitch circle.
    let half = 20e-6 * 20f64.to_radians().cos();
    assert!((number("drawn_half_gap") / half - 1.0).abs() < 1e-9);
    assert_eq!(number("drawn_half_gap"), number("half_gap"));
    assert!(number("stiffness_min") < number("stiffness_mean"));
    assert!(number("stiffness_mean") < number("stiffness_max"));

    let given = told(QUICKSTART);
    assert_eq!(given["gears"]["drawn_half_gap"], serde_json::Value::Null);
    let levels =
        ["stiffness_min", "stiffness_max"].map(|key| given["gears"][key].as_f64().unwrap());
    assert!((levels[0] / levels[1] - 0.75).abs() < 1e-12, "{levels:?}");
}

/// Keys from the command line are checked like those of the manifest.
#[test]
fn what_is_set_is_advised_on() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), QUICKSTART).unwrap();
    let checked = |set: &[&str], arguments: &[&str]| {
        let set = set.iter().flat_map(|change| ["--set", *change]);
        let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
            .args(["check", "m.toml"])
            .args(set.chain(arguments.iter().copied()))
            .current_dir(folder.path())
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let relief = "gear.tip_relief={ amount = \"20 um\", length = 0.3 }";
    assert!(!checked(&[], &[]).contains("gear.tip_relief"));
    let text = checked(&[relief], &[]);
    assert!(
        text.contains("gear.tip_relief (--set): has no effect"),
        "{text}"
    );
    let gap = checked(&["mesh.half_gap=1.5 mm"], &["--json"]);
    let value: serde_json::Value = serde_json::from_str(&gap).unwrap();
    let word = &value["advice"].as_array().unwrap()[0];
    assert_eq!(word["key"], "mesh.half_gap");
    assert_eq!(word["set"], true);
    assert_eq!(word["line"], serde_json::Value::Null);
}

/// Orders of mesh and shafts that meet a mode near the speeds of the grid, the same as in a Campbell diagram.
#[test]
fn resonances_are_told_by_order() {
    let value = told(&quickstart(&[("\"6000 rpm\"", "\"2000 rpm\"")]));
    let structure = &value["structure"];
    let found = structure["resonances"].as_array().unwrap();
    assert!(
        found
            .iter()
            .any(|one| one["excitation"] == "1 × mesh" && one["contacts"] == "closed")
    );
    assert!(
        found
            .iter()
            .any(|one| one["excitation"] == "1 × mesh" && one["contacts"] == "open")
    );
    for one in found {
        let rpm = one["speed"].as_f64().unwrap() * 30.0 / std::f64::consts::PI;
        assert!((0.9 * 2000.0..=1.1 * 12000.0).contains(&rpm), "{one}");
        let turns = match one["excitation"].as_str().unwrap() {
            "1 × pinion" => 1.0,
            "1 × wheel" => 20.0 / 30.0,
            mesh => {
                20.0 * mesh
                    .strip_suffix(" × mesh")
                    .unwrap()
                    .parse::<f64>()
                    .unwrap()
            }
        };
        let modes = &structure[one["contacts"].as_str().unwrap()];
        let mode = &modes[one["mode"].as_u64().unwrap() as usize - 1];
        let meets = rpm / 60.0 * turns;
        assert!(
            (meets / mode["frequency_hz"].as_f64().unwrap() - 1.0).abs() < 1e-12,
            "{one}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let text = quickstart(&[("\"6000 rpm\"", "\"2000 rpm\"")]);
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(["plot", "m.toml", "--what", "campbell", "--json"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let drawn: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(&drawn["resonances"], &structure["resonances"]);
}

#[test]
fn the_load_of_rolling_bearings_is_told() {
    let text = include_str!("../../manifests/trains/two-stage.toml");
    let counter = text.find("name = \"counter\"").unwrap();
    let own = text[counter..].replacen(
        r#"x = "1.5e8 N/m", y = "1.2e8 N/m", axial"#,
        r#"ball = { count = 9, diameter = "11.1 mm", pitch_diameter = "53.5 mm" }, axial"#,
        1,
    );
    let text = format!("{}{own}", &text[..counter]).replacen("modes = 30", "modes = 10", 1);
    let value = told(&text);
    let bearings = &value["loaded_bearings"];
    assert_eq!(bearings["at_load"], 1.0);
    let [own] = &bearings["bearings"].as_array().unwrap()[..] else {
        panic!("{bearings:#}");
    };
    assert_eq!(own["name"], "counter 1");
    assert_eq!(own["stiffness"].as_array().unwrap().len(), 5);
    assert!(own["elements"].as_u64().unwrap() > 2);
    // Without rolling bearings nothing is reported, and the key has no effect.
    let plain = include_str!("../../manifests/trains/two-stage.toml");
    assert!(told(plain)["loaded_bearings"].is_null());
    let idle = plain.replacen("[train]", "[train]\nbearing_load = 0.5", 1);
    let warning = &told(&idle)["warnings"][0];
    assert_eq!(warning["key"], "train.bearing_load");
}

/// `check` lists further meshes from the drawing, with the mean force of hand statics.
#[test]
fn further_meshes_from_the_drawing_are_listed() {
    let text = include_str!("../../manifests/trains/two-stage.toml");
    let given = "levels = [\"5e8 N/m\", \"5e8 N/m\", \"5e8 N/m\", \"3.8e8 N/m\", \"3.8e8 N/m\"]";
    assert!(text.contains(given));
    let value = told(&text.replacen(given, "law = \"continuous\"", 1));
    assert!(value["first_point_error"].is_null(), "{value:#}");
    let [mesh] = &value["gears"]["further_meshes"].as_array().unwrap()[..] else {
        panic!("{:#}", value["gears"]);
    };
    assert_eq!(mesh["gears"], serde_json::json!(["z18", "z54"]));
    // Torque: 5 % of 40 N m times 50/20, on 18 teeth of 3 mm, and 1 N m of drag on 54 teeth.
    let torques = 0.05 * 40.0 * 50.0 / 20.0 / 27e-3 + 1.0 / 81e-3;
    let force = torques / 20f64.to_radians().cos();
    let number = |key: &str| mesh[key].as_f64().unwrap();
    assert!((number("force") / force - 1.0).abs() < 1e-10, "{mesh:#}");
    assert!(number("stiffness_min") < number("stiffness_mean"));
    assert!(number("stiffness_mean") < number("stiffness_max"));
    assert!((1.0..2.0).contains(&number("contact_ratio_loaded")));
    assert_eq!(told(text)["gears"]["further_meshes"], serde_json::json!([]));
}

/// `check` reports why the first point of a valid manifest has no solution.
#[test]
fn a_first_point_without_a_solution_is_reported() {
    let text = include_str!("../../manifests/trains/two-stage.toml");
    let unloaded = [
        ("levels = [\"5e8 N/m\"", "law = \"continuous\" # "),
        ("drag_torque", "# drag_torque"),
        ("\nload = {", "\nload = 0 # {"),
    ];
    let unloaded = unloaded.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    let value = told(&unloaded);
    let error = value["first_point_error"].as_str().unwrap();
    assert!(
        error.contains("the mesh of z18 and z54") && error.contains("the load is 0"),
        "{error}"
    );
    assert!(told(text)["first_point_error"].is_null());
}
