//! A table that another program truncates while a run uses it: the run ends with the bits of an undisturbed one, and
//! the next run computes the table again.

#![allow(clippy::unwrap_used)]

use crate::{place, results};
use place::{OSCILLATOR, Place, status, stderr};
use results::assert_same;
use std::fs::{self, OpenOptions, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time limit of a run for its first point.
const PATIENCE: Duration = Duration::from_secs(120);

#[test]
fn a_run_whose_table_is_cut_down_goes_on() {
    let text = OSCILLATOR
        .replace("[run]\n", "[run]\nkernel = \"closed_modes\"\n")
        .replace("cycles = 300", "cycles = 60000");
    assert!(text.contains("closed_modes") && text.contains("60000"));
    let place = Place::new(&text);
    let arguments = ["--threads", "1", "--tables", "kept"];
    place.whole("whole", &arguments);
    let tables: Vec<_> = fs::read_dir(place.path("kept")).unwrap().collect();
    let [Ok(table)] = &tables[..] else {
        panic!("{tables:?}");
    };
    let table = table.path();

    let mut child = (place.command("r", &arguments))
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let journal = place.path("r/.journal");
    let start = Instant::now();
    // The journal is longer than its head: a point is finished.
    while fs::metadata(&journal).map_or(0, |found| found.len()) < 400 {
        assert!(start.elapsed() < PATIENCE, "no point");
        assert!(child.try_wait().unwrap().is_none(), "ended too soon");
        sleep(Duration::from_millis(2));
    }
    // The file is read-only, but its owner may change that.
    fs::set_permissions(&table, Permissions::from_mode(0o644)).unwrap();
    let file = OpenOptions::new().write(true).open(&table).unwrap();
    file.set_len(60).unwrap();
    assert!(child.try_wait().unwrap().is_none(), "ended too soon");

    let output = child.wait_with_output().unwrap();
    assert!([0, 3].contains(&status(&output)), "{}", stderr(&output));
    let all = ["points.parquet", "poincare.parquet", "spectra.parquet"];
    assert_same(&all, &place.path("whole"), &place.path("r"));

    place.whole("again", &arguments);
    let warnings = place.record("again")["warnings"].to_string();
    assert!(warnings.contains("cut off"), "{warnings}");
    assert_same(&all, &place.path("whole"), &place.path("again"));
}
