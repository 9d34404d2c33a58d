//! The data of a Campbell diagram, computed from a manifest: natural frequencies over the speed, with contacts open and
//! closed, and the orders of mesh, shafts and torque ripple.

use std::f64::consts::TAU;
use std::path::Path;

use super::{manifest_args, with_causes};
use crate::analysis::Frequencies;
use crate::manifest::{self, AxisKey, Job, ManifestText, PointSpec};
use crate::model::DriveShaft;
use crate::report::{Campbell, DEFAULT_ORDERS, ModeLine, NEAR_GRID, Ray, to_digits};
use crate::store::read_runs;
use crate::structure::ModalStructure;
use crate::sweep::{MeshTables, Prepared, build};
use crate::units;

/// Number of speeds at which modes are computed; between them, frequencies are nearly linear in the speed.
const SPEEDS: usize = 9;

/// Largest ratio of the lowest to the highest speed of the diagram. The diagram always begins below the grid.
const LOWEST: f64 = 0.05;

/// Highest speed of the diagram if the grid has a single speed, relative to this speed.
const BEYOND_ONE: f64 = 1.5;

/// The diagram of a job's first structure, with rays for these mesh orders; if `orders` is empty, for the
/// [`DEFAULT_ORDERS`].
///
/// # Errors
/// The reason why there is no diagram, as a sentence.
pub fn of(job: &Job, orders: &[f64], parts: &Prepared) -> Result<Campbell, String> {
    let axis = job.axes.iter().find(|axis| axis.key == AxisKey::Speed);
    let first = job
        .points
        .first()
        .ok_or_else(|| "the grid has no point".to_owned())?;
    let (low, high) = axis.map_or((first.speed, first.speed), |axis| axis.values.ends());
    let last = high * if low == high { BEYOND_ONE } else { 1.0 + NEAR_GRID };
    let lowest = (LOWEST * last).min((1.0 - NEAR_GRID) * low);
    let structure = parts.structure(&first.model);
    let structure = structure.map_err(|error| with_causes(&error))?;
    let speeds: Vec<f64> = (0..SPEEDS)
        .map(|i| lowest + (last - lowest) * i as f64 / (SPEEDS - 1) as f64)
        .collect();
    let at_speed = at_speeds(&structure, &first, &speeds, parts.meshes());
    let at_speed = at_speed.map_err(|error| with_causes(&error))?;
    // A line joins the modes with the same position in ascending frequency. Rigid-body motions get no line.
    let count = |of: fn(&Frequencies) -> usize| at_speed.iter().map(of).min().unwrap_or(0);
    let lines = |count: usize, of: &dyn Fn(&Frequencies, usize) -> [f64; 2]| -> Vec<ModeLine> {
        let all = (0..count).map(|mode| {
            let values: Vec<[f64; 2]> = at_speed.iter().map(|at| of(at, mode)).collect();
            ModeLine {
                mode: mode + 1,
                frequencies: values
                    .iter()
                    .map(|[frequency, _]| frequency / TAU)
                    .collect(),
                mesh_share: values.iter().map(|[_, share]| *share).fold(0.0, f64::max),
            }
        });
        all.filter(|line| line.frequencies.iter().any(|f| *f > 0.0))
            .collect()
    };
    let open = lines(count(|at| at.open.len()), &|at, mode| {
        [at.open[mode].frequency, 0.0]
    });
    let closed = lines(count(|at| at.closed.len()), &|at, mode| {
        let closed = &at.closed[mode];
        [closed.mode.frequency, closed.mesh_share]
    });
    let cycles = structure.cycles_per_turn();
    let orders = if orders.is_empty() { &DEFAULT_ORDERS[..] } else { orders };
    let mesh = orders.iter().map(|order| Ray {
        name: format!("{} × mesh", to_digits(*order, 4)),
        order: order * cycles,
        of_mesh: true,
    });
    let further = further_meshes(&structure);
    let further = further.iter().flat_map(|(name, ratio)| {
        orders.iter().map(move |order| Ray {
            name: format!("{} × {name}", to_digits(*order, 4)),
            order: order * cycles * ratio,
            of_mesh: true,
        })
    });
    let shafts = [
        ("pinion", DriveShaft::Pinion, Some(1.0)),
        (
            "wheel",
            DriveShaft::Wheel,
            structure.wheel_teeth.map(|wheel| cycles / f64::from(wheel)),
        ),
    ];
    let shafts = shafts.iter().flat_map(|(name, shaft, turns)| {
        let turns = turns.iter().flat_map(|turns| {
            let orders = shaft_orders(&first, *shaft).into_iter();
            orders.map(move |order| (order, order * turns))
        });
        turns.map(move |(multiple, order)| Ray {
            name: format!("{} × {name}", to_digits(multiple, 4)),
            order,
            of_mesh: false,
        })
    });
    let mut written = job.written().axis_units();
    let load = match written.remove("load") {
        Some(unit) => {
            let factor = units::conversion("1", &unit).unwrap_or(1.0);
            format!("{} {unit}", to_digits(first.load * factor, 4))
        }
        None => to_digits(first.load, 4),
    };
    Ok(Campbell {
        unit: written.remove("speed"),
        words: match job.points.variants().len() {
            1 => format!(
                "load {load}  ·  closed: the contacts that bear the static load, at their mean stiffness"
            ),
            count => format!(
                "load {load}, the first of {count} structures  ·  closed: the contacts that bear the static load"
            ),
        },
        job: job.name.clone(),
        grid: [low, high],
        speeds,
        open,
        closed,
        rays: mesh.chain(further).chain(shafts).collect(),
    })
}

