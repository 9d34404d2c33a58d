//! The piecewise-linear system: a linear structure with one-sided contacts. This module is the only
//! description of the dynamics, and does not depend on its solution.
//!
//! Mode `i` is a real 2 × 2 block `x' = A x − Σ g F + s + …`. Contact j has the deflection δ along
//! its line, to which the block contributes `w·x`, and pushes along its direction g. With
//! the transmission error `e` imposed on it, its half gap `b` and its side s = ±1,
//!
//! ```text
//! δ  = Σ w·x − e(t)                                   deflection [m]
//! δ' = Σ w·A x − e'(t)                                its rate [m/s]
//! F  = k (δ − s b) + c (δ' − s b')   where it is closed;   F = 0 where it is open
//! ```
//!
//! c, w and g are constant on each segment of the contact's mesh cycle. k and b are polynomials there, and
//! usually constant. b is the half gap plus the error of loaded flanks. At a step of b the contact may open
//! or close; the damper ignores the step. Any number of contacts may be closed at once. A time is an integer
//! number of mesh cycles and a time within the cycle, so that long runs lose no digits.

mod assembly;
mod basis;
mod bearing;
mod block;
mod breakpoints;
mod clearance;
mod contact;
mod derivative;
mod direction;
mod drive;
mod equilibrium;
mod error;
mod excitation;
mod film;
mod film_layers;
mod flank_error;
mod flank_springs;
mod friction;
mod imposed_motion;
mod initial;
mod load_terms;
mod mesh;
mod one_set;
mod output;
mod release;
mod rest;
mod rolling;
mod slider;
mod sliding;
mod state_change;
mod sticking;
mod stiffness;
mod stop;
mod stopping;
mod structure_contacts;
mod system;
mod torque_curve;
mod unrestrained;

pub use crate::structure::MeshHarmonic;
pub use basis::{Basis, Coupled};
pub use bearing::BearingOutput;
pub use block::{Block, DRIFT, MeshGain};
pub use breakpoints::OUT_OF_REACH;
pub use contact::{
    ActiveSet, COAST_FLANK, Contact, DRIVE_FLANK, FlankState, MOST_CONTACTS, SEVERAL_CONTACTS,
};
pub use derivative::ModelDerivative;
pub use direction::{Direction, Line};
pub use drive::{
    CoastFlank, Division, Drive, DriveShaft, ImposedMotion, OperatingPoint, SAME_PHASE,
    StiffnessHarmonic, ToothCycles, TorqueRipple,
};
pub use error::{ModelError, NoStaticState, ShapeChange};
pub use excitation::{Ripple, TransmissionErrorHarmonic, turned};
pub use film::{Film, FilmLayer};
pub use flank_error::FlankError;
pub use friction::DryFriction;
pub use initial::{InitialState, TrajectoryState};
pub use load_terms::{LOAD_TERMS, LoadTerm, LoadTerms};
pub use mesh::{MOST_PARTS, MeshCycle, Segment, equal_parts};
pub use output::{NamedMesh, Output, Quantity};
pub use release::Release;
pub use rolling::Rolling;
pub use slider::Slider;
pub use state_change::StateChange;
pub use stiffness::{STIFFNESS_TERMS, Stiffness};
pub use stop::{Constraint, Stop};
pub use system::Model;
pub use torque_curve::TorqueCurve;

#[cfg(test)]
pub(crate) mod fixtures;
#[cfg(test)]
use crate::structure::ModalStructure;
