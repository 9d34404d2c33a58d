//! Planets on pins of a carrier, between central gears on its axis.
//!
//! A carrier rotates, and with it the positions of the meshes. The equations are in the frame that
//! rotates with the carrier at its mean speed: planets keep their positions there, and the directions of
//! all meshes are constant. Supports on the ground must therefore be isotropic, unless the carrier is
//! held. The gears roll as if the carrier did not rotate ([`Layout::mesh_speeds`]). The speeds follow from the held
//! members ([`super::equations`]).
//!
//! Sets share a frame only if their carriers have equal speeds ([`super::frames`]).
//!
//! The neutral rotation is that of the whole set at its mean speeds, and the carrier takes its planets along:
//! a planet at r moves by `Ω_c e_z × r` and rotates at its speed.

use super::axes::Axis;
use super::contacts::Terms;
use super::frames::{arm, arm_vector};
use super::nodes::Assembled;
use super::speeds::{Layout, sense};
use super::{GearPlace, TrainDrive, TrainError, TrainShaft};
use crate::shaft::assembly::Freedom;
use crate::shaft::drive::Bearing;
use crate::shaft::error::ShaftError;
use serde::Serialize;
use std::f64::consts::TAU;

/// Part of a tooth by which an angle may deviate from a position between the teeth.
const IN_PLACE: f64 = 1e-3;

/// Part of a cycle within rounding.
const ROUNDING: f64 = 1e-9;

/// Planets on pins of a carrier.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanetarySet {
    /// The shaft with the pins.
    pub carrier: usize,
    /// Position of the pins on it \[m\].
    pub at: f64,
    /// The planets, each a rigid body with one gear.
    pub planets: Vec<Planet>,
    /// The bearing of each planet on its pin.
    pub bearing: Bearing,
    /// Tip diameter of the planets \[m\].
    pub tip_diameter: f64,
}

/// A planet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Planet {
    /// Index of its body among the shafts.
    pub shaft: usize,
    /// Displacement of its pin from the nominal position, in the direction of the carrier's rotation \[m\].
    pub pin_error: f64,
}

impl PlanetarySet {
    /// Pairs of shafts that the pins connect: each planet and the carrier.
    pub(super) fn pins(&self) -> impl Iterator<Item = [usize; 2]> {
        self.planets
            .iter()
            .map(|planet| [planet.shaft, self.carrier])
    }
}

impl TrainShaft {
    /// The point at a position `at` \[m\] on its axis, displaced by a distance \[m\] at an angle \[rad\] in its frame.
    pub fn point_at_distance(&self, at: f64, distance: f64, angle: f64) -> [f64; 3] {
        let (sin, cos) = angle.sin_cos();
        let axis = Axis::new(self.origin, self.direction);
        axis.offset_point(at, [distance * cos, distance * sin])
            .into()
    }
}

/// Phase of a planet's mesh relative to that of the first planet, in cycles in \[0, 1). `angle` is the angle from the
/// first planet to this one. If the central gear rolls in this direction, its teeth reach this planet later.
pub fn phase_of_planet(teeth: u32, sense: f64, angle: f64) -> f64 {
    let turns = -sense * f64::from(teeth) * angle / TAU;
    let phase = turns.rem_euclid(1.0);
    if 1.0 - phase < ROUNDING { 0.0 } else { phase }
}

impl TrainDrive {
    /// All planets, set by set, with the numbers of their sets.
    pub(super) fn planets(&self) -> impl Iterator<Item = (usize, &PlanetarySet, &Planet)> {
        let sets = self.planetary.iter().enumerate();
        sets.flat_map(|(number, set)| set.planets.iter().map(move |planet| (number, set, planet)))
    }

    /// The set that contains a shaft as a planet; `None` for other shafts.
    pub(super) fn set_of_planet(&self, shaft: usize) -> Option<usize> {
        let mut planets = self.planets();
        planets
            .find(|(_, _, planet)| planet.shaft == shaft)
            .map(|(set, _, _)| set)
    }

    /// Whether a shaft is a planet.
    pub(super) fn is_planet(&self, shaft: usize) -> bool {
        self.set_of_planet(shaft).is_some()
    }

