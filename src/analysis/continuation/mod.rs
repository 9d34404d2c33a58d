//! Periodic orbits followed over a parameter, through their bifurcations.

pub mod bifurcation;
pub mod branch;
pub mod drive;
pub mod map;
pub mod orbit;
pub mod path;
pub mod search;
pub mod switch;
pub mod touches;
