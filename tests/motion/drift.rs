//! Misalignment that drifts within a run: consecutive slices compared with the same integration by hand, and columns
//! about each slice's mesh compared with its table.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, advance_with, volterra};
use gearatlas::analysis::Nvh;
use gearatlas::gear::{Contact, FaceLaw, Flanks, MeshTable, MeshTableInputs};
use gearatlas::manifest::{self, PointSpec};
use gearatlas::model::{InitialState, TrajectoryState};
use gearatlas::store::{ResultTable, TableKind};
use std::path::Path;
use std::process::Command;

const MANIFEST: &str = include_str!("../../manifests/misalignment-drift.toml");

/// Cycles on each slice: audited, measured.
const CYCLES: [u64; 2] = [20, 230];

fn number(table: &ResultTable, name: &str) -> Vec<f64> {
    let column = table.f64(name).unwrap();
    column.into_iter().map(Option::unwrap).collect()
}

/// Motion and mesh of five slices with increasing misalignment agree with an integration by hand.
#[test]
fn a_drift_is_one_motion_over_its_slices() {
    let folder = tempfile::tempdir().unwrap();
    let text = MANIFEST.replace("order = \"both\"", "order = \"sweep-up\"");
    std::fs::write(folder.path().join("m.toml"), &text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(["run", "m.toml", "--out", "r", "--quiet"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 3)), "{said}");
    let table = ResultTable::read(&folder.path().join("r"), TableKind::Points).unwrap();
    let [rms, loss] = ["deflection_rms", "power_loss"].map(|name| number(&table, name));
    let slices = number(&table, "mesh.misalignment");
    assert_eq!(slices, [0.0, 5e-5, 1e-4, 1.5e-4, 2e-4]);
    let measured = table.u64("measured_cycles").unwrap();
    assert_eq!(measured, [Some(CYCLES[1]); 5]);

    // Integrate by hand: the state and the mesh cycles continue from slice to slice.
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    let parts = common::parts();
    let mut state: Option<TrajectoryState> = None;
    for slice in 0..slices.len() {
        let point = job.points.at(slice);
        let model = parts.model(&point).unwrap();
        let start = match &state {
            Some(end) => TrajectoryState::new(&model, end.state.clone(), end.cycle),
            None => model.start(&InitialState::Static),
        };
        let kernel = volterra(&model);
        let audited = advance(&kernel, &start, CYCLES[0]);
        let mut nvh = Nvh::new(&model, 0);
        state = Some(advance_with(&kernel, &audited, CYCLES[1], &mut nvh).0);
        let found = nvh.outcome().unwrap();
        println!(
            "{slice}: RMS {} {}",
            found.values.deflection_rms, rms[slice]
        );
        assert!(
            (found.values.deflection_rms / rms[slice] - 1.0).abs() < 1e-6,
            "slice {slice}"
        );
        assert!(
            (found.values.power_loss.unwrap() / loss[slice] - 1.0).abs() < 1e-6,
            "slice {slice}"
        );
    }
    assert_eq!(state.unwrap().cycle, 5 * CYCLES.iter().sum::<u64>());
    meshes(&table, |slice| job.points.at(slice));
}

/// Compares the columns about the mesh with a table for the angle in their row.
fn meshes(table: &ResultTable, point: impl Fn(usize) -> PointSpec) {
    let column = |name: &str| number(table, name);
    let [angle, centre, stiffness] =
        ["misalignment_loaded", "load_centre", "mesh_stiffness"].map(column);
    let [ratio, error] = ["contact_ratio_loaded", "transmission_error_pp"].map(column);
    for slice in 0..angle.len() {
        let gears = point(slice).model.source.gears().unwrap();
        let flanks = Flanks::new(&gears).unwrap();
        let mut inputs = MeshTableInputs::of_gears(&gears);
        inputs.misalignment = vec![angle[slice]];
        inputs.torque = vec![0.3 * gears.rated_torque];
        inputs.contact = Contact::Secant;
        // This is the face law of the manifest.
        inputs.face = FaceLaw::Independent;
        let cycle = MeshTable::build(&flanks, &inputs, &|_, _| ())
            .unwrap()
            .cycle(0, 0);
        let close = |a: f64, b: f64, scale: f64| assert!((a - b).abs() < 1e-5 * scale, "{a} {b}");
        close(centre[slice], cycle.mean_centre(), gears.face_width);
        close(stiffness[slice], cycle.mean_stiffness(), stiffness[slice]);
        close(error[slice], cycle.peak_to_peak(), 1e-6);
        // Flanks without relief touch over the path of contact of the drawing, and with their tips slightly further.
        let beyond = ratio[slice] - flanks.contact_ratio();
        assert!((0.0..0.1).contains(&beyond), "{beyond}");
    }
    // The shafts compensate a part of the misalignment, and the mesh becomes softer towards one end.
    assert!(angle[4] < 2e-4 && angle[4] > 1e-4, "{angle:?}");
    assert!(
        stiffness
            .windows(2)
            .all(|pair| pair[1] <= pair[0] * (1.0 + 1e-9)),
        "{stiffness:?}"
    );
    assert!(stiffness[4] < stiffness[0] && centre[4].abs() > centre[0].abs() + 1e-4);
}

/// Relief at the tips prevents pairs from carrying load at the ends of the path.
#[test]
fn relief_shortens_the_contact_under_a_light_load() {
    let relieved =
        "bore = [\"48 mm\", \"76 mm\"]\ntip_relief = { amount = \"20 um\", length = \"4 mm\" }\n#";
    let text = MANIFEST.replace("bore = [\"48 mm\", \"76 mm\"]", relieved);
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    let parts = common::parts();
    let mut point = job.points.at(0);
    let mut at = |load: f64| {
        point.load = load;
        parts
            .model_and_mesh(&point)
            .unwrap()
            .1
            .unwrap()
            .contact_ratio
    };
    let [light, heavy] = [0.05, 5.0].map(&mut at);
    println!("pairs that bear: {light} under a light load, {heavy} under a heavy one");
    assert!(
        (1.0..1.55).contains(&light) && heavy > light + 0.05,
        "{light} {heavy}"
    );
}
