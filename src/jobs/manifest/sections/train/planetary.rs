//! The tables `[[train.planetary]]`: planets as rigid bodies, one shaft each, and the meshes that each has in common
//! with the first.

use super::parts::{Parts, Planets, SunMesh};
use super::rolling;
use super::shaft;
use crate::gear::ToothForm;
use crate::manifest::diagnostic::{DiagnosticKind, Issues};
use crate::manifest::reader::{Section, all_or_none};
use crate::shaft::{
    Bearing, Drag, GearPlace, Motion, Planet, PlanetarySet, TrainDrive, TrainError, TrainMesh,
    TrainShaft, phase_of_planet,
};
use std::f64::consts::TAU;

/// Largest rounding of a planet's angle, as a fraction of the angle between neighbouring possible positions.
const ROUNDED: f64 = 1e-3;

/// Adds the planets of all sets to the shafts, and returns the sets.
pub(super) fn read(
    section: &Section,
    density: f64,
    (shafts, drawn): (&mut Vec<TrainShaft>, &mut Vec<Vec<ToothForm>>),
) -> Option<Vec<Planets>> {
    let tables = section.tables("planetary")?;
    let names = names(&tables, section.issues, shafts)?;
    let mut planets = Vec::with_capacity(tables.len());
    let mut axis_distances = Vec::with_capacity(tables.len());
    let named = shafts.len();
    for table in &tables {
        if let Some((planet_set, axis_distance)) =
            set(table, density, (shafts, drawn), (named, &names))
        {
            planets.push(planet_set);
            axis_distances.push(axis_distance);
        }
    }
    if planets.len() < tables.len() {
        return None;
    }
    for (number, axis_distance) in axis_distances.into_iter().enumerate() {
        let parts = Parts {
            shafts: &*shafts,
            drawn: &*drawn,
            planets: &planets,
        };
        planets[number].sun = parts.sun_of(section, number)?;
        planets[number].place(section, (shafts, drawn), axis_distance)?;
    }
    Some(planets)
}

/// The common name of the planets of every set; names must differ between sets.
fn names(tables: &[Section], issues: &Issues, shafts: &[TrainShaft]) -> Option<Vec<String>> {
    let names = tables
        .iter()
        .map(|table| table.text("name").map(str::to_owned));
    let names = all_or_none(names)?;
    let of_shaft = |shaft: &TrainShaft| {
        let gears = shaft.gears.iter().map(|gear| gear.name.clone());
        gears.chain([shaft.name.clone()]).collect::<Vec<_>>()
    };
    let of_shafts: Vec<String> = shafts.iter().flat_map(of_shaft).collect();
    for (number, (table, name)) in tables.iter().zip(&names).enumerate() {
        let other = names[..number]
            .iter()
            .find(|other| Planets::has_name(name, other) || Planets::has_name(other, name));
        let taken = of_shafts
            .iter()
            .find(|taken_name| Planets::has_name(name, taken_name));
        let what = match (other, taken) {
            (Some(other), _) => format!(
                "two planetary sets call their planets `{other}` and `{name}`, so that single planets have one name"
            ),
            (None, Some(taken_name)) => {
                format!("a shaft or gear has the name `{taken_name}`, which is that of a planet")
            }
            (None, None) => continue,
        };
        return table
            .whole_fault(DiagnosticKind::Inconsistent, what)
            .label("names must differ")
            .remedy("give the planets another name, such as name = \"idler\"")
            .fail(issues);
    }
    Some(names)
}

