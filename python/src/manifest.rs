//! Manifests: read, judged, and their points listed.

use crate::errors::{faults, faulty};
use crate::point::Point;
use crate::table::{Table, with_unit};
use crate::toml_values::{text_of, value_text};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Metadata, Schema};
use gearatlas::manifest::{self, Job, ManifestErrors, ManifestText};
use gearatlas::sweep::sample_columns;
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;

/// A manifest without faults.
#[pyclass(frozen, module = "gearatlas._gearatlas")]
pub struct Manifest {
    pub job: Arc<Job>,
}

/// What `set` of Python asks to change, as `--set` does.
fn changes(set: &Bound<'_, PyDict>) -> PyResult<Vec<String>> {
    let change = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        let value = value_text(&value, &key)?;
        Ok(format!("{key}={value}"))
    };
    set.iter().map(change).collect()
}

fn judged(py: Python<'_>, found: Result<Job, ManifestErrors>) -> PyResult<Manifest> {
    match found {
        Ok(job) => Ok(Manifest { job: Arc::new(job) }),
        Err(errors) => Err(faulty(py, &errors)),
    }
}

#[pymethods]
impl Manifest {
    /// The manifest in a file.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf, set: &Bound<'_, PyDict>) -> PyResult<Self> {
        let changes = changes(set)?;
        judged(py, py.detach(|| manifest::load_changed(&path, &changes)))
    }

    /// The manifest that a text is; relative paths in it start at `folder`.
    #[staticmethod]
    fn from_text(
        py: Python<'_>,
        text: &str,
        set: &Bound<'_, PyDict>,
        name: &str,
        folder: PathBuf,
    ) -> PyResult<Self> {
        let changes = &changes(set)?[..];
        let written = ManifestText { text, changes };
        judged(py, py.detach(|| written.job(name, &folder)))
    }

    /// The manifest that a dictionary of tables is.
    #[staticmethod]
    fn from_dict(
        py: Python<'_>,
        tables: &Bound<'_, PyDict>,
        set: &Bound<'_, PyDict>,
        folder: PathBuf,
    ) -> PyResult<Self> {
        Self::from_text(py, &text_of(tables)?, set, "dict", folder)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.job.name
    }

    #[getter]
    fn hash(&self) -> &str {
        &self.job.hash
    }

    #[getter]
    fn text(&self) -> &str {
        &self.job.text
    }

    #[getter]
    fn changes(&self) -> Vec<String> {
        self.job.changes.clone()
    }

    /// What the manifest is warned of, every warning by its parts.
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let warnings = &self.job.warnings;
        faults(py, &warnings.sources, warnings.diagnostics.iter())
    }

    /// The same as the command line shows it; empty where there is nothing.
    fn warned(&self) -> String {
        self.job.warnings.render()
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.job.seed
    }

    /// Keys that a drive depends on continuously.
    #[getter]
    fn keys(&self) -> Vec<String> {
        self.job.between.continuous_keys()
    }

    /// Name, unit and values of every axis of the grid.
    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> Vec<(&str, &str, Bound<'py, PyArray1<f64>>)> {
        let axes = self.job.axes.iter();
        let values = |axis: &manifest::Axis| axis.values.iter().collect::<Vec<f64>>();
        axes.map(|axis| (axis.name(), &*axis.unit, values(axis).into_pyarray(py)))
            .collect()
    }

    fn __len__(&self) -> usize {
        self.job.points.len()
    }

    /// The grid: `point_id`, the value of every axis, `sample` where some are distributions, and `direction` where states
    /// are carried.
    fn grid(&self, py: Python<'_>) -> PyResult<Table> {
        py.detach(|| self.listed())
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The point of a number; `values` change keys of it.
    fn point(&self, py: Python<'_>, id: usize, values: &Bound<'_, PyDict>) -> PyResult<Point> {
        let count = self.job.points.len();
        if id >= count {
            let sentence =
                format!("there is no point {id}: the manifest has {count} points, counted from 0");
            return Err(PyIndexError::new_err(sentence));
        }
        let point = self.job.points.at(id);
        Point::new(self.job.clone(), point).changed(py, values)
    }
}

impl Manifest {
    fn listed(&self) -> Result<Table, arrow_schema::ArrowError> {
        let job = &self.job;
        let points: Vec<_> = job.points.iter().collect();
        let ids: UInt64Array = points.iter().map(|point| point.point_id).collect();
        let mut fields = vec![with_unit(
            "point_id",
            DataType::UInt64,
            "1",
            "Number of the point",
        )];
        let mut columns: Vec<ArrayRef> = vec![Arc::new(ids)];
        for (index, axis) in job.axes.iter().enumerate() {
            let values = points.iter().map(|point| point.axis_values[index]);
            let values: Float64Array = values.collect::<Vec<f64>>().into();
            fields.push(with_unit(
                axis.name(),
                DataType::Float64,
                &axis.unit,
                "Axis of the grid",
            ));
            columns.push(Arc::new(values));
        }
        let mut told = Metadata::default();
        if let Some(samples) = sample_columns(job) {
            let rows: UInt64Array = points.iter().map(|own| samples.row(own.point_id)).collect();
            let about = "Row of the design of the axes that are distributions, from 0";
            fields.push(with_unit("sample", DataType::UInt64, "1", about));
            columns.push(Arc::new(rows));
            let axes: Vec<&str> = job.axes.iter().map(manifest::Axis::name).collect();
            told.insert("axes".to_owned(), serde_json::json!(axes).to_string());
            told.insert("samples".to_owned(), serde_json::json!(samples).to_string());
        }
        if job.carried.is_some() {
            let ways = points
                .iter()
                .map(|point| point.direction.map(|way| way.name()));
            fields.push(with_unit(
                "direction",
                DataType::Utf8,
                "",
                "Direction of the sweep: up or down",
            ));
            columns.push(Arc::new(ways.collect::<StringArray>()));
        }
        let schema = Arc::new(Schema::new(fields).with_metadata(told));
        let batch = RecordBatch::try_new(schema.clone(), columns)?;
        Ok(Table::new(schema, vec![batch]))
    }
}
