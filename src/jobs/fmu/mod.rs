//! A drive as a functional mock-up unit (FMU), which other simulators step: FMI 2.0 and 3.0, co-simulation.
//!
//! ```text
//! manifest → Drive → Description → modelDescription.xml ┐
//!                 └→ Resources ─────────────────────────┴→ archive
//! resources → Drive → Plant, which steps a LiveState
//! ```
//!
//! The program writes the file. The library in it reads the resources again. Both make the same list of variables from
//! the same manifest ([`Description`]), so a value reference is an index in this list.

mod archive;
mod description;
mod drive;
mod error;
mod export;
mod inputs;
mod live;
mod names;
mod plant;
mod resources;
mod sensors;
mod xml;

pub use description::{Description, Role, Variable};
pub use drive::Drive;
pub use error::FmuError;
pub use export::{MARK, Platform, export};
pub use inputs::{INPUTS, Input};
pub use live::{LiveState, Mode};
pub use plant::Plant;
pub use xml::{MODEL_IDENTIFIER, Version};