/// Adds the planets of one set to the shafts, without positions. Returns the set, and the distance of the
/// planets from the axis \[m\] if it is given. The carrier is one of the first `named` shafts.
fn set(
    table: &Section,
    density: f64,
    (shafts, drawn): (&mut Vec<TrainShaft>, &mut Vec<Vec<ToothForm>>),
    (named, names): (usize, &[String]),
) -> Option<(Planets, Option<f64>)> {
    let carrier = carrier(table, (&shafts[..named], &drawn[..named]), names);
    let at = table.quantity("at");
    let angles = angles(table);
    let gear = shaft::planet(table, density);
    let width = gear.as_ref().map(|(gear, _)| gear.width);
    let bearing = bearing(table, width);
    let errors = table.if_given("pin_errors", |table, name| table.quantities(name, None));
    let axis_distance = table.if_given("radius", Section::quantity);
    let (carrier, at, angles, errors) = (carrier?, at?, angles?, errors?.unwrap_or_default());
    let (gear, drawing) = gear?;
    if !errors.is_empty() && errors.len() != angles.len() {
        let message = format!("{} pin errors for {} planets", errors.len(), angles.len());
        return table
            .inconsistent("pin_errors", message)
            .label("give one length per planet")
            .fail(table.issues);
    }
    let (bearing, axis_distance) = (bearing?, axis_distance?);
    let name = gear.name.clone();
    let tip_diameter = drawing.tip_diameter[0].unwrap_or_else(|| {
        let addendum = drawing.rack.addendum + drawing.profile_shift[0];
        2.0 * (gear.pitch_radius() + gear.module * addendum)
    });
    let first = shafts.len();
    for number in 1..=angles.len() {
        let name = format!("{name} {number}");
        shafts.push(TrainShaft {
            name: name.clone(),
            origin: [0.0; 3],
            direction: shafts[carrier].direction,
            sections: Vec::new(),
            element: None,
            motion: Motion::All,
            discs: Vec::new(),
            gears: vec![crate::shaft::TrainGear {
                name,
                ..gear.clone()
            }],
            bearings: Vec::new(),
            torque_at: 0.0,
            output: 0.0,
            drag: Drag::default(),
        });
        drawn.push(vec![drawing.clone()]);
    }
    let planets = (0..angles.len()).map(|number| Planet {
        shaft: first + number,
        pin_error: errors.get(number).copied().unwrap_or(0.0),
    });
    let set = PlanetarySet {
        carrier,
        at,
        planets: planets.collect(),
        bearing,
        tip_diameter,
    };
    let planets = Planets {
        set,
        name,
        angles,
        sun: None,
    };
    Some((planets, axis_distance))
}

/// The shaft with the pins, which must not be a planet of any set.
fn carrier(
    table: &Section,
    (shafts, drawn): (&[TrainShaft], &[Vec<ToothForm>]),
    names: &[String],
) -> Option<usize> {
    let planets = &[];
    let parts = Parts {
        shafts,
        drawn,
        planets,
    };
    let name = table.text("carrier")?;
    let known = shafts.iter().any(|shaft| shaft.name == name);
    if known
        || !names
            .iter()
            .any(|known_name| Planets::has_name(known_name, name))
    {
        return parts.shaft(table, "carrier");
    }
    let error = TrainError::CarrierIsPlanet {
        planet: name.to_owned(),
    };
    let fault = table.inconsistent("carrier", error.to_string());
    fault.label("this is a planet").fail(table.issues)
}

/// Angles of the planets from the first one \[rad\].
fn angles(table: &Section) -> Option<Vec<f64>> {
    if table.has("angles") {
        table.given_twice(&["count"], "angles", "give the number of planets");
        let angles = table.quantities("angles", None)?;
        if angles.is_empty() {
            let fault = table.inconsistent("angles", "a planetary set has no planets");
            return fault.label("give one angle per planet").fail(table.issues);
        }
        return Some(angles);
    }
    let count = table.integer("count")?;
    Some((0..count).map(|i| TAU * i as f64 / count as f64).collect())
}

/// The bearing of a planet of this width \[m\] on its pin.
fn bearing(table: &Section, width: Option<f64>) -> Option<Bearing> {
    let bearing_table = table.required_child("bearing")?;
    let rolling = rolling::read(&bearing_table, &["radial"]);
    let radial = match rolling {
        Some(None) => bearing_table.quantity("radial"),
        _ => Some(0.0),
    };
    let optional = |key: &str| bearing_table.if_given(key, Section::quantity);
    let [axial, tilt] = ["axial", "tilt"].map(optional);
    let (radial, width) = (radial?, width?);
    Some(Bearing {
        x: radial,
        y: radial,
        axial: axial?.unwrap_or(radial),
        // Tilt stiffness of a bearing as wide as the planet.
        tilt: tilt?.unwrap_or(radial * width * width / 12.0),
        rolling: rolling?,
        ..Bearing::default()
    })
}

