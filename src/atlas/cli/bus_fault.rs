//! A mapped table that another program cuts down while this one reads it: the system stops the
//! reader by SIGBUS, and nothing can be done but to say which file it was.
//!
//! Checking lengths now and then would not help: the cut may come between a check and the next read.

use rustix::stdio::stderr;
use signal_hook::consts::SIGBUS;
use signal_hook::low_level::{exit, register};

use std::sync::atomic::{AtomicBool, Ordering};

use crate::store::cut_down;

/// Exit status, that of any file that cannot be read.
const STATUS: i32 = 1;

/// Has the process say why it ends. Where the system refuses, it would end without a word.
#[allow(unsafe_code)]
pub(super) fn say_which() {
    // SAFETY: the action runs in the handler of a signal. It asks for lengths of files, writes to
    // standard error and ends the process, each by one system call that is allowed there; it
    // neither allocates nor panics, and waits for nothing but the end of the process.
    _ = unsafe { register(SIGBUS, last_words) };
}

fn last_words() {
    static ENDING: AtomicBool = AtomicBool::new(false);
    // Other threads read the same file: the first one speaks, and ends all of them.
    while ENDING.swap(true, Ordering::Relaxed) {
        std::hint::spin_loop();
    }
    let mut named = false;
    cut_down(|name| {
        named = true;
        say(b"\nerror: `");
        say(name.as_bytes());
        say(
            b"` was made shorter by another program while it was read; remove the file (`atlas \
              table clean`) and repeat the command: finished points of a run are kept\n",
        );
    });
    if !named {
        say(
            b"\nerror: a mapped file can no longer be read (SIGBUS): look for faults of the disk \
              (`dmesg`), check the tables (`atlas table verify`) and repeat the command: finished \
              points of a run are kept\n",
        );
    }
    exit(STATUS);
}

/// Past the locks and buffers of the standard library.
fn say(text: &[u8]) {
    _ = rustix::io::write(stderr(), text);
}
