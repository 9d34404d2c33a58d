//! Single operating points, tied axes, and torques: which points exist, in which order, and do they equal the same
//! points of a product?

#![allow(clippy::unwrap_used)]

use crate::{place, results};
use gearatlas::manifest::{self, Direction, Job, ManifestErrors};
use gearatlas::store::{ResultTable, TableKind};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use results::assert_same;
use std::path::Path;

const QUICKSTART: &str = include_str!("../../manifests/quickstart.toml");

/// A manifest with another grid.
fn with_grid(text: &str, grid: &str) -> String {
    let (head, rest) = text.split_once("[grid]").unwrap();
    let (_, tail) = rest.split_once("[run]").unwrap();
    format!("{head}[grid]\n{grid}\n[run]{tail}")
}

fn parsed(grid: &str, folder: &Path) -> Result<Job, ManifestErrors> {
    manifest::parse(&with_grid(QUICKSTART, grid), "m.toml", folder)
}

fn job(grid: &str) -> Job {
    parsed(grid, Path::new("")).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Load, speed and half gap of every point.
fn places(job: &Job) -> Vec<[f64; 3]> {
    let of = |point: manifest::PointSpec| [point.load, point.speed, point.mesh.half_gap];
    job.points.iter().map(of).collect()
}

const RPM: f64 = std::f64::consts::PI / 30.0;

#[test]
fn a_list_in_the_manifest_and_one_in_a_file_are_the_same_points() {
    let folder = tempfile::tempdir().unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("p.csv"), text).unwrap();
    write("speed [rpm],torque [N m],mesh.half_gap [um]\n6000,5,12\n7000,-10,15\n6000,0,12\n");
    let file = parsed("points = \"p.csv\"", folder.path()).unwrap();
    let rows = "points = [
        { torque = \"5 N m\", speed = \"6000 rpm\", \"mesh.half_gap\" = \"12 um\" },
        { torque = -10, speed = \"7000 rpm\", \"mesh.half_gap\" = \"15 um\" },
        { torque = 0, speed = \"6000 rpm\", \"mesh.half_gap\" = \"12 um\" },
    ]";
    let written = job(rows);
    let wanted = [
        [0.1, 6000.0 * RPM, 12e-6],
        [-0.2, 7000.0 * RPM, 15e-6],
        [0.0, 6000.0 * RPM, 12e-6],
    ];
    for job in [&file, &written] {
        assert_eq!(places(job), wanted);
        let names: Vec<&str> = job.axes.iter().map(|axis| axis.name()).collect();
        assert_eq!(names, ["mesh.half_gap", "torque", "speed"]);
        assert_eq!(job.dimensions.len(), 1);
    }
    assert_eq!(file.hash, written.hash);
    // The hash includes the numbers of the file, not their format.
    write(
        "# remark\nspeed [rpm];torque [N*mm];mesh.half_gap\n6e3;5000;12e-6\n7000;-10000;1.5e-5\n6000;0;1.2e-5\n",
    );
    let again = parsed("points = \"p.csv\"", folder.path()).unwrap();
    assert_eq!(again.hash, file.hash);
    write("speed [rpm],torque [N m],mesh.half_gap [um]\n6000,5,12\n7000,-10,15\n6000,1,12\n");
    let other = parsed("points = \"p.csv\"", folder.path()).unwrap();
    assert_ne!(other.hash, file.hash);
}

#[test]
fn tied_axes_advance_in_step_and_others_are_combined_with_them() {
    let job = job("tied = [[\"load\", \"speed\"]]\n\
        load = { values = [0.1, 0.3, 0.1] }\n\
        speed = { from = 600, to = 1000, count = 3 }\n\
        \"mesh.half_gap\" = { from = \"5 um\", to = \"20 um\", count = 3, spacing = \"log\" }");
    let mut wanted = Vec::new();
    // The half gaps have equal ratios, and both ends are exact.
    for half_gap in [5e-6, 10e-6, 20e-6] {
        for (load, speed) in [(0.1, 600.0), (0.3, 800.0), (0.1, 1000.0)] {
            wanted.push([load, speed, half_gap]);
        }
    }
    let found = places(&job);
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(wanted) {
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 1e-15, "{found} {wanted}");
        }
    }
    assert_eq!(found[0][2], 5e-6);
    assert_eq!(found[8][2], 20e-6);
    // Tied axes make another job, although the values of the axes are the same.
    let square =
        "load = { values = [0.1, 0.3, 0.2] }\nspeed = { from = 600, to = 1000, count = 3 }";
    let tied = format!("tied = [[\"load\", \"speed\"]]\n{square}");
    assert_ne!(self::job(square).hash, self::job(&tied).hash);
}

