//! One Parquet file, from the first row to its final name.
//!
//! Rows are encoded in pieces and written in row groups, so one encoded group bounds the memory. The file has
//! a hidden temporary name in the folder of its destination and is renamed when complete. If it is dropped
//! before, no file remains.

use std::fmt;
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_schema::{Metadata, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use serde::{Deserialize, Serialize};
use tempfile::{NamedTempFile, TempPath};

use super::StoreError;
use super::checksum::{Hashed, TableRecord};
use super::fsync;
use super::table::Table;
use super::table_kind::TableKind;

/// Version of the column layout, stored as metadata `format`.
pub(super) const FORMAT: &str = "atlas-results-1";
/// Rows of a row group. Groups depend on the rows only, never on timing.
pub const GROUP_ROWS: usize = 16_384;
/// Number of rows that are encoded together. Encoded rows take less memory.
const PIECE_ROWS: usize = 1024;
/// Size at which a row group of long rows is written \[bytes\].
pub const GROUP_BYTES: usize = 16 << 20;

/// Suffix of an unfinished file.
const PARTIAL: &str = ".partial";

/// One part of a split job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Index from 1.
    pub index: u32,
    /// Number of shards.
    pub count: u32,
}

impl fmt::Display for Shard {
    /// `shard 1 of 2`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "shard {} of {}", self.index, self.count)
    }
}

impl Shard {
    /// The shard in file names, such as `shard-01-of-12`. The names sort by index.
    pub fn stem(&self) -> String {
        let width = self.count.to_string().len();
        format!("shard-{:0width$}-of-{}", self.index, self.count)
    }
}

/// Path of a table in a results folder: `DIR/points.parquet`, or `DIR/points.parquet/shard-i-of-n.parquet`.
pub fn table_path(folder: &Path, kind: TableKind, shard: Option<Shard>) -> PathBuf {
    let table = folder.join(kind.file_name());
    match shard {
        None => table,
        Some(shard) => table.join(format!("{}.parquet", shard.stem())),
    }
}

/// Starts a Parquet file with the fields of a schema; errors name `path`.
pub(super) fn start_writer<W: Write + Send>(
    sink: W,
    path: &Path,
    schema: &Schema,
    metadata: Vec<(String, String)>,
) -> Result<ArrowWriter<Hashed<W>>, StoreError> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        // Bounds and offsets of pages would take most of the memory in a long run.
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_created_by(format!("atlas {}", env!("CARGO_PKG_VERSION")))
        .build();
    // The metadata is written twice: pyarrow shows that of the Arrow schema, other readers that of the file.
    let schema = Schema::new(schema.fields().clone())
        .with_metadata(metadata.iter().cloned().collect::<Metadata>());
    let mut writer = ArrowWriter::try_new(Hashed::new(sink), Arc::new(schema), Some(properties))
        .map_err(|source| StoreError::parquet(path, "write", source))?;
    for (key, value) in metadata {
        writer.append_key_value_metadata(KeyValue::new(key, value));
    }
    Ok(writer)
}

/// Writes the footer of a file. No row may be written afterwards.
pub(super) fn complete<W: Write + Send>(
    writer: &mut ArrowWriter<Hashed<W>>,
    path: &Path,
) -> Result<(), StoreError> {
    let refused = |source| StoreError::parquet(path, "write", source);
    writer.finish().map_err(refused)?;
    // `ArrowWriter` buffers; its `into_inner` would turn an error of the system into text.
    let synced = writer.sync();
    synced.map_err(|source| StoreError::io(path, "write", source))
}

/// Encodes rows piece by piece into any sink, and writes them in row groups.
pub(super) struct TableWriter<R, W: Write + Send> {
    table: Table<R>,
    path: PathBuf,
    writer: ArrowWriter<Hashed<W>>,
    /// Rows not yet encoded.
    buffer: Vec<R>,
    /// Rows of the unfinished group.
    group_rows: usize,
    /// Bytes of the rows of the unfinished group.
    group_bytes: usize,
    rows: u64,
    largest_buffer: usize,
}

impl<R, W: Write + Send> TableWriter<R, W> {
    /// Starts a file. Errors name `path`. `metadata` is stored beside units and descriptions.
    pub(super) fn new(
        sink: W,
        path: PathBuf,
        table: Table<R>,
        metadata: &[(&str, String)],
    ) -> Result<Self, StoreError> {
        let entries = [
            ("format", FORMAT.to_owned()),
            ("units", serde_json::json!(table.units()).to_string()),
            (
                "descriptions",
                serde_json::json!(table.descriptions()).to_string(),
            ),
        ];
        let metadata: Vec<(String, String)> = entries
            .into_iter()
            .chain(metadata.iter().cloned())
            .map(|(key, value)| (key.to_owned(), value))
            .collect();
        let writer = start_writer(sink, &path, &table.schema(), metadata)?;
        let buffer = Vec::new();
        Ok(Self {
            table,
            path,
            writer,
            buffer,
            group_rows: 0,
            group_bytes: 0,
            rows: 0,
            largest_buffer: 0,
        })
    }

