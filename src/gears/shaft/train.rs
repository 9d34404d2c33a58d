//! Trains: shafts on separate axes, with any number of gears, discs and bearings on each,
//! joined by meshes, couplings and the springs of clutches.
//!
//! Every shaft has freedoms in a separate frame, with z along its axis. A *body* rotates as one:
//! a shaft, or a gear that runs loose on it. Without contact every body rotates independently.
//! The numbers of teeth determine the speed of each body if all contacts carry load ([`speeds`]). With
//! these speeds the *neutral* rotation of the whole train causes no deflection in any contact.

mod axes;
mod balance;
mod bearings;
mod contacts;
mod equations;
mod error;
mod frames;
mod housing;
mod kinematics;
mod loads;
mod mesh;
mod names;
mod nodes;
mod outputs;
mod planetary;
mod ratio;
mod size;
mod solved;
mod speeds;
mod structure;
#[cfg(test)]
mod tests;

pub use axes::ParallelPlacement;
pub use bearings::LoadedBearing;
pub use error::TrainError;
pub use housing::{Housing, HousingError, HousingJoint, HousingNode, HousingPoint, JoinedHousing};
pub use loads::mean_forces;
pub use mesh::{DrawnLaw, MeshLaw, TrainMesh};
pub use planetary::{Planet, PlanetarySet, phase_of_planet};

use super::disc::Disc;
use super::drive::{Bearing, Drag, Motion};
use super::error::ShaftError;
use crate::gear::{GearPair, Hub};
use crate::structure::ContactLaw;
use serde::Serialize;
use strum::EnumString;

/// A train of gears; the structure of the `train` model kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrainDrive {
    /// All shafts.
    pub shafts: Vec<TrainShaft>,
    /// The gears of the first mesh, whose cycles are the unit of time.
    pub gears: [GearPlace; 2],
    /// Drawing of these gears, at the centre distance of their axes.
    pub pair: GearPair,
    /// Further meshes.
    pub meshes: Vec<TrainMesh>,
    /// Couplings of shafts.
    pub couplings: Vec<ShaftCoupling>,
    /// Stops of shafts.
    pub stops: Vec<Stop>,
    /// Planets on pins of carriers, set by set.
    pub planetary: Vec<PlanetarySet>,
    /// The housing under the bearings; `None` if all bearings are on the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub housing: Option<JoinedHousing>,
    /// The shaft that the motor drives.
    pub driver: usize,
    /// Young's modulus \[Pa\].
    pub young_modulus: f64,
    /// Shear modulus \[Pa\].
    pub shear_modulus: f64,
    /// Density of shafts and gear bodies \[kg/m³\].
    pub density: f64,
    /// Timoshenko shear coefficient κ \[1\].
    pub shear_coefficient: f64,
    /// Global modal damping ratio of the elastic modes \[1\]; rigid modes are undamped.
    pub damping: f64,
    /// `(mode, ratio)` overrides, modes counted from 1 in ascending frequency.
    pub damping_overrides: Vec<(usize, f64)>,
    /// Whether shafts and gear bodies have gyroscopic moments.
    pub gyroscopic: bool,
    /// Load at which the stiffness of rolling bearings is computed, as a fraction of the rated load; `None` without
    /// such bearings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing_load: Option<f64>,
}

/// One shaft and the parts on it. Positions are distances \[m\] from its origin along its axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrainShaft {
    /// Its name.
    pub name: String,
    /// Start of its first section \[m\].
    pub origin: [f64; 3],
    /// Vector of any length along its axis.
    pub direction: [f64; 3],
    /// Its sections in a row; empty for a rigid body.
    pub sections: Vec<ShaftSection>,
    /// Largest length of a beam element \[m\] in sections that state none; `None`: the section's outer diameter.
    pub element: Option<f64>,
    /// Its free motions.
    pub motion: Motion,
    /// Rigid bodies on the shaft, with their positions. A body with only polar inertia does not tilt with the shaft.
    pub discs: Vec<(f64, Disc)>,
    /// Gears on it.
    pub gears: Vec<TrainGear>,
    /// Bearings, with their positions.
    pub bearings: Vec<(f64, Bearing)>,
    /// Position at which torques and drag act on it.
    pub torque_at: f64,
    /// Part of the motor's power that leaves the train at this shaft.
    pub output: f64,
    /// Its brakes against the ground.
    pub drag: Drag,
}

