//! In which frame are the equations of every shaft?
//!
//! The members of a planetary set are in the frame of its carrier: carrier, planets, the shafts whose gears mesh with
//! these, and shafts joined to them by couplings across the axis. Other shafts are in the fixed frame. Couplings
//! between two frames leave the motions across the axis free. Rotation about the axis and motion along the axis are the
//! same in all frames, but a force across the axis would rotate. Sets whose carriers have equal speeds may share a
//! frame.

use super::axes::Axis;
use super::{PlanetarySet, Stop, TrainDrive, TrainError};
use crate::shaft::drive::Motion;

/// Axes closer than this part of the distance between the pins and the carrier's axis coincide.
const CENTRAL: f64 = 1e-9;

/// A connection of two shafts across their axis.
struct CrossConnection {
    shafts: [usize; 2],
    is_coupling: bool,
}

impl TrainDrive {
    /// All connections across the axis. A coupling to a shaft without free motions does not count: such a shaft
    /// is the same in every frame.
    fn across(&self) -> Vec<CrossConnection> {
        let pins = self.planetary.iter().flat_map(PlanetarySet::pins);
        let meshing = (self.pairs().map(|gears| gears.map(|gear| gear.shaft)))
            .filter(|shafts| shafts.iter().any(|&shaft| self.is_planet(shaft)));
        let moves = |shaft: &usize| self.shafts[*shaft].motion != Motion::None;
        let coupled = (self.couplings.iter())
            .filter(|coupling| coupling.stiffness[0] > 0.0 || coupling.stiffness[2] > 0.0)
            .map(|coupling| coupling.shafts)
            .filter(|shafts| shafts.iter().all(moves));
        let joined = |is_coupling: bool| {
            move |shafts: [usize; 2]| CrossConnection {
                shafts,
                is_coupling,
            }
        };
        (pins.chain(meshing).map(joined(false)))
            .chain(coupled.map(joined(true)))
            .collect()
    }

    /// The set whose frame each shaft is in, the first of those that share it; `None` in the fixed frame.
    pub(super) fn frames(&self) -> Vec<Option<usize>> {
        let group = self.groups(
            self.across()
                .into_iter()
                .map(|connection| connection.shafts),
        );
        let sets = |shaft: usize| {
            let mut carriers = self.planetary.iter().map(|set| group[set.carrier]);
            carriers.position(|carrier| carrier == group[shaft])
        };
        (0..self.shafts.len()).map(sets).collect()
    }

    /// Checks that carriers of sets in one frame have equal speeds; `speed` is that of a body.
    pub(super) fn frames_are_one<T: PartialEq>(
        &self,
        frames: &[Option<usize>],
        speed: impl Fn(usize) -> T,
    ) -> Result<(), TrainError> {
        let mut shared = self.planetary.iter().filter_map(|set| {
            let first = self.planetary[frames[set.carrier]?].carrier;
            (speed(first) != speed(set.carrier)).then_some([first, set.carrier])
        });
        let Some(carriers) = shared.next() else {
            return Ok(());
        };
        let all = self.across();
        let joins = |count: &usize| {
            let group = self.groups(all[..=*count].iter().map(|connection| connection.shafts));
            group[carriers[0]] == group[carriers[1]]
        };
        let name = |shaft: usize| self.shafts[shaft].name.clone();
        let culprit = (0..all.len()).find(joins).map(|last| &all[last]);
        let what = culprit.map_or_else(String::new, |connection| match connection {
            CrossConnection {
                shafts: [one, two],
                is_coupling: true,
            } => format!("the coupling of `{}` and `{}`", name(*one), name(*two)),
            CrossConnection { shafts, .. } => {
                let central = shafts.iter().find(|shaft| !self.is_planet(**shaft));
                format!("shaft `{}`", name(*central.unwrap_or(&shafts[0])))
            }
        });
        Err(TrainError::TwoFrames {
            what,
            carriers: carriers.map(name),
        })
    }

