//! Makes meshes and structures from drawings: gear pairs and their load sharing ([`gear`]), shafts, bearings and trains
//! ([`shaft`]).

pub mod gear;
pub mod shaft;

use gearatlas_core::{model, numerics, structure};
