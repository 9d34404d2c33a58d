//! `[train]`: the names in it looked up, everything else read by one file a part.

mod joints;
mod planetary;
mod shaft;

use crate::gear::{Flanks, GearError, GearPair, InternalPair, ToothForm};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::slip;
use crate::manifest::tree::Value;
use crate::shaft::{GearPlace, TrainDrive, TrainError, TrainShaft};
use planetary::Planets;
use shaft::Drawn;

/// Parts of the motor's power add up to 1 within this.
const POWER: f64 = 1e-9;

/// A centre distance this near to the one without backlash, as a part of it, is that one.
const TIGHT: f64 = 1e-9;

/// What is known when joints are read.
pub(super) struct Parts<'a> {
    pub shafts: &'a [TrainShaft],
    /// What the drawing says of each gear beside, shaft by shaft.
    pub drawn: &'a [Vec<Drawn>],
    /// Planets among the shafts.
    planets: Option<&'a Planets>,
}

/// Reads the table; `[model]` says how the modes are damped.
pub(super) fn read(section: &Section, issues: &mut Issues) -> Option<TrainDrive> {
    let rated_torque = section.quantity(issues, "rated_torque");
    let young_modulus = section.quantity_or_default(issues, "young_modulus");
    let shear_modulus = section.quantity_or_default(issues, "shear_modulus");
    let density = section.quantity_or_default(issues, "density");
    let shear_coefficient = section.quantity_or_default(issues, "shear_coefficient");
    if !section.has("shaft") {
        section.missing(issues, "shaft");
    }
    let tables = section.tables(issues, "shaft")?;
    let (mut shafts, mut drawn) = shaft::read_all(&tables, issues, density?)?;
    let planets = planetary::read(section, issues, density?, (&mut shafts, &mut drawn))?;
    let parts = Parts {
        shafts: &shafts,
        drawn: &drawn,
        planets: planets.as_ref(),
    };
    let gears = parts.gears(section, issues, "gears");
    let couplings = joints::couplings(section, issues, &parts);
    let stops = joints::stops(section, issues, &parts);
    let driver = if section.has("driver") {
        parts.shaft(section, issues, "driver")
    } else {
        gears.map(|[first, _]| first.shaft)
    };
    check_outputs(section, issues, &shafts)?;
    let gears = gears?;
    let mut train = TrainDrive {
        gears,
        pair: parts.pair(gears, rated_torque?),
        meshes: Vec::new(),
        couplings: couplings?,
        stops: stops?,
        planetary: planets.as_ref().map(|planets| planets.set.clone()),
        driver: driver?,
        young_modulus: young_modulus?,
        shear_modulus: shear_modulus?,
        density: density?,
        shear_coefficient: shear_coefficient?,
        damping: 0.0,
        damping_overrides: Vec::new(),
        gyroscopic: false,
        shafts: shafts.clone(),
    };
    if gears.iter().any(|&gear| train.gear(gear).internal) {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of("gears"),
                &section.path_of("gears"),
                "the first mesh has an internal gear".to_owned(),
            )
            .label("both gears must be external")
            .remedy("name the mesh of the sun and a planet here, and the mesh of the ring in [[train.mesh]]"),
        );
        return None;
    }
    train.pair = parts.drawing(section, issues, &train, gears, "gears")?.0;
    train.meshes = joints::meshes(section, issues, &parts, &train)?;
    // What the parts are together shows in the layout; it costs nothing.
    if let Err(error) = train.check() {
        let fault = match error {
            TrainError::TooFine { place, .. } => too_fine(issues, &tables, &train, place, &error),
            _ => Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span,
                "train",
                error.to_string(),
            )
            .label("these shafts and gears do not form a train"),
        };
        issues.push(fault);
        return None;
    }
    Some(train)
}

