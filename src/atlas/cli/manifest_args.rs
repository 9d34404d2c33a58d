//! The manifest argument of a command, and the keys that `--set` changes.

use super::{BAD_INPUT, fail, portable, refuses_colours};
use crate::manifest::{self, Job, ManifestErrors, Warnings};
use clap::Args;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// A manifest with some keys changed.
#[derive(Debug, Args)]
pub struct ManifestArgs {
    /// Manifest to read. `-` reads it from standard input; relative paths in it then start at the current folder.
    #[arg(value_name = "MANIFEST")]
    pub path: PathBuf,
    /// Change a key of the manifest for this command: --set mesh.half_gap="20 um", --set grid.load=0.1. The value is
    /// TOML, or text without quotes. An empty value removes the key: --set run.initial=. Repeat --set for several keys.
    /// The results record the changes.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

impl ManifestArgs {
    /// The name of the manifest in messages.
    pub fn name(&self) -> String {
        if self.is_stream() {
            "standard input".to_owned()
        } else {
            self.path.display().to_string()
        }
    }

    /// The folder at which relative paths in the manifest start.
    pub fn base(&self) -> &Path {
        match self.path.parent() {
            Some(folder) if !self.is_stream() => folder,
            _ => Path::new(""),
        }
    }

    fn is_stream(&self) -> bool {
        self.path == Path::new("-")
    }

    /// The job of the manifest.
    ///
    /// # Errors
    /// All errors of the manifest and of the changes.
    pub fn load(&self) -> Result<Job, ManifestErrors> {
        if self.is_stream() {
            manifest::read_changed(&mut std::io::stdin().lock(), &self.name(), &self.set)
        } else {
            manifest::load_changed(&self.path, &self.set)
        }
    }

    /// The job of the manifest, for a command that computes. Shows the warnings of the manifest, and
    /// restricts the process to portable instructions if the job demands it. On failure, shows the errors and
    /// returns the exit status.
    pub fn read_job(&self) -> Result<Job, ExitCode> {
        let job = self.load().map_err(|errors| {
            report(&errors);
            ExitCode::from(BAD_INPUT)
        })?;
        portable::restrict(&job).map_err(|message| fail(BAD_INPUT, &message))?;
        warn(&job.warnings);
        Ok(job)
    }
}

/// Shows the errors of a manifest on standard error, in colour on a terminal.
pub fn report(errors: &ManifestErrors) {
    let text = errors.render(colour());
    print_line(&format!("{text}{}\n", errors.summary()));
}

/// Shows the warnings of a manifest on standard error, in colour on a terminal.
pub fn warn(warnings: &Warnings) {
    if warnings.is_empty() {
        return;
    }
    let text = warnings.render(colour());
    print_line(&format!("{text}{}\n", warnings.summary()));
}

fn colour() -> bool {
    std::io::stderr().is_terminal() && !refuses_colours()
}

/// Writes a text to standard error; ignores a closed standard error.
fn print_line(text: &str) {
    _ = std::io::stderr().lock().write_all(text.as_bytes());
}
