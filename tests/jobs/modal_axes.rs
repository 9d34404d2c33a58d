//! Numbers of a modal file as axes, expressions between axes, and oscillators without a mesh.

#![allow(clippy::unwrap_used)]

use crate::program::{printed, refused, said};
use gearatlas::store::{ResultTable, TableKind};
use std::fs;
use std::path::Path;

/// An oscillator with a stop and a harmonic force, with the given gap and force.
fn oscillator(gap: f64, force: f64) -> String {
    format!(
        "frequency = [1.0]\ndamping = [0.05]\n\
         [[contact]]\nname = \"stop\"\nparticipation = [1.0]\ngap = {gap:?}\nstiffness = 30.0\n\
         [[harmonic_load]]\nname = \"shaker\"\nforce = [{force:?}]\ncycles = [1, 1]\n"
    )
}

/// A job over some axes.
fn job(model: &str, grid: &str, rest: &str) -> String {
    format!(
        "job.name = \"j\"\n[model]\nkind = \"modal\"\nfile = \"s.modal.toml\"\n{model}\n\
         [grid]\n{grid}\n[run]\ntransient = 200\ncycles = 400\n\
         [analyses]\nnvh = {{}}\nlyapunov = {{ exponents = 2, effort = \"survey\" }}\n{rest}\n"
    )
}

fn write(folder: &Path, modal: &str, manifest: &str) {
    fs::write(folder.join("s.modal.toml"), modal).unwrap();
    fs::write(folder.join("m.toml"), manifest).unwrap();
}

/// Columns of the points of a job.
fn run(modal: &str, manifest: &str, columns: &[&str]) -> Vec<Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), modal, manifest);
    said(folder.path(), &["run", "m.toml", "--quiet", "--out", "r"]);
    let table = ResultTable::read(&folder.path().join("r"), TableKind::Points).unwrap();
    let column = |name: &&str| {
        table
            .f64(name)
            .unwrap()
            .into_iter()
            .map(|v| v.unwrap())
            .collect()
    };
    columns.iter().map(column).collect()
}

/// Kind, period and axis value of the results of `atlas follow`, sorted.
fn follow(modal: &str, manifest: &str, over: &str) -> Vec<(String, u64, f64)> {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), modal, manifest);
    said(
        folder.path(),
        &["follow", "m.toml", "--quiet", "--out", "r"],
    );
    let table = ResultTable::read(&folder.path().join("r"), TableKind::Bifurcations).unwrap();
    let (kinds, periods) = (table.text("kind").unwrap(), table.u64("period").unwrap());
    let places = table.f64(over).unwrap();
    let mut rows: Vec<(String, u64, f64)> = (0..table.rows())
        .map(|row| {
            (
                kinds[row].clone().unwrap(),
                periods[row].unwrap(),
                places[row].unwrap(),
            )
        })
        .filter(|(kind, ..)| kind != "end")
        .collect();
    rows.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)).then(a.1.cmp(&b.1)));
    rows
}

const MOTION: [&str; 4] = [
    "lambda_max",
    "deflection_mean",
    "deflection_rms",
    "events_per_cycle",
];

#[test]
fn a_swept_gap_is_the_gap_of_a_file() {
    let gaps = [-0.1, 0.2, 0.7];
    let grid =
        "speed = { values = [0.8, 2.8] }\n\"contact.stop.gap\" = { values = [-0.1, 0.2, 0.7] }";
    let length = "length = 1.0";
    let swept = run(&oscillator(5.0, 1.0), &job(length, grid, ""), &MOTION);
    for (number, gap) in gaps.into_iter().enumerate() {
        let grid = "speed = { values = [0.8, 2.8] }";
        let own = run(&oscillator(gap, 1.0), &job(length, grid, ""), &MOTION);
        for (swept, own) in swept.iter().zip(&own) {
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(
                bits(&swept[2 * number..2 * number + 2]),
                bits(own),
                "gap {gap}"
            );
        }
    }
}

/// A mass on a belt: swept numbers are those of a file, and on a belt that is too fast it never sticks.
/// A range of gaps through zero often has a value of round-off instead of 0. It is no scale of the motion.
#[test]
fn a_gap_of_round_off_is_a_gap_of_zero() {
    let grid = "speed = 2.8\n\"contact.stop.gap\" = { values = [-1e-12, 0.0, 2.8e-17, 1e-10] }";
    for kernel in ["closed_modes", "volterra", "stepping"] {
        let manifest = job("length = 1.0", grid, "")
            .replace("[run]", &format!("[run]\nkernel = \"{kernel}\""));
        let found = run(&oscillator(0.0, 1.0), &manifest, &MOTION[1..]);
        for column in &found {
            assert!(
                column.iter().all(|value| (value - column[1]).abs() < 1e-6),
                "{kernel}: {column:?}"
            );
        }
    }
}