    /// The set of the planet among two gears in mesh; `None` if neither is a planet.
    pub(super) fn set_of_mesh(&self, gears: [GearPlace; 2]) -> Option<usize> {
        let [one, two] = gears.map(|gear| self.set_of_planet(gear.shaft));
        one.or(two)
    }

    /// Checks that no carrier is a planet, and no mesh joins planets of two sets: their relative position would be
    /// undefined.
    pub(super) fn check_set_separation(&self) -> Result<(), TrainError> {
        let mut carriers = self.planetary.iter().map(|set| set.carrier);
        if let Some(carrier) = carriers.find(|&shaft| self.is_planet(shaft)) {
            return Err(TrainError::CarrierIsPlanet {
                planet: self.shafts[carrier].name.clone(),
            });
        }
        let both = |gears: &[GearPlace; 2]| gears.iter().all(|gear| self.is_planet(gear.shaft));
        self.pairs().find(both).map_or(Ok(()), |gears| {
            Err(TrainError::PlanetsMesh {
                gears: gears.map(|place| self.gear(place).name.clone()),
            })
        })
    }

    /// Checks that the first mesh has a planet, if the train has planets.
    pub(super) fn check_first(&self) -> Result<(), TrainError> {
        if self.planetary.is_empty() || self.gears.iter().any(|gear| self.is_planet(gear.shaft)) {
            return Ok(());
        }
        Err(TrainError::FirstOfPlanets {
            gears: self.gears.map(|place| self.gear(place).name.clone()),
        })
    }

    /// Checks that the members of a set are central, and that its planets fit.
    pub(super) fn check_planets(
        &self,
        number: usize,
        axes: &[Axis],
        frames: &[Option<usize>],
    ) -> Result<(), TrainError> {
        let set = &self.planetary[number];
        self.members_are_central(set, axes, frames)?;
        self.planets_fit(set, axes)?;
        self.planets_assemble(number, axes)
    }

    /// Checks that no two planets touch.
    fn planets_fit(&self, set: &PlanetarySet, axes: &[Axis]) -> Result<(), TrainError> {
        let tip = set.tip_diameter;
        for (second, two) in set.planets.iter().enumerate() {
            for one in &set.planets[..second] {
                let apart = (axes[one.shaft].at(0.0) - axes[two.shaft].at(0.0)).norm();
                if apart <= tip {
                    return Err(TrainError::PlanetsTouch {
                        planets: [one, two].map(|planet| self.shafts[planet.shaft].name.clone()),
                        apart,
                        tip,
                    });
                }
            }
        }
        Ok(())
    }

    /// Checks that every planet fits between the teeth of the external and of the internal central gear at
    /// the same time.
    fn planets_assemble(&self, number: usize, axes: &[Axis]) -> Result<(), TrainError> {
        let set = &self.planetary[number];
        let Some([external, internal]) = self.central_teeth(number, self.pairs()) else {
            return Ok(());
        };
        let together = f64::from(external + internal);
        let first = set
            .planets
            .first()
            .map_or(0.0, |planet| arm(axes, set, planet.shaft).0);
        for planet in &set.planets {
            let turns = (arm(axes, set, planet.shaft).0 - first).rem_euclid(TAU) / TAU;
            let place = turns * together;
            if (place - place.round()).abs() > IN_PLACE {
                return Err(TrainError::Assembly {
                    planet: self.shafts[planet.shaft].name.clone(),
                    first: self.shafts[set.planets[0].shaft].name.clone(),
                    angle: 360.0 * turns,
                    teeth: [external, internal],
                    nearest: 360.0 * place.round() / together,
                });
            }
        }
        Ok(())
    }

    /// Teeth of the external and of the internal gear that mesh with planets of a set; `None` unless there are both.
    pub fn central_teeth(
        &self,
        set: usize,
        pairs: impl Iterator<Item = [GearPlace; 2]>,
    ) -> Option<[u32; 2]> {
        let mut teeth = [None; 2];
        for gears in pairs.filter(|gears| self.set_of_mesh(*gears) == Some(set)) {
            for gear in gears.into_iter().filter(|gear| !self.is_planet(gear.shaft)) {
                let train_gear = self.gear(gear);
                teeth[usize::from(train_gear.internal)] = Some(train_gear.teeth);
            }
        }
        Some([teeth[0]?, teeth[1]?])
    }

