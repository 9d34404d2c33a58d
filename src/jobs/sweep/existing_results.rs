//! What does a results folder contain before a run, and may the run write there?

use crate::manifest::{Job, ManifestText};
use crate::store::{
    RunRecord, RunState, Shard, StoreError, TableKind, journal_path, read_run, record_paths,
    run_path, table_path, verify,
};
use std::path::{Path, PathBuf};

/// What a folder already contains of the requested run.
#[derive(Debug)]
pub enum ExistingResults {
    /// No complete results; a journal may have points of an interrupted run.
    Nothing,
    /// All results of the run; every table agrees with its record.
    Complete(Box<RunRecord>),
}

/// Why a folder must not be touched.
#[derive(Debug, thiserror::Error)]
pub enum ExistingResultsError {
    /// The contents cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The results of another manifest.
    #[error(
        "{} holds results of another manifest ({hashes}); {remedy}\n{difference}",
        folder.display()
    )]
    OtherManifest {
        /// The folder.
        folder: PathBuf,
        /// Name and shard of the job there, and the beginnings of both hashes.
        hashes: String,
        /// The remedy.
        remedy: &'static str,
        /// Lines that only one of the two manifests has.
        difference: String,
    },
    /// The results of another split of the same job.
    #[error(
        "{} holds {found} of this job, which cannot be combined with {wanted}; choose another folder with --out, or remove this folder",
        folder.display()
    )]
    OtherParts {
        /// The folder.
        folder: PathBuf,
        /// The contents of the folder, in words.
        found: String,
        /// The requested results, in words.
        wanted: String,
    },
    /// A table that belongs to no known run.
    #[error(
        "{} is in the way: no record and no journal there tells which run wrote it; choose another folder with --out, or \
         replace the tables with --overwrite",
        path.display()
    )]
    NoRecord {
        /// The table.
        path: PathBuf,
    },
}

/// Inspects the folder. `fresh` allows replacing the results of the same shard (or of the whole job), never other
/// results: a folder holds one job.
///
/// # Errors
/// [`ExistingResultsError`] if the folder must not be touched.
pub fn inspect(
    folder: &Path,
    job: &Job,
    shard: Option<Shard>,
    fresh: bool,
) -> Result<ExistingResults, ExistingResultsError> {
    if !folder.exists() {
        return Ok(ExistingResults::Nothing);
    }
    let new_record = run_path(folder, shard);
    let mut records = Vec::new();
    for path in record_paths(folder)? {
        match read_run(&path) {
            Ok(record) => records.push(record),
            // `fresh` replaces this record, so its faults do not matter.
            Err(_) if fresh && path == new_record => {}
            Err(error) => return Err(error.into()),
        }
    }
    for record in records {
        let replaceable = record.shard == shard;
        if replaceable && fresh {
            continue;
        }
        if record.manifest_hash != job.hash {
            let there = ManifestText {
                text: &record.manifest,
                changes: &record.set,
            };
            let of_shard = record.shard.map_or_else(String::new, |s| format!(", {s}"));
            return Err(ExistingResultsError::OtherManifest {
                folder: folder.to_path_buf(),
                hashes: format!(
                    "job {}{of_shard}, hash {}…; this one is {}…",
                    record.job,
                    prefix(&record.manifest_hash),
                    prefix(&job.hash)
                ),
                remedy: if replaceable {
                    "choose another folder with --out, or replace them with --overwrite"
                } else {
                    "choose another folder with --out, or remove this folder"
                },
                difference: difference(&there.to_string(), &job.written().to_string()),
            });
        }
        if record.shard.map(|s| s.count) != shard.map(|s| s.count) {
            return Err(ExistingResultsError::OtherParts {
                folder: folder.to_path_buf(),
                found: part(record.shard),
                wanted: part(shard),
            });
        }
        if replaceable && record.state == RunState::Complete {
            verify(folder, &record)?;
            return Ok(ExistingResults::Complete(Box::new(record)));
        }
    }
    let unfinished = [&new_record, &journal_path(folder, shard)];
    if !fresh && unfinished.iter().all(|path| !path.exists()) {
        let mut tables = (TableKind::OF_A_JOB.iter()).map(|kind| table_path(folder, *kind, shard));
        if let Some(path) = tables.find(|path| path.exists()) {
            return Err(ExistingResultsError::NoRecord { path });
        }
    }
    Ok(ExistingResults::Nothing)
}

fn part(shard: Option<Shard>) -> String {
    shard.map_or_else(|| "the whole job".to_owned(), |shard| shard.to_string())
}

/// The beginning of a hash, long enough to distinguish two.
fn prefix(hash: &str) -> &str {
    hash.get(..8).unwrap_or(hash)
}

/// Largest number of displayed lines of a difference.
const SHOWN: usize = 12;

/// Lines that only one of two manifests has. Comments and spaces do not matter.
fn difference(there: &str, here: &str) -> String {
    let (there, here) = (bare(there), bare(here));
    let only = |of: &[String], other: &[String], mark: &str| -> Vec<String> {
        let lines = of.iter().filter(|line| !other.contains(line));
        lines.map(|line| format!("  {mark} {line}")).collect()
    };
    let mut lines = only(&there, &here, "-");
    lines.extend(only(&here, &there, "+"));
    if lines.is_empty() {
        return "their lines are equal, but their order or a file that they name has changed"
            .to_owned();
    }
    let more = lines.len().saturating_sub(SHOWN);
    lines.truncate(SHOWN);
    if more > 0 {
        lines.push(format!("  … and {more} more"));
    }
    format!("differences (- there, + here):\n{}", lines.join("\n"))
}

/// The lines of a manifest without comments, repeated spaces and empty lines.
fn bare(text: &str) -> Vec<String> {
    let words = |line: &str| {
        let code = line.split('#').next().unwrap_or_default();
        code.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    text.lines()
        .map(words)
        .filter(|line| !line.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_shown_without_comments() {
        let there = "# a job\n[mesh]\nhalf_gap  = \"15 um\"  # half\n\n[run]\ncycles = 3\n";
        let here = "[mesh]\nhalf_gap = \"16 um\"\n[run] # integrating\ncycles = 3\nkernel = \"volterra\"\n";
        assert_eq!(
            difference(there, here),
            "differences (- there, + here):\n  - half_gap = \"15 um\"\n  + half_gap = \"16 um\"\n  + kernel = \"volterra\""
        );
        assert!(difference(there, there).contains("a file that they name"));
        let many: String = (0..40).map(|i| format!("a{i} = 1\n")).collect();
        assert!(difference(&many, "").ends_with("… and 28 more"));
    }
}
