//! What the mean load makes of a mesh that is computed from the drawing of its gears.

use serde::{Deserialize, Serialize};

/// What the mean load makes of a mesh that is computed from the drawing of its gears.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeshUnderLoad {
    /// Angle between the flanks in the plane of action, the shafts' tilt included where it is asked for, ε_eff \[rad\].
    pub misalignment: f64,
    /// Mean load centroid z_c: where along the face the mesh force acts, from mid-face \[m\].
    pub load_centre: f64,
    /// Mean stiffness over the mesh cycle \[N/m\].
    pub stiffness: f64,
    /// Mean number of pairs of teeth that bear load.
    pub contact_ratio: f64,
    /// Largest less smallest loaded static transmission error \[m\].
    pub transmission_error: f64,
}
