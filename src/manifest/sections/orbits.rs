//! `[analyses.orbits]`: which periodic orbits are sought.

use crate::analysis::OrbitQuestion;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;

const DEFAULT_PERIODS: [u32; 2] = [1, 2];
const DEFAULT_GUESSES: u64 = 16;
const DEFAULT_CYCLES: u64 = 400;

pub(super) fn read(table: &Section, issues: &mut Issues) -> Option<OrbitQuestion> {
    let periods = match table.has("periods") {
        true => periods(table, issues),
        false => Some(DEFAULT_PERIODS.to_vec()),
    };
    let guesses = table.integer_or(issues, "guesses", DEFAULT_GUESSES);
    let cycles = table.integer_or(issues, "cycles", DEFAULT_CYCLES);
    let floquet = table.boolean_or(issues, "floquet", true);
    Some(OrbitQuestion {
        periods: periods?,
        guesses: u32::try_from(guesses?).ok()?,
        cycles: u32::try_from(cycles?).ok()?,
        floquet: floquet?,
    })
}

fn periods(table: &Section, issues: &mut Issues) -> Option<Vec<u32>> {
    let values = table.whole_numbers(issues, "periods")?;
    if values.is_empty() {
        let path = table.path_of("periods");
        issues.push(
            Diagnostic::new(
                DiagnosticKind::OutOfRange,
                table.span_of("periods"),
                &path,
                format!("`{path}` is empty"),
            )
            .label("no period")
            .accepted(table.spec(&path).accepted())
            .remedy("name at least one period, or leave the analysis out"),
        );
        return None;
    }
    values
        .into_iter()
        .map(|value| u32::try_from(value).ok())
        .collect()
}
