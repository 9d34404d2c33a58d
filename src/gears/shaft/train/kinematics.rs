//! What are the exact speeds of the bodies of a train? They follow from joints and held shafts.

use super::axes::PitchPoint;
use super::equations::{Equations, RatioTooLarge};
use super::ratio::Ratio;
use super::{GearPlace, TrainDrive, TrainError};

/// The relation between the speeds of two bodies.
struct SpeedRelation {
    bodies: [usize; 2],
    ratio: Ratio,
    /// Body that both speeds are relative to.
    carrier: Option<usize>,
}

impl SpeedRelation {
    /// `(ω₁ − ω_c) r − (ω₂ − ω_c) = 0`.
    fn equation(&self) -> impl Iterator<Item = (usize, Ratio)> {
        let [one, two] = self.bodies;
        let carrier = self.carrier.map(|body| (body, Ratio::ONE - self.ratio));
        let bodies = [(one, self.ratio), (two, Ratio::ZERO - Ratio::ONE)];
        bodies.into_iter().chain(carrier)
    }

    /// Speed of the second body that the relation requires; `None` if the other speeds are undetermined.
    fn speed_of_second(&self, equations: &Equations) -> Option<Ratio> {
        let frame = match self.carrier {
            Some(carrier) => equations.value(carrier)?,
            None => Ratio::ZERO,
        };
        Some((equations.value(self.bodies[0])? - frame) * self.ratio + frame)
    }
}

/// Exact speeds of the bodies connected with the driver; see [`Layout`](super::speeds::Layout).
pub(super) struct Speeds {
    pub speeds: Vec<Option<Ratio>>,
    pub mesh_speeds: Vec<Option<Ratio>>,
    pub first_gear_speed: Ratio,
}

impl TrainDrive {
    /// The relations between the speeds of bodies.
    fn joints(&self, meshes: &[PitchPoint]) -> Vec<SpeedRelation> {
        let mut joints: Vec<SpeedRelation> = (self.pairs().zip(meshes))
            .map(|(gears, pitch_point)| {
                let [z1, z2] = gears.map(|place| i128::from(self.gear(place).teeth));
                SpeedRelation {
                    bodies: gears.map(|place| self.body_of(place)),
                    ratio: Ratio::new(z1 * i128::from(pitch_point.sense), z2),
                    carrier: self
                        .set_of_mesh(gears)
                        .map(|set| self.planetary[set].carrier),
                }
            })
            .collect();
        joints.extend(self.couplings.iter().map(|coupling| SpeedRelation {
            bodies: coupling.shafts,
            ratio: Ratio::ONE,
            carrier: None,
        }));
        joints
    }

    /// The equations of all joints connected with the driver, and the bodies that they reach.
    fn equations(&self, joints: &[SpeedRelation]) -> Result<(Equations, Vec<bool>), TrainError> {
        let bodies = self.shafts.len() + self.loose_gears().count();
        let mut equations = Equations::new(bodies, self.driver);
        let mut reached = vec![false; bodies];
        reached[self.driver] = true;
        let mut left: Vec<&SpeedRelation> = joints.iter().collect();
        // Joints are taken from the driver outwards, so that each speed follows directly from known ones by a
        // short ratio.
        while let Some(next) = (left.iter()).position(|joint| {
            joint
                .bodies
                .into_iter()
                .chain(joint.carrier)
                .any(|body| reached[body])
        }) {
            let joint = left.remove(next);
            for body in joint.bodies.into_iter().chain(joint.carrier) {
                reached[body] = true;
            }
            let [one, two] = joint.bodies;
            let speeds = (equations.value(two), joint.speed_of_second(&equations));
            let bodies_at_rest = |equations: &Equations| {
                let is_at_rest = |body: &usize| equations.value(*body) == Some(Ratio::ZERO);
                [one, two].iter().filter(|body| is_at_rest(body)).count()
            };
            let before = bodies_at_rest(&equations);
            let turns = equations.add(joint.equation());
            let turns = turns.map_err(|long| self.long_ratio(long))?;
            // Nothing is held yet, so a joint that stops both bodies contradicts the earlier ones.
            if !turns || before == 0 && bodies_at_rest(&equations) == 2 {
                return Err(match speeds {
                    (Some(found), Some(required)) => TrainError::Locked {
                        body: self.body_name(two),
                        speeds: [found, required].map(Ratio::value),
                    },
                    _ => TrainError::Contradiction {
                        bodies: [one, two].map(|body| self.body_name(body)),
                        driver: self.shafts[self.driver].name.clone(),
                    },
                });
            }
        }
        Ok((equations, reached))
    }

