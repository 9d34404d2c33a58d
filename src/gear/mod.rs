//! Gear geometry and what follows from it; knows nothing of files or dynamics.

mod compliance;
mod error;
mod flanks;
mod form;
mod involute;
mod pair;
mod tooth;

pub use compliance::{PairCompliance, ToothCompliance};
pub use error::GearError;
pub use flanks::{Flanks, PathOfContact};
pub use form::{BasicRack, Material, Relief, ToothForm};
pub use involute::{inverse_involute, involute};
pub use pair::GearPair;
pub use tooth::{ProfilePoint, Tooth};
