//! Single values in the JSON Schema: types, ranges, words, units.

use crate::manifest::schema::{Bounds, DefaultValue, Key, Kind};
use crate::units::Dimension;
use serde_json::{Map, Value, json};

/// The accepted values of a key that is neither a table nor a list.
pub(super) fn value(key: &Key) -> Value {
    let mut forms = scalar(key);
    if key.pair.is_some() {
        forms.push(json!({
            "type": "array", "minItems": 2, "maxItems": 2, "items": { "anyOf": forms }
        }));
    }
    if let [form] = forms.as_slice() {
        return form.clone();
    }
    json!({ "anyOf": forms })
}

/// The forms of one value of a key.
pub(super) fn scalar(key: &Key) -> Vec<Value> {
    match key.kind {
        Kind::Quantity(dimension) | Kind::Axis(dimension) => {
            let mut forms = vec![number("number", key.bounds)];
            forms.extend(text(dimension));
            forms
        }
        Kind::Integer => vec![number("integer", key.bounds)],
        Kind::Boolean => vec![json!({ "type": "boolean" })],
        Kind::Choice(words) => vec![json!({ "type": "string", "enum": words })],
        Kind::ContactDamping => {
            let mut forms = vec![number("number", key.bounds)];
            forms.extend(text(Dimension::Ratio));
            forms.extend(text(Dimension::Damping));
            forms
        }
        Kind::Text | Kind::List(_) | Kind::InitialState | Kind::Table | Kind::Points => {
            vec![json!({ "type": "string" })]
        }
    }
}

/// A number in a range.
fn number(kind: &str, bounds: Bounds) -> Value {
    let mut form = json!({ "type": kind });
    let mut bound = |name: &str, value: f64| {
        let whole = value.fract() == 0.0 && value.abs() < 9e15;
        let value = if whole { json!(value as i64) } else { json!(value) };
        form[name] = value;
    };
    if bounds.min.is_finite() {
        let name = if bounds.min_open { "exclusiveMinimum" } else { "minimum" };
        bound(name, bounds.min);
    }
    if bounds.max.is_finite() {
        let name = if bounds.max_open { "exclusiveMaximum" } else { "maximum" };
        bound(name, bounds.max);
    }
    form
}

/// A text with a unit, as [`texts`] defines it; `None` if only bare numbers are accepted.
fn text(dimension: Dimension) -> Option<Value> {
    let known = dimension.pattern().is_some();
    known.then(|| json!({ "$ref": format!("#/definitions/text_{dimension:?}") }))
}

/// Texts with units, by dimension.
pub(super) fn texts() -> Map<String, Value> {
    let form = |dimension: Dimension| {
        let form = json!({ "type": "string", "pattern": dimension.pattern()? });
        Some((format!("text_{dimension:?}"), form))
    };
    Dimension::with_text_form().filter_map(form).collect()
}

/// The default, if it is a value and not words.
pub(super) fn default(key: &Key) -> Option<Value> {
    match key.default {
        DefaultValue::Value(text) => toml_value(text),
        DefaultValue::Required | DefaultValue::Words(_) => None,
    }
}

/// The example, if any.
pub(super) fn example(key: &Key) -> Option<Value> {
    toml_value(key.example)
}

/// A value from its text in a manifest.
fn toml_value(text: &str) -> Option<Value> {
    let mut table: toml::Table = format!("x = {text}").parse().ok()?;
    serde_json::to_value(table.remove("x")?).ok()
}
