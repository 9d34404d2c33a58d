//! Arguments of the command line, parsed without execution.

use gearatlas::cli::understood;
use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;

/// One argument per line, with any bytes.
pub fn command(data: &[u8]) {
    let lines = data.split(|byte| *byte == b'\n').take(40);
    let arguments = lines.map(|line| OsString::from_vec(line.to_vec()));
    let arguments = std::iter::once("atlas".into()).chain(arguments);
    if let Err(refusal) = understood(arguments) {
        // Help and versions are also texts.
        super::right(!refusal.to_string().is_empty(), || {
            "refused without a word".into()
        });
    }
}
