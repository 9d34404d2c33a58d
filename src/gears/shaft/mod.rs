//! Structures: beam elements, assembly, modes. Independent of files and dynamics.

mod assembly;
mod banded;
mod beam;
mod body;
mod disc;
mod drive;
mod error;
mod flexible;
mod modes;
mod projection;
mod rigid;
mod rolling;
mod train;
mod two_shafts;

pub use assembly::{AssembledMatrices, Assembly, CouplingMatrices, Freedom, NODE_FREEDOMS};
pub use beam::{BeamElement, ELEMENT_FREEDOMS, ElementMatrix, Material, Section};
pub use disc::Disc;
pub use drive::{Bearing, Drag, FlexibleDrive, Motion, Pedestal, Shaft};
pub use error::ShaftError;
pub use modes::Modes;
pub use rigid::{RigidDrive, Tier};
pub use rolling::{RING_FREEDOMS, Ring, RollingBearing, RollingElement, RollingLaw, RollingLoad};
pub use train::{
    DrawnLaw, GearPlace, Housing, HousingError, HousingJoint, HousingNode, HousingPoint,
    Hysteresis, JoinedHousing, LoadedBearing, LooseGear, MeshLaw, ParallelPlacement, Planet,
    PlanetarySet, ShaftCoupling, ShaftSection, Stage, StageSide, Stop, TrainDrive, TrainError,
    TrainGear, TrainMesh, TrainShaft, mean_forces, phase_of_planet,
};