/// A prismatic part of a shaft.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShaftSection {
    /// Length \[m\].
    pub length: f64,
    /// Outer diameter \[m\].
    pub outer: f64,
    /// Inner diameter \[m\].
    pub inner: f64,
    /// Largest length of a beam element \[m\]; `None`: that of the shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<f64>,
}

/// A gear with a rigid body. If the manifest states no body, it is an annulus from the bore to the pitch
/// circle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrainGear {
    /// Its name.
    pub name: String,
    /// The middle of its face \[m\].
    pub at: f64,
    /// Number of teeth.
    pub teeth: u32,
    /// Whether the teeth point towards the axis, as those of a ring.
    pub internal: bool,
    /// Module in the normal section \[m\].
    pub module: f64,
    /// Pressure angle in the normal section \[rad\].
    pub pressure_angle: f64,
    /// Helix angle at the reference cylinder \[rad\], positive if right-handed.
    pub helix_angle: f64,
    /// Face width \[m\].
    pub width: f64,
    /// Its body, without the hub.
    pub body: Disc,
    /// The part of its body that thickens the shaft; `None` for a loose gear.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hub: Option<Hub>,
    /// Bearing of the gear on its shaft; `None` if the gear is fixed to the shaft.
    pub loose: Option<LooseGear>,
}

/// How a gear runs loose on its shaft.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LooseGear {
    /// Its bearing on the shaft.
    pub bearing: Bearing,
    /// Its brakes against its shaft.
    pub drag: Drag,
}

/// A gear, identified by its shaft and its index among the shaft's gears.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct GearPlace {
    /// The shaft.
    pub shaft: usize,
    /// Index among its gears.
    pub gear: usize,
}

/// Springs and dampers between positions of two shafts on one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShaftCoupling {
    /// Both shafts.
    pub shafts: [usize; 2],
    /// Positions at which it is fixed to them \[m\].
    pub at: [f64; 2],
    /// Stiffness across the axis and along the axis \[N/m\], against tilts and against twist \[N m/rad\].
    pub stiffness: [f64; 4],
    /// Damper against twist \[N m s/rad\].
    pub damping: f64,
    /// Further springs against twist behind gaps.
    pub stages: Vec<Stage>,
    /// Dry hysteresis against twist: springs in series with dry sliders.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hysteresis: Vec<Hysteresis>,
}

/// A spring against twist in series with a dry slider.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hysteresis {
    /// Stiffness of the spring \[N m/rad\].
    pub stiffness: f64,
    /// Torque at which the slider slips \[N m\].
    pub limit: f64,
}

/// A spring of a coupling that acts once its gap is closed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stage {
    /// Its force law; radians replace the metres of contacts.
    pub law: ContactLaw,
    /// Direction in which the stage acts.
    #[serde(skip_serializing_if = "StageSide::is_both")]
    pub side: StageSide,
}

/// Direction of its coupling's twist in which a stage acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum StageSide {
    /// In both directions, in each of them once the gap is closed.
    #[default]
    Both,
    /// If the first shaft is ahead of the second.
    Forward,
    /// If the first shaft is behind the second.
    Backward,
}

impl StageSide {
    fn is_both(&self) -> bool {
        *self == Self::Both
    }

    /// The sign of the twist at each of its contacts, and the name of that side.
    pub(super) fn ways(self) -> &'static [(f64, &'static str)] {
        const WAYS: [(f64, &str); 2] = [(1.0, "forward"), (-1.0, "backward")];
        match self {
            Self::Both => &WAYS,
            Self::Forward => &WAYS[..1],
            Self::Backward => &WAYS[1..],
        }
    }
}

