//! Changes of keys that mostly keep a manifest valid: numbers over three decades, units kept, and keys of the schema
//! with the values of its examples.

use super::dice::Dice;
use gearatlas::manifest::manual::json_schema;
use gearatlas::units::split;
use toml::Value;

/// Keys to change, with their possible values.
pub struct Changes {
    /// The keys of each manifest.
    own: Vec<Vec<(String, Value)>>,
    /// Keys of the schema, each with an example in TOML.
    examples: Vec<(String, String)>,
}

/// Tables whose keys define a drive and its operating point.
const TABLES: [&str; 7] = [
    "model",
    "gear",
    "shafts",
    "train",
    "mesh",
    "excitation",
    "grid",
];

impl Changes {
    /// Changes of some manifests.
    pub fn of(manifests: &[&str]) -> Self {
        let schema = serde_json::from_str(&json_schema()).unwrap();
        let mut examples = Vec::new();
        gather(&schema, "", &mut examples);
        let own = manifests.iter().map(|text| {
            let mut keys = Vec::new();
            let table: toml::Table = text.parse().unwrap();
            for (name, value) in table {
                leaves(name, value, &mut keys);
            }
            keys.retain(|(key, _)| TABLES.contains(&key.split('.').next().unwrap()));
            keys
        });
        Self {
            own: own.collect(),
            examples,
        }
    }

    /// The number of a manifest, and changes of it, one per line.
    pub fn draw(&self, dice: &mut Dice) -> Vec<u8> {
        let base = dice.below(self.own.len());
        let mut bytes = vec![base as u8];
        for _ in 0..1 + dice.below(5) {
            let line = if dice.chance(0.2) {
                let (key, example) = &self.examples[dice.below(self.examples.len())];
                format!("{key}={example}")
            } else {
                let (key, value) = &self.own[base][dice.below(self.own[base].len())];
                format!("{key}={}", changed(value, dice))
            };
            bytes.extend(line.bytes());
            bytes.push(b'\n');
        }
        bytes
    }
}

/// A random replacement for a value.
fn changed(value: &Value, dice: &mut Dice) -> String {
    let scaled = |number: f64, dice: &mut Dice| match dice.below(12) {
        0 => 0.0,
        1 => -number,
        2 => number * dice.decades(-6.0, 6.0),
        3..6 => number * dice.between(0.9, 1.1),
        _ => number * dice.decades(-1.5, 1.5),
    };
    match value {
        Value::Integer(number) => {
            if dice.chance(0.8) {
                format!("{}", number + dice.below(5) as i64 - 2)
            } else {
                format!("{}", scaled(*number as f64, dice).round())
            }
        }
        Value::Float(number) => format!("{:e}", scaled(*number, dice)),
        Value::Boolean(truth) => (!truth).to_string(),
        Value::String(text) => match split(text) {
            Some((number, unit)) => format!("{:e} {unit}", scaled(number, dice)),
            None => text.clone(),
        },
        other => other.to_string(),
    }
}

/// The dotted keys of a value that contain no other keys.
fn leaves(key: String, value: Value, keys: &mut Vec<(String, Value)>) {
    match value {
        Value::Table(table) => {
            for (name, value) in table {
                let name = if name.contains('.') { format!("\"{name}\"") } else { name };
                leaves(format!("{key}.{name}"), value, keys);
            }
        }
        Value::Array(values) => {
            for (place, value) in values.into_iter().enumerate() {
                leaves(format!("{key}.{place}"), value, keys);
            }
        }
        plain => keys.push((key, plain)),
    }
}

/// Keys of plain tables with their examples.
fn gather(schema: &serde_json::Value, path: &str, examples: &mut Vec<(String, String)>) {
    let Some(properties) = schema["properties"].as_object() else {
        return;
    };
    for (name, inner) in properties {
        let path = match path {
            "" => name.clone(),
            path => format!("{path}.{name}"),
        };
        if let Some(example) = inner["examples"]
            .get(0)
            .filter(|example| !holds_a_table(example))
        {
            examples.push((path.clone(), example.to_string()));
        }
        let table = TABLES.iter().any(|table| path.starts_with(table));
        if table && !path.starts_with("grid") {
            gather(inner, &path, examples);
        }
    }
}

/// TOML writes tables differently from JSON.
fn holds_a_table(value: &serde_json::Value) -> bool {
    match value {
        serde_json::Value::Object(_) => true,
        serde_json::Value::Array(values) => values.iter().any(holds_a_table),
        _ => false,
    }
}
