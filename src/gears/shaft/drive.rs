//! The description of a drive: two parallel shafts, bearings, gear bodies.

use super::assembly::{Assembly, Freedom};
use super::disc::Disc;
use super::error::ShaftError;
use super::rolling::{Ring, RollingBearing};
use crate::gear::GearPair;
use crate::gear::{non_negative, positive};
use strum::EnumString;

/// Two parallel shafts on bearings, each with a gear body between its bearings and an
/// end inertia on an overhang; the structure of the `flexible` model kind.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
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
    /// Whether shafts and gear bodies have gyroscopic moments.
    pub gyroscopic: bool,
}

/// One shaft with its two bearings and its end inertia.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Shaft {
    /// Diameter \[m\].
    pub diameter: f64,
    /// Inner diameter of a hollow shaft \[m\]; 0 for a solid one.
    pub inner_diameter: f64,
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
    /// Brakes of the shaft.
    pub drag: Drag,
}

/// Drag torques against the rotation of a shaft; none by default. In a drive with two shafts they act
/// at the free end of the overhang, where the end inertia is and torques act.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Drag {
    /// Viscous part, torque per speed of this shaft \[N m s/rad\].
    pub viscous: f64,
    /// Constant part, against the direction of rotation \[N m\].
    pub constant: f64,
}

/// Stiffness and damping of one bearing; zero by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Bearing {
    /// Along the line of centres, x \[N/m\].
    pub x: f64,
    /// Across it, y \[N/m\].
    pub y: f64,
    /// Axial \[N/m\].
    pub axial: f64,
    /// Both tilts \[N m/rad\].
    pub tilt: f64,
    /// Dampers, rows x and y of c in `−c (x', y')` \[N s/m\].
    pub damping: [[f64; 2]; 2],
    /// Cross-coupled stiffness `[k_xy, k_yx]` \[N/m\]: forces `−k_xy y` along x, `−k_yx x`
    /// along y.
    pub cross: [f64; 2],
    /// Rolling contacts in addition to these springs; only for trains.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolling: Option<RollingBearing>,
    /// Pedestal of the bearing, if the bearing is mounted neither on the ground nor on a housing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pedestal: Option<Pedestal>,
}

/// The support of a bearing of the `pedestal` tier: a mass that may move along and across the
/// line of centres, on springs to the ground.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Pedestal {
    /// Stiffness along the line of centres, x \[N/m\].
    pub x: f64,
    /// Stiffness across it, y \[N/m\].
    pub y: f64,
    /// Its mass \[kg\].
    pub mass: f64,
}

impl Pedestal {
    /// Adds its node to an assembly.
    pub(super) fn add(self, assembly: &mut Assembly) -> Result<usize, ShaftError> {
        let Self { x, y, mass } = self;
        positive("pedestal stiffness along the line of centres [N/m]", x)?;
        positive("pedestal stiffness across the line of centres [N/m]", y)?;
        positive("pedestal mass [kg]", mass)?;
        let node = assembly.add_node();
        for &freedom in &Freedom::ALL[2..] {
            assembly.fix(node, freedom)?;
        }
        assembly.add_spring(node, [x, y, 0.0, 0.0, 0.0, 0.0])?;
        let body = Disc {
            mass,
            ..Disc::default()
        };
        assembly.add_disc(node, body)?;
        Ok(node)
    }
}

/// Free motions of a shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum Motion {
    /// All six.
    All,
    /// The rotation about its axis, and x and y.
    Translation,
    /// The rotation about its axis; mounts are rigid.
    Rotation,
    /// All motions except the rotation, which is fixed at the position where torques would act.
    Lateral,
    /// None.
    None,
}

impl Motion {
    /// Whether the shaft may rotate.
    pub(super) fn may_rotate(self) -> bool {
        matches!(self, Self::All | Self::Translation | Self::Rotation)
    }

    /// The freedoms that are fixed at every node, without the rotation about the axis.
    pub(super) fn fixed_freedoms(self) -> &'static [Freedom] {
        match self {
            Self::All | Self::Lateral => &[],
            Self::Translation => &Freedom::ALL[2..5],
            Self::Rotation | Self::None => &Freedom::ALL[..5],
        }
    }

    /// Whether any motion besides the rotation is free.
    pub(super) fn may_deflect(self) -> bool {
        self.fixed_freedoms().len() < 5
    }
}

