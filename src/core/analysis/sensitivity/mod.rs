//! Derivatives of a motion with respect to parameters of its drive.

pub mod derivative_observer;
pub mod ensemble;
mod impulse;
pub mod orbit;
pub mod tangent;
