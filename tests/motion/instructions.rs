//! A run records its instruction set, and `portable` gives the same bits on every processor. If an emulator is
//! installed, the test uses an emulated processor without fused multiply-adds and wide vectors.

#![allow(clippy::unwrap_used)]

use crate::program::PORTABLE;
use crate::{processor, skipped};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use gearatlas::store::{ResultTable, TableKind, read_runs};
use processor::without_chosen_instructions;
use skipped::skipped;

const QUICKSTART: &str = include_str!("../../manifests/quickstart.toml");

/// A few points of the drive with all linear algebra: modes, multipliers, spectra.
fn manifest(instructions: &str) -> String {
    let text = QUICKSTART
        .replacen(
            "[run] ",
            &format!("[run]\ninstructions = \"{instructions}\"\n#"),
            1,
        )
        .replacen("count = 3 }", "count = 2 }", 1)
        .replacen("cycles = 160000", "cycles = 600", 1)
        .replacen(
            "nvh = { harmonics = 5 }",
            "nvh = { harmonics = 3, spectrum = {} }",
            1,
        )
        .replacen("transient = 500", "transient = 100", 1);
    assert!(text.contains("instructions") && text.contains("spectrum") && text.contains("600"));
    text
}

fn run(folder: &Path, instructions: &str, out: &str, emulator: &[&str]) -> Output {
    let name = format!("{instructions}.toml");
    fs::write(folder.join(&name), manifest(instructions)).unwrap();
    let program = [emulator, &[env!("CARGO_BIN_EXE_atlas")]].concat();
    let mut command = Command::new(program[0]);
    command
        .args(&program[1..])
        .args(["run", &name, "--out", out, "--threads", "2", "--quiet"])
        .current_dir(folder);
    without_chosen_instructions(&mut command);
    if instructions == "portable" {
        command.env(PORTABLE[0], PORTABLE[1]);
    }
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 3)), "{said}");
    output
}

/// Every number of the points and spectra, except those about place and time.
fn numbers(folder: &Path) -> Vec<(String, Vec<Option<u64>>)> {
    let elsewhere = ["wall_time", "worker", "numa_node"];
    let mut all = Vec::new();
    for kind in [TableKind::Points, TableKind::Poincare, TableKind::Spectra] {
        let table = ResultTable::read(folder, kind).unwrap();
        for name in table.units().unwrap().into_keys() {
            if elsewhere.contains(&name.as_str()) {
                continue;
            }
            if let Ok(values) = table.f64(&name) {
                let bits = values.into_iter().map(|value| value.map(f64::to_bits));
                all.push((format!("{kind:?}.{name}"), bits.collect()));
            } else if let Ok(lists) = table.lists(&name) {
                let bits = lists.into_iter().flatten().flatten();
                let bits = bits.map(|value| value.map(f64::to_bits));
                all.push((format!("{kind:?}.{name}"), bits.collect()));
            }
        }
    }
    assert!(all.len() > 30, "{}", all.len());
    all
}

#[test]
fn a_run_records_its_instructions_and_portable_ones_are_another_job() {
    let folder = tempfile::tempdir().unwrap();
    let mut hashes = Vec::new();
    for (instructions, known) in [
        ("auto", &["avx512", "avx2", "baseline"][..]),
        ("portable", &["portable"]),
    ] {
        run(folder.path(), instructions, instructions, &[]);
        let record = read_runs(&folder.path().join(instructions))
            .unwrap()
            .remove(0);
        let [used] = &record.machine.instructions[..] else {
            panic!("{:?}", record.machine.instructions);
        };
        assert!(known.contains(&used.as_str()), "{used}");
        hashes.push(record.manifest_hash);
    }
    assert_ne!(hashes[0], hashes[1]);
    // Other instructions give other bits.
    let [auto, portable] = ["auto", "portable"].map(|out| numbers(&folder.path().join(out)));
    let record = read_runs(&folder.path().join("auto")).unwrap().remove(0);
    match &*record.machine.instructions[0] {
        "baseline" => skipped("no instructions here but those that every processor has"),
        _ => assert_ne!(auto, portable),
    }
}

#[test]
fn portable_results_have_the_same_bits_on_a_plain_processor() {
    const EMULATOR: &str = "qemu-x86_64";
    if Command::new(EMULATOR).arg("--version").output().is_err() {
        skipped(format!("{EMULATOR} is not installed"));
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), "portable", "here", &[]);
    // The emulated processor has no AVX and no FMA, only the instructions of every 64-bit processor and a few of 2009.
    run(
        folder.path(),
        "portable",
        "plain",
        &[EMULATOR, "-cpu", "Nehalem"],
    );
    let plain = read_runs(&folder.path().join("plain")).unwrap().remove(0);
    assert!(
        !plain.machine.isa.iter().any(|set| set == "fma"),
        "{:?}",
        plain.machine.isa
    );
    let [here, there] = ["here", "plain"].map(|out| numbers(&folder.path().join(out)));
    for (here, there) in here.iter().zip(&there) {
        assert_eq!(here, there);
    }
    assert_eq!(here.len(), there.len());
}

#[test]
fn tables_that_processors_make_differently_are_not_portable() {
    let folder = tempfile::tempdir().unwrap();
    let text = manifest("portable")
        .replacen("cycles = 600", "kernel = \"closed_modes\"\ncycles = 600", 1)
        .replacen("[mesh]", "[mesh]\ncoast_flank = \"same_line\"\n#", 1);
    fs::write(folder.path().join("m.toml"), text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(["check", "m.toml"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("run.instructions") || said.contains("instructions = \"portable\""),
        "{said}"
    );
    assert!(said.contains("same on every processor"), "{said}");
}
