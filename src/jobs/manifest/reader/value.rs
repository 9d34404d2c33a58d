//! Single values: checks type, unit and range by the schema's entry of their key.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::schema::{self, Key, Kind};
use crate::manifest::tree::{Node, Value};
use crate::units::{self, Dimension, QuantityError};

/// Records a value of another type than in the schema.
pub(in crate::manifest) fn wrong_type(issues: &mut Issues, node: &Node, path: &str, spec: &Key) {
    let wanted = match spec.kind {
        Kind::Quantity(dimension) => dimension.name(),
        Kind::Integer => "a whole number",
        Kind::Boolean => "true or false",
        Kind::Text | Kind::Choice(_) => "a text in quotes",
        Kind::List(_) => "a list in [ ]",
        Kind::ContactDamping => "a damping ratio or coefficient",
        Kind::Initial => "\"static\", \"rest\" or a table",
        Kind::Table => "a table",
        Kind::Axis(_) => "a value or a table of values",
        Kind::Points => "a list of points or the path of a file",
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::WrongType,
            node.span,
            path,
            format!("`{path}` must be {wanted}, not {}", node.value.type_name()),
        )
        .label(format!("this is {}", node.value.type_name()))
        .accepted(spec.accepted()),
    );
}

/// A quantity without its range, in SI.
pub(in crate::manifest) fn quantity_unbounded(
    issues: &mut Issues,
    node: &Node,
    path: &str,
    dimension: Dimension,
    spec: &Key,
) -> Option<f64> {
    match &node.value {
        Value::Float(value) | Value::Sample(value, _) => Some(*value + 0.0),
        Value::Integer(value) => Some(*value as f64),
        Value::Text(text) => match units::parse(text, dimension) {
            Ok(value) => Some(value + 0.0),
            Err(error) => {
                wrong_unit(issues, node, path, dimension, &error, spec);
                None
            }
        },
        _ => {
            wrong_type(issues, node, path, spec);
            None
        }
    }
}

/// A quantity in its range, in SI.
pub(in crate::manifest) fn quantity(
    issues: &mut Issues,
    node: &Node,
    path: &str,
    spec: &Key,
) -> Option<f64> {
    let (Kind::Quantity(dimension) | Kind::Axis(dimension)) = spec.kind else {
        unreachable!("`{path}` is read as a quantity but is none in the schema")
    };
    let value = quantity_unbounded(issues, node, path, dimension, spec)?;
    in_range(issues, node, path, value, dimension, spec)
}

/// The value if it is in the key's range.
pub(in crate::manifest) fn in_range(
    issues: &mut Issues,
    node: &Node,
    path: &str,
    value: f64,
    dimension: Dimension,
    spec: &Key,
) -> Option<f64> {
    if spec.bounds.contain(value) {
        return Some(value);
    }
    let unit = match dimension {
        Dimension::Ratio => String::new(),
        _ => format!(" {}", dimension.unit()),
    };
    let (message, label) = if value.is_finite() {
        (
            format!("`{path}` = {}{unit} is out of range", schema::number(value)),
            format!("must be {}{unit}", spec.bounds.words()),
        )
    } else {
        (
            format!("`{path}` is not a finite number"),
            "not finite".to_owned(),
        )
    };
    let mut diagnostic = Diagnostic::new(DiagnosticKind::OutOfRange, node.span, path, message)
        .label(label)
        .accepted(spec.accepted());
    if let Some(remedy) = meant(&node.value, spec) {
        diagnostic = diagnostic.remedy(remedy);
    }
    issues.push(diagnostic);
    None
}

/// Likely meaning of a bare number: the same number in the unit of the key's example, if that is in range.
pub(in crate::manifest) fn meant(value: &Value, spec: &Key) -> Option<String> {
    let number = match value {
        Value::Integer(number) => *number as f64,
        Value::Float(number) => *number,
        _ => return None,
    };
    let Kind::Quantity(dimension) = spec.kind else {
        return None;
    };
    let example = spec.example.trim_matches(|c: char| "[]\"".contains(c));
    let example = example.split('"').next().unwrap_or(example);
    let (_, unit) = example.split_once(' ')?;
    let number = schema::number(number);
    let meant = format!("{number} {unit}");
    let inside = units::parse(&meant, dimension).is_ok_and(|value| spec.bounds.contain(value));
    let other = unit != dimension.unit() && inside;
    other.then(|| {
        let own = dimension.unit();
        format!("a bare number is in {own}: write the unit, such as \"{meant}\"")
    })
}

/// Records text that is not a quantity of the expected dimension.
pub(in crate::manifest) fn wrong_unit(
    issues: &mut Issues,
    node: &Node,
    path: &str,
    dimension: Dimension,
    error: &QuantityError,
    spec: &Key,
) {
    let mut diagnostic = Diagnostic::new(
        DiagnosticKind::WrongUnit,
        node.span,
        path,
        format!("`{path}`: {error}"),
    )
    .label(format!("{} is needed here", dimension.name()))
    .accepted(spec.accepted());
    if let QuantityError::MissingUnit { text } = error {
        let number = text.trim();
        diagnostic = diagnostic.remedy(if dimension.units().is_empty() {
            format!("remove the quotes: {number}")
        } else if dimension == Dimension::Ratio {
            format!("remove the quotes ({number}), or write \"{number} %\"")
        } else {
            format!(
                "write the unit (\"{number} {}\"), or remove the quotes: a bare number is in {}",
                dimension.unit(),
                dimension.unit()
            )
        });
    }
    issues.push(diagnostic);
}

/// A whole number in its range.
pub(in crate::manifest) fn integer(
    issues: &mut Issues,
    node: &Node,
    path: &str,
    spec: &Key,
) -> Option<u64> {
    let value = match node.value {
        Value::Integer(value) => value,
        Value::Sample(value, _) if value.fract() == 0.0 && value.abs() < 9e15 => value as i64,
        Value::Sample(value, _) | Value::Float(value) => {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::WrongType,
                    node.span,
                    path,
                    format!(
                        "`{path}` must be a whole number, not {}",
                        schema::number(value)
                    ),
                )
                .label("not a whole number")
                .accepted(spec.accepted()),
            );
            return None;
        }
        _ => {
            wrong_type(issues, node, path, spec);
            return None;
        }
    };
    if spec.bounds.contain(value as f64) {
        return u64::try_from(value).ok();
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::OutOfRange,
            node.span,
            path,
            format!("`{path}` = {value} is out of range"),
        )
        .label("out of range")
        .accepted(spec.accepted()),
    );
    None
}

/// One of the schema's words.
pub(in crate::manifest) fn choice(
    issues: &mut Issues,
    node: &Node,
    path: &str,
    spec: &Key,
) -> Option<&'static str> {
    let Kind::Choice(choices) = spec.kind else {
        unreachable!("`{path}` is read as a choice but is none in the schema")
    };
    let Value::Text(text) = &node.value else {
        wrong_type(issues, node, path, spec);
        return None;
    };
    if let Some(choice) = choices.iter().find(|choice| *choice == text) {
        return Some(choice);
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::OutOfRange,
            node.span,
            path,
            format!("`{path}` cannot be \"{text}\""),
        )
        .label("not one of the choices")
        .accepted(spec.accepted())
        .suggestion(schema::nearest(text, choices).map(|near| format!("\"{near}\""))),
    );
    None
}