/// The state is carried in the order of the swept axis; tied axes change with it, also between the points.
#[test]
fn a_chain_goes_by_the_swept_axis() {
    let job = job("points = [
        { load = 0.3, speed = 800, \"mesh.half_gap\" = 3e-5 },
        { load = 0.1, speed = 600, \"mesh.half_gap\" = 1e-5 },
        { load = 0.2, speed = 900, \"mesh.half_gap\" = 2e-5 },
    ]
    order = \"both\"
    along = \"speed\"
    \"excitation.transmission_error.0.amplitude\" = { values = [1e-6, 2e-6] }");
    let up = [[0.1, 600.0, 1e-5], [0.3, 800.0, 3e-5], [0.2, 900.0, 2e-5]];
    let down: Vec<[f64; 3]> = up.iter().rev().copied().collect();
    let one = [&up[..], &down].concat();
    assert_eq!(places(&job), [&one[..], &one].concat());
    assert_eq!(job.chain_length(), 3);
    let first = job.points.at(0);
    assert_eq!(first.direction, Some(Direction::Up));
    let between = job.point_between(&first, 850.0).unwrap();
    let [load, gap] = [between.load, between.mesh.half_gap];
    assert_eq!(between.speed, 850.0);
    assert!(
        (load - 0.25).abs() < 1e-15 && (gap - 2.5e-5).abs() < 1e-19,
        "{load} {gap}"
    );
}

#[test]
fn torques_are_loads_times_the_rated_torque() {
    let job = job(
        "torque = { from = \"-10 N m\", to = \"25 N m\", count = 8 }\n\
                   speed = \"6000 rpm\"\n\
                   \"gear.rated_torque\" = { values = [\"50 N m\", \"100 N m\"] }",
    );
    for (i, point) in job.points.iter().enumerate() {
        let rated = if i < 8 { 50.0 } else { 100.0 };
        let torque = -10.0 + 5.0 * (i % 8) as f64;
        assert!((point.load - torque / rated).abs() < 1e-16);
        let parameter = job.between.parameter(&point, "torque").unwrap();
        let known = job.between.value(&point, &parameter).unwrap();
        assert!((known - torque).abs() < 1e-14);
        // A torque keeps its value if the rated torque changes, and a load changes as requested.
        let rating = job.between.parameter(&point, "gear.rated_torque").unwrap();
        let changed = job.between.changed(&point, &[(&rating, 200.0)]).unwrap();
        assert!((changed.load - torque / 200.0).abs() < 1e-16);
        let twice = [(&rating, 200.0), (&parameter, 40.0)];
        assert_eq!(job.between.changed(&point, &twice).unwrap().load, 0.2);
    }
    assert_eq!(job.between.continuous_keys()[0], "torque");
}

/// Every point of a list equals the same point of a product, bit for bit, for any threads and shards.
#[test]
fn listed_points_are_computed_as_those_of_a_product() {
    let place = Place::new(&OSCILLATOR.replace("cycles = 300", "cycles = 320"));
    let text = std::fs::read_to_string(place.path("m.toml")).unwrap();
    let speeds = [600.0, 1050.0, 1500.0];
    let mut sheet = "load,speed\n".to_owned();
    for load in [0.05, 0.3] {
        for speed in speeds {
            sheet += &format!("{load},{speed}\n");
        }
    }
    std::fs::write(place.path("p.csv"), sheet).unwrap();
    let whole = place.whole("product", &["-j", "2"]);
    std::fs::write(place.path("m.toml"), with_grid(&text, "points = \"p.csv\"")).unwrap();
    let listed = place.whole("listed", &["-j", "2"]);
    let tables = ["points.parquet", "poincare.parquet", "spectra.parquet"];
    assert_same(&tables, &whole, &listed);
    for index in 1..=3 {
        place.whole("parts", &["--shard", &format!("{index}/3")]);
    }
    assert_same(&tables, &whole, &place.path("parts"));
    let points = ResultTable::read(&listed, TableKind::Points).unwrap();
    assert_eq!(points.rows(), 6);

    let check = place.atlas(&["check", "m.toml"]);
    assert!(
        stdout(&check).contains("6 = 6 load with speed"),
        "{}",
        stdout(&check)
    );
    let plan = place.atlas(&["plan", "m.toml", "-j", "1"]);
    assert_eq!(status(&plan), 0, "{}", stderr(&plan));
    let show = place.atlas(&["show", "listed"]);
    assert_eq!(status(&show), 0, "{}", stderr(&show));
    assert!(stdout(&show).contains("speed"), "{}", stdout(&show));
    let plot = place.atlas(&["plot", "listed", "--out", "pictures"]);
    assert_eq!(status(&plot), 0, "{}", stderr(&plot));
}

/// A point of a list needs only as many axes as distinguish it from the others.
#[test]
fn tied_axes_need_not_all_be_named() {
    let rows = "points = [
        { load = 0.1, speed = 600, \"mesh.half_gap\" = 1e-5 },
        { load = -0.2, speed = 700, \"mesh.half_gap\" = 2e-5 },
        { load = -0.2, speed = 800, \"mesh.half_gap\" = 3e-5 },
    ]";
    let place = Place::new(&with_grid(OSCILLATOR, rows));
    let trace = |point: &str| {
        place.atlas(&[
            "trace",
            "m.toml",
            "--point",
            point,
            "--cycles",
            "2",
            "--skip",
            "0",
            "--out",
            "t",
            "--json",
            "--overwrite",
        ])
    };
    let told = |point: &str| {
        let output = trace(point);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        told["point"].clone()
    };
    let third = serde_json::json!({ "mesh.half_gap": 3e-5, "load": -0.2, "speed": 800.0 });
    assert_eq!(told("speed=800"), third);
    assert_eq!(told("mesh.half_gap=30 um"), third);
    // Load and speed may have values off the list. These do not determine the half gap, which must be given.
    let free = serde_json::json!({ "mesh.half_gap": 1e-5, "load": 0.0, "speed": 650.0 });
    assert_eq!(told("load=0,speed=650,mesh.half_gap=1e-5"), free);
    let output = trace("load=-0.2");
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("needs a value for"),
        "{}",
        stderr(&output)
    );
}

/// Values of model keys from different rows of a list are no point.
#[test]
fn values_of_different_rows_are_no_point() {
    let rows = "points = [
        { load = 0.1, speed = 600, \"mesh.half_gap\" = 1e-5, \"mesh.contact_damping\" = 0.05 },
        { load = 0.2, speed = 700, \"mesh.half_gap\" = 2e-5, \"mesh.contact_damping\" = 0.06 },
    ]";
    let place = Place::new(&with_grid(OSCILLATOR, rows));
    let point = "load=0.1,speed=600,mesh.half_gap=1e-5,mesh.contact_damping=0.06";
    let output = place.atlas(&["trace", "m.toml", "--point", point, "--out", "t"]);
    assert_eq!(status(&output), 2);
    let errors = stderr(&output);
    assert!(
        errors.contains("the grid has no point at these values"),
        "{errors}"
    );
}
