//! Lists of points whose columns have names and units: tables in the manifest, or a text file.

use super::csv::{self, ListOf};
use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::reader::{Given, all_or_none};
use super::schema::{self, Key, Kind, MANIFEST};
use super::text;
use super::tree::{Entry, Node, Value};
use crate::units::{self, Dimension};
use std::path::Path;

/// A column of a list of points, as it was read.
pub(super) struct Column {
    /// Name and its place.
    pub name: Entry,
    /// Unit of the values, if the header of the column has one.
    pub unit: Option<(String, Span)>,
    /// One value per point.
    pub values: Vec<Node>,
}

/// The columns of a list; `None` if it has faults, which are reported.
pub(super) fn read(
    issues: &Issues,
    entry: &Entry,
    list: &ListOf,
    base_dir: &Path,
) -> Option<Vec<Column>> {
    match &entry.node.value {
        Value::Text(name) => file(issues, entry, name, list, base_dir),
        Value::Array(rows) => rows_of(issues, &entry.node, rows, list),
        _ => {
            let spec = schema::find(MANIFEST, list.path)?;
            let given = Given {
                issues,
                node: &entry.node,
                path: list.path,
                spec,
            };
            given.wrong_type()
        }
    }
}

/// A column of quantities.
#[derive(Debug)]
pub(super) struct Quantities {
    /// Name of the quantity.
    pub name: &'static str,
    /// Place of the column's header and of each value.
    pub spans: (Span, Vec<Span>),
    /// Values in SI.
    pub values: Vec<f64>,
}

