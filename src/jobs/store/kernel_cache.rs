//! Tables of the kernel `closed_modes` in the cache: only this file stores a kernel's arrays.
//!
//! A table does not depend on load, half gap or the phases of excitation, so the key omits them. They enter
//! through the state to which the table is applied. Points of one structure and mesh share one table.
//!
//! A table is read into memory, not mapped: if another program truncates a mapped file, the process ends (SIGBUS).
//! Every byte is hashed before use, so reading costs only one additional copy.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::PathBuf;

use super::table_cache::{CacheContent, CacheKind, Fetched, TableStore};
use crate::model::Model;
use crate::propagate::{Aligned, ClosedModes, KeptTables, SharedStorage, TableArray, TableError};

/// Part of every key: changes whenever the same model gives other numbers or other arrays.
const METHOD: &str = "atlas kernel tables 3";

/// The arrays of a kernel, read-only. Share them in an `Arc`.
#[derive(Debug, Serialize, Deserialize)]
pub struct KernelArrays {
    arrays: Vec<KernelArray>,
    /// Data that kernels derive from the arrays on demand.
    #[serde(skip)]
    shared: SharedStorage,
}

/// One array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KernelArray {
    /// Name.
    pub name: String,
    /// SI unit; `mixed` if the units of entries differ.
    pub unit: String,
    /// The values of the array.
    #[serde(with = "aligned")]
    pub values: Aligned,
}

/// Serialises the numbers as a plain list.
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
            shared: SharedStorage::new(),
        }
    }
}

impl KernelArrays {
    /// The arrays.
    pub fn all(&self) -> &[KernelArray] {
        &self.arrays
    }

    /// A copy of the arrays. The calling thread writes it first, which places its memory on the node of this
    /// thread.
    pub fn copied(&self) -> Self {
        Self {
            arrays: self.arrays.clone(),
            shared: SharedStorage::new(),
        }
    }

    /// Size of all numbers in bytes.
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

    fn shared_storage(&self) -> Option<&SharedStorage> {
        Some(&self.shared)
    }
}

// Kernels compare the lengths of the arrays with the model, so no check is needed here.
impl CacheContent for KernelArrays {
    const KIND: CacheKind = CacheKind::Systems;
}

impl TableStore {
    /// The table of closed modes for a model: from disk, or computed and stored.
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

/// All inputs that determine the numbers of a table.
fn inputs(model: &Model) -> Value {
    json!({
        "method": METHOD,
        "modes": model.modes(),
        "contacts": model.contacts.len(),
        "model": fingerprint(model),
    })
}

/// Hash of the numbers of a model that its table depends on, hexadecimal. They include terms that depend on the speed,
/// such as gyroscopic ones.
fn fingerprint(model: &Model) -> String {
    let mut hash = blake3::Hasher::new();
    let mut put = |numbers: &[f64]| {
        // The length separates one list from the next.
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
            // Separates one cycle from the next.
            put(&[]);
        }
    }
    hash.finalize().to_hex().to_string()
}
