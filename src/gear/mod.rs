//! Gear geometry and what follows from it; knows nothing of files or dynamics.

mod flank_law;
mod friction;
mod mesh_table;
mod misalignment;
mod pair;
mod sharing;

pub use flank_law::{FlankLaw, PairCompliance, PathOfContact};
pub use friction::{FrictionDirection, friction_direction};
pub use mesh_table::{
    MeshTable, MeshTableCycle, MeshTableError, MeshTableInputs, MeshTablePiece, NODES, SegmentMeans,
};
pub use misalignment::{
    MisalignmentEnding, MisalignmentReport, MisalignmentSearch, MisalignmentStep, TiltCompliance,
    loaded_misalignment,
};
pub use pair::GearPair;
pub use sharing::{
    Contact, ContactPair, Face, Foundation, LoadSharing, MOST_PAIRS, SharedLoad, SharingError,
    pairs_at,
};
