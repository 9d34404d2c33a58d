//! An independent event-driven integrator for cross-checks. It computes the trajectory to round-off from
//! [`Model::derivative`](crate::model::Model::derivative). It imports `model` only, and shares no code with
//! the kernels.
//!
//! Between segment boundaries and changes of contact state the vector field is smooth and is integrated by Gauss
//! collocation of order 16 with compensated summation. Newton's method locates the crossings of contact surfaces.
//! Each evaluation integrates from the start of the step, so that a crossing is known to round-off. The distance to
//! a surface is sampled within a step. Its minima between two samples are located, so that no pair of grazing
//! crossings is missed.
//!
//! Speed is not a goal. The largest step and the rule are fixed. [`Reference::refined`] shortens the step, to show
//! that the result does not change.
//!
//! [`Extended`] computes the trajectory to about 30 digits by Taylor series in numbers of two doubles, and shares no
//! method with [`Reference`].

mod compressed;
mod crossing;
mod end_conditions;
mod error;
mod extended;
mod friction;
mod gauss;
mod integrator;
mod push;
mod rate;
mod stops;

pub use error::ReferenceError;
pub use extended::{DoubleDouble, Extended, ExtendedCrossing, ExtendedPassage};
pub use integrator::{Crossing, Moment, Passage, Reference};