/// Results know where the files of their manifest are.
#[test]
fn a_point_is_named_by_its_values_from_any_folder() {
    let [folder, elsewhere] = [0, 1].map(|_| tempfile::tempdir().unwrap());
    let manifest = job("", "speed = { values = [0.8, 0.9] }", "poincare = {}");
    write(folder.path(), &oscillator(0.1, 1.0), &manifest);
    said(folder.path(), &["run", "m.toml", "--quiet", "--out", "r"]);
    let results = folder.path().join("r");
    let results = results.to_str().unwrap();
    let drawn = said(
        elsewhere.path(),
        &[
            "plot",
            results,
            "--point",
            "speed=0.9",
            "--what",
            "phase",
            "--out",
            "p",
        ],
    );
    assert!(drawn.contains("point1"), "{drawn}");
}

#[test]
fn a_swept_belt_is_the_belt_of_a_file() {
    let belt = |force: f64, speed: f64| {
        format!(
            "frequency = [1.0]\ndamping = [0.05]\n\
             [[dry_friction]]\nname = \"belt\"\nparticipation = [1.0]\nforce = {force:?}\n\
             static_force = 1.0\nbelt_speed = {speed:?}\n"
        )
    };
    let model = "length = 1.0";
    let grid = "speed = 6.0\n\"dry_friction.belt.force\" = { values = [0.6, 0.8] }\n\
                \"dry_friction.belt.belt_speed\" = { values = [0.2, 3.0] }";
    let run_at_rest = |modal: &str, grid: &str| {
        let manifest = job(model, grid, "").replace("[run]\n", "[run]\ninitial = \"rest\"\n");
        run(
            modal,
            &manifest,
            &["deflection_mean", "deflection_rms", "events_per_cycle"],
        )
    };
    let swept = run_at_rest(&belt(0.5, 9.0), grid);
    for (number, (force, speed)) in [(0.6, 0.2), (0.8, 0.2), (0.6, 3.0), (0.8, 3.0)]
        .into_iter()
        .enumerate()
    {
        let own = run_at_rest(&belt(force, speed), "speed = 6.0");
        for (swept, own) in swept.iter().zip(&own) {
            assert_eq!(swept[number].to_bits(), own[0].to_bits(), "{force} {speed}");
        }
        let [mean, rms, events] = [0, 1, 2].map(|column| swept[column][number]);
        if speed > 1.0 {
            assert!(
                (mean - force).abs() < 1e-9 && rms < 1e-6 && events == 0.0,
                "{mean} {rms}"
            );
        } else {
            assert!(rms > 0.1 && events > 0.1, "{rms} {events}");
        }
    }
}

#[test]
fn set_changes_a_number_as_an_axis_does() {
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &oscillator(5.0, 1.0),
        &job("length = 1.0", "speed = 2.8", ""),
    );
    let hash = |set: &[&str]| {
        let set = set.iter().flat_map(|set| ["--set", set]);
        let all: Vec<&str> = ["check", "m.toml", "--json"]
            .into_iter()
            .chain(set)
            .collect();
        let told: serde_json::Value = serde_json::from_str(&said(folder.path(), &all)).unwrap();
        told["manifest_hash"]
            .as_str()
            .or(told["hash"].as_str())
            .unwrap()
            .to_owned()
    };
    let changed = hash(&["contact.stop.gap=0.2", "harmonic_load.shaker.force[1]=0.5"]);
    assert_ne!(changed, hash(&[]));
    fs::write(folder.path().join("s.modal.toml"), oscillator(0.2, 0.5)).unwrap();
    assert_eq!(changed, hash(&[]));
    let wrong = ["check", "m.toml", "--set", "contact.stp.gap=1"];
    let told = refused(folder.path(), &wrong, 2);
    assert!(told.contains("contact.stop.gap"), "{told}");
}

