//! Pictures, pages and exports.

#![allow(clippy::unwrap_used)]

#[path = "../common/program.rs"]
mod program;
#[path = "../common/seal.rs"]
mod seal;

mod export;
mod plot;
mod report;
