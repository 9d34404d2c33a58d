//! Why could a check not run?

use crate::analysis::{Interrupted, SliceError};
use crate::fmu::FmuError;
use crate::gear::{GearError, MeshTableError, SharingError};
use crate::manifest::ManifestErrors;
use crate::model::ModelError;
use crate::propagate::varying_speed::VaryingSpeedError;
use crate::propagate::{Stop, TableError};
use crate::reference::ReferenceError;
use crate::shaft::ShaftError;
use crate::store::MeshFetchError;
use crate::structure::ModeCount;
use crate::sweep::build::BuildError;
use std::error::Error;

/// Why a check could not run.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// A kernel stopped.
    #[error(transparent)]
    Stop(#[from] Stop),
    /// A kernel's tables cannot be built.
    #[error(transparent)]
    Tables(#[from] TableError),
    /// A kernel from outside this crate cannot be built.
    #[error(transparent)]
    Kernel(Box<dyn Error + Send + Sync>),
    /// The reference integrator stopped.
    #[error("the reference integrator stopped: {0}")]
    Reference(#[from] ReferenceError),
    /// A structure cannot be assembled.
    #[error(transparent)]
    Shaft(#[from] ShaftError),
    /// A structure has fewer modes than requested.
    #[error(transparent)]
    ModeCount(#[from] ModeCount),
    /// Gears do not mesh.
    #[error(transparent)]
    Gear(#[from] GearError),
    /// A load cannot be distributed.
    #[error(transparent)]
    Sharing(#[from] SharingError),
    /// A mesh table cannot be computed.
    #[error(transparent)]
    MeshTable(#[from] MeshTableError),
    /// The mesh table of a pair of gears cannot be obtained.
    #[error(transparent)]
    MeshFetch(#[from] MeshFetchError),
    /// A model cannot be formed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The built-in drive cannot be read.
    #[error("the manifest of the built-in drive has errors: {0}")]
    Manifest(#[from] ManifestErrors),
    /// The model of a manifest cannot be built.
    #[error(transparent)]
    Build(#[from] Box<BuildError>),
    /// A drive cannot run at a varying speed.
    #[error(transparent)]
    VaryingSpeed(#[from] VaryingSpeedError),
    /// A drive cannot be an FMU.
    #[error(transparent)]
    Fmu(#[from] Box<FmuError>),
    /// The requested slice of initial states does not exist.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// An analysis ended without a result.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A temporary folder cannot be used.
    #[error("cannot use a temporary folder: {0}")]
    Folder(#[from] std::io::Error),
    /// Threads cannot be started.
    #[error("cannot start worker threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A result cannot be converted to bytes for a comparison.
    #[error("bytes: {0}")]
    Bytes(#[from] postcard::Error),
    /// A prerequisite of the check is missing.
    #[error("{what} is missing")]
    Missing {
        /// Description of the prerequisite.
        what: &'static str,
    },
}
