//! What a sweep needs of the process: signals that call it off, and the machine it runs on.
//!
//! Work that is called off ends by itself where it looks at the flag. Libraries do not (an eigenvalue problem
//! of thousands of freedoms), nor does a table in the making: so the work is done on a thread of its own, and
//! the first thread ends the process where the work does not end within [`PATIENCE`].

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

/// How long work that was called off may take to end by itself.
const PATIENCE: Duration = Duration::from_millis(700);

/// How often the first thread looks whether the work was called off.
const LOOK_UP: Duration = Duration::from_millis(50);

/// Stack of the thread that does the work \[bytes\]: what the first thread of a process has by default.
const STACK: usize = 8 << 20;

/// Results are being computed.
const WORKING: u8 = 0;
/// What is finished is being written: this is waited for.
const WRITING: u8 = 1;
/// The process ends without waiting for the work.
const ENDING: u8 = 2;

/// What the process is doing; it leaves [`WORKING`] once.
static STAGE: AtomicU8 = AtomicU8::new(WORKING);

/// Raised by Ctrl-C and SIGTERM from [`Process::prepare`] on.
static CALLED_OFF: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// What is said where the process ends without waiting.
static LEFT: Mutex<String> = Mutex::new(String::new());

/// What is said of commands that write when all is done.
pub const NOTHING_WRITTEN: &str = "interrupted; nothing was written";

/// Does the work of a command on a thread of its own, and gives its status. Work that is called off and does not
/// end by itself is left where it is: then the status is that of what was interrupted.
pub fn attend(work: fn() -> ExitCode) -> ExitCode {
    let (done, waiting) = channel();
    let named = thread::Builder::new().name("main".to_owned());
    let worker = match named.stack_size(STACK).spawn(move || _ = done.send(work())) {
        Ok(worker) => worker,
        // Without another thread a second signal ends the process.
        Err(_) => return work(),
    };
    let mut since = None;
    loop {
        match waiting.recv_timeout(LOOK_UP) {
            Ok(status) => return status,
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {}
        }
        if !CALLED_OFF.load(Ordering::Relaxed) {
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

/// Leaves [`WORKING`] for another stage; false where the process has left it for a third one.
fn enter(stage: u8) -> bool {
    let entered = STAGE.compare_exchange(WORKING, stage, Ordering::AcqRel, Ordering::Acquire);
    entered.is_ok() || entered == Err(stage)
}

/// From now on what is finished is written, which the end of the process waits for.
pub fn begin_writing() {
    if !enter(WRITING) {
        loop {
            thread::park();
        }
    }
}

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
    /// Watches signals and looks at the machine; `left` is what the user is told where the process has to
    /// end without waiting for its work.
    ///
    /// # Errors
    /// Signals cannot be watched.
    pub fn prepare(left: &str) -> io::Result<Self> {
        left.clone_into(&mut LEFT.lock().unwrap_or_else(PoisonError::into_inner));
        let called_off = CALLED_OFF.clone();
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

/// What is said where the process ends without waiting for a point.
pub(super) fn left(folder: &Path) -> String {
    format!(
        "interrupted: finished points are kept in the journal in {}; the same command continues",
        folder.display()
    )
}
