//! What does a drawing say about the teeth beyond number, module, pressure angle and width?

use super::modification::{Modification, Relief};
use crate::numerics::point_course::PointCourse;
use strum::EnumString;

/// Shape and material of the teeth. Arrays are `[pinion, wheel]`.
///
/// The default is an unshifted pair of the rack of ISO 53, profile A, at its reference centre
/// distance, of steel, without relief.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ToothForm {
    /// Profile shift coefficients x \[1\], in normal modules, positive if they make the teeth thicker: away
    /// from the axis, for a ring towards the axis.
    pub profile_shift: [f64; 2],
    /// The basic rack that cuts both gears.
    pub rack: BasicRack,
    /// Reduction of each tooth's thickness along its reference circle from that by the profile shift
    /// \[m\]. The rack is fed deeper by `thinning / (2 tan α_t)` to get it.
    pub thinning: [f64; 2],
    /// Centre distance \[m\]; `None`: the one without backlash for the profile shifts.
    pub centre_distance: Option<f64>,
    /// Tip diameters \[m\]; `None`: `m_t z + 2 m_n (h_a + x + k)` with the tip alteration k that
    /// keeps the rack's clearance (ISO 21771, 10.3).
    pub tip_diameter: [Option<f64>; 2],
    /// Material taken off towards the tip, falling to 0 from the tip circle inwards.
    pub tip_relief: [Relief; 2],
    /// Material taken off towards the root, falling to 0 from the start of the active profile
    /// outwards.
    pub root_relief: [Relief; 2],
    /// How far each gear's face reaches beyond the common face of both.
    pub overhang: [FaceOverhang; 2],
    /// Middle of the common face from the middle of the gear bodies, along +z \[m\].
    pub face_middle: f64,
    /// Material taken off towards both ends of each gear's face.
    pub end_relief: [Relief; 2],
    /// Crowning and slope of the profile, root to tip.
    pub profile: [Modification; 2],
    /// Crowning and slope of the lead, over each gear's face width.
    pub lead: [Modification; 2],
    /// Missing material \[m\] of the profile through points, over the roll length from the base circle (base radius
    /// times roll angle) in the transverse section.
    pub profile_points: [PointCourse; 2],
    /// Missing material \[m\] of the lead through points, over the distance from the middle of each gear's face.
    pub lead_points: [PointCourse; 2],
    /// Bore of the gear bodies \[m\], where they are clamped; `None`: the shaft's diameter, which this drawing does
    /// not contain.
    pub bore: [Option<f64>; 2],
    /// Outer diameter of a ring with inner teeth as the wheel \[m\]. The ring is clamped all round there, and the
    /// wheel has no bore. `None`: the teeth of the wheel point outwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ring: Option<f64>,
    /// Materials of the gears.
    pub material: [Material; 2],
    /// Hubs, webs and rims of the gear bodies. They do not affect the flanks.
    pub body: [BodyShape; 2],
    /// The plane state of teeth and bodies.
    pub plane: Plane,
}

impl ToothForm {
    /// The form of a pair of gears with separate drawings: the first entries of `one` and the second ones
    /// of `two`. Common values are those of `one`.
    pub fn of_each(one: &Self, two: &Self) -> Self {
        fn both<T: Clone>(one: &[T; 2], two: &[T; 2]) -> [T; 2] {
            [one[0].clone(), two[1].clone()]
        }
        Self {
            profile_shift: both(&one.profile_shift, &two.profile_shift),
            thinning: both(&one.thinning, &two.thinning),
            tip_diameter: both(&one.tip_diameter, &two.tip_diameter),
            tip_relief: both(&one.tip_relief, &two.tip_relief),
            root_relief: both(&one.root_relief, &two.root_relief),
            overhang: both(&one.overhang, &two.overhang),
            end_relief: both(&one.end_relief, &two.end_relief),
            profile: both(&one.profile, &two.profile),
            lead: both(&one.lead, &two.lead),
            profile_points: both(&one.profile_points, &two.profile_points),
            lead_points: both(&one.lead_points, &two.lead_points),
            bore: both(&one.bore, &two.bore),
            ring: two.ring,
            material: both(&one.material, &two.material),
            body: both(&one.body, &two.body),
            ..one.clone()
        }
    }

    /// Reverses the lead of a gear along its face: slope and points change ends.
    pub fn turn_lead(&mut self, gear: usize) {
        self.lead[gear].slope *= -1.0;
        let points = &mut self.lead_points[gear].points;
        points.reverse();
        points.iter_mut().for_each(|point| point[0] *= -1.0);
    }

    /// Whether any material is missing along the lead.
    pub fn has_modified_lead(&self) -> bool {
        self.has_curved_lead() || self.lead.iter().any(|lead| lead.slope != 0.0)
    }

    /// Whether the missing material may vary nonlinearly along the lead; leads through points always count.
    pub fn has_curved_lead(&self) -> bool {
        self.lead.iter().any(|lead| lead.crowning != 0.0)
            || self.end_relief.iter().any(|relief| relief.amount != 0.0)
            || self.lead_points.iter().any(|lead| !lead.points.is_empty())
    }
}

