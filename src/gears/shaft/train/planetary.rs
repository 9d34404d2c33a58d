//! Planets on pins of a carrier, between central gears on its axis.
//!
//! A carrier turns, and with it the places where gears mesh. The train is written in the frame that
//! turns with the carrier at its mean speed: planets keep their places there, and the directions of
//! all meshes are constant. What stands still has to feel the same in all directions for that, unless the carrier is
//! held. The gears roll as if the carrier stood still ([`Layout::rolling`]); the speeds follow from the one member that
//! is held.
//!
//! In this frame are the members of the set: carrier, planets, the shafts whose gears mesh with these, and what couplings
//! join to them across the axis. Other shafts, whose couplings to members leave them the motions across the axis, keep
//! the frame of space: turning about the axis and moving along it are the same in both.
//!
//! The neutral rotation is that of the whole set at its mean speeds, the carrier taking its planets along:
//! a planet at r moves by `Ω_c e_z × r` and turns at its own speed.

use super::axes::Axis;
use super::contacts::Terms;
use super::nodes::Assembled;
use super::speeds::{Layout, sense};
use super::{GearPlace, Stop, TrainDrive, TrainError, TrainShaft};
use crate::shaft::assembly::Freedom;
use crate::shaft::drive::Bearing;
use crate::shaft::error::ShaftError;
use serde::Serialize;
use std::f64::consts::TAU;

/// Part of a tooth by which an angle may miss a place between the teeth.
const IN_PLACE: f64 = 1e-3;

/// Part of a cycle that is rounding.
const ROUNDING: f64 = 1e-9;

/// Distance of two axes that are one, in units of the distance of the pins.
const CENTRAL: f64 = 1e-9;

/// Planets on pins of a carrier.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanetarySet {
    /// The shaft that has the pins.
    pub carrier: usize,
    /// Their place on it \[m\].
    pub at: f64,
    /// The planets, each a rigid body with one gear.
    pub planets: Vec<Planet>,
    /// The bearing of each on its pin.
    pub bearing: Bearing,
    /// Tip diameter of the planets \[m\].
    pub tip_diameter: f64,
}

/// A planet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Planet {
    /// Its body, among the shafts.
    pub shaft: usize,
    /// How far its pin stands ahead of its place, in the sense in which the carrier turns \[m\].
    pub pin_error: f64,
}

impl PlanetarySet {
    /// Each planet and the carrier.
    pub(super) fn pins(&self) -> impl Iterator<Item = [usize; 2]> {
        self.planets
            .iter()
            .map(|planet| [planet.shaft, self.carrier])
    }
}

impl TrainShaft {
    /// The point beside its axis at a place `at` \[m\] along it, by distance \[m\] and angle \[rad\] in its frame.
    pub fn beside(&self, at: f64, distance: f64, angle: f64) -> [f64; 3] {
        let (sin, cos) = angle.sin_cos();
        let axis = Axis::new(self.origin, self.direction);
        axis.beside(at, [distance * cos, distance * sin]).into()
    }
}

/// Phase of a mesh of a planet against that of the first planet, in cycles from 0 on: a tooth of the central gear comes
/// there later by the angle of the planet, counted in the sense in which this gear rolls.
pub fn phase_of_planet(teeth: u32, sense: f64, angle: f64) -> f64 {
    let turns = -sense * f64::from(teeth) * angle / TAU;
    let phase = turns.rem_euclid(1.0);
    if 1.0 - phase < ROUNDING { 0.0 } else { phase }
}

impl TrainDrive {
    /// Whether a shaft is a planet.
    pub(super) fn is_planet(&self, shaft: usize) -> bool {
        let mut planets = self.planetary.iter().flat_map(|set| &set.planets);
        planets.any(|planet| planet.shaft == shaft)
    }

