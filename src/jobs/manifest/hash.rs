//! The content hash of a job: BLAKE3 over one serialisation of the resolved values, including defaults.
//! Comments, layout, order of keys and the job's name do not matter. The unit in which a quantity is written only
//! matters in a grid with too many combinations to hash all. Everything that can change a result matters.

use super::spec::{Axis, Carried};
use super::tree::{Entry, Node, Value};
use serde::Serialize;
use std::collections::BTreeMap;

/// Version of the computation. It must change whenever the same values give other results.
const METHOD: u32 = 4;

/// The unfinished hash of a job.
#[derive(Debug)]
pub(super) struct JobHash(blake3::Hasher);

impl JobHash {
    /// Starts with the data that all points share.
    pub fn new(seed: u64, axes: &[&Axis], carried: Option<&Carried>) -> Self {
        let mut hash = Self(blake3::Hasher::new());
        hash.add(&("atlas job", METHOD, env!("CARGO_PKG_VERSION")));
        hash.add(&(seed, axes, carried));
        hash
    }

    /// Lower-case hexadecimal.
    pub fn finish(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }

    /// Adds the tree of a manifest, except job and grid, if some combinations do not enter the hash.
    /// Equal quantities in different units then give different hashes. Layout and order of keys do not
    /// matter.
    pub fn in_part(&mut self, root: &Node) {
        let Plain::Table(mut entries) = Plain::of(root) else {
            return;
        };
        entries.retain(|name, _| !["job", "grid"].contains(name));
        self.add(&entries);
    }

    /// Adds values.
    pub fn add(&mut self, values: &impl Serialize) {
        match postcard::to_stdvec(values) {
            Ok(bytes) => self.0.update(&bytes),
            // Only sequences of unknown length or faulty implementations of `Serialize` cause an error.
            Err(error) => unreachable!("values of a manifest are plain: {error}"),
        };
    }
}

/// A value of the text without its place.
#[derive(Serialize)]
enum Plain<'t> {
    Text(&'t str),
    Integer(i64),
    Number(f64),
    Boolean(bool),
    Datetime,
    Array(Vec<Self>),
    Table(BTreeMap<&'t str, Self>),
}

impl<'t> Plain<'t> {
    fn of(node: &'t Node) -> Self {
        match &node.value {
            Value::Text(text) => Self::Text(text),
            Value::Integer(value) => Self::Integer(*value),
            Value::Float(value) | Value::Sample(value, _) => Self::Number(*value),
            Value::Boolean(value) => Self::Boolean(*value),
            Value::Datetime => Self::Datetime,
            Value::Array(items) => Self::Array(items.iter().map(Self::of).collect()),
            Value::Table(entries) => {
                let plain = |entry: &'t Entry| (entry.key.as_str(), Self::of(&entry.node));
                Self::Table(entries.iter().map(plain).collect())
            }
        }
    }
}
