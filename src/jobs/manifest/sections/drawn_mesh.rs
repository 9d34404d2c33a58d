//! Meshes computed from the drawing of their gears: the keys of mesh tables, in `[mesh]` and in further meshes of a
//! train.

use super::backlash::MeshContext;
use crate::gear::{Contact, CycleDivision, FaceLaw, Flanks, GearPair, MeshTableSpec, StiffnessLaw};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind};
use crate::manifest::reader::Section;
use crate::manifest::spec::{StiffnessSpec, StructureSource};
use crate::manifest::tree::Value;
use crate::model::SEVERAL_CONTACTS;
use std::sync::Arc;

/// Stiffness from the drawing of the gears, which must mesh.
pub(super) fn read(
    section: &Section,
    mesh_context: MeshContext<'_>,
    misalignment: Option<f64>,
) -> Option<StiffnessSpec> {
    let gears = mesh_context.gears;
    let continuous = section.has("stiffness")
        && matches!(section.entry("stiffness")?.node.value, Value::Text(ref text) if text == "continuous");
    let law = if continuous { "continuous" } else { "table" };
    section.without_effect(
        &[
            "mean_stiffness",
            "contact_ratio",
            "single_pair_drop",
            "values",
        ],
        &format!("with stiffness = \"{law}\": the drawing of the gears determines it"),
        "remove it, or set stiffness = \"piecewise\"",
    );
    if continuous {
        section.without_effect(
            &["segments"],
            "with stiffness = \"continuous\"",
            "remove it, or set stiffness = \"table\"",
        );
    }
    let resolution = section.choice("resolution")?;
    let pairs = pairs(section, resolution, gears, misalignment);
    let spec = of_drawing(section, gears, continuous, pairs);
    let (pairs, spec) = (pairs?, spec?);
    if let Some(StructureSource::Train(train)) = mesh_context.source
        && !train.planetary.is_empty()
        && pairs.is_some()
    {
        let message =
            "all planets share the law of the first mesh, but springs of pairs cannot be shared";
        return section
            .fault(DiagnosticKind::Unavailable, "resolution", message)
            .label("not available with planets")
            .accepted("resolution = \"secant\" or \"mean_load\"")
            .fail(section.issues);
    }
    let Some(spec) = spec else {
        // For other sources, a missing or faulty drawing has been reported.
        if let Some(StructureSource::Train(_)) = mesh_context.source {
            let message =
                "a mesh table needs parallel axes, but the gears of the first mesh are bevel gears";
            section
                .fault(DiagnosticKind::Unavailable, "stiffness", message)
                .label("bevel gears have no mesh table")
                .accepted("stiffness = \"constant\", \"piecewise\" or \"fourier\"")
                .report(section.issues);
        }
        return None;
    };
    let flanks = match Flanks::new(&spec.gears) {
        Ok(flanks) => flanks,
        Err(error) => {
            let message =
                format!("the mesh table of the gears in [gear] cannot be computed: {error}");
            return Diagnostic::new(
                DiagnosticKind::OutOfRange,
                section.span_of("stiffness"),
                "gear",
                message,
            )
            .label("computed from [gear]")
            .accepted("give a pair of gears that can mesh, or stiffness = \"piecewise\"")
            .fail(section.issues);
        }
    };
    if let Some(slices) = pairs {
        check_springs(section, &flanks, slices as usize)?;
    }
    Some(StiffnessSpec::Table(Arc::new(spec)))
}

