//! What a machine gives: memory, arithmetic and kernels.

pub mod characterize;

use gearatlas_core::{model, numerics, propagate, structure};
use gearatlas_gears::shaft;
use gearatlas_jobs::{manifest, store, topology};
