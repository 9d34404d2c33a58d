//! Reads a results folder back: tables by column, and the run records.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{Array, RecordBatch};
use arrow_schema::{DataType, FieldRef, Fields};
use serde::de::DeserializeOwned;
use strum::VariantArray;

use super::checksum::{RecordedTables, TableRecord, is_sealed};
use super::command_record::TablesRecord;
use super::error::Damage;
use super::open::TableReader;
use super::table::ELEMENTS;
use super::table_kind::TableKind;
use super::{RunRecord, StoreError};
use crate::input::{self, printable};

/// Largest run record that is read \[bytes\]: a manifest, and a few hundred bytes per shard.
const MOST_RECORD: u64 = 256 << 20;

/// Type of a column's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Whole numbers.
    Whole,
    /// Numbers.
    Number,
    /// Truth values.
    Truth,
    /// Texts.
    Text,
    /// Lists of numbers.
    List,
}

/// Names of the elements of a column's lists, printable.
fn elements(field: &FieldRef) -> Vec<String> {
    let text = field.metadata().get(ELEMENTS);
    let names: Vec<String> = text
        .and_then(|text| serde_json::from_str(text).ok())
        .unwrap_or_default();
    let fit = |name: &String| printable(name).into_owned();
    names.iter().map(fit).collect()
}

/// A column's name, unit, description and type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnHead {
    /// Name.
    pub name: String,
    /// SI unit; `1` if dimensionless, empty for text and truth values.
    pub unit: String,
    /// One sentence.
    pub description: String,
    /// Type of its values.
    pub kind: ColumnKind,
    /// Names of the elements of its lists; empty if they are only numbered.
    pub elements: Vec<String>,
}

/// A table in memory: one file, or all shards in the order of their names.
#[derive(Debug, Clone)]
pub struct ResultTable {
    path: PathBuf,
    pub(super) batches: Vec<RecordBatch>,
    pub(super) metadata: BTreeMap<String, String>,
    /// All columns of its files, including those that were not read.
    pub(super) fields: Fields,
    /// Indices of the rows in the order in which columns return them. [`Self::read`] sorts the rows of a run by
    /// ascending `point_id`; otherwise it is the order of the files.
    pub(super) order: Vec<usize>,
}

impl ResultTable {
    /// Reads a table of a results folder, and checks its files against the records of the folder, if there are any.
    ///
    /// # Errors
    /// The folder or the table does not exist, cannot be read, is of another program, or was changed.
    pub fn read(folder: &Path, kind: TableKind) -> Result<Self, StoreError> {
        let mut table = Self::at(folder, kind);
        table.walk(folder, kind, None, |table, mut reader| {
            while let Some(batch) = reader.next()? {
                table.batches.push(batch);
            }
            Ok::<_, StoreError>(())
        })?;
        let rows = table.batches.iter().map(RecordBatch::num_rows).sum();
        table.order = (0..rows).collect();
        // Traced samples stay in order of time, and orbits in the order of their branch.
        if kind.command_record().is_none() {
            let ids = table.u64("point_id")?;
            table.order.sort_by_key(|&row| ids[row]);
        }
        Ok(table)
    }

    /// A table's metadata and columns, without its rows.
    ///
    /// # Errors
    /// As [`ResultTable::read`].
    pub fn head(folder: &Path, kind: TableKind) -> Result<Self, StoreError> {
        let mut table = Self::at(folder, kind);
        table.walk(folder, kind, Some(&[]), |_, _| Ok::<_, StoreError>(()))?;
        Ok(table)
    }

    /// Passes the rows of a table to `each`, some thousand at a time, with only the named columns, in the order of its
    /// files.
    ///
    /// # Errors
    /// As [`ResultTable::read`], or an error of `each`.
    pub fn scan<E: From<StoreError>>(
        folder: &Path,
        kind: TableKind,
        columns: &[&str],
        mut each: impl FnMut(&Self) -> Result<(), E>,
    ) -> Result<(), E> {
        Self::at(folder, kind).walk(folder, kind, Some(columns), |part, mut reader| {
            while let Some(batch) = reader.next()? {
                part.order = (0..batch.num_rows()).collect();
                part.batches = vec![batch];
                each(part)?;
            }
            Ok(())
        })
    }

