//! Derivatives of a motion by parameters of its drive.

pub mod ensemble;
pub mod orbit;
pub mod tangent;
pub mod witness;
