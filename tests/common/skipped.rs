//! Reports tests that this machine does not support, with the reason.

// Every test binary uses a part of it.
#![allow(dead_code)]

use std::fmt::Display;
use std::io::Write;

/// Writes `skipped: TEST: why` directly to the error stream, because libtest hides the output of the print macros in
/// tests that pass. `scripts/test` ends with a list of these lines.
pub fn skipped(why: impl Display) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let why = why.to_string().replace('\n', " ");
    let line = format!("skipped: {test}: {}\n", why.trim());
    _ = std::io::stderr().write_all(line.as_bytes());
}
