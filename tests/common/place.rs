//! A separate folder with a manifest, and `atlas` as a process in it.

// Every test binary uses a part of it.
#![allow(dead_code, clippy::unwrap_used)]

use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A one-degree oscillator: 2 loads, 3 speeds, seconds of work.
pub const OSCILLATOR: &str = include_str!("../data/oscillator.toml");

/// A folder with a manifest `m.toml` and the oscillator's modal file.
pub struct Place(pub TempDir);

impl Place {
    pub fn new(manifest: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("m.toml"), manifest).unwrap();
        fs::write(
            folder.path().join("oscillator.modal.toml"),
            include_str!("../data/oscillator.modal.toml"),
        )
        .unwrap();
        Self(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `atlas` with any arguments.
    pub fn atlas(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_atlas"));
        command.current_dir(self.0.path()).args(arguments);
        command.output().unwrap()
    }

    /// Runs a shell script, in which `$ATLAS` is the program.
    pub fn shell(&self, script: &str) -> Output {
        Command::new("bash")
            .current_dir(self.0.path())
            .env("ATLAS", env!("CARGO_BIN_EXE_atlas"))
            .args(["-c", script])
            .output()
            .unwrap()
    }

    /// `atlas run`, not started yet.
    pub fn command(&self, out: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_atlas"));
        command
            .current_dir(self.0.path())
            .args(["run", "m.toml", "--out", out])
            .args(arguments);
        command
    }

    pub fn run(&self, out: &str, arguments: &[&str]) -> Output {
        self.command(out, arguments).output().unwrap()
    }

    pub fn record(&self, out: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(out).join("run.json")).unwrap()).unwrap()
    }

    /// Runs to the end; points that do not settle within their cycles are allowed.
    pub fn whole(&self, out: &str, arguments: &[&str]) -> PathBuf {
        let output = self.run(out, arguments);
        assert!([0, 3].contains(&status(&output)), "{}", stderr(&output));
        self.path(out)
    }
}

pub fn status(output: &Output) -> i32 {
    output.status.code().unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}
