//! Tables of dense kernels in the cache: the one place where a kernel's arrays meet a file.
//!
//! Load and half gap are coordinates of the state these tables act on, and so are the phases of
//! all excitation: none of them is part of a key. Bases are of a structure and its mesh, whatever
//! the speed and the excitation; points of one structure and mesh share one table. What runs of
//! cells make of it is of one speed.

use serde_json::{Value, json};
use thiserror::Error;

use super::{Arrays, CacheError, CacheKind, Fetched, MappedTable, TableStore};
use crate::model::Model;
use crate::propagate::{Beside, DenseError, KeptTables, KernelTable, TableArray, bases_form};

/// Part of every key: changes whenever the same model gives other numbers or other arrays.
const METHOD: &str = "atlas kernel tables 3";

fn kind(table: KernelTable) -> CacheKind {
    match table {
        KernelTable::Bases => CacheKind::Bases,
        KernelTable::Systems => CacheKind::Systems,
        KernelTable::Runs { .. } => CacheKind::Runs,
    }
}

/// There are no tables for this model.
#[derive(Debug, Error)]
pub enum OperatorFetchError {
    /// They cannot be computed.
    #[error(transparent)]
    Dense(#[from] DenseError),
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
        KernelTable::Bases => {
            let (slow_rate, harmonics) = bases_form(model);
            json!({
                "method": METHOD,
                "modes": model.modes(),
                "segments": model.first_cycle().segments.len(),
                "slow_rate": slow_rate,
                "harmonics": harmonics,
                "model": structure.finish(),
            })
        }
        KernelTable::Systems => {
            structure.put_contacts(model);
            json!({
                "method": METHOD,
                "modes": model.modes(),
                "contacts": model.contacts.len(),
                "model": structure.finish(),
            })
        }
        KernelTable::Runs { cells } => {
            structure.put_speed(model);
            json!({
                "method": METHOD,
                "cells": cells,
                "modes": model.modes(),
                "segments": model.first_cycle().segments.len(),
                "period": model.period(),
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

    fn put_speed(&mut self, model: &Model) {
        self.put(model.rated_input.as_flattened());
        self.put(&[model.period()]);
        for segment in &model.first_cycle().segments {
            self.put(&[segment.end]);
        }
        for harmonic in model.transmission_errors() {
            self.put(&[
                harmonic.angular_frequency,
                harmonic.amplitude,
                harmonic.phase,
            ]);
        }
        for ripple in &model.ripple {
            self.put(&[ripple.angular_frequency]);
            self.put(ripple.input.as_flattened());
        }
    }

    /// The hash, hexadecimal.
    fn finish(self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}
