//! `atlas run` as a process: the same numbers after any interruption or split, and a clear end for every failure.

#![allow(clippy::unwrap_used)]

use crate::{place, results};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use results::physics;
use std::fs::{self, OpenOptions};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Many points of moderate length: a sweep that takes seconds.
fn long() -> String {
    let text = OSCILLATOR.replace("count = 3", "count = 12");
    assert_ne!(text, OSCILLATOR);
    text.replace("cycles = 300", "cycles = 8000")
        .replace("transient = 50", "transient = 2000")
}

fn assert_same(a: &Path, b: &Path) {
    results::assert_same(&TABLES, a, b);
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

const TABLES: [&str; 3] = ["points.parquet", "poincare.parquet", "spectra.parquet"];

const RESULTS: [&str; 4] = [
    "poincare.parquet",
    "points.parquet",
    "run.json",
    "spectra.parquet",
];

/// Starts a run and waits until its journal contains some points.
fn start(place: &Place, out: &str, arguments: &[&str]) -> Child {
    let child = place
        .command(out, arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let journal = place.path(out).join(".journal");
    let length = || fs::metadata(&journal).map_or(0, |found| found.len());
    // Wait until the journal is longer than its head, and contains two points: the last may be damaged.
    let (mut last, mut points) = (length().max(400), 0);
    let patience = Instant::now();
    while points < 2 {
        let now = length();
        points += u32::from(now > last);
        last = last.max(now);
        assert!(
            patience.elapsed() < Duration::from_secs(60),
            "no point in a minute"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

fn signal(child: &Child, name: &str) {
    // The built-in `kill` of the shell: a minimal Debian has no other.
    let sent = Command::new("sh")
        .args(["-c", &format!("kill -s {name} {}", child.id())])
        .status();
    assert!(sent.unwrap().success());
}

#[test]
fn threads_and_shards_change_nothing() {
    let place = Place::new(OSCILLATOR);
    let one = place.whole("one", &["--threads", "1"]);
    let two = place.whole("two", &["--threads", "2"]);
    assert_eq!(names(&one), RESULTS);
    assert_same(&one, &two);
    for arguments in [["--threads", "7"], ["--threads", "16"]] {
        let many = place.whole(arguments[1], &[&arguments[..], &["--pin"]].concat());
        assert_same(&one, &many);
    }
    for count in [1, 2, 3, 8] {
        let out = format!("parts{count}");
        for index in 1..=count {
            place.whole(&out, &["--shard", &format!("{index}/{count}")]);
        }
        assert_same(&one, &place.path(&out));
    }

    // Parts of another split, or the whole job, cannot join these shards.
    for arguments in [
        &["--shard", "1/3"][..],
        &[],
        &["--shard", "1/3", "--overwrite"],
    ] {
        let output = place.run("parts2", arguments);
        assert_eq!(status(&output), 2, "{arguments:?}");
        assert!(stderr(&output).contains("--out"), "{}", stderr(&output));
    }
    assert_eq!(status(&place.run("one", &["--shard", "1/2"])), 2);
    assert_same(&one, &place.path("parts2"));
}

/// Simulated machines: other distributions of workers and of copies of tables.
#[test]
#[cfg(feature = "hwloc")]
fn the_machine_changes_nothing() {
    the_machine_changes_nothing_of(OSCILLATOR);
}

/// Tables of kernels are also copied to nodes, and workers use those of their node.
#[test]
#[cfg(feature = "hwloc")]
fn the_machine_changes_nothing_of_kernels_with_tables() {
    let kernel = "[run]\nkernel = \"closed_modes\"";
    the_machine_changes_nothing_of(&OSCILLATOR.replace("[run]", kernel));
}

#[cfg(feature = "hwloc")]
fn the_machine_changes_nothing_of(manifest: &str) {
    let place = Place::new(manifest);
    let here = place.whole("here", &["--threads", "1"]);
    for (machine, copied) in [
        ("package:1 core:1 pu:1", false),
        ("package:2 [numa] core:2 pu:2", true),
        ("package:1 numa:4 core:2 pu:1", true),
        ("pu:3", false),
    ] {
        for threads in ["1", "2", "7", "16"] {
            let mut command =
                place.command("there", &["--threads", threads, "--pin", "--overwrite"]);
            let output = command.env("HWLOC_SYNTHETIC", machine).output().unwrap();
            assert_eq!(status(&output), 0, "{}", stderr(&output));
            assert_same(&here, &place.path("there"));
            let placement = place.record("there")["placement"].clone();
            let asked = placement["copies_asked"].as_str().unwrap();
            let several = copied && threads != "1";
            assert_eq!(asked.starts_with("a copy on each"), several, "{asked}");
            let obtained = placement["copies_obtained"].as_str().unwrap();
            assert_eq!(obtained.contains("does not report"), several, "{obtained}");
        }
    }
}

#[test]
fn the_record_says_where_workers_were_to_run_and_where_they_ran() {
    let place = Place::new(OSCILLATOR);
    let ran = |out: &str, arguments: &[&str], machine: Option<&str>| {
        let mut command = place.command(out, arguments);
        command.envs(machine.map(|machine| ("HWLOC_SYNTHETIC", machine)));
        let output = command.output().unwrap();
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let placement = place.record(out)["placement"].clone();
        ["asked", "obtained"].map(|key| placement[key].as_str().unwrap().to_owned())
    };
    let [asked, obtained] = ran("free", &["--no-pin"], None);
    let copies = place.record("free")["placement"]["copies_obtained"].clone();
    assert_eq!(copies, "one copy for all workers");
    assert!(
        asked.ends_with("; not pinned") && obtained == "not pinned",
        "{asked}, {obtained}"
    );
    let [asked, obtained] = ran("pinned", &["--threads", "1", "--pin"], None);
    assert!(asked.starts_with("1 worker on 1 of "), "{asked}");
    // Some sandboxes forbid it, and the record says so.
    assert!(
        obtained == "pinned" || obtained.starts_with("0 of 1 workers pinned: "),
        "{obtained}"
    );
    if cfg!(not(feature = "hwloc")) {
        return;
    }
    // A description of another machine binds nothing; the work is done nevertheless.
    let [asked, obtained] = ran(
        "other",
        &["--threads", "4"],
        Some("package:2 [numa] core:2 pu:2"),
    );
    assert_eq!(asked, "4 workers on 4 of 4 cores, 2 NUMA nodes; pinned");
    assert_eq!(
        obtained,
        "0 of 4 workers pinned: the topology describes another machine"
    );
    assert_same(&place.path("free"), &place.path("other"));
}

#[test]
fn a_truncated_modal_structure_runs() {
    let modal = "teeth = 20\nrated_force = 1330.0\nfrequency = [0.0, 4000.0, 60000.0]\n\
                 damping = [0.0, 0.02, 0.02]\nmesh = [0.6, 0.3, 0.2]\ntorque = [0.6, 0.3, 0.2]\n";
    let mut seen = Vec::new();
    for extra in ["", "retained = 2", "retained = 2\nmta = true"] {
        let place = Place::new(&OSCILLATOR.replace("[mesh]", &format!("{extra}\n[mesh]")));
        fs::write(place.path("oscillator.modal.toml"), modal).unwrap();
        let out = place.whole("r", &[]);
        seen.push(physics(&out, "points.parquet"));
    }
    assert!(seen[0] != seen[1] && seen[1] != seen[2] && seen[0] != seen[2]);
}

#[test]
fn points_that_go_wrong_are_rows() {
    for (from, to, wanted) in [
        ("[run]", "[run]\nevent_limit = 1", "event_storm"),
        ("\"15 um\"", "1e-200", "diverged"),
    ] {
        let place = Place::new(&OSCILLATOR.replace(from, to));
        let output = place.run("r", &[]);
        assert_eq!(status(&output), 3, "{wanted}: {}", stderr(&output));
        let points = physics(&place.path("r"), "points.parquet");
        assert!(points.contains(wanted), "{points}");
        assert!(
            !points.contains("reason=StringArray\n[\n  \"\","),
            "{points}"
        );
        assert_eq!(place.record("r")["state"], "complete");
        // All points are done: a second run has nothing to do and reports it again.
        assert_eq!(status(&place.run("r", &[])), 3);
    }
}

/// A wrong unit would need millions of windows per mesh cycle. It is reported at once, without integration.
#[test]
fn a_mesh_too_stiff_for_its_cycle_is_a_row() {
    let quickstart = include_str!("../../manifests/quickstart.toml");
    let text = quickstart.replace("\"4e8 N/m\"", "\"4e18 N/m\"");
    assert_ne!(text, quickstart);
    let place = Place::new(&text);
    assert_eq!(status(&place.run("r", &[])), 3);
    let points = physics(&place.path("r"), "points.parquet");
    assert!(
        points.contains("check the units of mesh stiffness"),
        "{points}"
    );
    assert_eq!(place.record("r")["totals"]["failed"], 12);
}

#[test]
fn a_structure_that_cannot_be_computed_is_a_row() {
    let quickstart = include_str!("../../manifests/quickstart.toml");
    let text = quickstart.replace("diameter = \"22 mm\"", "diameter = 1e-160");
    assert_ne!(text, quickstart);
    let place = Place::new(&text);
    assert_eq!(status(&place.run("r", &[])), 3);
    let points = physics(&place.path("r"), "points.parquet");
    assert!(
        points.contains("the structure cannot be computed"),
        "{points}"
    );
    assert_eq!(place.record("r")["totals"]["failed"], 12);
}

#[test]
fn a_signal_ends_a_run_and_the_same_command_goes_on() {
    let place = Place::new(&long());
    let whole = place.whole("whole", &["--threads", "2"]);
    for name in ["INT", "TERM"] {
        let child = start(&place, name, &["--threads", "2"]);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        assert_eq!(status(&output), 130);
        let text = stdout(&output);
        assert!(text.contains("the same command continues"), "{text}");
        let record = place.record(name);
        assert_eq!(record["state"], "interrupted");
        assert!(record["totals"]["missing"].as_u64().unwrap() > 0);
        let partial = physics(&place.path(name), "points.parquet");
        assert!(!partial.is_empty() && physics(&whole, "points.parquet") != partial);

        let output = place.run(name, &["--threads", "1"]);
        assert!([0, 3].contains(&status(&output)), "{}", stderr(&output));
        let record = place.record(name);
        let resumed = record["totals"]["resumed"].as_u64().unwrap();
        assert!(resumed > 0 && resumed < 24, "{resumed}");
        let said = format!("{resumed} of them kept from an interrupted run");
        assert!(stdout(&output).contains(&said), "{}", stdout(&output));
        assert_eq!(names(&place.path(name)), RESULTS);
        assert_same(&whole, &place.path(name));
        // The wall time is that of the last part, and so are the cycles per time.
        let shown = stdout(&place.atlas(&["show", name, "--json"]));
        let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
        assert_eq!(
            shown["wall_time_per_cycle"],
            record["totals"]["wall_time_per_cycle"]
        );
    }
}

/// A point with one mesh cycle of a million steps and eighty tangents takes half a minute. The signal ends it within
/// the cycle, and resuming would begin it again.
#[test]
fn a_signal_ends_a_run_in_the_midst_of_a_cycle() {
    let mut text = include_str!("../../manifests/event-grid.toml").to_owned();
    for (from, to) in [
        (
            "\"run.steps\" = { values = [60, 240, 960, 3840, 15360] }",
            "",
        ),
        ("[\"700 rad/s\", \"1000 rad/s\"]", "[\"400 rad/s\"]"),
        ("load = 0.10", "load = 1.0"),
        ("amplitude = \"5 um\"", "amplitude = \"0.1 um\""),
        ("steps = 4096", "steps = 1000000"),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let place = Place::new(&text);
    let mut child = place
        .command("out", &["--threads", "1", "--quiet"])
        .spawn()
        .unwrap();
    let patience = Instant::now();
    while !place.path("out").join(".journal").exists() {
        assert!(patience.elapsed() < Duration::from_secs(60), "no journal");
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(Duration::from_secs(3));
    signal(&child, "INT");
    let sent = Instant::now();
    let ended = loop {
        if let Some(ended) = child.try_wait().unwrap() {
            break ended;
        }
        if sent.elapsed() > Duration::from_secs(15) {
            child.kill().unwrap();
            panic!("still at work a quarter of a minute after the signal");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    assert_eq!(ended.code(), Some(130));
    assert_eq!(place.record("out")["state"], "interrupted");
    assert_eq!(place.record("out")["totals"]["missing"], 1);
}

/// After a signal, every command has the status of an interruption; a trace leaves no file.
#[test]
fn a_signal_ends_every_command_with_the_same_status() {
    let place = Place::new(OSCILLATOR);
    let trace =
        "trace m.toml --point load=0.3,speed=600 --cycles 1000000000 --samples-per-cycle 1 --out t";
    let verify = "verify --full --threads 1";
    for (name, arguments) in [
        ("TERM", trace),
        ("INT", trace),
        ("TERM", verify),
        ("INT", verify),
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_atlas"))
            .current_dir(place.path(""))
            .args(arguments.split(' '))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let patience = Instant::now();
        let at_work = || {
            if arguments == trace {
                place.path("t").exists() && !names(&place.path("t")).is_empty()
            } else {
                patience.elapsed() > Duration::from_secs(1)
            }
        };
        while !at_work() {
            assert!(patience.elapsed() < Duration::from_secs(60), "{arguments}");
            std::thread::sleep(Duration::from_millis(2));
        }
        signal(&child, name);
        assert_eq!(
            child.wait().unwrap().code(),
            Some(130),
            "{name} {arguments}"
        );
    }
    assert_eq!(names(&place.path("t")), [""; 0]);
}

#[test]
fn a_killed_run_goes_on_even_from_a_damaged_journal() {
    let place = Place::new(&long());
    let whole = place.whole("whole", &["--threads", "2"]);
    type Damage = fn(&Path);
    let damages: [(&str, Damage); 3] = [
        ("whole_records", |_| {}),
        ("cut", |path| {
            let file = OpenOptions::new().write(true).open(path).unwrap();
            file.set_len(file.metadata().unwrap().len() - 5).unwrap();
        }),
        ("flipped", |path| {
            let mut bytes = fs::read(path).unwrap();
            *bytes.last_mut().unwrap() ^= 4;
            fs::write(path, bytes).unwrap();
        }),
    ];
    for (out, damage) in damages {
        // The run is killed twice: a resumed run can be resumed.
        for threads in ["2", "1"] {
            let mut child = start(&place, out, &["--threads", threads]);
            signal(&child, "KILL");
            child.wait().unwrap();
            assert!(!place.path(out).join("points.parquet").exists());
            let show = Command::new(env!("CARGO_BIN_EXE_atlas"))
                .arg("show")
                .arg(place.path(out))
                .output()
                .unwrap();
            assert_eq!(status(&show), 2);
            assert!(stderr(&show).contains("was killed"), "{}", stderr(&show));
            damage(&place.path(out).join(".journal"));
        }
        place.whole(out, &["--threads", "2"]);
        assert!(place.record(out)["totals"]["resumed"].as_u64().unwrap() > 0);
        assert_eq!(names(&place.path(out)), RESULTS, "nothing is left behind");
        assert_same(&whole, &place.path(out));
    }
}

/// Ends of the records of a journal: each starts with its length, after a magic number.
fn record_ends(journal: &[u8]) -> Vec<usize> {
    let mut ends = vec![8];
    let mut end = 8;
    while let Some(length) = journal.get(end..).and_then(<[u8]>::first_chunk::<8>) {
        end += 16 + u64::from_le_bytes(*length) as usize;
        ends.push(end);
    }
    // The last record may be truncated.
    ends.retain(|end| *end <= journal.len());
    ends
}

/// Damages every record of a real journal, by truncation in its middle and by a flipped bit there. A damaged header in
/// front of points is refused.
#[test]
fn damage_to_any_record_costs_only_what_follows() {
    let text = OSCILLATOR.replace("count = 3", "count = 12");
    let place = Place::new(&text.replace("cycles = 300", "cycles = 2000"));
    let whole = place.whole("whole", &["--threads", "2"]);
    let mut child = start(&place, "r", &["--threads", "1"]);
    signal(&child, "KILL");
    child.wait().unwrap();
    let out = place.path("r");
    let journal = fs::read(out.join(".journal")).unwrap();
    let ends = record_ends(&journal);
    assert!(ends.len() >= 3, "header and a point: {ends:?}");
    for (record, pair) in ends.windows(2).enumerate() {
        let middle = usize::midpoint(pair[0], pair[1]);
        let mut turned = journal.clone();
        turned[middle] ^= 1 << (record % 8);
        for damaged in [&journal[..middle], &turned] {
            fs::remove_dir_all(&out).unwrap();
            fs::create_dir(&out).unwrap();
            fs::write(out.join(".journal"), damaged).unwrap();
            // The first record is the header: without it nothing is trusted.
            if record == 0 && damaged.len() == journal.len() {
                let output = place.run("r", &["--threads", "2"]);
                assert_eq!(status(&output), 2);
                let said = stderr(&output);
                assert!(said.contains("its start is damaged"), "{said}");
                assert_eq!(fs::read(out.join(".journal")).unwrap(), damaged);
                continue;
            }
            place.whole("r", &["--threads", "2"]);
            let points = record.saturating_sub(1) as u64;
            assert_eq!(place.record("r")["totals"]["resumed"], points);
            assert_same(&whole, &out);
        }
    }
}

#[test]
fn a_second_run_in_the_same_folder_is_refused_while_the_first_is_alive() {
    let place = Place::new(&long());
    let mut child = start(&place, "r", &["--threads", "1"]);
    for arguments in [&[][..], &["--overwrite"]] {
        let output = place.run("r", arguments);
        assert_eq!(status(&output), 4, "not 2: it passes");
        assert!(
            stderr(&output).contains("another `atlas run`"),
            "{}",
            stderr(&output)
        );
    }
    signal(&child, "KILL");
    child.wait().unwrap();
}

/// Tables without a record may be the only copy of somebody's results.
#[test]
fn tables_without_a_record_are_not_replaced() {
    let place = Place::new(OSCILLATOR);
    let out = place.path("r");
    fs::create_dir(&out).unwrap();
    for name in ["points.parquet", "spectra.parquet"] {
        fs::write(out.join(name), "mine").unwrap();
        let refused = place.run("r", &[]);
        assert_eq!(status(&refused), 2);
        assert!(
            stderr(&refused).contains("--overwrite"),
            "{}",
            stderr(&refused)
        );
        assert_eq!(fs::read(out.join(name)).unwrap(), b"mine");
        fs::remove_file(out.join(name)).unwrap();
    }
    fs::write(out.join("points.parquet"), "mine").unwrap();
    place.whole("r", &["--overwrite"]);
}

#[test]
fn results_are_recognised_refused_and_replaced() {
    let place = Place::new(OSCILLATOR);
    let out = place.whole("r", &[]);
    let before = fs::read(out.join("points.parquet")).unwrap();
    let again = place.run("r", &[]);
    assert_eq!(status(&again), 0);
    assert!(
        stdout(&again).contains("already holds"),
        "{}",
        stdout(&again)
    );

    let other = OSCILLATOR
        .replace("15 um", "16 um")
        .replace("poincare = { samples = 20 }\n", "");
    fs::write(place.path("m.toml"), other).unwrap();
    let refused = place.run("r", &[]);
    assert_eq!(status(&refused), 2);
    assert!(
        stderr(&refused).contains("another manifest"),
        "{}",
        stderr(&refused)
    );
    for line in [
        "- half_gap = \"15 um\"",
        "+ half_gap = \"16 um\"",
        "- poincare =",
    ] {
        assert!(
            stderr(&refused).contains(line),
            "{line}: {}",
            stderr(&refused)
        );
    }
    assert_eq!(fs::read(out.join("points.parquet")).unwrap(), before);
    assert_eq!(names(&out), RESULTS, "untouched");

    place.whole("r", &["--overwrite"]);
    assert_ne!(fs::read(out.join("points.parquet")).unwrap(), before);
    assert_eq!(
        names(&out),
        ["points.parquet", "run.json", "spectra.parquet"],
        "no table of the earlier job stays"
    );
}

#[test]
fn quiet_is_quiet() {
    let place = Place::new(OSCILLATOR);
    for _ in 0..2 {
        let output = place.run("q", &["--quiet"]);
        assert_eq!(
            (stdout(&output), stderr(&output)),
            (String::new(), String::new())
        );
    }
}

#[test]
fn closed_and_full_outputs_do_no_harm() {
    let place = Place::new(OSCILLATOR);
    let closed = place.shell("\"$ATLAS\" run m.toml --out closed >&- 2>&-");
    assert_eq!(status(&closed), 0);
    assert_eq!(names(&place.path("closed")), RESULTS);
    let piped = place.shell("set -o pipefail; \"$ATLAS\" run m.toml --out piped 2>&1 | true");
    assert_eq!(status(&piped), 0, "{}", stderr(&piped));
    assert_eq!(names(&place.path("piped")), RESULTS);
    for command in [
        "run m.toml --out piped",
        "check m.toml",
        "show piped",
        "completions bash",
    ] {
        let full = place.shell(&format!("\"$ATLAS\" {command} > /dev/full"));
        assert_eq!(status(&full), 1, "{command}");
        assert!(
            stderr(&full).contains("cannot write to standard output"),
            "{command}"
        );
    }

    // 8 blocks of 512 or 1024 bytes have room for a journal's beginning, not for the result files.
    let limited = place.shell("ulimit -f 8; \"$ATLAS\" run m.toml --out limited");
    assert_eq!(status(&limited), 1);
    assert_eq!(stderr(&limited).lines().count(), 1, "{}", stderr(&limited));
    assert!(
        stderr(&limited).contains("ulimit -f"),
        "{}",
        stderr(&limited)
    );
    let left = names(&place.path("limited"));
    assert!(left.iter().all(|name| name == ".journal"), "{left:?}");
    place.whole("limited", &[]);
    assert_same(&place.path("closed"), &place.path("limited"));
}

#[test]
fn impossible_folders_give_one_line() {
    let place = Place::new(OSCILLATOR);
    fs::write(place.path("file"), "mine").unwrap();
    for (out, code, words) in [
        ("file", 2, "not a folder"),
        ("file/below", 2, "not a folder"),
        ("/proc/atlas", 1, "/proc/atlas"),
    ] {
        let output = place.run(out, &[]);
        assert_eq!(status(&output), code, "{out}: {}", stderr(&output));
        assert_eq!(stderr(&output).lines().count(), 1, "{}", stderr(&output));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    assert_eq!(fs::read(place.path("file")).unwrap(), b"mine");
}

#[test]
fn misuse_is_bad_input() {
    let place = Place::new(OSCILLATOR);
    for arguments in [
        &["--threads", "0"][..],
        &["--threads", "-1"],
        &["--shard", "0/2"],
        &["--shard", "3/2"],
        &["--shard", "2"],
        &["--nonsense"],
        &["another.toml"],
    ] {
        let output = place.run("r", arguments);
        assert_eq!(status(&output), 2, "{arguments:?}");
        assert!(
            stderr(&output).starts_with("error: "),
            "{}",
            stderr(&output)
        );
    }
    assert!(!place.path("r").exists());
}
