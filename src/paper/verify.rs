//! The checks of `atlas verify`, with the paper's kernels.

use crate::kernels::{DenseError, Dyadic, Fused, Hermite, Spectral};
use crate::model::Model;
use gearatlas_verify::verify::candidate::{Candidate, Propagator};
use gearatlas_verify::verify::{self, Check, CheckError, Extent, Report, Subjects};

/// Largest number of events in a mesh cycle.
const EVENT_LIMIT: u32 = 10_000;

/// Smallest number of unit steps per mesh cycle, as published.
const CELLS: u32 = 60;

fn built<'m, P: Propagator + 'm>(
    kernel: Result<P, DenseError>,
) -> Result<Box<dyn Propagator + 'm>, CheckError> {
    match kernel {
        Ok(kernel) => Ok(Box::new(kernel)),
        Err(error) => Err(CheckError::Kernel(error.into())),
    }
}

/// The paper's kernels.
pub fn kernels() -> Vec<Candidate> {
    vec![
        Candidate::of_tables("dyadic", |model: &Model| {
            built(Dyadic::new(model, CELLS, EVENT_LIMIT))
        }),
        Candidate::of_tables("hermite", |model: &Model| {
            built(Hermite::new(model, CELLS, EVENT_LIMIT))
        }),
        Candidate::of_tables("spectral", |model: &Model| {
            built(Spectral::new(model, CELLS, EVENT_LIMIT, None))
        }),
        Candidate::of_tables("fused", |model: &Model| {
            built(Fused::new(model, CELLS, EVENT_LIMIT))
        }),
    ]
}

/// Names of the checks for every kernel.
pub const CHECKS: [&str; 11] = [
    "multipliers",
    "grazing",
    "bouncing",
    "rigid-pair",
    "cycle",
    "contact",
    "energy",
    "neutral",
    "tangents",
    "trace",
    "resumed",
];

/// The checks for every kernel, in the order of the program.
pub fn checks() -> impl Iterator<Item = Check> {
    let all = verify::CHECKS.iter().copied();
    all.filter(|check| CHECKS.contains(&check.name))
}

/// Runs checks on the paper's kernels. Calls `watch` with every check before it starts.
///
/// # Errors
/// The built-in drives cannot be assembled.
pub fn run(
    extent: Extent,
    checks: &[Check],
    watch: &mut dyn FnMut(&Check),
) -> Result<Report, CheckError> {
    let subjects = Subjects {
        kernels: kernels(),
        ..Subjects::all(extent)?
    };
    Ok(verify::run(&subjects, checks, watch))
}
