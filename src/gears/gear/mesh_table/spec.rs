//! How does a mesh follow from the drawing of its gears?

use super::StiffnessLaw;
use crate::gear::{Contact, FaceLaw, GearPair};
use serde::Serialize;

/// Stiffness, load centroid and friction from a mesh table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshTableSpec {
    /// The gears, with known bores.
    pub gears: GearPair,
    /// How the table is used over the cycle.
    pub division: CycleDivision,
    /// Which stiffness represents the mesh near the mean load; with springs of pairs it is for information only.
    pub stiffness: StiffnessLaw,
    /// Whether the shafts' tilt under the mean load adds to the misalignment.
    pub shaft_tilt: bool,
    /// How the flanks flatten where they touch.
    pub contact: Contact,
    /// Whether slices of the face are elastically coupled.
    pub face: FaceLaw,
}

/// How a mesh table is used over the cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum CycleDivision {
    /// Means of the tangent stiffness, load centroid and friction over this number of equal segments. The secant
    /// stiffness is not averaged but follows the table, as in [`Self::Continuous`].
    Segments(u32),
    /// The stiffness follows the table by polynomials over joined pieces, each as long as its accuracy allows.
    Continuous,
    /// No linear law at the mean load: every pair of teeth is a spring across a separate gap, on each slice of
    /// the face.
    Pairs {
        /// Equal slices of the face.
        slices: u32,
    },
}
