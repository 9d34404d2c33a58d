//! Python's dictionaries as the text of a manifest.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyInt, PyList, PyMapping, PySequence, PyString, PyTuple};
use toml::{Table, Value};

/// A dictionary as the text of a manifest.
///
/// # Errors
/// `TypeError` for a value that a manifest cannot contain.
pub fn text_of(dictionary: &Bound<'_, PyDict>) -> PyResult<String> {
    let table = table_of(dictionary.as_mapping(), "")?;
    toml::to_string(&table).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// The text of a value after `KEY=`: empty for None, which removes the key.
///
/// # Errors
/// `TypeError` for a value that a manifest cannot contain.
pub fn value_text(value: &Bound<'_, PyAny>, key: &str) -> PyResult<String> {
    if value.is_none() {
        Ok(String::new())
    } else {
        Ok(value_of(value, key)?.to_string())
    }
}

fn table_of(mapping: &Bound<'_, PyMapping>, path: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for item in mapping.items()?.try_iter()? {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item?.extract()?;
        let Ok(name) = key.extract::<String>() else {
            let kind = key.get_type().qualname()?;
            let place = if path.is_empty() { "the manifest" } else { path };
            let sentence =
                format!("a key of {place} is a {kind}, but keys of a manifest must be texts");
            return Err(PyTypeError::new_err(sentence));
        };
        let path = match path {
            "" => name.clone(),
            _ => format!("{path}.{name}"),
        };
        table.insert(name, value_of(&value, &path)?);
    }
    Ok(table)
}

fn value_of(value: &Bound<'_, PyAny>, path: &str) -> PyResult<Value> {
    if value.is_instance_of::<PyBool>() || is_numpy(value, "bool") {
        return Ok(Value::Boolean(value.is_truthy()?));
    }
    if value.is_instance_of::<PyInt>() || is_numpy(value, "integer") {
        return Ok(Value::Integer(value.extract()?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.extract()?));
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        return Ok(Value::Table(table_of(mapping, path)?));
    }
    let sequence = value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>();
    if sequence || (value.hasattr("__array__")? && value.hasattr("__len__")? && value.len().is_ok())
    {
        let items = value.try_iter()?.enumerate();
        let items = items.map(|(i, item)| value_of(&item?, &format!("{path}.{i}")));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    if value.cast::<PySequence>().is_err()
        && let Ok(number) = value.extract::<f64>()
    {
        return Ok(Value::Float(number));
    }
    // The value is a path, for example of a file of points.
    if let Ok(path) = value.call_method0("__fspath__") {
        return Ok(Value::String(path.extract()?));
    }
    let kind = value.get_type().qualname()?;
    Err(PyTypeError::new_err(format!(
        "{path} is a {kind}; give a text, a number, a truth value, or a list or table of these"
    )))
}

/// Whether a value is a NumPy scalar of some kind.
fn is_numpy(value: &Bound<'_, PyAny>, kind: &str) -> bool {
    let is = || {
        let numpy = value.py().import("numpy")?;
        value.is_instance(&numpy.getattr(kind)?)
    };
    is().unwrap_or(false)
}
