//! `grid.points`: operating points one by one, in the manifest or in a file. What their columns name are axes that
//! are tied.

use super::csv::{self, Sheet};
use super::dimension_of;
use super::grid_axis::GridAxis;
use super::values::{AxisReader, Spans};
use crate::manifest::axis::{AxisKey, AxisValues};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::manifest::reader::{Section, wrong_type};
use crate::manifest::spec::Axis;
use crate::manifest::text;
use crate::manifest::tree::{Entry, Node, Value};
use crate::units::{self, Dimension};
use std::path::Path;

const PATH: &str = "grid.points";

/// What a list of points makes of the grid.
#[derive(Debug, Default)]
pub(super) struct List {
    /// Its columns; all are tied.
    pub axes: Vec<GridAxis>,
    /// Names of the columns that have faults.
    pub faulty: Vec<String>,
    /// Whether it cannot be told which columns there are.
    pub unknown: bool,
}

/// A column in the text.
struct Column {
    name: Entry,
    /// Unit of the values, where the head of a column has one.
    unit: Option<(String, Span)>,
    values: Vec<Node>,
}

/// The list, where there is one.
pub(super) fn read(section: &Section, issues: &mut Issues, base_dir: &Path) -> Option<List> {
    let entry = section.entry("points")?;
    let columns = match &entry.node.value {
        Value::Text(name) => file(issues, entry, name, base_dir),
        Value::Array(rows) => rows_of(issues, &entry.node, rows),
        _ => {
            wrong_type(issues, &entry.node, PATH, section.spec(PATH));
            None
        }
    };
    let Some(columns) = columns else {
        return Some(List {
            unknown: true,
            ..List::default()
        });
    };
    let mut list = List::default();
    for column in columns {
        match axis(issues, &column) {
            Some(axis) => list.axes.push(axis),
            None => list.faulty.push(column.name.key.clone()),
        }
    }
    Some(list)
}

fn axis(issues: &mut Issues, column: &Column) -> Option<GridAxis> {
    let name = column.name.key.as_str();
    let path = super::path_of(name);
    let spec = super::axis_key(issues, &column.name, &path)?;
    let mut reader = AxisReader {
        spec,
        path: &path,
        dimension: dimension_of(spec),
    };
    if let Some((unit, span)) = &column.unit {
        let dimension = units::parse_any(&format!("1 {unit}"))
            .ok()
            .map(|(_, found)| found);
        let fits = match (dimension, reader.dimension) {
            (Some(found), Some(wanted)) => found == wanted,
            (found, None) => found.is_some(),
            (None, Some(_)) => false,
        };
        if !fits {
            let wanted = reader.dimension.unwrap_or(Dimension::Ratio);
            let units = match wanted.units() {
                "" => "no unit: write only the name".to_owned(),
                units => units.to_owned(),
            };
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::WrongUnit,
                    *span,
                    &path,
                    format!("`{unit}` is not a unit of `{name}`"),
                )
                .label(format!("{} is needed here", wanted.name()))
                .accepted(units)
                .remedy("write the unit after the name of the column, such as speed [rpm]"),
            );
            return None;
        }
    }
    let read: Vec<Option<f64>> = (column.values.iter())
        .map(|value| reader.one(issues, value))
        .collect();
    let values = read.into_iter().collect::<Option<Vec<f64>>>()?;
    let dimension = reader.dimension.unwrap_or(Dimension::Ratio);
    Some(GridAxis {
        axis: Axis {
            key: AxisKey::of(name),
            unit: dimension.unit().to_owned(),
            values: AxisValues::each(values),
        },
        key_span: column.name.key_span,
        dimension,
        spans: Spans::Each(column.values.iter().map(|value| value.span).collect()),
    })
}

/// The columns of rows that stand in the manifest.
fn rows_of(issues: &mut Issues, list: &Node, rows: &[Node]) -> Option<Vec<Column>> {
    if rows.is_empty() {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Empty,
                list.span,
                PATH,
                format!("`{PATH}` is empty, so the grid has no points"),
            )
            .label("empty")
            .remedy("give at least one point, { load = 0.1, speed = \"1000 rpm\" }"),
        );
        return None;
    }
    let mut columns: Vec<Column> = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        let Value::Table(entries) = &row.value else {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::WrongType,
                    row.span,
                    PATH,
                    format!("point {} must be a table, not {}", number + 1, row.value.type_name()),
                )
                .label(format!("this is {}", row.value.type_name()))
                .accepted("{ load = 0.1, speed = \"1000 rpm\" }, with quoted model keys: \"mesh.half_gap\" = \"15 um\""),
            );
            return None;
        };
        if number == 0 {
            columns = (entries.iter())
                .map(|entry| Column {
                    name: entry.clone(),
                    unit: None,
                    values: Vec::new(),
                })
                .collect();
        }
        let extra = entries
            .iter()
            .find(|entry| !columns.iter().any(|column| column.name.key == entry.key));
        let lacking = columns
            .iter()
            .find(|column| row.entry(&column.name.key).is_none());
        let fault = match (extra, lacking) {
            (Some(entry), _) => Some((
                entry.key_span,
                format!(
                    "point {} has `{}`, but the first point does not",
                    number + 1,
                    entry.key
                ),
                "not in the first point",
            )),
            (None, Some(column)) => Some((
                row.span,
                format!(
                    "point {} has no `{}`, but the first point has",
                    number + 1,
                    column.name.key
                ),
                "incomplete",
            )),
            (None, None) => None,
        };
        if let Some((span, message, label)) = fault {
            issues.push(
                Diagnostic::new(DiagnosticKind::Inconsistent, span, PATH, message)
                    .label(label)
                    .remedy("give every point the same keys; give a key with one value for all points in [grid]"),
            );
            return None;
        }
        for column in &mut columns {
            column
                .values
                .extend(row.entry(&column.name.key).map(|entry| entry.node.clone()));
        }
    }
    Some(columns)
}

/// The columns of a file.
fn file(issues: &mut Issues, entry: &Entry, name: &str, base_dir: &Path) -> Option<Vec<Column>> {
    let path = base_dir.join(name);
    let source = text::read_named(issues, &path, "the list of points", (PATH, entry.node.span))?;
    // Taken out while its faults are recorded, and put back.
    let text = std::mem::take(&mut issues.sources[source].text);
    let sheet = csv::read(source, &text, issues);
    issues.sources[source].text = text;
    let Sheet { columns } = sheet?;
    Some(
        (columns.into_iter())
            .map(|column| Column {
                values: (column.cells.into_iter())
                    .map(|(span, number, typed)| Node {
                        span,
                        value: match &column.unit {
                            Some((unit, _)) => Value::Text(format!("{typed} {unit}")),
                            None if number.fract() == 0.0 && number.abs() < 9e15 => {
                                Value::Integer(number as i64)
                            }
                            None => Value::Float(number),
                        },
                    })
                    .collect(),
                name: Entry {
                    key: column.name,
                    key_span: column.span,
                    node: Node {
                        span: column.span,
                        value: Value::Float(0.0),
                    },
                },
                unit: column.unit,
            })
            .collect(),
    )
}
