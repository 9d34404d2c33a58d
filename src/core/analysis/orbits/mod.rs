//! Periodic orbits.

pub mod attracting;
pub mod character;
pub mod floquet;
pub mod kick;
pub mod returns;
pub mod shooting;
pub mod survey;
pub mod twins;
