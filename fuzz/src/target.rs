//! One target of `fuzz/targets` for libFuzzer, selected by ATLAS_FUZZ_TARGET.
//!
//! With ATLAS_FUZZ_SEEDS it writes the seeds of all targets and the dictionary to that folder instead, and ends.

#![no_main]

#[path = "../targets/mod.rs"]
mod targets;

use libfuzzer_sys::fuzz_target;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;
use targets::{TARGETS, Target, named, seeds};

static TARGET: OnceLock<&Target> = OnceLock::new();

fuzz_target!(init: begin(), |data: &[u8]| {
    if let Some(target) = TARGET.get() {
        (target.run)(data);
    }
});

/// Selects the target. A panic that the program catches, for example in the decoding of files, must not reach the
/// fuzzer: only one that leaves the target ends the process.
fn begin() {
    _ = std::panic::take_hook();
    if let Some(folder) = std::env::var_os("ATLAS_FUZZ_SEEDS") {
        write_seeds(Path::new(&folder));
        std::process::exit(0);
    }
    let name = std::env::var("ATLAS_FUZZ_TARGET").unwrap_or_default();
    let Some(target) = named(&name) else {
        eprintln!("ATLAS_FUZZ_TARGET is `{name}`, not the name of a target");
        std::process::exit(2);
    };
    _ = TARGET.set(target);
}

fn write_seeds(folder: &Path) {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for target in &TARGETS {
        let own = folder.join(target.name);
        fs::create_dir_all(&own).expect("a folder that can be written");
        for (number, seed) in seeds::of(target.name, &repository).iter().enumerate() {
            fs::write(own.join(format!("seed-{number}")), seed).expect("a file");
        }
        println!("{}\t{}", target.name, target.about);
    }
    let words = seeds::dictionary();
    let escaped = words.iter().map(|word| {
        let bytes = word.bytes().map(|byte| format!("\\x{byte:02x}"));
        format!("\"{}\"\n", bytes.collect::<String>())
    });
    fs::write(folder.join("dictionary"), escaped.collect::<String>()).expect("a file");
}
