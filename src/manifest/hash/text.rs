//! The hash of a text: of a manifest whose combinations of values were not all resolved.

use super::JobHash;
use crate::manifest::tree::{Entry, Node, Value};

impl JobHash {
    /// The text of a manifest whose combinations were judged in part, job and grid aside: equal
    /// units differ, layout and the order of keys do not matter.
    pub fn in_part(&mut self, root: &Node) {
        self.text("judged in part");
        for name in [
            "model",
            "gear",
            "shafts",
            "mesh",
            "excitation",
            "run",
            "analyses",
        ] {
            self.optional(root.entry(name), |hash, entry| hash.node(&entry.node));
        }
    }

    fn node(&mut self, node: &Node) {
        match &node.value {
            Value::Text(text) => self.text(text),
            Value::Integer(value) => self.text(&value.to_string()),
            Value::Float(value) => self.number(*value),
            Value::Sample(value, _) => self.number(*value),
            Value::Boolean(value) => self.flag(*value),
            Value::Datetime => self.text("date"),
            Value::Array(items) => {
                self.integer(items.len() as u64);
                items.iter().for_each(|item| self.node(item));
            }
            Value::Table(entries) => {
                let mut sorted: Vec<&Entry> = entries.iter().collect();
                sorted.sort_by(|a, b| a.key.cmp(&b.key));
                self.integer(sorted.len() as u64);
                for entry in sorted {
                    self.text(&entry.key);
                    self.node(&entry.node);
                }
            }
        }
    }
}
