//! How fast does every body of a train rotate if all contacts carry load, and how many cycles does each
//! mesh have?

use super::axes::{Axis, ParallelPlacement, PitchPoint, PlacedGear};
use super::kinematics::Speeds;
use super::ratio::Ratio;
use super::{GearPlace, ShaftCoupling, TrainDrive, TrainError, TrainShaft};
use crate::numerics::integers::least_multiple;
use crate::structure::{MOST_BASE_CYCLES, MOST_RATIO_CYCLES};

/// Largest difference of unit vectors along axes of the same direction.
const ALIKE: f64 = 1e-9;

/// Points closer than this \[m\] coincide: coordinates of oblique shafts are rounded to hundredths of a millimetre.
const ONE_PLACE: f64 = 2e-5;

/// Direction of rotation: −1 for a negative speed, else 1.
pub(super) fn sense(speed: f64) -> f64 {
    if speed < 0.0 { -1.0 } else { 1.0 }
}

/// A train laid out in space, with the speeds of its bodies.
#[derive(Debug)]
pub(super) struct Layout {
    /// Axis of each shaft.
    pub axes: Vec<Axis>,
    /// Speed of each body about its axis, right-handed, in units of the driver's; 0 for a body at
    /// rest. First the shafts, then the loose gears. The first gear rolls forwards.
    pub speeds: Vec<f64>,
    /// Speed of each body in its meshes, in units of the first gear's speed. Speeds of members of planetary sets are
    /// relative to their carrier.
    pub mesh_speeds: Vec<f64>,
    /// Rolling speed of the first gear, in units of the driver's speed.
    pub first_gear_speed: f64,
    /// Speed of the carrier of each planetary set.
    pub carriers: Vec<f64>,
    /// The set whose frame each shaft is in; `None` in the fixed frame.
    pub frames: Vec<Option<usize>>,
    /// Whether the frame of each shaft rotates.
    pub turning: Vec<bool>,
    /// Pitch points of the first mesh and of each further one.
    pub meshes: Vec<PitchPoint>,
    /// Turns of each body in the meshes, `[p, q]`: p in q cycles of the first mesh; `None` for bodies at rest,
    /// and if p or q is out of range.
    pub turns: Vec<Option<[u32; 2]>>,
    /// Cycles of each mesh, `[p, q]`: p in q of the first mesh.
    pub cycles: Vec<[u32; 2]>,
    /// Cycles of the first mesh after which all varying meshes repeat.
    pub base_cycles: usize,
}

impl TrainDrive {
    /// Both gears of the first mesh and of each further one.
    pub(super) fn pairs(&self) -> impl Iterator<Item = [GearPlace; 2]> {
        std::iter::once(self.gears).chain(self.meshes.iter().map(|mesh| mesh.gears))
    }

    /// All gears, shaft by shaft.
    pub(super) fn gears(&self) -> impl Iterator<Item = GearPlace> {
        let shafts = self.shafts.iter().enumerate();
        shafts
            .flat_map(|(shaft, on)| (0..on.gears.len()).map(move |gear| GearPlace { shaft, gear }))
    }

    /// Loose gears, in the order of their bodies.
    pub(super) fn loose_gears(&self) -> impl Iterator<Item = GearPlace> {
        (self.gears()).filter(|&place| self.gear(place).loose.is_some())
    }

    /// The body that a gear rotates with: its shaft, or itself.
    pub(super) fn body_of(&self, place: GearPlace) -> usize {
        let loose = self.loose_gears().position(|other| other == place);
        loose.map_or(place.shaft, |number| self.shafts.len() + number)
    }

    /// The shaft of a body: itself, or the one that a loose gear runs on.
    pub(super) fn shaft_of(&self, body: usize) -> usize {
        let loose = body.checked_sub(self.shafts.len());
        let place = loose.and_then(|number| self.loose_gears().nth(number));
        place.map_or(body, |place| place.shaft)
    }

