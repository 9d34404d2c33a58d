//! Errors of exporting a drive as an FMU and of reading it back.

use crate::manifest::ManifestErrors;
use crate::propagate::varying_speed::VaryingSpeedError;
use crate::shaft::ShaftError;
use crate::sweep::build::BuildError;
use std::path::PathBuf;

/// Why a drive cannot be exported as an FMU or read back.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// The structure cannot be computed.
    #[error("the structure cannot be computed: {0}")]
    Structure(#[from] ShaftError),
    /// The drive cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The drive cannot be stepped.
    #[error(transparent)]
    Kernel(#[from] VaryingSpeedError),
    /// The structure has no participation of a torque on a shaft.
    #[error(
        "the structure does not say what a torque on the {shaft}'s shaft does; {}",
        if *modal {
            "give torque_pinion, torque_wheel and teeth_wheel in the modal file"
        } else {
            "an FMU needs a drive whose first two gears are fixed on their shafts, without planets"
        }
    )]
    NoTorque {
        /// `pinion` or `wheel`.
        shaft: &'static str,
        /// Whether the structure is from a modal file.
        modal: bool,
    },
    /// Something holds or brakes the rotation of the whole drive.
    #[error(
        "the drive does not turn freely, so that torques do not set its speed; remove viscous drag (shafts.*.drag) and springs \
         to the ground on its rotation"
    )]
    Held,
    /// The values of the parameters do not describe a drive, or the job has no point of the chosen number.
    #[error("these parameters do not describe a drive: {0}")]
    Parameters(String),
    /// Two variables would have the same name.
    #[error("two variables are called {name}; rename a mesh, a bearing or a shaft")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// The manifest in the resources is faulty.
    #[error("the manifest in the resources is faulty: {0}")]
    Manifest(#[from] ManifestErrors),
    /// A file of the resources, or one that the manifest names, cannot be read.
    #[error("`{}` cannot be read: {why}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// The description was written for other resources or another library.
    #[error(
        "the token {given} is not that of the resources, {expected}: the description, the resources and the library must come \
         from one file that `atlas fmu` wrote"
    )]
    Token {
        /// The token from the importer.
        given: String,
        /// The token of the resources and this library.
        expected: String,
    },
    /// The library belongs to another version than the program.
    #[error(
        "it is not the library of this version of atlas ({mark}); build both from the same sources"
    )]
    OtherLibrary {
        /// The text that the right library contains.
        mark: &'static str,
    },
    /// The archive cannot be written.
    #[error("the archive cannot be written: {0}")]
    Archive(String),
}
