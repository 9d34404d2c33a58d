//! Jobs with only those instructions that every x86-64 processor has (`run.instructions = "portable"`).
//!
//! The program can restrict its loops at any time. The mathematical functions of the system (sin, exp, ...) choose an
//! implementation when a process starts; only the environment can restrict this choice.

use crate::manifest::Job;
use crate::numerics::instructions::keep_portable;

/// Restricts the process to portable instructions if the job demands it.
///
/// # Errors
/// The process was started without the environment variable for the system's library. The text has the command to
/// type.
pub fn restrict(job: &Job) -> Result<(), String> {
    if !job.portable() {
        return Ok(());
    }
    keep_portable();
    is_started_for_it()
}

/// Features that the GNU C library must not use; it ignores names that its version does not know.
#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
const WITHOUT: &str = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX,-AVX512F,-FMA_Usable,-FMA4_Usable,-AVX2_Usable,-AVX_Usable";

#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
fn is_started_for_it() -> Result<(), String> {
    const VARIABLE: &str = "GLIBC_TUNABLES";
    let tunables = std::env::var(VARIABLE).unwrap_or_default();
    let can_use_avx_or_fma = is_x86_feature_detected!("avx") || is_x86_feature_detected!("fma");
    if !can_use_avx_or_fma || tunables.contains(WITHOUT) {
        return Ok(());
    }
    let separator = if tunables.is_empty() { "" } else { ":" };
    let command: Vec<String> = std::env::args().map(|word| quoted(&word)).collect();
    Err(format!(
        "run.instructions = \"portable\" needs an environment variable that limits the system's mathematical library \
         to portable instructions; run\n  {VARIABLE}={} {}",
        quoted(&format!("{tunables}{separator}{WITHOUT}")),
        command.join(" ")
    ))
}

/// A word quoted for a shell.
#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,%+@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(not(all(target_env = "gnu", target_arch = "x86_64")))]
fn is_started_for_it() -> Result<(), String> {
    Ok(())
}
