//! The parts of a train that its joints refer to: shafts and gears by name, and pairs of gears.

use super::shaft::pair_of;
use crate::gear::{Flanks, GearError, GearPair, InternalPair, Tooth, ToothForm};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::sections::gear;
use crate::shaft::{
    GearPlace, ParallelPlacement, PlanetarySet, TrainDrive, TrainError, TrainGear, TrainShaft,
};

/// Relative difference below which a centre distance equals the one without backlash.
pub(super) const TIGHT: f64 = 1e-9;

/// The parts that joints refer to.
pub(super) struct Parts<'a> {
    pub shafts: &'a [TrainShaft],
    /// Further drawing data of each gear, shaft by shaft.
    pub drawn: &'a [Vec<ToothForm>],
    /// Planets among the shafts, set by set.
    pub planets: &'a [Planets],
}

/// Gears of a mesh, and its index in `[[train.mesh]]`; `None` for the first mesh.
pub(super) type SunMesh = ([GearPlace; 2], Option<usize>);

/// Planets of a set, with their angles.
pub(super) struct Planets {
    pub set: PlanetarySet,
    /// Common name of the planets in the manifest.
    pub name: String,
    /// Angles from the first planet \[rad\].
    pub angles: Vec<f64>,
    /// Mesh of the planets with an external gear.
    pub sun: Option<SunMesh>,
}

impl Planets {
    /// The place of the first planet's gear.
    pub fn first(&self) -> Option<GearPlace> {
        let shaft = self.set.planets.first()?.shaft;
        Some(GearPlace { shaft, gear: 0 })
    }

    /// Whether the sun is the driving gear of its mesh with these planets; false without a sun.
    pub fn sun_drives(&self) -> bool {
        self.sun
            .is_some_and(|(gears, _)| Some(gears[1]) == self.first())
    }

    /// Whether `other` is `name`, the common name of planets, or `name` with a number.
    pub fn has_name(name: &str, other: &str) -> bool {
        let number = other.strip_prefix(name).map(str::trim);
        number.is_some_and(|number| number.is_empty() || number.parse::<u32>().is_ok())
    }
}