/// The specification of a mesh table from the drawing; the inner option is `None` without a drawing. `pairs` is the
/// number of slices if every pair is a separate spring.
pub(super) fn of_drawing(
    section: &Section,
    gears: Option<&GearPair>,
    continuous: bool,
    pairs: Option<Option<u32>>,
) -> Option<Option<MeshTableSpec>> {
    let effective = &section.if_effective(!matches!(pairs, Some(Some(_))));
    let segments = if continuous { None } else { effective.integer("segments") };
    let shaft_tilt = effective.boolean("shaft_tilt");
    let face = face(effective, gears);
    let contact = section.choice("contact");
    let resolution = section.choice("resolution");
    let (pairs, face, shaft_tilt) = (pairs?, face?, shaft_tilt?);
    let (contact, resolution) = (contact?, resolution?);
    let Some(gears) = gears else {
        return Some(None);
    };
    Some(Some(MeshTableSpec {
        gears: gears.clone(),
        division: match (pairs, continuous) {
            (Some(slices), _) => CycleDivision::Pairs { slices },
            (None, true) => CycleDivision::Continuous,
            // The schema bounds the segments far below the range of u32.
            (None, false) => CycleDivision::Segments(segments?),
        },
        stiffness: match resolution {
            "secant" => StiffnessLaw::Secant,
            _ => StiffnessLaw::Tangent,
        },
        shaft_tilt,
        contact: match contact {
            "load_dependent" => Contact::Secant,
            _ => Contact::Linear,
        },
        // Springs of pairs are not coupled along the face.
        face: if pairs.is_some() { FaceLaw::Independent } else { face },
    }))
}

/// Whether the slices of the face are elastically coupled.
fn face(section: &Section, gears: Option<&GearPair>) -> Option<FaceLaw> {
    if gears.is_some_and(|pair| pair.helix_angle != 0.0 || pair.form.ring.is_some()) {
        section.without_effect(
            &["face"],
            "on helical gears and in rings, because their slices bear load independently",
            "remove it",
        );
        return Some(FaceLaw::Independent);
    }
    section.variant("face")
}

/// Number of slices of the face if every pair is a separate spring, otherwise an inner `None`; an outer `None` if a key
/// has faults.
fn pairs(
    section: &Section,
    resolution: &str,
    gears: Option<&GearPair>,
    misalignment: Option<f64>,
) -> Option<Option<u32>> {
    let slices = section.integer("slices");
    if resolution != "pairs" {
        section.without_effect(
            &["slices"],
            "without resolution = \"pairs\"",
            "remove it, or set resolution = \"pairs\"",
        );
        return Some(None);
    }
    section.without_effect(
        &["face", "segments", "shaft_tilt"],
        "with resolution = \"pairs\": its springs follow the mesh phase and the tilt of the shafts at every instant",
        "remove it, or set resolution = \"secant\" or \"mean_load\"",
    );
    if gears.is_some_and(|pair| pair.helix_angle != 0.0) {
        let message = "resolution = \"pairs\" makes pairs of teeth separate springs, which requires spur gears";
        return section
            .fault(DiagnosticKind::Unavailable, "resolution", message)
            .label("not with gear.helix_angle")
            .accepted("resolution = \"secant\" or \"mean_load\"")
            .fail(section.issues);
    }
    let slices = slices?;
    let across = gears.is_some_and(|pair| pair.form.has_modified_lead());
    let is_misaligned = misalignment.is_some_and(|angle| angle != 0.0);
    if slices == 1 && (across || is_misaligned) {
        let key = if across { "resolution" } else { "misalignment" };
        let message = "one slice of the face cannot represent misalignment or a modified lead";
        return section
            .inconsistent(key, message)
            .label("misalignment and modified leads need slices")
            .accepted("set mesh.slices to 2 or more, or resolution = \"secant\" or \"mean_load\"")
            .fail(section.issues);
    }
    Some(Some(slices))
}

/// Checks that the springs of all slices, pairs and flanks are not too many.
fn check_springs(section: &Section, flanks: &Flanks, slices: usize) -> Option<()> {
    let [first, last] = flanks.reach();
    let pairs = ((last - first) / flanks.path().base_pitch) as usize + 1;
    let room = SEVERAL_CONTACTS / (2 * pairs);
    if slices <= room {
        return Some(());
    }
    let message = format!(
        "{slices} slices of both flanks of {pairs} pairs in contact, tip edges included, need {} \
                 springs, more than {SEVERAL_CONTACTS}",
        2 * pairs * slices
    );
    section
        .fault(DiagnosticKind::OutOfRange, "slices", message)
        .label(format!("at most {room} with these gears"))
        .accepted(format!("a whole number from 1 to {room}"))
        .fail(section.issues)
}
