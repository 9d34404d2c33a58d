//! Tables of kernels in the cache: the one place where a kernel's arrays meet a file.
//!
//! They belong to a structure and its mesh. Load, half gap, speed and excitation are not part of a key: points of one
//! structure and mesh share one table.

use serde_json::{Value, json};
use thiserror::Error;

use super::{Arrays, CacheError, CacheKind, Fetched, MappedTable, TableStore};
use crate::model::Model;
use crate::propagate::{Beside, KeptTables, KernelTable, TableArray, TableError};

/// Part of every key: changes whenever the same model gives other numbers or other arrays.
const METHOD: &str = "atlas kernel tables 3";

fn kind(table: KernelTable) -> CacheKind {
    match table {
        KernelTable::Systems => CacheKind::Systems,
    }
}

/// There are no tables for this model.
#[derive(Debug, Error)]
pub enum OperatorFetchError {
    /// They cannot be computed.
    #[error(transparent)]
    Dense(#[from] TableError),
    /// They are no arrays that can be kept.
    #[error(transparent)]
    Arrays(#[from] CacheError),
}

impl KeptTables for MappedTable {
    fn numbers(&self, name: &str) -> Option<&[f64]> {
        self.array(name).ok().map(|(_, values)| values)
    }

    fn beside(&self) -> Option<&Beside> {
        Some(&self.beside)
    }
}

impl TableStore {
    /// A table of a kernel for a model: the one on disk, or a new one, which is kept.
    ///
    /// # Errors
    /// The kernel cannot be built for the model. A cache that cannot be read or written is told
    /// in the warnings.
    pub fn kernel_table(
        &self,
        table: KernelTable,
        model: &Model,
    ) -> Result<Fetched, OperatorFetchError> {
        self.get_or_build(kind(table), &inputs(table, model), || {
            let mut arrays = Arrays::new();
            for TableArray { name, unit, values } in table.arrays(model)? {
                arrays.push(name, unit, &[values.len()], values.to_vec())?;
            }
            Ok(arrays)
        })
    }

    /// The file of a table of a kernel.
    pub fn kernel_table_path(&self, table: KernelTable, model: &Model) -> std::path::PathBuf {
        self.path(kind(table), &inputs(table, model))
    }
}

/// Everything that decides the numbers of a table.
fn inputs(table: KernelTable, model: &Model) -> Value {
    let mut structure = Fingerprint::default();
    structure.put_structure(model);
    match table {
        KernelTable::Systems => {
            structure.put_contacts(model);
            json!({
                "method": METHOD,
                "modes": model.modes(),
                "contacts": model.contacts.len(),
                "model": structure.finish(),
            })
        }
    }
}

/// Hash of the numbers of a model that a table depends on. What depends on the speed in a
/// structure, as gyroscopic terms do, is in its numbers.
#[derive(Default)]
struct Fingerprint(blake3::Hasher);

impl Fingerprint {
    fn put(&mut self, numbers: &[f64]) {
        // The length keeps one list from running into the next.
        self.0.update(&(numbers.len() as u64).to_le_bytes());
        for number in numbers {
            self.0.update(&number.to_le_bytes());
        }
    }

    fn put_structure(&mut self, model: &Model) {
        for block in &model.blocks {
            self.put(block.generator.as_flattened());
        }
        for direction in &model.directions {
            for gain in &direction.gains {
                self.put(&gain.deflection);
                self.put(&gain.rate);
                self.put(&gain.mesh_input);
            }
        }
        for segment in &model.first_cycle().segments {
            let direction = segment.direction as f64;
            self.put(&[segment.stiffness.mean(), segment.damping, direction]);
        }
    }

    fn put_contacts(&mut self, model: &Model) {
        for contact in &model.contacts {
            for cycle in &contact.cycles {
                for segment in &cycle.segments {
                    let direction = segment.direction as f64;
                    self.put(&[segment.stiffness.mean(), segment.damping, direction]);
                }
                // One cycle must not run into the next.
                self.put(&[]);
            }
        }
    }

    /// The hash, hexadecimal.
    fn finish(self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}
