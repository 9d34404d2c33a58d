//! Gear geometry and derived quantities; independent of files and dynamics.

mod compliance;
mod drawing_checks;
mod error;
mod even_sharing;
mod faulty_flanks;
#[cfg(test)]
mod fixtures;
mod flank_law;
mod flanks;
mod form;
mod friction;
mod friction_turns;
mod helix;
mod internal;
mod involute;
mod mean_friction;
mod mesh_springs;
mod mesh_table;
mod misalignment;
mod modification;
mod oil_film;
mod pair;
mod root_crack;
mod sharing;
mod symmetry;
mod tip_contact;
mod tooth;
mod tooth_fault;

pub use compliance::{FaceCoupling, PairCompliance};
pub use error::{FlankCourse, GearError};
pub(crate) use error::{non_negative, positive};
pub use even_sharing::EvenSharing;
pub use faulty_flanks::FaultyFlanks;
pub use flank_law::{FlankLaw, IndependentSlices, SecantContact};
pub use flanks::{Flanks, PathOfContact};
pub use form::{BasicRack, BodyShape, FaceOverhang, Hub, Material, Plane, ToothForm, Web};
pub use friction::{FrictionDirection, friction_direction};
pub use internal::{InternalError, InternalPair};
pub use involute::{inverse_involute, involute};
pub use mean_friction::MeanFriction;
pub use mesh_springs::{MeshSprings, SpringPiece, SpringStretch};
pub use mesh_table::{
    CycleDivision, FaceLaw, JoinedPieces, JoiningAccuracy, MeshTable, MeshTableCycle,
    MeshTableError, MeshTableInputs, MeshTablePiece, MeshTableSpec, NODES, SegmentMeans,
    StiffnessLaw,
};
pub use misalignment::{
    MisalignmentEnding, MisalignmentReport, MisalignmentSearch, MisalignmentStep, TiltCompliance,
    loaded_misalignment,
};
pub use modification::{Modification, Relief, ReliefCourse};
pub use oil_film::OilFilm;
pub use pair::GearPair;
pub use root_crack::RootCrack;
pub use sharing::{
    Contact, ContactPair, Face, HelicalFace, LoadSharing, MOST_PAIRS, SharedLoad, SharingError,
    pairs_at,
};
pub use symmetry::standard_symmetry;
pub use tooth::{ProfilePoint, Tooth, Undercut};
pub use tooth_fault::{FaultyTeeth, ToothFault};
