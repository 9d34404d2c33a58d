//! The half gap of `[mesh]`: given, or computed from the drawing of the gears.

use crate::gear::GearPair;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::manifest::spec::{StiffnessSpec, StructureSource};

/// The keys for the half gap, of which a mesh has at most one.
const KEYS: [&str; 3] = ["half_gap", "normal_backlash", "circumferential_backlash"];

/// Relative difference from the drawing that counts as rounding of the given number.
const ROUNDED: f64 = 0.01;

/// Upper bound of a half gap, as a fraction of the base pitch: a tooth and its space have one half each.
const OF_BASE_PITCH: f64 = 0.25;

/// Upper bound of a half gap without a drawing, as a multiple of the mesh deflection under the rated force. Drives have
/// 1 to 1000.
const OF_DEFLECTION: f64 = 1e5;

/// Other parts of the drive that the reader of a mesh needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeshContext<'a> {
    /// The drawing, with known bores.
    pub gears: Option<&'a GearPair>,
    /// The drawing has faults, which have been reported.
    pub faulty_drawing: bool,
    /// Source of the structure; `None` if it has faults, which have been reported.
    pub source: Option<&'a StructureSource>,
}

/// The half gap \[m\], from the only key that gives it or from the drawing.
pub(super) fn read(section: &Section, mesh_context: MeshContext<'_>) -> Option<f64> {
    let drawn = mesh_context
        .gears
        .and_then(|gears| gears.drawn_half_gap().ok()?);
    let given: Vec<&str> = KEYS.into_iter().filter(|key| section.has(key)).collect();
    let Some((&key, others)) = given.split_first() else {
        if drawn.is_none() && !mesh_context.faulty_drawing {
            section.missing(KEYS[0]);
        }
        return drawn;
    };
    for other in others {
        let message = format!("`mesh.{key}` and `mesh.{other}` both give the backlash");
        section
            .inconsistent(other, message)
            .label("given twice")
            .remedy("keep one of them")
            .report(section.issues);
    }
    let value = section.quantity(key)?;
    let half_gap = match key {
        "half_gap" => value,
        "normal_backlash" => 0.5 * value / normal(mesh_context.gears),
        _ => 0.5 * value * along_line_of_action(section, key, mesh_context)?,
    };
    match drawn {
        Some(drawn) if (half_gap - drawn).abs() > ROUNDED * drawn => {
            let normal = 2.0 * drawn * normal(mesh_context.gears);
            contradiction(section, key, half_gap, [drawn, normal]);
            None
        }
        _ => others.is_empty().then_some(half_gap),
    }
}

/// The drawing with its thinning changed to give `mesh.half_gap`, if the drawing has backlash. [`read`]
/// reports faults of the key.
pub(super) fn thinned(section: &Section, gears: GearPair) -> GearPair {
    let drawn = gears.drawn_half_gap().ok().flatten();
    let given = section
        .entry(KEYS[0])
        .and_then(|_| section.quantity(KEYS[0]));
    (drawn.and(given))
        .and_then(|half_gap| gears.with_half_gap(half_gap).ok())
        .unwrap_or(gears)
}

/// Ratio of the normal backlash to the backlash along the line of action in the transverse section, `cos β_b`.
fn normal(gears: Option<&GearPair>) -> f64 {
    gears.map_or(1.0, |gears| gears.base_helix_angle().cos())
}

/// Ratio of the backlash along the line of action to the circumferential one, `cos α_w`.
fn along_line_of_action(
    section: &Section,
    key: &str,
    mesh_context: MeshContext<'_>,
) -> Option<f64> {
    if let Some(gears) = mesh_context.gears {
        return gears.operating_pressure_angle().ok().map(f64::cos);
    }
    if !mesh_context.faulty_drawing {
        let message =
            format!("`mesh.{key}` needs the operating pressure angle, but there is no [gear]");
        section
            .inconsistent(key, message)
            .label("unknown pitch circle")
            .remedy("give mesh.normal_backlash, which is normal to the flanks")
            .report(section.issues);
    }
    None
}

fn contradiction(section: &Section, key: &str, half_gap: f64, [drawn, normal]: [f64; 2]) {
    let microns = |metres: f64| format!("{:.4} um", 1e6 * metres);
    let message = format!(
        "`mesh.{key}` gives a half gap of {}, but thinning and centre distance of [gear] give a \
                 normal backlash of {}, a half gap of {}",
        microns(half_gap),
        microns(normal),
        microns(drawn)
    );
    let remedy = format!(
        "remove mesh.{key} to use the half gap of the drawing, or correct gear.thinning and gear.centre_distance"
    );
    section
        .inconsistent(key, message)
        .label("contradicts the drawing")
        .remedy(remedy)
        .report(section.issues);
}

/// Checks that the teeth have room for the half gap. A half gap that is too large is usually given in metres
/// instead of microns.
pub(super) fn check_scale(
    section: &Section,
    mesh_context: MeshContext<'_>,
    half_gap: f64,
    stiffness: &StiffnessSpec,
) -> Option<()> {
    let rated_force = mesh_context.source.and_then(StructureSource::rated_force);
    let (most, what) = match (mesh_context.gears, rated_force, stiffness.mean()) {
        (Some(gears), ..) => {
            let pitch = 2.0 * std::f64::consts::PI * gears.base_radii()[0];
            let most = OF_BASE_PITCH * pitch / f64::from(gears.teeth[0]);
            (most, "a quarter of the base pitch of [gear]".to_owned())
        }
        (None, Some(force), Some(mean)) => {
            let most = OF_DEFLECTION * force / mean;
            let what = format!("{OF_DEFLECTION:e} times the mesh deflection under the rated force");
            (most, what)
        }
        _ => return Some(()),
    };
    if half_gap < most {
        return Some(());
    }
    let key = KEYS.into_iter().find(|key| section.has(key));
    let key = key.unwrap_or(KEYS[0]);
    let message =
        format!("a half gap of {half_gap} m is out of range, because {what} is {most:.3e} m");
    section
        .fault(DiagnosticKind::OutOfRange, key, message)
        .label(format!("the half gap must be less than {most:.3e} m"))
        .remedy("a bare number is in metres; write the unit, such as \"15 um\"")
        .fail(section.issues)
}
