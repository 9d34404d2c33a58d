//! Planets on pins of a carrier, between central gears on its axis.
//!
//! A carrier turns, and with it the places where gears mesh. The train is written in the frame that
//! turns with the carrier at its mean speed: planets keep their places there, and the directions of
//! all meshes are constant. What stands still has to feel the same in all directions for that. The gears
//! roll as if the carrier stood still ([`Layout::rolling`]); the speeds follow from the one member that
//! is held.
//!
//! The neutral rotation is that of the whole set at its mean speeds, the carrier taking its planets along:
//! a planet at r moves by `Ω_c e_z × r` and turns at its own speed.

use super::axes::Axis;
use super::contacts::Terms;
use super::nodes::Assembled;
use super::speeds::{Layout, sense};
use super::{GearPlace, TrainDrive, TrainError, TrainShaft};
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
    /// That everything is central and the planets fit.
    pub(super) fn check_planets(
        &self,
        set: &PlanetarySet,
        axes: &[Axis],
    ) -> Result<(), TrainError> {
        self.all_is_central(set, axes)?;
        self.bearings_are_round(set)?;
        self.planets_fit(set, axes)?;
        self.planets_assemble(set, axes)
    }

    /// That all shafts lie on the axis of the carrier, planets beside it, and that every mesh has a planet.
    fn all_is_central(&self, set: &PlanetarySet, axes: &[Axis]) -> Result<(), TrainError> {
        let carrier = axes[set.carrier];
        let is_planet = |shaft: usize| set.planets.iter().any(|planet| planet.shaft == shaft);
        let refuse = |what: &str| TrainError::OffCentre {
            what: what.to_owned(),
            carrier: self.shafts[set.carrier].name.clone(),
        };
        let radius = (set.planets.first()).map_or(0.0, |planet| arm(axes, set, planet.shaft).1);
        for (shaft, own) in self.shafts.iter().enumerate() {
            let along = (axes[shaft].along() - carrier.along()).norm() < CENTRAL;
            let central = is_planet(shaft) || arm(axes, set, shaft).1 <= CENTRAL * radius;
            if !(along && central) {
                return Err(refuse(&own.name));
            }
        }
        let planet_less = |gears: &[GearPlace; 2]| !gears.iter().any(|gear| is_planet(gear.shaft));
        match self.pairs().find(planet_less) {
            Some([one, _]) => Err(refuse(&self.gear(one).name)),
            None => Ok(()),
        }
    }

    /// That bearings against the ground are the same in all directions, where they are seen to turn. Those of rolling
    /// elements are stiffer along their load.
    fn bearings_are_round(&self, set: &PlanetarySet) -> Result<(), TrainError> {
        for shaft in &self.shafts {
            for (number, (_, own)) in (1..).zip(&shaft.bearings) {
                let plain =
                    own.damping == [[0.0; 2]; 2] && own.cross == [0.0; 2] && own.rolling.is_none();
                if own.x != own.y || !plain {
                    return Err(TrainError::UnequalBearing {
                        shaft: shaft.name.clone(),
                        bearing: number,
                        carrier: self.shafts[set.carrier].name.clone(),
                    });
                }
            }
        }
        Ok(())
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
        let mut teeth = [None; 2];
        for gears in self.pairs() {
            for gear in gears {
                if !set.planets.iter().any(|planet| planet.shaft == gear.shaft) {
                    let own = self.gear(gear);
                    teeth[usize::from(own.internal)] = Some(own.teeth);
                }
            }
        }
        let [Some(external), Some(internal)] = teeth else {
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
        assembled.assembly.in_turning_frame(layout.carrier);
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
