//! A modal state: `{ displacement = [...], velocity = [...] }`.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::tree::entries;
use crate::model::InitialState;

pub(super) fn read(
    state: &Section,
    issues: &mut Issues,
    retained: Option<usize>,
) -> Option<InitialState> {
    let displacement = modal_vector(state, issues, "displacement", retained);
    let velocity = modal_vector(state, issues, "velocity", retained);
    Some(InitialState::Modal {
        displacement: displacement?,
        velocity: velocity?,
    })
}

/// One number per retained mode.
pub(super) fn modal_vector(
    state: &Section,
    issues: &mut Issues,
    name: &str,
    retained: Option<usize>,
) -> Option<Vec<f64>> {
    let values = state.quantities(issues, name, None)?;
    let retained = retained?;
    if values.len() == retained {
        return Some(values);
    }
    let path = state.path_of(name);
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            state.span_of(name),
            &path,
            format!(
                "`{path}` has {} for {retained} retained modes",
                entries(values.len())
            ),
        )
        .label(format!("{retained} are needed"))
        .remedy("give one number per retained mode, in ascending frequency"),
    );
    None
}
