//! `[mesh]`: backlash, stiffness over the mesh cycle, misalignment, contact damping, friction, oil, faults of teeth.

use super::backlash::{self, MeshContext};
use super::coast;
use super::contact_law;
use super::drawn_mesh;
use super::film;
use super::friction;
use super::tooth_fault;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind};
use crate::manifest::reader::{Given, Section};
use crate::manifest::spec::{DampingSpec, MeshSpec, StiffnessSpec, TwoLevels};
use crate::manifest::tree::Value;
use crate::units::{self, Dimension};
use std::sync::Arc;

/// Keys of the two-level law.
const LAW: [&str; 3] = ["contact_ratio", "single_pair_drop", "segments"];

/// Distance between a transition and the border of a segment, in segments, below which they coincide: the
/// round-off in `contact_ratio − 1`.
const ON_BORDER: f64 = 1e-9;

/// Keys that only have a meaning with a mesh table.
const OF_TABLES: [&str; 6] = [
    "misalignment",
    "shaft_tilt",
    "contact",
    "face",
    "resolution",
    "slices",
];

/// Whether a mesh takes its stiffness from the drawing of the gears: with `table`, and with `continuous` unless a key
/// of the two-level law is given.
pub(super) fn wants_gears(section: &Section) -> bool {
    let law = section.has("mean_stiffness") || LAW[..2].iter().any(|key| section.has(key));
    match section.entry("stiffness").map(|entry| &entry.node.value) {
        Some(Value::Text(text)) => text == "table" || (text == "continuous" && !law),
        _ => false,
    }
}

/// Reads the table.
pub(super) fn read(section: &Section, mesh_context: MeshContext<'_>) -> Option<MeshSpec> {
    let half_gap = backlash::read(section, mesh_context);
    let choice = section.choice("stiffness");
    if choice.is_some_and(|choice| choice != "fourier") {
        section.without_effect(
            &["stiffness_harmonics"],
            "without stiffness = \"fourier\"",
            "remove it, or set stiffness = \"fourier\"",
        );
    }
    let of_gears = wants_gears(section);
    let misalignment = (section.if_effective(of_gears)).quantity("misalignment");
    let stiffness = if of_gears {
        drawn_mesh::read(section, mesh_context, misalignment)
    } else {
        section.without_effect(
            &OF_TABLES,
            "because the mesh is not computed from [gear]",
            "remove it, or set stiffness = \"table\"",
        );
        match choice {
            Some("constant") => constant(section),
            Some("continuous") => continuous(section),
            Some("fourier") => fourier(section),
            Some(_) => piecewise(section),
            None => None,
        }
    };
    let friction = friction::read(section, mesh_context);
    let damping = contact_damping(section);
    let laws = stiffness.as_ref().zip(friction.as_ref());
    let sliding = laws.and_then(|(stiffness, friction)| {
        friction::sliding(section, mesh_context, friction, stiffness)
    });
    let coast = coast::read(section, mesh_context, laws);
    let release = section.variant("release");
    let film = film::read(section, mesh_context);
    let teeth = (stiffness.as_ref().zip(coast.as_ref()))
        .and_then(|laws| tooth_fault::read(section, mesh_context, laws));
    let (half_gap, stiffness) = (half_gap?, stiffness?);
    backlash::check_scale(section, mesh_context, half_gap, &stiffness)?;
    Some(MeshSpec {
        half_gap,
        length: None,
        stiffness,
        damping: damping?,
        friction: friction?,
        sliding: sliding?,
        misalignment: misalignment?,
        coast: coast?,
        release: release?,
        film: film?,
        teeth: teeth?,
    })
}

/// Warns of the keys of a piecewise stiffness, which have no effect with another law.
fn warn_of_piecewise_keys(section: &Section, law: &str) {
    let others = [LAW.as_slice(), &["values"]].concat();
    let why = format!("with stiffness = \"{law}\"");
    let remedy = "remove it, or set stiffness = \"piecewise\"";
    section.without_effect(&others, &why, remedy);
}