    /// A table of a folder before anything is read.
    fn at(folder: &Path, kind: TableKind) -> Self {
        Self {
            path: folder.join(kind.file_name()),
            batches: Vec::new(),
            metadata: BTreeMap::new(),
            fields: Fields::empty(),
            order: Vec::new(),
        }
    }

    /// Opens the files of the table in turn, checks each against the records of the folder, if there are any, and reads
    /// its metadata.
    fn walk<E: From<StoreError>>(
        &mut self,
        folder: &Path,
        kind: TableKind,
        columns: Option<&[&str]>,
        mut each: impl FnMut(&mut Self, TableReader) -> Result<(), E>,
    ) -> Result<(), E> {
        let tables = recorded(folder, kind)?;
        let recorded = (tables.as_deref()).map(|tables| RecordedTables { folder, tables });
        for file in parts(folder, &self.path, recorded)? {
            let reader = TableReader::open(&file, recorded, columns)?;
            let metadata: BTreeMap<String, String> = reader.metadata().iter().cloned().collect();
            if !self.metadata.is_empty() && metadata.get("units") != self.metadata.get("units") {
                let detail = "its columns differ from the columns of the other shards";
                Err(StoreError::foreign(&file, detail))?;
            }
            self.metadata = metadata;
            self.fields = reader.schema().fields().clone();
            each(self, reader)?;
        }
        Ok(())
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.order.len()
    }

    /// Names of the grid's axes, slowest first.
    ///
    /// # Errors
    /// The file does not have them.
    pub fn axes(&self) -> Result<Vec<String>, StoreError> {
        self.json("axes")
    }

    /// Units of the axes in the manifest, by name; empty if the file does not have them.
    pub fn axis_units(&self) -> BTreeMap<String, String> {
        self.json("axis_units").unwrap_or_default()
    }

    /// SI unit of every column, by name.
    ///
    /// # Errors
    /// The file does not have them.
    pub fn units(&self) -> Result<BTreeMap<String, String>, StoreError> {
        self.json("units")
    }

    /// The columns of its files, in order, including those that were not read.
    ///
    /// # Errors
    /// The file has no units, or a column of an unknown type.
    pub fn columns(&self) -> Result<Vec<ColumnHead>, StoreError> {
        let units = self.units()?;
        let descriptions: BTreeMap<String, String> = self.json("descriptions")?;
        let of = |texts: &BTreeMap<String, String>, name: &str| {
            texts
                .get(name)
                .map(|text| printable(text).into_owned())
                .unwrap_or_default()
        };
        let head = |field: &FieldRef| {
            let name = field.name();
            let kind = match field.data_type() {
                DataType::UInt64 | DataType::UInt32 => ColumnKind::Whole,
                DataType::Float64 => ColumnKind::Number,
                DataType::Boolean => ColumnKind::Truth,
                DataType::Utf8 => ColumnKind::Text,
                DataType::List(_) => ColumnKind::List,
                other => {
                    return Err(self.foreign(format!("column `{name}` has the wrong type {other}")));
                }
            };
            Ok(ColumnHead {
                unit: of(&units, name),
                description: of(&descriptions, name),
                name: name.clone(),
                kind,
                elements: elements(field),
            })
        };
        self.fields.iter().map(head).collect()
    }

