//! The targets of `fuzz/targets`, tested with inputs that once broke them and with some thousand mutated ones.
//!
//! The inputs follow from a seed, so that failures are reproducible; the bytes of a failure are in
//! `target/tmp/fuzz-targets`. `scripts/fuzz` runs the same targets with libFuzzer, which observes the program's
//! coverage, and with this program for a requested time.

#![allow(clippy::unwrap_used)]

use crate::{changed, dice, mutated, targets};
use changed::Changes;
use dice::Dice;
use gearatlas::numerics::random::Stream;
use mutated::Mutations;
use std::collections::BTreeMap;
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use targets::{TARGETS, Target, WRONG, named, seeds};

/// Time limit for an input; a target that takes longer counts as hanging.
const HANG: Duration = Duration::from_secs(60);

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Generates the inputs of a target.
enum Drawing {
    Mutated(Mutations),
    /// Drives that a manifest accepts more often than a mutated text.
    Changed(Changes, Mutations),
}

impl Drawing {
    fn of(target: &str) -> Self {
        let mutations = Mutations {
            seeds: seeds::of(target, repository()),
            words: seeds::dictionary(),
        };
        match target {
            "drive" => Self::Changed(Changes::of(&targets::BASES), mutations),
            _ => Self::Mutated(mutations),
        }
    }

    /// The input with a number under a seed.
    fn draw(&self, seed: u64, number: u64) -> Vec<u8> {
        let mut dice = Dice(Stream::new(seed, number, 0));
        match self {
            Self::Mutated(mutations) => mutations.draw(&mut dice),
            Self::Changed(changes, mutations) => {
                if dice.chance(0.9) {
                    changes.draw(&mut dice)
                } else {
                    mutations.draw(&mut dice)
                }
            }
        }
    }
}

/// Counts over some inputs.
#[derive(Debug, Default)]
struct Tally {
    inputs: u64,
    /// Inputs that broke the target, by message.
    broken: BTreeMap<String, Vec<PathBuf>>,
}

/// The message of a target for bytes that break it.
fn put(target: &Target, bytes: &[u8]) -> Result<(), String> {
    catch_unwind(|| (target.run)(bytes)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        text.unwrap_or_else(|| "a panic without a word".into())
    })
}

/// Tests a target with inputs on a separate thread, so that hangs are detected.
fn fuzz(target: &'static Target, seed: u64, until: impl Fn(u64) -> bool + Send + 'static) -> Tally {
    let folder = repository().join("target/tmp/fuzz-targets");
    fs::create_dir_all(&folder).unwrap();
    let name = move |number: u64| folder.join(format!("{}-{seed}-{number}", target.name));
    let (sender, receiver) = channel();
    let name_of = name.clone();
    let worker = std::thread::spawn(move || {
        let drawing = Drawing::of(target.name);
        let mut tally = Tally::default();
        while !until(tally.inputs) {
            let bytes = drawing.draw(seed, tally.inputs);
            sender.send(tally.inputs).unwrap();
            if let Err(said) = put(target, &bytes) {
                let path = name_of(tally.inputs);
                fs::write(&path, &bytes).unwrap();
                let said = said.lines().next().unwrap_or_default().to_owned();
                tally.broken.entry(said).or_default().push(path);
            }
            tally.inputs += 1;
        }
        tally
    });
    let mut last = 0;
    loop {
        match receiver.recv_timeout(HANG) {
            Ok(number) => last = number,
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                let path = name(last);
                fs::write(&path, Drawing::of(target.name).draw(seed, last)).unwrap();
                panic!("HANG: {} on {}", target.name, path.display());
            }
        }
    }
    worker.join().unwrap()
}

/// Panics of the targets are caught, counted and printed once; the standard hook would print each. Tests run on threads
/// with names, targets on one without.
fn hush() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if std::thread::current().name().is_some() {
                usual(panic);
            }
        }));
    });
}

fn unbroken(name: &str, inputs: u64) {
    hush();
    let tally = fuzz(named(name).unwrap(), 1, move |done| done >= inputs);
    assert!(tally.broken.is_empty(), "{:#?}", tally.broken);
    assert_eq!(tally.inputs, inputs);
}

macro_rules! unbroken {
    ($($test:ident: $target:literal, $inputs:literal;)*) => {
        $(
            #[test]
            fn $test() {
                unbroken($target, $inputs);
            }
        )*

        #[test]
        fn every_target_is_put_to_the_test() {
            let tested = [$($target),*];
            for target in &TARGETS {
                assert!(tested.contains(&target.name), "{}", target.name);
            }
        }
    };
}

unbroken! {
    manifests: "manifest", 1500;
    modal_files: "modal", 1500;
    changed_keys: "changes", 1000;
    points_files: "points", 1000;
    quantities: "units", 20_000;
    command_lines: "command", 1500;
    kept_tables: "table", 300;
    kept_tables_with_checksums: "table-sealed", 1500;
    journals: "journal", 500;
    journals_with_checksums: "journal-sealed", 500;
    result_tables: "results", 500;
    records: "record", 500;
    drives: "drive", 150;
    breakpoints: "breakpoints", 300;
}

/// Inputs that broke a target before a fix.
#[test]
fn what_once_broke_a_target_does_so_no_more() {
    for target in &TARGETS {
        for (path, bytes) in seeds::regressions(target.name, repository()) {
            let said = put(target, &bytes);
            assert!(said.is_ok(), "{}: {said:?}", path.display());
        }
    }
}

/// The check works: a target with a wrong result panics with the word that the counts use.
#[test]
fn a_wrong_answer_is_told_from_a_crash() {
    let wrong = Target {
        run: |_| panic!("{WRONG}2 points of 1"),
        ..*named("units").unwrap()
    };
    assert_eq!(put(&wrong, b""), Err("WRONG: 2 points of 1".into()));
}

/// For `scripts/fuzz`: runs ATLAS_FUZZ_SECONDS on the target ATLAS_FUZZ_TARGET, with seed ATLAS_FUZZ_SEED.
#[test]
#[ignore = "as long as asked for"]
#[allow(clippy::print_stdout)]
fn as_long_as_asked_for() {
    hush();
    let text = |name: &str, default: &str| std::env::var(name).unwrap_or_else(|_| default.into());
    let target = named(&text("ATLAS_FUZZ_TARGET", "drive")).unwrap();
    let seconds: u64 = text("ATLAS_FUZZ_SECONDS", "60").parse().unwrap();
    let seed: u64 = text("ATLAS_FUZZ_SEED", "2").parse().unwrap();
    let clock = Instant::now();
    let tally = fuzz(target, seed, move |_| clock.elapsed().as_secs() >= seconds);
    for (said, paths) in &tally.broken {
        println!(
            "BROKEN {} times, {}: {said}",
            paths.len(),
            paths[0].display()
        );
    }
    let wrong = |said: &&String| said.starts_with(WRONG);
    let kinds = tally.broken.keys();
    println!(
        "{}: {} inputs in {seconds} s, {} kinds of crash, {} of wrong answer",
        target.name,
        tally.inputs,
        kinds.clone().filter(|said| !wrong(said)).count(),
        kinds.filter(wrong).count(),
    );
    assert!(tally.broken.is_empty());
}
