//! Gears, shafts and meshes compared with published values, finite elements and closed forms.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../../src/gears/gear/fixtures.rs"]
mod fixtures;
#[path = "../common/flank.rs"]
mod flank;

mod bearings;
mod contact_finite_elements;
mod flank_points;
mod gear_compliance;
mod gear_finite_elements;
mod gear_geometry;
mod gear_published;
mod geared_pair_published;
mod helical;
mod helical_finite_elements;
mod helical_shafts;
mod housing;
mod mesh_course;
mod mesh_pairs;
mod mesh_resolution;
mod mesh_structure;
mod mesh_table;
mod mesh_teeth;
mod planetary;
mod planetary_frames;
mod planetary_rattle;
mod planetary_sets;
mod ring_teeth;
mod sharing;
mod structure_published;
mod structure_reference;
mod table_course;
mod table_mesh;
mod tier_manifests;
mod tiers;
mod tooth_errors;
mod tooth_faults;
mod train_meshes;
mod trains;

use common::default_drive;

// Names that the fixtures use through `super`.
use gearatlas::gear::{GearPair, ToothForm};
