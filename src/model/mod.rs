//! The piecewise-linear system: a linear structure with one scalar feedback. The only
//! description of the dynamics; knows nothing of how it is solved.
//!
//! Mode `i` is a real 2 × 2 block `x' = A x − g F + s + …` with its contribution `w·x`
//! to the mesh deflection. With `e` the static transmission error that is imposed and `b` the
//! half gap,
//!
//! ```text
//! δ  = Σ w·x − e(t)                                   mesh deflection [m]
//! δ' = Σ w·A x − e'(t)                                its rate [m/s]
//! F  = k (δ − s b) + c (δ' − s b')   in contact, s = ±1;   F = 0 in free flight
//! ```
//!
//! c, w and g are constant on each segment of the mesh cycle; k and b are polynomials there
//! (mostly constants). b is the backlash and what loaded flanks lack besides; where it steps, a
//! contact may open or close, and the damper does not feel the step. Time is a whole number of
//! mesh cycles and a time within the cycle, so that long runs lose no digits.

mod block;
mod contact;
mod direction;
mod drive;
mod excitation;
mod flank_error;
mod initial;
mod mesh;
mod stiffness;
mod system;

pub use block::{Block, MeshGain};
pub use contact::{Contact, Surface};
pub use drive::{Division, Drive, DriveShaft, MeshHarmonic, OperatingPoint, TorqueRipple};
pub use excitation::{Ripple, TransmissionErrorHarmonic};
pub use flank_error::FlankError;
pub use initial::{InitialState, TrajectoryState};
pub use mesh::{MeshCycle, Segment};
pub use stiffness::{STIFFNESS_TERMS, Stiffness};
pub use system::{Model, ModelError};

#[cfg(test)]
pub(crate) mod fixtures;
#[cfg(test)]
use crate::shaft::ModalStructure;
