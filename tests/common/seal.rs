//! Updates the record of a run after a test has changed its tables.

// Every test binary uses a part of it.
#![allow(dead_code, clippy::unwrap_used)]

use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Updates the checksums of tables in a record (`run.json`), applies `change`, and seals the record again.
pub fn reseal(record: &Path, change: impl FnOnce(&mut Value)) {
    let mut value: Value = serde_json::from_slice(&fs::read(record).unwrap()).unwrap();
    for table in value["tables"].as_array_mut().unwrap() {
        let name = table["name"].as_str().unwrap();
        if let Ok(bytes) = fs::read(record.parent().unwrap().join(name)) {
            table["bytes"] = json!(bytes.len());
            table["blake3"] = json!(blake3::hash(&bytes).to_hex().as_str());
        }
    }
    change(&mut value);
    value.as_object_mut().unwrap().remove("blake3").unwrap();
    let text = serde_json::to_string_pretty(&value).unwrap();
    let text = text.strip_suffix("\n}").unwrap();
    let hash = blake3::hash(text.as_bytes()).to_hex();
    fs::write(record, format!("{text},\n  \"blake3\": \"{hash}\"\n}}\n")).unwrap();
}
