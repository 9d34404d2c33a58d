//! How a mesh follows from the drawing of its gears.

use super::StiffnessLaw;
use crate::gear::{Contact, FaceLaw, GearPair};
use serde::Serialize;

/// Stiffness, load centroid and friction from a mesh table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshTableSpec {
    /// The gears, their bores known.
    pub gears: GearPair,
    /// How the table is used over the cycle.
    pub division: CycleDivision,
    /// Which stiffness stands for the mesh about the mean load; of springs of pairs it is only told.
    pub stiffness: StiffnessLaw,
    /// Whether the shafts' tilt under the mean load adds to the misalignment.
    pub shaft_tilt: bool,
    /// How the flanks flatten where they touch.
    pub contact: Contact,
    /// Whether slices of the face support each other.
    pub face: FaceLaw,
}

/// How a mesh table is used over the cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum CycleDivision {
    /// Load centroid and friction as means over so many equal segments, where they vary, and so the tangent stiffness;
    /// the secant stiffness as it is.
    Segments(u32),
    /// Stiffness as it is, broken at its true transitions only.
    Continuous,
    /// No tangent at the mean load: every pair of teeth is a spring across a gap of its own, on so many slices of
    /// the face.
    Pairs {
        /// Equal slices of the face.
        slices: u32,
    },
}
