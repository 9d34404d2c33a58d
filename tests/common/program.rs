//! `atlas` as a process in a folder.

// Every test binary uses a part of it.
#![allow(dead_code, clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

/// The variable without which a portable job is refused, and its value.
pub const PORTABLE: [&str; 2] = [
    "GLIBC_TUNABLES",
    "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX,-AVX512F,-FMA_Usable,-FMA4_Usable,-AVX2_Usable,-AVX_Usable",
];

/// Output of a command; a portable job runs with the variable [`PORTABLE`].
pub fn atlas(folder: impl AsRef<Path>, arguments: &[&str]) -> Output {
    let is_portable = arguments.contains(&"run.instructions=portable");
    let [name, value] = PORTABLE;
    Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(arguments)
        .envs(is_portable.then_some((name, value)))
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Output of a command that must succeed; this includes a run with points that did not converge.
#[track_caller]
pub fn said(folder: impl AsRef<Path>, arguments: &[&str]) -> String {
    let output = atlas(folder, arguments);
    let (status, errors) = (output.status.code(), String::from_utf8(output.stderr));
    assert!(matches!(status, Some(0 | 3)), "{status:?} {errors:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// Standard output of a command without messages.
#[track_caller]
pub fn printed(folder: impl AsRef<Path>, arguments: &[&str]) -> String {
    let output = atlas(folder, arguments);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        (output.status.code(), &errors[..]),
        (Some(0), ""),
        "{arguments:?}"
    );
    String::from_utf8(output.stdout).unwrap()
}

/// The message of a command that fails with a status.
#[track_caller]
pub fn refused(folder: impl AsRef<Path>, arguments: &[&str], status: i32) -> String {
    let output = atlas(folder, arguments);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}
