//! Processes that should detect the instructions of their processor, emulated or not.

// Every test binary uses a part of it.
#![allow(dead_code)]

use std::env;
use std::process::Command;

/// Prefixes of the names of variables that choose instructions or the emulated processor instead of detection.
/// tests/python/program.py has the same list.
const CHOOSE_INSTRUCTIONS: [&str; 14] = [
    "ARROW_",
    "ATEN_CPU_",
    "BLIS_",
    "DNNL_",
    "GLIBC_TUNABLES",
    "GOTO_",
    "LD_HWCAP_MASK",
    "MKL_",
    "NPY_",
    "NVPL_",
    "ONEDNN_",
    "OPENBLAS_",
    "POLARS_SKIP_CPU_CHECK",
    "QEMU_",
];

/// Removes the variables that choose instructions from the environment of a command.
pub fn without_chosen_instructions(command: &mut Command) -> &mut Command {
    for (name, _) in env::vars_os() {
        let chooses = |beginning: &&str| name.to_string_lossy().starts_with(*beginning);
        if CHOOSE_INSTRUCTIONS.iter().any(chooses) {
            command.env_remove(&name);
        }
    }
    command
}
