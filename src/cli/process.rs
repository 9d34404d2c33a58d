//! What a sweep needs of the process: signals that call it off, and the machine it runs on.

use super::INTERRUPTED;
use crate::sweep::this_machine;
use crate::topology::Topology;
use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

/// Whether a first signal ends the process: until something asks to be called off instead.
static AT_ONCE: LazyLock<Arc<AtomicBool>> = LazyLock::new(|| Arc::new(AtomicBool::new(true)));

/// Lets Ctrl-C and SIGTERM end the process at once with the status of what was interrupted, until
/// [`Process::prepare`].
///
/// # Errors
/// Signals cannot be watched.
pub fn end_when_interrupted() -> io::Result<()> {
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_shutdown(signal, i32::from(INTERRUPTED), AT_ONCE.clone())?;
    }
    Ok(())
}

/// A process ready for a sweep.
#[derive(Debug)]
pub struct Process {
    /// Raised by Ctrl-C and SIGTERM.
    pub called_off: Arc<AtomicBool>,
    /// The machine, where it can be described.
    pub topology: Option<Topology>,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

impl Process {
    /// Watches signals and looks at the machine.
    ///
    /// # Errors
    /// Signals cannot be watched.
    pub fn prepare() -> io::Result<Self> {
        let called_off = Arc::new(AtomicBool::new(false));
        watch_signals(&called_off)?;
        AT_ONCE.store(false, Ordering::Relaxed);
        let (topology, warnings) = this_machine();
        Ok(Self {
            called_off,
            topology,
            warnings,
        })
    }
}

/// Lets Ctrl-C and SIGTERM call the sweep off; a second one ends the process at once.
fn watch_signals(called_off: &Arc<AtomicBool>) -> io::Result<()> {
    for signal in [SIGINT, SIGTERM] {
        let status = i32::from(INTERRUPTED);
        flag::register_conditional_shutdown(signal, status, called_off.clone())?;
        flag::register(signal, called_off.clone())?;
    }
    // Unwatched, this one would end the process without a word when a file outgrows
    // `ulimit -f`; watched, the write fails and the error is said.
    flag::register(SIGXFSZ, Arc::default())?;
    Ok(())
}
