//! Replaces points of finished results by the same points computed again, without changing other rows.
//!
//! Tables are replaced one by one, `points.parquet` last. A repeated replacement gives the same result, so a
//! killed command can be repeated. During the replacement, the record lists the old and the new tables.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use arrow_array::Array;
use arrow_array::cast::AsArray;
use arrow_array::types::UInt64Type;

use super::StoreError;
use super::checksum::{RecordedTables, TableRecord};
use super::file::{ClosedTable, Shard, table_path};
use super::interleave::{Source, interleave};
use super::open::TableReader;
use super::table_kind::TableKind;

/// The points of each status in finished results (of a shard). `tables` has the records of all their tables.
///
/// # Errors
/// The table cannot be read, is not of this program, or is not what was written.
pub fn statuses(
    folder: &Path,
    shard: Option<Shard>,
    tables: &[TableRecord],
) -> Result<BTreeMap<String, BTreeSet<u64>>, StoreError> {
    let path = table_path(folder, TableKind::Points, shard);
    let foreign = || StoreError::foreign(&path, "it does not have the columns point_id and status");
    let recorded = Some(RecordedTables { folder, tables });
    let mut reader = TableReader::open(&path, recorded, Some(&["point_id", "status"]))?;
    let mut points_by_status: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
    while let Some(batch) = reader.next()? {
        let ids = batch
            .column_by_name("point_id")
            .and_then(|ids| ids.as_primitive_opt::<UInt64Type>())
            .filter(|ids| ids.null_count() == 0)
            .ok_or_else(foreign)?;
        let statuses = batch
            .column_by_name("status")
            .and_then(|statuses| statuses.as_string_opt::<i32>())
            .ok_or_else(foreign)?;
        for (id, status) in ids.values().iter().zip(statuses) {
            let status = status.ok_or_else(foreign)?;
            points_by_status
                .entry(status.to_owned())
                .or_default()
                .insert(*id);
        }
    }
    Ok(points_by_status)
}

/// Points of finished results, and their replacements.
#[derive(Debug, Clone, Copy)]
pub struct Exchange<'a> {
    /// The results that change (of a shard of a job).
    pub folder: &'a Path,
    /// The part of a split job.
    pub shard: Option<Shard>,
    /// Tables of the results that change.
    pub tables: &'a [TableRecord],
    /// Ids of the points that are replaced.
    pub points: &'a BTreeSet<u64>,
    /// The results of an undivided run over these points.
    pub new_folder: &'a Path,
    /// Tables of the new results.
    pub added: &'a [TableRecord],
}

/// Replaces points and returns the new tables. Calls `announce` with them before the first file changes, so that after
/// a kill the mixture of old and new tables can be recognised.
///
/// # Errors
/// A file cannot be read or written, the columns of the tables have changed, or an error of `announce`.
pub fn replace(
    exchange: Exchange<'_>,
    announce: impl FnOnce(&[TableRecord]) -> Result<(), StoreError>,
) -> Result<Vec<TableRecord>, StoreError> {
    let Exchange { folder, shard, .. } = exchange;
    let none = BTreeSet::new();
    let old = RecordedTables {
        folder,
        tables: exchange.tables,
    };
    let new = RecordedTables {
        folder: exchange.new_folder,
        tables: exchange.added,
    };
    let mut joined = Vec::new();
    for kind in TableKind::OF_A_JOB {
        let kept = Source {
            path: table_path(folder, kind, shard),
            recorded: old,
            without: exchange.points,
        };
        let added = Source {
            path: table_path(exchange.new_folder, kind, None),
            recorded: new,
            without: &none,
        };
        if old.lists(&kept.path) || new.lists(&added.path) {
            let sources = [kept, added];
            joined.push(interleave(&sources, folder, kind, shard, |_, _, _| Ok(()))?);
        }
    }
    let tables: Vec<TableRecord> = joined.iter().map(|table| table.record.clone()).collect();
    announce(&tables)?;
    joined.into_iter().map(ClosedTable::publish).collect()
}
