//! What a table is found by: its kind and a hash of what it was computed from.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use strum::IntoStaticStr;

use super::layout::VERSION;

/// What a table holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum CacheKind {
    /// Mesh stiffness and its companions over a mesh cycle.
    Mesh,
    /// Bases of a structure and its mesh, of the kernels `spectral` and `fused` at every speed.
    Bases,
    /// Eigenvectors of each set of closed contacts, of the kernel `closed_modes` at every speed.
    Systems,
    /// Products of cells at one speed, of the kernel `fused`.
    Runs,
}

impl CacheKind {
    /// Its name in file names and headers.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// JSON in the one form that is hashed: keys sorted, no spaces, numbers in the shortest
/// digits that give the same bits back.
pub(super) fn canonical(value: &Value) -> String {
    match value {
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(canonical).collect();
            format!("[{}]", items.join(","))
        }
        Value::Object(map) => {
            let mut entries: Vec<(&String, &Value)> = map.iter().collect();
            entries.sort_by_key(|(name, _)| *name);
            let entries: Vec<String> = entries
                .into_iter()
                .map(|(name, value)| format!("{}:{}", Value::from(name.as_str()), canonical(value)))
                .collect();
            format!("{{{}}}", entries.join(","))
        }
        plain => plain.to_string(),
    }
}

/// Hash of the inputs in canonical form, of the kind and of the file format: lower-case
/// hexadecimal, 64 digits.
pub(super) fn key(kind: CacheKind, inputs: &str) -> String {
    let mut hash = blake3::Hasher::new();
    // No name of a kind contains the byte 0, so that the parts cannot run into each other.
    hash.update(format!("atlas table {VERSION}\0{}\0", kind.name()).as_bytes());
    hash.update(inputs.as_bytes());
    hash.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn order_and_spaces_do_not_matter_and_bits_do() {
        let a: Value =
            serde_json::from_str(r#"{"b": [1.0, "x\n"], "a": {"d":1,"c":null}}"#).unwrap();
        assert_eq!(canonical(&a), r#"{"a":{"c":null,"d":1},"b":[1.0,"x\n"]}"#);
        let number = 0.1 + 0.2;
        assert_ne!(canonical(&json!(number)), canonical(&json!(0.3)));
        assert_eq!(canonical(&json!(number)).parse(), Ok(number));
        assert_ne!(canonical(&json!(0.0)), canonical(&json!(-0.0)));
    }

    #[test]
    fn keys_differ_by_kind_and_inputs() {
        let keys = [
            key(CacheKind::Mesh, "{}"),
            key(CacheKind::Bases, "{}"),
            key(CacheKind::Mesh, "[]"),
        ];
        assert!(keys.iter().all(|key| key.len() == 64));
        assert!(keys[0] != keys[1] && keys[0] != keys[2] && keys[1] != keys[2]);
    }
}
