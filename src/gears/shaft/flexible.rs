//! The flexible drive as a train of two: Timoshenko shafts on bearings, rigid gear bodies centred on their node, end
//! inertias on overhangs.

use super::disc::Disc;
use super::drive::{self, FlexibleDrive, Released};
use super::error::ShaftError;
use super::train::{GearPlace, Motion, ShaftSection, TrainDrive, TrainGear, TrainShaft};
use crate::gear::Hub;
use crate::structure::ModalStructure;

impl FlexibleDrive {
    /// The `retained` lowest of the `modes` lowest modes of the drive.
    ///
    /// With `mta` (modal-truncation augmentation) the modes computed but not retained
    /// return as residual flexibility `Σ mesh²/ω²`; without it that is 0. Modes beyond
    /// `modes` are dropped either way.
    ///
    /// `pinion_torque` and `wheel_torque` act at the end inertias, each positive in its
    /// shaft's sense of running. The sign of a mode is such that its mesh participation is
    /// positive, or, where the mesh does not feel it, that its largest freedom moves in the
    /// positive direction.
    ///
    /// # Errors
    /// Any [`ShaftError`] but those of ties: unphysical dimensions, shafts that are not
    /// held, more modes than freedoms, fewer retained than the two rigid ones.
    pub fn modes(
        &self,
        modes: usize,
        retained: usize,
        mta: bool,
    ) -> Result<ModalStructure, ShaftError> {
        drive::check(&self.gears, &self.shafts, self.density, Released::All)?;
        let mut structure = self.train()?.modes(modes, retained, mta)?;
        // From the gear to the load: a train counts along its shaft.
        for wheel in structure.torques.iter_mut().skip(1) {
            for gain in &mut wheel.gain {
                *gain = -*gain;
            }
        }
        Ok(structure)
    }

    /// The drive as a train, the middles of its gear bodies in one plane.
    fn train(&self) -> Result<TrainDrive, ShaftError> {
        let place = |shaft| GearPlace { shaft, gear: 0 };
        Ok(TrainDrive {
            shafts: vec![self.shaft(0)?, self.shaft(1)?],
            gears: [place(0), place(1)],
            pair: self.gears.clone(),
            meshes: Vec::new(),
            couplings: Vec::new(),
            stops: Vec::new(),
            planetary: None,
            housing: None,
            driver: 0,
            young_modulus: self.young_modulus,
            shear_modulus: self.shear_modulus,
            density: self.density,
            shear_coefficient: self.shear_coefficient,
            damping: self.damping,
            damping_overrides: self.damping_overrides.clone(),
            gyroscopic: self.gyroscopic,
            bearing_load: None,
        })
    }

    /// One shaft with bearings, gear body and end inertia.
    fn shaft(&self, index: usize) -> Result<TrainShaft, ShaftError> {
        let shaft = &self.shafts[index];
        let gears = &self.gears;
        let body = drive::gear_body(gears, &self.shafts, self.density, index)?;
        let mut sections = self.sections(index)?;
        let bearing_at = [shaft.overhang, shaft.overhang + shaft.span];
        let gear_at = shaft.overhang + shaft.gear_position * shaft.span;
        if let Some(hub) = body.hub {
            let ends = hub_ends(hub, index + 1, gear_at, bearing_at)?;
            sections = ShaftSection::thickened(&sections, ends, hub.diameter);
        }
        let end = Disc {
            polar_inertia: shaft.end_inertia,
            ..Disc::default()
        };
        let name = ["pinion", "wheel"][index].to_owned();
        let gear = TrainGear {
            name: name.clone(),
            at: gear_at,
            teeth: gears.teeth[index],
            internal: false,
            module: gears.module,
            pressure_angle: gears.pressure_angle,
            helix_angle: [1.0, -1.0][index] * gears.helix_angle,
            width: gears.face_width,
            body: body.rigid,
            loose: None,
        };
        let across = if index == 0 { 0.0 } else { gears.centre_distance()? };
        Ok(TrainShaft {
            name,
            origin: [across, 0.0, -gear_at],
            direction: [0.0, 0.0, 1.0],
            sections,
            element: None,
            motion: Motion::All,
            discs: vec![(0.0, end)],
            gears: vec![gear],
            bearings: bearing_at.into_iter().zip(shaft.bearings).collect(),
            torque_at: 0.0,
            output: [0.0, 1.0][index],
            drag: shaft.drag,
        })
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

/// Where along its shaft a hub begins and ends, about a gear between two bearings \[m\]. `number` of the shaft is 1 or 2.
fn hub_ends(
    hub: Hub,
    number: usize,
    gear: f64,
    bearings: [f64; 2],
) -> Result<[f64; 2], ShaftError> {
    let [start, end] = [-0.5, 0.5].map(|side| gear + side * hub.length);
    let round_off = 8.0 * f64::EPSILON * bearings[1];
    if start < bearings[0] - round_off || end > bearings[1] + round_off {
        return Err(ShaftError::HubBeyondBearings {
            shaft: number,
            length: hub.length,
            room: 2.0 * (gear - bearings[0]).min(bearings[1] - gear),
        });
    }
    Ok([start, end])
}

#[cfg(test)]
pub(super) mod tests;
