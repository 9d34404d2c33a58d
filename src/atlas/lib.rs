//! Gear rattle over grids of operating points: a flexible drive with backlash is
//! propagated exactly between breakpoints, events are located to round-off, and every
//! point of a grid is answered with numbers that carry their error.
//!
//! Data flows one way:
//!
//! ```text
//! manifest → gear + shaft → model → propagate → analysis → store → report
//! ```
//!
//! `sweep` drives the middle, `cli` drives everything. A module imports only from
//! layers above its own line; `tests/house/architecture.rs` holds the code to that.

pub mod cli;
pub mod export;
pub mod report;

pub use gearatlas_core::{analysis, model, numerics, propagate, structure};
pub use gearatlas_gears::{gear, shaft};
pub use gearatlas_jobs::{fmu, input, manifest, store, sweep, topology, units};
pub use gearatlas_machine::characterize;
pub use gearatlas_verify::{reference, verify};

/// The commit the program was built from, with `-dirty` where the sources differ from it; none outside a git checkout.
pub const COMMIT: Option<&str> = option_env!("ATLAS_COMMIT");
