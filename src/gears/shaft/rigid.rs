//! The rigid-body tiers: the drive of [`FlexibleDrive`](super::FlexibleDrive) with shafts that
//! neither bend nor twist.
//!
//! Each shaft with its gear is one rigid body that moves as its gear's centre does. Gear body,
//! shaft and end inertia keep their places on it, and the bearings act where they stand: the
//! matrices are those of the flexible drive, reduced to rigid motions of the shafts. A tier is
//! what is released of them.

use super::assembly::{Assembly, Freedom};
use super::disc::Disc;
use super::drive::{self, Pedestal, Released, Shaft, Support};
use super::error::{ShaftError, positive};
use super::pair::{PairedShafts, ShaftNodes};
use crate::gear::GearPair;
use crate::structure::ModalStructure;
use strum::IntoStaticStr;

/// What a rigid-body model releases. Everything else is fixed to the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, serde::Serialize)]
#[strum(serialize_all = "snake_case")]
pub enum Tier {
    /// The rotations of both bodies: 2 degrees of freedom. Mounts are rigid.
    Torsional,
    /// And x and y of both: 6.
    Translational,
    /// And axial displacement and tilts of both: 12.
    Tilting,
    /// And x and y of the four pedestals: 20.
    Pedestal,
}

impl Tier {
    /// All four, by degrees of freedom.
    pub const ALL: [Self; 4] = [
        Self::Torsional,
        Self::Translational,
        Self::Tilting,
        Self::Pedestal,
    ];

    /// The name of the model kind.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Degrees of freedom.
    pub fn freedoms(self) -> usize {
        match self {
            Self::Torsional => 2,
            Self::Translational => 6,
            Self::Tilting => 12,
            Self::Pedestal => 20,
        }
    }

    fn released(self) -> Released {
        match self {
            Self::Torsional => Released::Rotation,
            Self::Translational => Released::Translation,
            Self::Tilting | Self::Pedestal => Released::All,
        }
    }
}

/// Two parallel rigid shafts; the structure of the model kinds `torsional`, `translational`,
/// `tilting` and `pedestal`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RigidDrive {
    /// What is released.
    pub tier: Tier,
    /// The gear pair.
    pub gears: GearPair,
    /// Pinion shaft, wheel shaft. Stiffness that holds a motion not released is of no effect.
    pub shafts: [Shaft; 2],
    /// What the bearings stand on, `[pinion, wheel]` by `[first, second]`: needed by
    /// [`Tier::Pedestal`], of no effect in other tiers.
    pub pedestals: Option<[[Pedestal; 2]; 2]>,
    /// Density of shafts and gear bodies \[kg/m³\].
    pub density: f64,
    /// Global modal damping ratio of the elastic modes \[1\]; rigid modes are undamped.
    pub damping: f64,
    /// `(mode, ratio)` overrides, modes counted from 1 in ascending frequency.
    pub damping_overrides: Vec<(usize, f64)>,
    /// Whether shafts and gear bodies have gyroscopic moments; felt by tiers that tilt.
    pub gyroscopic: bool,
}

impl RigidDrive {
    /// The `retained` lowest of the `modes` lowest modes of the drive, at most the tier's
    /// degrees of freedom; as [`FlexibleDrive::modes`](super::FlexibleDrive::modes). Bearings
    /// that the tier cannot load have no gain.
    ///
    /// # Errors
    /// As there; [`ShaftError::NoPedestals`].
    pub fn modes(
        &self,
        modes: usize,
        retained: usize,
        mta: bool,
    ) -> Result<ModalStructure, ShaftError> {
        let released = self.tier.released();
        drive::check(&self.gears, &self.shafts, self.density, released)?;
        let mut assembly = Assembly::new();
        let shafts = [
            self.add_shaft(&mut assembly, 0)?,
            self.add_shaft(&mut assembly, 1)?,
        ];
        let paired = PairedShafts {
            gears: &self.gears,
            shafts,
            damping: self.damping,
            damping_overrides: &self.damping_overrides,
            drag: [0, 1].map(|index| self.shafts[index].drag),
        };
        paired.modes(&assembly, modes, retained, mta)
    }

    /// Adds one shaft with bearings, gear body and end inertia.
    fn add_shaft(&self, assembly: &mut Assembly, index: usize) -> Result<ShaftNodes, ShaftError> {
        let shaft = &self.shafts[index];
        let gear = assembly.add_node();
        let held: &[Freedom] = match self.tier.released() {
            Released::Rotation => &Freedom::ALL[..5],
            Released::Translation => &[Freedom::Z, Freedom::RotationX, Freedom::RotationY],
            Released::All => &[],
        };
        for &freedom in held {
            assembly.fix(gear, freedom)?;
        }
        let mut at = |station: f64| {
            assembly.add_carried_node(gear, station - shaft.gear_position * shaft.span)
        };
        let end = at(-shaft.overhang)?;
        let middle = at(0.5 * (shaft.span - shaft.overhang))?;
        let bearings = [at(0.0)?, at(shaft.span)?];

        assembly.turn(drive::turning(&self.gears, index, self.gyroscopic));
        let body = drive::gear_body(&self.gears, &self.shafts, self.density, index)?;
        assembly.add_disc(gear, body.whole)?;
        let length = shaft.span + shaft.overhang;
        let rod = Disc::annulus(shaft.diameter, shaft.inner_diameter, length, self.density)?;
        assembly.add_disc(middle, rod)?;
        assembly.add_polar_inertia(end, shaft.end_inertia)?;
        assembly.add_drag(end, None, shaft.drag.viscous)?;

        let supports = [
            self.add_support(assembly, [index, 0], bearings[0])?,
            self.add_support(assembly, [index, 1], bearings[1])?,
        ];
        Ok(ShaftNodes {
            end,
            gear,
            supports,
        })
    }

    /// Adds a bearing between a node of its shaft and its pedestal. `place` is `[shaft, bearing]`.
    fn add_support(
        &self,
        assembly: &mut Assembly,
        place: [usize; 2],
        node: usize,
    ) -> Result<Support, ShaftError> {
        let stiffness = self.shafts[place[0]].bearings[place[1]];
        let pedestal = self.add_pedestal(assembly, place)?;
        Support::add(assembly, node, Some(pedestal), stiffness)
    }

    /// Adds what a bearing stands on: a pedestal, or the ground.
    fn add_pedestal(
        &self,
        assembly: &mut Assembly,
        place: [usize; 2],
    ) -> Result<usize, ShaftError> {
        let node = assembly.add_node();
        let pedestal = match self.tier {
            Tier::Pedestal => {
                let pedestals = self.pedestals.ok_or(ShaftError::NoPedestals)?;
                Some(pedestals[place[0]][place[1]])
            }
            Tier::Torsional | Tier::Translational | Tier::Tilting => None,
        };
        let held = match pedestal {
            Some(_) => &Freedom::ALL[2..],
            None => &Freedom::ALL[..],
        };
        for &freedom in held {
            assembly.fix(node, freedom)?;
        }
        if let Some(Pedestal { x, y, mass }) = pedestal {
            positive("pedestal stiffness along the line of centres [N/m]", x)?;
            positive("pedestal stiffness across the line of centres [N/m]", y)?;
            positive("pedestal mass [kg]", mass)?;
            assembly.add_spring(node, [x, y, 0.0, 0.0, 0.0, 0.0])?;
            let pedestal_body = Disc {
                mass,
                transverse_inertia: 0.0,
                polar_inertia: 0.0,
            };
            assembly.add_disc(node, pedestal_body)?;
        }
        Ok(node)
    }
}
