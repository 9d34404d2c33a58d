//! Files of measured points.

use crate::errors::faulty;
use gearatlas::manifest::{Measured, MeasuredColumn};
use gearatlas::units;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Name, unit as written, and numbers of a column.
type Column<'py> = (String, Option<String>, Bound<'py, PyArray1<f64>>);

/// The two or three columns of a file of measured points.
#[pyfunction]
pub fn read_measured(py: Python<'_>, path: PathBuf) -> PyResult<Vec<Column<'_>>> {
    let found = py.detach(|| Measured::read(&path));
    let found = found.map_err(|errors| faulty(py, &errors))?;
    let of = |column: MeasuredColumn| (column.name, column.unit, column.numbers.into_pyarray(py));
    let columns = [Some(found.axis), Some(found.value), found.stderr];
    Ok(columns.into_iter().flatten().map(of).collect())
}

/// Number of units `to` in one unit `from`; None if either is unknown or they belong to different quantities.
#[pyfunction]
pub fn conversion(from: &str, to: &str) -> Option<f64> {
    units::conversion(from, to)
}
