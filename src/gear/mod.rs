//! Gear geometry and what follows from it; knows nothing of files or dynamics.

mod pair;

pub use pair::GearPair;
