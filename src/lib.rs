//! Gear rattle over grids of operating points: a flexible drive with backlash is
//! propagated exactly between breakpoints, events are located to round-off, and every
//! point of a grid is answered with numbers that carry their error.
//!
//! Data flows one way:
//!
//! ```text
//! manifest → gear + shaft → model → propagate → analysis → store → report
//! ```
//!
//! `sweep` drives the middle, `cli` drives everything. A module imports only from
//! layers above its own line; `tests/architecture.rs` holds the code to that.

pub mod analysis;
pub mod characterize;
pub mod cli;
pub mod export;
pub mod gear;
pub mod input;
pub mod manifest;
pub mod model;
pub mod numerics;
pub mod propagate;
pub mod reference;
pub mod report;
pub mod shaft;
pub mod store;
pub mod sweep;
pub mod topology;
pub mod units;
pub mod verify;
