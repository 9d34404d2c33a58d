//! Errors of the library as the exceptions of `gearatlas._errors`.

use gearatlas::input::with_causes;
use gearatlas::manifest::{Diagnostic, ManifestErrors, Source};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::error::Error;

/// The exception with a name and arguments.
fn raise<'py>(py: Python<'py>, name: &str, arguments: impl pyo3::call::PyCallArgs<'py>) -> PyErr {
    let made = || {
        py.import("gearatlas._errors")?
            .getattr(name)?
            .call1(arguments)
    };
    made().map_or_else(|error| error, PyErr::from_value)
}

/// `gearatlas.AtlasError` with the message of an error and its causes.
pub fn failed(py: Python<'_>, error: &dyn Error) -> PyErr {
    refused(py, &with_causes(error))
}

/// `gearatlas.AtlasError` with a sentence.
pub fn refused(py: Python<'_>, sentence: &str) -> PyErr {
    raise(py, "AtlasError", (sentence,))
}

/// `gearatlas.ManifestError` with the text of the command line, and the parts of every fault.
pub fn faulty(py: Python<'_>, errors: &ManifestErrors) -> PyErr {
    let text = format!("{}{}", errors.render(false), errors.summary());
    match faults(py, &errors.sources, errors.errors()) {
        Ok(faults) => raise(py, "ManifestError", (text, faults, errors.count())),
        Err(error) => error,
    }
}

/// The parts of faults, in the form of `gearatlas._errors.Fault`.
pub fn faults<'py, 'd>(
    py: Python<'py>,
    sources: &[Source],
    faults: impl Iterator<Item = &'d Diagnostic>,
) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for fault in faults {
        let known = (fault.line > 0).then_some((fault.line, fault.column));
        let parts = PyDict::new(py);
        parts.set_item("kind", fault.kind.code())?;
        parts.set_item("source", &sources[fault.span.source].name)?;
        parts.set_item("line", known.map(|(line, _)| line))?;
        parts.set_item("column", known.map(|(_, column)| column))?;
        parts.set_item("key", &fault.key)?;
        parts.set_item("message", &fault.message)?;
        parts.set_item("accepted", fault.accepted.as_deref())?;
        parts.set_item("nearest", fault.suggestion.as_deref())?;
        parts.set_item("remedy", fault.remedy.as_deref())?;
        parts.set_item("seen_at", fault.at_point.as_deref())?;
        list.append(parts)?;
    }
    Ok(list)
}
