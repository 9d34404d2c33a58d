//! Arrow IPC files (Feather, version 2): a table in its memory layout, for Julia, R and other programs with Arrow.
//!
//! Columns keep their types, lists stay lists, absent values are null. Units and descriptions are in the
//! metadata of the schema and of the columns, as in the result files. The files are uncompressed, so that
//! programs can map them into memory.

use super::error::ExportError;
use super::survey::Surveyed;
use crate::store::{AtomicFile, ResultTable};
use arrow_ipc::writer::FileWriter;
use arrow_schema::{ArrowError, FieldRef, Schema};
use std::io::BufWriter;
use std::path::Path;

/// Writes the surveyed columns of a table to `path`, batch by batch.
pub fn write(folder: &Path, table: &Surveyed, path: &Path) -> Result<(), ExportError> {
    let refused = |source: ArrowError| ExportError::Arrow {
        path: path.to_path_buf(),
        source,
    };
    let names: Vec<&str> = (table.columns.iter())
        .map(|column| column.head.name.as_str())
        .collect();
    let (all, _) = ResultTable::head(folder, table.kind)?.batches()?;
    let chosen = |field: &&FieldRef| names.contains(&field.name().as_str());
    let fields: Vec<FieldRef> = all.fields().iter().filter(chosen).cloned().collect();
    let schema = Schema::new_with_metadata(fields, all.metadata().clone());
    let file = AtomicFile::create(path)?;
    let sink = BufWriter::with_capacity(1 << 20, file.file());
    let mut writer = FileWriter::try_new(sink, &schema).map_err(refused)?;
    ResultTable::scan(folder, table.kind, &names, |rows| {
        for batch in rows.batches()?.1 {
            writer.write(&batch).map_err(refused)?;
        }
        Ok::<_, ExportError>(())
    })?;
    writer.finish().map_err(refused)?;
    drop(writer);
    Ok(file.publish()?)
}
