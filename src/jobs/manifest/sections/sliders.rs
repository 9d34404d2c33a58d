//! Reports keys that cannot be combined with dry sliders, rigid stops or dry friction.

use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::manifest::spec::ModelSpec;

/// An excluded key: table (empty for the top level), key, excluded values (empty for all), reason, remedy.
pub(super) type Excluded<'a> = (
    &'static str,
    &'static str,
    &'static [&'static str],
    &'a str,
    &'a str,
);

/// Excludes the kernels `closed_modes` and `stepping`, which support neither a `Part` nor a film of oil.
pub(super) const fn excluded_kernel<'a>(why: &'a str, remedy: &'a str) -> Excluded<'a> {
    ("run", "kernel", &["closed_modes", "stepping"], why, remedy)
}

/// A kind of part that some kernels, covariant vectors and followed orbits do not support.
struct Part {
    /// Name of the part in messages.
    name: &'static str,
    /// Reason why covariant vectors cannot be integrated backwards.
    forgets: &'static str,
    /// The alternative in the remedy "remove the analysis, or …", so that the drive has no such part.
    instead: &'static str,
}

const SLIDERS: Part = Part {
    name: "dry sliders",
    forgets: "a slip of a dry slider forgets a direction",
    instead: "the hysteresis of the drive",
};

const STOPS: Part = Part {
    name: "rigid stops",
    forgets: "a stop that comes to hold the structure forgets directions",
    instead: "give the stops a stiffness",
};

const FRICTION: Part = Part {
    name: "dry friction",
    forgets: "dry friction that sticks forgets a direction",
    instead: "replace `[[dry_friction]]` by a damper",
};

/// Reports keys that cannot be combined with the sliders, rigid stops and dry friction of a model.
pub(super) fn check(root: &Section, model: Option<&ModelSpec>) {
    let Some(source) = model.map(|model| &model.source) else {
        return;
    };
    for (part, count, unit) in [
        (SLIDERS, source.sliders(), ""),
        (STOPS, source.rigid_stops(), ""),
        (FRICTION, source.dry_frictions(), "elements of "),
    ] {
        if count > 0 {
            let Part {
                name,
                forgets,
                instead,
            } = part;
            let label = format!("not with {count} {unit}{name}");
            let kernel = format!("is a kernel that cannot follow {name}");
            let covariant =
                format!("is not available: {forgets}, so that no vector goes backwards");
            let over =
                format!("is not available: orbits with {name} cannot be followed over a parameter");
            let remedy = |what: &str| format!("remove {what}, or {instead}");
            let keys = [
                excluded_kernel(&kernel, "set kernel = \"volterra\" or \"auto\""),
                (
                    "analyses",
                    "covariant",
                    &[],
                    &covariant,
                    &remedy("the analysis"),
                ),
                ("", "continuation", &[], &over, &remedy("the table")),
            ];
            exclude(root, &keys, &label);
        }
    }
}

/// Reports every excluded key that the manifest has.
pub(super) fn exclude(root: &Section, keys: &[Excluded<'_>], label: &str) {
    for &(table, key, values, why, remedy) in keys {
        let within = || root.child(table).flatten();
        let section = if table.is_empty() { Some(root.clone()) } else { within() };
        let Some(section) = section else {
            continue;
        };
        if !section.has(key) {
            continue;
        }
        if values.is_empty()
            || section
                .text(key)
                .is_some_and(|value| values.contains(&value))
        {
            let message = format!("`{}` {why}", section.path_of(key));
            section
                .fault(DiagnosticKind::Unavailable, key, message)
                .label(label)
                .remedy(remedy)
                .report(section.issues);
        }
    }
}
