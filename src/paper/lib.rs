//! The kernels of *How Fast Can High-Fidelity Gear Rattle Be Simulated, and Where Does Trajectory Simulation Give Way
//! to Structure?* (preprint, July 2026), and its measurements.
//!
//! [`kernels`] contains the kernels that the paper compares: dense propagators on unit steps of the mesh cycle. The
//! program `atlas` does not use them. [`attachment`] replaces modes that a reduction leaves out. `atlas-paper` times
//! the kernels together with those of `atlas` on the paper's cases, and runs the checks of `atlas verify` on them.

pub mod attachment;
pub mod kernels;
pub mod verify;

use gearatlas_core::{model, numerics, propagate};
