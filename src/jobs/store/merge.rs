//! Joins the shards of a job into the tables that one run over all points would have written, with a record of their
//! origin.
//!
//! No table appears in the output folder before all shards are found, each point occurs once, and all tables
//! are read. The inputs are only read.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::checksum::RecordedTables;
use super::file::{ClosedTable, create_folder, remove_stale, table_path};
use super::interleave::{Source, interleave};
use super::run::{
    KernelRecord, RunRecord, RunState, ShardRecord, Totals, mixed_instructions_warning,
};
use super::table_kind::TableKind;
use super::{StoreError, read_runs, write_run};

/// Why shards cannot be joined.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A folder without results.
    #[error("no finished run in `{}`; give folders that `atlas run --shard` wrote", folder.display())]
    NoRun {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder with a whole job.
    #[error("`{}` holds the whole job, so there is nothing to join", folder.display())]
    Whole {
        /// The folder.
        folder: PathBuf,
    },
    /// Shards that do not belong together.
    #[error(
        "`{}` and `{}` cannot be joined: {what} differs ({}; {})",
        folders[0].display(), folders[1].display(), found[0], found[1]
    )]
    Unlike {
        /// The folders.
        folders: [PathBuf; 2],
        /// `the manifest`, `the program` or `the number of shards`.
        what: &'static str,
        /// The value in each.
        found: [String; 2],
    },
    /// A shard that occurs twice.
    #[error(
        "shard {index} of {count} is in `{}` and in `{}`: give only one of them",
        folders[0].display(), folders[1].display()
    )]
    Twice {
        /// Index of the shard.
        index: u32,
        /// Number of shards.
        count: u32,
        /// The folders with this shard.
        folders: [PathBuf; 2],
    },
    /// Missing shards.
    #[error(
        "of {count} shards, these are missing: {}; run them with --shard i/{count}",
        list(missing, missing.len() as u64)
    )]
    Missing {
        /// Number of shards.
        count: u32,
        /// Indices of the missing shards.
        missing: Vec<u64>,
    },
    /// A shard that was interrupted.
    #[error(
        "shard {index} of {count} in `{}` was interrupted and {points} of its points are missing; repeat \
         its command", folder.display()
    )]
    Interrupted {
        /// Index of the shard.
        index: u32,
        /// Number of shards.
        count: u32,
        /// The folder with this shard.
        folder: PathBuf,
        /// Points that were not computed.
        points: u64,
    },
    /// A table whose number of points differs from its record.
    #[error("`{}` has {found} points, but its record lists {wanted}; run the shard again with --overwrite", path.display())]
    Count {
        /// The table.
        path: PathBuf,
        /// Points in it.
        found: u64,
        /// Points of the shard.
        wanted: u64,
    },
    /// Points that no shard has.
    #[error("no shard has these points: {}", list(missing, *all))]
    PointsMissing {
        /// The first missing points.
        missing: Vec<u64>,
        /// Number of missing points.
        all: u64,
    },
    /// The output folder is in use.
    #[error("`{}` is not empty; choose another folder with --out", folder.display())]
    OutputInUse {
        /// The folder.
        folder: PathBuf,
    },
    /// A file cannot be read or written, or has another format.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Largest number of entries in an error's list.
const LISTED: usize = 8;

/// The first entries of a list, and the total if there are more.
fn list(numbers: &[u64], all: u64) -> String {
    let texts: Vec<String> = numbers.iter().take(LISTED).map(u64::to_string).collect();
    let mut text = texts.join(", ");
    if all > LISTED as u64 {
        text += &format!(" … ({all} in all)");
    }
    text
}

/// A shard and the folder it lies in.
struct Part {
    folder: PathBuf,
    index: u32,
    count: u32,
    record: RunRecord,
}

impl Part {
    fn recorded(&self) -> RecordedTables<'_> {
        RecordedTables {
            folder: &self.folder,
            tables: &self.record.tables,
        }
    }
}

/// Joins the shards in `folders` into `out`, which must be empty or not exist. Each folder contains shards, or folders
/// with shards. Returns the record of the whole job.
///
/// # Errors
/// Shards are missing, unfinished, doubled or of different jobs; a point is missing or doubled; a file cannot be read
/// or written.
pub fn merge(folders: &[PathBuf], out: &Path) -> Result<RunRecord, MergeError> {
    let parts = parts(folders)?;
    prepare_output(out)?;
    let tables = tables(&parts, out)?;
    let mut record = record(&parts);
    record.tables = (tables.into_iter())
        .map(ClosedTable::publish)
        .collect::<Result<_, _>>()?;
    write_run(out, &record)?;
    Ok(record)
}

