//! `[analyses.orbits]`: the periodic orbits to be searched for.

use super::modal_state;
use crate::analysis::OrbitConfig;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;

pub(super) fn read(
    table: &Section,
    issues: &mut Issues,
    retained: Option<usize>,
) -> Option<OrbitConfig> {
    let periods = periods(table, issues);
    let guesses = table.integer_or_default(issues, "guesses");
    let cycles = table.integer_or_default(issues, "cycles");
    let floquet = table.boolean_or_default(issues, "floquet");
    let returns = table.integer_or_default(issues, "returns");
    let states = table.tables(issues, "states").map(|tables| {
        // Read every state before failing, so that all faults are found.
        let read: Vec<_> = tables
            .iter()
            .map(|state| modal_state::read(state, issues, retained))
            .collect();
        read.into_iter().collect::<Option<Vec<_>>>()
    });
    Some(OrbitConfig {
        periods: periods?,
        guesses: u32::try_from(guesses?).ok()?,
        cycles: u32::try_from(cycles?).ok()?,
        floquet: floquet?,
        returns: u32::try_from(returns?).ok()?,
        states: states??,
    })
}

fn periods(table: &Section, issues: &mut Issues) -> Option<Vec<u32>> {
    let values = table.whole_numbers_or_default(issues, "periods")?;
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
            .remedy("name at least one period, or remove the analysis"),
        );
        return None;
    }
    values
        .into_iter()
        .map(|value| u32::try_from(value).ok())
        .collect()
}
