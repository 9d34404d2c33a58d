//! State of the disk after a power cut: the order in which a run passes files and names to the kernel. Bytes must
//! precede their name, and the name must precede the next one and the removal of the journal.

#![allow(clippy::unwrap_used)]

use crate::{place, skipped};
use place::{OSCILLATOR, Place};
use skipped::skipped;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A system call of a process, with names without their folders.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Call {
    Folder(String),
    Write(String),
    Sync(String),
    Rename(String, String),
    Remove(String),
}

fn name(path: &str) -> String {
    let name = Path::new(path).file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// A line of strace: `PID call(3</path>, "path") = 0`, or its beginning if another thread interrupted it.
fn call(line: &str) -> Option<Call> {
    let (_, line) = line.split_once(' ')?;
    let (kind, arguments) = line.trim_start().split_once('(')?;
    if line.contains(" = -1 ") {
        return None;
    }
    let open = || Some(name(arguments.split_once('<')?.1.split_once('>')?.0));
    let mut quoted = arguments.split('"').skip(1).step_by(2).map(name);
    match kind {
        "mkdir" | "mkdirat" => Some(Call::Folder(quoted.next()?)),
        "write" | "pwrite64" | "writev" => Some(Call::Write(open()?)),
        "fsync" | "fdatasync" => Some(Call::Sync(open()?)),
        "rename" | "renameat" | "renameat2" => Some(Call::Rename(quoted.next()?, quoted.next()?)),
        "unlink" | "unlinkat" => Some(Call::Remove(quoted.next()?)),
        _ => None,
    }
}

/// The system calls of `atlas` with some arguments; `None` if tracing is not permitted.
fn watched(place: &Place, arguments: &[&str]) -> Option<Vec<Call>> {
    let seen = place.path("seen");
    let calls = "trace=mkdir,mkdirat,write,pwrite64,writev,fsync,fdatasync,rename,renameat,renameat2,unlink,unlinkat";
    let output = Command::new("strace")
        .args(["-f", "-y", "-s", "4096", "-e", calls, "-o"])
        .arg(&seen)
        .arg(env!("CARGO_BIN_EXE_atlas"))
        .args(arguments)
        .current_dir(place.0.path())
        .output();
    let refused = match output {
        Err(error) => format!("no strace: {error}"),
        Ok(output) if !output.status.success() => {
            String::from_utf8_lossy(&output.stderr).into_owned()
        }
        Ok(_) => {
            let text = fs::read(&seen).unwrap();
            let text = String::from_utf8_lossy(&text);
            return Some(text.lines().filter_map(call).collect());
        }
    };
    assert!(
        !refused.starts_with("error"),
        "the program itself: {refused}"
    );
    skipped(refused);
    None
}

/// Faults of files that get their name in `folder` before their bytes, or whose name is not synced.
fn check(calls: &[Call], folder: &str) -> Vec<String> {
    let mut named = Vec::new();
    for (i, asked) in calls.iter().enumerate() {
        let Call::Rename(from, to) = asked else {
            continue;
        };
        let (before, after) = (&calls[..i], &calls[i + 1..]);
        let written = (before.iter()).rposition(|call| *call == Call::Write(from.clone()));
        let synced = (before.iter()).rposition(|call| *call == Call::Sync(from.clone()));
        assert!(written < synced, "{to}: its bytes may be lost");
        let next = (after.iter())
            .position(|call| matches!(call, Call::Rename(..) | Call::Remove(_)))
            .unwrap_or(after.len());
        let name = Call::Sync(folder.to_owned());
        assert!(after[..next].contains(&name), "{to}: its name may be lost");
        named.push(to.clone());
    }
    named
}

#[test]
fn a_run_leaves_nothing_to_a_power_cut() {
    let place = Place::new(&OSCILLATOR.replace("[run]", "[run]\nkernel = \"volterra\""));
    let arguments = ["run", "m.toml", "--out", "deep/results", "--threads", "1"];
    let Some(calls) = watched(&place, &arguments) else {
        return;
    };
    let named = check(&calls, "results");
    assert_eq!(
        named,
        [
            "spectra.parquet",
            "poincare.parquet",
            "points.parquet",
            "run.json"
        ],
        "the record last"
    );
    let first = |wanted: &Call| calls.iter().position(|call| call == wanted).unwrap();
    let own = name(place.0.path().to_str().unwrap());
    // The folders and the journal have their names before the journal contains a point.
    let made = first(&Call::Folder("results".into()));
    assert!(calls[made..].contains(&Call::Sync("deep".into())));
    assert!(calls[made..].contains(&Call::Sync(own)));
    let journal = first(&Call::Write(".journal".into()));
    let synced = first(&Call::Sync(".journal".into()));
    let mut points = calls[synced..].iter();
    let points = points.position(|call| *call == Call::Write(".journal".into()));
    let until = synced + points.unwrap();
    assert!(journal < synced && calls[synced..until].contains(&Call::Sync("results".into())));
    // The run removes the journal when all data are on the disk.
    let gone = first(&Call::Remove(".journal".into()));
    let last = (calls.iter()).rposition(|call| matches!(call, Call::Rename(..)));
    assert!(last.unwrap() < gone);
}

#[test]
fn a_kept_table_is_on_the_disk_under_its_name() {
    let text = OSCILLATOR.replace("[run]", "[run]\nkernel = \"closed_modes\"");
    let place = Place::new(&text);
    let arguments = ["run", "m.toml", "--out", "r", "--tables", "kept"];
    let Some(calls) = watched(&place, &arguments) else {
        return;
    };
    let kept = |call: &&Call| matches!(call, Call::Rename(_, to) if to.ends_with(".table"));
    let table = calls.iter().position(|call| kept(&call)).unwrap();
    // Other workers write their points meanwhile.
    let (before, after) = (&calls[..table], &calls[table + 1..]);
    let Call::Rename(from, _) = &calls[table] else {
        unreachable!()
    };
    let written = before
        .iter()
        .rposition(|call| *call == Call::Write(from.clone()));
    assert!(
        written
            < before
                .iter()
                .rposition(|call| *call == Call::Sync(from.clone()))
    );
    assert!(after.contains(&Call::Sync("kept".into())));
}

#[test]
fn lines_are_understood() {
    let lines = [
        (
            "7 rename(\"r/.a.x.partial\", \"r/a\") = 0",
            Some(Call::Rename(".a.x.partial".into(), "a".into())),
        ),
        ("7 fsync(3</tmp/r>) = 0", Some(Call::Sync("r".into()))),
        (
            "7 write(5</tmp/r/.journal>, \"x\\\"\", 2 <unfinished ...>",
            Some(Call::Write(".journal".into())),
        ),
        ("7 mkdir(\"r\", 0777) = -1 EEXIST (File exists)", None),
        ("7 <... write resumed>) = 2", None),
        ("7 +++ exited with 0 +++", None),
    ];
    for (line, wanted) in lines {
        assert_eq!(call(line), wanted, "{line}");
    }
    let early = [Call::Rename("t".into(), "a".into()), Call::Sync("r".into())];
    let lost = std::panic::catch_unwind(|| check(&early, "r"));
    assert!(lost.is_err(), "a name before its bytes is found");
}
