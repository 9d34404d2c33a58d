//! Rows of several files of one table brought into one file, in ascending `point_id`, every
//! value as it was.
//!
//! Each file holds its rows in ascending `point_id` and each point lies in one file, so a
//! merge of sorted sequences does; memory holds one batch a file and one row group.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::builder::{Float64Builder, ListBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{
    Array, ArrayRef, ArrowPrimitiveType, BooleanArray, PrimitiveArray, RecordBatch, StringArray,
};
use arrow_schema::DataType;
use parquet::arrow::ArrowWriter;
use tempfile::TempPath;

use super::StoreError;
use super::file::{
    GROUP_BYTES, GROUP_ROWS, Shard, TableKind, create_folder, publish, start_writer, table_path,
    temporary_file,
};
use super::open::TableReader;
use super::seal::{Hashed, Seals, TableRecord};

/// A file to take rows from.
#[derive(Debug)]
pub(super) struct Source<'a> {
    /// The file.
    pub path: PathBuf,
    /// What the record of its run says of it.
    pub seals: Seals<'a>,
    /// Points whose rows stay behind.
    pub without: &'a BTreeSet<u64>,
}

/// A table brought together, on its way to its final name.
pub(super) struct Woven {
    folder: PathBuf,
    writer: ArrowWriter<Hashed<File>>,
    temporary: TempPath,
    path: PathBuf,
    rows: u64,
}

/// The same, whole.
pub(super) struct Finished {
    woven: Woven,
    pub record: TableRecord,
}

impl Woven {
    /// Completes the file, still under its temporary name.
    pub(super) fn finish(mut self) -> Result<Finished, StoreError> {
        let refused = |source| StoreError::parquet(&self.path, "write", source);
        self.writer.finish().map_err(refused)?;
        self.writer
            .sync()
            .map_err(|source| StoreError::io(&self.path, "write", source))?;
        let written = self.writer.inner();
        let record = written.record(&self.folder, &self.path, self.rows);
        let woven = self;
        Ok(Finished { woven, record })
    }
}

impl Finished {
    /// Gives the file its final name.
    pub(super) fn publish(self) -> Result<(), StoreError> {
        let Woven {
            writer,
            temporary,
            path,
            ..
        } = self.woven;
        if let Some(parent) = path.parent() {
            create_folder(parent)?;
        }
        publish(&writer.inner().sink, temporary, &path)
    }
}

/// Brings the rows of `sources`, of which there is at least one, together in a table of
/// `folder` (of its `shard`). `met` is told of every point once, in ascending order, with the
/// number of the source it lies in and of its rows.
///
/// # Errors
/// A file cannot be read or written, is not such a table, has other columns than the first, is
/// not in ascending order, or has rows of a point that another one has as well; or what `met`
/// says.
pub(super) fn weave(
    sources: &[Source<'_>],
    folder: &Path,
    kind: TableKind,
    shard: Option<Shard>,
    mut met: impl FnMut(u64, usize, u64) -> Result<(), StoreError>,
) -> Result<Woven, StoreError> {
    let mut threads: Vec<Thread<'_>> =
        sources.iter().map(Thread::open).collect::<Result<_, _>>()?;
    let (first, others) = threads.split_first().ok_or_else(|| StoreError::Missing {
        folder: folder.to_path_buf(),
        missing: table_path(folder, kind, shard),
    })?;
    let schema = first.reader.schema().clone();
    if let Some(other) = others.iter().find(|t| *t.reader.schema() != schema) {
        let detail = format!(
            "its columns differ from those of `{}`",
            first.source.path.display()
        );
        return Err(other.foreign(detail));
    }
    create_folder(folder)?;
    let path = table_path(folder, kind, shard);
    let (file, temporary) =
        temporary_file(folder, &format!(".{}.", kind.file_name()))?.into_parts();
    let writer = start_writer(file, &path, &schema, first.reader.metadata().to_vec())?;
    let mut cloth = Cloth {
        woven: Woven {
            folder: folder.to_path_buf(),
            writer,
            temporary,
            path,
            rows: 0,
        },
        picks: Vec::new(),
        rows_in_group: 0,
    };
    let mut next: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
    for index in 0..threads.len() {
        let point = next_point(&mut threads, index, &mut cloth)?;
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
                threads[index].foreign(format!("point {point_id} stands behind point {before}"))
            });
        }
        last = Some((point_id, index));
        let mut rows = 0;
        loop {
            cloth.picks.push((index, threads[index].row));
            rows += 1;
            threads[index].row += 1;
            if cloth.is_due() {
                cloth.write(&threads)?;
            }
            match next_point(&mut threads, index, &mut cloth)? {
                Some(id) if id == point_id => {}
                Some(id) => {
                    next.push(Reverse((id, index)));
                    break;
                }
                None => break,
            }
        }
        met(point_id, index, rows)?;
    }
    cloth.write(&threads)?;
    Ok(cloth.woven)
}

/// The point of a source's next row. What was picked of a batch is written before the next
/// batch takes its place.
fn next_point(
    threads: &mut [Thread<'_>],
    index: usize,
    cloth: &mut Cloth,
) -> Result<Option<u64>, StoreError> {
    loop {
        if let Some(point_id) = threads[index].point_here()? {
            return Ok(Some(point_id));
        }
        cloth.write(threads)?;
        if !threads[index].load()? {
            return Ok(None);
        }
    }
}

/// A source being read, a batch at a time.
struct Thread<'a> {
    source: &'a Source<'a>,
    reader: TableReader,
    batch: RecordBatch,
    /// The next row of the batch.
    row: usize,
}

