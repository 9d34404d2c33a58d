//! The contents of a file of computed tables, as text for a terminal or as JSON.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::Value;

use super::numbers::{number, size_text};
use crate::gear::MeshTable;
use crate::store::{CacheFault, CacheKind, KernelArrays, TableFile, mesh_quantities};

/// A table file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableSummary {
    /// Path of the file.
    pub file: PathBuf,
    /// Kind of its contents.
    pub kind: CacheKind,
    /// Hash of its inputs.
    pub key: String,
    /// Program that computed it.
    pub program: String,
    /// Size of all numbers \[bytes\].
    pub bytes: u64,
    /// Inputs of its computation.
    pub inputs: Value,
    /// Quantities of the file.
    pub quantities: Vec<QuantitySummary>,
}

/// A quantity of a table file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantitySummary {
    /// Name of the quantity.
    pub name: String,
    /// SI unit of the quantity.
    pub unit: String,
    /// Number of its values.
    pub count: usize,
    /// Smallest finite value; absent if there is none.
    pub least: Option<f64>,
    /// Largest finite value; absent if there is none.
    pub greatest: Option<f64>,
}

impl TableSummary {
    /// Reads a table file and checks every byte of it.
    ///
    /// # Errors
    /// The file is damaged or cannot be used; [`CacheFault`] gives the reason.
    pub fn read(path: &Path) -> Result<Self, CacheFault> {
        let file = TableFile::open(path)?;
        let quantities: Vec<_> = match file.header.kind {
            CacheKind::Mesh => {
                let table: MeshTable = file.content()?;
                let all = mesh_quantities(&table).into_iter();
                all.map(|quantity| summary(quantity.name, quantity.unit, quantity.values))
                    .collect()
            }
            CacheKind::Systems => {
                let table: KernelArrays = file.content()?;
                let all = table.all().iter();
                all.map(|quantity| summary(&quantity.name, &quantity.unit, &quantity.values))
                    .collect()
            }
        };
        let count: usize = quantities.iter().map(|quantity| quantity.count).sum();
        Ok(Self {
            file: path.to_path_buf(),
            kind: file.header.kind,
            key: file.header.key(),
            program: file.header.program.clone(),
            bytes: (count * size_of::<f64>()) as u64,
            inputs: serde_json::from_str(&file.header.inputs).map_err(|error| {
                CacheFault::Content {
                    detail: format!("its inputs: {error}"),
                }
            })?,
            quantities,
        })
    }

    /// The summary as text for a terminal.
    pub fn render(&self) -> String {
        let mut text = String::new();
        let serves = match self.kind {
            CacheKind::Mesh => "every speed",
            CacheKind::Systems => "every speed, load, gap and excitation; kernel closed_modes",
        };
        for (name, value) in [
            ("kind", self.kind.name()),
            ("key", &self.key),
            ("file", &self.file.display().to_string()),
            ("numbers", &size_text(self.bytes)),
            ("checksum", "right"),
            ("serves", serves),
            ("computed by", &self.program),
        ] {
            _ = writeln!(text, "{name:<13}{value}");
        }
        text.push_str("inputs");
        push_json(&mut text, &self.inputs, 1);
        let name = "quantity";
        _ = writeln!(
            text,
            "\n\n{name:<20}{:<8}{:>9}{:>14}{:>14}",
            "unit", "count", "least", "greatest"
        );
        for quantity in &self.quantities {
            let [least, greatest] = [quantity.least, quantity.greatest]
                .map(|value| value.map_or("–".to_owned(), number));
            let QuantitySummary {
                name, unit, count, ..
            } = quantity;
            _ = writeln!(
                text,
                "{name:<20}{unit:<8}{count:>9}{least:>14}{greatest:>14}"
            );
        }
        text
    }
}

fn summary(name: &str, unit: &str, values: &[f64]) -> QuantitySummary {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    QuantitySummary {
        name: name.to_owned(),
        unit: unit.to_owned(),
        count: values.len(),
        least: finite().reduce(f64::min),
        greatest: finite().reduce(f64::max),
    }
}

/// Appends a JSON value as indented text: `key: value` on one line per key of an object, and every other value, also a
/// list, as JSON on the line of its key.
fn push_json(text: &mut String, value: &Value, depth: usize) {
    let Value::Object(map) = value else {
        _ = write!(text, " {value}");
        return;
    };
    for (key, value) in map {
        _ = write!(text, "\n{:indent$}{key}:", "", indent = 2 * depth);
        push_json(text, value, depth + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_have_a_key_a_line() {
        let inputs =
            serde_json::json!({ "teeth": [25, 31], "rack": { "addendum": 1.0 }, "x": null });
        let mut text = String::new();
        push_json(&mut text, &inputs, 1);
        assert_eq!(
            text,
            "\n  teeth: [25,31]\n  rack:\n    addendum: 1.0\n  x: null"
        );
    }
}
