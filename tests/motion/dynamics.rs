//! Requests of nonsmooth dynamics research, through the program: all exponents with errors, the dimension, the
//! histories of estimates, covariant vectors, sections at events, seeds and separations as axes.

#![allow(clippy::unwrap_used)]

use gearatlas::store::{ResultTable, TableKind};
use std::path::Path;
use std::process::Command;

const STRUCTURE: &str = "teeth = 20\nrated_force = 1330.0\nfrequency = [0.0]\ndamping = [0.0]\nmesh = [1.0]\n\
                         torque = [1.0]\n";

/// A chaotic oscillator of one degree of freedom.
const MANIFEST: &str = r#"
[job]
name = "chaotic"
[model]
kind = "modal"
file = "one.modal.toml"
[mesh]
half_gap = "10 um"
stiffness = "constant"
mean_stiffness = "4e8 N/m"
contact_damping = "1483 N*s/m"
[excitation]
transmission_error = [{ harmonic = 1, amplitude = "2 um" }]
[grid]
load = 0.5
speed = 1320
"analyses.lyapunov.separation" = { values = [1e-8, 1e-6] }
"job.seed" = { values = [1, 2] }
[run]
transient = 300
cycles = 1000
[analyses]
lyapunov = { exponents = 2, course = 10, effort = "survey" }
poincare = { section = "force_maximum", samples = 50 }
covariant = { vectors = 2, cycles = 800, align = 100 }
"#;

fn atlas(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let said = [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
    (output.status.code(), said.concat())
}

fn folder(manifest: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("one.modal.toml"), STRUCTURE).unwrap();
    std::fs::write(folder.path().join("m.toml"), manifest).unwrap();
    folder
}

#[test]
fn a_chaotic_oscillator_is_answered_in_full() {
    let folder = folder(MANIFEST);
    let path = folder.path();
    for threads in ["1", "3"] {
        let (status, said) = atlas(
            path,
            &[
                "run",
                "m.toml",
                "--out",
                threads,
                "--threads",
                threads,
                "--quiet",
            ],
        );
        assert_eq!(status, Some(0), "{said}");
    }
    let bytes = |out: &str| std::fs::read(path.join(out).join("poincare.parquet")).unwrap();
    assert!(bytes("1") == bytes("3"));
    let [points, again] =
        ["1", "3"].map(|out| ResultTable::read(&path.join(out), TableKind::Points).unwrap());
    assert_eq!(points.rows(), 4);
    let list = |name: &str| -> Vec<Vec<f64>> {
        let column = points.lists(name).unwrap();
        assert_eq!(column, again.lists(name).unwrap(), "{name}");
        let rows = column.into_iter().map(Option::unwrap);
        rows.map(|row| row.into_iter().map(Option::unwrap).collect())
            .collect()
    };
    let number = |name: &str| -> Vec<f64> {
        let column = points.f64(name).unwrap();
        column.into_iter().map(Option::unwrap).collect()
    };
    assert_eq!(number("job.seed"), [1.0, 2.0, 1.0, 2.0]);
    assert_eq!(
        number("analyses.lyapunov.separation"),
        [1e-8, 1e-8, 1e-6, 1e-6]
    );
    let (exponents, errors) = (list("exponents"), list("exponents_stderr"));
    let (covariant, doubts) = (
        list("covariant_exponents"),
        list("covariant_exponents_stderr"),
    );
    let (dimension, doubt) = (number("kaplan_yorke"), number("kaplan_yorke_stderr"));
    let (cycles, course, bars) = (
        list("course_cycles"),
        list("course_exponents"),
        list("course_stderr"),
    );
    for row in 0..4 {
        let (own, error) = (&exponents[row], &errors[row]);
        assert!(own[0] > 0.1 && own[1] < 0.0, "{own:?}");
        assert_eq!(error[0], number("lambda_stderr")[row]);
        let exact = 1.0 + own[0] / own[1].abs();
        assert!(
            (dimension[row] - exact).abs() < 1e-12,
            "{dimension:?} {exact}"
        );
        assert!(doubt[row] > 0.0 && doubt[row] < 0.1, "{doubt:?}");
        for i in 0..2 {
            let apart = (own[i] - covariant[row][i]).abs();
            let both = error[i].hypot(doubts[row][i]);
            assert!(apart < 4.0 * both, "{own:?} {:?} {both}", covariant[row]);
        }
        // The history ends at the estimate.
        assert_eq!((cycles[row].len(), course[row].len()), (10, 20));
        assert_eq!((course[row][9], course[row][19]), (own[0], own[1]));
        assert_eq!((bars[row][9], bars[row][19]), (error[0], error[1]));
    }
    let (least, quantiles) = (number("angle_min"), list("angle_quantiles"));
    for (least, quantiles) in least.iter().zip(&quantiles) {
        assert!(*least > 0.0 && *least <= quantiles[0] && quantiles.is_sorted());
        assert!(quantiles[4] <= std::f64::consts::FRAC_PI_2);
    }
    let sections = ResultTable::read(&path.join("1"), TableKind::Poincare).unwrap();
    let kinds = sections.text("section").unwrap();
    assert_eq!(kinds.len(), 200);
    assert!(
        kinds
            .iter()
            .all(|kind| kind.as_deref() == Some("force_maximum"))
    );

    let drawn = [
        "plot",
        "1",
        "--what",
        "convergence",
        "--format",
        "svg",
        "--point",
        "2",
    ];
    let (status, said) = atlas(path, &drawn);
    assert_eq!(status, Some(0), "{said}");
    let picture = path.join("1/pictures/convergence-point2.svg");
    let picture = std::fs::read_to_string(picture).unwrap();
    assert!(picture.contains("λ1 = ") && picture.contains("λ2 = "));
}

#[test]
fn what_was_not_asked_for_is_told() {
    let plain = MANIFEST
        .replace("course = 10, ", "")
        .replace("cycles = 1000", "cycles = 400")
        .replace("covariant = { vectors = 2, cycles = 800, align = 100 }", "");
    let folder = folder(&plain);
    let path = folder.path();
    let (status, said) = atlas(path, &["run", "m.toml", "--out", "r", "--quiet"]);
    assert!([Some(0), Some(3)].contains(&status), "{said}");
    let points = ResultTable::read(&path.join("r"), TableKind::Points).unwrap();
    for name in ["course_cycles", "covariant_exponents", "angle_quantiles"] {
        assert_eq!(points.lists(name).unwrap(), vec![None; 4], "{name}");
    }
    let (status, said) = atlas(path, &["plot", "r", "--what", "convergence"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("lyapunov.course"), "{said}");
    let too_much = MANIFEST.replace("cycles = 800", "cycles = 900000000");
    std::fs::write(path.join("m.toml"), too_much).unwrap();
    let (status, said) = atlas(path, &["check", "m.toml"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("at most 1024 MiB"), "{said}");
}
