//! Drives of every kind with changed keys: every accepted manifest is computed without a panic, in bounded time, and no
//! row with status `ok` is wrong.

use super::manifest::judged;
use super::row::{broken, differs, questions};
use super::scratch::folder;
use super::{WRONG, right};
use gearatlas::analysis::{Class, PointOutcome, Status, investigate_onward};
use gearatlas::manifest::{ManifestText, PointSpec, StiffnessSpec};
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::propagate::{ClosedModes, InstructionSet, Kernel, Volterra};
use gearatlas::store::TableStore;
use gearatlas::sweep::Prepared;
use std::sync::atomic::AtomicBool;

/// Base manifests: every kind of model, of stiffness, of contact.
pub const BASES: [&str; 12] = [
    super::scratch::OSCILLATOR,
    include_str!("../../manifests/tiers/torsional.toml"),
    include_str!("../../manifests/tiers/translational.toml"),
    include_str!("../../manifests/tiers/tilting.toml"),
    include_str!("../../manifests/tiers/pedestal.toml"),
    include_str!("../../manifests/tiers/flexible.toml"),
    include_str!("../../manifests/trains/clutch.toml"),
    include_str!("../../manifests/trains/idle-rattle.toml"),
    include_str!("../../manifests/trains/two-stage.toml"),
    include_str!("../../manifests/quickstart.toml"),
    include_str!("../../manifests/modes-mta.toml"),
    include_str!("../../manifests/basins.toml"),
];

const TRANSIENT: u64 = 60;
const CYCLES: u64 = 120;
const EVENT_LIMIT: u32 = 1000;

/// Limits of windows per mesh cycle and of modes, for the time of a run.
const WINDOWS: f64 = 400.0;
const MODES: usize = 30;

/// The first byte selects a manifest; the lines after it change its keys, `KEY=VALUE`.
pub fn drive(data: &[u8]) {
    let Some((first, lines)) = data.split_first() else {
        return;
    };
    let text = BASES[usize::from(*first) % BASES.len()];
    let changes: Vec<String> = (String::from_utf8_lossy(lines).lines())
        .map(str::to_owned)
        .collect();
    let asked = ManifestText {
        text,
        changes: &changes,
    };
    let Some(job) = judged(asked, &folder()) else {
        return;
    };
    for id in [0, job.points.len() - 1] {
        let point = job.points.at(id);
        // Tables of meshes take seconds each.
        let tabled = matches!(point.mesh.stiffness, StiffnessSpec::Table(_));
        if tabled || point.model.retained > MODES {
            return;
        }
        computed(&point);
    }
}

fn computed(point: &PointSpec) {
    let parts = Prepared::new(TableStore::open(folder().join("tables")));
    let Ok(model) = parts.model(point) else {
        return;
    };
    let windows = Volterra::windows_needed(&model, f64::EPSILON);
    if windows.is_nan() || windows > WINDOWS {
        return;
    }
    let volterra = Volterra::new(&model, f64::EPSILON, EVENT_LIMIT);
    let mut trajectory = model.start(&point.run.initial);
    let row = investigated(&model, &volterra, &mut trajectory);
    if row.status != Status::Ok {
        return;
    }
    if let Some((rule, how)) = broken(&row, model.half_gap).first() {
        panic!("{WRONG}{rule}: {how}");
    }
    let repeats = matches!(
        row.class,
        Some(Class::SteadyContact(Some(_)) | Class::Periodic(_))
    );
    if let Ok(closed_modes) = ClosedModes::new(&model, EVENT_LIMIT, InstructionSet::best())
        && repeats
    {
        let again = investigated(&model, &closed_modes, &mut trajectory);
        if let Some(how) = differs(&row, &again, model.half_gap) {
            panic!("{WRONG}closed_modes: {how}");
        }
    }
    right(trajectory.state.iter().all(|x| x.is_finite()), || {
        format!("{:?}", trajectory.state)
    });
}

fn investigated<K: Kernel>(
    model: &Model,
    kernel: &K,
    trajectory: &mut TrajectoryState,
) -> PointOutcome {
    let found = investigate_onward(
        model,
        kernel,
        trajectory,
        &questions(TRANSIENT, CYCLES),
        &AtomicBool::new(false),
    );
    found.expect("nobody calls it off")
}