impl Stage {
    /// Number of its contacts.
    pub fn contacts(&self) -> usize {
        self.side.ways().len()
    }
}

/// A one-sided spring between a position of a shaft and the ground.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stop {
    /// The shaft.
    pub shaft: usize,
    /// Position on the shaft \[m\].
    pub at: f64,
    /// Direction in the shaft's frame, from the shaft to the stop: x, y, along the axis.
    pub direction: [f64; 3],
    /// Its force law.
    pub law: ContactLaw,
}

impl TrainDrive {
    /// The gear at a place.
    pub fn gear(&self, place: GearPlace) -> &TrainGear {
        &self.shafts[place.shaft].gears[place.gear]
    }

    /// All bearings: of shafts, loose gears and planets.
    pub fn bearings(&self) -> impl Iterator<Item = &Bearing> {
        let of_shafts = self.shafts.iter().flat_map(|shaft| &shaft.bearings);
        let gears = self.shafts.iter().flat_map(|shaft| &shaft.gears);
        let of_gears = gears.filter_map(|gear| Some(&gear.loose.as_ref()?.bearing));
        let of_planets = self.planetary.iter().map(|set| &set.bearing);
        (of_shafts.map(|(_, bearing)| bearing))
            .chain(of_gears)
            .chain(of_planets)
    }

    /// The pair with bores. A bore missing from the drawing is the diameter of the shaft there, if the shaft
    /// has sections.
    pub fn on_shafts(&self, pair: &GearPair, gears: [GearPlace; 2]) -> GearPair {
        let mut pair = pair.clone();
        for (bore, place) in pair.form.bore.iter_mut().zip(gears) {
            let section = ShaftSection::at(&self.shafts[place.shaft].sections, self.gear(place).at);
            *bore = bore.or(section.map(|section| section.outer));
        }
        pair
    }
}

