//! Several processes and one table. The other processes run this test program again, with one test and their task in
//! the environment.

use std::convert::Infallible;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use gearatlas::propagate::{KeptTables, TableArray};
use gearatlas::store::{Fetched, KernelArrays, TableStore};
use serde_json::json;

/// Numbers of a table: 8 MiB.
const NUMBERS: usize = 1 << 20;
/// Time limit of a process that waits for another.
const PATIENCE: Duration = Duration::from_secs(60);

fn numbers() -> Vec<f64> {
    (0..NUMBERS).map(|i| (i as f64).sqrt()).collect()
}

fn fetch(folder: &Path, before: impl FnOnce()) -> Fetched<KernelArrays> {
    let build = || {
        before();
        let roots = TableArray {
            name: "roots",
            unit: "1",
            values: numbers()[..].into(),
        };
        Ok::<_, Infallible>(KernelArrays::from(vec![roots]))
    };
    TableStore::open(folder)
        .get_or_build(&json!({ "numbers": NUMBERS }), build)
        .unwrap()
}

fn whole(table: &KernelArrays) -> bool {
    table.numbers("roots").unwrap() == numbers()
}

/// Starts this test program again, after the `shell` commands.
fn start(shell: &str, role: &str, folder: &Path) -> Child {
    let program = std::env::current_exe().unwrap();
    Command::new("sh")
        .args(["-c", &format!("{shell} exec \"$0\" \"$@\"")])
        .arg(program)
        .args(["--exact", "processes::child", "--ignored", "--nocapture"])
        .env("ATLAS_TEST_ROLE", role)
        .env("ATLAS_TEST_FOLDER", folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The text of another process after `child: `.
fn heard(child: &mut Child) -> String {
    // Each process prints one line; further buffered lines are not needed.
    let lines = BufReader::new(child.stdout.as_mut().unwrap()).lines();
    for line in lines.map_while(Result::ok) {
        if let Some((_, said)) = line.split_once("child: ") {
            return said.to_owned();
        }
    }
    panic!("the other process ended without a word");
}

/// The tasks of the other processes.
#[test]
#[ignore = "started by the other tests of this file"]
fn child() {
    let Ok(role) = std::env::var("ATLAS_TEST_ROLE") else {
        return;
    };
    let folder = PathBuf::from(std::env::var("ATLAS_TEST_FOLDER").unwrap());
    let tables = folder.join("tables");
    let fetched = match role.strip_prefix("race ") {
        None => fetch(&tables, || {}),
        Some(place) => fetch(&tables, || {
            // No process writes before all have found that there is no table.
            let (own, count) = place.split_once(" of ").unwrap();
            fs::write(folder.join(format!("ready-{own}")), "").unwrap();
            let all = || {
                (0..count.parse().unwrap()).all(|i: u32| folder.join(format!("ready-{i}")).exists())
            };
            let start = Instant::now();
            while !all() {
                assert!(start.elapsed() < PATIENCE, "the others did not come");
                sleep(Duration::from_millis(1));
            }
        }),
    };
    let (origin, whole) = (fetched.origin, whole(&fetched.table));
    let warnings: Vec<String> = fetched.warnings.iter().map(ToString::to_string).collect();
    println!("\nchild: {origin:?}, whole {whole}, {warnings:?}");
    // Holds the table until its parent has seen enough.
    _ = BufReader::new(std::io::stdin()).read_line(&mut String::new());
}

#[test]
fn processes_that_build_one_table_at_once_leave_one_good_file() {
    let folder = tempfile::tempdir().unwrap();
    let race = |i| start("", &format!("race {i} of 3"), folder.path());
    let mut children: Vec<Child> = (0..3).map(race).collect();
    for child in &mut children {
        assert_eq!(heard(child), "Built, whole true, []");
        assert!(child.stdin.take().is_some());
        assert!(child.wait().unwrap().success());
    }
    let tables = folder.path().join("tables");
    assert_eq!(
        fs::read_dir(&tables).unwrap().count(),
        1,
        "a temporary file stayed"
    );
    let found = fetch(&tables, || panic!("there is a table"));
    assert!(whole(&found.table) && found.warnings.is_empty());
}

#[test]
fn a_file_that_outgrows_a_limit_leaves_the_table_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    // 8 blocks of 512 bytes (1024 in some shells). The signal is ignored as in `atlas run`, so that writing fails
    // instead.
    let mut child = start("trap '' XFSZ; ulimit -f 8;", "fetch", folder.path());
    let said = heard(&mut child);
    assert!(said.starts_with("BuiltInMemory, whole true, "), "{said}");
    assert!(said.contains("exceeds the largest file"), "{said}");
    drop(child.stdin.take());
    assert!(child.wait().unwrap().success());
    assert_eq!(
        fs::read_dir(folder.path().join("tables")).unwrap().count(),
        0
    );
}
