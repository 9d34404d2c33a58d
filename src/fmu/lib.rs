//! The library in an FMU: the C interfaces of FMI 2.0 and FMI 3.0, for co-simulation, over one instance.
//!
//! The library exports all functions of both standards for co-simulation by their names. It also exports those of FMI
//! 3.0 for other kinds of FMU, because importers need them. The functions convert the importer's arguments (`foreign`),
//! call the `instance`, and return a status; a refusal is a sentence to the importer's logger. The library prints
//! nothing, and no panic leaves it.

mod absent;
mod both;
mod export;
mod fmi2;
mod fmi3;
mod foreign;
mod instance;
mod panics;
mod resource_path;

use gearatlas_jobs::fmu::MARK;

/// Marks the library, so that the program recognises its own version.
#[used]
static OF_VERSION: &str = MARK;
