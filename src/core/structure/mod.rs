//! A linear structure in modal coordinates, reduced to its contacts. Independent of gears, files and motion.

mod dry_friction;
mod friction_part;
mod mesh_harmonic;
mod modal;
mod mode_shapes;
mod slider;
mod slider_part;
mod static_share;
mod stop;
mod stop_part;

pub use dry_friction::FrictionLaw;
pub use friction_part::FrictionPart;
pub use mesh_harmonic::MeshHarmonic;
pub use modal::{
    BearingGain, ContactLaw, Coupling, FlankParticipation, HarmonicLoad, MOST_BASE_CYCLES,
    MOST_RATIO_CYCLES, ModalStructure, ModeCount, MotionKind, PlaceMotion, StructureContact,
    TorqueGain, TurningFrame,
};
pub use mode_shapes::ModeShapes;
pub use slider_part::SliderPart;
pub use static_share::OmittedModeForces;
pub use stop_part::StopPart;
