//! Points of finished results exchanged for the same points computed again; every other
//! row stays as it is.
//!
//! Tables are exchanged one by one, `points.parquet` last. Doing it twice gives the same, so
//! a command that was killed amid it is simply repeated.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::Path;

use arrow_array::Array;
use arrow_array::cast::AsArray;
use arrow_array::types::UInt64Type;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::StoreError;
use super::file::{Shard, TableKind, table_path};
use super::weave::{Source, weave};

/// How the points of finished results (of a shard) ended: the points of each status.
///
/// # Errors
/// The table cannot be read or is not of this program.
pub fn statuses(
    folder: &Path,
    shard: Option<Shard>,
) -> Result<BTreeMap<String, BTreeSet<u64>>, StoreError> {
    let path = table_path(folder, TableKind::Points, shard);
    let refused = |source| StoreError::parquet(&path, "read", source);
    let foreign = || StoreError::Foreign {
        path: path.clone(),
        detail: "it has no columns point_id and status".into(),
    };
    let file = File::open(&path).map_err(|source| StoreError::io(&path, "read", source))?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(refused)?;
    let columns = ProjectionMask::columns(builder.parquet_schema(), ["point_id", "status"]);
    let reader = builder.with_projection(columns).build().map_err(refused)?;
    let mut found: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
    for batch in reader {
        let batch = batch.map_err(|error| refused(error.into()))?;
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
            found.entry(status.to_owned()).or_default().insert(*id);
        }
    }
    Ok(found)
}

/// Exchanges `points` in the results in `folder` (of a shard of a job) for those in `anew`, the
/// results of an undivided run over these points.
///
/// # Errors
/// A file cannot be read or written, or the tables have other columns than they had.
pub fn replace(
    folder: &Path,
    shard: Option<Shard>,
    points: &BTreeSet<u64>,
    anew: &Path,
) -> Result<(), StoreError> {
    let none = BTreeSet::new();
    let mut woven = Vec::new();
    for kind in TableKind::OF_A_JOB {
        let kept = Source {
            path: table_path(folder, kind, shard),
            without: points,
        };
        let added = Source {
            path: table_path(anew, kind, None),
            without: &none,
        };
        if kind == TableKind::Points || kept.path.exists() || added.path.exists() {
            woven.push(weave(
                &[kept, added],
                folder,
                kind,
                shard,
                |_, _, _| Ok(()),
            )?);
        }
    }
    woven.into_iter().try_for_each(|table| table.publish())
}
