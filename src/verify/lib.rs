//! Checks the program against independent integrators, closed forms and published values.

pub mod reference;
pub mod verify;

use gearatlas_core::{analysis, model, numerics, propagate, structure};
use gearatlas_gears::{gear, shaft};
use gearatlas_jobs::{fmu, manifest, store, sweep};
