//! Has the user interrupted the work?

use crate::propagate::Stop;
use std::sync::atomic::{AtomicBool, Ordering};

/// The work was interrupted; the point has no results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted before the point was finished")]
pub struct Interrupted;

/// Why a motion was not measured to its end.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum EndedEarly {
    /// The work was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A trajectory cannot be advanced.
    #[error(transparent)]
    Stop(#[from] Stop),
}

impl Interrupted {
    /// Ends the work if it was interrupted.
    ///
    /// # Errors
    /// [`Interrupted`] if the flag is raised.
    pub fn check(flag: &AtomicBool) -> Result<(), Self> {
        if flag.load(Ordering::Relaxed) { Err(Self) } else { Ok(()) }
    }
}
