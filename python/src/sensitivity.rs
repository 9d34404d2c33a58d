//! How do the results of a point change with keys of its manifest?

use crate::attended::attended;
use crate::errors::failed;
use crate::point::Point;
use crate::table::{Table, with_unit};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use gearatlas::analysis::sensitivity::ensemble::Ensemble;
use gearatlas::manifest::Parameter;
use gearatlas::store::TableStore;
use gearatlas::sweep::{Differentiated, Prepared, Sensitivity, sensitivities};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// The kind of motion of a point, the reason for it, and a row for each key and quantity. Without `keys`, uses all
/// continuous keys.
#[pyfunction]
#[pyo3(signature = (point, *, keys, members, cycles, step, tables))]
pub fn sensitivity(
    py: Python<'_>,
    point: &Point,
    keys: Option<Vec<String>>,
    members: usize,
    cycles: u64,
    step: f64,
    tables: PathBuf,
) -> PyResult<(&'static str, String, Table)> {
    let names = keys.unwrap_or_else(|| point.job().between.continuous_keys());
    let keys = names.iter().map(|name| point.parameter(py, name));
    let keys: Vec<Parameter> = keys.collect::<PyResult<_>>()?;
    let asked = Ensemble {
        members,
        transient: 200,
        cycles,
    };
    let parts = Prepared::new(TableStore::open(tables));
    let work = |interrupt: &_| {
        let own = Differentiated {
            point: &point.spec,
            held: &point.changes,
        };
        sensitivities(point.job(), own, &keys, &asked, step, &parts, interrupt)
    };
    let found = attended(py, work, |_| Ok(()))?.map_err(|error| failed(py, &error))?;
    let rows = table(&found.rows).map_err(|error| failed(py, &error))?;
    Ok((found.class.name(), found.reason, rows))
}

/// The rows as a table. Units are a column, because they differ between rows.
fn table(rows: &[Sensitivity]) -> Result<Table, ArrowError> {
    type Text = fn(&Sensitivity) -> &str;
    type Number = fn(&Sensitivity) -> Option<f64>;
    let texts: [(&str, &str, Text); 6] = [
        ("key", "Key of the manifest", |row| &row.key),
        ("key_unit", "Its SI unit", |row| row.key_unit),
        ("quantity", "Quantity of the motion", |row| &row.quantity),
        ("unit", "Its SI unit", |row| row.unit),
        ("method", "orbit (exact), difference or ensemble", |row| {
            row.method
        }),
        ("note", "Why the derivative is missing or unsure", |row| {
            &row.note
        }),
    ];
    let numbers: [(&str, &str, Number); 5] = [
        ("at", "Value of the key", |row| Some(row.at)),
        ("value", "Value of the quantity", |row| Some(row.value)),
        (
            "derivative",
            "Derivative of the quantity by the key",
            |row| row.by,
        ),
        (
            "check",
            "The same by differences, or by a doubled step",
            |row| row.check,
        ),
        (
            "stderr",
            "Standard error of an estimated derivative",
            |row| row.error,
        ),
    ];
    let mut fields: Vec<Field> = Vec::new();
    let mut columns: Vec<ArrayRef> = Vec::new();
    for (name, description, of) in texts {
        fields.push(with_unit(name, DataType::Utf8, "", description));
        let values = rows.iter().map(|row| Some(of(row)));
        columns.push(Arc::new(values.collect::<StringArray>()));
    }
    for (name, description, of) in numbers {
        fields.push(with_unit(name, DataType::Float64, "", description));
        columns.push(Arc::new(rows.iter().map(of).collect::<Float64Array>()));
    }
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(schema.clone(), columns)?;
    Ok(Table::new(schema, vec![batch]))
}
