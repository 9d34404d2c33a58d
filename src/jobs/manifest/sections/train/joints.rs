//! The tables `[[train.mesh]]`, `[[train.coupling]]` and `[[train.stop]]`.

use super::no_train;
use super::parts::{Parts, Planets, TIGHT};
use crate::gear::{EvenSharing, Flanks, GearPair, InternalPair, MeshTableSpec};
use crate::manifest::diagnostic::{DiagnosticKind, Issues};
use crate::manifest::reader::{Section, all_of};
use crate::manifest::schema::OF_MESH;
use crate::manifest::sections::excitation::errors_of_gears;
use crate::manifest::sections::{contact_law, drawn_mesh};
use crate::model::{Division, MOST_CONTACTS, MeshHarmonic};
use crate::shaft::{
    DrawnLaw, GearPlace, Hysteresis, MeshLaw, ShaftCoupling, Stage, Stop, TrainDrive, TrainError,
    TrainMesh,
};
use crate::structure::SliderPart;
use std::f64::consts::TAU;

/// Keys of meshes from the drawing.
const OF_DRAWING: [&str; 6] = [
    "misalignment",
    "shaft_tilt",
    "contact",
    "face",
    "resolution",
    "segments",
];

/// Keys of meshes with a given stiffness.
const OF_NUMBERS: [&str; 3] = ["stiffness", "levels", "stiffness_harmonics"];

/// Largest number of contacts beside the flanks of the first mesh.
const MOST_FURTHER_CONTACTS: usize = MOST_CONTACTS - 2;

/// Checks that no two gears mesh twice.
fn given_once(section: &Section, first: [GearPlace; 2], read: &[TrainMesh]) -> Option<()> {
    let tables = section.tables("mesh")?;
    let same_mesh = |a: [GearPlace; 2], b: [GearPlace; 2]| a == b || a == [b[1], b[0]];
    for (number, (table, mesh)) in tables.iter().zip(read).enumerate() {
        let earlier = read[..number].iter().map(|other| other.gears);
        if std::iter::once(first)
            .chain(earlier)
            .any(|other| same_mesh(other, mesh.gears))
        {
            let what = "these gears already mesh in `train.gears` or in another [[train.mesh]]";
            return table
                .inconsistent("gears", what)
                .label("given twice")
                .remedy("remove one of both")
                .fail(table.issues);
        }
    }
    Some(())
}

/// Further meshes of a train that is otherwise complete. A mesh of the first planet becomes the meshes of all planets.
pub(super) fn meshes(
    section: &Section,
    parts: &Parts,
    train: &TrainDrive,
) -> Option<Vec<TrainMesh>> {
    let read = section.each("mesh", |table| mesh((section, table), parts, train))?;
    given_once(section, train.gears, &read)?;
    // The rolling of central gears is known once every set has the meshes of its first planet.
    let draft = TrainDrive {
        meshes: read.clone(),
        ..train.clone()
    };
    let others = |mesh: &TrainMesh| -> Result<Vec<TrainMesh>, TrainError> {
        let sets = parts.planets.iter().enumerate();
        let all = sets.map(|(set, planets)| planets.meshes_of_other_planets(&draft, set, mesh));
        Ok(all.collect::<Result<Vec<_>, _>>()?.concat())
    };
    let first = TrainMesh {
        gears: train.gears,
        pressure_angle: train.pair.operating_pressure_angle().ok()?,
        law: MeshLaw::OfFirst { phase: 0.0 },
    };
    let with_others = || -> Result<Vec<TrainMesh>, TrainError> {
        let mut meshes = others(&first)?;
        for mesh in &read {
            meshes.push(mesh.clone());
            meshes.extend(others(mesh)?);
        }
        Ok(meshes)
    };
    let meshes = match with_others() {
        Ok(meshes) => meshes,
        Err(error) => return no_train(section, &error).fail(section.issues),
    };
    let stages = train.couplings.iter().flat_map(|coupling| &coupling.stages);
    let stages: usize = stages.map(Stage::contacts).sum();
    let count =
        2 * meshes.len() + stages + SliderPart::ALL.len() * train.sliders() + train.stops.len();
    if count > MOST_FURTHER_CONTACTS {
        let message = format!("the train has {count} contacts in addition to its first mesh");
        let label = format!(
            "at most {MOST_FURTHER_CONTACTS} are accepted: two per mesh, one per side of a stage, three per hysteresis element, one per stop"
        );
        return section
            .whole_fault(DiagnosticKind::OutOfRange, message)
            .label(label)
            .remedy("remove some, or combine stages that act as one")
            .fail(section.issues);
    }
    Some(meshes)
}

