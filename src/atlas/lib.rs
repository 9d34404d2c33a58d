//! Gear rattle over grids of operating points. The default kernels integrate a flexible drive with backlash to
//! round-off and locate events to round-off. Averages of motion that does not settle have standard errors.
//!
//! Data flows one way:
//!
//! ```text
//! manifest → gear + shaft → model → propagate → analysis → store → report
//! ```
//!
//! `sweep` calls the modules from `gear` to `store` for every point, and `cli` calls all modules. Modules
//! form layers, and a module imports only from lower layers; `tests/house/architecture.rs` lists and checks
//! the layers.

pub mod cli;
pub mod export;
pub mod report;

pub use gearatlas_core::{analysis, model, numerics, propagate, structure};
pub use gearatlas_gears::{gear, shaft};
pub use gearatlas_jobs::{fmu, input, manifest, store, sweep, topology, units};
pub use gearatlas_machine::characterize;
pub use gearatlas_verify::{reference, verify};

/// The commit of the sources, with `-dirty` if they differ from it; `None` outside a git checkout.
pub const COMMIT: Option<&str> = option_env!("ATLAS_COMMIT");
