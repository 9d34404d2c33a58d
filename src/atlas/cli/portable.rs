//! A process that keeps to instructions that every processor has, where its manifest asks for it.
//!
//! The program's own loops are told. The system's library of functions (sin, exp, ...) chooses by
//! the processor when a process starts, and can be told only by the environment then: the process
//! starts itself again with it.

use crate::manifest::Job;
use crate::numerics::instructions::keep_portable;

/// Keeps to portable instructions if the job asks for it; comes back in a process that does. With
/// `piped` the manifest has been read from standard input, where the process finds it again.
///
/// # Errors
/// The program cannot be started again, in a sentence.
pub fn obey(job: &Job, piped: bool) -> Result<(), String> {
    if !job.portable() {
        return Ok(());
    }
    keep_portable();
    start_again(piped.then_some(&job.text))
}

/// What the GNU C library is to leave unused; names that a version does not know it passes over.
#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
const WITHOUT: &str = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX,-AVX512F,-FMA_Usable,-FMA4_Usable,-AVX2_Usable,-AVX_Usable";

#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
fn start_again(input: Option<&String>) -> Result<(), String> {
    use std::env;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    const VARIABLE: &str = "GLIBC_TUNABLES";
    let tunables = env::var(VARIABLE).unwrap_or_default();
    let choice = is_x86_feature_detected!("avx") || is_x86_feature_detected!("fma");
    if !choice || tunables.contains(WITHOUT) {
        return Ok(());
    }
    let all = match tunables.is_empty() {
        true => WITHOUT.to_owned(),
        false => format!("{tunables}:{WITHOUT}"),
    };
    let mut arguments = env::args_os();
    let mut again = Command::new("/proc/self/exe");
    if let Some(name) = arguments.next() {
        again.arg0(name);
    }
    let failed = |error| {
        format!(
            "run.instructions = \"portable\" needs the program to start itself again, which failed: {error}"
        )
    };
    if let Some(text) = input {
        again.stdin(as_file(text).map_err(failed)?);
    }
    // Returns only where it fails.
    Err(failed(again.args(arguments).env(VARIABLE, all).exec()))
}

/// A file in memory with a text, to be read from its start.
#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
fn as_file(text: &str) -> std::io::Result<std::fs::File> {
    use rustix::fs::{MemfdFlags, memfd_create};
    use std::io::{Seek, Write};

    let mut file = std::fs::File::from(memfd_create("manifest", MemfdFlags::CLOEXEC)?);
    file.write_all(text.as_bytes())?;
    file.rewind()?;
    Ok(file)
}

#[cfg(not(all(target_env = "gnu", target_arch = "x86_64")))]
fn start_again(_input: Option<&String>) -> Result<(), String> {
    Ok(())
}
