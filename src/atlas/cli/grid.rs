//! The points of a job, as text and as JSON, for `atlas check` and `atlas plan`.

use crate::manifest::{Carried, Design, Job, Law};
use crate::report::{Unit, to_digits};
use crate::units::plural;
use serde_json::{Value, json};

/// Number of points: `80 = 8 load x 10 speed`. For a refined grid, the smallest and the largest number of
/// points.
pub fn points(job: &Job) -> String {
    let mut counts = counts(job, &[]);
    if let Some(carried) = job.carried.as_ref().filter(|c| c.directions.len() > 1) {
        counts.push(format!("{} directions", carried.directions.len()));
    }
    let all = format!("{} = {}", job.points.len(), counts.join(" x "));
    let Some(refine) = &job.refine else {
        return all;
    };
    let halvings = plural(refine.nested.levels as usize, "halving");
    format!(
        "{} = {}; more where {} differ, up to {halvings} of each interval: at most {all}",
        refine.nested.places(0),
        self::counts(job, &refine.nested.coarse).join(" x "),
        refine.by_words(),
    )
}

/// Length and names of each dimension: `8 load`, `10 speed`, or `12 torque with speed` for tied axes.
/// `varied` replaces the lengths of the dimensions with several values, in their order; empty to keep all
/// lengths.
fn counts(job: &Job, varied: &[usize]) -> Vec<String> {
    let mut varied = varied.iter().copied();
    let mut count = |all: usize| match all {
        1 => 1,
        all => varied.next().unwrap_or(all),
    };
    (job.dimensions.iter())
        .map(|dimension| {
            let names: Vec<&str> = dimension
                .axes
                .iter()
                .map(|&axis| job.axes[axis].name())
                .collect();
            let names = names.join(" with ");
            let of = if dimension.sampled { "samples of " } else { "" };
            format!("{} {of}{names}", count(dimension.length))
        })
        .collect()
}

/// `16 chains of 200 points, carried along speed (up, then down); chains run side by side`.
pub fn order(job: &Job, carried: &Carried) -> String {
    let chains = job.points.len() / carried.length;
    let directions: Vec<&str> = carried.directions.iter().map(|d| d.name()).collect();
    format!(
        "{} of {} points, carried along {} ({}); {}",
        plural(chains, "chain"),
        carried.length,
        (job.tied(carried.axis)
            .iter()
            .map(|&axis| job.axes[axis].name()))
        .filter(|name| *name != job.axes[carried.axis].name())
        .fold(
            job.axes[carried.axis].name().to_owned(),
            |words, name| format!("{words} with {name}")
        ),
        directions.join(", then "),
        match chains {
            1 => "one after another on one thread",
            _ => "chains run side by side",
        }
    )
}

/// How the state is carried; null if points are independent.
pub fn carried_json(job: &Job) -> Value {
    json!(job.carried.as_ref().map(|carried| json!({
        "along": job.axes[carried.axis].name(),
        "directions": carried.directions.iter().map(|d| d.name()).collect::<Vec<_>>(),
        "chains": job.points.len() / carried.length,
        "chain_length": carried.length,
    })))
}

/// The axes that advance in step, by group.
pub fn tied_json(job: &Job) -> Value {
    let names =
        |axes: &[usize]| -> Vec<&str> { axes.iter().map(|&axis| job.axes[axis].name()).collect() };
    let groups = job
        .dimensions
        .iter()
        .filter(|dimension| dimension.is_tied());
    json!(groups.map(|group| names(&group.axes)).collect::<Vec<_>>())
}

/// `1000 Sobol' points of 3 distributions, scrambled by seed 1; 5000 rows of the matrices A, AB and B for
/// Sobol' indices (saltelli)`. `None` if no axis is a distribution.
pub fn samples(job: &Job) -> Option<String> {
    let samples = job.samples.as_ref()?;
    let (count, axes) = (samples.count, samples.axes.len());
    let of = if axes == 1 {
        "1 distribution".to_owned()
    } else {
        format!("{axes} distributions")
    };
    let rows = match samples.design {
        Design::Sobol => String::new(),
        Design::Saltelli => {
            let rows = count * samples.design.rows_per_sample(axes);
            format!("; {rows} rows of the matrices A, AB and B for Sobol' indices (saltelli)")
        }
    };
    Some(format!(
        "{count} Sobol' points of {of}, scrambled by seed {}{rows}",
        job.seed
    ))
}

/// `normal (mean 80, standard deviation 10, truncated at 60 and 100)`: the distribution of a sampled axis. The
/// text has the values in `unit`, without the unit itself. `None` if the axis is not a distribution.
pub fn distribution(job: &Job, axis: usize, unit: &Unit) -> Option<String> {
    let drawn = job.samples.as_ref()?.axes.iter();
    let (_, distribution) = drawn
        .into_iter()
        .find(|(drawn_axis, _)| *drawn_axis == axis)?;
    let number = |value: f64| to_digits(value * unit.factor, 4);
    let law = match &distribution.law {
        Law::Normal { mean, deviation } => {
            format!(
                "mean {}, standard deviation {}",
                number(*mean),
                number(*deviation)
            )
        }
        Law::Lognormal { median, deviation } => format!(
            "median {}, standard deviation of the logarithm {}",
            number(*median),
            to_digits(*deviation, 4)
        ),
        Law::Uniform { low, high } => format!("{} to {}", number(*low), number(*high)),
        Law::Empirical(values) => format!("{} values", values.len()),
    };
    let limits = distribution.truncate.map_or(String::new(), |[low, high]| {
        format!(", truncated at {} and {}", number(low), number(high))
    });
    Some(format!("{} ({law}{limits})", distribution.law.name()))
}

/// How values are sampled; null if no axis is a distribution.
pub fn samples_json(job: &Job) -> Value {
    json!(job.samples.as_ref().map(|samples| json!({
        "design": samples.design.name(),
        "samples": samples.count,
        "rows": samples.count * samples.design.rows_per_sample(samples.axes.len()),
        "distributions": (samples.axes.iter())
            .map(|(axis, distribution)| json!({
                "axis": job.axes[*axis].name(),
                "law": distribution.law,
                "truncate": distribution.truncate,
            }))
            .collect::<Vec<_>>(),
    })))
}

/// How the grid is refined; null if it is not. For a refined grid, `points` of `atlas check` is an upper limit.
pub fn refine_json(job: &Job) -> Value {
    json!(job.refine.as_ref().map(|refine| json!({
        "coarse": refine.nested.coarse,
        "coarse_points": refine.nested.places(0),
        "levels": refine.nested.levels,
        "by": refine.by.iter().map(|criterion| criterion.name()).collect::<Vec<_>>(),
        "tolerance": refine.tolerance,
        "longest_period": refine.longest_period,
    })))
}

/// The reason why `--shard` or `--retry` cannot be used with a refined grid; `None` for other grids.
pub fn refuses(job: &Job, option: &str) -> Option<String> {
    job.refine.as_ref().map(|_| {
        format!(
            "{option} cannot be used with grid.refine, because each refined point depends on the results of \
             others; remove {option} or grid.refine"
        )
    })
}
