//! Reads a result table if it exists, and returns a table in memory as Arrow record batches for other programs,
//! with the metadata of its files.

use std::path::Path;
use std::sync::Arc;

use arrow_array::{Array, RecordBatch};
use arrow_schema::{ArrowError, Fields, Schema, SchemaRef};
use arrow_select::interleave::interleave_record_batch;

use super::{ResultTable, StoreError, TableKind};

impl ResultTable {
    /// Reads a table as [`ResultTable::read`] does; `None` if the folder has no such table.
    ///
    /// # Errors
    /// As [`ResultTable::read`], except a missing table.
    pub fn read_if_there(folder: &Path, kind: TableKind) -> Result<Option<Self>, StoreError> {
        StoreError::if_there(Self::read(folder, kind))
    }

    /// The columns that were read, as batches of one schema with the metadata of the files. Rows are copied only if
    /// rows of shards must be sorted by point.
    ///
    /// # Errors
    /// The files of the shards do not fit together.
    pub fn batches(&self) -> Result<(SchemaRef, Vec<RecordBatch>), StoreError> {
        let known = |name: &str| {
            let mut batches = self.batches.iter();
            batches.all(|batch| batch.schema_ref().column_with_name(name).is_some())
        };
        let fields: Fields = (self.fields.iter())
            .filter(|field| known(field.name()))
            .cloned()
            .collect();
        let schema = Arc::new(Schema::new_with_metadata(fields, self.metadata.clone()));
        let unfit = |error: ArrowError| self.foreign(error.to_string());
        let batches = self.batches.iter();
        let batches: Vec<RecordBatch> = batches
            .map(|batch| batch.clone().with_schema(schema.clone()).map_err(unfit))
            .collect::<Result<_, _>>()?;
        if self.order.iter().enumerate().all(|(row, at)| row == *at) {
            return Ok((schema, batches));
        }
        let places = (batches.iter().enumerate())
            .flat_map(|(batch, rows)| (0..rows.num_rows()).map(move |row| (batch, row)));
        let places: Vec<(usize, usize)> = places.collect();
        let order: Vec<(usize, usize)> = self.order.iter().map(|&row| places[row]).collect();
        let all: Vec<&RecordBatch> = batches.iter().collect();
        let sorted = interleave_record_batch(&all, &order).map_err(unfit)?;
        Ok((schema, vec![sorted]))
    }

    /// Number of rows without a value in a column; all rows if the column was not read.
    pub fn absent(&self, name: &str) -> usize {
        let of = |batch: &RecordBatch| match batch.column_by_name(name) {
            Some(column) => column.null_count(),
            None => batch.num_rows(),
        };
        self.batches.iter().map(of).sum()
    }
}
