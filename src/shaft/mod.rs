//! Structures: beam elements, assembly, modes. Knows nothing of files or dynamics.

mod assembly;
mod beam;
mod drive;
mod error;
mod flexible;
mod modal;
mod modes;

pub use assembly::{AssembledMatrices, Assembly, Disc, Freedom, NODE_FREEDOMS};
pub use beam::{BeamElement, ELEMENT_FREEDOMS, ElementMatrix, Material, Section};
pub use drive::{Bearing, FlexibleDrive, Shaft};
pub use error::ShaftError;
pub use modal::{BearingGain, ModalStructure};
pub use modes::Modes;
