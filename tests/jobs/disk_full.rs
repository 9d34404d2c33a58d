//! A disk that becomes full during a run: one line reports it, no incomplete file remains, and with free space the same
//! command resumes with the same bits.
//!
//! The disk is a small tmpfs in a separate mount namespace, which ends with its shell. If the system does not allow
//! one, the test reports this and is skipped.

#![allow(clippy::unwrap_used)]

use crate::{place, results, skipped};
use place::{OSCILLATOR, Place};
use skipped::skipped;
use std::fs;
use std::process::Command;

const TABLES: [&str; 3] = ["points.parquet", "poincare.parquet", "spectra.parquet"];

/// Runs `m.toml` on a disk with some options, then on one with space. Stores outside the files in between, and the
/// messages of both runs.
const SCRIPT: &str = r#"
set -u
mkdir -p disk kept
mount -t tmpfs -o "$OPTIONS" tmpfs disk || exit 99
"$ATLAS" run m.toml --out disk/r --threads 2 > kept/first.out 2> kept/first.err
echo $? > kept/first.status
ls -A disk/r > kept/between
mount -o "remount,size=64m,nr_inodes=1000" disk || exit 99
"$ATLAS" run m.toml --out disk/r --threads 1 > kept/second.out 2> kept/second.err
echo $? > kept/second.status
cp -r disk/r kept/r
"#;

/// Observations on one disk.
struct Seen {
    /// Exit status and errors of the first run.
    first: (i32, String),
    /// Points that the second run took over.
    resumed: u64,
}

/// Runs on a disk with some options of tmpfs and compares with the results in `whole`; `None` if the system does not
/// allow such a disk.
fn on_a_disk_of(options: &str, place: &Place) -> Option<Seen> {
    let namespace = ["--user", "--map-root-user", "--mount"];
    let output = Command::new("unshare")
        .args(namespace)
        .args(["sh", "-c", SCRIPT])
        .current_dir(place.0.path())
        .env("ATLAS", env!("CARGO_BIN_EXE_atlas"))
        .env("OPTIONS", options)
        .output();
    let refused = match &output {
        Err(error) => Some(error.to_string()),
        Ok(output) if !output.status.success() => {
            Some(String::from_utf8_lossy(&output.stderr).into_owned())
        }
        Ok(_) => None,
    };
    if let Some(refused) = refused {
        skipped(format!("no disk of its own here: {refused}"));
        return None;
    }
    let kept = |name: &str| fs::read_to_string(place.path("kept").join(name)).unwrap();
    let status = |name: &str| kept(name).trim().parse::<i32>().unwrap();
    let first = (status("first.status"), kept("first.err"));
    if first.0 != 0 {
        // Either no table has its final name, or all have and the record is missing.
        let left = kept("between");
        let tables = left.lines().filter(|name| *name != ".journal");
        let mut tables: Vec<&str> = tables.collect();
        tables.sort_unstable();
        let mut all = TABLES;
        all.sort_unstable();
        assert!(
            tables.is_empty() || tables == all,
            "left on a disk of {options}: {left}"
        );
    }
    assert_eq!(status("second.status"), 0, "{}", kept("second.err"));
    let results = place.path("kept/r");
    results::assert_same(&TABLES, &place.path("whole"), &results);
    let left = fs::read_dir(&results).unwrap().count();
    assert_eq!(left, TABLES.len() + 1, "tables and run.json, nothing else");
    let resumed = place.record("kept/r")["totals"]["resumed"]
        .as_u64()
        .unwrap();
    fs::remove_dir_all(place.path("kept")).unwrap();
    Some(Seen { first, resumed })
}

#[test]
fn a_full_disk_is_said_and_the_run_goes_on_once_there_is_space() {
    // Each point has the size of some pages.
    let place = Place::new(&OSCILLATOR.replace("harmonics = 5", "harmonics = 600"));
    place.whole("whole", &[]);
    let (mut none, mut some, mut journal, mut tables) = (0, 0, 0, 0);
    // Disks range from no room for a point to room for the journal but not for the tables.
    for pages in [1, 4, 8, 16, 24, 32, 40, 48, 56, 64] {
        let Some(Seen { first, resumed }) = on_a_disk_of(&format!("size={}", 4096 * pages), &place)
        else {
            return;
        };
        let (status, said) = first;
        if status == 0 {
            continue;
        }
        assert_eq!(status, 1, "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.starts_with("error: "), "{said}");
        assert!(
            said.contains("is full") && said.contains("disk/r"),
            "{said}"
        );
        *if resumed == 0 { &mut none } else { &mut some } += 1;
        if said.contains(".journal") { journal += 1 } else { tables += 1 }
    }
    assert!(
        none > 0 && some > 0 && journal > 0 && tables > 0,
        "{none} {some} {journal} {tables}"
    );
}

#[test]
fn a_disk_without_inodes_is_not_called_full() {
    let place = Place::new(OSCILLATOR);
    place.whole("whole", &[]);
    let mut failed = 0;
    // The inodes are for the folder of the disk, the folder of results, the journal, then one table after the other.
    for inodes in 1..6 {
        let options = format!("size=64m,nr_inodes={inodes}");
        let Some(Seen { first, .. }) = on_a_disk_of(&options, &place) else {
            return;
        };
        let (status, said) = first;
        if status == 0 {
            continue;
        }
        failed += 1;
        assert_eq!((status, said.lines().count()), (1, 1), "{said}");
        assert!(
            said.contains("inodes") && said.contains("disk/r") && !said.contains("is full"),
            "{said}"
        );
    }
    assert!(failed > 2, "{failed}");
}