    /// Name of a body.
    pub(super) fn body_name(&self, body: usize) -> String {
        match self.shafts.get(body) {
            Some(shaft) => shaft.name.clone(),
            None => (self.loose_gears().nth(body - self.shafts.len()))
                .map_or_else(String::new, |place| self.gear(place).name.clone()),
        }
    }

    /// Pitch point of the gears of a mesh.
    ///
    /// # Errors
    /// [`TrainError::NotInside`], [`TrainError::SkewAxes`], [`TrainError::OneAxis`],
    /// [`TrainError::PitchCircles`], [`TrainError::FacesApart`].
    fn pitch_point(&self, gears: [GearPlace; 2], axes: &[Axis]) -> Result<PitchPoint, TrainError> {
        let [one, two] = gears.map(|place| {
            let gear = self.gear(place);
            PlacedGear {
                name: gear.name.clone(),
                axis: axes[place.shaft],
                at: gear.at,
                teeth: gear.teeth,
                internal: gear.internal,
                radius: gear.pitch_radius(),
                module: gear.module,
                width: gear.width,
            }
        });
        PitchPoint::of([&one, &two])
    }

    /// Relative position of two gears; `None` if their axes intersect, as for bevel gears.
    ///
    /// # Errors
    /// [`TrainError`] if the gears cannot mesh there.
    pub fn parallel_placement(
        &self,
        gears: [GearPlace; 2],
    ) -> Result<Option<ParallelPlacement>, TrainError> {
        Ok(self.pitch_point(gears, &self.axes())?.parallel)
    }

