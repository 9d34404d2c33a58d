//! A table that another program cuts down while a run reads it where it is mapped: the run says which
//! file it was, what it finished stays, and the same command ends with the bits of an undisturbed run.

#![allow(clippy::unwrap_used)]

use crate::{place, results};
use place::{OSCILLATOR, Place, status, stderr};
use results::assert_same;
use std::fs::{self, OpenOptions, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Tables beyond this length are mapped \[bytes\] (`MOST_READ` of the store).
const MOST_READ: u64 = 64 << 20;

/// What a run may take to finish its first point.
const PATIENCE: Duration = Duration::from_secs(120);

/// A drive of forty modes whose mesh has so many stiffnesses that its systems are more than is read.
fn large() -> Place {
    const MODES: usize = 40;
    const LEVELS: usize = 15;
    let values: Vec<String> = (0..LEVELS)
        .map(|i| format!("{}", 4e8 + 4e6 * i as f64))
        .collect();
    let mesh = format!("values = [{}]", values.join(", "));
    let text = OSCILLATOR
        .replace(
            "mean_stiffness = \"4e8 N/m\"\ncontact_ratio = 1.6\nsingle_pair_drop = 0.25\n",
            "",
        )
        .replace("[mesh]\n", &format!("[mesh]\n{mesh}\n"))
        .replace("[run]\n", "[run]\nkernel = \"closed_modes\"\n")
        .replace("cycles = 300", "cycles = 2000");
    assert!(
        text.contains("closed_modes") && text.contains("2000") && !text.contains("contact_ratio")
    );
    let place = Place::new(&text);
    let list = |of: &dyn Fn(usize) -> f64| {
        let numbers: Vec<String> = (0..MODES).map(|i| format!("{:?}", of(i))).collect();
        format!("[{}]", numbers.join(", "))
    };
    let modal = format!(
        "teeth = 20\nrated_force = 1330.0\nfrequency = {}\ndamping = {}\nmesh = {}\ntorque = {}\n",
        list(&|i| 700.0 * i as f64),
        list(&|i| if i == 0 { 0.0 } else { 0.03 }),
        list(&|i| 0.877 / (1.0 + i as f64)),
        list(&|i| 0.877 / (1.0 + i as f64)),
    );
    fs::write(place.path("oscillator.modal.toml"), modal).unwrap();
    place
}

/// The tables in a folder.
fn tables(place: &Place, folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(place.path(folder)).into_iter().flatten();
    entries.map(|entry| entry.unwrap().path()).collect()
}

#[test]
#[ignore = "takes a minute: cargo test --release --test jobs -- --ignored cut_table"]
fn a_run_whose_table_is_cut_down_says_so_and_goes_on_when_repeated() {
    let place = large();
    place.whole("whole", &["--threads", "2", "--tables", "kept"]);
    let [table] = &tables(&place, "kept")[..] else {
        panic!("{:?}", tables(&place, "kept"));
    };
    let length = fs::metadata(table).unwrap().len();
    assert!(length > MOST_READ, "{length}");

    let mut child = place
        .command("r", &["--threads", "2", "--tables", "kept"])
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let journal = place.path("r/.journal");
    let start = Instant::now();
    // Beyond its head: a point is finished.
    while fs::metadata(&journal).map_or(0, |found| found.len()) < 400 {
        assert!(start.elapsed() < PATIENCE, "no point");
        assert!(child.try_wait().unwrap().is_none(), "ended too soon");
        sleep(Duration::from_millis(2));
    }
    // Nobody may write it, but its owner may let himself.
    fs::set_permissions(table, Permissions::from_mode(0o644)).unwrap();
    OpenOptions::new()
        .write(true)
        .open(table)
        .unwrap()
        .set_len(4096)
        .unwrap();

    let output = child.wait_with_output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{:?} {said}", output.status);
    let name = table.file_name().unwrap().to_str().unwrap();
    for words in [name, "made shorter", "repeat the command"] {
        assert_eq!(said.matches(words).count(), 1, "{said}");
    }
    assert!(fs::metadata(&journal).unwrap().len() >= 400);

    // The table is found to be damaged and made anew; what was finished is not computed again.
    let again = place.run("r", &["--threads", "2", "--tables", "kept"]);
    assert!([0, 3].contains(&status(&again)), "{}", stderr(&again));
    let warnings = place.record("r")["warnings"].to_string();
    assert!(warnings.contains("cut off"), "{warnings}");
    let resumed = place.record("r")["totals"]["resumed"].as_u64().unwrap();
    assert!((1..6).contains(&resumed), "{resumed}");
    let all = ["points.parquet", "poincare.parquet", "spectra.parquet"];
    assert_same(&all, &place.path("whole"), &place.path("r"));
}
