//! How fast does every body of a train turn where all contacts bear, and how many cycles has each
//! mesh?

use super::axes::{Axis, BesideEachOther, PitchPoint, PlacedGear};
use super::{GearPlace, ShaftCoupling, TrainDrive, TrainError, TrainShaft};
use crate::numerics::integers::{greatest_divisor, least_multiple};
use crate::structure::{MOST_BASE_CYCLES, MOST_CYCLES};

/// Difference of unit vectors along axes that point the same way.
const ALIKE: f64 = 1e-9;

/// Distance \[m\] of places that are one: those of shafts askew in space are told in hundredths of a millimetre.
const ONE_PLACE: f64 = 2e-5;

/// A ratio of whole numbers in lowest terms, the denominator positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Ratio {
    over: i128,
    under: i128,
}

impl Ratio {
    fn new(over: i128, under: i128) -> Self {
        let divisor = greatest_divisor(over.unsigned_abs(), under.unsigned_abs()) as i128;
        let sign = if under < 0 { -1 } else { 1 };
        Self {
            over: sign * over / divisor,
            under: sign * under / divisor,
        }
    }

    fn times(self, over: i128, under: i128) -> Self {
        Self::new(self.over * over, self.under * under)
    }

    fn minus(self, other: Self) -> Self {
        let over = self.over * other.under - other.over * self.under;
        Self::new(over, self.under * other.under)
    }

    fn value(self) -> f64 {
        self.over as f64 / self.under as f64
    }
}

/// Sense of running: −1 for a negative speed, else 1.
pub(super) fn sense(speed: f64) -> f64 {
    if speed < 0.0 { -1.0 } else { 1.0 }
}

/// A train laid out in space, with the speeds of its bodies.
#[derive(Debug)]
pub(super) struct Layout {
    /// Axis of each shaft.
    pub axes: Vec<Axis>,
    /// Speed of each body about its axis, right-handed, in units of the first gear's; 0 of one that
    /// stands still: first the shafts, then the loose gears.
    pub speeds: Vec<f64>,
    /// The same as the meshes see them: beside the speed of the carrier, in units of the first gear's own.
    pub rolling: Vec<f64>,
    /// Speed of the carrier of planets; 0 where the axes of all meshes stand still.
    pub carrier: f64,
    /// Where the first mesh and each further one meet.
    pub meshes: Vec<PitchPoint>,
    /// Cycles of each mesh, `[p, q]`: p in q of the first mesh.
    pub cycles: Vec<[u32; 2]>,
    /// Cycles of the first mesh after which those that vary are as they were.
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

    /// The body that a gear turns with: its shaft, or itself.
    pub(super) fn body_of(&self, place: GearPlace) -> usize {
        let loose = self.loose_gears().position(|other| other == place);
        loose.map_or(place.shaft, |number| self.shafts.len() + number)
    }

    /// Name of a body.
    pub(super) fn body_name(&self, body: usize) -> String {
        match self.shafts.get(body) {
            Some(shaft) => shaft.name.clone(),
            None => (self.loose_gears().nth(body - self.shafts.len()))
                .map_or_else(String::new, |place| self.gear(place).name.clone()),
        }
    }

