//! `[analyses.covariant]`, and the number of exponents of a model.

use crate::analysis::{CovariantConfig, MOST_MEMORY};
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::manifest::spec::ModelSpec;

pub(super) fn read(table: &Section, model: Option<&ModelSpec>) -> Option<CovariantConfig> {
    let vectors = table.integer("vectors");
    let cycles = table.integer("cycles");
    let align = table.integer("align");
    let config = CovariantConfig {
        vectors: vectors?,
        cycles: cycles?,
        align: align?,
    };
    check_exponents(table, "vectors", config.vectors, model)?;
    let memory = config.memory();
    if memory > MOST_MEMORY {
        let most = MOST_MEMORY / (memory / (config.cycles + config.align));
        let message = format!(
            "the factors of {} vectors over {} + {} cycles need {} MiB of memory for every point being computed",
            config.vectors,
            config.cycles,
            config.align,
            memory >> 20
        );
        return table
            .whole_fault(DiagnosticKind::Inconsistent, message)
            .label(format!("at most {} MiB", MOST_MEMORY >> 20))
            .remedy(format!(
                "reduce the number of vectors, or keep cycles and align together at {most} or less"
            ))
            .fail(table.issues);
    }
    Some(config)
}

/// Checks that the model has as many exponents as requested. Reports if not.
pub(super) fn check_exponents(
    table: &Section,
    key: &str,
    requested: usize,
    model: Option<&ModelSpec>,
) -> Option<()> {
    let Some(model) = model.filter(|model| requested > model.exponents()) else {
        return Some(());
    };
    let (retained, most) = (model.retained, model.exponents());
    let (of, note) = match model.neutral_exponents() {
        0 => ("none".to_owned(), String::new()),
        other => (
            format!("{other}, under drag"),
            format!(", and {other} under drag"),
        ),
    };
    let neutral = match model.neutral() {
        0 => String::new(),
        1 => format!(" (the neutral rotation has {of})"),
        _ => format!(" (neutral rotations have {of})"),
    };
    let message =
        format!("{requested} {key} are too many: {retained} retained modes have {most}{neutral}");
    table
        .inconsistent(key, message)
        .label(format!("at most {most}"))
        .accepted(format!(
            "a whole number from 1 to {most}, twice the retained modes{}{note}",
            if neutral.is_empty() { "" } else { " that are not neutral" }
        ))
        .fail(table.issues)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    /// With drag, the speed of the neutral rotation has an exponent.
    #[test]
    fn drag_has_an_exponent_of_its_own() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../manifests/tiers");
        let text = std::fs::read_to_string(folder.join("torsional.toml")).unwrap();
        let exponents_of = |exponents: usize, drag: &str| {
            let own = format!("end_inertia = \"2e-3 kg*m^2\"\ndrag = {drag}");
            let text = text.replacen("end_inertia = \"2e-3 kg*m^2\"", &own, 1);
            let lyapunov = format!("lyapunov = {{ exponents = {exponents}");
            let text = text.replacen("lyapunov = { exponents = 1", &lyapunov, 1);
            assert!(text.contains(&own) && text.contains(&lyapunov));
            crate::manifest::parse(&text, "test.toml", &folder)
                .map(|job| job.points.at(0).model.exponents())
                .map_err(|errors| errors.to_string())
        };
        assert_eq!(exponents_of(2, "0"), Ok(2));
        assert_eq!(exponents_of(3, "0.05"), Ok(3));
        for (exponents, drag, words) in [
            (
                3,
                "0",
                "2 retained modes have 2 (the neutral rotation has none)",
            ),
            (
                4,
                "0.05",
                "2 retained modes have 3 (the neutral rotation has 1, under drag)",
            ),
            (
                4,
                "0.05",
                "from 1 to 3, twice the retained modes that are not neutral, and 1 under drag",
            ),
        ] {
            let errors = exponents_of(exponents, drag).unwrap_err();
            assert!(errors.contains(words), "{errors}");
        }
    }
}
