//! Which key does an entry of `[grid]` vary?

use crate::manifest::axis::AxisKey;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::modal_keys;
use crate::manifest::schema::{self, Key, Kind, MANIFEST, SEED, VARIABLE_TABLES};
use crate::manifest::tree::{Entry, Value};
use crate::units::Dimension;

/// The path of an axis in messages.
pub(super) fn path_of(name: &str) -> String {
    if name.contains(['.', '[']) {
        format!("grid.\"{name}\"")
    } else {
        format!("grid.{name}")
    }
}

/// Dimension of an axis's values; `None` if the first value determines it.
pub(super) fn dimension_of(spec: &Key) -> Option<Dimension> {
    match spec.kind {
        Kind::Quantity(dimension) | Kind::Axis(dimension) => Some(dimension),
        Kind::ContactDamping => None,
        _ => Some(Dimension::Ratio),
    }
}

/// The schema's entry for the key of an axis; `None` if no axis can vary the key, which is reported.
pub(super) fn axis_key(issues: &Issues, entry: &Entry, path: &str) -> Option<&'static Key> {
    let name = entry.key.as_str();
    if !AxisKey::of(name).is_model_key() {
        return schema::find(MANIFEST, path);
    }
    if modal_keys::is_modal_number_name(name) {
        let spec = modal_keys::find(name);
        if spec.is_none() {
            issues.push_with(|| no_number(entry, path));
        }
        return spec;
    }
    let key = schema::find(MANIFEST, name).filter(|key| key.is_variable());
    let spec = key.filter(|spec| spec.can_be_axis());
    if spec.is_none() {
        issues.push_with(|| no_axis(entry, path, key));
    }
    spec
}

/// The message about a name that looks like a number of a modal file but is not one.
fn no_number(entry: &Entry, path: &str) -> Diagnostic {
    let message = format!("the axis `{}` is no number of a modal file", entry.key);
    Diagnostic::new(DiagnosticKind::UnknownAxis, entry.key_span, path, message)
        .label("unknown")
        .accepted(
            "a quantity of the file: \"rated_force\", \"frequency[1]\", \"stiffness_matrix[1,2]\", \
             \"contact.NAME.gap\", \"harmonic_load.NAME.force[1]\"; indices count from 1",
        )
        .suggestion(modal_keys::nearest(&entry.key).map(|near| format!("\"{near}\"")))
}

/// Why is an entry of `[grid]` not an axis?
fn no_axis(entry: &Entry, path: &str, key: Option<&Key>) -> Diagnostic {
    let name = entry.key.as_str();
    let fault = |message: String| {
        Diagnostic::new(DiagnosticKind::UnknownAxis, entry.key_span, path, message).accepted(
            "load, torque, speed, or a quoted key that takes a number, such as \"mesh.half_gap\"",
        )
    };
    if let Some(why) = key.and_then(Key::shared) {
        return fault(format!("`{name}` cannot be an axis: {why}"))
            .label("one value for the whole run")
            .remedy("write one manifest per value");
    }
    match key.map(|key| key.kind) {
        Some(Kind::List(_)) => fault(format!("`{name}` is a list; an axis varies one number"))
            .label("a list")
            .remedy(format!("name one element, \"{name}.0\", or a key below it")),
        Some(Kind::Table) if !name.contains('.') => {
            let inner = match &entry.node.value {
                Value::Table(entries) => entries.first().map(|inner| inner.key.as_str()),
                _ => None,
            };
            let full = format!("\"{name}.{}\"", inner.unwrap_or("key"));
            fault(format!("`{name}` is a table, not an axis"))
                .label("a table")
                .remedy(format!("put the whole key in quotes: {full} = ..."))
        }
        Some(_) => fault(format!("`{name}` is not a number, so it cannot be an axis"))
            .label("not a number")
            .remedy("write one manifest per value"),
        None if schema::find(MANIFEST, name).is_some() => {
            fault(format!("`{name}` cannot be an axis"))
                .label("not a key of a point")
                .remedy(format!(
                    "axes are keys of {}, and {SEED}",
                    VARIABLE_TABLES.join(", ")
                ))
        }
        None => fault(format!("the axis `{name}` is not a key of the manifest"))
            .label("unknown")
            .suggestion(nearest_axis(name)),
    }
}

/// The entry of `[grid]` or numeric key most like `name`, by the whole key or by its last part.
fn nearest_axis(name: &str) -> Option<String> {
    let paths: Vec<&str> = ["load", "torque", "speed", "points", "tied"]
        .into_iter()
        .chain(
            schema::all(MANIFEST)
                .filter(|key| {
                    matches!(
                        key.kind,
                        Kind::Quantity(_) | Kind::Integer | Kind::ContactDamping
                    )
                })
                .map(|key| key.path)
                .filter(|path| !path.contains(['*', '<'])),
        )
        .collect();
    schema::nearest_path(name, &paths).map(|near| {
        if near.contains('.') { format!("\"{near}\"") } else { near.to_owned() }
    })
}