impl Parts<'_> {
    /// The mesh of a set's planets with an external gear, the sun; the first one in the manifest. An inner `None`: no
    /// sun; an outer `None`: a key has faults.
    fn sun_of(&self, section: &Section, set: usize) -> Option<Option<SunMesh>> {
        let first = (self.gears(section, "gears")?, None);
        let tables = section.tables("mesh")?;
        let mut meshes = vec![first];
        for (number, table) in tables.iter().enumerate() {
            meshes.push((self.gears(table, "gears")?, Some(number)));
        }
        let planet = self.planets[set].first()?;
        let external = |gear: &GearPlace| !self.shafts[gear.shaft].gears[gear.gear].internal;
        Some(
            meshes
                .into_iter()
                .find(|(gears, _)| gears.contains(&planet) && gears.iter().all(external)),
        )
    }
}

impl Planets {
    /// Sets the origins of the planets' shafts, at a given distance from the axis of the carrier \[m\] or at the
    /// distance without backlash.
    fn place(
        &self,
        section: &Section,
        (shafts, drawn): (&mut [TrainShaft], &[Vec<ToothForm>]),
        axis_distance: Option<f64>,
    ) -> Option<()> {
        let parts = Parts {
            shafts: &*shafts,
            drawn,
            planets: &[],
        };
        let axis_distance = match axis_distance {
            Some(axis_distance) => axis_distance,
            None => match self.tight_distance(&parts) {
                Ok(axis_distance) => axis_distance,
                Err(error) => {
                    let message =
                        format!("the distance of the planets from the axis is unknown: {error}");
                    return section
                        .inconsistent("gears", message)
                        .label("these gears")
                        .remedy(format!("give `radius` of the planets `{}`", self.name))
                        .fail(section.issues);
                }
            },
        };
        let at = self.set.at;
        for (planet, &angle) in self.set.planets.iter().zip(&self.angles) {
            shafts[planet.shaft].origin =
                shafts[self.set.carrier].point_at_distance(at, axis_distance, angle);
        }
        Some(())
    }

    /// Distance of sun and planets without backlash.
    fn tight_distance(&self, parts: &Parts) -> Result<f64, String> {
        let Some((sun, _)) = self.sun else {
            return Err(format!(
                "no mesh joins `{}` and an external gear",
                self.name
            ));
        };
        let pair = parts.pair(sun, 1.0);
        pair.tight_centre_distance()
            .map_err(|error| error.to_string())
    }

    /// The meshes of the other planets of this set that correspond to `mesh`; empty unless `mesh` is one of the first
    /// planet. `train` contains only the meshes of the first planet of each set.
    pub fn meshes_of_other_planets(
        &self,
        train: &TrainDrive,
        set: usize,
        mesh: &TrainMesh,
    ) -> Result<Vec<TrainMesh>, TrainError> {
        let of_planet = |place: &GearPlace| Some(*place) == self.first();
        let Some(gear_place) = mesh.gears.iter().find(|place| !of_planet(place)) else {
            return Ok(Vec::new());
        };
        if !mesh.gears.iter().any(of_planet) || self.angles.len() == 1 {
            return Ok(Vec::new());
        }
        let read = train.meshes.iter().map(|mesh| mesh.gears);
        let central = train.central_teeth(set, std::iter::once(train.gears).chain(read));
        let sense = train.rolling_sense(*gear_place)?;
        let from = self.angles[0];
        let others = self.set.planets[1..].iter().zip(&self.angles[1..]);
        let gear = train.gear(*gear_place);
        Ok(others
            .map(|(planet, &angle)| {
                let place = GearPlace {
                    shaft: planet.shaft,
                    gear: 0,
                };
                let ahead = phase_of_planet(gear.teeth, sense, exact(central, angle - from));
                TrainMesh {
                    gears: mesh
                        .gears
                        .map(|gear_place| if of_planet(&gear_place) { place } else { gear_place }),
                    law: mesh.law.with_phase_lead(ahead),
                    pressure_angle: mesh.pressure_angle,
                }
            })
            .collect())
    }
}

/// The angle of a planet without its rounding, if a possible position between the teeth of the central gears is near.
/// Otherwise the angle itself.
fn exact(central: Option<[u32; 2]>, angle: f64) -> f64 {
    let Some([external, internal]) = central else {
        return angle;
    };
    let together = f64::from(external + internal);
    let place = angle / TAU * together;
    if (place - place.round()).abs() > ROUNDED {
        angle
    } else {
        TAU * place.round() / together
    }
}
