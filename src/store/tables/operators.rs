//! Tables of dense kernels in the cache: the one place where a kernel's arrays meet a file.
//!
//! Load and half gap are coordinates of the state these tables act on, and the phases of torque
//! ripple are too: none of them is part of the key, so that points of one structure, mesh and
//! speed share a table.

use serde_json::{Value, json};
use thiserror::Error;

use super::{Arrays, CacheError, CacheKind, Fetched, MappedTable, TableStore};
use crate::model::Model;
use crate::propagate::{DenseError, Dyadic, Fused, KeptKernel, KeptTables, Spectral, TableArray};

/// Part of every key: changes whenever the same model gives other numbers or other arrays.
const METHOD: &str = "atlas kernel tables 2";

/// Name of the array that holds the size \[bytes\] of the dyadic kernel's tables of the same
/// model.
pub const DYADIC_BYTES: &str = "dyadic_bytes";

fn kind(kernel: KeptKernel) -> CacheKind {
    match kernel {
        KeptKernel::Spectral => CacheKind::Spectral,
        KeptKernel::Fused => CacheKind::Fused,
    }
}

fn arrays_of(kernel: KeptKernel, model: &Model, cells: u32) -> Result<Vec<TableArray>, DenseError> {
    // Nothing is integrated: no event is met.
    match kernel {
        KeptKernel::Spectral => Ok(Spectral::new(model, cells, 0, None)?.arrays()),
        KeptKernel::Fused => Ok(Fused::new(model, cells, 0)?.arrays()),
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
}

impl TableStore {
    /// The tables of a kernel for a model in so many `cells` a mesh cycle: those on disk, or new
    /// ones, which are kept.
    ///
    /// # Errors
    /// The kernel cannot be built for the model. A cache that cannot be read or written is told
    /// in the warnings.
    pub fn kernel_tables(
        &self,
        kernel: KeptKernel,
        model: &Model,
        cells: u32,
    ) -> Result<Fetched, OperatorFetchError> {
        self.get_or_build(kind(kernel), &inputs(model, cells), || {
            let mut arrays = Arrays::new();
            for TableArray { name, unit, values } in arrays_of(kernel, model, cells)? {
                arrays.push(name, unit, &[values.len()], values)?;
            }
            let dyadic = Dyadic::size(model, cells)?.bytes as f64;
            arrays.push(DYADIC_BYTES, "B", &[], vec![dyadic])?;
            Ok(arrays)
        })
    }

    /// The file of a kernel's tables.
    pub fn kernel_tables_path(
        &self,
        kernel: KeptKernel,
        model: &Model,
        cells: u32,
    ) -> std::path::PathBuf {
        self.path(kind(kernel), &inputs(model, cells))
    }
}

/// Everything that decides the numbers of a table.
fn inputs(model: &Model, cells: u32) -> Value {
    json!({
        "method": METHOD,
        "cells": cells,
        "modes": model.modes(),
        "segments": model.first_cycle().segments.len(),
        "period": model.period(),
        "model": fingerprint(model),
    })
}

/// Hash of all numbers of a model that its tables depend on, hexadecimal.
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
    put(model.rated_input.as_flattened());
    for direction in &model.directions {
        for gain in &direction.gains {
            put(&gain.deflection);
            put(&gain.rate);
            put(&gain.mesh_input);
        }
    }
    put(&[model.period()]);
    for segment in &model.first_cycle().segments {
        put(&[
            segment.end,
            segment.stiffness.mean(),
            segment.damping,
            segment.direction as f64,
        ]);
    }
    for harmonic in model.transmission_errors() {
        put(&[
            harmonic.angular_frequency,
            harmonic.amplitude,
            harmonic.phase,
        ]);
    }
    for ripple in &model.ripple {
        put(&[ripple.angular_frequency]);
        put(ripple.input.as_flattened());
    }
    hash.finalize().to_hex().to_string()
}