    /// Adds the condition that held shafts do not rotate.
    fn add_held_shafts(
        &self,
        joined: &Equations,
        reached: &[bool],
    ) -> Result<Equations, TrainError> {
        let shafts = self.shafts.iter().enumerate();
        let fixed_bodies: Vec<usize> = shafts
            .filter(|(body, shaft)| reached[*body] && !shaft.motion.may_rotate())
            .map(|(body, _)| body)
            .collect();
        let with = |all: &[usize]| -> Result<Option<Equations>, TrainError> {
            let mut equations = joined.clone();
            for &body in all {
                let turns = equations.add([(body, Ratio::ONE)]);
                if !turns.map_err(|long| self.long_ratio(long))? {
                    return Ok(None);
                }
            }
            Ok(Some(equations))
        };
        if let Some(equations) = with(&fixed_bodies)? {
            return Ok(equations);
        }
        // Find the first held shaft that stops the driver, and another one without which the driver could rotate.
        let mut last = 0;
        while with(&fixed_bodies[..=last])?.is_some() {
            last += 1;
        }
        for other in 0..last {
            let mut rest = fixed_bodies[..=last].to_vec();
            rest.remove(other);
            if with(&rest)?.is_some() {
                return Err(TrainError::AllHeld {
                    held: [fixed_bodies[other], fixed_bodies[last]]
                        .map(|body| self.body_name(body)),
                });
            }
        }
        let body = if self.planetary.is_empty() { fixed_bodies[last] } else { self.driver };
        Err(TrainError::Held {
            body: self.body_name(body),
        })
    }

    fn long_ratio(&self, RatioTooLarge(body): RatioTooLarge) -> TrainError {
        TrainError::LongRatio {
            body: self.body_name(body),
        }
    }

    /// Checks that a speed, of a body or from its joints, is a ratio of integers that are not too large.
    pub(super) fn is_exact(&self, speed: Ratio, body: usize) -> Result<(), TrainError> {
        if speed == Ratio::TOO_LARGE {
            Err(self.long_ratio(RatioTooLarge(body)))
        } else {
            Ok(())
        }
    }

    /// Why gears in mesh do not roll on each other.
    pub(super) fn standstill_error(&self, gears: [GearPlace; 2]) -> TrainError {
        let bodies = gears.map(|gear| self.body_of(gear));
        let is_fixed = |body: &usize| {
            let shaft = self.shafts.get(*body);
            shaft.is_some_and(|held_shaft| !held_shaft.motion.may_rotate())
        };
        match bodies.iter().find(|body| is_fixed(body)) {
            Some(&body) if self.set_of_mesh(gears).is_none() => TrainError::Held {
                body: self.body_name(body),
            },
            _ => TrainError::NotRolling {
                gears: gears.map(|place| self.gear(place).name.clone()),
            },
        }
    }

    /// Speeds of the bodies; held ones are 0.
    pub(super) fn speeds(
        &self,
        meshes: &[PitchPoint],
        frames: &[Option<usize>],
    ) -> Result<Speeds, TrainError> {
        let (joined, reached) = self.equations(&self.joints(meshes))?;
        let equations = self.add_held_shafts(&joined, &reached)?;
        let name = |body: usize| self.body_name(body);
        let first = self.body_of(self.gears[0]);
        // Without planets the speed of an operating point is that of the first gear.
        let alone = self.planetary.is_empty() && equations.value(first) != Some(Ratio::ONE);
        if !reached[first] || alone {
            return Err(TrainError::Driver {
                driver: name(self.driver),
            });
        }
        let free: Vec<String> = (0..reached.len())
            .filter(|&body| reached[body] && equations.value(body).is_none())
            .filter(|&body| !self.is_planet(body))
            .map(|body| format!("`{}`", name(body)))
            .collect();
        if !free.is_empty() {
            return Err(TrainError::NothingHeld {
                free: free.join(", "),
                driver: name(self.driver),
            });
        }
        let speed = |body: usize| equations.value(body).filter(|_| reached[body]);
        self.frames_are_one(frames, speed)?;
        let rolls = |body: usize| {
            let frame = frames[self.shaft_of(body)].map(|set| self.planetary[set].carrier);
            let frame_speed = frame.map_or(Some(Ratio::ZERO), speed);
            Some(speed(body)? - frame_speed?)
        };
        let first_gear_speed = rolls(first).unwrap_or(Ratio::ZERO);
        self.is_exact(first_gear_speed, first)?;
        if first_gear_speed == Ratio::ZERO {
            return Err(self.standstill_error(self.gears));
        }
        // The first gear rolls forwards.
        let sense = first_gear_speed / first_gear_speed.modulus();
        let bodies = || 0..reached.len();
        let solved = Speeds {
            speeds: bodies().map(|body| Some(speed(body)? * sense)).collect(),
            mesh_speeds: bodies()
                .map(|body| Some(rolls(body)? / first_gear_speed))
                .collect(),
            first_gear_speed: first_gear_speed.modulus(),
        };
        for (body, (speed, mesh_speed)) in solved.speeds.iter().zip(&solved.mesh_speeds).enumerate()
        {
            for value in speed.iter().chain(mesh_speed) {
                self.is_exact(*value, body)?;
            }
        }
        Ok(solved)
    }
}