/// The columns as quantities with known names; `None` if one is faulty or unknown, which is reported.
pub(super) fn quantities(
    issues: &Issues,
    columns: Vec<Column>,
    list: &ListOf,
    known: &[&'static Key],
) -> Option<Vec<Quantities>> {
    let read = columns.into_iter().map(|column| {
        let name = column.name.key.as_str();
        let path = format!("{}.{name}", list.path);
        let Some(spec) = known.iter().find(|key| key.path == name) else {
            let names: Vec<&str> = known.iter().map(|key| key.path).collect();
            let message = format!("`{name}` is not a column of {}", list.path);
            return Diagnostic::new(
                DiagnosticKind::UnknownKey,
                column.name.key_span,
                &path,
                message,
            )
            .label("unknown")
            .accepted(names.join(", "))
            .remedy("rename the column, or remove it")
            .fail(issues);
        };
        let Kind::Quantity(dimension) = spec.kind else {
            return None;
        };
        let fits = column.unit_fits(issues, &path, Some(dimension));
        fits.then_some(())?;
        let values = column.values.iter();
        let values: Vec<Option<f64>> = values
            .map(|node| {
                let given = Given {
                    issues,
                    node,
                    path: &path,
                    spec,
                };
                given.quantity()
            })
            .collect();
        Some(Quantities {
            name: spec.path,
            spans: (
                column.name.key_span,
                column.values.iter().map(|node| node.span).collect(),
            ),
            values: values.into_iter().collect::<Option<_>>()?,
        })
    });
    all_or_none(read)
}

/// Removes and returns the only column whose name is one of `names`. Otherwise reports a fault: at `span` if there is
/// none, at the second one if there are several.
pub(super) fn one_of(
    issues: &Issues,
    columns: &mut Vec<Quantities>,
    names: &[&str],
    (list, span): (&ListOf, Span),
) -> Option<Quantities> {
    let places: Vec<usize> = (0..columns.len())
        .filter(|&k| names.contains(&columns[k].name))
        .collect();
    if let [place] = places[..] {
        return Some(columns.remove(place));
    }
    let (at, message, label) = match places.get(1) {
        None => (
            span,
            format!("{} needs a column `{}`", list.path, names.join("` or `")),
            "missing",
        ),
        Some(second) => (
            columns[*second].spans.0,
            format!(
                "{} has the columns `{}`; only one can be used",
                list.path,
                names.join("` and `")
            ),
            "second",
        ),
    };
    Diagnostic::new(DiagnosticKind::Inconsistent, at, list.path, message)
        .label(label)
        .remedy(format!(
            "begin a file with a header such as {}",
            list.header
        ))
        .fail(issues)
}

/// Whether a column has at least two values, each larger than the one before. Reports the fault if not.
pub(super) fn increases(issues: &Issues, column: &Quantities, list: &ListOf) -> bool {
    let pairs = column.values.windows(2);
    let fault = match pairs.clone().position(|pair| pair[1] <= pair[0]) {
        None if column.values.len() >= 2 => return true,
        None => (
            column.spans.0,
            format!("`{}` has one value; a course needs two", column.name),
        ),
        Some(place) => {
            let [before, value] = [place, place + 1].map(|k| schema::number(column.values[k]));
            let message = format!(
                "`{}` goes back or stays, from {before} to {value}",
                column.name
            );
            (column.spans.1[place + 1], message)
        }
    };
    Diagnostic::new(DiagnosticKind::Inconsistent, fault.0, list.path, fault.1)
        .label("not larger than before")
        .remedy(format!(
            "give `{}` in increasing order, without repeats",
            column.name
        ))
        .report(issues);
    false
}

impl Column {
    /// Whether the unit of the column has the dimension `wanted`; `None` (contact damping) accepts every known unit.
    /// A column without a unit fits. Reports a wrong unit.
    pub fn unit_fits(&self, issues: &Issues, path: &str, wanted: Option<Dimension>) -> bool {
        let Some((unit, span)) = &self.unit else {
            return true;
        };
        let quantity = units::parse_any(&format!("1 {unit}")).ok();
        let fits = match (quantity.map(|(_, dimension)| dimension), wanted) {
            (Some(quantity), Some(wanted)) => quantity == wanted,
            (quantity, None) => quantity.is_some(),
            (None, Some(_)) => false,
        };
        if !fits {
            let (needed, units) = match wanted {
                None => ("a damping ratio or coefficient", "%, N*s/m"),
                Some(wanted) if wanted.units().is_empty() => {
                    (wanted.name(), "no unit: write only the name")
                }
                Some(wanted) => (wanted.name(), wanted.units()),
            };
            let message = format!("`{unit}` is not a unit of `{}`", self.name.key);
            Diagnostic::new(DiagnosticKind::WrongUnit, *span, path, message)
                .label(format!("{needed} is needed here"))
                .accepted(units)
                .remedy("write the unit after the name of the column, such as speed [rpm]")
                .report(issues);
        }
        fits
    }
}

/// The columns of a list of tables in the manifest, one table per point.
fn rows_of(issues: &Issues, node: &Node, rows: &[Node], list: &ListOf) -> Option<Vec<Column>> {
    if rows.is_empty() {
        let message = format!("`{}` is empty", list.path);
        return Diagnostic::new(DiagnosticKind::Empty, node.span, list.path, message)
            .label("empty")
            .remedy(format!("give at least one point, {}", list.row))
            .fail(issues);
    }
    let mut columns: Vec<Column> = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        let Value::Table(entries) = &row.value else {
            let message = format!(
                "point {} must be a table, not {}",
                number + 1,
                row.value.type_name()
            );
            return Diagnostic::new(DiagnosticKind::WrongType, row.span, list.path, message)
                .label(format!("this is {}", row.value.type_name()))
                .accepted(list.row)
                .fail(issues);
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
        let without_column = columns
            .iter()
            .find(|column| row.entry(&column.name.key).is_none());
        let fault = match (extra, without_column) {
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
            return Diagnostic::new(DiagnosticKind::Inconsistent, span, list.path, message)
                .label(label)
                .remedy("give every point the same keys")
                .fail(issues);
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
fn file(
    issues: &Issues,
    entry: &Entry,
    name: &str,
    list: &ListOf,
    base_dir: &Path,
) -> Option<Vec<Column>> {
    let path = base_dir.join(name);
    let key = (list.path, entry.node.span);
    let source = text::read_named(issues, &path, "the list of points", key)?;
    let columns = csv::read(source, &issues.text(source), list, issues)?;
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
