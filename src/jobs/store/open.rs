//! The tables of a results folder as record batches. Every table is read through this module, which first compares it
//! with its record, if the folder has records, and returns only finite numbers.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, RecordBatch};
use arrow_schema::{DataType, SchemaRef};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};

use super::StoreError;
use super::checksum::RecordedTables;
use super::error::Damage;
use super::file::FORMAT;
use crate::input;

/// Number of rows in a batch if columns are selected.
const ROWS_AT_A_TIME: usize = 8192;

/// Metadata key of the Parquet library for the schema.
const ARROW_SCHEMA: &str = "ARROW:schema";

/// Reads a table's file batch by batch.
pub(super) struct TableReader {
    path: PathBuf,
    schema: SchemaRef,
    metadata: Vec<(String, String)>,
    /// `None` after the last batch: decoders take megabytes, and a merge may have a thousand files open.
    batches: Option<ParquetRecordBatchReader>,
    /// Rows of the batches so far.
    rows: u64,
    /// Rows of the file.
    rows_in_all: u64,
}

impl TableReader {
    /// Opens a file, checked against `recorded` if the folder has a record. Reads only the named columns if names are
    /// given.
    pub(super) fn open(
        path: &Path,
        recorded: Option<RecordedTables<'_>>,
        columns: Option<&[&str]>,
    ) -> Result<Self, StoreError> {
        let file = match recorded {
            Some(recorded) => recorded.open(path)?,
            None => input::open(path).map_err(|source| StoreError::io(path, "read", source))?,
        };
        let refused = |source| StoreError::parquet(path, "read", source);
        let builder =
            decoding(path, || ParquetRecordBatchReaderBuilder::try_new(file))?.map_err(refused)?;
        let metadata: Vec<(String, String)> = builder
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .into_iter()
            .flatten()
            .filter(|pair| pair.key != ARROW_SCHEMA)
            .filter_map(|pair| Some((pair.key.clone(), pair.value.clone()?)))
            .collect();
        let format = metadata.iter().find(|(key, _)| key == "format");
        match format.map(|(_, format)| format.as_str()) {
            Some(FORMAT) => {}
            Some(other) => {
                return Err(StoreError::foreign(
                    path,
                    format!("format `{other}`, not `{FORMAT}`"),
                ));
            }
            None => return Err(StoreError::foreign(path, "it states no format")),
        }
        let schema = builder.schema().clone();
        let groups = builder.metadata().row_groups().iter();
        let rows_in_all = groups.map(|group| group.num_rows().unsigned_abs()).sum();
        let batches = decoding(path, || match columns {
            None => builder.build(),
            Some(names) => {
                // By index: a name with a dot (`mesh.half_gap`) would be taken for a path.
                let fields = schema.fields().iter().enumerate();
                let wanted = fields.filter(|(_, field)| names.contains(&field.name().as_str()));
                let places = wanted.map(|(place, _)| place);
                let mask = ProjectionMask::roots(builder.parquet_schema(), places);
                let builder = builder.with_projection(mask);
                builder.with_batch_size(ROWS_AT_A_TIME).build()
            }
        })?;
        Ok(Self {
            path: path.to_path_buf(),
            schema,
            metadata,
            batches: Some(batches.map_err(refused)?),
            rows: 0,
            rows_in_all,
        })
    }

    /// All columns of the file.
    pub(super) fn schema(&self) -> &SchemaRef {
        &self.schema
    }

    /// The file's metadata.
    pub(super) fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    /// The next rows; `None` after the last.
    pub(super) fn next(&mut self) -> Result<Option<RecordBatch>, StoreError> {
        let Some(batches) = &mut self.batches else {
            return Ok(None);
        };
        let Some(batch) = decoding(&self.path, || batches.next())? else {
            return Ok(None);
        };
        let batch = batch.map_err(|error| StoreError::parquet(&self.path, "read", error.into()))?;
        self.reject_non_finite_values(&batch)?;
        self.rows += batch.num_rows() as u64;
        if self.rows >= self.rows_in_all {
            self.batches = None;
        }
        Ok(Some(batch))
    }

    /// Refuses numbers that are not finite. A run writes nulls for them, so another program wrote the file.
    fn reject_non_finite_values(&self, batch: &RecordBatch) -> Result<(), StoreError> {
        for (field, array) in batch.schema_ref().fields().iter().zip(batch.columns()) {
            let found = match field.data_type() {
                DataType::Float64 => not_finite(array.as_ref()),
                DataType::List(_) => array.as_list_opt::<i32>().and_then(|lists| {
                    let first_not_finite =
                        |list: usize| Some((list, not_finite(&lists.value(list))?.1));
                    let suspect = not_finite(lists.values()).is_some();
                    let to_check = |&list: &usize| suspect && lists.is_valid(list);
                    (0..lists.len()).filter(to_check).find_map(first_not_finite)
                }),
                _ => None,
            };
            if let Some((row, value)) = found {
                return Err(StoreError::NotFinite {
                    path: self.path.clone(),
                    column: field.name().clone(),
                    row: self.rows + row as u64,
                    value,
                });
            }
        }
        Ok(())
    }
}

/// The first number of an array that is not finite, with its index.
fn not_finite(array: &dyn Array) -> Option<(usize, f64)> {
    let values = array.as_primitive_opt::<Float64Type>()?;
    let found = values.iter().enumerate();
    found
        .filter_map(|(row, value)| Some((row, value?)))
        .find(|(_, value)| !value.is_finite())
}

thread_local! {
    static DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is decoding a file. A panic then becomes an error that names the file, and needs no further
/// message.
pub fn is_decoding() -> bool {
    DECODING.get()
}

/// Calls the Parquet library, which panics on some files that it should refuse. Files that a run wrote do not
/// cause this. For files in a folder without a record, this function is the only protection.
fn decoding<T>(path: &Path, call: impl FnOnce() -> T) -> Result<T, StoreError> {
    DECODING.set(true);
    let decoded = catch_unwind(AssertUnwindSafe(call));
    DECODING.set(false);
    decoded.map_err(|panic| {
        let text = (panic.downcast_ref::<String>().map(String::as_str))
            .or_else(|| panic.downcast_ref::<&str>().copied());
        let reason = text
            .unwrap_or("without a word")
            .lines()
            .next()
            .unwrap_or_default();
        StoreError::Damaged {
            path: path.to_path_buf(),
            damage: Damage::Undecodable {
                reason: reason.to_owned(),
            },
        }
    })
}
