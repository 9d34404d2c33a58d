//! The flexible drive as a train of two shafts: Timoshenko beams on bearings, rigid gear bodies centred on their nodes,
//! end inertias on overhangs.

use super::drive::{self, FlexibleDrive, Motion};
use super::error::ShaftError;
use super::train::{ShaftSection, TrainDrive, TrainShaft};
use super::two_shafts::TwoShafts;
use crate::gear::Hub;
use crate::structure::ModalStructure;

impl FlexibleDrive {
    /// The `retained` lowest of the `modes` lowest modes of the drive.
    ///
    /// With `mta` (modal-truncation augmentation) the modes that are computed but not retained
    /// return as residual flexibility `Σ mesh²/ω²`; without it that is 0. Modes beyond
    /// `modes` are dropped in both cases.
    ///
    /// `pinion_torque` and `wheel_torque` act at the end inertias, each positive in its
    /// shaft's direction of rotation. The sign of a mode makes its mesh participation
    /// positive. If that is zero, the mode's largest freedom moves in the
    /// positive direction.
    ///
    /// # Errors
    /// All of [`ShaftError`] except those of ties: unphysical dimensions, shafts that are not
    /// held, more modes than freedoms, fewer retained than the two rigid ones.
    pub fn modes(
        &self,
        modes: usize,
        retained: usize,
        mta: bool,
    ) -> Result<ModalStructure, ShaftError> {
        drive::check(&self.gears, &self.shafts, self.density, Motion::All)?;
        let mut structure = self.train()?.modes(modes, retained, mta)?;
        // Torques are positive from the gear to the load here, but along the shaft in a train.
        for wheel in structure.torques.iter_mut().skip(1) {
            for gain in &mut wheel.gain {
                *gain = -*gain;
            }
        }
        // Motions of pinion and wheel are those of the gears, not of the ends where torques act.
        if let [.., pinion_end, wheel_end, pinion, wheel] = structure.motions.as_mut_slice() {
            pinion_end.gain.clone_from(&pinion.gain);
            wheel_end.gain.clone_from(&wheel.gain);
        }
        Ok(structure)
    }

    /// The drive as a train, with the middles of its gear bodies in one plane.
    pub(super) fn train(&self) -> Result<TrainDrive, ShaftError> {
        let pair = TwoShafts {
            gears: &self.gears,
            shafts: &self.shafts,
            density: self.density,
            damping: self.damping,
            damping_overrides: &self.damping_overrides,
            gyroscopic: self.gyroscopic,
        };
        Ok(TrainDrive {
            young_modulus: self.young_modulus,
            shear_modulus: self.shear_modulus,
            shear_coefficient: self.shear_coefficient,
            ..pair.train([self.shaft(&pair, 0)?, self.shaft(&pair, 1)?])
        })
    }

    /// One shaft with its sections and its hub.
    fn shaft(&self, pair: &TwoShafts, index: usize) -> Result<TrainShaft, ShaftError> {
        let body = pair.body(index)?;
        let mut shaft = pair.shaft(index, self.shafts[index].overhang, body.rigid)?;
        if let Some(hub) = body.hub {
            let bearings = [0, 1].map(|number| shaft.bearings[number].0);
            check_hub(hub, index + 1, shaft.gears[0].at, bearings)?;
        }
        shaft.gears[0].hub = body.hub;
        shaft.sections = self.sections(index)?;
        Ok(shaft)
    }

    /// The sections of a shaft without its hub, each in equal elements.
    fn sections(&self, index: usize) -> Result<Vec<ShaftSection>, ShaftError> {
        let shaft = &self.shafts[index];
        let before = shaft.gear_position * shaft.span;
        let parts = [
            (shaft.overhang, "the overhang"),
            (before, "the part from the first bearing to the gear"),
            (
                shaft.span - before,
                "the part from the gear to the second bearing",
            ),
        ];
        let parts = parts.into_iter().zip(self.elements);
        (parts.filter(|((length, _), _)| *length > 0.0))
            .map(|((length, stretch), elements)| match elements {
                0 => Err(ShaftError::NoElement { stretch }),
                _ => Ok(ShaftSection {
                    length,
                    outer: shaft.diameter,
                    inner: shaft.inner_diameter,
                    element: Some(length / elements as f64),
                }),
            })
            .collect()
    }
}

/// Checks that a hub around a gear ends between both bearings \[m\]. `number` of the shaft is 1 or 2.
fn check_hub(hub: Hub, number: usize, gear: f64, bearings: [f64; 2]) -> Result<(), ShaftError> {
    let [start, end] = hub.ends(gear);
    let round_off = 8.0 * f64::EPSILON * bearings[1];
    if start < bearings[0] - round_off || end > bearings[1] + round_off {
        return Err(ShaftError::HubBeyondBearings {
            shaft: number,
            length: hub.length,
            room: 2.0 * (gear - bearings[0]).min(bearings[1] - gear),
        });
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests;
