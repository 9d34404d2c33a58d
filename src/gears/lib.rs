//! From drawings to structures: gear pairs and what their teeth bear ([`gear`]), shafts, bearings and trains ([`shaft`]).

pub mod gear;
pub mod shaft;

use gearatlas_core::{model, numerics, structure};
