//! `atlas sensitivity m.toml --point …`: derivatives of the results of a point with respect to keys of the
//! manifest.

use super::manifest_args::ManifestArgs;
use super::point::{self, PointArg, number};
use super::process::{NOTHING_WRITTEN, Process};
use super::table::TablesFolder;
use super::threads::Threads;
use super::{BAD_INPUT, INTERRUPTED, OrFail, Status, answer, either, fail, start_threads};
use crate::analysis::sensitivity::ensemble::Ensemble;
use crate::manifest::Parameter;
use crate::sweep::{
    Differentiated, Prepared, Sensitivities, Sensitivity, SensitivityError, sensitivities,
};
use clap::Args;
use serde_json::json;
use std::process::ExitCode;

/// Arguments of `atlas sensitivity`.
#[derive(Debug, Args)]
pub struct SensitivityArgs {
    #[command(flatten)]
    manifest: ManifestArgs,
    #[command(flatten)]
    point: PointArg,
    /// Differentiate with respect to these keys, separated by commas: load, speed, or any quantity of the drive or of its
    /// modal file, such as mesh.half_gap or contact.stop.gap [default: load, speed, and all quantities of mesh and excitation that the manifest sets].
    #[arg(long, value_name = "KEY,...", value_delimiter = ',')]
    pub by: Vec<String>,
    /// Use an ensemble of this many members for a chaotic motion.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub members: u32,
    /// Compute this many mesh cycles of each member.
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub cycles: u64,
    /// Change each key by this fraction of its value for a chaotic motion.
    #[arg(long, value_name = "FRACTION", default_value_t = 0.02)]
    pub step: f64,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    tables: TablesFolder,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Prints the sensitivities of a point: status 0 if done, 1 if threads cannot start, 2 for bad input, 130 if
/// interrupted.
pub fn run(args: &SensitivityArgs) -> Status {
    let job = args.manifest.read_job()?;
    let point = point::read_point(&job, &args.point.text)?.spec;
    if !(args.step > 0.0 && args.step < 0.5) {
        return Err(fail(BAD_INPUT, "--step must be above 0 and below 0.5"));
    }
    let names = if args.by.is_empty() { job.between.continuous_keys() } else { whole(&args.by) };
    let keys: Result<Vec<Parameter>, _> = names
        .iter()
        .map(|name| job.between.parameter(&point, name))
        .collect();
    let keys = keys.or_fail(BAD_INPUT)?;
    let process = Process::prepare(NOTHING_WRITTEN)?;
    start_threads(args.threads.count())?;
    let settings = Ensemble {
        members: args.members as usize,
        transient: 200,
        cycles: args.cycles,
    };
    let parts = Prepared::new(args.tables.store());
    let differentiated = Differentiated {
        point: &point,
        held: &[],
    };
    let found = match sensitivities(
        &job,
        differentiated,
        &keys,
        &settings,
        args.step,
        &parts,
        &process.interrupt,
    ) {
        Err(SensitivityError::Interrupted(_)) => return Err(fail(INTERRUPTED, "interrupted")),
        found => found.or_explain(BAD_INPUT)?,
    };
    let text = either(args.json, || in_json(&found), || in_text(&found));
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// Rejoins names that clap split at a comma in brackets, such as `stiffness_matrix[1,2]`.
fn whole(parts: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for part in parts {
        match names.last_mut() {
            Some(name) if name.contains('[') && !name.contains(']') => {
                *name = format!("{name},{part}");
            }
            _ => names.push(part.clone()),
        }
    }
    names
}

fn in_json(sensitivities: &Sensitivities) -> serde_json::Value {
    let rows: Vec<_> = (sensitivities.rows.iter())
        .map(|row| {
            json!({
                "key": row.key, "key_unit": row.key_unit, "at": row.at,
                "quantity": row.quantity, "unit": row.unit, "value": row.value,
                "derivative": row.by, "check": row.check, "stderr": row.error,
                "method": row.method, "note": row.note,
            })
        })
        .collect();
    json!({ "class": sensitivities.class.name(), "reason": sensitivities.reason, "sensitivities": rows })
}

fn in_text(sensitivities: &Sensitivities) -> String {
    let mut out = format!(
        "motion    {}: {}\n\n",
        sensitivities.class.name(),
        sensitivities.reason
    );
    let names = |row: &Sensitivity| {
        let key = format!("{} [{}]", row.key, row.key_unit);
        (key, format!("{} [{}]", row.quantity, row.unit))
    };
    let (key_width, quantity_width) = sensitivities.rows.iter().map(names).fold(
        (26, 24),
        |(keys, quantities), (key, quantity)| {
            let width = |text: String| text.chars().count();
            (keys.max(width(key)), quantities.max(width(quantity)))
        },
    );
    out.push_str(&format!(
        "{:<key_width$}  {:<quantity_width$}{:>14}{:>16}{:>14}  {}\n",
        "key", "quantity", "value", "derivative", "relative", "check"
    ));
    for row in &sensitivities.rows {
        let by = row.by.map_or("-".to_owned(), |by| format!("{by:.6e}"));
        let relative = (row.by.map(|by| by * row.at / row.value)).filter(|part| part.is_finite());
        let relative = relative.map_or("-".to_owned(), |part| format!("{part:+.4}"));
        let check = match (row.by, row.check, row.error) {
            (Some(by), Some(check), None) if by == check => "differences agree".to_owned(),
            (Some(by), Some(check), None) if (by - check).abs() >= 0.1 * by.abs() => {
                format!("differences give {check:.1e}")
            }
            (Some(by), Some(check), None) => {
                format!("differences agree to {:.0e}", ((by - check) / by).abs())
            }
            (_, Some(check), Some(error)) => format!("± {error:.2e}, doubled step {check:.4e}"),
            _ => String::new(),
        };
        let note = if row.note.is_empty() { String::new() } else { format!("  ({})", row.note) };
        let (key, quantity) = names(row);
        out.push_str(&format!(
            "{key:<key_width$}  {quantity:<quantity_width$}{:>14}{by:>16}{relative:>14}  {check}{note}\n",
            number(row.value)
        ));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Class;

    #[test]
    fn rows_are_columns_and_zero_has_no_relative_error() {
        let row = |key: &str, by: f64| Sensitivity {
            key: key.to_owned(),
            key_unit: "N*s/m",
            at: 1.0,
            quantity: "force_mean".to_owned(),
            unit: "N",
            value: 100.0,
            by: Some(by),
            check: Some(1e-9),
            error: None,
            method: "orbit",
            note: String::new(),
        };
        let found = Sensitivities {
            class: Class::Periodic(1),
            reason: "it repeats".to_owned(),
            rows: vec![
                row("mesh.contact_damping", 0.0),
                row("excitation.transmission_error.0.amplitude", 1e-9),
            ],
        };
        let text = in_text(&found);
        assert!(!text.contains("inf"), "{text}");
        assert!(text.contains("differences give 1.0e-9"), "{text}");
        let lines = text.lines().skip(2).map(|line| line.find("force_mean"));
        let places: Vec<_> = lines.skip(1).collect();
        assert!(places[0].is_some() && places[0] == places[1], "{text}");
        assert!(text.contains("mesh.contact_damping [N*s/m] "), "{text}");
    }
}
