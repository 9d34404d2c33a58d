//! Measures memory, arithmetic and kernels of a machine.

pub mod characterize;

use gearatlas_core::{model, numerics, propagate, structure};
use gearatlas_gears::shaft;
use gearatlas_jobs::{manifest, store, topology};
