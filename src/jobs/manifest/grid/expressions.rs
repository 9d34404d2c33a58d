//! Axes given by expressions: each is tied to the axes in its expression.

use super::axis_key::{axis_key, dimension_of, path_of};
use super::grid_axis::GridAxis;
use super::values::Spans;
use crate::manifest::axis::{AxisKey, AxisValues};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::expression::{ACCEPTED, Expression};
use crate::manifest::reader::Given;
use crate::manifest::schema::{self, Key, Kind};
use crate::manifest::tree::{Entry, Value};
use crate::units::Dimension;

/// An entry of `[grid]` that is an expression.
pub(super) struct Pending<'t> {
    entry: &'t Entry,
    spec: &'static Key,
    expression: Expression,
}

impl Pending<'_> {
    /// Name of its axis.
    pub fn name(&self) -> &str {
        &self.entry.key
    }
}

/// Whether an entry is an expression.
pub(super) fn is_expression(entry: &Entry) -> bool {
    matches!(&entry.node.value, Value::Text(text) if Expression::is_expression(text))
}

/// Reads an entry; `None` if it is faulty, which is reported.
pub(super) fn read<'t>(issues: &Issues, entry: &'t Entry) -> Option<Pending<'t>> {
    let path = path_of(&entry.key);
    let spec = axis_key(issues, entry, &path)?;
    let Value::Text(text) = &entry.node.value else {
        return None;
    };
    if spec.kind == Kind::Integer {
        let message = format!(
            "`{}` takes whole numbers, so no expression can give it",
            entry.key
        );
        let fault = fault(entry, message);
        return fault.remedy("give it as { values = [...] }").fail(issues);
    }
    match Expression::parse(text) {
        Ok(expression) => Some(Pending {
            entry,
            spec,
            expression,
        }),
        Err(why) => {
            let message = format!("`{}` cannot be read as an expression: {why}", text.trim());
            fault(entry, message).accepted(ACCEPTED).fail(issues)
        }
    }
}

/// Adds the axes given by expressions; each is tied to the axes in its expression. Returns the expressions by
/// the name of their axis, each after the expressions of the axes in it. Adds the names of faulty axes to `faulty`.
pub(super) fn add(
    issues: &Issues,
    mut pending: Vec<Pending<'_>>,
    axes: &mut Vec<GridAxis>,
    groups: &mut Vec<Vec<usize>>,
    faulty: &mut Vec<String>,
) -> Vec<(String, Expression)> {
    let mut found = Vec::new();
    while let Some(next) = pending.iter().position(|own| {
        let known = |name: &String| axes.iter().any(|axis| axis.axis.name() == name);
        own.expression.names().iter().all(known)
    }) {
        let own = pending.remove(next);
        match axis(issues, &own, axes, groups) {
            Some(axis) => {
                found.push((own.entry.key.clone(), own.expression));
                axes.push(axis);
            }
            None => faulty.push(own.entry.key.clone()),
        }
    }
    for own in &pending {
        // If an axis in the expression is faulty, that has been reported.
        if !own
            .expression
            .names()
            .iter()
            .any(|name| faulty.contains(name))
        {
            issues.push(without_value(own, &pending, axes));
        }
    }
    faulty.extend(pending.iter().map(|own| own.entry.key.clone()));
    found
}

/// The axis that an expression computes from known axes. It joins their group of tied axes.
fn axis(
    issues: &Issues,
    derived: &Pending<'_>,
    axes: &[GridAxis],
    groups: &mut Vec<Vec<usize>>,
) -> Option<GridAxis> {
    let (entry, expression) = (derived.entry, &derived.expression);
    let place = |name: &str| axes.iter().position(|axis| axis.axis.name() == name);
    let needed: Vec<usize> = expression
        .names()
        .iter()
        .filter_map(|name| place(name))
        .collect();
    let varied = |axis: &&usize| axes[**axis].axis.values.len() > 1;
    let group = |axis: usize| groups.iter().position(|group| group.contains(&axis));
    let mut along = needed.iter().filter(varied);
    let first = along.next().copied();
    let apart = |axis: &&usize| {
        first.is_some_and(|first| {
            first != **axis && (group(first).is_none() || group(first) != group(**axis))
        })
    };
    if let (Some(first), Some(&other)) = (first, along.find(apart)) {
        let [first, other] = [first, other].map(|axis| axes[axis].axis.name().to_owned());
        let message = format!(
            "`{}` needs `{first}` and `{other}`, which the grid combines, but an expression follows axes that advance together",
            expression.text()
        );
        return fault(entry, message)
            .label("axes that are combined")
            .remedy("tie them, give the points as a list, or give one of them a factor of its own, such as harmonic_load.NAME.amplitude beside force")
            .fail(issues);
    }
    let path = path_of(&entry.key);
    let dimension = dimension_of(derived.spec).unwrap_or(Dimension::Ratio);
    let length = first.map_or(1, |first| axes[first].axis.values.len());
    let mut values = Vec::with_capacity(length);
    for at in 0..length {
        let value = expression.value(|name| {
            let values = place(name).map(|axis| &axes[axis].axis.values);
            values.map_or(f64::NAN, |values| {
                values.get(if values.len() > 1 { at } else { 0 })
            })
        });
        let value = match value {
            Ok(value) => value,
            Err(why) => return fault(entry, format!("`{}`: {why}", entry.key)).fail(issues),
        };
        let given = Given {
            issues,
            node: &entry.node,
            path: &path,
            spec: derived.spec,
        };
        values.push(given.in_range(value, dimension)?);
    }
    if let Some(first) = first {
        match group(first) {
            Some(group) => groups[group].push(axes.len()),
            None => groups.push(vec![first, axes.len()]),
        }
    }
    let values = (AxisValues::each(values), Spans::Whole(entry.node.span));
    let key = AxisKey::of(&entry.key);
    Some(GridAxis::new(key, entry.key_span, dimension, values))
}

/// The fault of an expression without a value: an unknown name, or a circle of expressions.
fn without_value(derived: &Pending<'_>, pending: &[Pending<'_>], axes: &[GridAxis]) -> Diagnostic {
    let (names, text) = (derived.expression.names(), derived.expression.text());
    let known: Vec<&str> = (axes.iter().map(|axis| axis.axis.name()))
        .chain(pending.iter().map(|other| other.entry.key.as_str()))
        .collect();
    match names.iter().find(|name| !known.contains(&name.as_str())) {
        Some(name) => fault(
            derived.entry,
            format!("`{text}` names `{name}`, which is no axis of the grid"),
        )
        .label("unknown name")
        .accepted(ACCEPTED)
        .suggestion(schema::nearest(name, &known).map(|near| format!("`{near}`")))
        .remedy(format!("give `{name}` in [grid], where one value will do")),
        None => {
            let circle: Vec<&str> = pending
                .iter()
                .map(|other| other.entry.key.as_str())
                .collect();
            fault(
                derived.entry,
                format!("`{text}` needs its own value: {}", circle.join(", ")),
            )
            .label("a circle of expressions")
            .remedy("give one of these axes values")
        }
    }
}

fn fault(entry: &Entry, message: String) -> Diagnostic {
    Diagnostic::new(
        DiagnosticKind::Inconsistent,
        entry.node.span,
        &path_of(&entry.key),
        message,
    )
    .label("not a value")
}
