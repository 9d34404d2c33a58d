//! Tells the program which commit it was built from (`ATLAS_COMMIT`). A build outside a
//! git checkout, or without git, simply has no commit to report.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    for input in ["src", "build.rs", "Cargo.toml", "Cargo.lock"] {
        println!("cargo:rerun-if-changed={input}");
    }
    let Some(commit) = commit() else { return };
    println!("cargo:rustc-env=ATLAS_COMMIT={commit}");
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"])
        && Path::new(&log).exists()
    {
        println!("cargo:rerun-if-changed={log}");
    }
}

/// The commit checked out, with `-dirty` where the sources differ from it.
fn commit() -> Option<String> {
    // A source archive unpacked inside some other repository must not report that one.
    let top = git(&["rev-parse", "--show-toplevel"])?;
    let here = env::var_os("CARGO_MANIFEST_DIR")?;
    if Path::new(&top).canonicalize().ok()? != Path::new(&here).canonicalize().ok()? {
        return None;
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changes = git(&[
        "status",
        "--porcelain",
        "--",
        "src",
        "build.rs",
        "Cargo.toml",
        "Cargo.lock",
    ])?;
    Some(if changes.is_empty() { commit } else { format!("{commit}-dirty") })
}

/// Standard output of a git command, trimmed; nothing when it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    if !output.status.success() {
        return None;
    }
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
