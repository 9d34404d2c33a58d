//! Single values: checks type, unit and range by the schema's entry of their key.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::schema::{self, Key, Kind};
use crate::manifest::tree::{Node, Value};
use crate::units::{self, Dimension, QuantityError};

/// Largest whole number up to which a double represents every whole number.
pub(in crate::manifest) const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// A value with its path and the schema's entry of its key. Its methods read the value and record faults.
#[derive(Clone, Copy)]
pub(in crate::manifest) struct Given<'a> {
    pub issues: &'a Issues,
    pub node: &'a Node,
    pub path: &'a str,
    pub spec: &'a Key,
}

impl<'a> Given<'a> {
    fn fault(self, kind: DiagnosticKind, message: String) -> Diagnostic {
        let fault = Diagnostic::new(kind, self.node.span, self.path, message);
        fault.accepted(self.spec.accepted())
    }

    /// Records a value of the wrong type, and returns `None`.
    pub fn wrong_type<T>(self) -> Option<T> {
        let wanted = match self.spec.kind {
            Kind::Quantity(dimension) => dimension.name(),
            Kind::Integer => "a whole number",
            Kind::Boolean => "true or false",
            Kind::Text | Kind::Choice(_) => "a text in quotes",
            Kind::List(_) => "a list in [ ]",
            Kind::ContactDamping => "a damping ratio or coefficient",
            Kind::InitialState => "\"static\", \"rest\" or a table",
            Kind::Table => "a table",
            Kind::Axis(_) => "a value or a table of values",
            Kind::Points => "a list of points or the path of a file",
        };
        let type_name = self.node.value.type_name();
        let message = format!("`{}` must be {wanted}, not {type_name}", self.path);
        self.fault(DiagnosticKind::WrongType, message)
            .label(format!("this is {type_name}"))
            .fail(self.issues)
    }

    /// A text.
    pub fn text(self) -> Option<&'a str> {
        match &self.node.value {
            Value::Text(text) => Some(text),
            _ => self.wrong_type(),
        }
    }

    /// A quantity in SI of any size.
    pub fn quantity_unbounded(self, dimension: Dimension) -> Option<f64> {
        match &self.node.value {
            Value::Float(value) | Value::Sample(value, _) => Some(*value + 0.0),
            Value::Integer(value) => Some(*value as f64),
            Value::Text(text) => match units::parse(text, dimension) {
                Ok(value) => Some(value + 0.0),
                Err(error) => self.wrong_unit(dimension, &error),
            },
            _ => self.wrong_type(),
        }
    }

    /// A quantity in SI. Records a value outside the range of its key.
    pub fn quantity(self) -> Option<f64> {
        let (Kind::Quantity(dimension) | Kind::Axis(dimension)) = self.spec.kind else {
            let path = self.path;
            unreachable!("`{path}` is read as a quantity but is none in the schema")
        };
        let value = self.quantity_unbounded(dimension)?;
        self.in_range(value, dimension)
    }

    /// The value if it is in the key's range; otherwise records a fault.
    pub fn in_range(self, value: f64, dimension: Dimension) -> Option<f64> {
        let Self { path, spec, .. } = self;
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
        let mut fault = self.fault(DiagnosticKind::OutOfRange, message).label(label);
        if let Some(remedy) = meant(&self.node.value, spec) {
            fault = fault.remedy(remedy);
        }
        fault.fail(self.issues)
    }

    /// Records a text that is not a quantity of the expected dimension, and returns `None`.
    pub fn wrong_unit<T>(self, dimension: Dimension, error: &QuantityError) -> Option<T> {
        let message = format!("`{}`: {error}", self.path);
        let mut fault = self
            .fault(DiagnosticKind::WrongUnit, message)
            .label(format!("{} is needed here", dimension.name()));
        if let QuantityError::MissingUnit { text } = error {
            let (number, unit) = (text.trim(), dimension.unit());
            fault = fault.remedy(if dimension.units().is_empty() {
                format!("remove the quotes: {number}")
            } else if dimension == Dimension::Ratio {
                format!("remove the quotes ({number}), or write \"{number} %\"")
            } else {
                format!(
                    "write the unit (\"{number} {unit}\"), or remove the quotes: a bare number is in {unit}"
                )
            });
        }
        fault.fail(self.issues)
    }

    /// A whole number in its range.
    pub fn integer(self) -> Option<u64> {
        let path = self.path;
        let value = match self.node.value {
            Value::Integer(value) => value,
            Value::Sample(value, _) if value.fract() == 0.0 && value.abs() <= EXACT as f64 => {
                value as i64
            }
            Value::Sample(value, _) | Value::Float(value) => {
                let value = schema::number(value);
                let message = format!("`{path}` must be a whole number, not {value}");
                return self
                    .fault(DiagnosticKind::WrongType, message)
                    .label("not a whole number")
                    .fail(self.issues);
            }
            _ => return self.wrong_type(),
        };
        if self.spec.bounds.contain(value as f64) {
            return u64::try_from(value).ok();
        }
        let message = format!("`{path}` = {value} is out of range");
        self.fault(DiagnosticKind::OutOfRange, message)
            .label("out of range")
            .fail(self.issues)
    }

    /// One of the schema's words.
    pub fn choice(self) -> Option<&'static str> {
        let Kind::Choice(choices) = self.spec.kind else {
            let path = self.path;
            unreachable!("`{path}` is read as a choice but is none in the schema")
        };
        let text = self.text()?;
        let choice = choices.iter().find(|choice| **choice == text);
        choice.copied().or_else(|| self.not_a_choice(text, choices))
    }

    /// Records a text that is not one of some words, and returns `None`.
    pub fn not_a_choice<T>(self, text: &str, choices: &[&str]) -> Option<T> {
        let message = format!("`{}` cannot be \"{text}\"", self.path);
        self.fault(DiagnosticKind::OutOfRange, message)
            .label("not one of the choices")
            .suggestion(schema::nearest(text, choices).map(|near| format!("\"{near}\"")))
            .fail(self.issues)
    }
}

/// A remedy for a bare number: the same number with the unit of the key's example, if that quantity is in range.
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
        let si_unit = dimension.unit();
        format!("a bare number is in {si_unit}: write the unit, such as \"{meant}\"")
    })
}