    pub(super) fn table(&self) -> &Table<R> {
        &self.table
    }

    /// Adds a row; writes a row group if it is full.
    pub(super) fn push(&mut self, row: R) -> Result<(), StoreError> {
        self.group_bytes += self.table.row_bytes(&row);
        self.group_rows += 1;
        self.buffer.push(row);
        self.rows += 1;
        self.largest_buffer = self.largest_buffer.max(self.buffer.len());
        if self.group_rows >= GROUP_ROWS || self.group_bytes >= GROUP_BYTES {
            self.flush()?;
        } else if self.buffer.len() >= PIECE_ROWS {
            self.encode()?;
        }
        Ok(())
    }

    fn encode(&mut self) -> Result<(), StoreError> {
        self.table
            .batch(&self.buffer)
            .map_err(Into::into)
            .and_then(|batch| self.writer.write(&batch))
            .map_err(|source| StoreError::parquet(&self.path, "write", source))?;
        self.buffer.clear();
        Ok(())
    }

    fn flush(&mut self) -> Result<(), StoreError> {
        if self.group_rows == 0 {
            return Ok(());
        }
        self.encode()?;
        self.writer
            .flush()
            .map_err(|source| StoreError::parquet(&self.path, "write", source))?;
        (self.group_rows, self.group_bytes) = (0, 0);
        Ok(())
    }

    /// Writes the remaining rows and the footer; returns the number of rows. No row may be pushed afterwards.
    fn finish(&mut self) -> Result<u64, StoreError> {
        self.flush()?;
        complete(&mut self.writer, &self.path)?;
        Ok(self.rows)
    }
}

/// A table that is being written, before it has its final name.
pub(super) struct UnfinishedTable<R> {
    folder: PathBuf,
    writer: TableWriter<R, File>,
    temporary: TempPath,
}

impl<R> UnfinishedTable<R> {
    /// Starts the table's file in a results folder that exists.
    pub(super) fn create(
        folder: &Path,
        kind: TableKind,
        shard: Option<Shard>,
        table: Table<R>,
        metadata: &[(&str, String)],
    ) -> Result<Self, StoreError> {
        let path = table_path(folder, kind, shard);
        check_layout(folder, kind, shard)?;
        // The file is in the results folder even for a shard: polars cannot read a folder of shards with a stray file
        // in it.
        let stem = shard.map_or_else(String::new, |shard| format!("{}.", shard.stem()));
        let (file, temporary) =
            temporary_file(folder, &format!(".{}.{stem}", kind.file_name()))?.into_parts();
        Ok(Self {
            folder: folder.to_path_buf(),
            writer: TableWriter::new(file, path, table, metadata)?,
            temporary,
        })
    }

    /// Starts a file that is not a table of a job.
    pub(super) fn create_standalone(
        folder: &Path,
        name: &str,
        table: Table<R>,
        metadata: &[(&str, String)],
    ) -> Result<Self, StoreError> {
        let (file, temporary) = temporary_file(folder, &format!(".{name}."))?.into_parts();
        Ok(Self {
            folder: folder.to_path_buf(),
            writer: TableWriter::new(file, folder.join(name), table, metadata)?,
            temporary,
        })
    }

    pub(super) fn table(&self) -> &Table<R> {
        self.writer.table()
    }

    pub(super) fn push(&mut self, row: R) -> Result<(), StoreError> {
        self.writer.push(row)
    }

    /// Completes the file and gives it its final name.
    pub(super) fn finish(self) -> Result<TableRecord, StoreError> {
        self.close()?.publish()
    }

    /// Writes the remaining rows of the table, still under its temporary name.
    pub(super) fn close(mut self) -> Result<ClosedTable, StoreError> {
        let rows = self.writer.finish()?;
        let TableWriter { path, writer, .. } = &self.writer;
        ClosedTable::new(writer.inner(), rows, &self.folder, path, self.temporary)
    }
}

/// A complete table that still has its temporary name.
pub(super) struct ClosedTable {
    pub(super) record: TableRecord,
    temporary: TempPath,
    path: PathBuf,
}

impl ClosedTable {
    /// Syncs a completed table of `folder` to the disk.
    pub(super) fn new(
        written: &Hashed<File>,
        rows: u64,
        folder: &Path,
        path: &Path,
        temporary: TempPath,
    ) -> Result<Self, StoreError> {
        let synced = written.sink.sync_all();
        synced.map_err(|source| StoreError::io(path, "write", source))?;
        Ok(Self {
            record: written.record(folder, path, rows),
            temporary,
            path: path.to_path_buf(),
        })
    }

    /// Gives the table its final name.
    pub(super) fn publish(self) -> Result<TableRecord, StoreError> {
        if let Some(parent) = self.path.parent() {
            create_folder(parent)?;
        }
        fsync::rename(self.temporary, &self.path)
            .map_err(|source| StoreError::io(&self.path, "write", source))?;
        Ok(self.record)
    }
}