    /// A text of the file's metadata, such as `job`, or `half_gap` of a trace.
    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.metadata.get(key).map(String::as_str)
    }

    fn json<T: DeserializeOwned>(&self, key: &str) -> Result<T, StoreError> {
        self.metadata
            .get(key)
            .and_then(|text| serde_json::from_str(text).ok())
            .ok_or_else(|| self.foreign(format!("no `{key}` in its metadata")))
    }

    /// A column of whole numbers, in the order of the rows; `None` for a null.
    ///
    /// # Errors
    /// No such column, or of another type.
    pub fn u64(&self, name: &str) -> Result<Vec<Option<u64>>, StoreError> {
        self.column(name, |array| match array.data_type() {
            DataType::UInt64 => Some(array.as_primitive::<UInt64Type>().iter().collect()),
            DataType::UInt32 => {
                let values = array.as_primitive::<UInt32Type>().iter();
                Some(values.map(|value| value.map(u64::from)).collect())
            }
            _ => None,
        })
    }

    /// A column of numbers, in the order of the rows; `None` for a null.
    ///
    /// # Errors
    /// No such column, or of another type.
    pub fn f64(&self, name: &str) -> Result<Vec<Option<f64>>, StoreError> {
        self.column(name, |array| {
            Some(array.as_primitive_opt::<Float64Type>()?.iter().collect())
        })
    }

    /// A column of truth values, in the order of the rows; `None` for a null.
    ///
    /// # Errors
    /// No such column, or of another type.
    pub fn bool(&self, name: &str) -> Result<Vec<Option<bool>>, StoreError> {
        self.column(name, |array| Some(array.as_boolean_opt()?.iter().collect()))
    }

    /// A column of text, printable, in the order of the rows; `None` for a null.
    ///
    /// # Errors
    /// No such column, or of another type.
    pub fn text(&self, name: &str) -> Result<Vec<Option<String>>, StoreError> {
        self.column(name, |array| {
            let values = array.as_string_opt::<i32>()?.iter();
            let shown = |value: &str| printable(value).into_owned();
            Some(values.map(|value| value.map(shown)).collect())
        })
    }

    /// A column of lists of numbers, in the order of the rows; `None` for a null.
    ///
    /// # Errors
    /// No such column, or of another type.
    pub fn lists(&self, name: &str) -> Result<Vec<Option<Vec<Option<f64>>>>, StoreError> {
        self.column(name, |array| {
            let lists = array.as_list_opt::<i32>()?;
            lists
                .iter()
                .map(|list| match list {
                    None => Some(None),
                    Some(list) => Some(Some(
                        list.as_primitive_opt::<Float64Type>()?.iter().collect(),
                    )),
                })
                .collect()
        })
    }

    /// Whether a column holds lists.
    pub fn is_list(&self, name: &str) -> bool {
        let field = self.fields.iter().find(|field| field.name() == name);
        field.is_some_and(|field| matches!(field.data_type(), DataType::List(_)))
    }

    /// A column of numbers of any type, or of lists of numbers, in the order of the rows. Each row gives its one
    /// number, the numbers of its list, or no number if it is null.
    ///
    /// # Errors
    /// No such column, or of another type.
    pub fn numbers(&self, name: &str) -> Result<Vec<Vec<Option<f64>>>, StoreError> {
        if self.is_list(name) {
            let lists = self.lists(name)?.into_iter();
            return Ok(lists.map(Option::unwrap_or_default).collect());
        }
        let single = |value: Option<f64>| value.map(Some).into_iter().collect();
        let field = self.fields.iter().find(|field| field.name() == name);
        let whole = field.is_some_and(|field| field.data_type().is_integer());
        Ok(if whole {
            (self.u64(name)?.into_iter())
                .map(|value| single(value.map(|whole| whole as f64)))
                .collect()
        } else {
            self.f64(name)?.into_iter().map(single).collect()
        })
    }

    fn column<T>(
        &self,
        name: &str,
        extract: impl Fn(&dyn Array) -> Option<Vec<Option<T>>>,
    ) -> Result<Vec<Option<T>>, StoreError> {
        let mut values = Vec::with_capacity(self.order.len());
        for batch in &self.batches {
            let array = batch
                .column_by_name(name)
                .ok_or_else(|| self.foreign(format!("it has no column `{name}`")))?;
            values.extend(extract(array).ok_or_else(|| {
                self.foreign(format!(
                    "column `{name}` has the wrong type {}",
                    array.data_type()
                ))
            })?);
        }
        Ok(self.order.iter().map(|&row| values[row].take()).collect())
    }

    pub(super) fn foreign(&self, detail: String) -> StoreError {
        StoreError::foreign(&self.path, detail)
    }
}

/// The tables of a folder, including missing ones that its records list.
///
/// # Errors
/// As [`read_runs`].
pub fn present_tables(folder: &Path) -> Result<Vec<TableKind>, StoreError> {
    let mut named: Vec<TableRecord> = Vec::new();
    for kind in TableKind::OF_RECORDS {
        named.extend(recorded(folder, kind)?.unwrap_or_default());
    }
    let is_there = |kind: &&TableKind| {
        let path = folder.join(kind.file_name());
        let named = || (named.iter()).any(|table| folder.join(&table.name).starts_with(&path));
        path.exists() || named()
    };
    Ok(TableKind::VARIANTS
        .iter()
        .filter(is_there)
        .copied()
        .collect())
}