impl Default for ToothForm {
    fn default() -> Self {
        Self {
            profile_shift: [0.0; 2],
            rack: BasicRack::default(),
            thinning: [0.0; 2],
            centre_distance: None,
            tip_diameter: [None; 2],
            tip_relief: [Relief::default(); 2],
            root_relief: [Relief::default(); 2],
            overhang: [FaceOverhang::default(); 2],
            face_middle: 0.0,
            end_relief: [Relief::default(); 2],
            profile: [Modification::default(); 2],
            lead: [Modification::default(); 2],
            profile_points: Default::default(),
            lead_points: Default::default(),
            bore: [None; 2],
            ring: None,
            material: [Material::default(); 2],
            body: [BodyShape::default(); 2],
            plane: Plane::default(),
        }
    }
}

/// Lengths by which a gear's face extends beyond the common face, on which flanks touch \[m\]; by default 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct FaceOverhang {
    /// Beyond the end of the common face at negative z.
    pub before: f64,
    /// Beyond the end of the common face at positive z.
    pub behind: f64,
}

impl FaceOverhang {
    /// Converts a position z from the middle of a common face to one from the middle of this gear's face. Also returns
    /// half the width of this gear's face \[m\].
    pub fn to_gear_face(&self, z: f64, common: f64) -> [f64; 2] {
        let Self { before, behind } = self;
        [
            z - 0.5 * (behind - before),
            0.5 * (common + before + behind),
        ]
    }
}

/// Construction of a gear body between shaft and teeth. By default the body is solid, with its full length down to
/// the shaft, and does not stiffen its shaft.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct BodyShape {
    /// The hub; `None` if the shaft bends as if it were alone.
    pub hub: Option<Hub>,
    /// The web; `None` if the body has its full length down to the hub or the shaft.
    pub web: Option<Web>,
}

/// The part of a gear body that bends and twists with its shaft, in the middle of the body.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Hub {
    /// Diameter \[m\].
    pub diameter: f64,
    /// Length along the shaft \[m\].
    pub length: f64,
}

impl Hub {
    /// Positions of both ends of a hub whose middle is at a position on its shaft \[m\].
    pub fn ends(&self, at: f64) -> [f64; 2] {
        [-0.5, 0.5].map(|side| at + side * self.length)
    }
}

/// The disc between hub (or shaft) and rim, in the middle of the body.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Web {
    /// Thickness along the shaft \[m\].
    pub thickness: f64,
    /// Inner diameter of the rim \[m\], which is as long as the body.
    pub rim_diameter: f64,
}

/// Basic rack of the gears in their normal section, in normal modules (ISO 53). The dedendum of the rack is the
/// addendum of the tool.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct BasicRack {
    /// Addendum `h_a` \[1\].
    pub addendum: f64,
    /// Dedendum `h_f` \[1\].
    pub dedendum: f64,
    /// Radius of the root, that is of the tool's tip, `ρ_f` \[1\].
    pub tip_radius: f64,
}

impl Default for BasicRack {
    fn default() -> Self {
        Self {
            addendum: 1.0,
            dedendum: 1.25,
            tip_radius: 0.38,
        }
    }
}

/// The plane state in which teeth and gear bodies deform. The flattening of the flanks is always
/// plane strain: its extent is short compared with the face width.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum Plane {
    /// Free of stress across the face: a face narrow compared with the deformed region.
    #[default]
    Stress,
    /// No strain across the face: a wide face.
    Strain,
}

/// An isotropic elastic material.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Material {
    /// Young's modulus E \[Pa\].
    pub young_modulus: f64,
    /// Poisson's ratio ν \[1\].
    pub poisson_ratio: f64,
}

impl Default for Material {
    /// Steel.
    fn default() -> Self {
        Self {
            young_modulus: 206e9,
            poisson_ratio: 0.3,
        }
    }
}

impl Material {
    /// Modulus in plane strain, `E / (1 − ν²)` \[Pa\].
    pub fn plane_strain_modulus(&self) -> f64 {
        self.young_modulus / (1.0 - self.poisson_ratio.powi(2))
    }

    /// The material whose plane stress equals this one's plane state. In plane strain Young's modulus
    /// is `E / (1 − ν²)` and Poisson's ratio `ν / (1 − ν)`.
    pub fn in_plane(&self, plane: Plane) -> Self {
        match plane {
            Plane::Stress => *self,
            Plane::Strain => Self {
                young_modulus: self.plane_strain_modulus(),
                poisson_ratio: self.poisson_ratio / (1.0 - self.poisson_ratio),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face of 24 mm over one of 20 mm, 1 mm before it and 3 mm behind.
    #[test]
    fn places_are_those_of_the_own_face() {
        let wide = FaceOverhang {
            before: 1e-3,
            behind: 3e-3,
        };
        for (z, own) in [(-10e-3, -11e-3), (0.0, -1e-3), (10e-3, 9e-3)] {
            let [found, half] = wide.to_gear_face(z, 20e-3);
            assert!((found - own).abs() < 1e-17 && (half - 12e-3).abs() < 1e-17);
        }
        assert_eq!(
            FaceOverhang::default().to_gear_face(3e-3, 20e-3),
            [3e-3, 10e-3]
        );
    }
}
