//! The state of a mesh under the mean load, if it is computed from the drawing of its gears.

use serde::{Deserialize, Serialize};

/// The state of a computed mesh under the mean load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeshUnderLoad {
    /// Angle between the flanks in the plane of action ε_eff, with the tilt of the shafts if requested \[rad\].
    pub misalignment: f64,
    /// Mean load centroid z_c: position of the mesh force along the face, from mid-face \[m\].
    pub load_centre: f64,
    /// Mean stiffness over the mesh cycle \[N/m\].
    pub stiffness: f64,
    /// Mean number of pairs of teeth that carry load.
    pub contact_ratio: f64,
    /// Peak-to-peak loaded static transmission error \[m\].
    pub transmission_error: f64,
}
