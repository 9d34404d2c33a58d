//! `[mesh]`: backlash, stiffness over the mesh cycle, misalignment, contact damping, friction.

use super::backlash::{self, Surroundings};
use super::coast;
use super::contact_law;
use super::friction;
use crate::gear::{Contact, FaceLaw, Flanks, GearPair, StiffnessLaw};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{self, Section};
use crate::manifest::spec::{
    CycleDivision, DampingSpec, MeshSpec, MeshTableSpec, StiffnessSpec, StructureSource, TwoLevels,
};
use crate::manifest::tree::Value;
use crate::model::{Release, SEVERAL_CONTACTS};
use crate::units::{self, Dimension};
use std::sync::Arc;

/// Keys of the two-level law.
const LAW: [&str; 3] = ["contact_ratio", "single_pair_drop", "segments"];

/// A transition this close to a segment's border, in segments, stands on it: only
/// rounding in `contact_ratio − 1` put it elsewhere.
const ON_BORDER: f64 = 1e-9;

/// Keys that only a table of the gears gives a meaning to.
const OF_TABLES: [&str; 6] = [
    "misalignment",
    "shaft_tilt",
    "contact",
    "face",
    "resolution",
    "slices",
];

/// Whether a mesh takes its stiffness from the drawing of the gears: `continuous` does where no
/// key of the two-level law is given.
pub(super) fn wants_gears(section: &Section) -> bool {
    let law = section.has("mean_stiffness") || LAW[..2].iter().any(|key| section.has(key));
    match section.entry("stiffness").map(|entry| &entry.node.value) {
        Some(Value::Text(text)) => text == "table" || (text == "continuous" && !law),
        _ => false,
    }
}

/// Reads the table.
pub(super) fn read(
    section: &Section,
    issues: &mut Issues,
    drive: Surroundings<'_>,
) -> Option<MeshSpec> {
    let half_gap = backlash::read(section, issues, drive);
    let choice = section.choice(issues, "stiffness");
    if choice.is_some_and(|choice| choice != "fourier") {
        section.without_effect(
            issues,
            &["stiffness_harmonics"],
            "without stiffness = \"fourier\"",
            "remove it, or set stiffness = \"fourier\"",
        );
    }
    let of_gears = wants_gears(section);
    let misalignment = (section.felt(of_gears)).quantity_or_default(issues, "misalignment");
    let stiffness = if of_gears {
        table(section, issues, drive, misalignment)
    } else {
        section.without_effect(
            issues,
            &OF_TABLES,
            "because the mesh is not computed from [gear]",
            "remove it, or set stiffness = \"table\"",
        );
        match choice {
            Some("constant") => constant(section, issues),
            Some("continuous") => continuous(section, issues),
            Some("fourier") => fourier(section, issues),
            Some(_) => piecewise(section, issues),
            None => None,
        }
    };
    let friction = friction::read(section, issues, drive);
    let damping = contact_damping(section, issues);
    let laws = stiffness.as_ref().zip(friction.as_ref());
    let sliding = laws.and_then(|(stiffness, friction)| {
        friction::sliding(section, issues, drive, friction, stiffness)
    });
    let coast = coast::read(section, issues, drive, laws);
    let release = section.choice_or_default(issues, "release");
    let (half_gap, stiffness) = (half_gap?, stiffness?);
    backlash::check_scale(section, issues, drive, half_gap, &stiffness)?;
    Some(MeshSpec {
        half_gap,
        stiffness,
        damping: damping?,
        friction: friction?,
        sliding: sliding?,
        misalignment: misalignment?,
        coast: coast?,
        release: match release? {
            "force" => Release::Force,
            _ => Release::Deflection,
        },
    })
}