/// The known drawing of a mesh.
enum Drawing {
    /// External gears, and whether their axes are parallel.
    Pair(Box<GearPair>, bool),
    /// A gear in a ring, and whether the gear drives.
    Ring(Box<GearPair>, InternalPair, bool),
}

impl Drawing {
    /// The half gap from the drawing; `None` if there is none, or the drawing does not determine it.
    fn half_gap(&self) -> Option<f64> {
        match self {
            Self::Pair(_, false) => None,
            Self::Pair(pair, true) => pair.drawn_half_gap().ok().flatten(),
            Self::Ring(_, pair, _) => pair
                .half_gap()
                .ok()
                .filter(|gap| *gap > TIGHT * pair.module),
        }
    }

    fn pressure_angle(&self) -> Option<f64> {
        match self {
            Self::Pair(pair, false) => Some(pair.pressure_angle),
            Self::Pair(pair, true) => pair.operating_pressure_angle().ok(),
            Self::Ring(_, pair, _) => pair.operating_pressure_angle().ok(),
        }
    }

    /// The mesh phase about which the coast flanks mirror the drive flanks, in cycles.
    fn symmetry(&self) -> Option<f64> {
        match self {
            Self::Pair(pair, true) => pair.symmetry().ok(),
            Self::Ring(_, pair, true) => pair.symmetry().ok(),
            Self::Pair(_, false) | Self::Ring(_, _, false) => None,
        }
    }
}

fn mesh(
    (section, table): (&Section, &Section),
    parts: &Parts,
    train: &TrainDrive,
) -> Option<TrainMesh> {
    let gears = parts.gears(table, "gears");
    let friction = table.quantity("friction");
    let drawing = gears.and_then(|gears| {
        if gears.iter().any(|&gear| train.gear(gear).internal) {
            let drives = !train.gear(gears[0]).internal;
            let (pair, ring) = parts.ring(table, train, gears)?;
            return Some(Drawing::Ring(Box::new(pair), ring, drives));
        }
        let (pair, parallel) = parts.drawing(table, train, gears, "gears")?;
        Some(Drawing::Pair(Box::new(pair), parallel))
    });
    let gap = if table.has("half_gap") {
        table.quantity("half_gap")
    } else if let Some(drawing) = &drawing {
        let drawn = drawing.half_gap();
        if drawn.is_none() {
            table.missing("half_gap");
        }
        drawn
    } else {
        None
    };
    let law = drawn_or_given(table, (train, gears), drawing.as_ref());
    let undrawn_properties = contact_law::properties_except_stiffness(table, gap);
    let errors = gear_errors(table, parts, (train, gears));
    let (drawing, law) = (drawing?, law?);
    let mut undrawn_properties = undrawn_properties?;
    let planets = gears.and_then(|gears| parts.set_of(gears));
    let planets = planets.filter(|set| set.sun_drives() && !table.has("phase"));
    if let (Drawing::Ring(_, ring, true), Some(planets)) = (&drawing, planets) {
        let sun = parts.sun_pair(section, train, planets);
        let ring_phase = sun.and_then(|sun| phase_of_ring(&sun, ring)).unwrap_or(0.0);
        undrawn_properties.phase = ring_phase + phase_of_sun(section, planets);
    }
    let phase = undrawn_properties.phase;
    let earlier = |cycles: f64| {
        move |harmonic: MeshHarmonic| {
            harmonic.with_phase_lead(-TAU * harmonic.turns_per_cycle() * cycles)
        }
    };
    let [orders, deviations] = errors?;
    // The first tooth engages at the start of the cycle that runs at time 0.
    let deviations = deviations.into_iter().map(earlier(phase.floor()));
    let error = &mut undrawn_properties.error;
    error.extend(orders.into_iter().map(earlier(phase)).chain(deviations));
    let friction = friction?;
    let steady = matches!(&law, Stiffness::Given(divisions) if divisions.len() == 1);
    let symmetry = if table.has("coast_symmetry") {
        table.quantity("coast_symmetry")?
    } else if steady && friction == 0.0 {
        // Nothing depends on the phase of symmetry.
        0.0
    } else {
        let drawn = drawing.symmetry();
        if drawn.is_none() {
            table.missing("coast_symmetry");
        }
        drawn?
    };
    let law = match law {
        Stiffness::Drawn(spec, misalignment) => MeshLaw::Drawn(Box::new(DrawnLaw {
            table: *spec,
            misalignment,
            friction,
            symmetry,
            undrawn_properties,
        })),
        Stiffness::Given(mut divisions) => {
            if friction > 0.0 {
                divisions = sliding(table, &drawing)?.cut(&divisions);
            }
            MeshLaw::Own(Box::new(
                undrawn_properties.on_both_flanks(&divisions, friction, symmetry),
            ))
        }
    };
    Some(TrainMesh {
        gears: gears?,
        pressure_angle: drawing.pressure_angle()?,
        law,
    })
}

