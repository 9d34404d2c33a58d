//! Derivatives by parameters: compared with differences of trajectories in thirty digits, for every kind of key, and
//! the order of those from differences of tables.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use gearatlas::analysis::continuation::branch::{StepSettings, follow};
use gearatlas::analysis::continuation::drive::{DriveMap, ParametricDrive};
use gearatlas::analysis::continuation::end::End;
use gearatlas::analysis::continuation::map::CycleMap;
use gearatlas::analysis::continuation::orbit::{OrbitCondition, find};
use gearatlas::analysis::continuation::path::Span;
use gearatlas::analysis::sensitivity::tangent::ParameterTangent;
use gearatlas::manifest::{self, Job};
use gearatlas::model::{InitialState, Model, ModelDerivative, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel, Volterra};
use gearatlas::reference::Extended;
use gearatlas::store::TableStore;
use gearatlas::sweep::{PointFamily, Prepared};
use std::path::Path;

fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests");
    std::fs::read_to_string(folder.join(name)).unwrap()
}

fn job(text: &str) -> Job {
    manifest::parse(text, "test.toml", Path::new("")).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The rattling tier of six degrees of freedom with all kinds of parts.
fn rattling() -> String {
    text("tiers/translational.toml")
        .replace("\"piecewise\"", "\"continuous\"")
        .replace("segments = 60", "")
        .replace("contact_ratio = 1.6 ", "contact_ratio = 1.62 ")
        .replace("phase = 0.0 }]", "phase = 0.3 }, { harmonic = 2, amplitude = \"1 um\" }]")
        .replace("torque_ripple = []", "torque_ripple = [{ shaft = \"pinion\", order = 20, amplitude = \"3 N*m\", phase = 0.4 }]")
}

/// The rattling tier with teeth from the drawing, relieved tips and misaligned axes.
fn toothed() -> String {
    rattling()
        .replace(
            "stiffness = \"continuous\"",
            "stiffness = \"table\"\nmisalignment = \"0.1 mrad\"\nsegments = 24",
        )
        .replace("mean_stiffness = \"4e8 N/m\"", "")
        .replace("contact_ratio = 1.62 ", "#")
        .replace("single_pair_drop", "#")
}

/// The state of a rattling trajectory after some cycles.
fn start(model: &Model, cycles: u64) -> TrajectoryState {
    let kernel = Volterra::new(model, f64::EPSILON, 1000);
    let mut state = model.start(&InitialState::Static);
    kernel
        .advance(
            cycles,
            &mut state,
            &mut kernel.workspace(),
            &mut (),
            &mut Counters::default(),
        )
        .unwrap();
    state
}

fn tangent(
    model: &Model,
    by: &ModelDerivative,
    start: &TrajectoryState,
    cycles: u64,
) -> (Vec<f64>, u64) {
    let kernel = Volterra::new(model, f64::EPSILON, 1000);
    let mut tangent =
        ParameterTangent::new(model, by, &start.state, vec![0.0; start.state.len()], ());
    let mut counters = Counters::default();
    kernel
        .advance(
            cycles,
            &mut start.clone(),
            &mut kernel.workspace(),
            &mut tangent,
            &mut counters,
        )
        .unwrap();
    (tangent.state().to_vec(), counters.events)
}

/// Largest error of first and of second components, each relative to its largest entry.
fn error(found: &[f64], exact: &[f64]) -> f64 {
    let n = found.len() / 2;
    let half = |range: std::ops::Range<usize>| {
        let size = exact[range.clone()]
            .iter()
            .fold(0.0_f64, |m, x| m.max(x.abs()));
        range
            .map(|i| (found[i] - exact[i]).abs() / size)
            .fold(0.0, f64::max)
    };
    half(0..n).max(half(n..2 * n))
}

/// Differences of the sixth order of the 30-digit integrator over models of neighbouring values.
fn differences(
    family: &PointFamily<'_>,
    at: [f64; 2],
    step: f64,
    start: &TrajectoryState,
    cycles: u64,
) -> (Vec<f64>, bool) {
    let base = family.model(at).unwrap();
    let mut sum = vec![0.0; start.state.len()];
    let mut counts = Vec::new();
    for (steps, weight) in [(1.0, 45.0), (2.0, -9.0), (3.0, 1.0)] {
        for side in [1.0, -1.0] {
            let model = family.model([at[0] + side * steps * step, at[1]]).unwrap();
            let change = model.basis.change_to(&base.basis).unwrap();
            let own = TrajectoryState::new(&model, change.undo(&start.state), start.cycle);
            let passage = Extended::new(&model).advance(&own, cycles).unwrap();
            counts.push(passage.crossings.len());
            let end: Vec<f64> = passage.state.iter().map(|x| x.value()).collect();
            for (sum, x) in sum.iter_mut().zip(change.apply(&end)) {
                *sum += side * weight / (60.0 * step) * x;
            }
        }
    }
    (sum, counts.iter().all(|count| *count == counts[0]))
}

fn every_key(text: &str, keys: &[&str], tolerance: f64) {
    let job = job(text);
    let folder = tempfile::tempdir().unwrap();
    let parts = Prepared::new(TableStore::open(folder.path()));
    let point = job.points.at(0);
    let cycles = 2;
    for key in keys {
        let parameter = job.between.parameter(&point, key).unwrap();
        let family = PointFamily::new(point.clone(), vec![parameter], &job.between, &parts);
        let at = family.values();
        let model = family.model(at).unwrap();
        let start = start(&model, 137);
        let by = family.derivative(at, 0, &model.basis).unwrap();
        let (found, events) = tangent(&model, &by, &start, cycles);
        let size = if at[0] == 0.0 { 1e-2 } else { at[0].abs() };
        let (exact, same) = differences(&family, at, 1e-3 * size, &start, cycles);
        let (exact, same) = if same {
            (exact, same)
        } else {
            differences(&family, at, 1e-4 * size, &start, cycles)
        };
        assert!(same, "{key}: events differ within a step");
        let worst = error(&found, &exact);
        println!("{key}: {worst:.1e}, {events} events");
        assert!(events > 0 && worst < tolerance, "{key}: {worst:e}");
    }
}

#[test]
fn derivatives_by_every_kind_of_key_are_those_of_thirty_digits() {
    every_key(
        &rattling(),
        &[
            "load",
            "speed",
            "mesh.half_gap",
            "mesh.mean_stiffness",
            "mesh.single_pair_drop",
            "mesh.contact_ratio",
            "mesh.contact_damping",
            "mesh.friction",
            "excitation.transmission_error.0.amplitude",
            "excitation.transmission_error.0.phase",
            "excitation.torque_ripple.0.amplitude",
            "excitation.torque_ripple.0.phase",
            "model.damping",
            "gear.pressure_angle",
            "shafts.pinion.diameter",
            "shafts.pinion.end_inertia",
            "shafts.bearings.x",
            "shafts.bearings.y",
            "gear.rated_torque",
        ],
        1e-8,
    );
}

/// Gyroscopic terms and dampers couple modes, so that states depend on the keys by their coordinates, too.
#[test]
fn derivatives_where_modes_are_coupled_are_those_of_thirty_digits() {
    let text = rattling()
        .replace("\"translational\"", "\"tilting\"\ngyroscopic = true")
        .replace(
            "tilt = ",
            "damping_x = \"400 N*s/m\"\ndamping_y = \"900 N*s/m\"\ntilt = ",
        );
    every_key(
        &text,
        &[
            "load",
            "speed",
            "shafts.bearings.x",
            "shafts.bearings.damping_x",
            "shafts.pinion.end_inertia",
            "mesh.contact_damping",
        ],
        1e-8,
    );
}

/// Bearings with equal stiffness in both directions, the usual input, give pairs of modes with equal frequencies. Their
/// directions jump with a key of the structure.
#[test]
fn derivatives_at_equal_frequencies_are_those_of_thirty_digits() {
    let equal = rattling().replace("y = \"1e8 N/m\"", "y = \"1.25e8 N/m\"");
    let keys = [
        "shafts.bearings.x",
        "shafts.pinion.end_inertia",
        "shafts.density",
    ];
    every_key(&equal, &keys, 1e-8);
    let turning = equal
        .replace("\"translational\"", "\"tilting\"\ngyroscopic = true")
        .replace("tilt = ", "damping_x = \"400 N*s/m\"\ntilt = ");
    every_key(
        &turning,
        &[
            "shafts.bearings.x",
            "shafts.bearings.tilt",
            "shafts.density",
        ],
        1e-8,
    );
}

/// Frequencies cross where x is equal to y, and where a mode of the pinion has the frequency of one of the wheel.
#[test]
fn a_branch_crosses_equal_frequencies() {
    let job = job(&text("tiers/translational.toml"));
    let parts = Prepared::new(TableStore::in_memory());
    let mut point = job.points.at(0);
    (point.load, point.speed) = (1.0, 500.0);
    let parameter = job.between.parameter(&point, "shafts.bearings.x").unwrap();
    let family = PointFamily::new(point, vec![parameter], &job.between, &parts);
    let at = [3e7, 0.0];
    let mut map = DriveMap::new(&family, at).unwrap();
    let start = map.model(at).unwrap().start(&InitialState::Static);
    let guess = map.coordinates(&start.state);
    let orbit = find(&mut map, &guess, at, 1, &OrbitCondition::Parameters).unwrap();
    let span = Span {
        axis: 0,
        from: at[0],
        to: 3e8,
    };
    let branch = follow(&mut map, &span, orbit, &StepSettings::default()).unwrap();
    println!("{} orbits, {:?}", branch.orbits.len(), branch.ends);
    assert_eq!(branch.ends, [End::Interval, End::Interval]);
    assert!(branch.bifurcations.is_empty());
}

/// With fewer modes than freedoms, the modes of a model do not span those of the first model of a map.
#[test]
fn the_map_of_a_truncated_structure_has_the_derivative_of_its_images() {
    let text = text("tiers/flexible.toml").replace("modes = 40 ", "modes = 12 ");
    let job = job(&text);
    let parts = Prepared::new(TableStore::in_memory());
    let point = job.points.at(0);
    let parameter = job.between.parameter(&point, "shafts.bearings.x").unwrap();
    let family = PointFamily::new(point, vec![parameter], &job.between, &parts);
    let at = |value: f64| [value, 0.0];
    let mut map = DriveMap::new(&family, at(0.8e8)).unwrap();
    let here = 1.3e8;
    let mut state = map.model(at(here)).unwrap().start(&InitialState::Static);
    map.advance(at(here), 30, &mut state, &mut ()).unwrap();
    let u = map.coordinates(&state.state);
    let exact = map.by_parameter(&u, at(here), 1, 0).unwrap();
    let h = 1e-5 * here;
    let [more, less] = [h, -h].map(|h| map.image(&u, at(here + h), 1).unwrap().end);
    let quotient: Vec<f64> = (more.iter().zip(&less))
        .map(|(a, b)| (a - b) / (2.0 * h))
        .collect();
    let worst = error(&quotient, &exact);
    println!("{worst:.1e}");
    assert!(worst < 1e-6, "{worst:e}");
}

#[test]
fn derivatives_through_tables_of_teeth_are_those_of_thirty_digits() {
    let keys = ["mesh.misalignment", "gear.face_width", "mesh.friction"];
    every_key(&toothed(), &keys, 1e-8);
    // A table follows its law to 1e-6, and under another load its pieces are different.
    every_key(&toothed(), &["load"], 1e-5);
}

/// Central differences of a table, segment by segment, propagated exactly through the cycle: the error decreases with
/// the square of the step.
#[test]
fn differences_of_tables_are_of_the_second_order() {
    let job = job(&toothed());
    let folder = tempfile::tempdir().unwrap();
    let parts = Prepared::new(TableStore::open(folder.path()));
    let point = job.points.at(0);
    let parameter = job.between.parameter(&point, "mesh.misalignment").unwrap();
    let family = PointFamily::new(point.clone(), vec![parameter], &job.between, &parts);
    let at = family.values();
    let model = family.model(at).unwrap();
    let start = start(&model, 137);
    let exact = tangent(
        &model,
        &family.derivative(at, 0, &model.basis).unwrap(),
        &start,
        1,
    )
    .0;
    let errors: Vec<f64> = [4e-2, 2e-2, 1e-2]
        .map(|part| {
            let step = part * at[0];
            let ends = [-1.0, 1.0].map(|side| family.model([at[0] + side * step, 0.0]).unwrap());
            let by = [(-0.5 / step, &ends[0]), (0.5 / step, &ends[1])];
            let by = Model::combined(&by, &model.basis).unwrap();
            error(&tangent(&model, &by, &start, 1).0, &exact)
        })
        .to_vec();
    println!("{errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.8..2.2).contains(&order), "{errors:?}");
    }
}

/// 0.6 of a mesh cycle is a boundary of its sixty segments, 0.605 lies within one. At a boundary, the models on both
/// sides have equally many levels, but the levels are elsewhere.
#[test]
fn no_derivative_exists_where_the_segments_change() {
    let job = job(&text("tiers/translational.toml"));
    let parts = Prepared::new(TableStore::in_memory());
    let point = job.points.at(0);
    let parameter = (job.between.parameter(&point, "mesh.contact_ratio")).unwrap();
    let family = PointFamily::new(point, vec![parameter], &job.between, &parts);
    let basis = family.model([1.6, 0.0]).unwrap().basis;
    assert!(family.derivative([1.605, 0.0], 0, &basis).is_ok());
    let refused = family.derivative([1.6, 0.0], 0, &basis).unwrap_err();
    assert!(refused.contains("segments of the mesh cycle"), "{refused}");
}
