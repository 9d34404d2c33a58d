//! Reads manifests, sweeps their points over threads and stores the rows.

pub mod fmu;
pub mod input;
pub mod manifest;
pub mod store;
pub mod sweep;
pub mod topology;
pub mod units;

use gearatlas_core::{analysis, model, numerics, propagate, structure};
use gearatlas_gears::{gear, shaft};