/// Errors that rotate with the two gears of a mesh, as in [`errors_of_gears`].
fn gear_errors(
    table: &Section,
    parts: &Parts,
    (train, gears): (&TrainDrive, Option<[GearPlace; 2]>),
) -> Option<[Vec<MeshHarmonic>; 2]> {
    let teeth = gears.map(|gears| gears.map(|gear| Some(train.gear(gear).teeth)));
    let errors = errors_of_gears(table, ("gear", OF_MESH), teeth)?;
    let gears = gears?;
    if parts.set_of(gears).is_some() && errors.iter().any(|errors| !errors.is_empty()) {
        let key = if table.has("gear_error") { "gear_error" } else { "pitch_deviation" };
        let what = "errors of single gears are not possible in meshes of planets";
        return table
            .fault(DiagnosticKind::Unavailable, key, what)
            .label("all planets share this mesh")
            .remedy("remove it")
            .fail(table.issues);
    }
    Some(errors)
}

/// The source of a mesh's stiffness.
enum Stiffness {
    Given(Vec<Division>),
    /// From the drawing, under a misalignment \[rad\].
    Drawn(Box<MeshTableSpec>, f64),
}

/// The stiffness of a mesh from the keys of its law.
fn drawn_or_given(
    table: &Section,
    (train, gears): (&TrainDrive, Option<[GearPlace; 2]>),
    drawing: Option<&Drawing>,
) -> Option<Stiffness> {
    let law = table.choice("law")?;
    if law == "given" {
        let why = "with law = \"given\"";
        table.without_effect(&OF_DRAWING, why, "remove it, or set law = \"table\"");
        return contact_law::stiffness(table).map(Stiffness::Given);
    }
    let why = "because the drawing of the gears gives the stiffness";
    table.without_effect(&OF_NUMBERS, why, "remove it, or set law = \"given\"");
    let refuse = |key: &str, message: &str, accepted: &str| {
        table
            .fault(DiagnosticKind::Unavailable, key, message)
            .label("not available for this mesh")
            .accepted(accepted)
            .fail(table.issues)
    };
    let pair = match drawing? {
        Drawing::Pair(pair, true) => train.on_shafts(pair, gears?),
        Drawing::Pair(_, false) => {
            return refuse("law", "bevel gears have no mesh table", "law = \"given\"");
        }
        Drawing::Ring(pair, _, true) => {
            let pair = train.on_shafts(pair, gears?);
            if let Err(error) = Flanks::new(&pair) {
                let message =
                    format!("the mesh of this gear in its ring cannot be computed: {error}");
                return refuse("law", &message, "law = \"given\"");
            }
            pair
        }
        Drawing::Ring(_, _, false) => {
            return refuse(
                "law",
                "a ring that is named first drives, and has no mesh table",
                "name the gear inside first, or set law = \"given\"",
            );
        }
    };
    if table.choice("resolution")? == "pairs" {
        let only = "only the first mesh can have springs of pairs";
        return refuse(
            "resolution",
            only,
            "resolution = \"secant\" or \"mean_load\"",
        );
    }
    let misalignment = table.quantity("misalignment");
    let continuous = law == "continuous";
    let spec = drawn_mesh::of_drawing(table, Some(&pair), continuous, Some(None));
    Some(Stiffness::Drawn(Box::new(spec??), misalignment?))
}

/// Phase of the mesh of a sun and its first planet, as given in the table of this mesh; 0 if it is not given.
fn phase_of_sun(section: &Section, planets: &Planets) -> f64 {
    let none = Issues::default();
    let number = planets.sun.and_then(|(_, number)| number);
    let phase = number.and_then(|number| {
        let tables = section.recording_in(&none).tables("mesh")?;
        let table = tables.get(number).filter(|table| table.has("phase"))?;
        table.quantity("phase")
    });
    phase.unwrap_or(0.0)
}

