//! The library in an FMU: the C interfaces of FMI 2.0 and FMI 3.0 for co-simulation, with a common
//! implementation.
//!
//! The library exports all functions of both standards for co-simulation. It also exports the functions of
//! FMI 3.0 for other kinds of FMU, because importers require them. The functions convert the importer's
//! arguments (`foreign`), call the `instance`, and return a status. If a call is refused, the importer's
//! logger gets a sentence with the reason. The library prints nothing, and catches all panics.

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
