//! Which keys of a manifest have no effect on a run?

use crate::analysis::Section as PoincareSection;
use crate::manifest::tree::{Node, Value};
use crate::manifest::{
    AxisKey, FrictionSpec, Job, PointSpec, StiffnessSpec, StructureSource, sections,
};

/// Keys of `[gear]` that only a mesh computed from the drawing uses.
const OF_FLANKS: [&str; 13] = [
    "tip_relief",
    "root_relief",
    "end_relief",
    "profile_crowning",
    "profile_slope",
    "profile_points",
    "lead_crowning",
    "lead_slope",
    "lead_points",
    "young_modulus",
    "poisson_ratio",
    "plane",
    "bore",
];

/// Keys of [`OF_FLANKS`], and the face width, on which the compliance of a cracked tooth depends.
const OF_CRACKS: [&str; 4] = ["face_width", "young_modulus", "poisson_ratio", "plane"];

/// Keys without effect, each with a message about the reason.
pub(super) fn idle(job: &Job, first: &PointSpec, root: &Node) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let varied = |key: &str| job.axes.iter().any(|axis| axis.name() == key);
    let drawn = first.model.source.gears().is_some();
    let imposed = !matches!(first.mesh.stiffness, StiffnessSpec::Table(_));
    let cracked = (first.mesh.teeth.as_ref())
        .is_some_and(|teeth| teeth.faults.iter().any(|fault| fault.cracks != [None; 2]));
    if drawn && imposed {
        let why = "has no effect because the stiffness of the mesh is given; stiffness = \"table\" computes it from the drawing";
        // The mesh acts at the middle of offset faces, which depends on their widths.
        let offset = root.at("gear.face_offset").is_some()
            || ["", ".0", ".1"]
                .iter()
                .any(|end| varied(&format!("gear.face_offset{end}")));
        // Laws of friction and a film of oil depend on the width, too.
        let constant = matches!(first.mesh.friction, FrictionSpec::Constant(_));
        let width = (constant && !offset && first.mesh.film.is_none()).then_some("face_width");
        let idle = |key: &&str| !(cracked && OF_CRACKS.contains(key));
        for key in OF_FLANKS.into_iter().chain(width).filter(idle) {
            let path = format!("gear.{key}");
            if given(job, root, &path) {
                found.push((path, why.to_owned()));
            }
        }
    }
    found.extend(ineffective_shaft_keys(first, root));
    found.extend(overridden_shafts(job, root));
    // Amplitudes that the grid varies may be 0 at some points only.
    found.extend(silent(first).into_iter().filter(|(key, _)| !varied(key)));
    if job.continuation.is_some() {
        let why = "is only used by `atlas follow`, not by `atlas run`";
        found.push(("continuation".to_owned(), why.to_owned()));
    }
    if job.run_up.is_some() {
        let why = "is only used by `atlas runup`, not by `atlas run`";
        found.push(("runup".to_owned(), why.to_owned()));
    }
    found.extend(unloaded(job, first));
    found.extend(sections_of_flanks(first, root));
    if first.load == 0.0
        && job
            .axes
            .iter()
            .filter(|axis| matches!(axis.key, AxisKey::Load | AxisKey::Torque))
            .all(|axis| axis.values.ends() == (0.0, 0.0))
    {
        let given = ["gear.rated_torque", "train.rated_torque"]
            .into_iter()
            .filter(|key| root.at(key).is_some());
        let why = "has no effect because every load is 0";
        found.extend(given.map(|key| (key.to_owned(), why.to_owned())));
    }
    found
}

/// The axis of load or torque if it has no effect because the modal file has no `torque`.
fn unloaded(job: &Job, first: &PointSpec) -> Option<(String, String)> {
    let StructureSource::Modal(structure) = &first.model.source else {
        return None;
    };
    let axis =
        (job.axes.iter()).find(|axis| matches!(axis.key, AxisKey::Load | AxisKey::Torque))?;
    let idle =
        structure.torque.iter().all(|torque| *torque == 0.0) && axis.values.ends() != (0.0, 0.0);
    let why = "has no effect because the modal file has no `torque`";
    idle.then(|| (format!("grid.{}", axis.name()), why.to_owned()))
}