/// The fault of a section of a shaft that takes too many elements, where its largest cause is: the longest element that
/// is given, a length that no shaft has, or the diameter.
fn too_fine(
    issues: &mut Issues,
    tables: &[Section],
    train: &TrainDrive,
    [shaft, section]: [usize; 2],
    error: &TrainError,
) -> Diagnostic {
    let own = &train.shafts[shaft].sections[section];
    let sections = tables[shaft].tables(issues, "sections");
    let long = slip::of_length(own.length, "length", slip::LENGTHS);
    let thin = slip::of_length(own.outer, "diameter", slip::DIAMETERS);
    let of_section = sections.as_ref().and_then(|all| all.get(section));
    let (table, key, slip) = match (of_section, train.shafts[shaft].element) {
        (Some(table), _) if long.is_some() => (table, "length", long),
        (Some(table), None) => (table, "outer", thin),
        _ => (&tables[shaft], "element", None),
    };
    let remedy =
        "lengthen the elements of the shaft (train.shaft.*.element), or merge thin sections";
    let fault = Diagnostic::new(
        DiagnosticKind::OutOfRange,
        table.span_of(key),
        &table.path_of(key),
        error.to_string(),
    );
    fault
        .label("too many elements")
        .accepted("elements and degrees of freedom of all shafts: at most 4000 each")
        .remedy(slip.map_or(remedy.to_owned(), |slip| format!("{remedy}; {slip}")))
}

fn check_outputs(section: &Section, issues: &mut Issues, shafts: &[TrainShaft]) -> Option<()> {
    let sum: f64 = shafts.iter().map(|shaft| shaft.output).sum();
    if sum == 0.0 || (sum - 1.0).abs() < POWER {
        return Some(());
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            section.span_of("shaft"),
            "train.shaft",
            format!("the `output` fractions of all shafts add up to {sum}"),
        )
        .label("must add up to 1, or all be 0")
        .remedy("give output = 1 to the shaft of the driven machine"),
    );
    None
}