impl<'a> Thread<'a> {
    fn open(source: &'a Source<'a>) -> Result<Self, StoreError> {
        let reader = TableReader::open(&source.path, Some(source.seals), None)?;
        Ok(Self {
            source,
            batch: RecordBatch::new_empty(reader.schema().clone()),
            reader,
            row: 0,
        })
    }

    /// The point of the batch's next row that is taken; none behind its end.
    fn point_here(&mut self) -> Result<Option<u64>, StoreError> {
        let ids = self
            .batch
            .column_by_name("point_id")
            .and_then(|ids| ids.as_primitive_opt::<UInt64Type>())
            .filter(|ids| ids.null_count() == 0)
            .ok_or_else(|| self.foreign("it has a row without a point_id".into()))?;
        let ahead = ids.values().get(self.row..).unwrap_or_default();
        let skipped = ahead
            .iter()
            .take_while(|id| self.source.without.contains(id))
            .count();
        self.row += skipped;
        Ok(ahead.get(skipped).copied())
    }

    /// Goes on to the next batch; false when there is none.
    fn load(&mut self) -> Result<bool, StoreError> {
        let Some(batch) = self.reader.next()? else {
            return Ok(false);
        };
        self.batch = batch;
        self.row = 0;
        Ok(true)
    }

    fn foreign(&self, detail: String) -> StoreError {
        StoreError::Foreign {
            path: self.source.path.clone(),
            detail,
        }
    }
}

/// What is being written.
struct Cloth {
    woven: Woven,
    /// Source and row in its present batch of what comes next.
    picks: Vec<(usize, usize)>,
    rows_in_group: usize,
}

impl Cloth {
    /// Whether a row group is full.
    fn is_due(&self) -> bool {
        self.rows_in_group + self.picks.len() >= GROUP_ROWS
    }

    fn write(&mut self, threads: &[Thread<'_>]) -> Result<(), StoreError> {
        if self.picks.is_empty() {
            return Ok(());
        }
        let due = self.is_due();
        let schema = threads[0].reader.schema().clone();
        let columns = (0..schema.fields().len())
            .map(|column| {
                let parts: Vec<&dyn Array> = threads
                    .iter()
                    .map(|thread| thread.batch.column(column).as_ref())
                    .collect();
                gather(&parts, &self.picks).ok_or_else(|| {
                    let field = schema.field(column);
                    let (name, kind) = (field.name(), field.data_type());
                    threads[0].foreign(format!("column `{name}` is of type {kind}"))
                })
            })
            .collect::<Result<Vec<ArrayRef>, _>>()?;
        let refused = |source| StoreError::parquet(&self.woven.path, "write", source);
        let batch = RecordBatch::try_new(schema, columns).map_err(|error| refused(error.into()))?;
        let writer = &mut self.woven.writer;
        writer.write(&batch).map_err(refused)?;
        self.rows_in_group += self.picks.len();
        self.woven.rows += self.picks.len() as u64;
        self.picks.clear();
        if due || writer.in_progress_size() >= GROUP_BYTES {
            writer.flush().map_err(refused)?;
            self.rows_in_group = 0;
        }
        Ok(())
    }
}

/// Picked values (part, row) of one column; none for a type that no table has.
fn gather(parts: &[&dyn Array], picks: &[(usize, usize)]) -> Option<ArrayRef> {
    Some(match parts[0].data_type() {
        DataType::UInt64 => Arc::new(primitive::<UInt64Type>(parts, picks)?),
        DataType::UInt32 => Arc::new(primitive::<UInt32Type>(parts, picks)?),
        DataType::Float64 => Arc::new(primitive::<Float64Type>(parts, picks)?),
        DataType::Boolean => {
            let parts: Vec<_> = parts.iter().map(|p| p.as_boolean()).collect();
            let value = |&(part, row): &(usize, usize)| {
                let part = parts[part];
                part.is_valid(row).then(|| part.value(row))
            };
            Arc::new(picks.iter().map(value).collect::<BooleanArray>())
        }
        DataType::Utf8 => {
            let parts: Vec<_> = parts.iter().map(|p| p.as_string::<i32>()).collect();
            let value = |&(part, row): &(usize, usize)| {
                let part = parts[part];
                part.is_valid(row).then(|| part.value(row))
            };
            Arc::new(picks.iter().map(value).collect::<StringArray>())
        }
        DataType::List(item) if *item.data_type() == DataType::Float64 => {
            let parts: Vec<_> = parts.iter().map(|p| p.as_list::<i32>()).collect();
            let mut builder = ListBuilder::new(Float64Builder::new());
            for &(part, row) in picks {
                let part = parts[part];
                if part.is_valid(row) {
                    let list = part.value(row);
                    for value in list.as_primitive::<Float64Type>() {
                        builder.values().append_option(value);
                    }
                }
                builder.append(part.is_valid(row));
            }
            Arc::new(builder.finish())
        }
        _ => return None,
    })
}

fn primitive<T: ArrowPrimitiveType>(
    parts: &[&dyn Array],
    picks: &[(usize, usize)],
) -> Option<PrimitiveArray<T>> {
    let parts: Vec<&PrimitiveArray<T>> = parts
        .iter()
        .map(|part| part.as_primitive_opt::<T>())
        .collect::<Option<_>>()?;
    let value = |&(part, row): &(usize, usize)| {
        let part = parts[part];
        part.is_valid(row).then(|| part.value(row))
    };
    Some(picks.iter().map(value).collect())
}