/// One mesh per mesh frequency that differs from that of the first mesh, for example one per planetary set:
/// `mesh of` with the name of the mesh, and the number of its mesh cycles per cycle of the first mesh.
fn further_meshes(structure: &ModalStructure) -> Vec<(String, f64)> {
    let mut known = vec![[1, 1]];
    let names = structure.mesh_names().into_iter().skip(1);
    let meshes = names.zip(structure.contacts.iter().step_by(2));
    meshes
        .filter_map(|(name, contact)| {
            let [p, q] = contact.cycles;
            let new = !known.contains(&[p, q]);
            known.push([p, q]);
            new.then(|| (format!("mesh of {name}"), f64::from(p) / f64::from(q)))
        })
        .collect()
}

/// Modes at every speed. Only gyroscopic terms depend on the speed: without them, the modes of the first
/// speed are used for all speeds.
fn at_speeds(
    structure: &ModalStructure,
    first: &PointSpec,
    speeds: &[f64],
    meshes: &MeshTables,
) -> Result<Vec<Frequencies>, build::BuildError> {
    let turning = (structure.coupling.iter())
        .any(|coupling| coupling.gyroscopic.iter().any(|term| *term != 0.0));
    let distinct = if turning { speeds } else { &speeds[..1] };
    let models = build::mean_models(structure, first, distinct, meshes)?;
    let mut found: Vec<Frequencies> = models.iter().map(Frequencies::of).collect();
    let last = found.last().cloned();
    found.extend(last.into_iter().cycle().take(speeds.len() - found.len()));
    Ok(found)
}

/// Orders of the excitations of a shaft: once per revolution, torque ripple and imposed motion; ascending.
fn shaft_orders(first: &PointSpec, shaft: DriveShaft) -> Vec<f64> {
    let ripples = first.excitation.torque_ripple.iter();
    let motions = first.excitation.imposed_motion.iter();
    let all = (ripples.map(|ripple| (ripple.shaft, ripple.order)))
        .chain(motions.map(|motion| (motion.shaft, motion.order)));
    let of_shaft = all
        .filter(|excitation| excitation.0 == shaft)
        .map(|excitation| excitation.1);
    let mut orders: Vec<f64> = of_shaft.chain([1.0]).collect();
    orders.sort_by(f64::total_cmp);
    orders.dedup();
    orders
}

/// The job of a manifest, or of the record of a results folder.
///
/// # Errors
/// The reason as a sentence, with `remedy` if the record has no valid manifest. `None` if the errors of a
/// manifest file were already shown.
pub fn job(source: &Path, remedy: &str) -> Result<Job, Option<String>> {
    if source.is_file() {
        return match manifest::load(source) {
            Ok(job) => {
                manifest_args::warn(&job.warnings);
                Ok(job)
            }
            Err(errors) => {
                manifest_args::report(&errors);
                Err(None)
            }
        };
    }
    let runs = read_runs(source).map_err(|error| Some(with_causes(&error)))?;
    let Some(run) = runs.into_iter().next() else {
        let here = source.display();
        return Err(Some(format!(
            "`{here}` has no run.json with a manifest; {remedy}"
        )));
    };
    let written = ManifestText {
        text: &run.manifest,
        changes: &run.set,
    };
    let job = written.job("the manifest in run.json", Path::new(&run.folder));
    job.map_err(|errors| {
        let first = errors
            .diagnostics
            .first()
            .map_or("", |first| &first.message);
        Some(format!(
            "the manifest in `{}` cannot be read: {first}; {remedy}",
            source.join("run.json").display()
        ))
    })
}