impl Parts<'_> {
    /// A shaft by the name that stands as a value.
    pub fn shaft(&self, section: &Section, issues: &mut Issues, key: &str) -> Option<usize> {
        let name = section.text(issues, key)?;
        self.shaft_named(section, issues, key, name)
    }

    fn shaft_named(
        &self,
        section: &Section,
        issues: &mut Issues,
        key: &str,
        name: &str,
    ) -> Option<usize> {
        let found = self.shafts.iter().position(|shaft| shaft.name == name);
        if found.is_none() {
            let known: Vec<&str> = self.shafts.iter().map(|s| s.name.as_str()).collect();
            unknown_name(section, issues, key, ("shaft", name), &known);
        }
        found
    }

    /// Two shafts by their names.
    pub fn shafts(&self, section: &Section, issues: &mut Issues) -> Option<[usize; 2]> {
        let [one, two] = names(section, issues, "shafts")?;
        let one = self.shaft_named(section, issues, "shafts", one);
        let two = self.shaft_named(section, issues, "shafts", two);
        Some([one?, two?])
    }

    /// Two gears by their names.
    pub fn gears(
        &self,
        section: &Section,
        issues: &mut Issues,
        key: &str,
    ) -> Option<[GearPlace; 2]> {
        let both = names(section, issues, key)?;
        let all = || {
            let shafts = self.shafts.iter().enumerate();
            shafts.flat_map(|(shaft, on)| {
                let gears = on.gears.iter().enumerate();
                gears.map(move |(gear, own)| (own.name.as_str(), GearPlace { shaft, gear }))
            })
        };
        let found = both.map(|name| {
            let planets = self.planets.filter(|planets| planets.name == name);
            let place =
                (all().find(|(own, _)| *own == name)).or_else(|| Some((name, planets?.first()?)));
            if place.is_none() {
                let common = self.planets.map(|planets| planets.name.as_str());
                let known: Vec<&str> = all().map(|(name, _)| name).chain(common).collect();
                unknown_name(section, issues, key, ("gear", name), &known);
            }
            place.map(|(_, place)| place)
        });
        let [one, two] = [found[0]?, found[1]?];
        let (a, b) = (
            &self.shafts[one.shaft].gears[one.gear],
            &self.shafts[two.shaft].gears[two.gear],
        );
        let unlike = if one == two {
            Some("it is the same gear twice".to_owned())
        } else if a.module != b.module {
            Some(format!(
                "their modules are {} m and {} m",
                a.module, b.module
            ))
        } else if a.pressure_angle != b.pressure_angle {
            Some("their pressure angles differ".to_owned())
        } else {
            None
        };
        if let Some(why) = unlike {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    section.span_of(key),
                    &section.path_of(key),
                    format!("gears `{}` and `{}` cannot mesh: {why}", a.name, b.name),
                )
                .label("not a pair that meshes")
                .remedy("give both gears the same module and pressure angle; a bare number is in m: write the unit, \
                         such as module = \"3 mm\""),
            );
            return None;
        }
        Some([one, two])
    }

    /// Two gears as a pair at their reference centre distance.
    fn pair(&self, places: [GearPlace; 2], rated_torque: f64) -> GearPair {
        let gears = places.map(|place| &self.shafts[place.shaft].gears[place.gear]);
        let drawn = places.map(|place| self.drawn[place.shaft][place.gear]);
        GearPair {
            teeth: gears.map(|gear| gear.teeth),
            module: gears[0].module,
            pressure_angle: gears[0].pressure_angle,
            helix_angle: 0.0,
            face_width: gears[0].width.min(gears[1].width),
            body_length: gears.map(|gear| gear.width),
            rated_torque,
            form: ToothForm {
                profile_shift: drawn.map(|gear| gear.profile_shift),
                thinning: drawn.map(|gear| gear.thinning),
                ..ToothForm::default()
            },
        }
    }

    /// A gear and the ring around it on their axes, the gear being the first of both or the second.
    pub fn ring(
        &self,
        section: &Section,
        issues: &mut Issues,
        train: &TrainDrive,
        gears: [GearPlace; 2],
    ) -> Option<InternalPair> {
        let inside_out = if train.gear(gears[0]).internal { [gears[1], gears[0]] } else { gears };
        let [own, ring] = inside_out.map(|place| train.gear(place));
        let drawn = inside_out.map(|place| self.drawn[place.shaft][place.gear]);
        let fault = match train.centre_distance(gears) {
            Ok(distance) => {
                let pair = InternalPair {
                    teeth: [own.teeth, ring.teeth],
                    module: own.module,
                    pressure_angle: own.pressure_angle,
                    profile_shift: drawn.map(|gear| gear.profile_shift),
                    thinning: drawn.map(|gear| gear.thinning),
                    centre_distance: distance.unwrap_or_default(),
                };
                match pair.check() {
                    Ok(()) => return Some(pair),
                    Err(error) => {
                        format!("gear `{}` cannot run in `{}`: {error}", own.name, ring.name)
                    }
                }
            }
            Err(error) => error.to_string(),
        };
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of("gears"),
                &section.path_of("gears"),
                fault,
            )
            .label("these gears at the positions of their shafts"),
        );
        None
    }

    /// The drawing of two gears on their axes, and whether those are parallel: of others the
    /// geometry of spur gears does not hold.
    pub fn drawing(
        &self,
        section: &Section,
        issues: &mut Issues,
        train: &TrainDrive,
        gears: [GearPlace; 2],
        key: &str,
    ) -> Option<(GearPair, bool)> {
        let mut pair = self.pair(gears, train.pair.rated_torque);
        let mut refuse = |message: String| {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    section.span_of(key),
                    &section.path_of(key),
                    message,
                )
                .label("these gears at the positions of their shafts"),
            );
        };
        let names = gears.map(|place| &train.gear(place).name);
        let distance = match train.centre_distance(gears) {
            Ok(Some(distance)) => distance,
            Ok(None) => return Some((pair, false)),
            Err(error) => {
                refuse(error.to_string());
                return None;
            }
        };
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
                ));
                None
            }
        }
    }
}

fn unknown_name(
    section: &Section,
    issues: &mut Issues,
    key: &str,
    (what, name): (&str, &str),
    known: &[&str],
) {
    issues.push(
        Diagnostic::new(
            DiagnosticKind::OutOfRange,
            section.span_of(key),
            &section.path_of(key),
            format!("there is no {what} `{name}`"),
        )
        .label(format!("not a {what} of [train]"))
        .accepted(crate::manifest::schema::quoted(known))
        .suggestion(
            crate::manifest::schema::nearest(name, known).map(|near| format!("\"{near}\"")),
        ),
    );
}

/// Two names.
fn names<'t>(section: &Section<'t>, issues: &mut Issues, key: &str) -> Option<[&'t str; 2]> {
    let items = section.list(issues, key, Some(2))?;
    let texts: Vec<_> = (items.iter().enumerate())
        .map(|(i, item)| match &item.value {
            Value::Text(text) => Some(text.as_str()),
            _ => {
                let path = section.path_of(&format!("{key}.{i}"));
                crate::manifest::reader::wrong_type(issues, item, &path, section.spec(&path));
                None
            }
        })
        .collect();
    Some([texts[0]?, texts[1]?])
}
