//! Axes that are distributions: which values do they have, in which rows, and does each row equal the same point of a
//! product, for any threads and shards?

#![allow(clippy::unwrap_used)]

use crate::{place, results};
use gearatlas::manifest::{self, Job, ManifestErrors};
use gearatlas::store::{ResultTable, TableKind};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use results::assert_same;
use std::path::Path;

const QUICKSTART: &str = include_str!("../../manifests/quickstart.toml");

const TWO: &str = "\"mesh.half_gap\" = { normal = [\"80 um\", \"10 um\"] }\n\
    \"excitation.transmission_error.0.amplitude\" = { lognormal = [\"3 um\", 0.3] }";

/// A manifest with another grid.
fn with_grid(text: &str, grid: &str) -> String {
    let (head, rest) = text.split_once("[grid]").unwrap();
    let (_, tail) = rest.split_once("[run]").unwrap();
    format!("{head}[grid]\n{grid}\n[run]{tail}")
}

fn parsed(grid: &str, folder: &Path) -> Result<Job, ManifestErrors> {
    let grid = if grid.contains("load") {
        grid.to_owned()
    } else {
        format!("load = 0.1\n{grid}")
    };
    manifest::parse(&with_grid(QUICKSTART, &grid), "m.toml", folder)
}

fn job(grid: &str) -> Job {
    parsed(grid, Path::new("")).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The values of an axis.
fn values(job: &Job, name: &str) -> Vec<f64> {
    let axis = job.axes.iter().find(|axis| axis.name() == name).unwrap();
    axis.values.iter().collect()
}

fn moments(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / n;
    [mean, square.sqrt()]
}

/// The error of the mean of 4096 independent samples would be 1.6 % of a standard deviation.
#[test]
fn samples_have_the_moments_of_their_distributions() {
    let job = job(&format!(
        "samples = 4096\nspeed = {{ uniform = [600, 900] }}\n{TWO}"
    ));
    assert_eq!(job.points.len(), 4096);
    let gaps = values(&job, "mesh.half_gap");
    let [mean, deviation] = moments(&gaps);
    assert!((mean - 80e-6).abs() < 1e-3 * 10e-6, "{mean}");
    assert!((deviation - 10e-6).abs() < 5e-3 * 10e-6, "{deviation}");
    let logarithms: Vec<f64> = (values(&job, "excitation.transmission_error.0.amplitude").iter())
        .map(|value| (value / 3e-6).ln())
        .collect();
    let [mean, deviation] = moments(&logarithms);
    assert!(mean.abs() < 1e-3 * 0.3 && (deviation - 0.3).abs() < 5e-3 * 0.3);
    let [mean, deviation] = moments(&values(&job, "speed"));
    assert!((mean - 750.0).abs() < 0.1, "{mean}");
    assert!(
        (deviation - 300.0 / 12f64.sqrt()).abs() < 0.1,
        "{deviation}"
    );
    // Axes are independent.
    let products: Vec<f64> = (gaps.iter().zip(&logarithms))
        .map(|(gap, log)| (gap - 80e-6) / 10e-6 * log / 0.3)
        .collect();
    assert!(moments(&products)[0].abs() < 0.01);
    // Each point has the values of its row on both axes.
    for id in [0, 1, 4095] {
        let point = job.points.at(id);
        assert_eq!(point.mesh.half_gap, gaps[id]);
        assert_eq!(point.speed, values(&job, "speed")[id]);
    }
}

#[test]
fn seed_and_number_alone_decide_the_samples() {
    let grid = |samples: u32| format!("samples = {samples}\nspeed = 700\n{TWO}");
    let (few, more) = (job(&grid(10)), job(&grid(100)));
    let of = |job: &Job| values(job, "mesh.half_gap");
    assert_eq!(of(&few)[..], of(&more)[..10]);
    // The order of the text has no effect.
    let lines: Vec<&str> = TWO.lines().rev().collect();
    let turned = job(&format!("{}\nspeed = 700\nsamples = 10", lines.join("\n")));
    assert_eq!(turned.hash, few.hash);
    let text = with_grid(QUICKSTART, &format!("load = 0.1\n{}", grid(10)));
    let seeded = text.replacen("[job]", "[job]\nseed = 5", 1);
    let seeded = manifest::parse(&seeded, "m.toml", Path::new("")).unwrap();
    assert_ne!(of(&seeded), of(&few));
}

#[test]
fn given_values_come_from_a_list_or_a_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("g.csv"),
        "part,mesh.half_gap [um]\n1,70\n2,90\n3,75\n",
    )
    .unwrap();
    let grid = |from: &str| {
        format!(
            "samples = 300\nspeed = 700\n\"mesh.half_gap\" = {{ empirical = {from}, truncate = [\"72 um\", 1] }}"
        )
    };
    let file = parsed(&grid("\"g.csv\""), folder.path()).unwrap();
    let list = job(&grid("[\"90 um\", 7e-5, \"75 um\"]"));
    assert_eq!(file.hash, list.hash);
    let of = |value: f64| {
        values(&list, "mesh.half_gap")
            .iter()
            .filter(|own| **own == value)
            .count()
    };
    let [first, second] = [75e-6, 90e-6].map(of);
    assert!(
        first + second == 300 && first.abs_diff(second) <= 4,
        "{first} {second}"
    );
    // Equal values are one combination.
    assert_eq!(list.points.variants().len(), 2);
}