/// Stiffness from the drawing of the gears, which must be a pair that meshes.
fn table(
    section: &Section,
    issues: &mut Issues,
    drive: Surroundings<'_>,
    misalignment: Option<f64>,
) -> Option<StiffnessSpec> {
    let gears = drive.gears;
    section.without_effect(
        issues,
        &[
            "mean_stiffness",
            "contact_ratio",
            "single_pair_drop",
            "values",
        ],
        "with stiffness = \"table\": the drawing of the gears determines it",
        "remove it, or set stiffness = \"piecewise\"",
    );
    let continuous = section.has("stiffness")
        && matches!(section.entry("stiffness")?.node.value, Value::Text(ref text) if text == "continuous");
    if continuous {
        section.without_effect(
            issues,
            &["segments"],
            "with stiffness = \"continuous\"",
            "remove it, or set stiffness = \"table\"",
        );
    }
    let resolution = section.choice_or_default(issues, "resolution")?;
    let pairs = pairs(section, issues, resolution, gears, misalignment);
    let own = &section.felt(!matches!(pairs, Some(Some(_))));
    let segments = if continuous { None } else { own.integer_or_default(issues, "segments") };
    let shaft_tilt = own.boolean_or_default(issues, "shaft_tilt");
    let face = face(own, issues, gears);
    let contact = match section.choice_or_default(issues, "contact")? {
        "load_dependent" => Contact::Secant,
        _ => Contact::Linear,
    };
    let pairs = pairs?;
    if let Some(StructureSource::Train(train)) = drive.source
        && train.planetary.is_some()
    {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Unavailable,
                section.span_of("stiffness"),
                &section.path_of("stiffness"),
                "all planets share the law of the first mesh, which a mesh table cannot give them"
                    .to_owned(),
            )
            .label("not available with planets")
            .accepted("stiffness = \"constant\", \"piecewise\" or \"fourier\""),
        );
        return None;
    }
    let Some(gears) = gears else {
        // Of others a drawing that is missing or faulty has been reported.
        if let Some(StructureSource::Train(_)) = drive.source {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Unavailable,
                    section.span_of("stiffness"),
                    &section.path_of("stiffness"),
                    "a mesh table needs spur gears, but the gears of this train are bevel gears"
                        .to_owned(),
                )
                .label("bevel gears have no mesh table")
                .accepted("stiffness = \"constant\", \"piecewise\" or \"fourier\""),
            );
        }
        return None;
    };
    let flanks = match Flanks::new(gears) {
        Ok(flanks) => flanks,
        Err(error) => {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::OutOfRange,
                    section.span_of("stiffness"),
                    "gear",
                    format!("the mesh table of the gears in [gear] cannot be computed: {error}"),
                )
                .label("computed from [gear]")
                .accepted("give a pair of gears that can mesh, or stiffness = \"piecewise\""),
            );
            return None;
        }
    };
    if let Some(slices) = pairs {
        check_springs(section, issues, &flanks, slices as usize)?;
    }
    Some(StiffnessSpec::Table(Arc::new(MeshTableSpec {
        gears: gears.clone(),
        division: match (pairs, continuous) {
            (Some(slices), _) => CycleDivision::Pairs { slices },
            (None, true) => CycleDivision::Continuous,
            // The schema bounds the segments far below the range of u32.
            (None, false) => CycleDivision::Segments(u32::try_from(segments?).ok()?),
        },
        stiffness: match resolution {
            "secant" => StiffnessLaw::Secant,
            _ => StiffnessLaw::Tangent,
        },
        shaft_tilt: shaft_tilt?,
        contact,
        // Springs of pairs are those of each slice for itself.
        face: if pairs.is_some() { FaceLaw::Independent } else { face? },
    })))
}

/// Whether slices of the face support each other.
fn face(section: &Section, issues: &mut Issues, gears: Option<&GearPair>) -> Option<FaceLaw> {
    if gears.is_some_and(|pair| pair.helix_angle != 0.0) {
        section.without_effect(
            issues,
            &["face"],
            "on helical gears, because their slices bear load independently",
            "remove it",
        );
        return Some(FaceLaw::Independent);
    }
    Some(match section.choice_or_default(issues, "face")? {
        "independent" => FaceLaw::Independent,
        _ => FaceLaw::Coupled,
    })
}

