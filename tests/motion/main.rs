//! Motions, orbits and statistics compared with closed forms, other integrators and each other.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../fuzz/dice.rs"]
mod dice;
#[path = "../fuzz/drawn.rs"]
mod drawn;
#[path = "../common/leaps.rs"]
mod leaps;
#[path = "../common/place.rs"]
mod place;
#[path = "../common/processor.rs"]
mod processor;
#[path = "../common/program.rs"]
mod program;
#[path = "../common/random_drives.rs"]
mod random_drives;
#[path = "../common/results.rs"]
mod results;
#[path = "../common/stopped.rs"]
mod stopped;
#[path = "../../fuzz/targets/mod.rs"]
mod targets;

mod analysis;
mod any_drive;
mod basins;
mod bearing_forces;
mod breakpoints;
mod coast_flank;
mod coasting;
mod contact_jumps;
mod continuation;
mod continuous;
mod coverage;
mod cycle_map;
mod doubling;
mod drift;
mod dry_friction;
mod dynamics;
mod events;
mod exponents;
mod extended;
mod film;
mod flank_error;
mod followed;
mod fuzz_drives;
mod horizon;
mod hysteresis;
mod impacts;
mod instructions;
mod kept_tables;
mod kernel_choice;
mod kernel_tables;
mod lifetime;
mod losses;
mod multistability;
mod nvh;
mod nvh_stop;
mod orbits;
mod power_balance;
mod quasi_static;
mod reference;
mod release;
mod sensitivity;
mod settling;
mod specialisation;
mod statics;
mod steady_contact;
mod stepping;
mod torque_balance;
mod trace;
mod varying_speed;
mod verdicts;
mod volterra;

use common::{default_drive, skipped};
use targets::row;
