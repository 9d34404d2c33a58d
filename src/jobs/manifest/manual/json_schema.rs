//! The manual for editors: a JSON Schema (draft 7), for Taplo and Even Better TOML.
//!
//! It has tables, keys, types, ranges, words and units. Only `atlas check` judges rules about several keys. A manifest
//! that the program accepts satisfies the schema.

mod value;

use crate::manifest::modal_keys;
use crate::manifest::schema::{self, DefaultValue, Key, Kind, MANIFEST, SHARED};
use serde_json::{Map, Value, json};
use value::{default, example, scalar, texts, value};

/// The schema of a manifest, as text.
pub fn json_schema() -> String {
    let axes = axes();
    let mut top = table("");
    add_axes(&mut top["properties"]["grid"], &axes);
    // The grid is required, although none of its keys is.
    if let Some(required) = top["required"].as_array_mut() {
        required.push(json!("grid"));
    }
    let schema = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Manifest of atlas",
        "description": "A gear drive, a grid of operating points, and the analyses of each point.",
        "type": top["type"],
        "additionalProperties": top["additionalProperties"],
        "required": top["required"],
        "properties": top["properties"],
        "definitions": definitions(&axes),
    });
    format!("{schema:#}\n")
}

/// A table and everything below it.
fn table(path: &str) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for (name, path, key) in children(path) {
        properties.insert(name.to_owned(), node(&path, key));
        if must_stand(&path, key) {
            required.push(name);
        }
    }
    let mut table = json!({ "type": "object", "additionalProperties": false });
    if !required.is_empty() {
        table["required"] = json!(required);
    }
    table["properties"] = Value::Object(properties);
    table
}

/// Names, paths and entries of the keys of a table.
fn children(path: &str) -> impl Iterator<Item = (&'static str, String, &'static Key)> {
    let path = path.to_owned();
    schema::children(MANIFEST, &path)
        .into_iter()
        .filter_map(move |name| {
            let path = match path.as_str() {
                "" => name.to_owned(),
                path => format!("{path}.{name}"),
            };
            let key = schema::find(MANIFEST, &path)?;
            Some((name, path, key))
        })
}

/// Whether a key is required in its table. A key that the grid may vary is not: an axis may give it.
fn must_stand(path: &str, key: &Key) -> bool {
    key.default == DefaultValue::Required
        && match key.kind {
            Kind::Table => children(path).any(|(_, path, key)| must_stand(&path, key)),
            _ => !key.can_be_axis(),
        }
}

/// A key and everything below it.
fn node(path: &str, key: &Key) -> Value {
    let of_one = key.is_of_one_gear(path);
    let key = &Key {
        pair: key.pair.filter(|_| !of_one),
        ..*key
    };
    let mut node = match key.kind {
        Kind::Table => table(path),
        Kind::List(_) => list(path, key),
        Kind::InitialState => json!({ "anyOf": [{ "enum": ["static", "rest"] }, table(path)] }),
        Kind::Axis(_) => axis_reference(key),
        Kind::Points => {
            let point = json!({ "type": "object", "minProperties": 1 });
            let list = json!({ "type": "array", "minItems": 1, "items": point });
            json!({ "anyOf": [{ "type": "string" }, list] })
        }
        _ => value(key),
    };
    if !key.about.is_empty() {
        node["description"] = json!(key.about);
    }
    if let Some(default) = default(key) {
        node["default"] = default;
    }
    // Examples of these lists name a gear, which the table of one gear does not allow.
    let has_examples = !(of_one && key.kind == Kind::List("tables"));
    if let Some(example) = example(key).filter(|_| has_examples) {
        node["examples"] = json!([example]);
    }
    node
}

fn list(path: &str, key: &Key) -> Value {
    let mut list = json!({ "type": "array" });
    if let Some(length) = key.length {
        list["minItems"] = json!(length);
        list["maxItems"] = json!(length);
    }
    let elements = format!("{path}.0");
    if let Some(key) = schema::find(MANIFEST, &elements) {
        list["items"] = node(&elements, key);
    }
    list
}

/// Paths that can be axes besides load, torque and speed. A key that several tables share has several paths.
fn axes() -> Vec<(String, &'static Key)> {
    let mut axes = Vec::new();
    for key in schema::all(MANIFEST).filter(|key| key.can_be_axis()) {
        let shared = (SHARED.iter()).filter(|(_, _, which)| key.elsewhere == *which);
        let elsewhere = shared.filter_map(|(table, of, _)| {
            let rest = key.path.strip_prefix(of)?;
            Some(format!("{table}{rest}"))
        });
        for path in std::iter::once(key.path.to_owned()).chain(elsewhere) {
            if path.contains("<shaft>") {
                let shafts = ["pinion", "wheel"];
                axes.extend(shafts.map(|shaft| (path.replace("<shaft>", shaft), key)));
            } else {
                axes.push((path, key));
            }
        }
    }
    axes
}