impl TrainDrive {
    /// Checks that shafts, gears and couplings form a train whose matrices are not too large.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn check(&self) -> Result<(), TrainError> {
        self.layout()?;
        self.check_size()
    }

    /// Degrees of freedom.
    ///
    /// # Errors
    /// All of [`ShaftError`] except those of modes.
    pub fn freedoms(&self) -> Result<usize, ShaftError> {
        let assembled = self.assembled(&self.layout()?)?;
        Ok(assembled.assembly.free_freedoms())
    }

    /// The drawing of the first mesh on its shafts; `None` for bevel gears, or if the gears cannot mesh there.
    pub fn parallel_pair(&self) -> Option<GearPair> {
        let parallel = self.parallel_placement(self.gears).ok()?;
        parallel.map(|_| self.on_shafts(&self.pair, self.gears))
    }

    /// Number of dry sliders.
    pub fn sliders(&self) -> usize {
        let couplings = self.couplings.iter();
        couplings.map(|coupling| coupling.hysteresis.len()).sum()
    }

    /// Number of rotations that no spring holds.
    pub fn rotations(&self) -> usize {
        let rigid = self.couplings.iter().filter(|c| c.stiffness[3] > 0.0);
        self.free(&self.groups(rigid.map(|coupling| coupling.shafts)))
            .len()
    }

    /// Number of rotations that deflect no contact.
    pub fn neutral_rotations(&self) -> usize {
        self.free_of_contacts(&self.connected()).len()
    }

    /// The drags on shafts and loose gears.
    pub fn drags(&self) -> impl Iterator<Item = Drag> {
        let loose = self.loose_gears();
        let loose = loose.filter_map(|place| Some(self.gear(place).loose?.drag));
        self.shafts.iter().map(|shaft| shaft.drag).chain(loose)
    }

    /// Number of rotations without contact deflection that drag damps, against the ground or between a loose gear and
    /// its shaft.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn dragged_rotations(&self) -> Result<usize, TrainError> {
        let speeds = self.layout()?.speeds;
        let group = self.connected();
        let mut dragged = Vec::new();
        for (shaft, train_shaft) in self.shafts.iter().enumerate() {
            if train_shaft.drag.viscous > 0.0 {
                dragged.push(group[shaft]);
            }
        }
        for place in self.loose_gears() {
            let brakes = (self.gear(place).loose).is_some_and(|loose| loose.drag.viscous > 0.0);
            let (body, on) = (self.body_of(place), place.shaft);
            if brakes && (group[body] != group[on] || speeds[body] != speeds[on]) {
                dragged.push(group[body]);
            }
        }
        let free = self.free_of_contacts(&group);
        Ok(free
            .iter()
            .filter(|rotation| dragged.contains(rotation))
            .count())
    }

    /// The group of every body: bodies connected by meshes, couplings or pins share one.
    fn connected(&self) -> Vec<usize> {
        let joined = self.couplings.iter().map(|coupling| coupling.shafts);
        let meshing = self
            .pairs()
            .map(|gears| gears.map(|gear| self.body_of(gear)));
        let pins = self.planetary.iter().flat_map(PlanetarySet::pins);
        self.groups(joined.chain(meshing).chain(pins))
    }

    /// The group of every body: bodies connected by `joints` share one.
    fn groups(&self, joints: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
        let bodies = self.shafts.len() + self.loose_gears().count();
        let mut group: Vec<usize> = (0..bodies).collect();
        for joint in joints {
            let [one, two] = joint.map(|body| group[body]);
            for number in group.iter_mut().filter(|number| **number == two) {
                *number = one;
            }
        }
        group
    }

    /// The groups that may rotate without deflecting a contact. The group of a carrier may rotate even if a
    /// member of its set is held, because planets roll on held gears.
    fn free_of_contacts(&self, group: &[usize]) -> Vec<usize> {
        let mut free = self.free(group);
        for rolling in self.planetary.iter().map(|set| group[set.carrier]) {
            if !free.contains(&rolling) {
                free.push(rolling);
            }
        }
        free
    }

    /// The groups that may rotate.
    fn free(&self, group: &[usize]) -> Vec<usize> {
        let mut free = group.to_vec();
        free.sort_unstable();
        free.dedup();
        let shafts = self.shafts.iter().enumerate();
        let fixed_groups = shafts.filter(|(_, shaft)| !shaft.motion.may_rotate());
        let fixed_groups: Vec<usize> = fixed_groups.map(|(shaft, _)| group[shaft]).collect();
        free.retain(|group| !fixed_groups.contains(group));
        free
    }
}

impl TrainGear {
    /// Reference radius `m_t z / 2` \[m\].
    pub fn pitch_radius(&self) -> f64 {
        0.5 * self.module * f64::from(self.teeth) / self.helix_angle.cos()
    }

    /// Helix angle at the base cylinder \[rad\].
    fn base_helix_angle(&self) -> f64 {
        (self.helix_angle.sin() * self.pressure_angle.cos()).asin()
    }
}

impl TrainShaft {
    /// Length of all sections \[m\].
    pub fn length(&self) -> f64 {
        self.sections.iter().map(|section| section.length).sum()
    }

    /// Outer diameter at a position of a section, hubs included \[m\].
    fn outer_at(&self, section: &ShaftSection, at: f64) -> f64 {
        let hubs = self.gears.iter().filter_map(|gear| {
            let hub = gear.hub?;
            let [start, end] = hub.ends(gear.at);
            (start < at && at < end).then_some(hub.diameter)
        });
        hubs.fold(section.outer, f64::max)
    }
}

impl ShaftSection {
    /// The section of a shaft at a position, the thicker one where two meet; `None` beyond the ends.
    pub fn at(sections: &[Self], at: f64) -> Option<&Self> {
        let mut end = 0.0;
        let near = 1e-9 * sections.iter().map(|section| section.length).sum::<f64>();
        let here = sections.iter().filter(|section| {
            let start = end;
            end += section.length;
            start - near <= at && at <= end + near
        });
        here.max_by(|a, b| a.outer.total_cmp(&b.outer))
    }
}
