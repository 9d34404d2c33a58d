//! Derivatives of a motion by parameters of its drive.

pub mod derivative_observer;
pub mod ensemble;
pub mod orbit;
pub mod tangent;
