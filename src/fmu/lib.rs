//! The library in an FMU: the C interfaces of FMI 2.0 and FMI 3.0, for co-simulation, over one instance.
//!
//! All functions of both standards' co-simulation stand here by their names, and those of FMI 3.0 for other kinds of FMU, which
//! importers ask for as well. They take what the importer hands over (`foreign`), ask the `instance`, and answer with a
//! status; a refusal is a sentence to the importer's logger. Nothing is printed, and no panic leaves.

mod absent;
mod export;
mod fmi2;
mod fmi3;
mod foreign;
mod instance;
mod panics;
mod resource_path;

use gearatlas_jobs::fmu::MARK;

/// By this the program knows the library of its own version.
#[used]
static OF_VERSION: &str = MARK;
