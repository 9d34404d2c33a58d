//! Work that Ctrl-C can interrupt.

use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Interval between checks for Ctrl-C and for progress while the work runs.
const CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// Runs `work` on a separate thread, without the interpreter's lock. Meanwhile calls `between` periodically, and once
/// at the end. Returns the result of `work`.
///
/// # Errors
/// The exception of Ctrl-C or of `between`. The flag then ends the work, and the function waits for its end.
pub fn attended<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&AtomicBool) -> T + Send,
    mut between: impl FnMut(Python<'_>) -> PyResult<()>,
) -> PyResult<T> {
    let interrupt = AtomicBool::new(false);
    thread::scope(|scope| {
        let waiting = thread::current();
        let flag = &interrupt;
        let working = scope.spawn(move || {
            let done = work(flag);
            waiting.unpark();
            done
        });
        let mut raised = Ok(());
        while !working.is_finished() {
            py.detach(|| thread::park_timeout(CHECK_INTERVAL));
            if raised.is_ok() {
                raised = py.check_signals().and_then(|()| between(py));
                interrupt.store(raised.is_err(), Ordering::Relaxed);
            }
        }
        let done = working.join().unwrap_or_else(|panic| resume_unwind(panic));
        raised?;
        between(py)?;
        Ok(done)
    })
}