    /// Where the gears of a mesh meet.
    ///
    /// # Errors
    /// [`TrainError::SkewAxes`], [`TrainError::OneAxis`], [`TrainError::PitchCircles`],
    /// [`TrainError::FacesApart`].
    fn met(&self, gears: [GearPlace; 2], axes: &[Axis]) -> Result<PitchPoint, TrainError> {
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

    /// How two gears stand beside each other; none where their axes meet, as those of bevel gears do.
    ///
    /// # Errors
    /// [`TrainError`] where the gears cannot mesh there.
    pub fn beside(&self, gears: [GearPlace; 2]) -> Result<Option<BesideEachOther>, TrainError> {
        Ok(self.met(gears, &self.axes())?.beside)
    }

    /// Mesh cycles after which the stiffness of all further meshes is as it was.
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

    /// Name and speed of every body about its axis, right-handed, in units of the first gear's speed; of planets the first.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn body_speeds(&self) -> Result<Vec<(String, f64)>, TrainError> {
        let planets = self.planetary.iter().flat_map(|set| &set.planets);
        let alike: Vec<usize> = planets.skip(1).map(|planet| planet.shaft).collect();
        let speeds = self.layout()?.speeds.into_iter().enumerate();
        let told = speeds.filter(|(body, _)| !alike.contains(body));
        Ok(told
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
            .map(|gears| self.met(gears, &axes))
            .collect::<Result<Vec<_>, _>>()?;
        let rolling = self.rolling(&meshes)?;
        let (speeds, carrier) = self.speeds(&rolling)?;
        if let Some(set) = &self.planetary {
            self.check_planets(set, &axes)?;
        }
        if let Some(joined) = &self.housing {
            self.check_joints(joined, &axes)?;
        }
        let idle =
            |(shaft, speed): &(&TrainShaft, &Option<_>)| shaft.output != 0.0 && speed.is_none();
        if let Some((shaft, _)) = self.shafts.iter().zip(&speeds).find(idle) {
            return Err(TrainError::Idle {
                shaft: shaft.name.clone(),
            });
        }
        let mut cycles = vec![[1, 1]];
        let first = self.gear(self.gears[0]).teeth;
        for mesh in &self.meshes {
            let gear = self.gear(mesh.gears[0]);
            let body = self.body_of(mesh.gears[0]);
            let speed = rolling[body].ok_or_else(|| TrainError::Apart {
                body: self.body_name(body),
            })?;
            let ratio = speed.times(i128::from(gear.teeth), i128::from(first));
            let (p, q) = (ratio.over.unsigned_abs(), ratio.under.unsigned_abs());
            match [u64::try_from(p), u64::try_from(q)] {
                [Ok(p), Ok(q)] if p <= u64::from(MOST_CYCLES) && q <= u64::from(MOST_CYCLES) => {
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
        if speeds[self.driver] != Some(Ratio::new(1, 1)) {
            return Err(TrainError::Driver {
                driver: self.shafts[self.driver].name.clone(),
            });
        }
        let values = |speeds: Vec<Option<Ratio>>| {
            let values = speeds.into_iter();
            values
                .map(|speed| speed.map_or(0.0, Ratio::value))
                .collect()
        };
        Ok(Layout {
            base_cycles: together,
            axes,
            speeds: values(speeds),
            rolling: values(rolling),
            carrier: carrier.value(),
            meshes,
            cycles,
        })
    }

    /// That the ends of a coupling are on one axis, and that its springs across it have no arm.
    fn is_in_line(&self, coupling: &ShaftCoupling, axes: &[Axis]) -> Result<(), TrainError> {
        let shafts = || coupling.shafts.map(|shaft| self.shafts[shaft].name.clone());
        let [one, two] = coupling.shafts.map(|shaft| axes[shaft]);
        if (one.along() - two.along()).norm() > ALIKE {
            return Err(TrainError::CouplingAxes { shafts: shafts() });
        }
        let apart = two.at(coupling.at[1]) - one.at(coupling.at[0]);
        let gap = apart.dot(&one.along());
        let distance = (apart - one.along() * gap).norm();
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

    /// Speeds of the bodies beside that of the carrier, of those that anything connects with the first gear.
    fn rolling(&self, meshes: &[PitchPoint]) -> Result<Vec<Option<Ratio>>, TrainError> {
        // How the second body follows the first.
        let mut edges: Vec<([usize; 2], [i128; 2])> = (self.pairs().zip(meshes))
            .map(|(gears, met)| {
                let [z1, z2] = gears.map(|place| i128::from(self.gear(place).teeth));
                let bodies = gears.map(|place| self.body_of(place));
                (bodies, [z1 * i128::from(met.sense), z2])
            })
            .collect();
        edges.extend((self.couplings.iter()).map(|coupling| (coupling.shafts, [1, 1])));
        let bodies = self.shafts.len() + self.loose_gears().count();
        let mut speeds = vec![None; bodies];
        speeds[self.body_of(self.gears[0])] = Some(Ratio::new(1, 1));
        if let Some(set) = &self.planetary {
            speeds[set.carrier] = Some(Ratio::new(0, 1));
        }
        // Each round reaches what is one edge further away.
        for _ in 0..bodies {
            for &([one, two], [over, under]) in &edges {
                match (speeds[one], speeds[two]) {
                    (Some(speed), None) => speeds[two] = Some(Ratio::times(speed, over, under)),
                    (None, Some(speed)) => speeds[one] = Some(Ratio::times(speed, under, over)),
                    _ => {}
                }
            }
        }
        for &([one, two], [over, under]) in &edges {
            if let (Some(before), Some(speed)) = (speeds[one], speeds[two]) {
                let expected = before.times(over, under);
                if expected != speed {
                    return Err(TrainError::Locked {
                        body: self.body_name(two),
                        speeds: [speed.value(), expected.value()],
                    });
                }
            }
        }
        Ok(speeds)
    }

    /// Speeds of the bodies, and that of the carrier of planets, from those beside the carrier: what is held stands still.
    fn speeds(&self, rolling: &[Option<Ratio>]) -> Result<(Vec<Option<Ratio>>, Ratio), TrainError> {
        let zero = Ratio::new(0, 1);
        let mut held = (self.shafts.iter().zip(rolling))
            .filter(|(shaft, _)| !shaft.motion.turns())
            .filter_map(|(shaft, rolling)| Some((&shaft.name, (*rolling)?)));
        if self.planetary.is_none() {
            return match held.next() {
                Some((body, _)) => Err(TrainError::Held { body: body.clone() }),
                None => Ok((rolling.to_vec(), zero)),
            };
        }
        let (first, still) = held.next().ok_or(TrainError::NothingHeld)?;
        if let Some((other, _)) = held.find(|(_, rolling)| *rolling != still) {
            return Err(TrainError::AllHeld {
                held: [first, other].map(String::clone),
            });
        }
        let one = Ratio::new(1, 1).minus(still);
        if one == zero {
            return Err(TrainError::Held {
                body: first.clone(),
            });
        }
        // In units of the first gear's speed, Ω_i = (ρ_i − ρ_held)/(1 − ρ_held).
        let absolute = |rolling: Ratio| rolling.minus(still).times(one.under, one.over);
        let speeds = rolling.iter().map(|rolling| rolling.map(absolute));
        Ok((speeds.collect(), absolute(zero)))
    }
}
