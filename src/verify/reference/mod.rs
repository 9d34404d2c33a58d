//! An independent event-driven integrator for cross-checks: what is the trajectory, to
//! round-off, if nothing but [`Model::derivative`](crate::model::Model::derivative) is
//! trusted? It imports `model` only and shares no code with the kernels.
//!
//! Between breakpoints (segment boundaries, changes of contact state) the vector field is
//! smooth and is integrated by Gauss collocation of order 16 with compensated summation.
//! Crossings of the switching surfaces are located by Newton's method, every evaluation
//! being an integration from the start of the step, so that a crossing is known to
//! round-off. A minimum of the distance to a surface between two samples of a step is
//! looked up, so that no pair of grazing crossings is passed over.
//!
//! Speed is not its aim; its step and its rule are fixed, and
//! [`Reference::refined`] halves the step to show that the answer does not move.
//!
//! [`Extended`] answers the same to some 30 digits by Taylor series in numbers of two doubles,
//! and shares no method with [`Reference`].

mod compressed;
mod crossing;
mod extended;
mod friction;
mod gauss;
mod integrator;
mod push;
mod rate;
mod stops;
mod watched;

pub use extended::{DoubleDouble, Extended, ExtendedCrossing, ExtendedPassage};
pub use integrator::{Crossing, Moment, Passage, Reference, ReferenceError};
