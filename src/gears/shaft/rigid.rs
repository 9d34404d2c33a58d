//! The rigid-body tiers: the drive of [`FlexibleDrive`](super::FlexibleDrive) with shafts that
//! neither bend nor twist.
//!
//! Each shaft with its gear is one rigid body, described by the motion of the gear's centre. Gear body, shaft, end
//! inertia and bearings keep their positions on the shaft. The matrices are those of the flexible drive, reduced to
//! rigid motions of the shafts. A tier determines which of these motions are free.

use super::disc::Disc;
use super::drive::{self, Motion, Pedestal, Shaft};
use super::error::ShaftError;
use super::train::{TrainDrive, TrainShaft};
use super::two_shafts::TwoShafts;
use crate::gear::GearPair;
use crate::structure::ModalStructure;
use strum::IntoStaticStr;

/// Free motions of a rigid-body model. All others are fixed to the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, serde::Serialize)]
#[strum(serialize_all = "snake_case")]
pub enum Tier {
    /// The rotations of both bodies: 2 degrees of freedom. Mounts are rigid.
    Torsional,
    /// The rotations, x and y of both bodies: 6.
    Translational,
    /// All motions of both bodies: 12.
    Tilting,
    /// All motions of both bodies, and x and y of the four pedestals: 20.
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

    fn motion(self) -> Motion {
        match self {
            Self::Torsional => Motion::Rotation,
            Self::Translational => Motion::Translation,
            Self::Tilting | Self::Pedestal => Motion::All,
        }
    }
}

/// Two parallel rigid shafts; the structure of the model kinds `torsional`, `translational`,
/// `tilting` and `pedestal`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RigidDrive {
    /// The free motions.
    pub tier: Tier,
    /// The gear pair.
    pub gears: GearPair,
    /// Pinion shaft, wheel shaft. Stiffness against a fixed motion has no effect.
    pub shafts: [Shaft; 2],
    /// Pedestals of the bearings, `[pinion, wheel]` by `[first, second]`: needed by
    /// [`Tier::Pedestal`], without effect in other tiers.
    pub pedestals: Option<[[Pedestal; 2]; 2]>,
    /// Density of shafts and gear bodies \[kg/m³\].
    pub density: f64,
    /// Global modal damping ratio of the elastic modes \[1\]; rigid modes are undamped.
    pub damping: f64,
    /// `(mode, ratio)` overrides, modes counted from 1 in ascending frequency.
    pub damping_overrides: Vec<(usize, f64)>,
    /// Whether shafts and gear bodies have gyroscopic moments; they act only in tiers that tilt.
    pub gyroscopic: bool,
}

impl RigidDrive {
    /// The `retained` lowest of the `modes` lowest modes of the drive, at most the tier's
    /// degrees of freedom; as [`FlexibleDrive::modes`](super::FlexibleDrive::modes). Bearings
    /// that the tier cannot load have no gain.
    ///
    /// # Errors
    /// As [`FlexibleDrive::modes`](super::FlexibleDrive::modes); [`ShaftError::NoPedestals`].
    pub fn modes(
        &self,
        modes: usize,
        retained: usize,
        mta: bool,
    ) -> Result<ModalStructure, ShaftError> {
        drive::check(&self.gears, &self.shafts, self.density, self.tier.motion())?;
        self.train()?.modes(modes, retained, mta)
    }

    /// The drive as a train, with the middles of its gear bodies in one plane.
    fn train(&self) -> Result<TrainDrive, ShaftError> {
        let pair = TwoShafts {
            gears: &self.gears,
            shafts: &self.shafts,
            density: self.density,
            damping: self.damping,
            damping_overrides: &self.damping_overrides,
            gyroscopic: self.gyroscopic,
        };
        Ok(pair.train([self.shaft(&pair, 0)?, self.shaft(&pair, 1)?]))
    }

    /// One shaft, with positions counted from its gear.
    fn shaft(&self, pair: &TwoShafts, index: usize) -> Result<TrainShaft, ShaftError> {
        let drawn = &self.shafts[index];
        let first_bearing = -drawn.gear_position * drawn.span;
        let mut shaft = pair.shaft(index, first_bearing, pair.body(index)?.whole)?;
        let length = drawn.span + drawn.overhang;
        let rod = Disc::annulus(drawn.diameter, drawn.inner_diameter, length, self.density)?;
        let middle = first_bearing + 0.5 * (drawn.span - drawn.overhang);
        shaft.discs.push((middle, rod));
        shaft.motion = self.tier.motion();
        if self.tier == Tier::Pedestal {
            let pedestals = self.pedestals.ok_or(ShaftError::NoPedestals)?;
            for ((_, bearing), pedestal) in shaft.bearings.iter_mut().zip(pedestals[index]) {
                bearing.pedestal = Some(pedestal);
            }
        }
        Ok(shaft)
    }
}