/// Adds the quoted axes to the schema of `[grid]`; axes with indices are patterns.
fn add_axes(grid: &mut Value, axes: &[(String, &Key)]) {
    let mut patterns = Map::new();
    let mut plain = Map::new();
    for (path, key) in axes {
        let mut axis = axis_reference(key);
        if !key.about.is_empty() {
            axis["description"] = json!(key.about);
        }
        let pattern = |path: &str| {
            let escaped = path.replace('.', r"\.").replace('*', r"\d+");
            format!("^{escaped}$")
        };
        if path.contains('*') {
            patterns.insert(pattern(path), axis);
            continue;
        }
        if key.pair.is_some() {
            let element = format!("{path}.*");
            patterns.insert(pattern(&element), axis.clone());
        }
        plain.insert(path.clone(), axis);
    }
    for (form, key) in modal_keys::forms() {
        let escaped = form
            .replace('.', r"\.")
            .replace('[', r"\[")
            .replace(']', r"\]");
        let pattern = escaped.replace("NAME", ".+").replace('N', r"\d+");
        patterns.insert(format!("^{pattern}$"), axis_reference(key));
    }
    if let Some(properties) = grid["properties"].as_object_mut() {
        properties.append(&mut plain);
    }
    grid["patternProperties"] = Value::Object(patterns);
    let ways = [&["points"][..], &["speed"]];
    grid["anyOf"] = json!(ways.map(|keys| json!({ "required": keys })));
}

/// The name of the definition of a key's value: keys of the same kind and range share one.
fn value_name(key: &Key) -> String {
    let kind = match key.kind {
        Kind::Quantity(dimension) | Kind::Axis(dimension) => format!("{dimension:?}"),
        kind => format!("{kind:?}"),
    };
    let words = format!("{kind} {}", key.range());
    let parts: Vec<&str> = words
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '.')
        .filter(|part| !part.is_empty())
        .collect();
    parts.join("_")
}

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/definitions/{name}") })
}

fn axis_reference(key: &Key) -> Value {
    // Draft 7 ignores everything beside `$ref`.
    let form = reference(&format!("axis_{}", value_name(key)));
    json!({ "allOf": [form] })
}

/// Texts with units, the values of axes, and every kind of axis.
fn definitions(axes: &[(String, &'static Key)]) -> Value {
    let of_manifest = schema::all(MANIFEST).filter(|key| matches!(key.kind, Kind::Axis(_)));
    let mut definitions = texts();
    definitions.insert("distribution".to_owned(), distribution());
    let of_files = modal_keys::forms().map(|(_, key)| key);
    for key in of_manifest
        .chain(axes.iter().map(|(_, key)| *key))
        .chain(of_files)
    {
        let name = value_name(key);
        let whole = key.kind == Kind::Integer;
        definitions.insert(format!("axis_{name}"), axis(&reference(&name), whole));
        definitions.insert(name, json!({ "anyOf": scalar(key) }));
    }
    Value::Object(definitions)
}

/// One value, a list, an even range, or, except for whole numbers, a distribution.
fn axis(one: &Value, whole: bool) -> Value {
    let mut axis = json!({ "anyOf": [
        one,
        {
            "type": "object",
            "additionalProperties": false,
            "required": ["values"],
            "properties": { "values": {
                "description": "The values, one by one.",
                "type": "array", "minItems": 1, "items": one
            } }
        },
        {
            "type": "object",
            "additionalProperties": false,
            "required": ["from", "to", "count"],
            "properties": {
                "from": { "description": "The first value.", "allOf": [one] },
                "to": { "description": "The last value.", "allOf": [one] },
                "count": {
                    "description": "Number of values, both ends included.",
                    "type": "integer", "minimum": 1
                },
                "spacing": {
                    "description": "Whether the values or their logarithms are evenly spaced.",
                    "enum": ["linear", "log"], "default": "linear"
                }
            }
        }
    ] });
    if let Some(forms) = axis["anyOf"].as_array_mut().filter(|_| !whole) {
        forms.push(reference("distribution"));
    }
    axis
}

/// A distribution. Only `atlas check` judges units and ranges of its parameters.
fn distribution() -> Value {
    let laws = ["normal", "lognormal", "uniform", "empirical"];
    let value = json!({ "type": ["number", "string"] });
    let pair = |about: &str| json!({ "description": about, "type": "array", "minItems": 2, "maxItems": 2, "items": value });
    json!({
        "type": "object",
        "additionalProperties": false,
        "oneOf": laws.map(|law| json!({ "required": [law] })),
        "properties": {
            "normal": pair("Mean and standard deviation."),
            "lognormal": pair("Median, and standard deviation of the natural logarithm."),
            "uniform": pair("Smallest and largest value."),
            "empirical": {
                "description": "Equally likely values, or the path of a file with a column of them.",
                "anyOf": [{ "type": "string" }, { "type": "array", "minItems": 1, "items": value }]
            },
            "truncate": pair("Smallest and largest value that are kept.")
        }
    })
}
