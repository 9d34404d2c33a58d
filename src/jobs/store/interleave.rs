//! Merges the rows of several files of one table into one file, in ascending `point_id`, without changing values.
//!
//! Each file has its rows in ascending `point_id`, and the rows of a point are in one file. So a merge of sorted
//! sequences suffices; memory holds one batch per file and one row group.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::fs::File;
use std::path::{Path, PathBuf};

use arrow_array::cast::AsArray;
use arrow_array::types::UInt64Type;
use arrow_array::{Array, RecordBatch};
use arrow_select::interleave::interleave_record_batch;
use parquet::arrow::ArrowWriter;

use super::StoreError;
use super::checksum::{Hashed, RecordedTables};
use super::file::{
    ClosedTable, GROUP_BYTES, GROUP_ROWS, Shard, complete, create_folder, start_writer, table_path,
    temporary_file,
};
use super::open::TableReader;
use super::table_kind::TableKind;

/// A file whose rows are merged.
#[derive(Debug)]
pub(super) struct Source<'a> {
    /// The file.
    pub path: PathBuf,
    /// The records of its run.
    pub recorded: RecordedTables<'a>,
    /// Points whose rows are left out.
    pub without: &'a BTreeSet<u64>,
}

/// Merges the rows of at least one source into a table of `folder` (of its `shard`), still under its temporary name.
/// Calls `on_point` once for every point, in ascending order, with the index of its source and the number of its rows.
///
/// # Errors
/// A file cannot be read or written, is not a result table, has other columns than the first file, is not in ascending
/// order, or has rows of a point that another file also has; or an error of `on_point`.
pub(super) fn interleave(
    sources: &[Source<'_>],
    folder: &Path,
    kind: TableKind,
    shard: Option<Shard>,
    mut on_point: impl FnMut(u64, usize, u64) -> Result<(), StoreError>,
) -> Result<ClosedTable, StoreError> {
    let mut readers: Vec<SourceReader<'_>> = sources
        .iter()
        .map(SourceReader::open)
        .collect::<Result<_, _>>()?;
    let missing = || StoreError::missing(folder, table_path(folder, kind, shard));
    let (first, others) = readers.split_first().ok_or_else(missing)?;
    let schema = first.reader.schema().clone();
    if let Some(other) = others.iter().find(|other| *other.reader.schema() != schema) {
        let detail = format!(
            "its columns differ from the columns of `{}`",
            first.source.path.display()
        );
        return Err(other.foreign(detail));
    }
    create_folder(folder)?;
    let path = table_path(folder, kind, shard);
    let (file, temporary) =
        temporary_file(folder, &format!(".{}.", kind.file_name()))?.into_parts();
    let writer = start_writer(file, &path, &schema, first.reader.metadata().to_vec())?;
    let mut output = Interleaver {
        writer,
        path: &path,
        rows: 0,
        picks: Vec::new(),
        rows_in_group: 0,
    };
    let mut next: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
    for index in 0..readers.len() {
        let point = next_point(&mut readers, index, &mut output)?;
        next.extend(point.map(|id| Reverse((id, index))));
    }
    let mut last: Option<(u64, usize)> = None;
    while let Some(Reverse((point_id, index))) = next.pop() {
        if let Some((before, owner)) = last
            && before >= point_id
        {
            return Err(if before == point_id && owner != index {
                StoreError::PointTwice {
                    point_id,
                    paths: [owner, index].map(|i| sources[i].path.clone()),
                }
            } else {
                readers[index].foreign(format!("point {point_id} comes after point {before}"))
            });
        }
        last = Some((point_id, index));
        let mut rows = 0;
        loop {
            output.picks.push((index, readers[index].row));
            rows += 1;
            readers[index].row += 1;
            if output.is_due() {
                output.write(&readers)?;
            }
            match next_point(&mut readers, index, &mut output)? {
                Some(id) if id == point_id => {}
                Some(id) => {
                    next.push(Reverse((id, index)));
                    break;
                }
                None => break,
            }
        }
        on_point(point_id, index, rows)?;
    }
    output.write(&readers)?;
    complete(&mut output.writer, &path)?;
    ClosedTable::new(output.writer.inner(), output.rows, folder, &path, temporary)
}

/// The point of a source's next row; `None` after the last. Writes rows picked from a batch before the next batch
/// replaces it.
fn next_point(
    readers: &mut [SourceReader<'_>],
    index: usize,
    output: &mut Interleaver<'_>,
) -> Result<Option<u64>, StoreError> {
    loop {
        if let Some(point_id) = readers[index].next_point_id()? {
            return Ok(Some(point_id));
        }
        output.write(readers)?;
        if !readers[index].load()? {
            return Ok(None);
        }
    }
}

/// A source that is read batch by batch.
struct SourceReader<'a> {
    source: &'a Source<'a>,
    reader: TableReader,
    batch: RecordBatch,
    /// The next row of the batch.
    row: usize,
}

impl<'a> SourceReader<'a> {
    fn open(source: &'a Source<'a>) -> Result<Self, StoreError> {
        let reader = TableReader::open(&source.path, Some(source.recorded), None)?;
        let mut opened = Self {
            source,
            batch: RecordBatch::new_empty(reader.schema().clone()),
            reader,
            row: 0,
        };
        // A small file is read to its end and closed before the next one is opened.
        opened.load()?;
        Ok(opened)
    }

    /// The point of the batch's next row that is not left out; `None` after the last row.
    fn next_point_id(&mut self) -> Result<Option<u64>, StoreError> {
        let ids = self
            .batch
            .column_by_name("point_id")
            .and_then(|ids| ids.as_primitive_opt::<UInt64Type>())
            .filter(|ids| ids.null_count() == 0)
            .ok_or_else(|| self.foreign("it has a row without a point_id".into()))?;
        let remaining_ids = ids.values().get(self.row..).unwrap_or_default();
        let skipped = remaining_ids
            .iter()
            .take_while(|id| self.source.without.contains(id))
            .count();
        self.row += skipped;
        Ok(remaining_ids.get(skipped).copied())
    }

    /// Loads the next batch; false if there is none.
    fn load(&mut self) -> Result<bool, StoreError> {
        let Some(batch) = self.reader.next()? else {
            return Ok(false);
        };
        self.batch = batch;
        self.row = 0;
        Ok(true)
    }

    fn foreign(&self, detail: String) -> StoreError {
        StoreError::foreign(&self.source.path, detail)
    }
}

/// The output of a merge.
struct Interleaver<'a> {
    writer: ArrowWriter<Hashed<File>>,
    path: &'a Path,
    rows: u64,
    /// The rows to be written next: index of the source, and row in the source's present batch.
    picks: Vec<(usize, usize)>,
    rows_in_group: usize,
}

impl Interleaver<'_> {
    /// Whether a row group is full.
    fn is_due(&self) -> bool {
        self.rows_in_group + self.picks.len() >= GROUP_ROWS
    }

    fn write(&mut self, readers: &[SourceReader<'_>]) -> Result<(), StoreError> {
        if self.picks.is_empty() {
            return Ok(());
        }
        let due = self.is_due();
        let batches: Vec<&RecordBatch> = readers.iter().map(|reader| &reader.batch).collect();
        let refused = |source| StoreError::parquet(self.path, "write", source);
        let batch = interleave_record_batch(&batches, &self.picks)
            .map_err(|error| refused(error.into()))?;
        self.writer.write(&batch).map_err(refused)?;
        self.rows_in_group += self.picks.len();
        self.rows += self.picks.len() as u64;
        self.picks.clear();
        if due || self.writer.in_progress_size() >= GROUP_BYTES {
            self.writer.flush().map_err(refused)?;
            self.rows_in_group = 0;
        }
        Ok(())
    }
}
