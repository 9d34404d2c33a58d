//! The table kernels: dense propagators on unit steps of the mesh cycle, as published for this
//! class of drive, each with its own way of finding events.
//!
//! | kernel | what it does |
//! |---|---|
//! | [`Dyadic`] | propagators for Δ/2ᵐ; an event is bracketed by halving, one product a guard evaluation |
//! | [`Hermite`] | certificates from rows, a cubic Hermite guess, one or two more products |
//! | [`Spectral`] | damped sinusoids: events by scalar root finding, two products a stretch |
//! | [`Fused`] | the same, and certified runs of 1, 2, 4, 8 cells or a whole cycle in one product |
//!
//! [`PowerJumps`] crosses any number of cycles of constant contact.
//!
//! All integrate the augmented state of [`generator`] and share the loop of [`cycle`]: events are
//! located to round-off on the same surfaces, with the same saltation, counters, observers and
//! limits as every other kernel.

mod bases;
mod basis;
mod cell_model;
mod cluster;
mod conditioning;
mod cycle;
mod dyadic;
mod eigen;
mod exits;
mod exponential;
mod fused;
mod generator;
mod grid;
mod hermite;
mod jumps;
mod kept;
mod kernel;
mod matrix;
mod rates;
mod series;
mod show;
mod spectral;
mod spectral_table;
mod steady;
mod stretch;
mod waves;

pub use bases::{DYADIC_BYTES, form as bases_form};
pub use conditioning::Conditioning;
pub use dyadic::Dyadic;
pub use fused::Fused;
pub use hermite::Hermite;
pub use jumps::PowerJumps;
pub use kept::{Beside, KeptTables, Reader as KeptReader, TableArray, Writer as KeptWriter};
pub use matrix::Operator;
pub use spectral::Spectral;

/// Why a table kernel cannot be built for a model.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DenseError {
    /// Loaded flanks have an error.
    #[error(
        "kernels of tables do not follow the error of loaded flanks; use kernel = \"volterra\", or give excitation.table_harmonics, its harmonics, or 0 to leave it out"
    )]
    FlankError,
    /// Stiffness varies within a segment.
    #[error(
        "the mesh stiffness varies within its segments, which tables of matrix exponentials cannot \
         follow; set `stiffness = \"piecewise\"`"
    )]
    VaryingStiffness,
    /// The eigenvectors of a segment are too nearly parallel.
    #[error(
        "the eigenvectors of a mesh segment are nearly parallel: a propagator rebuilt from them is \
         off by {error:.1e} of its largest entry, at most 1e-11 is let pass (condition number \
         {condition:.1e}); the contact may be critically damped"
    )]
    Defective {
        /// Condition number of their basis.
        condition: f64,
        /// Error of a propagator rebuilt from them, relative to its largest entry.
        error: f64,
    },
    /// An undamped mode in resonance with a harmonic.
    #[error(
        "an undamped mode is in resonance with the harmonic at {frequency:.6e} rad/s; \
         give it damping"
    )]
    Resonance {
        /// Angular frequency of the harmonic \[rad/s\].
        frequency: f64,
    },
    /// The contacts are not two flanks on one line.
    #[error(
        "tables take two flanks with one line of action and one stiffness; set \
         mesh.coast_flank = \"same_line\", or a kernel without tables"
    )]
    Contacts,
    /// Contacts let go where their force vanishes.
    #[error(
        "tables do not know contacts that let go where their force vanishes; set \
         mesh.release = \"deflection\", or a kernel without tables"
    )]
    Release,
    /// Modes are coupled, or a load does not go with the rated one.
    #[error(
        "tables take modal damping and loads in proportion to the rated one; set \
         run.kernel = \"volterra\" for dampers, drag, gyroscopic terms and cross-coupled bearings"
    )]
    Coupled,
    /// A mode has two real eigenvalues.
    #[error("tables take no overdamped mode; set run.kernel = \"volterra\"")]
    Overdamped,
    /// Kept tables are not those of this model.
    #[error(
        "the kept tables have no array `{name}` that fits this model; delete the \
         folder of tables (`tables/`), they are computed again"
    )]
    Kept {
        /// The array.
        name: &'static str,
    },
    /// More systems than tables are made for.
    #[error(
        "contacts may be closed in {count} ways, each a linear system with a table of its own, and at most {most} are \
         kept; set run.kernel = \"volterra\""
    )]
    TooManySets {
        /// How many.
        count: usize,
        /// The most that are kept.
        most: usize,
    },
    /// Tables would be larger than they should be.
    #[error(
        "the tables of the {} ways in which contacts may be closed would take {:.0} MB, at most {:.0} MB are kept; keep fewer \
         modes or fewer levels of stiffness",
        size.operators, megabytes(size.bytes), megabytes(*most)
    )]
    TooLarge {
        /// What they would take.
        size: TableSize,
        /// The most \[bytes\].
        most: usize,
    },
    /// A cycle would take more cells than tables should have.
    #[error(
        "one mesh cycle would take {cells:.0} table steps; raise the speed or leave out high modes"
    )]
    TooManyCells {
        /// How many.
        cells: f64,
    },
}

impl DenseError {
    /// Whether it is the model that these tables do not fit, so that another kernel may.
    pub fn concerns_the_model(&self) -> bool {
        !matches!(self, Self::Kept { .. })
    }

    /// What is wrong, without the figures and the remedy that follow it.
    pub fn cause(&self) -> String {
        let text = self.to_string();
        text.split([':', ';']).next().unwrap_or_default().to_owned()
    }
}

/// Bytes in megabytes.
pub fn megabytes(bytes: usize) -> f64 {
    1e-6 * bytes as f64
}

/// Size of a kernel's tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableSize {
    /// Dense operators kept.
    pub operators: usize,
    /// Their bytes.
    pub bytes: usize,
    /// Unit steps a mesh cycle.
    pub cells: usize,
}
