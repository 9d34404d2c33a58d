//! Continuation of periodic orbits over a parameter, through their bifurcations.

pub mod bifurcation;
pub mod branch;
pub mod curve;
pub mod drive;
pub mod end;
pub mod explore;
pub mod kind;
mod locate;
pub mod map;
pub mod onset;
pub mod orbit;
pub mod path;
pub mod search;
pub mod switch;
pub mod touches;
