//! Arguments of the command line; nothing is carried out.

use gearatlas::cli::understood;
use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;

/// An argument a line, of any bytes.
pub fn command(data: &[u8]) {
    let lines = data.split(|byte| *byte == b'\n').take(40);
    let arguments = lines.map(|line| OsString::from_vec(line.to_vec()));
    let arguments = std::iter::once("atlas".into()).chain(arguments);
    if let Err(refusal) = understood(arguments) {
        // Help and versions are texts as well.
        super::right(!refusal.to_string().is_empty(), || {
            "refused without a word".into()
        });
    }
}
