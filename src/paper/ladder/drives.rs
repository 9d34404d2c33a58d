//! The paper's cases with manifests: a misalignment that drifts (Table 5), contact with friction (3.1).

use super::rattle::{CELLS, LIMIT};
use gearatlas_core::analysis::{Nvh, PointConfig, investigate};
use gearatlas_core::model::{InitialState, Model, TrajectoryState};
use gearatlas_core::propagate::{Counters, Kernel, Stepping};
use gearatlas_jobs::manifest::{Job, ManifestText};
use gearatlas_jobs::store::TableStore;
use gearatlas_jobs::sweep::Prepared;
use gearatlas_jobs::sweep::build::point_config;
use gearatlas_paper::kernels::{Bases, Fused, Spectral};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Changes of the manifest for five slices of misalignment. Dense tables accept only one line of action, and the error
/// of loaded flanks only as harmonics.
const DRIFTING_MISALIGNMENT: [&str; 3] = [
    "mesh.shaft_tilt=",
    r#"mesh.coast_flank="same_line""#,
    "excitation.table_harmonics=6",
];

/// Change of the manifest that gives five nearly equal values of the misalignment.
const CONSTANT_MISALIGNMENT: &str = r#"grid."mesh.misalignment"={values=["0.1 mrad","0.1000001 mrad","0.1000002 mrad","0.1000003 mrad","0.1000004 mrad"]}"#;

/// Number of repetitions, whose median is the result.
const REPEATS: usize = 3;

/// A manifest of the repository with some keys changed.
fn job(text: &str, changes: &[&str]) -> Job {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    let changed = ManifestText {
        text,
        changes: &changes,
    };
    changed
        .job("manifest", Path::new(""))
        .expect("a manifest of the repository")
}

/// Speed of `spectral` over slices of drift, compared with as many nearly equal slices \[× real time\].
pub fn drift() -> Value {
    let drifting = || speed(&DRIFTING_MISALIGNMENT);
    let still = || speed(&[&DRIFTING_MISALIGNMENT[..], &[CONSTANT_MISALIGNMENT]].concat());
    json!({ "drifting": median(drifting), "still": median(still) })
}

fn median(measure: impl Fn() -> f64) -> f64 {
    let mut found: Vec<f64> = (0..REPEATS).map(|_| measure()).collect();
    found.sort_by(f64::total_cmp);
    found[REPEATS / 2]
}

/// Simulated time divided by computing time, with the bases built beforehand. The state is carried from one
/// misalignment to the next.
fn speed(changes: &[&str]) -> f64 {
    let job = job(
        include_str!("../../../manifests/misalignment-drift.toml"),
        changes,
    );
    let parts = Prepared::new(TableStore::in_memory());
    let points = job.points.iter().map(|point| {
        let model = parts.model(&point).expect("a model");
        (point, Bases::new(&model).expect("tables"))
    });
    let points: Vec<_> = points.collect();
    let (mut simulated, clock) = (0.0, Instant::now());
    let mut carried: Option<(_, TrajectoryState)> = None;
    for (point, bases) in points {
        let model = parts.model(&point).expect("a model");
        let kernel = Spectral::with_bases(&model, CELLS, LIMIT, bases).expect("tables");
        let mut trajectory = match carried.take() {
            Some((direction, end)) if direction == point.direction => {
                TrajectoryState::new(&model, end.state, end.cycle)
            }
            _ => model.start(&InitialState::Static),
        };
        let cycles = point.run.audit_cycles + point.run.cycles;
        let (mut nvh, mut counters) = (Nvh::new(&model, 0), Counters::default());
        let mut workspace = kernel.workspace();
        kernel
            .advance(
                cycles,
                &mut trajectory,
                &mut workspace,
                &mut nvh,
                &mut counters,
            )
            .expect("the drive does not diverge");
        simulated += cycles as f64 * model.period();
        carried = Some((point.direction, trajectory));
    }
    simulated / clock.elapsed().as_secs_f64()
}

/// Constant contact with friction: RMS of the deflection by fused cycles and by small steps of 100 ns \[m\].
pub fn friction() -> Value {
    let changes = [
        r#"mesh.coast_flank="same_line""#,
        "mesh.friction=0.1",
        "grid.load=1.0",
        r#"grid.speed="600 rad/s""#,
        "run.settle=false",
        "run.cycles=200",
    ];
    let job = job(include_str!("../../../manifests/flex80.toml"), &changes);
    let point = job.points.at(0);
    let model = Prepared::new(TableStore::in_memory())
        .model(&point)
        .expect("a model");
    let seed = point.random();
    let config = point_config(&point, seed);
    let fused = Fused::new(&model, CELLS, LIMIT).expect("tables");
    let steps = (model.period() / 1e-7).round() as u32;
    let stepping = Stepping::new(&model, steps, LIMIT);
    let start = model.start(&point.run.initial);
    fn rms<K: Kernel>(
        kernel: &K,
        model: &Model,
        start: &TrajectoryState,
        config: &PointConfig,
    ) -> f64 {
        let never = AtomicBool::new(false);
        let found = investigate(model, kernel, start.clone(), config, &never);
        let nvh = found.expect("nobody calls it off").nvh;
        nvh.expect("statistics of the deflection")
            .values
            .deflection_rms
    }
    let fused = rms(&fused, &model, &start, &config);
    let stepping = rms(&stepping, &model, &start, &config);
    json!({
        "rms": { "fused": fused, "stepping": stepping },
        "difference": (fused / stepping - 1.0).abs(),
    })
}
