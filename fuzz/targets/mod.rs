//! Fuzz targets: functions of bytes, each with assertions for any bytes.
//!
//! For any bytes, the program neither panics nor hangs nor allocates without limit. Accepted input is valid, and
//! refusals are texts that fit a terminal. A wrong result causes a panic with a text that begins with [`WRONG`], so
//! that counts distinguish it from a crash.
//!
//! The functions are independent of the source of the bytes: `fuzz/src/target.rs` runs them with libFuzzer,
//! `tests/house/fuzz_targets.rs` with a seeded generator and with all inputs that ever broke them.

// Each of the two programs uses a part of it.
#![allow(dead_code, unused_imports)]

pub mod breakpoints;
mod command;
mod drive;
mod journal;
mod manifest;
mod points;
mod results;
pub mod row;
mod scratch;
pub mod seeds;
mod table;
mod units;

pub use drive::BASES;

/// Prefix of the text of a panic about a wrong result.
pub const WRONG: &str = "WRONG: ";

/// A function of bytes.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name: that of its folder of seeds.
    pub name: &'static str,
    /// Its purpose.
    pub about: &'static str,
    /// Passes bytes to the program.
    pub run: fn(&[u8]),
}

const fn target(name: &'static str, run: fn(&[u8]), about: &'static str) -> Target {
    Target { name, about, run }
}

/// All targets.
pub static TARGETS: [Target; 14] = [
    target("manifest", manifest::manifest, "text of a manifest"),
    target(
        "modal",
        manifest::modal,
        "modal file, and the model it gives",
    ),
    target("changes", manifest::changes, "keys that `--set` changes"),
    target("points", points::points, "file of operating points"),
    target("units", units::units, "quantities with units"),
    target("command", command::command, "arguments of the command line"),
    target("table", table::table, "kept table, as it lies on the disk"),
    target(
        "table-sealed",
        table::sealed,
        "kept table with checksums that fit",
    ),
    target(
        "journal",
        journal::journal,
        "journal, as it lies on the disk",
    ),
    target(
        "journal-sealed",
        journal::sealed,
        "record of a journal with a checksum that fits",
    ),
    target("results", results::table, "result table without a record"),
    target(
        "record",
        results::record,
        "record of a run with a checksum that fits",
    ),
    target(
        "drive",
        drive::drive,
        "changed drive, computed by two kernels",
    ),
    target(
        "breakpoints",
        breakpoints::breakpoints,
        "breakpoints that nearly coincide",
    ),
];

/// The target with a name.
pub fn named(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

/// Panics if a result is wrong.
fn right(holds: bool, what: impl FnOnce() -> String) {
    if !holds {
        panic!("{WRONG}{}", what());
    }
}
