//! What cannot be combined with dry sliders or rigid stops?

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::manifest::spec::ModelSpec;

/// An excluded key: table, key, excluded values (empty for all), reason, remedy.
pub(super) type Excluded = (
    &'static str,
    &'static str,
    &'static [&'static str],
    &'static str,
    &'static str,
);

/// Keys that cannot be combined with sliders.
const EXCLUDED: [Excluded; 3] = [
    (
        "run",
        "kernel",
        &["closed_modes", "stepping"],
        "is a kernel that cannot follow dry sliders",
        "set kernel = \"volterra\" or \"auto\"",
    ),
    (
        "analyses",
        "covariant",
        &[],
        "is not available: a slip of a dry slider forgets a direction, so that no vector goes backwards",
        "remove the analysis, or the hysteresis of the drive",
    ),
    (
        "continuation",
        "over",
        &[],
        "is not available: orbits with dry sliders cannot be followed over a parameter",
        "remove the table, or the hysteresis of the drive",
    ),
];

/// Keys that cannot be combined with rigid stops.
const EXCLUDED_BY_STOPS: [Excluded; 3] = [
    (
        "run",
        "kernel",
        &["closed_modes", "stepping"],
        "is a kernel that cannot follow rigid stops",
        "set kernel = \"volterra\" or \"auto\"",
    ),
    (
        "analyses",
        "covariant",
        &[],
        "is not available: a stop that comes to hold the structure forgets directions, so that no vector goes backwards",
        "remove the analysis, or give the stops a stiffness",
    ),
    (
        "continuation",
        "over",
        &[],
        "is not available: orbits with rigid stops cannot be followed over a parameter",
        "remove the table, or give the stops a stiffness",
    ),
];

/// Keys that dry friction excludes.
const EXCLUDED_BY_FRICTION: [Excluded; 3] = [
    (
        "run",
        "kernel",
        &["closed_modes", "stepping"],
        "is a kernel that cannot follow dry friction",
        "set kernel = \"volterra\" or \"auto\"",
    ),
    (
        "analyses",
        "covariant",
        &[],
        "is not available: dry friction that sticks forgets a direction, so that no vector goes backwards",
        "remove the analysis, or replace `[[dry_friction]]` by a damper",
    ),
    (
        "continuation",
        "over",
        &[],
        "is not available: orbits with dry friction cannot be followed over a parameter",
        "remove the table, or replace `[[dry_friction]]` by a damper",
    ),
];

/// Reports keys that cannot be combined with the sliders, rigid stops and dry friction of a model.
pub(super) fn check(root: &Section, issues: &mut Issues, model: Option<&ModelSpec>) {
    let sliders = model.map_or(0, |model| model.source.sliders());
    if sliders > 0 {
        exclude(
            root,
            issues,
            &EXCLUDED,
            &format!("not with {sliders} dry sliders"),
        );
    }
    let stops = model.map_or(0, |model| model.source.rigid_stops());
    if stops > 0 {
        let label = format!("not with {stops} rigid stops");
        exclude(root, issues, &EXCLUDED_BY_STOPS, &label);
    }
    let frictions = model.map_or(0, |model| model.source.dry_frictions());
    if frictions > 0 {
        let label = format!("not with {frictions} elements of dry friction");
        exclude(root, issues, &EXCLUDED_BY_FRICTION, &label);
    }
}

/// Reports the given ones among excluded keys.
pub(super) fn exclude(root: &Section, issues: &mut Issues, keys: &[Excluded], label: &str) {
    for &(table, key, values, why, remedy) in keys {
        let Child::Present(section) = root.child(issues, table) else {
            continue;
        };
        if !section.has(key) {
            continue;
        }
        let given = |issues: &mut Issues| section.text(issues, key);
        if values.is_empty() || given(issues).is_some_and(|value| values.contains(&value)) {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Unavailable,
                    section.span_of(key),
                    &section.path_of(key),
                    format!("`{}` {why}", section.path_of(key)),
                )
                .label(label)
                .remedy(remedy),
            );
        }
    }
}