    /// That the first mesh is one of the planets, where there are any.
    pub(super) fn check_first(&self) -> Result<(), TrainError> {
        if self.planetary.is_none() || self.gears.iter().any(|gear| self.is_planet(gear.shaft)) {
            return Ok(());
        }
        Err(TrainError::FirstOfPlanets {
            gears: self.gears.map(|place| self.gear(place).name.clone()),
        })
    }

    /// Which shafts move with the planets.
    pub(super) fn members(&self) -> Vec<bool> {
        let Some(set) = &self.planetary else {
            return vec![false; self.shafts.len()];
        };
        let across = (self.couplings.iter())
            .filter(|coupling| coupling.stiffness[0] > 0.0 || coupling.stiffness[2] > 0.0)
            .map(|coupling| coupling.shafts);
        let meshing = (self.pairs().map(|gears| gears.map(|gear| gear.shaft)))
            .filter(|shafts| shafts.iter().any(|&shaft| self.is_planet(shaft)));
        let group = self.groups(across.chain(meshing).chain(set.pins()));
        (0..self.shafts.len())
            .map(|shaft| group[shaft] == group[set.carrier])
            .collect()
    }

    /// That the members of the set are central, those that turn with its frame may, and the planets fit.
    pub(super) fn check_planets(
        &self,
        set: &PlanetarySet,
        axes: &[Axis],
        [members, turning]: [&[bool]; 2],
    ) -> Result<(), TrainError> {
        self.members_are_central(set, axes, members)?;
        self.meshes_are_of_planets(turning)?;
        self.supports_are_round(set, turning)?;
        self.planets_fit(set, axes)?;
        self.planets_assemble(set, axes)
    }

    /// That the members of the set lie on the axis of the carrier, planets beside it.
    fn members_are_central(
        &self,
        set: &PlanetarySet,
        axes: &[Axis],
        members: &[bool],
    ) -> Result<(), TrainError> {
        let carrier = axes[set.carrier];
        let radius = (set.planets.first()).map_or(0.0, |planet| arm(axes, set, planet.shaft).1);
        for (shaft, own) in self
            .shafts
            .iter()
            .enumerate()
            .filter(|(shaft, _)| members[*shaft])
        {
            let along = (axes[shaft].along() - carrier.along()).norm() < CENTRAL;
            let central = self.is_planet(shaft) || arm(axes, set, shaft).1 <= CENTRAL * radius;
            if !(along && central) {
                return Err(TrainError::OffCentre {
                    what: own.name.clone(),
                    carrier: self.shafts[set.carrier].name.clone(),
                });
            }
        }
        Ok(())
    }

    /// That meshes without a planet are those of shafts that keep the frame of space.
    fn meshes_are_of_planets(&self, turning: &[bool]) -> Result<(), TrainError> {
        let beside = self
            .pairs()
            .filter(|gears| !gears.iter().any(|gear| self.is_planet(gear.shaft)));
        let mut gears = beside.flatten();
        match gears.find(|gear| turning[gear.shaft]) {
            Some(gear) => Err(TrainError::GearBesidePlanets {
                gear: self.gear(gear).name.clone(),
                shaft: self.shafts[gear.shaft].name.clone(),
            }),
            None => Ok(()),
        }
    }

    /// That bearings and stops against the ground are the same in all directions, where they are seen to turn. Those of
    /// rolling elements are stiffer along their load.
    fn supports_are_round(&self, set: &PlanetarySet, turning: &[bool]) -> Result<(), TrainError> {
        let carrier = || self.shafts[set.carrier].name.clone();
        for shaft in self
            .shafts
            .iter()
            .zip(turning)
            .filter(|(_, turns)| **turns)
            .map(|(own, _)| own)
        {
            let loose = (shaft.gears.iter()).filter_map(|gear| {
                let name = format!("the bearing of the loose gear `{}`", gear.name);
                Some((name, gear.loose?.bearing))
            });
            let bearings = (1..).zip(&shaft.bearings).map(|(number, (_, own))| {
                let name = format!("bearing {number} of shaft `{}`", shaft.name);
                (name, *own)
            });
            for (bearing, own) in bearings.chain(loose) {
                let plain =
                    own.damping == [[0.0; 2]; 2] && own.cross == [0.0; 2] && own.rolling.is_none();
                if own.x != own.y || !plain {
                    return Err(TrainError::UnequalBearing {
                        bearing,
                        carrier: carrier(),
                    });
                }
            }
        }
        let across = |stop: &&Stop| turning[stop.shaft] && stop.direction[..2] != [0.0; 2];
        match self.stops.iter().find(across) {
            Some(stop) => Err(TrainError::StopAcross {
                shaft: self.shafts[stop.shaft].name.clone(),
                carrier: carrier(),
            }),
            None => Ok(()),
        }
    }

