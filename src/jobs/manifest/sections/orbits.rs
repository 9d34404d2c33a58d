//! `[analyses.orbits]`: the periodic orbits to be searched for.

use super::modal_state;
use crate::analysis::OrbitConfig;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;

pub(super) fn read(table: &Section, retained: Option<usize>) -> Option<OrbitConfig> {
    let periods = periods(table);
    let guesses = table.integer_or_default("guesses");
    let cycles = table.integer_or_default("cycles");
    let floquet = table.boolean_or_default("floquet");
    let returns = table.integer_or_default("returns");
    let states = table.each("states", |state| modal_state::read(state, retained));
    Some(OrbitConfig {
        periods: periods?,
        guesses: guesses?,
        cycles: cycles?,
        floquet: floquet?,
        returns: returns?,
        states: states?,
    })
}

fn periods(table: &Section) -> Option<Vec<u32>> {
    let values = table.whole_numbers_or_default("periods")?;
    if values.is_empty() {
        let path = table.path_of("periods");
        return table
            .fault(
                DiagnosticKind::OutOfRange,
                "periods",
                format!("`{path}` is empty"),
            )
            .label("no period")
            .accepted(table.spec(&path).accepted())
            .remedy("name at least one period, or remove the analysis")
            .fail(table.issues);
    }
    values
        .into_iter()
        .map(|value| u32::try_from(value).ok())
        .collect()
}