/// Creates a folder and its parents.
///
/// # Errors
/// The system refuses.
pub fn create_folder(folder: &Path) -> Result<(), StoreError> {
    fsync::create_folder(folder).map_err(|source| StoreError::io(folder, "create", source))
}

/// A hidden file in `folder`, removed when dropped and locked while it is written.
pub(super) fn temporary_file(folder: &Path, prefix: &str) -> Result<NamedTempFile, StoreError> {
    partial_file(folder, prefix).map_err(|source| StoreError::io(folder, "write", source))
}

/// As [`temporary_file`], with the system's error.
pub(super) fn partial_file(folder: &Path, prefix: &str) -> io::Result<NamedTempFile> {
    let file = tempfile::Builder::new()
        .prefix(prefix)
        .suffix(PARTIAL)
        // The permissions that the user's umask allows, as for any other file.
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder)?;
    // The lock only distinguishes files in use from stale ones. On a file system without locks, stale files stay,
    // which is harmless.
    _ = file.as_file().lock_shared();
    Ok(file)
}

/// Removes unfinished files that a killed process left in `folder`: those that no process has locked. Files that cannot
/// be removed are harmless and stay.
///
/// # Errors
/// The folder cannot be listed.
pub fn remove_stale(folder: &Path) -> Result<(), StoreError> {
    let entries = fs::read_dir(folder).map_err(|source| StoreError::io(folder, "read", source))?;
    for entry in entries.flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let is_ours =
            (name.to_str()).is_some_and(|name| name.starts_with('.') && name.ends_with(PARTIAL));
        // Opening anything other than a file may wait for ever.
        if !is_ours || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        if File::open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
            _ = fs::remove_file(&path);
        }
    }
    Ok(())
}

/// Makes a complete file durable and visible under its final name.
pub(super) fn publish(file: &File, temporary: TempPath, path: &Path) -> Result<(), StoreError> {
    fsync::publish(file, temporary, path).map_err(|source| StoreError::io(path, "write", source))
}

/// A file and a folder of shards of the same name exclude each other. Check this before the work, not after it.
fn check_layout(folder: &Path, kind: TableKind, shard: Option<Shard>) -> Result<(), StoreError> {
    let path = folder.join(kind.file_name());
    let found = match (shard, path.metadata()) {
        (None, Ok(metadata)) if metadata.is_dir() => "a sharded",
        (Some(_), Ok(metadata)) if !metadata.is_dir() => "an unsharded",
        _ => return Ok(()),
    };
    Err(StoreError::OtherLayout { path, found })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{PoincareSample, SampleKind};
    use crate::store::{ResultOfPoint, poincare_table};
    use std::fs::OpenOptions;

    fn row(point_id: u64) -> ResultOfPoint<PoincareSample> {
        let result = PoincareSample {
            cycle: point_id,
            phase: 0.0,
            deflection: 1e-6,
            velocity: 2e-3,
            kind: SampleKind::Strobe,
        };
        ResultOfPoint { point_id, result }
    }

    #[test]
    fn a_full_disk_is_said_in_one_line() {
        let sink = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let path = PathBuf::from("results/flex80/poincare.parquet");
        let mut writer = TableWriter::new(sink, path, poincare_table(), &[]).unwrap();
        writer.push(row(0)).unwrap();
        let error = writer.finish().err().unwrap();
        assert!(matches!(error, StoreError::Io(_)), "{error:?}");
        assert!(
            error
                .to_string()
                .contains("results/flex80/poincare.parquet` is full")
        );
    }

    #[test]
    fn memory_is_bounded_by_one_row_group() {
        let path = PathBuf::from("poincare.parquet");
        let mut writer = TableWriter::new(io::sink(), path, poincare_table(), &[]).unwrap();
        let count = 10 * GROUP_ROWS as u64 + 1;
        let (mut first, mut later) = (0, 0);
        for point_id in 0..count {
            writer.push(row(point_id)).unwrap();
            let memory = writer.writer.memory_size();
            if point_id < GROUP_ROWS as u64 {
                first = first.max(memory);
            } else {
                later = later.max(memory);
            }
            if (point_id + 1).is_multiple_of(GROUP_ROWS as u64) {
                assert_eq!(memory, 0, "the encoder keeps nothing between row groups");
            }
        }
        assert_eq!(writer.largest_buffer, PIECE_ROWS);
        assert!(0 < first && later <= first + first / 10, "{first} {later}");
        assert_eq!(writer.writer.flushed_row_groups().len(), 10);
        assert_eq!(writer.finish().unwrap(), count);
    }

    #[test]
    fn shards_sort_by_index() {
        assert_eq!(
            Shard {
                index: 3,
                count: 12
            }
            .stem(),
            "shard-03-of-12"
        );
        assert_eq!(
            table_path(
                Path::new("r"),
                TableKind::Points,
                Some(Shard { index: 1, count: 2 })
            ),
            Path::new("r/points.parquet/shard-1-of-2.parquet")
        );
    }
}
