//! Which points does a job have, in words and for programs?

use crate::manifest::{Carried, Job};
use serde_json::{Value, json};

/// `80 = 8 load x 10 speed`; of a refined grid what is computed in any case, and the most that may
/// be.
pub fn points(job: &Job) -> String {
    let mut counts = counts(job, &[]);
    if let Some(carried) = job.carried.as_ref().filter(|c| c.directions.len() > 1) {
        counts.push(format!("{} directions", carried.directions.len()));
    }
    let all = format!("{} = {}", job.points.len(), counts.join(" x "));
    let Some(refine) = &job.refine else {
        return all;
    };
    let halvings = match refine.nested.levels {
        1 => "1 halving".to_owned(),
        levels => format!("{levels} halvings"),
    };
    format!(
        "{} = {}; more where {} differ, up to {halvings} of each interval: at most {all}",
        refine.nested.places(0),
        self::counts(job, &refine.nested.coarse).join(" x "),
        refine.by_words(),
    )
}

/// `8 load`, `10 speed`, or `12 torque with speed` of tied axes; `varied` stands for the lengths of axes with several
/// values.
fn counts(job: &Job, varied: &[usize]) -> Vec<String> {
    let mut varied = varied.iter().copied();
    let mut count = |all: usize| match all {
        1 => 1,
        all => varied.next().unwrap_or(all),
    };
    (job.dimensions.iter())
        .map(|own| {
            let names: Vec<&str> = own.axes.iter().map(|&axis| job.axes[axis].name()).collect();
            format!("{} {}", count(own.length), names.join(" with "))
        })
        .collect()
}

/// `16 chains of 200 points, carried along speed (up, then down); chains run side by side`.
pub fn order(job: &Job, carried: &Carried) -> String {
    let chains = job.points.len() / carried.length;
    let directions: Vec<&str> = carried.directions.iter().map(|d| d.name()).collect();
    format!(
        "{chains} {} of {} points, carried along {} ({}); {}",
        if chains == 1 { "chain" } else { "chains" },
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

/// How the state is carried; null where points are independent.
pub fn carried_json(job: &Job) -> Value {
    json!(job.carried.as_ref().map(|carried| json!({
        "along": job.axes[carried.axis].name(),
        "directions": carried.directions.iter().map(|d| d.name()).collect::<Vec<_>>(),
        "chains": job.points.len() / carried.length,
        "chain_length": carried.length,
    })))
}

/// The axes that advance in step, group by group.
pub fn tied_json(job: &Job) -> Value {
    let names =
        |axes: &[usize]| -> Vec<&str> { axes.iter().map(|&axis| job.axes[axis].name()).collect() };
    let groups = job.dimensions.iter().filter(|own| own.is_tied());
    json!(groups.map(|own| names(&own.axes)).collect::<Vec<_>>())
}

/// How the grid is refined; null where it is not. `points` is then the most there can be.
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

/// Why the points of a refined grid cannot be dealt out, or some of them computed again.
pub fn refuses(job: &Job, option: &str) -> Option<String> {
    job.refine.as_ref().map(|_| {
        format!(
            "{option} cannot be used with grid.refine, because each refined point depends on the results of \
             others; remove {option} or grid.refine"
        )
    })
}
