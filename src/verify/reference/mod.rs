//! An independent event-driven integrator for cross-checks. It computes the trajectory to round-off from
//! [`Model::derivative`](crate::model::Model::derivative). It imports `model` only, and shares no code with
//! the kernels.
//!
//! Between breakpoints (segment boundaries, changes of contact state) the vector field is smooth and is
//! integrated by Gauss collocation of order 16 with compensated summation. Newton's method locates crossings
//! of the switching surfaces. Each of its evaluations is an integration from the start of the step, so that a
//! crossing is known to round-off. Minima of the distance to a surface between two samples of a step are
//! located, so that no pair of grazing crossings is missed.
//!
//! Speed is not a goal. The step and the rule are fixed. [`Reference::refined`] shortens the step, to show
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
