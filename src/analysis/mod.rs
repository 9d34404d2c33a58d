//! One file per question asked of a trajectory: numbers in, numbers out; no files, no threads.

mod outcome;

pub use outcome::*;