/// The run records of a results folder: `run.json`, or one per shard.
///
/// # Errors
/// The folder cannot be listed, or a record cannot be read, is not of this program, or was changed. A folder without a
/// record gives an empty list.
pub fn read_runs(folder: &Path) -> Result<Vec<RunRecord>, StoreError> {
    let paths = record_paths(folder)?;
    paths.iter().map(|path| read_run(path)).collect()
}

/// Paths of the run records of a results folder.
///
/// # Errors
/// The folder cannot be listed.
pub fn record_paths(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let is_record = |name: &str| {
        name == "run.json" || (name.starts_with("run.shard-") && name.ends_with(".json"))
    };
    listed(folder, is_record)
}

/// One run record.
///
/// # Errors
/// It cannot be read, is not of this program, or was changed.
pub fn read_run(path: &Path) -> Result<RunRecord, StoreError> {
    read_record(path)
}

/// Reads a record that ends in the hash of its text.
pub(super) fn read_record<T: DeserializeOwned>(path: &Path) -> Result<T, StoreError> {
    let text =
        input::read(path, MOST_RECORD).map_err(|source| StoreError::io(path, "read", source))?;
    if !is_sealed(&text) {
        return Err(StoreError::Damaged {
            path: path.to_path_buf(),
            damage: Damage::Unsealed,
        });
    }
    serde_json::from_slice(&text).map_err(|error| StoreError::foreign(path, error.to_string()))
}

/// Compares every table of a run with its record.
///
/// # Errors
/// [`StoreError::Damaged`] if one is missing or was changed; or it cannot be read.
pub fn verify(folder: &Path, record: &RunRecord) -> Result<(), StoreError> {
    let tables = &record.tables[..];
    let recorded = RecordedTables { folder, tables };
    let mut paths = recorded.paths().into_iter();
    paths.try_for_each(|path| recorded.open(&path).map(drop))
}

/// The files of a table: those in the folder and those in the records.
fn parts(
    folder: &Path,
    path: &Path,
    recorded: Option<RecordedTables<'_>>,
) -> Result<Vec<PathBuf>, StoreError> {
    let mut parts = match path.metadata() {
        Ok(metadata) if metadata.is_dir() => listed(path, |name| name.ends_with(".parquet"))?,
        Ok(_) => vec![path.to_path_buf()],
        Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
        Err(source) => return Err(StoreError::io(path, "read", source)),
    };
    let written = recorded.iter().flat_map(RecordedTables::paths);
    parts.extend(written.filter(|file| file.starts_with(path)));
    parts.sort();
    parts.dedup();
    if parts.is_empty() {
        Err(StoreError::missing(folder, path.to_path_buf()))
    } else {
        Ok(parts)
    }
}

/// Files of a folder whose names satisfy `wanted`, sorted.
fn listed(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>, StoreError> {
    let refused = |source| StoreError::io(folder, "read", source);
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(refused)? {
        let entry = entry.map_err(refused)?;
        if entry.file_name().to_str().is_some_and(&wanted) {
            paths.push(entry.path());
        }
    }
    paths.sort();
    Ok(paths)
}

/// The tables in the records of a folder, from the command that writes tables of this kind; `None` without such a
/// record or a folder.
///
/// # Errors
/// A record cannot be read, is not of this program, or was changed.
fn recorded(folder: &Path, kind: TableKind) -> Result<Option<Vec<TableRecord>>, StoreError> {
    if !folder.is_dir() {
        return Ok(None);
    }
    let Some(name) = kind.command_record() else {
        let runs = read_runs(folder)?;
        let tables = || runs.iter().flat_map(|run| run.tables.clone()).collect();
        return Ok((!runs.is_empty()).then(tables));
    };
    let path = folder.join(name);
    let record = (path.exists()).then(|| read_record::<TablesRecord>(&path));
    Ok(record.transpose()?.map(|record| record.tables))
}
