//! `[analyses.orbits]`: the periodic orbits to be searched for.

use super::modal_state;
use crate::analysis::OrbitConfig;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::{Section, all_of};

pub(super) fn read(table: &Section, retained: Option<usize>) -> Option<OrbitConfig> {
    all_of!(OrbitConfig {
        periods: periods(table),
        guesses: table.integer("guesses"),
        cycles: table.integer("cycles"),
        floquet: table.boolean("floquet"),
        returns: table.integer("returns"),
        states: table.each("states", |state| modal_state::read(state, retained)),
    })
}

fn periods(table: &Section) -> Option<Vec<u32>> {
    let values = table.whole_numbers("periods")?;
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