#[test]
fn an_expression_is_a_tied_list() {
    let speeds = [0.5, 0.9, 1.3];
    let grid = |force: &str| {
        let tied = if force.contains("values") {
            "tied = [[\"speed\", \"harmonic_load.shaker.force[1]\"]]\n"
        } else {
            ""
        };
        format!(
            "{tied}speed = {{ values = [0.5, 0.9, 1.3] }}\n\"harmonic_load.shaker.force[1]\" = {force}"
        )
    };
    let columns = [&MOTION[..], &["harmonic_load.shaker.force[1]"]].concat();
    let values = speeds.map(|speed: f64| 0.3 * speed.powf(2.0));
    let modal = oscillator(0.2, 1.0);
    let written = run(
        &modal,
        &job(
            "length = 1.0",
            &grid(&format!("{{ values = {values:?} }}")),
            "",
        ),
        &columns,
    );
    let expressed = run(
        &modal,
        &job("length = 1.0", &grid("\"0.3 * speed^2\""), ""),
        &columns,
    );
    assert_eq!(expressed, written);
    assert_eq!(expressed[4], values);
}

#[test]
fn what_is_no_number_of_the_file_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (grid, told) in [
        ("\"contact.stp.gap\" = 0.1", "contact.stop.gap"),
        ("\"contact.stop.gapp\" = 0.1", "contact.stop.gap"),
        ("\"frequency[2]\" = 3.0", "frequency"),
        ("\"damping[1]\" = 1.5", "less than 1"),
        ("\"contact.stop.gap\" = \"2 * sped\"", "nearest: `speed`"),
        (
            "\"contact.stop.gap\" = \"1 / (speed - 2.8)\"",
            "speed = 2.8",
        ),
        (
            "\"contact.stop.gap\" = \"damping[1]\"\n\"damping[1]\" = \"contact.stop.gap\"",
            "circle",
        ),
    ] {
        let manifest = job("length = 1.0", &format!("speed = 2.8\n{grid}"), "");
        write(folder.path(), &oscillator(0.2, 1.0), &manifest);
        let words = refused(folder.path(), &["check", "m.toml"], 2);
        assert!(words.contains(told), "{grid}: {words}");
    }
}

/// Orbits are found at the same values for any unit of length.
#[test]
fn bifurcations_do_not_depend_on_the_length() {
    let grid = "speed = { from = 0.6, to = 1.0, count = 5 }";
    let rest = "[continuation]\nover = \"speed\"\nstarts = 9\nlongest_period = 8\n";
    let modal = "frequency = [1.0]\ndamping = [0.01]\n\
                 [[contact]]\nname = \"stop\"\nparticipation = [1.0]\ngap = 1.0\nstiffness = 29.0\n\
                 [[harmonic_load]]\nname = \"s\"\nforce = [0.45714285714285713]\ncycles = [1, 1]\n";
    let found = |length: f64| {
        follow(
            modal,
            &job(&format!("length = {length:?}"), grid, rest),
            "speed",
        )
    };
    let reference = found(1.0);
    assert!(
        reference
            .iter()
            .filter(|(kind, ..)| kind == "graze")
            .count()
            > 2,
        "{reference:#?}"
    );
    for length in [3.0, 100.0, 1e4] {
        let own = found(length);
        let names = |rows: &[(String, u64, f64)]| {
            rows.iter()
                .map(|(kind, period, _)| (kind.clone(), *period))
                .collect::<Vec<_>>()
        };
        assert_eq!(
            names(&own),
            names(&reference),
            "{length}: {own:#?} {reference:#?}"
        );
        for (own, reference) in own.iter().zip(&reference) {
            assert!(
                (own.2 - reference.2).abs() < 1e-8,
                "{length}: {own:?} {reference:?}"
            );
        }
    }
}

/// A period doubling over the gap of the stop is between the gaps at which a sweep finds periods 2 and 4.
#[test]
fn a_doubling_over_the_gap_is_where_a_sweep_finds_it() {
    let modal = oscillator(0.0, 1.0);
    let rest = "[continuation]\nover = \"contact.stop.gap\"\nstarts = 3\nlongest_period = 4\n";
    let grid = "speed = 2.8\n\"contact.stop.gap\" = { from = -0.1, to = 0.1, count = 2 }";
    let found = follow(&modal, &job("length = 1.0", grid, rest), "contact.stop.gap");
    let doublings: Vec<f64> = found
        .iter()
        .filter(|own| own.0 == "period_doubling" && own.1 == 2)
        .map(|own| own.2)
        .collect();
    assert!(!doublings.is_empty(), "{found:#?}");
    let at = doublings[0];
    let gaps = [at - 1e-3, at + 1e-3];
    let grid = format!("speed = 2.8\n\"contact.stop.gap\" = {{ values = {gaps:?} }}");
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &modal, &job("length = 1.0", &grid, ""));
    said(folder.path(), &["run", "m.toml", "--quiet", "--out", "r"]);
    let table = ResultTable::read(&folder.path().join("r"), TableKind::Points).unwrap();
    let mut periods: Vec<u64> = table.u64("period").unwrap().into_iter().flatten().collect();
    periods.sort_unstable();
    assert_eq!(periods, [2, 4], "at {at}");
}

