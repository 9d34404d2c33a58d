//! The table `[train.planetary]`: planets as rigid bodies, one shaft each, and the meshes that each has like the first.

use super::parts::{Parts, Planets};
use super::rolling;
use super::shaft;
use crate::gear::ToothForm;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::shaft::{
    Bearing, Drag, GearPlace, Motion, Planet, PlanetarySet, TrainDrive, TrainMesh, TrainShaft,
    phase_of_planet,
};
use std::f64::consts::TAU;

/// Part of a tooth by which an angle of a planet may be rounded.
const ROUNDED: f64 = 1e-3;

/// Adds the planets to the shafts; `Some(None)` without any.
pub(super) fn read(
    section: &Section,
    issues: &mut Issues,
    density: f64,
    (shafts, drawn): (&mut Vec<TrainShaft>, &mut Vec<Vec<ToothForm>>),
) -> Option<Option<Planets>> {
    let table = match section.child(issues, "planetary") {
        Child::Absent => return Some(None),
        Child::Invalid => return None,
        Child::Present(table) => table,
    };
    let parts = Parts {
        shafts: &*shafts,
        drawn: &*drawn,
        planets: None,
    };
    let carrier = parts.shaft(&table, issues, "carrier");
    let at = table.quantity_or_default(issues, "at");
    let angles = angles(&table, issues);
    let gear = shaft::planet(&table, issues, density);
    let width = gear.as_ref().map(|(gear, _)| gear.width);
    let bearing = bearing(&table, issues, width);
    let errors = if table.has("pin_errors") {
        table.quantities(issues, "pin_errors", None)
    } else {
        Some(Vec::new())
    };
    let radius = if table.has("radius") {
        table.quantity(issues, "radius").map(Some)
    } else {
        Some(None)
    };
    let (carrier, at, angles, errors) = (carrier?, at?, angles?, errors?);
    let (gear, drawing) = gear?;
    if !errors.is_empty() && errors.len() != angles.len() {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                table.span_of("pin_errors"),
                &table.path_of("pin_errors"),
                format!("{} pin errors for {} planets", errors.len(), angles.len()),
            )
            .label("give one length per planet"),
        );
        return None;
    }
    let name = gear.name.clone();
    let taken = |own: &String| {
        let number = own.strip_prefix(&name).map(str::trim);
        number.is_some_and(|number| number.is_empty() || number.parse::<u32>().is_ok())
    };
    let names = |shaft: &TrainShaft| {
        let gears = shaft.gears.iter().map(|gear| gear.name.clone());
        gears.chain([shaft.name.clone()]).collect::<Vec<_>>()
    };
    if let Some(own) = shafts.iter().flat_map(names).find(taken) {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                table.span,
                "train.planetary",
                format!("a shaft or gear has the name `{own}`, which is that of a planet"),
            )
            .label("names must differ")
            .remedy("give the planets another name, such as name = \"idler\""),
        );
        return None;
    }
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
        bearing: bearing?,
        tip_diameter,
    };
    let mut planets = Planets { set, name, angles };
    planets.place(section, issues, (shafts, drawn), radius?)?;
    Some(Some(planets))
}

/// Angles of the planets from the first one \[rad\].
fn angles(table: &Section, issues: &mut Issues) -> Option<Vec<f64>> {
    if table.has("angles") {
        table.given_twice(issues, &["count"], "angles", "give the number of planets");
        return table.quantities(issues, "angles", None);
    }
    let count = table.integer(issues, "count")?;
    Some((0..count).map(|i| TAU * i as f64 / count as f64).collect())
}

/// The bearing of a planet of this width \[m\] on its pin.
fn bearing(table: &Section, issues: &mut Issues, width: Option<f64>) -> Option<Bearing> {
    let own = table.required_child(issues, "bearing")?;
    let rolling = rolling::read(&own, issues, &["radial"]);
    let radial = match rolling {
        Some(None) => own.quantity(issues, "radial"),
        _ => Some(0.0),
    };
    let mut optional = |key: &str| {
        if own.has(key) { own.quantity(issues, key).map(Some) } else { Some(None) }
    };
    let [axial, tilt] = ["axial", "tilt"].map(&mut optional);
    let (radial, width) = (radial?, width?);
    Some(Bearing {
        x: radial,
        y: radial,
        axial: axial?.unwrap_or(radial),
        // As of a bearing that is as wide as the planet.
        tilt: tilt?.unwrap_or(radial * width * width / 12.0),
        rolling: rolling?,
        ..Bearing::default()
    })
}

impl Planets {
    /// Puts the planets between the teeth, at a distance from the axis \[m\] that is given or leaves no backlash.
    fn place(
        &mut self,
        section: &Section,
        issues: &mut Issues,
        (shafts, drawn): (&mut [TrainShaft], &[Vec<ToothForm>]),
        radius: Option<f64>,
    ) -> Option<()> {
        let parts = Parts {
            shafts: &*shafts,
            drawn,
            planets: Some(self),
        };
        let gears = parts.gears(section, issues, "gears")?;
        let radius = match radius {
            Some(radius) => radius,
            None => match parts.pair(gears, 1.0).tight_centre_distance() {
                Ok(radius) => radius,
                Err(error) => {
                    issues.push(
                        Diagnostic::new(
                            DiagnosticKind::Inconsistent,
                            section.span_of("gears"),
                            &section.path_of("gears"),
                            format!(
                                "the distance of the planets from the axis is unknown: {error}"
                            ),
                        )
                        .label("these gears")
                        .remedy("give train.planetary.radius"),
                    );
                    return None;
                }
            },
        };
        let at = self.set.at;
        for (planet, &angle) in self.set.planets.iter().zip(&self.angles) {
            shafts[planet.shaft].origin = shafts[self.set.carrier].beside(at, radius, angle);
        }
        Some(())
    }

    /// The meshes of the other planets that a mesh of the first one stands for; `central` as of
    /// [`TrainDrive::central_teeth`].
    pub fn others(
        &self,
        train: &TrainDrive,
        mesh: &TrainMesh,
        central: Option<[u32; 2]>,
    ) -> Vec<TrainMesh> {
        let of_planet = |place: &GearPlace| Some(*place) == self.first();
        let Some(own) = mesh.gears.iter().find(|place| !of_planet(place)) else {
            return Vec::new();
        };
        if !mesh.gears.iter().any(of_planet) {
            return Vec::new();
        }
        let from = self.angles[0];
        let others = self.set.planets[1..].iter().zip(&self.angles[1..]);
        let gear = train.gear(*own);
        others
            .map(|(planet, &angle)| {
                let place = GearPlace {
                    shaft: planet.shaft,
                    gear: 0,
                };
                let sense = self.sense(train, *own);
                let ahead = phase_of_planet(gear.teeth, sense, exact(central, angle - from));
                TrainMesh {
                    gears: mesh
                        .gears
                        .map(|own| if of_planet(&own) { place } else { own }),
                    law: mesh.law.ahead(ahead),
                    pressure_angle: mesh.pressure_angle,
                }
            })
            .collect()
    }

    /// The sense in which a central gear rolls on the planets, where the first gear of the train rolls forwards.
    fn sense(&self, train: &TrainDrive, central: GearPlace) -> f64 {
        let forwards = |internal: bool| if internal { 1.0 } else { -1.0 };
        let first = train.gears[0];
        let planets = if Some(first) == self.first() {
            1.0
        } else {
            forwards(train.gear(first).internal)
        };
        planets * forwards(train.gear(central).internal)
    }
}

/// An angle without its rounding, where it is that of a place between these teeth.
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