/// The shards of one job, complete and in order.
fn parts(folders: &[PathBuf]) -> Result<Vec<Part>, MergeError> {
    let mut parts: BTreeMap<u32, Part> = BTreeMap::new();
    for given in folders {
        for (folder, record) in records_below(given)? {
            let shard = record.shard.ok_or_else(|| MergeError::Whole {
                folder: folder.clone(),
            })?;
            let part = Part {
                folder: folder.clone(),
                index: shard.index,
                count: shard.count,
                record,
            };
            if let Some(first) = parts.values().next() {
                check_same_job(first, &part)?;
            }
            if let Some(there) = parts.get(&part.index) {
                return Err(MergeError::Twice {
                    index: part.index,
                    count: part.count,
                    folders: [there.folder.clone(), part.folder],
                });
            }
            parts.insert(part.index, part);
        }
    }
    let count = parts.values().next().map_or(0, |part| part.count);
    let missing: Vec<u64> = (1..=count)
        .filter(|index| !parts.contains_key(index))
        .map(u64::from)
        .collect();
    if !missing.is_empty() {
        return Err(MergeError::Missing { count, missing });
    }
    let parts: Vec<Part> = parts.into_values().collect();
    match parts.iter().find(|p| p.record.state != RunState::Complete) {
        Some(part) => Err(MergeError::Interrupted {
            index: part.index,
            count,
            folder: part.folder.clone(),
            points: part.record.totals.missing,
        }),
        None => Ok(parts),
    }
}

/// The records of a folder, or else of its subfolders, with their paths.
fn records_below(folder: &Path) -> Result<Vec<(PathBuf, RunRecord)>, MergeError> {
    let records_of = |folder: &Path| -> Result<Vec<(PathBuf, RunRecord)>, StoreError> {
        let records = read_runs(folder)?.into_iter();
        Ok(records
            .map(|record| (folder.to_path_buf(), record))
            .collect())
    };
    let mut records = Vec::new();
    if folder.is_dir() {
        records = records_of(folder)?;
        let read_error = |error| StoreError::io(folder, "read", error);
        if records.is_empty() {
            for entry in fs::read_dir(folder).map_err(read_error)? {
                let subfolder = entry.map_err(read_error)?.path();
                if subfolder.is_dir() {
                    records.extend(records_of(&subfolder)?);
                }
            }
        }
    }
    if records.is_empty() {
        Err(MergeError::NoRun {
            folder: folder.to_path_buf(),
        })
    } else {
        Ok(records)
    }
}

/// Checks that two shards belong to the same split of one job by one program.
fn check_same_job(first: &Part, other: &Part) -> Result<(), MergeError> {
    let facts = |part: &Part| {
        [
            ("the manifest", part.record.manifest_hash.clone()),
            ("the program", part.record.program.to_string()),
            ("the number of shards", part.count.to_string()),
        ]
    };
    for ((what, a), (_, b)) in facts(first).into_iter().zip(facts(other)) {
        if a != b {
            return Err(MergeError::Unlike {
                folders: [first.folder.clone(), other.folder.clone()],
                what,
                found: [a, b],
            });
        }
    }
    Ok(())
}

/// Refuses a folder that contains anything except remains of a killed merge, so that no other result and no input can
/// be overwritten.
fn prepare_output(out: &Path) -> Result<(), MergeError> {
    match fs::read_dir(out) {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(create_folder(out)?),
        Err(error) => return Err(StoreError::io(out, "read", error).into()),
    }
    remove_stale(out)?;
    if fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_none()) {
        Ok(())
    } else {
        Err(MergeError::OutputInUse {
            folder: out.to_path_buf(),
        })
    }
}

/// All tables of the job, completely read and not yet published; the points are checked.
fn tables(parts: &[Part], out: &Path) -> Result<Vec<ClosedTable>, MergeError> {
    let none = BTreeSet::new();
    let points = (parts.iter()).fold(0_u64, |sum, part| {
        sum.saturating_add(part.record.totals.points)
    });
    let mut joined = Vec::new();
    for kind in TableKind::OF_A_JOB {
        let sources: Vec<Source<'_>> = (parts.iter())
            .map(|part| Source {
                path: table_path(&part.folder, kind, part.record.shard),
                recorded: part.recorded(),
                without: &none,
            })
            .collect();
        let lists_table = |source: &Source<'_>| source.recorded.lists(&source.path);
        if kind != TableKind::Points && !sources.iter().any(lists_table) {
            continue;
        }
        let mut census = Census::new(parts.len());
        let count_point = |point_id, part: usize, rows| {
            if point_id >= points {
                return Err(StoreError::PointBeyond {
                    path: sources[part].path.clone(),
                    point_id,
                    points,
                });
            }
            census.count(point_id, part, rows);
            Ok(())
        };
        joined.push(interleave(&sources, out, kind, None, count_point)?);
        if kind == TableKind::Points {
            census.check(parts, &sources)?;
        }
    }
    Ok(joined)
}

