//! Why does a point have no mesh?

use crate::gear::{GearError, MeshTableError};
use crate::store::MeshFetchError;

/// Why a point has no mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The table needs a mean load, but there is none.
    #[error(
        "the mesh table is computed under the mean load, but the load is 0; give a small load, \
         mesh.resolution = \"pairs\" or another mesh.stiffness"
    )]
    NoLoad,
    /// The gears do not mesh.
    #[error(transparent)]
    Gear(#[from] GearError),
    /// The pairs of teeth cannot share the load at some misalignment.
    #[error(transparent)]
    Table(#[from] MeshTableError),
    /// The table can neither be read nor computed.
    #[error(transparent)]
    Fetch(#[from] MeshFetchError),
    /// No misalignment of the flanks under load agrees with the tilt of the shafts.
    #[error(
        "misalignment and shaft tilt do not converge after {steps} steps (last misalignment \
         {misalignment:.3e} rad, residual {residual:.1e} rad); lower the load, stiffen shafts or bearings, \
         or set mesh.shaft_tilt = false"
    )]
    Unsettled {
        /// Evaluations of the load centroid.
        steps: usize,
        /// Last misalignment that was tried \[rad\].
        misalignment: f64,
        /// Misalignment from the structure minus the one that was tried \[rad\].
        residual: f64,
    },
}
