//! The exit status at the end of a run.

use super::{BAD_INPUT, BUSY, FAILED_POINTS, INTERRUPTED};
use crate::store::{RunRecord, RunState, StoreError};

/// Exit status if results cannot be read or written.
pub(super) fn failure(error: &StoreError) -> u8 {
    match error {
        StoreError::Busy { .. } => BUSY,
        refused if refused.is_refusal() => BAD_INPUT,
        _ => 1,
    }
}

/// Exit status of a run with this record.
pub(super) fn status(record: &RunRecord) -> u8 {
    match record.state {
        RunState::Interrupted => INTERRUPTED,
        RunState::Complete if record.totals.failed > 0 => FAILED_POINTS,
        RunState::Complete => 0,
    }
}
