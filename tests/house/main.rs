//! The rules of the sources, the documents, and the fuzz targets.

#![allow(clippy::unwrap_used)]

#[path = "../fuzz/changed.rs"]
mod changed;
#[path = "../fuzz/dice.rs"]
mod dice;
#[path = "../fuzz/mutated.rs"]
mod mutated;
#[path = "../../fuzz/targets/mod.rs"]
mod targets;

mod architecture;
mod book;
mod fuzz_targets;