/// Counts the points and rows of a merge.
struct Census {
    /// The next expected point.
    next: u64,
    /// The first missing points.
    missing: Vec<u64>,
    /// Number of points so far.
    points: u64,
    /// Number of rows in each part.
    rows: Vec<u64>,
}

impl Census {
    fn new(parts: usize) -> Self {
        Self {
            next: 0,
            missing: Vec::new(),
            points: 0,
            rows: vec![0; parts],
        }
    }

    fn count(&mut self, point_id: u64, part: usize, rows: u64) {
        let open = LISTED - self.missing.len();
        self.missing.extend((self.next..point_id).take(open));
        self.next = point_id + 1;
        self.points += 1;
        self.rows[part] += rows;
    }

    fn check(self, parts: &[Part], sources: &[Source<'_>]) -> Result<(), MergeError> {
        for ((part, source), found) in parts.iter().zip(sources).zip(self.rows) {
            let wanted = part.record.totals.points;
            if found != wanted {
                return Err(MergeError::Count {
                    path: source.path.clone(),
                    found,
                    wanted,
                });
            }
        }
        if self.missing.is_empty() {
            Ok(())
        } else {
            Err(MergeError::PointsMissing {
                all: self.next - self.points,
                missing: self.missing,
            })
        }
    }
}

/// The record of the whole job: machine and manifest of the first shard, and sums over all shards.
fn record(parts: &[Part]) -> RunRecord {
    let mut whole = parts[0].record.clone();
    whole.shard = None;
    let (mut totals, mut warnings) = (Totals::default(), Vec::new());
    for part in parts {
        let record = &part.record;
        totals.add(&record.totals);
        whole.started = whole.started.min(record.started.clone());
        whole.finished = whole.finished.max(record.finished.clone());
        for warning in &record.warnings {
            if !warnings.contains(warning) {
                warnings.push(warning.clone());
            }
        }
        if part.index > 1 {
            whole.retries.extend(record.retries.iter().cloned());
            KernelRecord::join(&mut whole.kernels, &record.kernels);
        }
        whole.shards.extend(record.shard.map(|shard| ShardRecord {
            shard,
            started: record.started.clone(),
            finished: record.finished.clone(),
            machine: record.machine.clone(),
            placement: record.placement.clone(),
            totals: record.totals.clone(),
        }));
    }
    let used = &mut whole.machine.instructions;
    for part in parts {
        let instructions = part.record.machine.instructions.iter();
        for name in instructions {
            if !used.contains(name) {
                used.push(name.clone());
            }
        }
    }
    warnings.extend(mixed_instructions_warning(used).filter(|warning| !warnings.contains(warning)));
    whole.totals = totals;
    whole.warnings = warnings;
    whole.placement.threads_asked = None;
    whole.placement.threads = parts.iter().map(|p| p.record.placement.threads).sum();
    whole.placement.asked = format!("joined from {} shards with separate values", parts.len());
    whole.placement.obtained = "see each shard".into();
    whole.placement.copies_asked = whole.placement.asked.clone();
    whole.placement.copies_obtained = whole.placement.obtained.clone();
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Shard;

    #[test]
    fn shards_of_unlike_processors_are_joined_with_a_warning() {
        let part = |index: u32, instructions: &str| {
            let mut record = crate::store::run::tests::record(Some(Shard { index, count: 2 }));
            record.machine.instructions = vec![instructions.to_owned()];
            Part {
                folder: PathBuf::new(),
                index,
                count: 2,
                record,
            }
        };
        let whole = record(&[part(1, "avx512"), part(2, "baseline")]);
        assert_eq!(whole.machine.instructions, ["avx512", "baseline"]);
        let note = whole
            .warnings
            .iter()
            .find(|w| w.contains("different instructions"));
        assert!(
            note.is_some_and(|note| note.contains("avx512, baseline")),
            "{:?}",
            whole.warnings
        );
        let each = whole
            .shards
            .iter()
            .map(|shard| &shard.machine.instructions[0]);
        assert_eq!(each.collect::<Vec<_>>(), ["avx512", "baseline"]);
        let whole = record(&[part(1, "avx512"), part(2, "avx2")]);
        assert!(whole.warnings.iter().all(|w| !w.contains("instructions")));
    }
}