    /// That no two planets touch.
    fn planets_fit(&self, set: &PlanetarySet, axes: &[Axis]) -> Result<(), TrainError> {
        let tip = set.tip_diameter;
        for (second, two) in set.planets.iter().enumerate() {
            for (first, one) in set.planets[..second].iter().enumerate() {
                let apart = (axes[one.shaft].at(0.0) - axes[two.shaft].at(0.0)).norm();
                if apart <= tip {
                    return Err(TrainError::PlanetsTouch {
                        planets: [first + 1, second + 1],
                        apart,
                        tip,
                    });
                }
            }
        }
        Ok(())
    }

    /// That every planet finds spaces on the external and on the internal central gear at once.
    fn planets_assemble(&self, set: &PlanetarySet, axes: &[Axis]) -> Result<(), TrainError> {
        let Some([external, internal]) = self.central_teeth(self.pairs()) else {
            return Ok(());
        };
        let together = f64::from(external + internal);
        let first = set
            .planets
            .first()
            .map_or(0.0, |own| arm(axes, set, own.shaft).0);
        for (number, planet) in (1..).zip(&set.planets) {
            let turns = (arm(axes, set, planet.shaft).0 - first).rem_euclid(TAU) / TAU;
            let place = turns * together;
            if (place - place.round()).abs() > IN_PLACE {
                return Err(TrainError::Assembly {
                    planet: number,
                    angle: 360.0 * turns,
                    teeth: [external, internal],
                    nearest: 360.0 * place.round() / together,
                });
            }
        }
        Ok(())
    }

    /// Teeth of the external and of the internal gear that mesh with planets; none unless there are both.
    pub fn central_teeth(&self, pairs: impl Iterator<Item = [GearPlace; 2]>) -> Option<[u32; 2]> {
        let mut teeth = [None; 2];
        for gears in pairs.filter(|gears| gears.iter().any(|gear| self.is_planet(gear.shaft))) {
            for gear in gears.into_iter().filter(|gear| !self.is_planet(gear.shaft)) {
                let own = self.gear(gear);
                teeth[usize::from(own.internal)] = Some(own.teeth);
            }
        }
        Some([teeth[0]?, teeth[1]?])
    }

    /// How planets move as the carrier takes them along at its mean speed.
    pub(super) fn orbits(&self, layout: &Layout, assembled: &Assembled) -> Terms {
        let planets = self.planetary.iter().flat_map(|set| {
            let planets = set.planets.iter();
            planets.map(|planet| (planet.shaft, arm_vector(&layout.axes, set, planet.shaft)))
        });
        planets
            .flat_map(|(shaft, [x, y])| {
                let node = assembled.at(shaft, 0.0);
                [
                    (node, Freedom::X, -layout.carrier * y),
                    (node, Freedom::Y, layout.carrier * x),
                ]
            })
            .collect()
    }

    /// Mass of a planet \[kg\].
    fn planet_mass(&self, planet: &Planet) -> f64 {
        let gears = self.shafts[planet.shaft].gears.iter();
        gears.map(|gear| gear.body.mass).sum()
    }

