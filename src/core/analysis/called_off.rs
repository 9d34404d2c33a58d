//! Has the work been called off meanwhile?

use std::sync::atomic::{AtomicBool, Ordering};

/// The work was called off; nothing is known of the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted before the point was finished")]
pub struct CalledOff;

impl CalledOff {
    /// Ends the work where it was called off.
    ///
    /// # Errors
    /// [`CalledOff`] when the flag is raised.
    pub fn check(flag: &AtomicBool) -> Result<(), Self> {
        if flag.load(Ordering::Relaxed) { Err(Self) } else { Ok(()) }
    }
}
