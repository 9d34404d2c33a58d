//! The paper's kernels compared with `volterra`, with the reference integrators and with their recorded results.

#![allow(clippy::unwrap_used)]

// Modules of the tests of `atlas`; the tests here use only parts of them.
#[allow(dead_code)]
#[path = "../../../../fuzz/targets/breakpoints.rs"]
mod breakpoint_motion;
#[path = "../../../../tests/common/mod.rs"]
mod common;
#[path = "../../../../tests/common/counting.rs"]
mod counting;
#[path = "../../../../tests/fuzz/dice.rs"]
mod dice;
#[allow(dead_code)]
#[path = "../../../../tests/fuzz/drawn.rs"]
mod drawn;
#[path = "../../../../tests/common/leaps.rs"]
mod leaps;
#[allow(dead_code)]
#[path = "../../../../tests/common/random_drives.rs"]
mod random_drives;
#[path = "../../../../fuzz/targets/row.rs"]
mod row;

mod allocation;
mod analyses;
mod bases;
mod breakpoints;
mod golden;
mod ladder;
mod ladder_fused;
mod random;
mod refusals;
mod repeated_modes;
mod verify;

/// The assertion for the shared checks of motions.
fn right(holds: bool, message: impl FnOnce() -> String) {
    assert!(holds, "{}", message());
}
