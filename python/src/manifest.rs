//! Manifests: reads and checks them, and lists their points.

use crate::errors::{faults, faulty, refused};
use crate::point::Point;
use crate::table::{Table, with_unit};
use crate::toml_values::{text_of, value_text};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Metadata, Schema};
use gearatlas::manifest::{self, GridDimension, Job, ManifestErrors, ManifestText};
use gearatlas::sweep::sample_columns;
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A valid manifest.
#[pyclass(frozen, module = "gearatlas._gearatlas")]
pub struct Manifest {
    pub job: Arc<Job>,
    source: Origin,
}

/// Origin of a manifest.
struct Origin {
    /// Its name in messages.
    name: String,
    /// Base folder of relative paths in it.
    folder: PathBuf,
}

/// The changes from `set` of Python, in the form of `--set`.
fn changes(set: &Bound<'_, PyDict>) -> PyResult<Vec<String>> {
    let change = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        let value = value_text(&value, &key)?;
        Ok(format!("{key}={value}"))
    };
    set.iter().map(change).collect()
}

fn judged(
    py: Python<'_>,
    found: Result<Job, ManifestErrors>,
    name: String,
    folder: PathBuf,
) -> PyResult<Manifest> {
    // An empty path has no absolute form.
    let folder = std::path::absolute(Path::new(".").join(&folder)).unwrap_or(folder);
    match found {
        Ok(job) => Ok(Manifest {
            job: Arc::new(job),
            source: Origin { name, folder },
        }),
        Err(errors) => Err(faulty(py, &errors)),
    }
}

#[pymethods]
impl Manifest {
    /// The manifest in a file.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf, set: &Bound<'_, PyDict>) -> PyResult<Self> {
        let changes = changes(set)?;
        let found = py.detach(|| manifest::load_changed(&path, &changes));
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        judged(py, found, path.display().to_string(), folder)
    }

    /// The manifest in a text; `folder` is the base of relative paths in it.
    #[staticmethod]
    fn from_text(
        py: Python<'_>,
        text: &str,
        set: &Bound<'_, PyDict>,
        name: &str,
        folder: PathBuf,
    ) -> PyResult<Self> {
        Self::read(py, text, &changes(set)?, name, folder)
    }

    /// The manifest from a pickle.
    #[staticmethod]
    fn unpickled(
        py: Python<'_>,
        text: &str,
        changes: Vec<String>,
        name: &str,
        folder: PathBuf,
        hash: &str,
    ) -> PyResult<Self> {
        let read = Self::read(py, text, &changes, name, folder)?;
        if read.hash() == hash {
            return Ok(read);
        }
        let sentence = format!(
            "the files that the manifest `{name}` names have changed since it was pickled; load it again"
        );
        Err(refused(py, &sentence))
    }

    /// The same text with more changes.
    fn changed(&self, py: Python<'_>, set: &Bound<'_, PyDict>) -> PyResult<Self> {
        let Origin { name, folder } = &self.source;
        let all = [self.changes(), changes(set)?].concat();
        Self::read(py, self.text(), &all, name, folder.clone())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let Origin { name, folder } = &self.source;
        let made = py.get_type::<Self>().getattr("unpickled")?;
        let parts = (self.text(), self.changes(), name, folder, self.hash());
        (made, parts).into_pyobject(py)
    }

    /// The manifest from a dictionary of tables.
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

    /// The warnings of the manifest, with the parts of each.
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let warnings = &self.job.warnings;
        faults(py, &warnings.sources, warnings.diagnostics.iter())
    }

    /// The warnings as on the command line; empty if there are none.
    fn warned(&self) -> String {
        self.job.warnings.render(false)
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.job.seed
    }

    /// Keys on which a drive depends continuously.
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

    /// The grid: `point_id`, the value of every axis, `sample` if some are distributions, and `direction` if states are
    /// carried.
    fn grid(&self, py: Python<'_>) -> PyResult<Table> {
        py.detach(|| self.listed())
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The point with a number; `values` change some of its keys.
    fn point(slf: &Bound<'_, Self>, id: i64, values: &Bound<'_, PyDict>) -> PyResult<Point> {
        let points = &slf.get().job.points;
        let count = points.len();
        let Some(place) = usize::try_from(id).ok().filter(|place| *place < count) else {
            let sentence =
                format!("there is no point {id}: the manifest has {count} points, counted from 0");
            return Err(PyIndexError::new_err(sentence));
        };
        Point::new(slf.clone().unbind(), points.at(place)).changed(slf.py(), values)
    }
}

impl Manifest {
    fn read(
        py: Python<'_>,
        text: &str,
        changes: &[String],
        name: &str,
        folder: PathBuf,
    ) -> PyResult<Self> {
        let written = ManifestText { text, changes };
        let found = py.detach(|| written.job(name, &folder));
        judged(py, found, name.to_owned(), folder)
    }

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
        let axes: Vec<&str> = job.axes.iter().map(manifest::Axis::name).collect();
        let mut told = Metadata::new().with("axes", serde_json::json!(axes).to_string());
        let tied = job.dimensions.iter().filter(|own| own.is_tied());
        let names = |own: &GridDimension| -> Vec<&str> {
            own.axes.iter().map(|&axis| axes[axis]).collect()
        };
        let tied: Vec<Vec<&str>> = tied.map(names).collect();
        told.insert("tied", serde_json::json!(tied).to_string());
        if let Some(samples) = sample_columns(job) {
            let rows: UInt64Array = points.iter().map(|own| samples.row(own.point_id)).collect();
            let about = "Row of the design of the axes that are distributions, from 0";
            fields.push(with_unit("sample", DataType::UInt64, "1", about));
            columns.push(Arc::new(rows));
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
