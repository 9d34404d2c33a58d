//! The flexible drive as an assembly: Timoshenko shafts on bearings, rigid gear bodies
//! centred on their node, end inertias on overhangs.

use super::assembly::Assembly;
use super::beam::{Material, Section};
use super::drive::{self, FlexibleDrive, Released, Support};
use super::error::ShaftError;
use super::pair::{PairedShafts, ShaftNodes, Torsion};
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
        let mut assembly = Assembly::new();
        let shafts = [
            self.add_shaft(&mut assembly, 0)?,
            self.add_shaft(&mut assembly, 1)?,
        ];
        let paired = PairedShafts {
            gears: &self.gears,
            shafts,
            damping: self.damping,
            damping_overrides: &self.damping_overrides,
            drag: [0, 1].map(|index| self.shafts[index].drag),
        };
        paired.modes(&assembly, modes, retained, mta)
    }

    /// Adds one shaft with bearings, gear body and end inertia.
    fn add_shaft(&self, assembly: &mut Assembly, index: usize) -> Result<ShaftNodes, ShaftError> {
        let shaft = &self.shafts[index];
        let gear_station = shaft.gear_position * shaft.span;
        let mut stations = vec![-shaft.overhang];
        if shaft.overhang > 0.0 {
            divide(&mut stations, 0.0, self.elements[0], "the overhang")?;
        }
        let first_bearing = stations.len() - 1;
        let body = drive::gear_body(&self.gears, &self.shafts, self.density, index)?;
        let hub = (body.hub)
            .map(|hub| HubEnds::new(hub, index + 1, gear_station, shaft.span))
            .transpose()?;
        divide(
            &mut stations,
            gear_station,
            self.elements[1],
            "the part from the first bearing to the gear",
        )?;
        if let Some(hub) = &hub {
            put_between(&mut stations, first_bearing, hub.start);
        }
        let gear = stations.len() - 1;
        divide(
            &mut stations,
            shaft.span,
            self.elements[2],
            "the part from the gear to the second bearing",
        )?;
        if let Some(hub) = &hub {
            put_between(&mut stations, gear, hub.end);
        }
        let second_bearing = stations.len() - 1;

        let material = Material {
            young_modulus: self.young_modulus,
            shear_modulus: self.shear_modulus,
            density: self.density,
        };
        assembly.turn(drive::turning(&self.gears, index, self.gyroscopic));
        let first = assembly.add_node();
        let mut torsion = None;
        for pair in stations.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let diameter = match &hub {
                Some(hub) if hub.start < middle && middle < hub.end => hub.diameter,
                _ => shaft.diameter,
            };
            let section = Section::hollow(diameter, shaft.inner_diameter)?;
            assembly.continue_shaft(pair, section, material, self.shear_coefficient)?;
            torsion.get_or_insert(Torsion {
                nodes: [first, first + 1],
                stiffness: self.shear_modulus * section.polar_moment() / (pair[1] - pair[0]),
            });
        }
        let [one, other] = [first_bearing, second_bearing].map(|station| first + station);
        let supports = [
            Support::add(assembly, one, None, shaft.bearings[0])?,
            Support::add(assembly, other, None, shaft.bearings[1])?,
        ];
        assembly.add_disc(first + gear, body.rigid)?;
        assembly.add_polar_inertia(first, shaft.end_inertia)?;
        assembly.add_drag(first, None, shaft.drag.viscous)?;
        Ok(ShaftNodes {
            end: first,
            gear: first + gear,
            supports,
            torsion,
        })
    }
}

/// Where along its shaft a hub is, from the first bearing on \[m\].
struct HubEnds {
    start: f64,
    end: f64,
    diameter: f64,
}

impl HubEnds {
    /// A hub about the gear's place. `number` of the shaft is 1 or 2.
    fn new(hub: Hub, number: usize, gear: f64, span: f64) -> Result<Self, ShaftError> {
        let [start, end] = [-0.5, 0.5].map(|side| gear + side * hub.length);
        let round_off = 8.0 * f64::EPSILON * span;
        if start < -round_off || end > span + round_off {
            return Err(ShaftError::HubBeyondBearings {
                shaft: number,
                length: hub.length,
                room: 2.0 * gear.min(span - gear),
            });
        }
        Ok(Self {
            start: start.max(0.0),
            end: end.min(span),
            diameter: hub.diameter,
        })
    }
}

/// Part of an element within which a hub's end takes an existing station with it instead of adding one:
/// much shorter elements than the others would only cost digits.
const NEAR: f64 = 0.25;

/// Makes a place a station, between those from `from` on: one that is near, but for the first and the last,
/// moves there, else it is added.
fn put_between(stations: &mut Vec<f64>, from: usize, place: f64) {
    let after = from + stations[from..].partition_point(|&station| station < place);
    if after >= stations.len() || stations[after] == place || after == from {
        return;
    }
    let near = NEAR * (stations[after] - stations[after - 1]);
    let last = stations.len() - 1;
    if place - stations[after - 1] < near && after - 1 > from {
        stations[after - 1] = place;
    } else if stations[after] - place < near && after < last {
        stations[after] = place;
    } else {
        stations.insert(after, place);
    }
}

/// Appends `count` equal steps from the last station to `to`.
fn divide(
    stations: &mut Vec<f64>,
    to: f64,
    count: usize,
    stretch: &'static str,
) -> Result<(), ShaftError> {
    if count == 0 {
        return Err(ShaftError::NoElement { stretch });
    }
    let from = stations[stations.len() - 1];
    for step in 1..=count {
        let fraction = step as f64 / count as f64;
        stations.push(from * (1.0 - fraction) + to * fraction);
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests;