#[test]
fn a_normal_law_may_leave_the_range_of_a_key_only_where_it_is_truncated() {
    let grid = |more: &str| {
        format!(
            "samples = 64\nspeed = 700\n\"mesh.half_gap\" = {{ normal = [\"15 um\", \"8 um\"]{more} }}"
        )
    };
    let errors = parsed(&grid(""), Path::new("")).unwrap_err();
    assert_eq!(errors.count(), 1);
    assert!(errors.to_string().contains("truncate"), "{errors}");
    let job = job(&grid(", truncate = [\"1 um\", \"29 um\"]"));
    let all = values(&job, "mesh.half_gap");
    assert!(all.iter().all(|value| (1e-6..=29e-6).contains(value)));
}

/// Every row equals a point with the same values in a list, bit for bit, for any threads and shards.
#[test]
fn rows_are_computed_as_points_of_a_list() {
    let grid = "samples = 3\ndesign = \"saltelli\"\nload = { values = [0.05, 0.3] }\nspeed = { uniform = [600, 1500] }\n\
                \"mesh.half_gap\" = { normal = [\"15 um\", \"2 um\"] }";
    let place = Place::new(&with_grid(
        &OSCILLATOR.replace("cycles = 300", "cycles = 320"),
        grid,
    ));
    let tables = ["points.parquet", "poincare.parquet", "spectra.parquet"];
    let whole = place.whole("whole", &["-j", "2"]);
    for index in 1..=3 {
        place.whole("parts", &["--shard", &format!("{index}/3")]);
    }
    assert_same(&tables, &whole, &place.path("parts"));
    let points = ResultTable::read(&whole, TableKind::Points).unwrap();
    let samples: Vec<Option<u64>> = points.u64("sample").unwrap();
    // There are 3 samples with 4 rows each, and 2 loads per row.
    let wanted: Vec<Option<u64>> = (0..12).flat_map(|row| [Some(row), Some(row)]).collect();
    assert_eq!(samples, wanted);
    let told = points.metadata("samples").unwrap();
    let told: serde_json::Value = serde_json::from_str(told).unwrap();
    assert_eq!(told["axes"], serde_json::json!(["mesh.half_gap", "speed"]));
    assert_eq!(
        (&told["design"], &told["samples"], &told["rows"]),
        (&"saltelli".into(), &3.into(), &12.into())
    );

    let [gaps, speeds] = ["mesh.half_gap", "speed"].map(|name| points.f64(name).unwrap());
    let mut sheet = "mesh.half_gap,speed\n".to_owned();
    for row in 0..12 {
        sheet += &format!(
            "{:e},{:e}\n",
            gaps[2 * row].unwrap(),
            speeds[2 * row].unwrap()
        );
    }
    std::fs::write(place.path("p.csv"), sheet).unwrap();
    let text = std::fs::read_to_string(place.path("m.toml")).unwrap();
    let listed = with_grid(&text, "load = { values = [0.05, 0.3] }\npoints = \"p.csv\"");
    std::fs::write(place.path("m.toml"), listed).unwrap();
    let listed = place.whole("listed", &["-j", "1"]);
    let listed = ResultTable::read(&listed, TableKind::Points).unwrap();
    for name in ["events_per_cycle", "deflection_rms", "force_std"] {
        assert_eq!(
            points.f64(name).unwrap(),
            listed.f64(name).unwrap(),
            "{name}"
        );
    }
}

/// A state is carried along another axis; the number of the row is then that of the chain.
#[test]
fn chains_cross_the_samples() {
    let grid = "samples = 2\norder = \"both\"\nalong = \"speed\"\nload = 0.1\nspeed = { values = [600, 900, 1200] }\n\
                \"mesh.half_gap\" = { uniform = [\"10 um\", \"20 um\"] }";
    let place = Place::new(&with_grid(
        &OSCILLATOR.replace("cycles = 300", "cycles = 320"),
        grid,
    ));
    let folder = place.whole("swept", &["-j", "2"]);
    let points = ResultTable::read(&folder, TableKind::Points).unwrap();
    let (samples, gaps) = (
        points.u64("sample").unwrap(),
        points.f64("mesh.half_gap").unwrap(),
    );
    let expected: Vec<Option<u64>> = (0..12).map(|id| Some(id / 6)).collect();
    assert_eq!(samples, expected);
    assert!(gaps[..6].iter().all(|gap| *gap == gaps[0]) && gaps[6] != gaps[0]);
    let check = place.atlas(&["check", "m.toml"]);
    let said = stdout(&check);
    for part in [
        "2 Sobol' points of 1 distribution",
        "uniform (10 to 20)",
        "2 samples of mesh.half_gap x 1 load x 3 speed x 2 directions",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    for command in [
        &["show", "swept"][..],
        &["plan", "m.toml"],
        &["plot", "swept", "--out", "p"],
        &["report", "swept"],
    ] {
        let output = place.atlas(command);
        assert_eq!(status(&output), 0, "{command:?} {}", stderr(&output));
    }
}