    /// Writes an assembly in the frame of the carrier, where anything is to feel that it turns.
    pub(super) fn turn_with_carrier(
        &self,
        assembled: &mut Assembled,
        layout: &Layout,
    ) -> Result<(), ShaftError> {
        let Some(set) = self
            .planetary
            .as_ref()
            .filter(|_| self.feels_the_frame(layout))
        else {
            return Ok(());
        };
        let mut turns = assembled.nodes_of(&layout.turning);
        let loose = self.loose_gears().zip(&assembled.loose);
        turns.extend(
            loose
                .filter(|(gear, _)| layout.turning[gear.shaft])
                .map(|(_, node)| node),
        );
        (assembled.assembly).in_turning_frame(layout.carrier, |node| turns.contains(&node));
        for (number, planet) in set.planets.iter().enumerate() {
            let nodes = [assembled.at(planet.shaft, 0.0), assembled.pins[number]];
            let arm = arm_vector(&layout.axes, set, planet.shaft);
            let mass = self.planet_mass(planet);
            let assembly = &mut assembled.assembly;
            assembly.add_mass_on_pin(nodes, mass, arm, layout.carrier)?;
        }
        Ok(())
    }

    fn feels_the_frame(&self, layout: &Layout) -> bool {
        self.gyroscopic && layout.carrier != 0.0
    }

    /// Centrifugal forces on the planets, per square of the pinion's speed.
    pub(super) fn centrifugal_forces(&self, layout: &Layout, assembled: &Assembled) -> Terms {
        let turns = self.feels_the_frame(layout);
        let sets = self.planetary.iter().filter(|_| turns);
        let planets = sets.flat_map(|set| set.planets.iter().map(move |planet| (set, planet)));
        planets
            .flat_map(|(set, planet)| {
                let [x, y] = arm_vector(&layout.axes, set, planet.shaft);
                let pull = self.planet_mass(planet) * layout.carrier.powi(2);
                let node = assembled.at(planet.shaft, 0.0);
                [(node, Freedom::X, pull * x), (node, Freedom::Y, pull * y)]
            })
            .collect()
    }

    /// How far the pin of a planet stands out of its place, in x and y \[m\].
    pub(super) fn pin_place(&self, number: usize, layout: &Layout) -> [f64; 2] {
        let Some(set) = &self.planetary else {
            return [0.0; 2];
        };
        let planet = &set.planets[number];
        let [x, y] = arm_vector(&layout.axes, set, planet.shaft);
        let ahead = sense(layout.carrier) * planet.pin_error / x.hypot(y);
        [-ahead * y, ahead * x]
    }

    /// Forces of the bearings of planets whose pins stand out of place, on planets and carrier.
    pub(super) fn pin_forces(&self, layout: &Layout, assembled: &Assembled) -> Terms {
        let mut forces = Terms::new();
        let Some(set) = &self.planetary else {
            return forces;
        };
        let bearings = assembled.supports.len() - set.planets.len();
        for (number, (_, support)) in assembled.supports[bearings..].iter().enumerate() {
            let place = self.pin_place(number, layout);
            for (freedom, moved) in [Freedom::X, Freedom::Y].into_iter().zip(place) {
                // Rolling contacts are symmetric, and bearings of planets have no cross-coupled springs.
                for (along, stiffness) in support.row(freedom) {
                    forces.push((support.node, along, stiffness * moved));
                    forces.extend(support.base.map(|pin| (pin, along, -stiffness * moved)));
                }
            }
        }
        forces.retain(|(_, _, force)| *force != 0.0);
        forces
    }
}

/// From the axis of the carrier to the one of a shaft, in the carrier's frame \[m\].
fn arm_vector(axes: &[Axis], set: &PlanetarySet, shaft: usize) -> [f64; 2] {
    let carrier = axes[set.carrier];
    let [x, y, _] = carrier.local(axes[shaft].at(0.0) - carrier.at(0.0));
    [x, y]
}

/// The same as angle \[rad\] and distance \[m\].
fn arm(axes: &[Axis], set: &PlanetarySet, shaft: usize) -> (f64, f64) {
    let [x, y] = arm_vector(axes, set, shaft);
    (y.atan2(x), x.hypot(y))
}