    /// Checks that the axes of all members of a set have the direction of the carrier's axis. Except for
    /// planets, they must also coincide with it.
    pub(super) fn members_are_central(
        &self,
        set: &PlanetarySet,
        axes: &[Axis],
        frames: &[Option<usize>],
    ) -> Result<(), TrainError> {
        let carrier = axes[set.carrier];
        let radius = (set.planets.first()).map_or(0.0, |planet| arm(axes, set, planet.shaft).1);
        for (shaft, train_shaft) in (self.shafts.iter().enumerate())
            .filter(|(shaft, _)| frames[*shaft] == frames[set.carrier])
        {
            let along = (axes[shaft].along() - carrier.along()).norm() < CENTRAL;
            let central = self.is_planet(shaft) || arm(axes, set, shaft).1 <= CENTRAL * radius;
            if !(along && central) {
                return Err(TrainError::OffCentre {
                    what: train_shaft.name.clone(),
                    carrier: self.shafts[set.carrier].name.clone(),
                });
            }
        }
        Ok(())
    }

    /// Checks that meshes without a planet are on shafts in the fixed frame.
    pub(super) fn meshes_are_of_planets(&self, turning: &[bool]) -> Result<(), TrainError> {
        let parallel = self
            .pairs()
            .filter(|gears| !gears.iter().any(|gear| self.is_planet(gear.shaft)));
        let mut gears = parallel.flatten();
        match gears.find(|gear| turning[gear.shaft]) {
            Some(gear) => Err(TrainError::GearBesidePlanets {
                gear: self.gear(gear).name.clone(),
                shaft: self.shafts[gear.shaft].name.clone(),
            }),
            None => Ok(()),
        }
    }

    /// Checks that bearings and stops against the ground are isotropic if they are in a rotating frame. Rolling
    /// bearings are not: they are stiffer along their load.
    pub(super) fn supports_are_round(
        &self,
        frames: &[Option<usize>],
        turning: &[bool],
    ) -> Result<(), TrainError> {
        let carrier = |shaft: usize| {
            let set = frames[shaft].and_then(|set| self.planetary.get(set));
            set.map_or_else(String::new, |set| self.shafts[set.carrier].name.clone())
        };
        for (index, shaft) in (self.shafts.iter().enumerate()).filter(|(index, _)| turning[*index])
        {
            let loose = (shaft.gears.iter()).filter_map(|gear| {
                let name = format!("the bearing of the loose gear `{}`", gear.name);
                Some((name, gear.loose?.bearing))
            });
            let bearings = (1..).zip(&shaft.bearings).map(|(number, (_, support))| {
                let name = format!("bearing {number} of shaft `{}`", shaft.name);
                (name, *support)
            });
            for (bearing, support) in bearings.chain(loose) {
                let plain = support.damping == [[0.0; 2]; 2]
                    && support.cross == [0.0; 2]
                    && support.rolling.is_none();
                if support.x != support.y || !plain {
                    return Err(TrainError::UnequalBearing {
                        bearing,
                        carrier: carrier(index),
                    });
                }
            }
        }
        let across = |stop: &&Stop| turning[stop.shaft] && stop.direction[..2] != [0.0; 2];
        match self.stops.iter().find(across) {
            Some(stop) => Err(TrainError::StopAcross {
                shaft: self.shafts[stop.shaft].name.clone(),
                carrier: carrier(stop.shaft),
            }),
            None => Ok(()),
        }
    }
}

/// Vector from the axis of the carrier to that of a shaft, in the carrier's frame \[m\].
pub(super) fn arm_vector(axes: &[Axis], set: &PlanetarySet, shaft: usize) -> [f64; 2] {
    let carrier = axes[set.carrier];
    let [x, y, _] = carrier.local(axes[shaft].at(0.0) - carrier.at(0.0));
    [x, y]
}

/// [`arm_vector`] as angle \[rad\] and distance \[m\].
pub(super) fn arm(axes: &[Axis], set: &PlanetarySet, shaft: usize) -> (f64, f64) {
    let [x, y] = arm_vector(axes, set, shaft);
    (y.atan2(x), x.hypot(y))
}