/// The linear motion touches the stop if the gap equals its amplitude `F/√((ω² − Ω²)² + (2ζωΩ)²)`, for any stiffness.
#[test]
fn a_linear_motion_grazes_where_the_gap_is_its_amplitude() {
    let rest = "[continuation]\nover = \"contact.stop.gap\"\nstarts = 2\nlongest_period = 1\n";
    let grid = "speed = 2.8\n\"contact.stop.gap\" = { from = 0.13, to = 0.2, count = 2 }";
    let (frequency, force, damping): (f64, f64, f64) = (2.8, 1.0, 0.05);
    let square = (1.0 - frequency * frequency).powi(2) + (2.0 * damping * frequency).powi(2);
    let amplitude = force / square.sqrt();
    for stiffness in ["30.0", "500.0"] {
        let modal = oscillator(0.2, force).replace("30.0", stiffness);
        let found = follow(&modal, &job("", grid, rest), "contact.stop.gap");
        let grazes = found.iter().filter(|own| own.0 == "graze");
        let nearest = grazes
            .map(|own| (own.2 - amplitude).abs())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-12, "{nearest} {amplitude} {found:#?}");
    }
}

/// For a force `a Ω²` from an expression, orbits over the speed have the force of their speed.
#[test]
fn an_expression_is_evaluated_along_a_branch() {
    let folder = tempfile::tempdir().unwrap();
    let rest = "[continuation]\nover = \"speed\"\nstarts = 2\nlongest_period = 1\n";
    let grid = "speed = { from = 0.6, to = 0.9, count = 2 }\n\"harmonic_load.shaker.force[1]\" = \"0.5 * speed^2\"";
    write(folder.path(), &oscillator(1.0, 1.0), &job("", grid, rest));
    said(
        folder.path(),
        &["follow", "m.toml", "--quiet", "--out", "r"],
    );
    let table = ResultTable::read(&folder.path().join("r"), TableKind::Bifurcations).unwrap();
    let column = |name: &str| -> Vec<f64> {
        table
            .f64(name)
            .unwrap()
            .into_iter()
            .map(|value| value.unwrap())
            .collect()
    };
    let (speeds, forces) = (column("speed"), column("harmonic_load.shaker.force[1]"));
    assert!(!speeds.is_empty());
    for (speed, force) in speeds.iter().zip(&forces) {
        assert!(
            (force - 0.5 * speed * speed).abs() < 1e-14,
            "{speed} {force}"
        );
    }
    // The linear motion touches the stop if its amplitude equals the gap, 1.
    let beyond = |speed: f64| {
        let square = (1.0 - speed * speed).powi(2) + (0.1 * speed).powi(2);
        0.5 * speed * speed / square.sqrt() - 1.0
    };
    let (mut low, mut high) = (0.6, 0.9);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if beyond(middle) < 0.0 { low = middle } else { high = middle }
    }
    let nearest = speeds
        .iter()
        .map(|at| (at - low).abs())
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-11, "{low}: {speeds:?}");
}

/// Derivatives of a settled motion with respect to the stiffness of the stop agree with differences of files.
#[test]
fn sensitivities_by_a_stiffness_are_differences() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = job("length = 1.0", "speed = 0.8", "");
    let modal = oscillator(0.2, 1.0);
    write(folder.path(), &modal, &manifest);
    let told = printed(
        folder.path(),
        &[
            "sensitivity",
            "m.toml",
            "--by",
            "contact.stop.stiffness",
            "--json",
        ],
    );
    let rows: serde_json::Value = serde_json::from_str(&told).unwrap();
    let rows = rows["sensitivities"]
        .as_array()
        .or(rows.as_array())
        .or(rows["rows"].as_array())
        .unwrap()
        .clone();
    let row = rows
        .iter()
        .find(|row| row["quantity"] == "deflection_rms")
        .unwrap();
    assert_eq!(row["key"], "contact.stop.stiffness");
    let by = row["derivative"].as_f64().unwrap();
    let rms = |stiffness: &str| {
        let changed = modal.replace("stiffness = 30.0", &format!("stiffness = {stiffness}"));
        run(&changed, &manifest, &["deflection_rms"])[0][0]
    };
    let difference = (rms("30.03") - rms("29.97")) / 0.06;
    assert!(
        (by - difference).abs() < 1e-4 * by.abs(),
        "{by} {difference}"
    );
}