/// One bearing in an assembly.
#[derive(Debug, Clone, Copy)]
pub(super) struct Support {
    /// Node of the shaft.
    pub node: usize,
    /// Node below the bearing; `None` for the ground.
    pub base: Option<usize>,
    pub stiffness: Bearing,
    /// Stiffness of its rolling contacts at the mean load \[N/m, N, N m\]; zero without such contacts.
    pub contacts: Ring<Ring>,
}

impl Support {
    /// Adds a bearing between a node of a shaft and a base, or the ground, to an assembly. Its rolling contacts have no
    /// stiffness until its mean load is known.
    pub fn add(
        assembly: &mut Assembly,
        node: usize,
        base: Option<usize>,
        bearing: Bearing,
    ) -> Result<Self, ShaftError> {
        match base {
            None => assembly.add_spring(node, bearing.stiffness())?,
            Some(base) => assembly.add_spring_between(node, base, bearing.stiffness())?,
        }
        assembly.add_dampers(node, base, bearing.damping)?;
        assembly.add_cross_springs(node, base, bearing.cross)?;
        Ok(Self {
            node,
            base,
            stiffness: bearing,
            contacts: Ring::default(),
        })
    }

    /// Row of a freedom in the stiffness of springs and rolling contacts.
    pub fn row(&self, freedom: Freedom) -> Vec<(Freedom, f64)> {
        let [xy, yx] = self.stiffness.cross;
        let place = freedom as usize;
        let mut row = self.contacts[place];
        row[place] += self.stiffness.stiffness()[place];
        match freedom {
            Freedom::X => row[Freedom::Y as usize] += xy,
            Freedom::Y => row[Freedom::X as usize] += yx,
            _ => {}
        }
        Freedom::ALL.into_iter().zip(row).collect()
    }
}

/// Checks for every drive of two shafts. Bearings must hold the free motions `motion`.
pub(super) fn check(
    gears: &GearPair,
    shafts: &[Shaft; 2],
    density: f64,
    motion: Motion,
) -> Result<(), ShaftError> {
    positive("module [m]", gears.module)?;
    positive("rated torque [N m]", gears.rated_torque)?;
    positive("pressure angle [rad]", gears.pressure_angle)?;
    gears.operating_pressure_angle()?;
    positive("density [kg/m^3]", density)?;
    for (number, shaft) in (1..).zip(shafts) {
        shaft.check_dimensions(number)?;
        shaft.check_held(number, motion)?;
    }
    Ok(())
}

impl Bearing {
    /// Stiffness of each freedom, in the order of [`Freedom`].
    fn stiffness(&self) -> [f64; 6] {
        [self.x, self.y, self.axial, self.tilt, self.tilt, 0.0]
    }
}

impl Shaft {
    fn check_dimensions(&self, number: usize) -> Result<(), ShaftError> {
        positive("bearing span [m]", self.span)?;
        non_negative("overhang [m]", self.overhang)?;
        non_negative("drag [N m s/rad]", self.drag.viscous)?;
        non_negative("drag torque [N m]", self.drag.constant)?;
        if !(self.gear_position > 0.0 && self.gear_position < 1.0) {
            return Err(ShaftError::GearPosition {
                shaft: number,
                position: self.gear_position,
            });
        }
        Ok(())
    }

    /// Checks that the bearings hold all free motions. `number` is 1 or 2.
    fn check_held(&self, number: usize, motion: Motion) -> Result<(), ShaftError> {
        let supports =
            |pick: fn(&Bearing) -> f64| self.bearings.iter().filter(|b| pick(b) > 0.0).count();
        // In a plane two springs hold a shaft, or one spring and a tilt spring.
        let upright = motion == Motion::Translation || supports(|b| b.tilt) > 0;
        let is_supported = |count: usize| count == 2 || (count == 1 && upright);
        let needed = match motion {
            Motion::Rotation | Motion::None => return Ok(()),
            Motion::Translation => 2,
            Motion::All | Motion::Lateral => 3,
        };
        let directions = [
            ("along the line of centres", is_supported(supports(|b| b.x))),
            (
                "across the line of centres",
                is_supported(supports(|b| b.y)),
            ),
            ("axially", supports(|b| b.axial) > 0),
        ];
        match directions[..needed]
            .iter()
            .find(|(_, is_supported)| !is_supported)
        {
            Some(&(direction, _)) => Err(ShaftError::NotHeld {
                shaft: number,
                direction,
            }),
            None => Ok(()),
        }
    }
}
