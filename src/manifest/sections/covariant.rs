//! `[analyses.covariant]`, and how many exponents a model has.

use crate::analysis::{CovariantQuestion, MOST_MEMORY};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::spec::ModelSpec;

pub(super) fn read(
    table: &Section,
    issues: &mut Issues,
    model: Option<&ModelSpec>,
) -> Option<CovariantQuestion> {
    let vectors = table.count_or_default(issues, "vectors");
    let cycles = table.integer_or_default(issues, "cycles");
    let align = table.integer_or_default(issues, "align");
    let question = CovariantQuestion {
        vectors: vectors?,
        cycles: cycles?,
        align: align?,
    };
    there_are(table, issues, "vectors", question.vectors, model)?;
    let memory = question.memory();
    if memory > MOST_MEMORY {
        let most = MOST_MEMORY / (memory / (question.cycles + question.align));
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                table.span,
                "analyses.covariant",
                format!(
                    "the factors of {} vectors over {} + {} cycles take {} MiB of every point at work",
                    question.vectors,
                    question.cycles,
                    question.align,
                    memory >> 20
                ),
            )
            .label(format!("at most {} MiB", MOST_MEMORY >> 20))
            .remedy(format!(
                "ask for fewer vectors, or for cycles and align of at most {most} together"
            )),
        );
        return None;
    }
    Some(question)
}

/// Whether a model has as many exponents as a key asks for; none where it has not, reported.
pub(super) fn there_are(
    table: &Section,
    issues: &mut Issues,
    key: &str,
    asked: usize,
    model: Option<&ModelSpec>,
) -> Option<()> {
    let Some(model) = model.filter(|model| asked > 2 * model.felt()) else {
        return Some(());
    };
    let (retained, most) = (model.retained, 2 * model.felt());
    let neutral = match retained - model.felt() {
        0 => "",
        1 => " (the neutral rotation has none)",
        _ => " (neutral rotations have none)",
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            table.span_of(key),
            &table.path_of(key),
            format!("there are no {asked} {key}: {retained} retained modes have {most}{neutral}"),
        )
        .label(format!("at most {most}"))
        .accepted(format!(
            "a whole number from 1 to {most}, twice the retained modes{}",
            match neutral.is_empty() {
                true => "",
                false => " that are not neutral",
            }
        )),
    );
    None
}
