//! What can go wrong with a result file? Each error gives the path and the remedy.

use std::io;
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use thiserror::Error;

use super::io_fault::{IoFault, Purpose, Refusal};
use super::table_kind::{FOLLOW_RECORD, RUNUP_RECORD, TRACE_RECORD, TableKind};

/// How a file differs from its record.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Damage {
    /// The file does not exist.
    #[error("it is missing, but the record of the run lists it")]
    Gone,
    /// Something other than a file has the name.
    #[error("it is not a file")]
    NoFile,
    /// No record lists the file.
    #[error("no record lists it, so the run that wrote it has not ended or was killed")]
    Unrecorded,
    /// The file was cut off or extended.
    #[error("it has {found} bytes, but {written} were written")]
    Size {
        /// Actual size.
        found: u64,
        /// Recorded size.
        written: u64,
    },
    /// The bytes of the file differ from those in the record.
    #[error(
        "its bytes differ from the written bytes (BLAKE3 {}… instead of {}…)",
        .found.get(..8).unwrap_or(found), .written.get(..8).unwrap_or(written)
    )]
    Changed {
        /// Hash of the actual bytes, hexadecimal.
        found: String,
        /// Hash in the record.
        written: String,
    },
    /// The text of a record does not match its hash.
    #[error("its text does not match the checksum at its end")]
    Unsealed,
    /// The file cannot be decoded, and there is no evidence of a change.
    #[error("the Parquet library cannot read it ({reason})")]
    Undecodable {
        /// Message of the library.
        reason: String,
    },
}

/// The file with all measurements of `atlas machine`.
pub(super) const MACHINE: &str = "machine.json";

/// The command that writes a file.
fn writer(path: &Path) -> &'static str {
    let name = path.file_name().and_then(|name| name.to_str());
    let record =
        name.and_then(|name| TableKind::named(name.strip_suffix(".parquet")?)?.command_record());
    match record.or(name) {
        Some(MACHINE) => "atlas machine",
        Some(FOLLOW_RECORD) => "atlas follow",
        Some(TRACE_RECORD) => "atlas trace",
        Some(RUNUP_RECORD) => "atlas runup",
        _ => "atlas run",
    }
}

/// The command or the option that computes a damaged file again.
fn recompute_command(path: &Path) -> &'static str {
    match writer(path) {
        // `atlas follow` always replaces its tables.
        "atlas follow" => "`atlas follow`",
        _ => "--overwrite",
    }
}

/// A result file could not be written or read.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] IoFault),
    /// A folder of shards has the name of a file to be written, or the reverse.
    #[error(
        "`{}` already holds results of {found} run: move them away, or choose another folder with --out", path.display()
    )]
    OtherLayout {
        /// The file or folder in the way.
        path: PathBuf,
        /// `a sharded` or `an unsharded`.
        found: &'static str,
    },
    /// A results folder, or a file in it, does not exist.
    #[error(
        "no results in `{}`: {} does not exist; give a folder that `{}` wrote",
        folder.display(), missing.display(), writer(missing)
    )]
    Missing {
        /// The folder given.
        folder: PathBuf,
        /// The missing file.
        missing: PathBuf,
    },
    /// The file has another format.
    #[error("`{}` is not a result file of this program ({detail}); write it again with `{}`", path.display(), writer(path))]
    Foreign {
        /// The file.
        path: PathBuf,
        /// Difference from the expected format.
        detail: String,
    },
    /// The file differs from its record or is missing.
    #[error(
        "`{}` is damaged: {damage}; restore it from a copy, or compute it again with {}",
        path.display(), recompute_command(path)
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Kind of damage.
        damage: Damage,
    },
    /// A table has a number that no run writes.
    #[error(
        "`{}` has {value} in column `{column}`, row {row} (counted from 0), which no run writes; restore \
         the file from a copy, or compute it again with --overwrite", path.display()
    )]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The row, from 0.
        row: u64,
        /// `NaN`, `inf` or `-inf`.
        value: f64,
    },
    /// A table has a point that the job does not have.
    #[error(
        "`{}` has rows of point {point_id}, but the job's {points} points are counted from 0; compute it \
         again with --overwrite", path.display()
    )]
    PointBeyond {
        /// The file.
        path: PathBuf,
        /// The point.
        point_id: u64,
        /// Points of the job.
        points: u64,
    },
    /// Another process is working in the folder.
    #[error(
        "another `atlas run` is writing here (it locks `{}`): wait for it, or choose another folder with \
         --out", path.display()
    )]
    Busy {
        /// The journal, which it has locked.
        path: PathBuf,
    },
    /// The file is not a journal, or its header is damaged.
    #[error(
        "`{}` is not a journal of this program, or its start is damaged: discard it with --overwrite, or choose \
         another folder with --out", path.display()
    )]
    ForeignJournal {
        /// The file.
        path: PathBuf,
    },
    /// The journal belongs to a run of another manifest.
    #[error(
        "`{}` keeps the points of an interrupted run of another manifest (hash {}…; this one is {}…): \
         choose another folder with --out, or discard them with --overwrite",
        path.display(), .found.get(..8).unwrap_or(found), .wanted.get(..8).unwrap_or(wanted)
    )]
    OtherJob {
        /// The journal.
        path: PathBuf,
        /// The manifest hash in the journal.
        found: String,
        /// The hash of the present job.
        wanted: String,
    },
    /// The journal was written by another build of this program, whose numbers may differ.
    #[error(
        "`{}` keeps the points of a run started with {found}, but this is {running}: finish it with that \
         program, or discard them with --overwrite", path.display()
    )]
    OtherProgram {
        /// The journal.
        path: PathBuf,
        /// Program that started the run.
        found: String,
        /// Present program.
        running: String,
    },
    /// Two columns would have the same name.
    #[error("the grid axis `{name}` has the same name as a result column")]
    AxisNameTaken {
        /// The axis.
        name: String,
    },
    /// A point was received twice, or does not belong to this job or shard.
    #[error("point {point_id} is not expected (received twice, or it belongs to another shard)")]
    UnexpectedPoint {
        /// The point.
        point_id: u64,
    },
    /// Two files of a table have rows of the same point.
    #[error(
        "point {point_id} is in `{}` and in `{}`", paths[0].display(), paths[1].display()
    )]
    PointTwice {
        /// The point.
        point_id: u64,
        /// The files.
        paths: [PathBuf; 2],
    },
    /// The Parquet library refused.
    #[error("cannot {action} `{}`", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// `read` or `write`.
        action: &'static str,
        /// The library's error.
        source: ParquetError,
    },
}

