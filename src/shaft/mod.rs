//! Structures: beam elements, assembly, modes. Knows nothing of files or dynamics.

mod drive;
mod modal;

pub use drive::{Bearing, FlexibleDrive, Shaft};
pub use modal::ModalStructure;