    /// Velocities of the planets' centres if every carrier turns at its mean speed.
    pub(super) fn planet_velocities(&self, layout: &Layout, assembled: &Assembled) -> Terms {
        self.planets()
            .flat_map(|(number, set, planet)| {
                let [x, y] = arm_vector(&layout.axes, set, planet.shaft);
                let node = assembled.at(planet.shaft, 0.0);
                let turning = layout.carriers[number];
                [
                    (node, Freedom::X, -turning * y),
                    (node, Freedom::Y, turning * x),
                ]
            })
            .collect()
    }

    /// Mass of a planet \[kg\].
    fn planet_mass(&self, planet: &Planet) -> f64 {
        let gears = self.shafts[planet.shaft].gears.iter();
        gears.map(|gear| gear.body.mass).sum()
    }

    /// Transforms an assembly to the frames of the carriers, if the effects of their rotation are included.
    pub(super) fn turn_with_carriers(
        &self,
        assembled: &mut Assembled,
        layout: &Layout,
    ) -> Result<(), ShaftError> {
        if !self.gyroscopic {
            return Ok(());
        }
        for (number, &speed) in layout.carriers.iter().enumerate() {
            let moves =
                |shaft: usize| layout.turning[shaft] && layout.frames[shaft] == Some(number);
            let marked: Vec<bool> = (0..self.shafts.len()).map(moves).collect();
            let mut turns = assembled.nodes_of(&marked);
            let loose = self.loose_gears().zip(&assembled.loose);
            turns.extend(
                loose
                    .filter(|(gear, _)| moves(gear.shaft))
                    .map(|(_, node)| node),
            );
            if !turns.is_empty() {
                (assembled.assembly).in_turning_frame(speed, |node| turns.contains(&node));
            }
        }
        for (index, (number, set, planet)) in self.planets().enumerate() {
            let speed = layout.carriers[number];
            if speed != 0.0 {
                let nodes = [assembled.at(planet.shaft, 0.0), assembled.pins[index]];
                let arm = arm_vector(&layout.axes, set, planet.shaft);
                let mass = self.planet_mass(planet);
                (assembled.assembly).add_mass_on_pin(nodes, mass, arm, speed)?;
            }
        }
        Ok(())
    }

    /// Centrifugal forces on the planets, per square of the driver's speed.
    pub(super) fn centrifugal_forces(&self, layout: &Layout, assembled: &Assembled) -> Terms {
        let planets = self
            .planets()
            .filter(|(number, _, _)| self.gyroscopic && layout.carriers[*number] != 0.0);
        planets
            .flat_map(|(number, set, planet)| {
                let [x, y] = arm_vector(&layout.axes, set, planet.shaft);
                let pull = self.planet_mass(planet) * layout.carriers[number].powi(2);
                let node = assembled.at(planet.shaft, 0.0);
                [(node, Freedom::X, pull * x), (node, Freedom::Y, pull * y)]
            })
            .collect()
    }

    /// Displacement of the base of a support from its nominal position, in x and y \[m\]: that of a planet's pin.
    pub(super) fn base_place(
        &self,
        support: usize,
        layout: &Layout,
        assembled: &Assembled,
    ) -> [f64; 2] {
        let first_planet = assembled.supports.len() - self.planets().count();
        let planet = support.checked_sub(first_planet);
        let Some((number, set, planet)) = planet.and_then(|index| self.planets().nth(index)) else {
            return [0.0; 2];
        };
        let [x, y] = arm_vector(&layout.axes, set, planet.shaft);
        let ahead = sense(layout.carriers[number]) * planet.pin_error / x.hypot(y);
        [-ahead * y, ahead * x]
    }

    /// Forces of planet bearings whose pins are displaced from their nominal positions, on planets and
    /// carrier.
    pub(super) fn pin_forces(&self, layout: &Layout, assembled: &Assembled) -> Terms {
        let mut forces = Terms::new();
        for (number, (_, support)) in assembled.supports.iter().enumerate() {
            let place = self.base_place(number, layout, assembled);
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