impl StoreError {
    /// Whether the contents of the folder, or the axes of the job, are the reason rather than the system. Nothing was
    /// changed then. False for files that are missing or of another format.
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::Io(IoFault {
                refusal: Refusal::NotADirectory | Refusal::SymbolicLink,
                ..
            }) | Self::OtherLayout { .. }
                | Self::Busy { .. }
                | Self::ForeignJournal { .. }
                | Self::OtherJob { .. }
                | Self::OtherProgram { .. }
                | Self::PointTwice { .. }
                | Self::PointBeyond { .. }
                | Self::Damaged { .. }
                | Self::NotFinite { .. }
                | Self::AxisNameTaken { .. }
        )
    }

    /// The error for a file that this program did not write, or not in this form.
    pub(crate) fn foreign(path: &Path, detail: impl Into<String>) -> Self {
        Self::Foreign {
            path: path.to_path_buf(),
            detail: detail.into(),
        }
    }

    /// The error for a file that is missing from a folder.
    pub fn missing(folder: &Path, missing: PathBuf) -> Self {
        let folder = folder.to_path_buf();
        Self::Missing { folder, missing }
    }

    /// The result of `read`; `None` if the file is missing.
    ///
    /// # Errors
    /// Those of `read`, except [`StoreError::Missing`].
    pub fn if_there<T>(read: Result<T, Self>) -> Result<Option<T>, Self> {
        match read {
            Err(Self::Missing { .. }) => Ok(None),
            read => read.map(Some),
        }
    }

    /// A failure of the operating system with a result file.
    pub fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        IoFault::new(path, action, Purpose::Results, source).into()
    }

    /// A failure of the Parquet library, which may wrap an error of the system.
    pub(crate) fn parquet(path: &Path, action: &'static str, source: ParquetError) -> Self {
        let source = match source {
            ParquetError::External(inner) => match inner.downcast::<io::Error>() {
                Ok(error) => return Self::io(path, action, *error),
                Err(inner) => ParquetError::External(inner),
            },
            source => source,
        };
        Self::Parquet {
            path: path.to_path_buf(),
            action,
            source,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_what_its_own_command_writes() {
        for (file, command) in [
            ("machine.json", "`atlas machine`"),
            ("run.json", "`atlas run`"),
            ("follow.json", "`atlas follow`"),
            ("branches.parquet", "`atlas follow`"),
            ("trace.json", "`atlas trace`"),
            ("events.parquet", "`atlas trace`"),
            ("runup.json", "`atlas runup`"),
            ("levels.parquet", "`atlas runup`"),
        ] {
            let missing = StoreError::Missing {
                folder: "there".into(),
                missing: Path::new("there").join(file),
            };
            let foreign = StoreError::Foreign {
                path: Path::new("there").join(file),
                detail: "not JSON".to_owned(),
            };
            for error in [missing, foreign] {
                assert!(error.to_string().contains(command), "{error}");
            }
        }
    }
}