impl Parts<'_> {
    /// All shafts except planets, which come last and have numbered names.
    fn named(&self) -> &[TrainShaft] {
        let planet = self.planets.first().and_then(Planets::first);
        &self.shafts[..planet.map_or(self.shafts.len(), |first| first.shaft)]
    }

    /// A shaft by the name in a key.
    pub fn shaft(&self, section: &Section, key: &str) -> Option<usize> {
        let name = section.text(key)?;
        self.shaft_named(section, key, name)
    }

    /// The set with a planet of this name.
    fn set_of_planet(&self, name: &str) -> Option<&Planets> {
        let is_it = |shaft: usize| self.shafts[shaft].name == name;
        (self.planets.iter())
            .find(|planets| planets.set.planets.iter().any(|planet| is_it(planet.shaft)))
    }

    /// The set whose first planet is one of two gears.
    pub fn set_of(&self, gears: [GearPlace; 2]) -> Option<&Planets> {
        let has = |planets: &&Planets| planets.first().is_some_and(|first| gears.contains(&first));
        self.planets.iter().find(has)
    }

    /// The drawing of the mesh between a sun and these planets, if known.
    pub fn sun_pair(
        &self,
        section: &Section,
        train: &TrainDrive,
        planets: &Planets,
    ) -> Option<GearPair> {
        match planets.sun? {
            (_, None) => Some(train.pair.clone()),
            // The reader of that mesh reports its faults.
            (gears, _) => {
                let none = Issues::default();
                let drawing = self.drawing(&section.recording_in(&none), train, gears, "gears");
                drawing.map(|(pair, _)| pair)
            }
        }
    }

    /// The shaft that the motor drives, which must not be a planet.
    pub fn driver(&self, section: &Section) -> Option<usize> {
        let shaft = self.shaft(section, "driver")?;
        let named = self.named();
        if shaft < named.len() {
            return Some(shaft);
        }
        let name = &self.shafts[shaft].name;
        let known: Vec<&str> = named.iter().map(|shaft| shaft.name.as_str()).collect();
        let what = format!("`{name}` is one of the planets, and no motor drives one of them alone");
        unknown_name(section, "driver", "driver", what, &known)
            .remedy(
                "name the shaft of the sun, the ring or the carrier, or one that is coupled to it",
            )
            .fail(section.issues)
    }

    fn shaft_named(&self, section: &Section, key: &str, name: &str) -> Option<usize> {
        let index = self.shafts.iter().position(|shaft| shaft.name == name);
        if index.is_none() {
            let known: Vec<&str> = self.shafts.iter().map(|s| s.name.as_str()).collect();
            let what = format!("there is no shaft `{name}`");
            let unknown = unknown_name(section, key, "shaft", what, &known);
            unknown
                .suggestion(near(name, &known))
                .report(section.issues);
        }
        index
    }

    /// Two shafts by their names.
    pub fn shafts(&self, section: &Section) -> Option<[usize; 2]> {
        let [one, two] = section.texts("shafts", Some(2))?.try_into().ok()?;
        let one = self.shaft_named(section, "shafts", one);
        let two = self.shaft_named(section, "shafts", two);
        Some([one?, two?])
    }

    /// Two gears by their names. `None` after a reported fault: an unknown name, or gears that cannot mesh.
    pub fn gears(&self, section: &Section, key: &str) -> Option<[GearPlace; 2]> {
        let both: [&str; 2] = section.texts(key, Some(2))?.try_into().ok()?;
        let all = || {
            let shafts = self.named().iter().enumerate();
            shafts.flat_map(|(shaft, on)| {
                let gears = on.gears.iter().enumerate();
                gears.map(move |(gear, train_gear)| {
                    (train_gear.name.as_str(), GearPlace { shaft, gear })
                })
            })
        };
        let found = both.map(|name| {
            let planets = self.planets.iter().find(|planets| planets.name == name);
            let place = (all().find(|(candidate, _)| *candidate == name))
                .or_else(|| Some((name, planets?.first()?)));
            if place.is_none() {
                let common = self.planets.iter().map(|planets| planets.name.as_str());
                let known: Vec<&str> = all().map(|(name, _)| name).chain(common).collect();
                section.issues.push(match self.set_of_planet(name) {
                    Some(planets) => {
                        let what = format!("`{name}` is one of the planets, which mesh alike");
                        unknown_name(section, key, "gear", what, &known).remedy(format!(
                            "write \"{}\": it stands for every planet",
                            planets.name
                        ))
                    }
                    None => {
                        let what = format!("there is no gear `{name}`");
                        unknown_name(section, key, "gear", what, &known)
                            .suggestion(near(name, &known))
                    }
                });
            }
            place.map(|(_, place)| place)
        });
        let [one, two] = [found[0]?, found[1]?];
        let (a, b) = (
            &self.shafts[one.shaft].gears[one.gear],
            &self.shafts[two.shaft].gears[two.gear],
        );
        let mut remedy = "give both gears the same module, pressure angle and rack; a bare number is in m: write the unit, \
                          such as module = \"3 mm\"";
        let unlike = if one == two {
            remedy = "name two different gears";
            Some("it is the same gear twice".to_owned())
        } else if [one, two]
            .iter()
            .all(|gear_place| gear_place.shaft >= self.named().len())
        {
            let gears = [a, b].map(|gear| gear.name.trim_end_matches(" 1").to_owned());
            let error = TrainError::PlanetsMesh { gears };
            let fault = section.inconsistent(key, error.to_string());
            return fault.label("both are planets").fail(section.issues);
        } else if a.module != b.module {
            Some(format!(
                "their modules are {} m and {} m",
                a.module, b.module
            ))
        } else if a.pressure_angle != b.pressure_angle {
            Some("their pressure angles differ".to_owned())
        } else if a.helix_angle
            != if a.internal || b.internal { b.helix_angle } else { -b.helix_angle }
        {
            let hands = "external gears need opposite angles, a gear and its ring equal ones";
            remedy = "correct `helix_angle` of one gear";
            let degrees = |gear: &TrainGear| (1e6 * gear.helix_angle.to_degrees()).round() / 1e6;
            let [a, b] = [a, b].map(degrees);
            Some(format!(
                "their helix angles are {a} and {b} degrees, but {hands}"
            ))
        } else if self.drawn[one.shaft][one.gear].rack != self.drawn[two.shaft][two.gear].rack {
            Some("their racks differ".to_owned())
        } else {
            None
        };
        if let Some(why) = unlike {
            let message = format!("gears `{}` and `{}` cannot mesh: {why}", a.name, b.name);
            return section
                .inconsistent(key, message)
                .label("not a pair that meshes")
                .remedy(remedy)
                .fail(section.issues);
        }
        Some([one, two])
    }

    /// Two gears as a pair without backlash.
    pub fn pair(&self, places: [GearPlace; 2], rated_torque: f64) -> GearPair {
        let gears = places.map(|place| &self.shafts[place.shaft].gears[place.gear]);
        let [one, two] = places.map(|place| &self.drawn[place.shaft][place.gear]);
        let pair = pair_of(gears, rated_torque);
        let form = ToothForm {
            plane: gear::plane_of(pair.module, pair.face_width),
            ..ToothForm::of_each(one, two)
        };
        GearPair { form, ..pair }
    }

    /// A gear inside a ring as a pair with the gear first. `gears` has either order. `None` after a reported fault.
    pub fn ring(
        &self,
        section: &Section,
        train: &TrainDrive,
        gears: [GearPlace; 2],
    ) -> Option<(GearPair, InternalPair)> {
        let inside_out = if train.gear(gears[0]).internal { [gears[1], gears[0]] } else { gears };
        let [inner, ring] = inside_out.map(|place| train.gear(place));
        let drawn = inside_out.map(|place| &self.drawn[place.shaft][place.gear]);
        // The mesh with the sun has shortened the tips of planets.
        let planets = self.set_of(gears).filter(|planets| planets.sun_drives());
        let sun = planets.and_then(|planets| self.sun_pair(section, train, planets));
        let cut = sun.and_then(|sun| Tooth::tip_radius_of(&sun, 1).ok());
        let tips =
            [(inner, drawn[0], 1.0), (ring, drawn[1], -1.0)].map(|(gear, form, outwards)| {
                let addendum = gear.module * (form.rack.addendum + form.profile_shift[0]);
                let given = form.tip_diameter[0].map(|diameter| 0.5 * diameter);
                given.unwrap_or(gear.pitch_radius() + outwards * addendum)
            });
        let mut pair = self.pair(inside_out, train.pair.rated_torque);
        pair.form.tip_diameter = [cut.unwrap_or(tips[0]), tips[1]].map(|tip| Some(2.0 * tip));
        let fault = match train.parallel_placement(inside_out) {
            Ok(beside) => {
                pair.form.centre_distance = Some(0.0);
                if let Some(beside) = beside {
                    set_common_face(&mut pair, &beside);
                    pair.form.centre_distance = Some(beside.centre_distance);
                }
                let checked = InternalPair::of(&pair).and_then(|internal| {
                    internal.check()?;
                    Ok(internal)
                });
                match checked {
                    Ok(inside) => return Some((pair, inside)),
                    Err(error) => {
                        format!(
                            "gear `{}` cannot run in `{}`: {error}",
                            inner.name, ring.name
                        )
                    }
                }
            }
            Err(error) => error.to_string(),
        };
        section
            .inconsistent("gears", fault)
            .label("these gears at the positions of their shafts")
            .fail(section.issues)
    }

    /// The drawing of two gears on their axes, and whether the axes are parallel. Gears on other axes are bevel gears;
    /// their mesh is not checked. `None` after a reported fault.
    pub fn drawing(
        &self,
        section: &Section,
        train: &TrainDrive,
        gears: [GearPlace; 2],
        key: &str,
    ) -> Option<(GearPair, bool)> {
        let mut pair = self.pair(gears, train.pair.rated_torque);
        let refuse = |message: String| {
            section
                .inconsistent(key, message)
                .label("these gears at the positions of their shafts")
                .fail(section.issues)
        };
        let names = gears.map(|place| &train.gear(place).name);
        let beside = match train.parallel_placement(gears) {
            Ok(Some(beside)) => beside,
            Ok(None) if pair.helix_angle != 0.0 => {
                let [one, two] = names;
                return refuse(format!(
                    "gears `{one}` and `{two}` are helical, but their axes are not parallel: bevel gears are straight"
                ));
            }
            Ok(None) => return Some((pair, false)),
            Err(error) => return refuse(error.to_string()),
        };
        let distance = beside.centre_distance;
        set_common_face(&mut pair, &beside);
        let tight = pair.tight_centre_distance().ok();
        if tight.is_none_or(|tight| (distance / tight - 1.0).abs() > TIGHT) {
            pair.form.centre_distance = Some(distance);
        }
        match Flanks::new(&train.on_shafts(&pair, gears)) {
            Ok(_) | Err(GearError::NoBore { .. } | GearError::BodyRatio { .. }) => {
                Some((pair, true))
            }
            Err(error) => {
                let [one, two] = names;
                let millimetres = 1e3 * distance;
                refuse(format!(
                    "gears `{one}` and `{two}` cannot mesh with their axes {millimetres:.6} mm apart: {error}"
                ))
            }
        }
    }
}

/// Sets the common face of a pair's gears. Turns the lead of the second gear if the axes have opposite directions.
fn set_common_face(pair: &mut GearPair, beside: &ParallelPlacement) {
    pair.face_width = beside.width;
    pair.form.overhang = beside.overhang;
    pair.form.plane = gear::plane_of(pair.module, pair.face_width);
    if !beside.alike {
        pair.form.turn_lead(1);
    }
}

/// The fault of an unknown name.
fn unknown_name(
    section: &Section,
    key: &str,
    what: &str,
    message: String,
    known: &[&str],
) -> Diagnostic {
    section
        .fault(DiagnosticKind::OutOfRange, key, message)
        .label(format!("not a {what} of [train]"))
        .accepted(crate::manifest::schema::quoted(known))
}

fn near(name: &str, known: &[&str]) -> Option<String> {
    crate::manifest::schema::nearest(name, known).map(|near| format!("\"{near}\""))
}
