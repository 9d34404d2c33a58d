//! Tables of the kernel `closed_modes` in the cache: the one place where a kernel's arrays meet a file.
//!
//! Load and half gap are coordinates of the state these tables act on, and so are the phases of
//! all excitation: none of them is part of a key. Points of one structure and mesh share one table.
//!
//! A table is read into memory, not mapped. A file that another program cuts short while it is mapped
//! would end the process (SIGBUS). Every byte is hashed before it is used, so reading costs one copy more.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::PathBuf;

use super::table_cache::{CacheContent, CacheKind, Fetched, TableStore};
use crate::model::Model;
use crate::propagate::{Aligned, Beside, ClosedModes, KeptTables, TableArray, TableError};

/// Part of every key: changes whenever the same model gives other numbers or other arrays.
const METHOD: &str = "atlas kernel tables 3";

/// The arrays of a kernel, read-only. Share them in an `Arc`.
#[derive(Debug, Serialize, Deserialize)]
pub struct KernelArrays {
    arrays: Vec<KernelArray>,
    /// What kernels make of them when they need it.
    #[serde(skip)]
    beside: Beside,
}

/// One array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KernelArray {
    /// Its name.
    pub name: String,
    /// Its unit, SI; `mixed` where entries differ in theirs.
    pub unit: String,
    /// Its numbers.
    #[serde(with = "aligned")]
    pub values: Aligned,
}

/// Numbers in a file as in any list.
mod aligned {
    use super::Aligned;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(values: &Aligned, to: S) -> Result<S::Ok, S::Error> {
        values[..].serialize(to)
    }

    pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<Aligned, D::Error> {
        Ok(Vec::deserialize(from)?[..].into())
    }
}

impl From<Vec<TableArray>> for KernelArrays {
    fn from(arrays: Vec<TableArray>) -> Self {
        let arrays = arrays.into_iter().map(|array| KernelArray {
            name: array.name.to_owned(),
            unit: array.unit.to_owned(),
            values: array.values,
        });
        Self {
            arrays: arrays.collect(),
            beside: Beside::new(),
        }
    }
}

impl KernelArrays {
    /// The arrays.
    pub fn all(&self) -> &[KernelArray] {
        &self.arrays
    }

    /// Equal arrays in memory that the calling thread writes first, which lies on its node.
    pub fn copied(&self) -> Self {
        Self {
            arrays: self.arrays.clone(),
            beside: Beside::new(),
        }
    }

    /// Bytes of all numbers.
    pub fn bytes(&self) -> usize {
        (self.arrays.iter())
            .map(|array| size_of_val(&array.values[..]))
            .sum()
    }

    /// The longest array.
    pub fn longest(&self) -> &[f64] {
        let longest = self.arrays.iter().max_by_key(|array| array.values.len());
        longest.map_or(&[], |array| &array.values)
    }
}

impl KeptTables for KernelArrays {
    fn numbers(&self, name: &str) -> Option<&[f64]> {
        let array = self.arrays.iter().find(|array| array.name == name)?;
        Some(&array.values)
    }

    fn beside(&self) -> Option<&Beside> {
        Some(&self.beside)
    }
}

// A kernel compares the lengths of its arrays with the model.
impl CacheContent for KernelArrays {
    const KIND: CacheKind = CacheKind::Systems;
}

impl TableStore {
    /// The table of closed modes for a model: the one on disk, or a new one, which is kept.
    ///
    /// # Errors
    /// The kernel cannot be built for the model. A cache that cannot be read or written gives a warning.
    pub fn systems(&self, model: &Model) -> Result<Fetched<KernelArrays>, TableError> {
        self.get_or_build(&inputs(model), || Ok(ClosedModes::arrays(model)?.into()))
    }

    /// The file of this table.
    pub fn systems_path(&self, model: &Model) -> PathBuf {
        self.path(CacheKind::Systems, &inputs(model))
    }
}

/// Everything that decides the numbers of a table.
fn inputs(model: &Model) -> Value {
    json!({
        "method": METHOD,
        "modes": model.modes(),
        "contacts": model.contacts.len(),
        "model": fingerprint(model),
    })
}

/// Hash of the numbers of a model that its table depends on, hexadecimal. What depends on the speed in a
/// structure, as gyroscopic terms do, is in its numbers.
fn fingerprint(model: &Model) -> String {
    let mut hash = blake3::Hasher::new();
    let mut put = |numbers: &[f64]| {
        // The length keeps one list from running into the next.
        hash.update(&(numbers.len() as u64).to_le_bytes());
        for number in numbers {
            hash.update(&number.to_le_bytes());
        }
    };
    for block in &model.blocks {
        put(block.generator.as_flattened());
    }
    for direction in &model.directions {
        for gain in &direction.gains {
            put(&gain.deflection);
            put(&gain.rate);
            put(&gain.mesh_input);
        }
    }
    for contact in &model.contacts {
        for cycle in &contact.cycles {
            for segment in &cycle.segments {
                let direction = segment.direction as f64;
                put(&[segment.stiffness.mean(), segment.damping, direction]);
            }
            // One cycle must not run into the next.
            put(&[]);
        }
    }
    hash.finalize().to_hex().to_string()
}
