//! The description of a flexible drive: two parallel shafts, bearings, gear bodies.

use crate::gear::GearPair;

/// Two parallel shafts on bearings, each with a gear body between its bearings and an
/// end inertia on an overhang; the structure of the `flexible` model kind.
#[derive(Debug, Clone, PartialEq)]
pub struct FlexibleDrive {
    /// The gear pair.
    pub gears: GearPair,
    /// Pinion shaft, wheel shaft.
    pub shafts: [Shaft; 2],
    /// Young's modulus \[Pa\].
    pub young_modulus: f64,
    /// Shear modulus \[Pa\].
    pub shear_modulus: f64,
    /// Density of shafts and gear bodies \[kg/m³\].
    pub density: f64,
    /// Timoshenko shear coefficient κ \[1\].
    pub shear_coefficient: f64,
    /// Elements on the overhang, from the first bearing to the gear, and from the gear to
    /// the second bearing.
    pub elements: [usize; 3],
    /// Global modal damping ratio of the elastic modes \[1\]; rigid modes are undamped.
    pub damping: f64,
    /// `(mode, ratio)` overrides, modes counted from 1 in ascending frequency.
    pub damping_overrides: Vec<(usize, f64)>,
}

/// One shaft with its two bearings and its end inertia.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// Diameter \[m\].
    pub diameter: f64,
    /// Distance between the bearings \[m\].
    pub span: f64,
    /// Length of the overhang before the first bearing \[m\].
    pub overhang: f64,
    /// Gear position as a fraction of the span from the first bearing, in (0, 1).
    pub gear_position: f64,
    /// Polar inertia at the free end of the overhang \[kg m²\].
    pub end_inertia: f64,
    /// Both bearings, first and second.
    pub bearings: [Bearing; 2],
}

/// Stiffness of one bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// Along the line of centres, x \[N/m\].
    pub line_of_centres: f64,
    /// Across it, y \[N/m\].
    pub across: f64,
    /// Axial \[N/m\].
    pub axial: f64,
    /// Both tilts \[N m/rad\].
    pub tilt: f64,
}
