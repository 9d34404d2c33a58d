//! Periodic orbits.

pub mod floquet;
