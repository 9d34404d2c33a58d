//! Says which tests this machine does not allow, and why.

// Every test binary uses a part of it.
#![allow(dead_code)]

use std::fmt::Display;
use std::io::Write;

/// Puts `skipped: TEST: why` on the error stream itself: libtest keeps what the print macros write of
/// tests that pass, and nobody would know. `scripts/test` ends with a list of these lines.
pub fn skipped(why: impl Display) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let why = why.to_string().replace('\n', " ");
    let line = format!("skipped: {test}: {}\n", why.trim());
    _ = std::io::stderr().write_all(line.as_bytes());
}