/// The Poincaré section if only flanks give samples there and the modal file has no mesh.
fn sections_of_flanks(first: &PointSpec, root: &Node) -> Option<(String, String)> {
    let section = &first.analyses.poincare.as_ref()?.section;
    let of_flanks = !matches!(
        section,
        PoincareSection::Strobe { .. } | PoincareSection::Surface(_) | PoincareSection::Extremum
    );
    let without_mesh =
        matches!(first.model.source, StructureSource::Modal(_)) && root.at("mesh").is_none();
    let why = "gives no samples because the modal file has no `mesh`; section = \"strobe\", \"extremum\" or \"surface\" does";
    (of_flanks && without_mesh).then(|| ("analyses.poincare.section".to_owned(), why.to_owned()))
}

/// Whether the manifest has a key, or an axis of its grid varies it.
fn given(job: &Job, root: &Node, path: &str) -> bool {
    root.at(path).is_some() || job.axes.iter().any(|axis| axis.name() == path)
}

/// Keys of `[shafts]` that the tables of both shafts override.
fn overridden_shafts(job: &Job, root: &Node) -> Vec<(String, String)> {
    let axes = job.axes.iter().map(|axis| axis.name());
    let mut shared: Vec<String> = axes
        .filter_map(|name| name.strip_prefix("shafts."))
        .map(str::to_owned)
        .collect();
    if let Some(Value::Table(entries)) = root.at("shafts").map(|node| &node.value) {
        for entry in entries {
            match &entry.node.value {
                Value::Table(inner) => {
                    shared.extend(inner.iter().map(|key| format!("{}.{}", entry.key, key.key)));
                }
                _ => shared.push(entry.key.clone()),
            }
        }
    }
    let of_both = |key: &String| {
        let paths = ["pinion", "wheel"].map(|shaft| format!("shafts.{shaft}.{key}"));
        paths.iter().all(|path| given(job, root, path))
    };
    (shared.into_iter())
        .filter(of_both)
        .map(|key| {
            let why = "has no effect because both shafts override it".to_owned();
            (format!("shafts.{key}"), why)
        })
        .collect()
}

/// Given keys of `[shafts]` that have no effect for the kind of model.
fn ineffective_shaft_keys(first: &PointSpec, root: &Node) -> Vec<(String, String)> {
    let StructureSource::Rigid(drive) = &first.model.source else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for table in ["shafts", "shafts.pinion", "shafts.wheel"] {
        let Some(Value::Table(entries)) = root.at(table).map(|node| &node.value) else {
            continue;
        };
        for entry in entries {
            let inner: Vec<String> = match &entry.node.value {
                Value::Table(inner) if entry.key == "bearings" => inner
                    .iter()
                    .map(|below| format!("bearings.{}", below.key))
                    .collect(),
                _ => vec![entry.key.clone()],
            };
            let ineffective_keys = inner
                .into_iter()
                .filter(|key| !sections::has_effect(drive.tier, key));
            let why = format!("has no effect with kind = \"{}\"", drive.tier.name());
            found.extend(ineffective_keys.map(|key| (format!("{table}.{key}"), why.clone())));
        }
    }
    found
}

/// Keys of excitations of amplitude 0.
fn silent(first: &PointSpec) -> Vec<(String, String)> {
    let excitation = &first.excitation;
    let errors = excitation
        .transmission_error
        .iter()
        .map(|term| term.amplitude);
    let of_coast = excitation.coast_transmission_error.iter().flatten();
    let ripples = excitation
        .torque_ripple
        .iter()
        .map(|ripple| ripple.amplitude);
    let mut found = Vec::new();
    let mut list = |name: &str, amplitudes: Vec<f64>| {
        for index in (0..amplitudes.len()).filter(|index| amplitudes[*index] == 0.0) {
            let key = format!("excitation.{name}.{index}.amplitude");
            found.push((key, "is 0, so this entry excites nothing".to_owned()));
        }
    };
    list("transmission_error", errors.collect());
    list(
        "coast_transmission_error",
        of_coast.map(|term| term.amplitude).collect(),
    );
    list("torque_ripple", ripples.collect());
    let motions = excitation.imposed_motion.iter();
    list(
        "imposed_motion",
        motions.map(|motion| motion.amplitude).collect(),
    );
    found
}
