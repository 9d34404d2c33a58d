//! Several processes and one table. The others are this test program again, with one test and
//! what it is to do in its environment.

use std::convert::Infallible;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use gearatlas::store::{Arrays, CacheKind, Fetched, MappedTable, TableStore};
use serde_json::json;

use crate::skipped::skipped;

/// Numbers of a table that is read: 8 MiB.
const NUMBERS: usize = 1 << 20;
/// Numbers of one that is mapped: a little more than 64 MiB.
const MANY_NUMBERS: usize = (8 << 20) + 1;
/// What a process may wait for another.
const PATIENCE: Duration = Duration::from_secs(60);

fn numbers(count: usize) -> Vec<f64> {
    (0..count).map(|i| (i as f64).sqrt()).collect()
}

fn fetch(folder: &Path, count: usize, before: impl FnOnce()) -> Fetched {
    let build = || {
        before();
        let mut arrays = Arrays::new();
        arrays.push("roots", "1", &[count], numbers(count)).unwrap();
        Ok::<_, Infallible>(arrays)
    };
    let inputs = json!({ "numbers": count });
    TableStore::open(folder)
        .get_or_build(CacheKind::Bases, &inputs, build)
        .unwrap()
}

fn whole(table: &MappedTable) -> bool {
    let (shape, roots) = table.array("roots").unwrap();
    roots == numbers(shape[0])
}

/// Starts this test program again: `shell` goes before it.
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

/// What another process prints after `child: `.
fn heard(child: &mut Child) -> String {
    // Each process says one line of its own: what is buffered beyond it is not missed.
    let lines = BufReader::new(child.stdout.as_mut().unwrap()).lines();
    for line in lines.map_while(Result::ok) {
        if let Some((_, said)) = line.split_once("child: ") {
            return said.to_owned();
        }
    }
    panic!("the other process ended without a word");
}

/// What the other processes do.
#[test]
#[ignore = "started by the other tests of this file"]
fn child() {
    let Ok(role) = std::env::var("ATLAS_TEST_ROLE") else {
        return;
    };
    let folder = PathBuf::from(std::env::var("ATLAS_TEST_FOLDER").unwrap());
    let tables = folder.join("tables");
    let fetched = match role.strip_prefix("race ") {
        None if role == "share" => fetch(&tables, MANY_NUMBERS, || {}),
        None => fetch(&tables, NUMBERS, || {}),
        Some(place) => fetch(&tables, NUMBERS, || {
            // Nobody writes before everybody has found that there is no table.
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
    // Holds the table until its starter has seen enough.
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
    let found = fetch(&tables, NUMBERS, || panic!("there is a table"));
    assert!(whole(&found.table) && found.warnings.is_empty());
}

#[test]
fn a_file_that_outgrows_a_limit_leaves_the_table_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    // 8 blocks of 512 bytes (1024 in some shells). The signal is ignored as `atlas run` does
    // it, so that writing fails instead.
    let mut child = start("trap '' XFSZ; ulimit -f 8;", "fetch", folder.path());
    let said = heard(&mut child);
    assert!(said.starts_with("BuiltInMemory, whole true, "), "{said}");
    assert!(said.contains("outgrew the largest file"), "{said}");
    drop(child.stdin.take());
    assert!(child.wait().unwrap().success());
    assert_eq!(
        fs::read_dir(folder.path().join("tables")).unwrap().count(),
        0
    );
}

/// Of the mapping of a table in a process: permissions, and by name its sizes \[kB\].
fn mapping(process: u32, name: &str) -> Option<(String, impl Fn(&str) -> f64)> {
    let text = fs::read_to_string(format!("/proc/{process}/smaps")).ok()?;
    let start = text.lines().position(|line| line.ends_with(name))?;
    let lines: Vec<String> = text.lines().skip(start).map(str::to_owned).collect();
    let permissions = lines[0].split(' ').nth(1)?.to_owned();
    let size = move |name: &str| {
        let line = lines
            .iter()
            .find_map(|line| line.strip_prefix(&format!("{name}:")));
        line.unwrap()
            .trim()
            .strip_suffix(" kB")
            .unwrap()
            .parse()
            .unwrap()
    };
    Some((permissions, size))
}

#[test]
fn processes_share_the_memory_of_a_large_table_and_cannot_change_it() {
    if !Path::new("/proc/self/smaps").exists() {
        skipped("no /proc/self/smaps to see shared memory in");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // The maker drops its mapping, so that only the other two have one.
    let file = {
        let tables = folder.path().join("tables");
        assert!(whole(&fetch(&tables, MANY_NUMBERS, || {}).table));
        fs::read_dir(&tables)
            .unwrap()
            .next()
            .unwrap()
            .unwrap()
            .path()
    };
    let mode = fs::metadata(&file).unwrap().permissions().mode();
    assert_eq!(mode & 0o222, 0, "somebody may write");
    let mut children = ["a", "b"].map(|_| start("", "share", folder.path()));
    for child in &mut children {
        assert_eq!(heard(child), "Found, whole true, []");
    }
    let name = file.file_name().unwrap().to_str().unwrap();
    let length = fs::metadata(&file).unwrap().len() as f64 / 1024.0;
    for child in &children {
        let (permissions, size) = mapping(child.id(), name).unwrap();
        assert_eq!(permissions, "r--s");
        let (resident, own) = (size("Rss"), size("Pss"));
        // Every byte was read, and each page counts half for each of the two.
        assert!(resident >= 0.99 * length, "{resident} of {length} kB");
        assert!(
            (own / resident - 0.5).abs() < 0.02,
            "Pss {own}, Rss {resident} kB"
        );
        assert_eq!(
            size("Private_Dirty") + size("Shared_Dirty") + size("Anonymous"),
            0.0
        );
    }
    // A table that is removed and made anew does not disturb who has the old one.
    fs::remove_file(&file).unwrap();
    assert!(mapping(children[0].id(), &format!("{name} (deleted)")).is_some());
    for child in &mut children {
        child.stdin.take().unwrap().write_all(b"\n").unwrap();
        assert!(child.wait().unwrap().success());
    }
}
