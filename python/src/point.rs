//! Operating points: points of a grid, and others near them.

use crate::errors::{failed, refused};
use crate::manifest::Manifest;
use gearatlas::manifest::{Job, Parameter, PointSpec};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// An operating point of a manifest, on its grid or off it.
#[pyclass(frozen, module = "gearatlas._gearatlas")]
pub struct Point {
    manifest: Py<Manifest>,
    pub spec: PointSpec,
    /// Keys whose values differ from the grid.
    pub changes: Vec<(Parameter, f64)>,
}

impl Point {
    pub fn new(manifest: Py<Manifest>, spec: PointSpec) -> Self {
        Self {
            manifest,
            spec,
            changes: Vec::new(),
        }
    }

    /// The job of its manifest.
    pub fn job(&self) -> &Job {
        &self.manifest.get().job
    }

    /// The parameter with a name.
    ///
    /// # Errors
    /// No parameter has this name.
    pub fn parameter(&self, py: Python<'_>, name: &str) -> PyResult<Parameter> {
        let found = self.job().between.parameter(&self.spec, name);
        found.map_err(|error| failed(py, &error))
    }
}

#[pymethods]
impl Point {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let values = PyDict::new(py);
        for (parameter, value) in &self.changes {
            values.set_item(parameter.name(), value)?;
        }
        let made = self.manifest.bind(py).getattr("point")?;
        (made, (self.id(), values)).into_pyobject(py)
    }

    /// Its number on the grid, or that of the point from which it was made.
    #[getter]
    fn id(&self) -> u64 {
        self.spec.point_id
    }

    /// Fraction of the rated mesh force.
    #[getter]
    fn load(&self) -> f64 {
        self.spec.load
    }

    /// Pinion speed \[rad/s\].
    #[getter]
    fn speed(&self) -> f64 {
        self.spec.speed
    }

    /// Direction of its sweep.
    #[getter]
    fn direction(&self) -> Option<&'static str> {
        self.spec.direction.map(|way| way.name())
    }

    /// The value of a key on which a drive depends continuously, in SI.
    fn value(&self, py: Python<'_>, key: &str) -> PyResult<f64> {
        let parameter = self.parameter(py, key)?;
        let own = self.changes.iter().find(|(own, _)| *own == parameter);
        let value = match own {
            Some((_, value)) => Some(*value),
            None => self.job().between.value(&self.spec, &parameter),
        };
        value.ok_or_else(|| refused(py, &format!("`{key}` has no value in the manifest")))
    }

    /// The SI unit of a key on which the drive depends continuously.
    fn unit(&self, py: Python<'_>, key: &str) -> PyResult<&'static str> {
        Ok(self.parameter(py, key)?.unit())
    }

    /// The same point with other values of some keys: numbers in SI, or texts with units.
    pub fn changed(&self, py: Python<'_>, values: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut changes = self.changes.clone();
        for (key, value) in values {
            let key: String = key.extract()?;
            let parameter = self.parameter(py, &key)?;
            let value = match value.extract::<String>() {
                Ok(text) => {
                    let parsed = parameter.parse(&text);
                    parsed.map_err(|reason| refused(py, &format!("{key}: {reason}")))?
                }
                Err(_) => value.extract()?,
            };
            // Load and torque are two names of one quantity.
            let same = |own: &Parameter| match key.as_str() {
                "load" | "torque" => ["load", "torque"].contains(&own.name()),
                _ => *own == parameter,
            };
            changes.retain(|(own, _)| !same(own));
            changes.push((parameter, value));
        }
        let all: Vec<(&Parameter, f64)> =
            (changes.iter()).map(|(key, value)| (key, *value)).collect();
        let changed = self.job().between.changed(&self.spec, &all);
        let mut spec = changed.map_err(|reason| refused(py, &reason))?;
        for (parameter, value) in all {
            let axes = self.job().axes.iter();
            let mut names = axes.map(|axis| axis.name());
            if let Some(axis) = names.position(|name| name == parameter.name()) {
                spec.axis_values[axis] = value;
            }
        }
        Ok(Self {
            manifest: self.manifest.clone_ref(py),
            spec,
            changes,
        })
    }
}
