//! Periodic orbits.

pub mod floquet;
pub mod shooting;
pub mod twins;