/// Phase of the ring's mesh with the first planet, relative to the mesh of a driving sun with this planet.
///
/// The sun drives with the leading flank of its tooth, so the backlash is behind this tooth. A space of the planet is
/// therefore on the line of centres later than the sun's tooth, by the time for half the backlash. The ring is on the
/// opposite side of the planet, half a turn farther. If the planet has an even number of teeth, a space is there at
/// this time, otherwise a tooth.
fn phase_of_ring(sun: &GearPair, ring: &InternalPair) -> Option<f64> {
    let space = sun.tooth_phase().ok()? + 0.5 * sun.action_backlash().ok()? / sun.base_pitch();
    let tooth = if sun.teeth[1].is_multiple_of(2) { space + 0.5 } else { space };
    Some((ring.tooth_phase().ok()? - tooth).rem_euclid(1.0))
}

/// Sliding of pairs over the mesh cycle. The drawing determines it for gears on parallel axes, unless a ring drives.
fn sliding(table: &Section, drawing: &Drawing) -> Option<EvenSharing> {
    let fault = match drawing {
        Drawing::Ring(_, _, false) => {
            "friction in a ring that is named first is not modelled".to_owned()
        }
        Drawing::Pair(_, false) => {
            "friction reverses at the pitch point, which is unknown for bevel gears".to_owned()
        }
        Drawing::Pair(pair, true) | Drawing::Ring(pair, _, true) => match EvenSharing::new(pair) {
            Ok(pairs) => return Some(pairs),
            Err(fault) => {
                format!("the drawing does not determine the direction of sliding: {fault}")
            }
        },
    };
    table
        .inconsistent("friction", fault)
        .label("unknown direction")
        .remedy("set friction = 0")
        .fail(table.issues)
}

/// The couplings between shafts.
pub(super) fn couplings(section: &Section, parts: &Parts) -> Option<Vec<ShaftCoupling>> {
    section.each("coupling", |table| {
        let shafts = parts.shafts(table);
        let at = if table.has("at") {
            table.quantities("at", Some(2))
        } else {
            shafts.map(|[first, _]| vec![parts.shafts[first].length(), 0.0])
        };
        let stiffness = ["radial", "axial", "tilt", "twist"].map(|key| table.quantity(key));
        let damping = table.quantity("damping");
        let stages = table.each("stages", stage);
        let hysteresis = table.each("hysteresis", |table| {
            all_of!(Hysteresis {
                stiffness: table.quantity("stiffness"),
                limit: table.quantity("limit"),
            })
        });
        let [radial, axial, tilt, twist] = stiffness;
        Some(ShaftCoupling {
            shafts: shafts?,
            at: at?.try_into().ok()?,
            stiffness: [radial?, axial?, tilt?, twist?],
            damping: damping?,
            stages: stages?,
            hysteresis: hysteresis?,
        })
    })
}

fn stage(table: &Section) -> Option<Stage> {
    all_of!(Stage {
        side: table.variant("side"),
        law: contact_law::constant(table),
    })
}

/// The stops of shafts.
pub(super) fn stops(section: &Section, parts: &Parts) -> Option<Vec<Stop>> {
    section.each("stop", |table| {
        let shaft = parts.shaft(table, "shaft");
        let at = table.quantity("at");
        let direction = table.triple("direction");
        let law = contact_law::constant(table);
        let direction = direction?;
        if direction == [0.0; 3] {
            let message = "the direction of a stop must not be 0";
            return table
                .fault(DiagnosticKind::OutOfRange, "direction", message)
                .label("all three are 0")
                .fail(table.issues);
        }
        Some(Stop {
            shaft: shaft?,
            at: at?,
            direction,
            law: law?,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::ToothForm;

    /// The planet touches the sun and the ring at the same positions for every thickness of the sun's teeth.
    #[test]
    fn the_phase_of_a_helical_ring_is_that_of_any_thickness_of_the_sun() {
        let drawn = |teeth, form| GearPair {
            teeth,
            module: 2e-3,
            pressure_angle: 20f64.to_radians(),
            helix_angle: 20f64.to_radians(),
            face_width: 20e-3,
            body_length: [20e-3; 2],
            rated_torque: 50.0,
            form,
        };
        let form = ToothForm {
            ring: Some(0.25),
            ..ToothForm::default()
        };
        let ring = InternalPair::of(&drawn([36, 96], form)).unwrap();
        let phase = |thinning: f64| {
            let form = ToothForm {
                thinning: [thinning, 0.0],
                ..ToothForm::default()
            };
            phase_of_ring(&drawn([24, 36], form), &ring).unwrap()
        };
        let off = phase(0.2e-3) - phase(0.0);
        assert!((off - off.round()).abs() < 1e-12, "{off}");
    }
}