    /// Mesh cycles after which the stiffness of all further meshes repeats.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn base_cycles(&self) -> Result<usize, TrainError> {
        Ok(self.layout()?.base_cycles)
    }

    fn axes(&self) -> Vec<Axis> {
        (self.shafts.iter())
            .map(|shaft| Axis::new(shaft.origin, shaft.direction))
            .collect()
    }

    /// Name and speed of every body about its axis, right-handed, in units of the driver's speed; only the first planet
    /// of a set.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn body_speeds(&self) -> Result<Vec<(String, f64)>, TrainError> {
        let repeated = (self.planetary.iter()).flat_map(|set| set.planets.iter().skip(1));
        let repeated: Vec<usize> = repeated.map(|planet| planet.shaft).collect();
        let speeds = self.layout()?.speeds.into_iter().enumerate();
        let others = speeds.filter(|(body, _)| !repeated.contains(body));
        Ok(others
            .map(|(body, speed)| (self.body_name(body), speed))
            .collect())
    }

    /// The train in space.
    pub(super) fn layout(&self) -> Result<Layout, TrainError> {
        let axes = self.axes();
        for coupling in &self.couplings {
            self.is_in_line(coupling, &axes)?;
        }
        let meshes = (self.pairs())
            .map(|gears| self.pitch_point(gears, &axes))
            .collect::<Result<Vec<_>, _>>()?;
        self.check_set_separation()?;
        self.check_first()?;
        let frames = self.frames();
        let Speeds {
            speeds,
            mesh_speeds,
            first_gear_speed,
        } = self.speeds(&meshes, &frames)?;
        let carrier = |set: usize| speeds[self.planetary[set].carrier].unwrap_or(Ratio::ZERO);
        let turning: Vec<bool> = (frames.iter())
            .map(|frame| frame.is_some_and(|set| carrier(set) != Ratio::ZERO))
            .collect();
        self.meshes_are_of_planets(&turning)?;
        self.supports_are_round(&frames, &turning)?;
        for set in 0..self.planetary.len() {
            self.check_planets(set, &axes, &frames)?;
        }
        if let Some(joined) = &self.housing {
            self.check_joints(joined, &axes, &turning)?;
        }
        let idle = |(shaft, speed): &(&TrainShaft, &Option<Ratio>)| {
            let turns =
                shaft.motion.may_rotate() && speed.is_some_and(|speed| speed != Ratio::ZERO);
            shaft.output != 0.0 && !turns
        };
        if let Some((shaft, _)) = self.shafts.iter().zip(&speeds).find(idle) {
            return Err(TrainError::Idle {
                shaft: shaft.name.clone(),
            });
        }
        let driver = &self.shafts[self.driver];
        if driver.output != 0.0 {
            return Err(TrainError::OutputOfDriver {
                driver: driver.name.clone(),
            });
        }
        let mut cycles = vec![[1, 1]];
        let first = self.gear(self.gears[0]).teeth;
        for mesh in &self.meshes {
            let gear = self.gear(mesh.gears[0]);
            let body = self.body_of(mesh.gears[0]);
            let speed = mesh_speeds[body].ok_or_else(|| TrainError::Apart {
                body: self.body_name(body),
            })?;
            if speed == Ratio::ZERO {
                return Err(self.standstill_error(mesh.gears));
            }
            let ratio = speed * Ratio::new(i128::from(gear.teeth), i128::from(first));
            self.is_exact(ratio, body)?;
            let (p, q) = (ratio.over.unsigned_abs(), ratio.under.unsigned_abs());
            match [u64::try_from(p), u64::try_from(q)] {
                [Ok(p), Ok(q)]
                    if p <= u64::from(MOST_RATIO_CYCLES) && q <= u64::from(MOST_RATIO_CYCLES) =>
                {
                    cycles.push([p as u32, q as u32]);
                }
                [p, q] => {
                    return Err(TrainError::LongPeriod {
                        gears: mesh.gears.map(|place| self.gear(place).name.clone()),
                        p: p.unwrap_or(u64::MAX),
                        q: q.unwrap_or(u64::MAX),
                    });
                }
            }
        }
        let varying = (self.meshes.iter().zip(&cycles[1..]))
            .filter(|(mesh, _)| mesh.law.varies())
            .map(|(_, &[_, q])| q as usize);
        let together = varying.fold(1, least_multiple);
        if together > MOST_BASE_CYCLES {
            return Err(TrainError::LongTogether { cycles: together });
        }
        let turns = |speed: &Option<Ratio>| {
            let turns = (speed.as_ref()?.modulus()) * Ratio::new(1, i128::from(first));
            let parts = [
                u32::try_from(turns.over).ok()?,
                u32::try_from(turns.under).ok()?,
            ];
            (parts[0] > 0).then_some(parts)
        };
        let turns = mesh_speeds.iter().map(turns).collect();
        let values = |speeds: Vec<Option<Ratio>>| {
            let values = speeds.into_iter();
            values
                .map(|speed| speed.map_or(0.0, Ratio::value))
                .collect()
        };
        Ok(Layout {
            base_cycles: together,
            carriers: (0..self.planetary.len())
                .map(|set| carrier(set).value())
                .collect(),
            axes,
            speeds: values(speeds),
            mesh_speeds: values(mesh_speeds),
            first_gear_speed: first_gear_speed.value(),
            frames,
            turning,
            meshes,
            turns,
            cycles,
        })
    }

    /// Checks that the ends of a coupling are on one axis, and that its radial springs have no lever arm.
    fn is_in_line(&self, coupling: &ShaftCoupling, axes: &[Axis]) -> Result<(), TrainError> {
        let shafts = || coupling.shafts.map(|shaft| self.shafts[shaft].name.clone());
        let [one, two] = coupling.shafts.map(|shaft| axes[shaft]);
        if (one.along() - two.along()).norm() > ALIKE {
            return Err(TrainError::CouplingAxes { shafts: shafts() });
        }
        let offset = two.at(coupling.at[1]) - one.at(coupling.at[0]);
        let gap = offset.dot(&one.along());
        let distance = (offset - one.along() * gap).norm();
        if distance > ONE_PLACE {
            return Err(TrainError::CouplingOffAxis {
                shafts: shafts(),
                distance,
            });
        }
        if coupling.stiffness[0] > 0.0 && gap.abs() > ONE_PLACE {
            Err(TrainError::CouplingGap {
                shafts: shafts(),
                gap: gap.abs(),
            })
        } else {
            Ok(())
        }
    }
}
