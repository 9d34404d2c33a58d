//! The keys of a manifest, with one file per table, and those of a modal file and of a housing file.

mod analyses;
mod continuation;
mod excitation;
mod gear;
mod grid;
mod housing_file;
mod job;
mod mesh;
mod modal_file;
mod model;
mod rolling;
mod run;
mod runup;
mod shafts;
mod train;

use super::Schema;
use super::key::{Bounds, bounds};
pub(in crate::manifest) use analyses::FEWEST_CYCLES;
pub(in crate::manifest) use train::OF_MESH;

/// The keys of a manifest.
pub(in crate::manifest) static MANIFEST: Schema = &[
    job::KEYS,
    model::KEYS,
    gear::KEYS,
    shafts::KEYS,
    train::KEYS,
    rolling::OF_SHAFT,
    rolling::OF_LOOSE,
    rolling::OF_PLANET,
    mesh::KEYS,
    excitation::KEYS,
    grid::KEYS,
    run::KEYS,
    analyses::KEYS,
    continuation::KEYS,
    runup::KEYS,
];

/// The keys of a modal file.
pub(in crate::manifest) static MODAL_FILE: Schema = &[modal_file::KEYS];

/// The keys of a housing file.
pub(in crate::manifest) static HOUSING_FILE: Schema = &[housing_file::KEYS];

/// Fractions above 0 and below 1.
const INSIDE_ONE: Bounds = bounds(0.0, true, 1.0, true);
