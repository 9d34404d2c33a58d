//! What a Campbell diagram shows, computed from a manifest: natural frequencies over the speed, with
//! contacts open and closed, and the orders of mesh and shafts.

use std::f64::consts::TAU;
use std::path::Path;

use super::{manifest_args, with_causes};
use crate::analysis::Frequencies;
use crate::manifest::{self, AxisKey, Job, axis_units};
use crate::report::{Campbell, ModeLine, Ray, USUAL_ORDERS, to_digits};
use crate::store::read_runs;
use crate::sweep::build;

/// Speeds at which modes are computed: between them frequencies are nearly linear.
const SPEEDS: usize = 9;

/// Lowest of them, as part of the highest.
const LOWEST: f64 = 0.05;

/// How far the diagram goes beyond the highest speed of the grid, and beyond the only one.
const BEYOND: [f64; 2] = [1.08, 1.5];

/// The diagram of a manifest, or of the manifest of a results folder.
///
/// # Errors
/// Why there is none, in a sentence; none where the errors of the manifest were already shown.
pub fn of(source: &Path, orders: &[f64]) -> Result<Campbell, Option<String>> {
    let job = job(source)?;
    let axis = job.axes.iter().find(|axis| axis.key == AxisKey::Speed);
    let first = job
        .points
        .first()
        .ok_or_else(|| Some("the grid has no point".to_owned()))?;
    let (low, high) = axis.map_or((first.speed, first.speed), |axis| axis.values.ends());
    let last = high * BEYOND[usize::from(low == high)];
    let grid = if low == high {
        [LOWEST * last, last]
    } else {
        [low, high]
    };
    let failed = |error: &dyn std::error::Error| Some(with_causes(error));
    let structure = build::structure(&first.model).map_err(|error| failed(&error))?;
    let speeds: Vec<f64> = (0..SPEEDS)
        .map(|i| last * (LOWEST + (1.0 - LOWEST) * i as f64 / (SPEEDS - 1) as f64))
        .collect();
    let mut at_speed = Vec::new();
    for &speed in &speeds {
        let mut point = first.clone();
        point.speed = speed;
        let model = build::mean_model(&structure, &point).map_err(|error| failed(&error))?;
        at_speed.push(Frequencies::of(&model));
    }
    // Modes are told by their place in ascending frequency; rigid motions are no line.
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
    let teeth = f64::from(structure.teeth);
    let orders = if orders.is_empty() {
        &USUAL_ORDERS[..]
    } else {
        orders
    };
    let mesh = orders.iter().map(|order| Ray {
        name: format!("{} × mesh", to_digits(*order, 4)),
        order: order * teeth,
        of_mesh: true,
    });
    let shaft = |name: &str, order: f64| Ray {
        name: name.to_owned(),
        order,
        of_mesh: false,
    };
    let wheel = structure
        .wheel_teeth
        .map(|wheel| shaft("1 × wheel", teeth / f64::from(wheel)));
    let load = to_digits(first.load, 4);
    Ok(Campbell {
        unit: axis_units(&job.text).remove("speed"),
        words: match job.points.variants().len() {
            1 => format!(
                "load {load}  ·  closed: the contacts that bear the static load, with their mean stiffness"
            ),
            count => format!(
                "load {load}, the first of {count} structures  ·  closed: the contacts that bear the static load"
            ),
        },
        job: job.name,
        grid,
        speeds,
        open,
        closed,
        rays: mesh
            .chain([shaft("1 × pinion", 1.0)])
            .chain(wheel)
            .collect(),
    })
}

/// The job of a manifest, or of the record of a results folder.
fn job(source: &Path) -> Result<Job, Option<String>> {
    if source.is_file() {
        return manifest::load(source).map_err(|errors| {
            manifest_args::report(&errors);
            None
        });
    }
    let runs = read_runs(source).map_err(|error| Some(with_causes(&error)))?;
    let remedy = "give the manifest itself: atlas plot m.toml --what campbell";
    let Some(run) = runs.into_iter().next() else {
        let here = source.display();
        return Err(Some(format!(
            "`{here}` has no run.json with a manifest; {remedy}"
        )));
    };
    manifest::parse(&run.manifest, "the manifest in run.json", Path::new("")).map_err(|errors| {
        let first = errors
            .diagnostics
            .first()
            .map_or("", |first| &first.message);
        Some(format!(
            "the manifest in `{}` cannot be read here: {first}; {remedy}",
            source.join("run.json").display()
        ))
    })
}
