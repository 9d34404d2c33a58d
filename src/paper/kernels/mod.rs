//! The table kernels: dense propagators on unit steps (cells) of the mesh cycle, as published for this class of drive.
//! They differ in how they find events. A guard gives δ, δ' and δ'' at a time. A certificate proves from guards at two
//! times and bounds of derivatives that a stretch between them has no event, or exactly one.
//!
//! | kernel | method |
//! |---|---|
//! | [`Dyadic`] | propagators for Δ/2ᵐ; halving brackets an event, with one product per guard evaluation |
//! | [`Hermite`] | guards from rows, without propagation; a cubic Hermite guess, one or two more products |
//! | [`Spectral`] | damped sinusoids: events by scalar root finding, two products per stretch |
//! | [`Fused`] | as [`Spectral`], and certified runs of 1, 2, 4, 8 cells or a whole cycle in one product |
//!
//! [`PowerJumps`] crosses any number of cycles of constant contact.
//!
//! All integrate the augmented state of `generator` and share the loop of `cycle`. They locate events to round-off on
//! the same surfaces, with the same saltation, counters, observers and limits as every other kernel.

mod bases;
mod basis;
mod cell_model;
mod cluster;
mod conditioning;
mod cycle;
mod dyadic;
mod eigen;
mod error;
mod exits;
mod exponential;
mod fused;
mod generator;
mod grid;
mod hermite;
mod jumps;
mod kernel;
mod matrix;
mod rates;
mod series;
mod show;
mod single;
mod spectral;
mod spectral_table;
mod state_part;
mod steady;
mod waves;

#[cfg(test)]
#[allow(dead_code)]
#[path = "../../core/model/fixtures.rs"]
mod fixtures;

pub use bases::Bases;
pub use conditioning::Conditioning;
pub use dyadic::Dyadic;
pub use error::DenseError;
pub use fused::Fused;
pub use hermite::Hermite;
pub use jumps::PowerJumps;
pub use matrix::Operator;
pub use single::SingleOperator;
pub use spectral::Spectral;

#[cfg(test)]
use crate::model::{Division, Drive, MeshHarmonic, OperatingPoint};
#[cfg(test)]
use gearatlas_core::structure::ModalStructure;

/// Size of a kernel's tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableSize {
    /// Number of dense operators.
    pub operators: usize,
    /// Bytes of the operators.
    pub bytes: usize,
    /// Unit steps per mesh cycle.
    pub cells: usize,
}