/// Slices of the face where every pair is a spring of its own; an inner none where it is not, an outer one
/// where a key has faults.
fn pairs(
    section: &Section,
    issues: &mut Issues,
    resolution: &str,
    gears: Option<&GearPair>,
    misalignment: Option<f64>,
) -> Option<Option<u32>> {
    let slices = section.integer_or_default(issues, "slices");
    if resolution != "pairs" {
        section.without_effect(
            issues,
            &["slices"],
            "without resolution = \"pairs\"",
            "remove it, or set resolution = \"pairs\"",
        );
        return Some(None);
    }
    section.without_effect(
        issues,
        &["face", "segments", "shaft_tilt"],
        "with resolution = \"pairs\": springs follow the mesh phase and the tilt of the shafts at every instant",
        "with resolution = \"pairs\": its springs follow the mesh phase and the tilt of the shafts at every instant",
    );
    if gears.is_some_and(|pair| pair.helix_angle != 0.0) {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Unavailable,
                section.span_of("resolution"),
                &section.path_of("resolution"),
                "resolution = \"pairs\" makes pairs of teeth separate springs, which requires spur gears".to_owned(),
            )
            .label("not with gear.helix_angle")
            .accepted("resolution = \"secant\" or \"mean_load\""),
        );
        return None;
    }
    let slices = u32::try_from(slices?).ok()?;
    let across = gears.is_some_and(|pair| pair.form.has_modified_lead());
    let askew = misalignment.is_some_and(|angle| angle != 0.0);
    if slices == 1 && (across || askew) {
        let key = if across { "resolution" } else { "misalignment" };
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of(key),
                &section.path_of(key),
                "one slice of the face cannot represent misalignment or a modified lead".to_owned(),
            )
            .label("misalignment and modified leads need slices")
            .accepted("set mesh.slices to 2 or more, or resolution = \"secant\" or \"mean_load\""),
        );
        return None;
    }
    Some(Some(slices))
}

/// The springs of all slices, of both flanks of all pairs at once, have room beside each other.
fn check_springs(
    section: &Section,
    issues: &mut Issues,
    flanks: &Flanks,
    slices: usize,
) -> Option<()> {
    let [first, last] = flanks.reach();
    let pairs = ((last - first) / flanks.path().base_pitch) as usize + 1;
    let room = SEVERAL_CONTACTS / (2 * pairs);
    if slices <= room {
        return Some(());
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::OutOfRange,
            section.span_of("slices"),
            &section.path_of("slices"),
            format!(
                "{slices} slices of both flanks of {pairs} pairs in contact, tip edges included, need {} \
                 springs, more than {SEVERAL_CONTACTS}",
                2 * pairs * slices
            ),
        )
        .label(format!("at most {room} with these gears"))
        .accepted(format!("a whole number from 1 to {room}")),
    );
    None
}

fn constant(section: &Section, issues: &mut Issues) -> Option<StiffnessSpec> {
    let others = [LAW.as_slice(), &["values"]].concat();
    section.without_effect(
        issues,
        &others,
        "with stiffness = \"constant\"",
        "remove it, or set stiffness = \"piecewise\"",
    );
    section
        .quantity(issues, "mean_stiffness")
        .map(StiffnessSpec::Constant)
}

/// A mean and harmonics that leave something of it everywhere.
fn fourier(section: &Section, issues: &mut Issues) -> Option<StiffnessSpec> {
    let others = [LAW.as_slice(), &["values"]].concat();
    section.without_effect(
        issues,
        &others,
        "with stiffness = \"fourier\"",
        "remove it, or set stiffness = \"piecewise\"",
    );
    let (mean, harmonics, _) = contact_law::fourier(section, issues, "mean_stiffness")?;
    Some(StiffnessSpec::Fourier(mean, harmonics.into()))
}

fn piecewise(section: &Section, issues: &mut Issues) -> Option<StiffnessSpec> {
    if section.has("values") {
        let others = [LAW.as_slice(), &["mean_stiffness"]].concat();
        section.given_twice(
            issues,
            &others,
            "values",
            "give the stiffness over the mesh cycle",
        );
        let values = section.quantities(issues, "values", None)?;
        if values.is_empty() {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Empty,
                    section.span_of("values"),
                    "mesh.values",
                    "`mesh.values` has no entries".to_owned(),
                )
                .label("empty")
                .accepted("give one stiffness per equal segment of the mesh cycle, at least 1"),
            );
            return None;
        }
        return Some(StiffnessSpec::Piecewise(values.into()));
    }
    let law = two_levels(section, issues);
    let segments = section.integer_or_default(issues, "segments");
    Some(StiffnessSpec::Piecewise(on_segments(law?, segments?)))
}

fn continuous(section: &Section, issues: &mut Issues) -> Option<StiffnessSpec> {
    section.without_effect(
        issues,
        &["segments", "values"],
        "with stiffness = \"continuous\"",
        "remove it, or set stiffness = \"piecewise\"",
    );
    let mut law = two_levels(section, issues)?;
    if let Some(end) = on_border(law.transition) {
        law.transition = end;
    }
    Some(StiffnessSpec::Continuous(law))
}