fn constant(section: &Section) -> Option<StiffnessSpec> {
    warn_of_piecewise_keys(section, "constant");
    section
        .quantity("mean_stiffness")
        .map(StiffnessSpec::Constant)
}

/// A mean and harmonics whose sum stays positive.
fn fourier(section: &Section) -> Option<StiffnessSpec> {
    warn_of_piecewise_keys(section, "fourier");
    let (mean, harmonics, _) = contact_law::fourier(section, "mean_stiffness")?;
    Some(StiffnessSpec::Fourier(mean, harmonics.into()))
}

fn piecewise(section: &Section) -> Option<StiffnessSpec> {
    if section.has("values") {
        let others = [LAW.as_slice(), &["mean_stiffness"]].concat();
        section.given_twice(&others, "values", "give the stiffness over the mesh cycle");
        let values = section.quantities("values", None)?;
        if values.is_empty() {
            let message = "`mesh.values` has no entries";
            return section
                .fault(DiagnosticKind::Empty, "values", message)
                .label("empty")
                .accepted("give one stiffness per equal segment of the mesh cycle, at least 1")
                .fail(section.issues);
        }
        return Some(StiffnessSpec::Piecewise(values.into()));
    }
    let law = two_levels(section);
    let segments = section.integer("segments");
    Some(StiffnessSpec::Piecewise(on_segments(law?, segments?)))
}

fn continuous(section: &Section) -> Option<StiffnessSpec> {
    section.without_effect(
        &["segments", "values"],
        "with stiffness = \"continuous\"",
        "remove it, or set stiffness = \"piecewise\"",
    );
    let mut law = two_levels(section)?;
    if let Some(end) = on_border(law.transition) {
        law.transition = end;
    }
    Some(StiffnessSpec::Continuous(law))
}

/// The two-level law: `k_d` over the first `ε − 1` of the cycle and `(1 − drop) k_d` over the
/// rest, with the given mean.
fn two_levels(section: &Section) -> Option<TwoLevels> {
    let mean = section.quantity("mean_stiffness");
    let contact_ratio = section.quantity("contact_ratio");
    let drop = section.quantity("single_pair_drop");
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

/// The border between segments at this position, if there is one. Positions count in segments.
fn on_border(place: f64) -> Option<f64> {
    let border = place.round();
    ((place - border).abs() < ON_BORDER).then_some(border)
}

/// The two-level law on equal segments; a segment that contains the transition has the average over its width.
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
fn contact_damping(section: &Section) -> Option<DampingSpec> {
    const PATH: &str = "mesh.contact_damping";
    let Some(entry) = section.entry("contact_damping") else {
        section.missing("contact_damping");
        return None;
    };
    let (node, spec) = (&entry.node, section.spec(PATH));
    let given = Given {
        issues: section.issues,
        node,
        path: PATH,
        spec,
    };
    let (value, dimension) = match &node.value {
        Value::Text(text) => match units::parse_any(text) {
            Ok((value, dimension @ (Dimension::Damping | Dimension::Ratio))) => (value, dimension),
            Ok(_) | Err(_) => {
                let error = units::parse(text, Dimension::Damping).err()?;
                return given.wrong_unit(Dimension::Damping, &error);
            }
        },
        Value::Sample(value, dimension) => (*value, *dimension),
        _ => (
            given.quantity_unbounded(Dimension::Ratio)?,
            Dimension::Ratio,
        ),
    };
    if dimension == Dimension::Ratio {
        return given.in_range(value, dimension).map(DampingSpec::Ratio);
    }
    if value >= 0.0 {
        return Some(DampingSpec::Coefficient(value));
    }
    let message = format!("`{PATH}` = {value} N*s/m is out of range");
    Diagnostic::new(DiagnosticKind::OutOfRange, node.span, PATH, message)
        .label("must be at least 0")
        .accepted(spec.accepted())
        .fail(section.issues)
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
