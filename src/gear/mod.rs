//! Gear geometry and what follows from it; knows nothing of files or dynamics.

mod error;
mod form;
mod involute;
mod pair;

pub use error::GearError;
pub use form::{BasicRack, Material, Relief, ToothForm};
pub use involute::{inverse_involute, involute};
pub use pair::GearPair;
