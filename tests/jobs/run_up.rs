//! `atlas runup` and `atlas sound` as a user runs them.

#![allow(clippy::unwrap_used)]

use crate::program::{printed, refused, said};
use gearatlas::store::{ResultTable, TableKind};
use std::path::Path;
use tempfile::TempDir;

const SPEED: &str = r#"speed = { from = "600 rpm", to = "1500 rpm", in = "0.2 s" }"#;

/// A folder with the rigid pair of the tiers, and what its run-up is.
fn folder(runup: &str) -> TempDir {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/tiers/torsional.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), format!("{text}\n{runup}\n")).unwrap();
    folder
}

/// All tables are there with what they promise, a second time with the same bytes; a sound file is as long as the signal.
#[test]
fn a_run_up_has_its_tables_and_its_sound() {
    let own = format!(
        "[runup]\n{SPEED}\nsettle = 0\norders = [0, 20]\nrevolutions = 1\nsample_rate = 8000\nfrequency_step = 50\nsignals = [\"deflection\", \"force\"]"
    );
    let folder = folder(&own);
    let at = folder.path();
    let text = said(at, &["runup", "m.toml", "--out", "a"]);
    assert!(text.contains("600 to 1500 rpm in 0.2 s"), "{text}");
    said(at, &["runup", "m.toml", "--out", "b", "--threads", "1"]);
    let kinds = [
        TableKind::Signals,
        TableKind::OrderTracks,
        TableKind::Levels,
        TableKind::Spectrogram,
        TableKind::ContactChanges,
    ];
    for kind in kinds {
        let [a, b] =
            ["a", "b"].map(|out| std::fs::read(at.join(out).join(kind.file_name())).unwrap());
        assert!(a == b, "{}", kind.name());
        assert!(ResultTable::read(&at.join("a"), kind).is_ok());
    }
    let column = |kind, name: &str| -> Vec<f64> {
        let table = ResultTable::read(&at.join("a"), kind).unwrap();
        table
            .f64(name)
            .unwrap()
            .into_iter()
            .map(Option::unwrap)
            .collect()
    };
    let (times, speeds) = (
        column(TableKind::Signals, "time"),
        column(TableKind::Signals, "speed"),
    );
    assert_eq!((times.len(), times[0], times[1600]), (1601, 0.0, 0.2));
    let rpm = std::f64::consts::TAU / 60.0;
    assert!((speeds[0] / rpm - 600.0).abs() < 1e-9 && (speeds[1600] / rpm - 1500.0).abs() < 1e-9);
    // Order 0 is the mean, under another window.
    let (orders, amplitudes) = (
        column(TableKind::OrderTracks, "order"),
        column(TableKind::OrderTracks, "amplitude"),
    );
    let means = column(TableKind::Levels, "mean");
    let of_order = orders
        .iter()
        .zip(&amplitudes)
        .filter(|(order, _)| **order == 0.0);
    assert_eq!(of_order.clone().count(), means.len());
    for ((_, amplitude), mean) in of_order.zip(&means) {
        assert!(
            (amplitude / mean.abs() - 1.0).abs() < 0.2,
            "{amplitude} {mean}"
        );
    }
    let text = printed(at, &["sound", "a", "--signal", "force"]);
    assert!(
        text.contains("24 bit") && text.contains(" N about the mean"),
        "{text}"
    );
    let bytes = std::fs::read(at.join("a/force.wav")).unwrap();
    assert!(bytes.starts_with(b"RIFF") && bytes.len() >= 3 * 1601);
    let again = refused(at, &["sound", "a", "--signal", "force"], 2);
    assert!(again.contains("--overwrite"), "{again}");
    let unknown = refused(at, &["sound", "a", "--signal", "noise"], 2);
    assert!(unknown.contains("force, deflection"), "{unknown}");
    let scale = refused(at, &["sound", "a", "--full-scale=-1", "--out", "x.wav"], 2);
    assert!(scale.contains("positive"), "{scale}");
    let occupied = refused(at, &["runup", "m.toml", "--out", "a"], 2);
    assert!(occupied.contains("--overwrite"), "{occupied}");
}

/// What is no run-up is refused with a remedy, and nothing is written.
#[test]
fn what_is_no_run_up_is_refused() {
    for (own, parts) in [
        ("", ["no table [runup]", "speed = {"]),
        (
            "[runup]\nspeed = { from = 0, to = 20, in = 1 }",
            ["runup.speed.from", "greater than 0"],
        ),
        (
            "[runup]\nspeed = { from = 20, to = 20, in = 1 }",
            ["both speeds", "atlas trace"],
        ),
        (
            "[runup]\nspeed = { from = 10, to = 20, in = 5000 }",
            ["too long", "sample_rate"],
        ),
        (
            "[runup]\nspeed = { from = 10, in = 1 }",
            ["runup.speed.to", "missing"],
        ),
    ] {
        let folder = folder(own);
        let text = refused(folder.path(), &["runup", "m.toml", "--out", "a"], 2);
        for part in parts {
            assert!(text.contains(part), "{own}: {text}");
        }
        assert!(!folder.path().join("a").exists(), "{own}");
    }
    let folder = tempfile::tempdir().unwrap();
    let text = refused(folder.path(), &["sound", "."], 2);
    assert!(text.contains("atlas runup"), "{text}");
}
