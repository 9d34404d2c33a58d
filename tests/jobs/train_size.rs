//! Are trains that are too fine to be solved refused before any allocation, with the key that causes it?

#![allow(clippy::unwrap_used)]

use crate::place;
use place::{Place, status, stderr, stdout};

const TRAIN: &str = include_str!("../../manifests/trains/two-stage.toml");

/// Limit of the address space of a command \[KiB\]: the program's usual mappings, and 200 MB.
const ADDRESSES: usize = 400_000;

/// Output of `atlas` for the train with a replaced part, with little memory: status, everything printed.
fn of(from: &str, to: &str, command: &str) -> (i32, String) {
    assert!(TRAIN.contains(from), "{from}");
    let place = Place::new(&TRAIN.replacen(from, to, 1));
    let output = place.shell(&format!("ulimit -v {ADDRESSES}; exec \"$ATLAS\" {command}"));
    let said = [stdout(&output), stderr(&output)].concat();
    (status(&output), said)
}

#[test]
fn sections_that_take_too_many_elements_are_refused_with_their_key() {
    let counter = "sections = [{ length = \"100 mm\", outer = \"35 mm\" }]";
    let counter_of = |length: &str, outer: &str| {
        format!("sections = [{{ length = \"{length}\", outer = \"{outer}\" }}]")
    };
    let elements = format!("{counter}\nelement = \"1e-9 mm\"");
    let long = "{ length = \"50 mm\", outer = \"25 mm\" },";
    for (from, to, key, words) in [
        // 2858 elements with 17 000 degrees of freedom would take 7 GB, and the eigensolver would panic.
        (
            counter,
            counter_of("100 mm", "0.035 mm"),
            "train.shaft.1.sections.0.outer",
            "did you mean 35 mm?",
        ),
        (
            counter,
            counter_of("100 mm", "1e-12 mm"),
            "train.shaft.1.sections.0.outer",
            "lengthen the elements",
        ),
        (
            long,
            long.replace("50 mm", "1e100 mm"),
            "train.shaft.0.sections.0.length",
            "lengthen the elements",
        ),
        (
            counter,
            counter_of("100 km", "35 mm"),
            "train.shaft.1.sections.0.length",
            "did you mean 100 mm?",
        ),
        (
            counter,
            elements,
            "train.shaft.1.element",
            "lengthen the elements",
        ),
    ] {
        for command in ["check m.toml", "run m.toml", "plan m.toml"] {
            let (status, said) = of(from, &to, command);
            assert_eq!(status, 2, "{command} {to}: {said}");
            for word in [words, "at most 4000", "GB", "m.toml:"] {
                assert!(said.contains(word), "{word}: {said}");
            }
        }
        let (_, said) = of(from, &to, "check m.toml --json");
        assert!(said.contains(&format!("\"{key}\"")), "{key}: {said}");
    }
}

/// A solvable train that looks like a wrong unit gives a warning, and is computed.
#[test]
fn a_shaft_that_nobody_builds_is_a_warning() {
    let from = "sections = [{ length = \"100 mm\", outer = \"35 mm\" }]";
    let thin = "sections = [{ length = \"100 mm\", outer = \"0.35 mm\" }]\nelement = \"20 mm\"";
    let (status, said) = of(from, thin, "check m.toml");
    assert_eq!(status, 0, "{said}");
    assert!(said.contains("train.shaft.1.sections.0.outer"), "{said}");
    assert!(said.contains("did you mean 350 mm?"), "{said}");
    let (status, said) = of(from, from, "check m.toml");
    assert_eq!(status, 0, "{said}");
    assert!(!said.contains("did you mean"), "{said}");
}
