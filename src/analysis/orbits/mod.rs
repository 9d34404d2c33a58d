//! Periodic orbits.

pub mod floquet;
pub mod shooting;