/// The two-level law: `k_d` over the first `ε − 1` of the cycle and `(1 − drop) k_d` over the
/// rest, with the given mean.
fn two_levels(section: &Section, issues: &mut Issues) -> Option<TwoLevels> {
    let mean = section.quantity(issues, "mean_stiffness");
    let contact_ratio = section.quantity(issues, "contact_ratio");
    let drop = section.quantity(issues, "single_pair_drop");
    Some(levels(mean?, contact_ratio?, drop?))
}

fn levels(mean: f64, contact_ratio: f64, drop: f64) -> TwoLevels {
    let transition = contact_ratio - 1.0;
    let double_pair = mean / (transition + (1.0 - drop) * (1.0 - transition));
    TwoLevels {
        double_pair,
        single_pair: (1.0 - drop) * double_pair,
        transition,
    }
}

/// The border of a segment on which a place, in segments, stands.
fn on_border(place: f64) -> Option<f64> {
    let border = place.round();
    ((place - border).abs() < ON_BORDER).then_some(border)
}

/// The two-level law on equal segments; one that straddles the transition has the average
/// over its width.
fn on_segments(law: TwoLevels, segments: u64) -> Arc<[f64]> {
    let exact = law.transition * segments as f64;
    let transition = on_border(exact).unwrap_or(exact);
    (0..segments)
        .map(|segment| {
            let double = (transition - segment as f64).clamp(0.0, 1.0);
            double * law.double_pair + (1.0 - double) * law.single_pair
        })
        .collect()
}

/// A bare number or a percentage is a ratio, a text in `N*s/m` the coefficient.
fn contact_damping(section: &Section, issues: &mut Issues) -> Option<DampingSpec> {
    const PATH: &str = "mesh.contact_damping";
    let Some(entry) = section.entry("contact_damping") else {
        section.missing(issues, "contact_damping");
        return None;
    };
    let (node, spec) = (&entry.node, section.spec(PATH));
    let (value, dimension) = match &node.value {
        Value::Text(text) => match units::parse_any(text) {
            Ok((value, dimension @ (Dimension::Damping | Dimension::Ratio))) => (value, dimension),
            Ok(_) | Err(_) => {
                let error = units::parse(text, Dimension::Damping).err()?;
                reader::wrong_unit(issues, node, PATH, Dimension::Damping, &error, spec);
                return None;
            }
        },
        Value::Sample(value, dimension) => (*value, *dimension),
        _ => {
            let value = reader::quantity_unbounded(issues, node, PATH, Dimension::Ratio, spec)?;
            (value, Dimension::Ratio)
        }
    };
    if dimension == Dimension::Ratio {
        let value = reader::in_range(issues, node, PATH, value, dimension, spec)?;
        return Some(DampingSpec::Ratio(value));
    }
    if value >= 0.0 {
        return Some(DampingSpec::Coefficient(value));
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::OutOfRange,
            node.span,
            PATH,
            format!("`{PATH}` = {value} N*s/m is out of range"),
        )
        .label("must be at least 0")
        .accepted(spec.accepted()),
    );
    None
}

#[cfg(test)]
mod tests {
    use super::{levels, on_segments};

    #[test]
    fn default_levels_are_the_drawing_s() {
        let values = on_segments(levels(4e8, 1.6, 0.25), 60);
        assert_eq!(values.len(), 60);
        for (i, value) in values.iter().enumerate() {
            let level = if i < 36 { 4e8 / 0.9 } else { 3e8 / 0.9 };
            assert!(
                (value / level - 1.0).abs() < 4.0 * f64::EPSILON,
                "segment {i}: {value}"
            );
        }
    }

    #[test]
    fn a_straddling_segment_keeps_the_mean() {
        // 0.63 · 7 = 4.41: the fifth segment has 0.41 of the higher level.
        let values = on_segments(levels(4e8, 1.63, 0.25), 7);
        let (high, low) = (values[0], values[6]);
        assert!((low / high - 0.75).abs() < 1e-15);
        assert!((values[4] - (0.41 * high + 0.59 * low)).abs() < 1e-6);
        let mean = values.iter().sum::<f64>() / 7.0;
        assert!((mean / 4e8 - 1.0).abs() < 1e-14);
    }
}
