//! A modal state: `{ displacement = [...], velocity = [...] }`.

use crate::manifest::reader::{Section, all_of};
use crate::manifest::tree::entries;
use crate::model::InitialState;

pub(super) fn read(state: &Section, retained: Option<usize>) -> Option<InitialState> {
    all_of!(InitialState::Modal {
        displacement: modal_vector(state, "displacement", retained),
        velocity: modal_vector(state, "velocity", retained),
    })
}

/// One number per retained mode.
pub(super) fn modal_vector(
    state: &Section,
    name: &str,
    retained: Option<usize>,
) -> Option<Vec<f64>> {
    let values = state.quantities(name, None)?;
    let retained = retained?;
    if values.len() == retained {
        return Some(values);
    }
    let path = state.path_of(name);
    let message = format!(
        "`{path}` has {} for {retained} retained modes",
        entries(values.len())
    );
    state
        .inconsistent(name, message)
        .label(format!("{retained} are needed"))
        .remedy("give one number per retained mode, in ascending frequency")
        .fail(state.issues)
}
