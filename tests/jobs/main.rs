//! Manifests, runs and result tables, mostly by the program in a separate process.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/place.rs"]
mod place;
#[path = "../common/program.rs"]
mod program;
#[path = "../common/results.rs"]
mod results;
#[path = "../common/seal.rs"]
mod seal;

mod appended;
mod bounds;
mod changed_keys;
mod check;
mod cut_table;
mod damage;
mod disk_full;
mod dry_friction;
mod fmu;
mod follow;
mod follow_bifurcations;
mod help;
mod hostile_names;
mod hysteresis;
mod interrupt;
mod limits;
mod machine;
mod manifest;
mod manifest_errors;
mod many_points;
mod merge;
mod messages;
mod modal_axes;
mod new;
mod plan;
mod planted;
mod points;
mod power_cut;
mod refined;
mod retry;
mod rigid_stops;
mod run;
mod run_up;
mod samples;
mod store_sample;
mod stream;
mod sweep;
mod train_size;
mod verify;
mod warnings;

use common::skipped;
