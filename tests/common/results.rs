//! Result tables as text, for bitwise comparisons of runs.

// Every test binary uses a part of it.
#![allow(dead_code, clippy::unwrap_used)]

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::UInt64Type;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// Columns that depend on place and time of the computation.
const PLACEMENT: [&str; 3] = ["wall_time", "worker", "numa_node"];

/// A table without its placement columns, in ascending `point_id` and, within a point, in the written order; one line
/// per row. Nulls stay nulls, numbers keep their bits.
pub fn physics(folder: &Path, table: &str) -> String {
    let path = folder.join(table);
    let mut files = vec![path.clone()];
    if path.is_dir() {
        files = fs::read_dir(&path)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
    }
    let mut rows: Vec<(u64, String)> = Vec::new();
    for file in files {
        let mut last = None;
        for batch in batches(&file) {
            for (row, id) in ids(&batch).into_iter().enumerate() {
                assert!(last <= Some(id), "rows are in point_id order");
                last = Some(id);
                rows.push((id, row_text(&batch, row)));
            }
        }
    }
    rows.sort_by_key(|row| row.0);
    let lines: Vec<String> = rows.into_iter().map(|(_, line)| line).collect();
    lines.join("\n")
}

/// The `point_id`s of a file, in its order.
pub fn file_ids(file: &Path) -> Vec<u64> {
    batches(&file.to_path_buf()).iter().flat_map(ids).collect()
}

fn batches(file: &PathBuf) -> Vec<RecordBatch> {
    let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(file).unwrap()).unwrap();
    reader
        .build()
        .unwrap()
        .map(|batch| batch.unwrap())
        .collect()
}

fn ids(batch: &RecordBatch) -> Vec<u64> {
    batch
        .column(0)
        .as_primitive::<UInt64Type>()
        .values()
        .to_vec()
}

/// Rust prints the shortest decimal number that gives the same bits back.
fn row_text(batch: &RecordBatch, row: usize) -> String {
    let schema = batch.schema();
    let fields = schema.fields().iter().zip(batch.columns());
    fields
        .filter(|(field, _)| !PLACEMENT.contains(&field.name().as_str()))
        .map(|(field, column)| format!("{}={:?}", field.name(), column.slice(row, 1)))
        .collect()
}

/// Asserts that tables of two results folders are equal.
pub fn assert_same(tables: &[&str], a: &Path, b: &Path) {
    for table in tables {
        let (left, right) = (physics(a, table), physics(b, table));
        assert!(!left.is_empty());
        assert!(
            left == right,
            "{table} of {} and {}",
            a.display(),
            b.display()
        );
    }
}
