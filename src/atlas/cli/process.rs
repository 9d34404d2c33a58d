//! Cancellation of a command by signals, and the description of the machine.
//!
//! A signal sets a flag, and the work ends when it checks this flag. Libraries do not check it, for example
//! during an eigenvalue problem with thousands of freedoms; nor does the computation of a mesh table.
//! Therefore a separate thread does the work, and the first thread ends the process if the work does not end
//! within [`PATIENCE`].

use super::{INTERRUPTED, fail};
use crate::sweep::this_machine;
use crate::topology::Topology;
use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use std::io;
use std::panic::resume_unwind;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time that cancelled work has to end by itself.
const PATIENCE: Duration = Duration::from_millis(700);

/// Interval at which the first thread checks for cancellation.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Stack of the working thread \[bytes\]: the default size for the first thread of a process.
const STACK: usize = 8 << 20;

/// Stage: results are being computed.
const WORKING: u8 = 0;
/// Stage: finished results are being written. The process does not end before they are written.
const WRITING: u8 = 1;
/// Stage: the process ends without waiting for the work.
const ENDING: u8 = 2;

/// The stage of the process; it leaves [`WORKING`] at most once.
static STAGE: AtomicU8 = AtomicU8::new(WORKING);

/// Set by Ctrl-C and SIGTERM from [`Process::prepare`] on.
static INTERRUPT: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Message of [`Process::prepare`] for an end without waiting for the work.
static LEFT: Mutex<String> = Mutex::new(String::new());

/// Message of commands that write only at their end.
pub const NOTHING_WRITTEN: &str = "interrupted; nothing was written";

/// Does the work of a command on a separate thread, and returns its status. Cancelled work that does not end in time is
/// abandoned; the status is then that of an interruption.
pub fn run_interruptibly(work: fn() -> ExitCode) -> ExitCode {
    let (done, waiting) = channel();
    let named = thread::Builder::new().name("main".to_owned());
    let worker = match named.stack_size(STACK).spawn(move || _ = done.send(work())) {
        Ok(worker) => worker,
        // Without a second thread, no thread watches `PATIENCE`: only a second signal ends work that hangs.
        Err(_) => return work(),
    };
    let mut since = None;
    loop {
        match waiting.recv_timeout(CHECK_INTERVAL) {
            Ok(status) => return status,
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {}
        }
        if !INTERRUPT.load(Ordering::Relaxed) {
            continue;
        }
        if since.get_or_insert_with(Instant::now).elapsed() >= PATIENCE && enter(ENDING) {
            let left = LEFT.lock().unwrap_or_else(PoisonError::into_inner);
            return fail(INTERRUPTED, &left);
        }
    }
    match worker.join() {
        Err(panic) => resume_unwind(panic),
        Ok(()) => ExitCode::FAILURE,
    }
}

/// Changes the stage from [`WORKING`] to `stage`. Returns false if the process is already in a different stage.
fn enter(stage: u8) -> bool {
    let entered = STAGE.compare_exchange(WORKING, stage, Ordering::AcqRel, Ordering::Acquire);
    entered.is_ok() || entered == Err(stage)
}

/// Marks the start of writing finished results, so that the process does not end before they are written.
/// Never returns if the process is already ending.
pub fn begin_writing() {
    if !enter(WRITING) {
        loop {
            thread::park();
        }
    }
}

/// Whether the first signal ends the process at once. False after [`Process::prepare`]: then it cancels the
/// work.
static AT_ONCE: LazyLock<Arc<AtomicBool>> = LazyLock::new(|| Arc::new(AtomicBool::new(true)));

/// Lets Ctrl-C and SIGTERM end the process at once with the status of an interruption, until [`Process::prepare`].
///
/// # Errors
/// Signals cannot be watched.
pub fn end_when_interrupted() -> io::Result<()> {
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_shutdown(signal, i32::from(INTERRUPTED), AT_ONCE.clone())?;
    }
    Ok(())
}

/// A process that watches signals and knows its machine.
#[derive(Debug)]
pub struct Process {
    /// Set by Ctrl-C and SIGTERM.
    pub interrupt: Arc<AtomicBool>,
    /// The machine, if it can be described.
    pub topology: Option<Topology>,
    /// Warnings for the user, one sentence each.
    pub warnings: Vec<String>,
}

impl Process {
    /// Lets signals cancel the work, and describes the machine. `left` is the message if the process has to
    /// end without waiting for the work.
    ///
    /// # Errors
    /// Signals cannot be watched; the error has been printed.
    pub fn prepare(left: &str) -> Result<Self, ExitCode> {
        left.clone_into(&mut LEFT.lock().unwrap_or_else(PoisonError::into_inner));
        let interrupt = INTERRUPT.clone();
        watch_signals(&interrupt)
            .map_err(|error| fail(1, &format!("cannot watch for signals: {error}")))?;
        AT_ONCE.store(false, Ordering::Relaxed);
        let (topology, warnings) = this_machine();
        Ok(Self {
            interrupt,
            topology,
            warnings,
        })
    }
}

/// Lets Ctrl-C and SIGTERM cancel the work; a second signal ends the process at once.
fn watch_signals(interrupt: &Arc<AtomicBool>) -> io::Result<()> {
    for signal in [SIGINT, SIGTERM] {
        let status = i32::from(INTERRUPTED);
        flag::register_conditional_shutdown(signal, status, interrupt.clone())?;
        flag::register(signal, interrupt.clone())?;
    }
    // Without a handler, this signal ends the process silently when a file exceeds `ulimit -f`. With a handler, the
    // write fails and the error is printed.
    flag::register(SIGXFSZ, Arc::default())?;
    Ok(())
}

/// Message of `atlas run` if the process ends without waiting for unfinished points.
pub(super) fn left(folder: &Path) -> String {
    format!(
        "interrupted: finished points are kept in the journal in {}; the same command continues",
        folder.display()
    )
}
