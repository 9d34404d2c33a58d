//! Drives of few modes: eight points at a time, one in each lane of the vectors.
//!
//! The matrices of so few modes do not fill the lanes of one point. Therefore eight points advance together
//! ([`passes`]), each in its own mesh cycle, with its own systems, events and breakpoints ([`batch`]). Each point is
//! computed on a stack of its own, which waits while its cycle is in a lane ([`group`]). A cycle that the lanes cannot
//! prove free of a missed event is integrated alone. A lane does not depend on the others, so results do not depend on
//! which points are computed at the same time.

mod batch;
mod beside;
mod cubics;
mod group;
mod passes;
mod tables;

pub use beside::{SideBySide, map_side_by_side};
pub use group::{Seat, work_side_by_side};
pub use tables::{MOST_MODES, PointTables};

#[cfg(test)]
mod tests;
