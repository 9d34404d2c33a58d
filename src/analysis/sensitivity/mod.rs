//! Derivatives of a motion by parameters of its drive.

pub mod tangent;
