//! `atlas fmu`: the archive, and refusals. `tests/python/test_fmu.py` steps the FMU.

use crate::common::skipped::skipped;
use crate::program::{printed, refused};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The library from this build; `None` if the crate was not built.
fn library() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_BIN_EXE_atlas")).with_file_name("libatlas_fmu.so");
    if path.exists() {
        return Some(path);
    }
    skipped("libatlas_fmu.so is not built; `cargo test --workspace` builds it");
    None
}

fn shipped(name: &str) -> String {
    format!("{}/manifests/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_same_manifest_gives_the_same_bytes() {
    if library().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let manifest = shipped("quickstart");
    for fmi in ["2", "3"] {
        let files = ["a.fmu", "b.fmu"].map(|out| {
            let said = printed(&folder, &["fmu", &manifest, "--fmi", fmi, "--out", out]);
            assert!(
                said.starts_with(out) && said.contains("pinion.torque"),
                "{said}"
            );
            fs::read(folder.path().join(out)).unwrap()
        });
        assert!(files[0] == files[1]);
        for out in ["a.fmu", "b.fmu"] {
            fs::remove_file(folder.path().join(out)).unwrap();
        }
    }
    printed(&folder, &["fmu", &manifest, "--json"]);
    let said = refused(&folder, &["fmu", &manifest], 2);
    assert!(said.contains("`quickstart.fmu` already exists"), "{said}");
}

/// Every co-simulation function of the two standards, and all others of FMI 3.0, are symbols of the library.
#[test]
fn all_functions_are_exported() {
    let Some(library) = library() else { return };
    let bytes = fs::read(library).unwrap();
    // Names of symbols are consecutive, each with a zero at its end.
    let names: BTreeSet<&[u8]> = (bytes.split(|byte| *byte == 0))
        .filter(|name| name.starts_with(b"fmi2") || name.starts_with(b"fmi3"))
        .filter(|name| name.iter().all(u8::is_ascii_alphanumeric))
        .collect();
    let of = |version: &[u8]| {
        names
            .iter()
            .filter(|name| name.starts_with(version))
            .count()
    };
    assert_eq!([of(b"fmi2"), of(b"fmi3")], [34, 75]);
}

#[test]
fn what_is_no_fmu_is_refused() {
    if library().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (manifest, said) in [
        (
            "trains/planetary",
            "what a torque on the wheel's shaft does",
        ),
        ("trains/clutch-hysteresis", "a dry slider"),
        ("basins", "give torque_pinion, torque_wheel and teeth_wheel"),
    ] {
        let errors = refused(&folder, &["fmu", &shipped(manifest)], 2);
        assert!(errors.contains(said), "{errors}");
    }
    let quickstart = shipped("quickstart");
    let drag = "shafts.wheel.drag=1e-3 N*m*s/rad";
    let errors = refused(&folder, &["fmu", &quickstart, "--set", drag], 2);
    assert!(errors.contains("does not turn freely"), "{errors}");
    fs::write(folder.path().join("other.so"), "gearatlas-fmu 0.0.9 #").unwrap();
    let errors = refused(&folder, &["fmu", &quickstart, "--library", "other.so"], 2);
    assert!(
        errors.contains("`other.so`: it is not the library of this version"),
        "{errors}"
    );
    let errors = refused(&folder, &["fmu", &quickstart, "--library", "none.so"], 2);
    assert!(errors.contains("`none.so` cannot be read"), "{errors}");
    let errors = refused(&folder, &["fmu", &quickstart, "--point", "12"], 2);
    assert!(errors.contains("there is no point 12"), "{errors}");
    assert!(
        fs::read_dir(&folder).unwrap().count() == 1,
        "nothing is written"
    );
}
