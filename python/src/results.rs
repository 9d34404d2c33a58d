//! Folders of results: the list of their tables, each table, and the records of their runs.

use crate::errors::{failed, refused};
use crate::table::Table;
use gearatlas::store::{ResultTable, TableKind, present_tables as present, read_runs as runs};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Names of the tables of a folder.
#[pyfunction]
pub fn present_tables(py: Python<'_>, folder: PathBuf) -> PyResult<Vec<&'static str>> {
    let found = py.detach(|| present(&folder));
    let found = found.map_err(|error| failed(py, &error))?;
    Ok(found.into_iter().map(TableKind::name).collect())
}

/// A table of a folder, checked against the record of its run.
#[pyfunction]
pub fn read_table(py: Python<'_>, folder: PathBuf, name: &str) -> PyResult<Table> {
    let Some(kind) = TableKind::named(name) else {
        let known = TableKind::names().collect::<Vec<_>>().join(", ");
        let sentence = format!("there is no table `{name}`; known tables are {known}");
        return Err(refused(py, &sentence));
    };
    // If the folder has other tables, it is a results folder, and the job did not request this table.
    let here = present_tables(py, folder.clone())?;
    if !here.is_empty() && !here.contains(&name) {
        let sentence = format!(
            "there is no {} in `{}`: {}; available are {}",
            kind.file_name(),
            folder.display(),
            kind.remedy(),
            here.join(", ")
        );
        return Err(refused(py, &sentence));
    }
    let read = || ResultTable::read(&folder, kind)?.batches();
    let (schema, batches) = py.detach(read).map_err(|error| failed(py, &error))?;
    Ok(Table::new(schema, batches))
}

/// The records of the runs of a folder, each as JSON.
#[pyfunction]
pub fn read_runs(py: Python<'_>, folder: PathBuf) -> PyResult<Vec<String>> {
    let found = py.detach(|| runs(&folder));
    let found = found.map_err(|error| failed(py, &error))?;
    let json = found.iter().map(serde_json::to_string);
    json.collect::<Result<_, _>>()
        .map_err(|error| failed(py, &error))
}
