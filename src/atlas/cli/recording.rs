//! Common parts of `atlas trace` and `atlas runup`: the folder of a recording, and the message at its end. Only
//! with `--overwrite` does a recording replace one of the same kind.

use super::{FAILED_POINTS, answer, fail};
use crate::manifest::Job;
use crate::propagate::Stop;
use crate::store::{TableKind, table_path};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The default folder of a recording: `results/JOB/trace-POINT`, or `results/JOB/trace` if `label` is empty.
pub(super) fn folder(job: &Job, recording: &str, label: &str) -> PathBuf {
    let name = match label {
        "" => recording.to_owned(),
        label => format!("{recording}-{label}"),
    };
    Path::new("results").join(&job.name).join(name)
}

/// The message if a folder already contains such a recording; `None` if it does not.
pub(super) fn existing_message(folder: &Path, kind: TableKind, recording: &str) -> Option<String> {
    let file = table_path(folder, kind, None);
    file.exists().then(|| {
        format!(
            "`{}` already exists; choose another folder with --out, or replace the {recording} with --overwrite",
            file.display()
        )
    })
}

/// The values of the axes as JSON, by name.
pub(super) fn values_json(values: &[(String, f64)]) -> Map<String, Value> {
    let values = values.iter();
    values
        .map(|(name, value)| (name.clone(), json!(value)))
        .collect()
}

/// Prints the summary of a recording, and the reason if the motion ended early. Returns the exit status.
pub(super) fn ended(text: &str, recording: &str, stop: Option<Stop>) -> ExitCode {
    let status = answer(text, ExitCode::SUCCESS);
    let Some(stop) = stop else {
        return status;
    };
    let message =
        format!("the {recording} ended early: {stop}; the files hold the motion before that");
    fail(FAILED_POINTS, &message)
}
