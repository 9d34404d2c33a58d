//! What a table file holds, for a reader at a terminal or for a program.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;
use serde_json::Value;

use super::numbers::{number, size_text};
use crate::store::{ArrayHeader, CacheFault, CacheKind, MappedTable, timestamp};

/// A table file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableSummary {
    /// Where it lies.
    pub file: PathBuf,
    /// What it holds.
    pub kind: CacheKind,
    /// Hash of what it was computed from.
    pub key: String,
    /// Program that computed it.
    pub program: String,
    /// Length of the file \[bytes\].
    pub bytes: u64,
    /// When it was last made or read, RFC 3339, UTC, to an hour.
    pub used: String,
    /// What it was computed from.
    pub inputs: Value,
    /// Its arrays.
    pub arrays: Vec<ArraySummary>,
}

/// An array of a table file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArraySummary {
    /// Its name.
    pub name: String,
    /// Its unit, SI.
    pub unit: String,
    /// Extent of each axis, slowest first.
    pub shape: Vec<usize>,
    /// Smallest finite value; absent where there is none.
    pub least: Option<f64>,
    /// Largest finite value; absent where there is none.
    pub greatest: Option<f64>,
    /// Values that are not finite.
    pub not_finite: usize,
}

impl TableSummary {
    /// Reads a table file and checks every byte of it.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn read(file: &Path) -> Result<Self, CacheFault> {
        let table = MappedTable::open(file)?;
        let metadata = fs::metadata(file).map_err(CacheFault::Unreadable)?;
        let header = table.header();
        let arrays = header.arrays.iter();
        Ok(Self {
            file: file.to_path_buf(),
            kind: header.kind,
            key: header.key.clone(),
            program: header.program.clone(),
            bytes: metadata.len(),
            used: timestamp(metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH)),
            inputs: serde_json::from_str(table.inputs()).map_err(|error| CacheFault::Header {
                detail: format!("its inputs: {error}"),
            })?,
            arrays: arrays.map(|array| summary(&table, array)).collect(),
        })
    }

    /// Which operating points use it.
    fn serves(&self) -> String {
        match self.kind {
            CacheKind::Mesh => "every speed".into(),
            CacheKind::Bases => {
                "every speed, load, gap and excitation; kernels spectral, fused".into()
            }
            CacheKind::Systems => {
                "every speed, load, gap and excitation; kernel closed_modes".into()
            }
            CacheKind::Runs => {
                let period = self.inputs["period"].as_f64().map_or("–".into(), number);
                format!("the speed of mesh period {period} s, every load and gap; kernel fused")
            }
        }
    }

    /// The summary as text for a terminal.
    pub fn render(&self) -> String {
        let mut text = String::new();
        for (name, value) in [
            ("kind", self.kind.name()),
            ("key", &self.key),
            ("file", &self.file.display().to_string()),
            ("size", &size_text(self.bytes)),
            ("serves", &self.serves()),
            ("computed by", &self.program),
            ("last used", &self.used),
        ] {
            _ = writeln!(text, "{name:<13}{value}");
        }
        text.push_str("inputs");
        push_json(&mut text, &self.inputs, 1);
        let rows = self.arrays.iter().map(ArraySummary::cells);
        let head = ["array", "unit", "shape", "least", "greatest"].map(str::to_owned);
        let rows: Vec<[String; 5]> = std::iter::once(head).chain(rows).collect();
        let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
        let widths: [usize; 5] = std::array::from_fn(|column| width(column).unwrap_or(0));
        text.push_str("\n\n");
        for [name, unit, shape, least, greatest] in &rows {
            let [a, b, c, d, e] = widths;
            let line = format!("{name:<a$}  {unit:<b$}  {shape:<c$}  {least:>d$}  {greatest:>e$}");
            _ = writeln!(text, "{}", line.trim_end());
        }
        text
    }
}

impl ArraySummary {
    fn cells(&self) -> [String; 5] {
        let shown = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
        let extents: Vec<String> = self.shape.iter().map(usize::to_string).collect();
        let shape = match (extents.is_empty(), self.not_finite) {
            (true, _) => "a number".to_owned(),
            (false, 0) => extents.join(" × "),
            (false, count) => format!("{} ({count} not finite)", extents.join(" × ")),
        };
        let [least, greatest] = [self.least, self.greatest].map(shown);
        [self.name.clone(), self.unit.clone(), shape, least, greatest]
    }
}

fn summary(table: &MappedTable, array: &ArrayHeader) -> ArraySummary {
    let values = table
        .array(&array.name)
        .map_or(&[][..], |(_, values)| values);
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    ArraySummary {
        name: array.name.clone(),
        unit: array.unit.clone(),
        shape: array.shape.clone(),
        least: finite().reduce(f64::min),
        greatest: finite().reduce(f64::max),
        not_finite: values.len() - finite().count(),
    }
}

/// JSON with a key a line, lists in one line.
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
