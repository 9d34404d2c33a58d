//! The tables `[[train.mesh]]`, `[[train.coupling]]` and `[[train.stop]]`.

use super::Parts;
use super::shaft::{all, triple};
use crate::gear::{EvenSharing, GearPair};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::sections::contact_law;
use crate::model::{Division, MOST_CONTACTS};
use crate::shaft::{ShaftCoupling, Stop, TrainDrive, TrainMesh};
use crate::structure::ContactLaw;

/// Contacts that may stand beside the flanks of the first mesh.
const MOST: usize = MOST_CONTACTS - 2;

/// Further meshes of a train that is complete but for them.
pub(super) fn meshes(
    section: &Section,
    issues: &mut Issues,
    parts: &Parts,
    train: &TrainDrive,
) -> Option<Vec<TrainMesh>> {
    let meshes = all(section, issues, "mesh", |table, issues| {
        mesh(table, issues, parts, train)
    })?;
    let stages: usize = train.couplings.iter().map(|c| 2 * c.stages.len()).sum();
    let count = 2 * meshes.len() + stages + train.stops.len();
    if count > MOST {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::OutOfRange,
                section.span,
                "train",
                format!("the train has {count} contacts in addition to its first mesh"),
            )
            .label(format!(
                "at most {MOST} are accepted: two per mesh, two per stage, one per stop"
            ))
            .remedy("remove some, or combine stages that act as one"),
        );
        return None;
    }
    Some(meshes)
}

fn mesh(
    table: &Section,
    issues: &mut Issues,
    parts: &Parts,
    train: &TrainDrive,
) -> Option<TrainMesh> {
    let gears = parts.gears(table, issues, "gears");
    let friction = table.quantity_or_default(issues, "friction");
    let drawing = gears.and_then(|gears| parts.drawing(table, issues, train, gears, "gears"));
    let gap = match (table.has("half_gap"), &drawing) {
        (true, _) => table.quantity(issues, "half_gap"),
        (false, Some((pair, true))) => half_gap(table, issues, pair),
        (false, Some((_, false))) => {
            table.missing(issues, "half_gap");
            None
        }
        (false, None) => None,
    };
    let law = contact_law::cyclic(table, issues, gap);
    let (pair, parallel) = drawing?;
    let pressure_angle = if parallel {
        pair.operating_pressure_angle().ok()?
    } else {
        pair.pressure_angle
    };
    let (mut drive, mut divisions) = law?;
    let friction = friction?;
    if friction > 0.0 {
        divisions = sliding(table, issues, &pair, parallel)?.cut(&divisions);
        contact_law::take(&mut drive, &divisions, true);
    }
    let symmetry = match (table.has("coast_symmetry"), divisions.len()) {
        (true, _) => table.quantity(issues, "coast_symmetry")?,
        // Nothing depends on it.
        (false, 1) => 0.0,
        (false, _) => drawn_symmetry(table, issues, &pair, parallel)?,
    };
    let mut coast = ContactLaw {
        // Counted as the coast flanks' own deflection, which grows as that of the drive flanks
        // falls.
        error: (drive.error.iter())
            .map(|&(harmonic, amplitude, phase)| {
                (harmonic, amplitude, phase + std::f64::consts::PI)
            })
            .collect(),
        ..drive.clone()
    };
    let mirrored = Division::mirrored(&divisions, symmetry);
    contact_law::take(&mut coast, &mirrored, friction > 0.0);
    Some(TrainMesh {
        gears: gears?,
        pressure_angle,
        friction,
        flanks: [drive, coast],
    })
}

/// The half gap that the drawing leaves.
fn half_gap(table: &Section, issues: &mut Issues, pair: &GearPair) -> Option<f64> {
    let drawn = pair.drawn_half_gap().ok().flatten();
    if drawn.is_none() {
        table.missing(issues, "half_gap");
    }
    drawn
}

/// Where pairs slide over the mesh cycle: the drawing says it of axes that are parallel.
fn sliding(
    table: &Section,
    issues: &mut Issues,
    pair: &GearPair,
    parallel: bool,
) -> Option<EvenSharing> {
    let fault = match EvenSharing::new(pair) {
        Ok(pairs) if parallel => return Some(pairs),
        Ok(_) => {
            "friction reverses at the pitch point, which is unknown for bevel gears".to_owned()
        }
        Err(fault) => format!("the drawing does not determine the direction of sliding: {fault}"),
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            table.span_of("friction"),
            &table.path_of("friction"),
            fault,
        )
        .label("unknown direction")
        .remedy("set friction = 0"),
    );
    None
}

fn drawn_symmetry(
    table: &Section,
    issues: &mut Issues,
    pair: &GearPair,
    parallel: bool,
) -> Option<f64> {
    if let Some(symmetry) = pair.symmetry().ok().filter(|_| parallel) {
        return Some(symmetry);
    }
    table.missing(issues, "coast_symmetry");
    None
}

/// What joins shafts.
pub(super) fn couplings(
    section: &Section,
    issues: &mut Issues,
    parts: &Parts,
) -> Option<Vec<ShaftCoupling>> {
    all(section, issues, "coupling", |table, issues| {
        let shafts = parts.shafts(table, issues);
        let at = if table.has("at") {
            table.quantities(issues, "at", Some(2))
        } else {
            shafts.map(|[first, _]| vec![parts.shafts[first].length(), 0.0])
        };
        let stiffness =
            ["radial", "axial", "tilt", "twist"].map(|key| table.quantity_or_default(issues, key));
        let damping = table.quantity_or_default(issues, "damping");
        let stages = all(table, issues, "stages", contact_law::constant);
        let [radial, axial, tilt, twist] = stiffness;
        Some(ShaftCoupling {
            shafts: shafts?,
            at: at?.try_into().ok()?,
            stiffness: [radial?, axial?, tilt?, twist?],
            damping: damping?,
            stages: stages?,
        })
    })
}

/// What shafts may strike.
pub(super) fn stops(section: &Section, issues: &mut Issues, parts: &Parts) -> Option<Vec<Stop>> {
    all(section, issues, "stop", |table, issues| {
        let shaft = parts.shaft(table, issues, "shaft");
        let at = table.quantity(issues, "at");
        let direction = if table.has("direction") {
            triple(table, issues, "direction", [0.0; 3])
        } else {
            table.missing(issues, "direction");
            None
        };
        let law = contact_law::constant(table, issues);
        let direction = direction?;
        if direction == [0.0; 3] {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::OutOfRange,
                    table.span_of("direction"),
                    &table.path_of("direction"),
                    "the direction of a stop must not be 0".to_owned(),
                )
                .label("all three are 0"),
            );
            return None;
        }
        Some(Stop {
            shaft: shaft?,
            at: at?,
            direction,
            law: law?,
        })
    })
}
