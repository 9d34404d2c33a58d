//! Bad text uses limited resources: for any manifest of a megabyte, the check takes little memory and time and prints
//! few words. None of its control characters reaches a terminal.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use gearatlas::manifest;
use gearatlas::store::TableStore;
use gearatlas::sweep::Prepared;

const QUICKSTART: &str = include_str!("../../manifests/quickstart.toml");

/// Size of a text \[bytes\].
const MEGABYTE: usize = 1_000_000;

/// Limit of the address space of a check \[KiB\]: the program's usual mappings, and 100 MB.
const ADDRESSES: usize = 300_000;

/// A check that takes this long counts as a hang.
const HANG: Duration = Duration::from_secs(60);

/// Largest number of bytes printed about a bad text.
const WORDS: usize = 100_000;

/// The manifest with a part replaced.
fn with(from: &str, to: &str) -> String {
    assert!(QUICKSTART.contains(from), "{from}");
    QUICKSTART.replacen(from, to, 1)
}

/// Numbered pieces that fill a megabyte together with the manifest.
fn pieces(piece: impl Fn(usize) -> String) -> String {
    let mut text = String::new();
    for i in 0.. {
        let next = piece(i);
        if text.len() + next.len() + QUICKSTART.len() > MEGABYTE {
            break;
        }
        text += &next;
    }
    text
}

const LOAD: &str = "load = { from = \"10 %\", to = \"30 %\", count = 3 }";

fn loads(values: &str) -> String {
    with(LOAD, &format!("load = {{ values = [{values}] }}"))
}

/// Kinds of text of a megabyte, most of them bad.
fn kinds() -> Vec<(&'static str, String)> {
    let under = |table: &str, piece: &dyn Fn(usize) -> String| {
        let header = format!("[{table}]");
        with(&header, &format!("{header}\n{}#", pieces(piece)))
    };
    let after = |text: String| format!("{QUICKSTART}{text}\n");
    let long = |letter: &str| letter.repeat(MEGABYTE - 2 * QUICKSTART.len());
    vec![
        ("unknown tables", after(pieces(|i| format!("[t{i}]\n")))),
        ("unknown keys", under("mesh", &|i| format!("k{i}=1\n"))),
        ("unknown axes", under("grid", &|i| format!("a{i}=1\n"))),
        (
            "unknown model axes",
            under("grid", &|i| format!("\"mesh.a{i}\"=1\n")),
        ),
        (
            "keys given twice",
            under("mesh", &|_| "half_gap=1\n".into()),
        ),
        ("tables given twice", after(pieces(|_| "[mesh]\n".into()))),
        (
            "wrong entries in a line",
            loads(&pieces(|_| "\"1 x\",".into())),
        ),
        (
            "wrong entries in lines",
            loads(&pieces(|_| "\"1 x\",\n".into())),
        ),
        ("tables for numbers", loads(&pieces(|_| "{},".into()))),
        (
            "dates for numbers",
            loads(&pieces(|_| "1979-05-27,".into())),
        ),
        (
            "integers of 67 bits",
            loads(&pieces(|_| "99999999999999999999,".into())),
        ),
        ("one value again and again", loads(&pieces(|_| "1,".into()))),
        (
            "as many valid values",
            loads(&pieces(|i| format!("{},", i + 1))),
        ),
        (
            "ripples without anything",
            with(
                "[grid]",
                &(pieces(|_| "[[excitation.torque_ripple]]\n".into()) + "[grid]"),
            ),
        ),
        (
            "one override again and again",
            with(
                "modes = 12",
                &format!(
                    "modes = 12\ndamping_overrides = [{}]",
                    pieces(|i| format!("{{mode={},ratio=0.1}},", i % 12 + 1))
                ),
            ),
        ),
        (
            "one period again and again",
            with(
                "[analyses]",
                &format!(
                    "[analyses]\norbits = {{ periods = [{}] }}",
                    pieces(|i| format!("{},", i % 64 + 1))
                ),
            ),
        ),
        ("lists in lists", after(format!("x = {}", long("[")))),
        (
            "tables in tables",
            after(format!("x = {}", pieces(|_| "{a=".into()))),
        ),
        (
            "keys of keys",
            after(format!("x{} = 1", pieces(|_| ".a".into()))),
        ),
        (
            "headers of keys",
            after(format!("[x{}]", pieces(|_| ".a".into()))),
        ),
        ("a long key", after(format!("{} = 1", long("k")))),
        (
            "a long axis",
            under("grid", &|_| format!("\"{}\"=1\n", "h".repeat(900_000))),
        ),
        (
            "a long unit",
            with("\"10 um\"", &format!("\"1 {}m\"", pieces(|_| "m*".into()))),
        ),
        (
            "a long word",
            with("\"piecewise\"", &format!("\"{}\"", long("p"))),
        ),
        ("a long number", with("\"10 um\"", &long("1"))),
        ("no syntax", after(pieces(|_| "=\n".into()))),
        ("texts without quotes", after(pieces(|_| "a=b\n".into()))),
        ("closed brackets", after(pieces(|_| "]\n".into()))),
        ("quotes", "\"".repeat(MEGABYTE)),
        ("zeros", "\0".repeat(MEGABYTE)),
        ("escapes", "\u{1b}[2J".repeat(MEGABYTE / 4)),
        (
            "axes of ten million",
            under("grid", &|i| {
                format!(
                    "\"excitation.transmission_error.{i}.amplitude\"={{from=1e-6,to=1e-5,count=10000000}}\n"
                )
            }),
        ),
        (
            "a model axis of ten million",
            with("half_gap = \"10 um\"", "").replacen(
                LOAD,
                "\"mesh.half_gap\" = { from = 1e-6, to = 1e-5, count = 2500000 }\nload = 0.1",
                1,
            ),
        ),
        (
            "two model axes",
            with(
                LOAD,
                "\"mesh.half_gap\" = { from = 1e-6, to = 1e-5, count = 1500 }\n\
                 \"mesh.friction\" = { from = 0, to = 0.1, count = 1500 }\nload = 0.1",
            ),
        ),
        (
            "a long list of the mesh and a model axis",
            with(
                "mean_stiffness = \"4e8 N/m\"\ncontact_ratio = 1.6\nsingle_pair_drop = 0.25",
                &format!("values = [{}]", pieces(|_| "4e8,".into())),
            )
            .replacen(
                LOAD,
                "\"mesh.half_gap\" = { from = 1e-6, to = 1e-5, count = 800000 }\nload = 0.1",
                1,
            ),
        ),
    ]
}

/// The output of the program if it ends before the time limit of a hang, in an address space of `addresses` KiB.
fn within(folder: &Path, addresses: usize, arguments: &[&str]) -> Output {
    let limited = format!("ulimit -v {addresses}; exec \"$0\" \"$@\"");
    let [out, err] = ["out.txt", "err.txt"].map(|name| folder.join(name));
    let mut child = Command::new("bash")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_atlas")])
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::from(fs::File::create(&out).unwrap()))
        .stderr(Stdio::from(fs::File::create(&err).unwrap()))
        .spawn()
        .unwrap();
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > HANG {
            child.kill().unwrap();
            panic!("{arguments:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    Output {
        status,
        stdout: fs::read(out).unwrap(),
        stderr: fs::read(err).unwrap(),
    }
}

fn check(folder: &Path, text: &[u8], arguments: &[&str]) -> Output {
    fs::write(folder.join("m.toml"), text).unwrap();
    within(
        folder,
        ADDRESSES,
        &[&["check", "m.toml"], arguments].concat(),
    )
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Whether the bytes contain no control characters, so that a terminal only displays them.
fn is_harmless(bytes: &[u8]) -> bool {
    words(bytes).chars().all(|c| !c.is_control() || c == '\n')
}

#[test]
fn a_megabyte_of_anything_is_judged_in_little_memory_and_few_words() {
    let folder = tempfile::tempdir().unwrap();
    let kinds = kinds();
    assert!(kinds.len() > 30);
    for (name, text) in kinds {
        for arguments in [&[][..], &["--json"]] {
            let output = check(folder.path(), text.as_bytes(), arguments);
            let said = output.stdout.len() + output.stderr.len();
            assert!(
                matches!(output.status.code(), Some(0 | 2)),
                "{name}: {:?} {}",
                output.status.signal(),
                &words(&output.stderr)[..200.min(output.stderr.len())]
            );
            // Programs get every stored fault, and ten thousand values of a valid axis.
            let most = if arguments.is_empty() { WORDS } else { 20 * WORDS };
            assert!(said < most, "{name}: {said} bytes are said");
            assert!(is_harmless(&output.stderr), "{name}");
        }
    }
}

#[test]
fn twenty_faults_are_shown_and_the_others_counted() {
    let folder = tempfile::tempdir().unwrap();
    let values: Vec<String> = (0..1000).map(|i| format!("\"{} rp\"", 6000 + i)).collect();
    let text = loads(&values.join(", "));
    let output = check(folder.path(), text.as_bytes(), &[]);
    let said = words(&output.stderr);
    assert_eq!(said.matches("error[wrong-unit]").count(), 20, "{said}");
    assert!(said.contains("\n… and 980 more\n"), "{said}");
    assert!(said.contains("m.toml: 1000 errors"), "{said}");
    assert!(
        said.lines().all(|line| line.chars().count() < 250),
        "{said}"
    );
    // The position refers to the file, not to the shown text.
    let column = text.lines().find(|line| line.contains("6019 rp")).unwrap();
    let column = column.find("\"6019 rp\"").unwrap() + 1;
    assert!(said.contains(&format!(":{column}\n")), "{column}: {said}");
    let json = check(folder.path(), text.as_bytes(), &["--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["errors_found"], 1000);
    assert_eq!(json["errors"].as_array().unwrap().len(), 100);
}

#[test]
fn what_a_terminal_would_obey_is_written_out() {
    let folder = tempfile::tempdir().unwrap();
    let text = with("\"quickstart\"", "\"\\u001b]0;pwn\\u0007\\u001b[31mRED\"");
    let output = check(folder.path(), text.as_bytes(), &[]);
    assert!(is_harmless(&output.stderr), "{}", words(&output.stderr));
    assert!(words(&output.stderr).contains(r"\u001b]0;pwn\u0007\u001b[31mRED"));
    // Put raw control characters into the text and into the name of the file.
    let raw = with("modes = 12", "modes = 12 \u{1b}[31m");
    let name = "\u{1b}[31m.toml";
    fs::write(folder.path().join(name), raw).unwrap();
    let output = within(folder.path(), ADDRESSES, &["check", name]);
    assert_eq!(output.status.code(), Some(2));
    assert!(is_harmless(&output.stderr), "{}", words(&output.stderr));
    let missing = within(folder.path(), ADDRESSES, &["show", name]);
    assert!(is_harmless(&missing.stderr), "{}", words(&missing.stderr));
}

#[test]
fn text_in_another_encoding_is_refused_at_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let text = with("half_gap = \"10 um\"", "half_gap = \"10 \u{b5}m\"");
    let latin1: Vec<u8> = text
        .chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap_or(b'?'))
        .collect();
    let line = 1 + text[..text.find('\u{b5}').unwrap()].matches('\n').count();
    let output = check(folder.path(), &latin1, &[]);
    let said = words(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(said.contains(&format!("m.toml:{line}:16")), "{said}");
    assert!(said.contains("0xb5") && said.contains("UTF-8"), "{said}");
}

#[test]
fn only_regular_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    for (path, word) in [
        ("pipe", "named pipe"),
        ("/dev/zero", "device"),
        (".", "folder"),
    ] {
        let output = within(folder.path(), ADDRESSES, &["check", path]);
        assert_eq!(output.status.code(), Some(2), "{path}");
        let said = words(&output.stderr);
        assert!(said.contains(word), "{path}: {said}");
    }
    // Read the pipe as a modal file, and as a table of results.
    let text = "[job]\nname = \"a\"\n[model]\nkind = \"modal\"\nfile = \"pipe\"\n\
                [mesh]\nhalf_gap = 1e-5\nmean_stiffness = 4e8\n[grid]\nload = 0.1\nspeed = 600\n";
    let output = check(folder.path(), text.as_bytes(), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        words(&output.stderr).contains("named pipe"),
        "{}",
        words(&output.stderr)
    );
    let results = folder.path().join("results");
    fs::create_dir(&results).unwrap();
    fs::rename(&pipe, results.join("points.parquet")).unwrap();
    let output = within(folder.path(), 4 * ADDRESSES, &["show", "results"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        words(&output.stderr).contains("named pipe"),
        "{}",
        words(&output.stderr)
    );
    fs::rename(results.join("points.parquet"), results.join("run.json")).unwrap();
    let output = within(folder.path(), 4 * ADDRESSES, &["show", "results"]);
    assert_eq!(output.status.code(), Some(2), "{}", words(&output.stderr));
}

#[test]
fn a_grid_that_is_too_large_is_counted_not_made() {
    let folder = tempfile::tempdir().unwrap();
    let axes: String = (0..100)
        .map(|i| {
            format!("\"excitation.transmission_error.{i}.amplitude\" = {{ from = 1e-6, to = 1e-5, count = 10000000 }}\n")
        })
        .collect();
    let output = check(folder.path(), with(LOAD, &(axes + LOAD)).as_bytes(), &[]);
    let said = words(&output.stderr);
    assert!(said.contains("the grid has about 10^701 points"), "{said}");
    assert!(said.contains("94 more axes"), "{said}");
}

/// Ten million gaps: only requested points are made, and each equals the point of a manifest with that gap alone.
#[test]
fn points_of_a_huge_grid_are_made_when_they_are_asked_for() {
    let grid = "\"mesh.half_gap\" = { from = 1e-6, to = 1e-5, count = 5000000 }\nload = 0.1";
    let huge = with("half_gap = \"10 um\"", "")
        .replacen(LOAD, grid, 1)
        .replacen("count = 4 }", "count = 2 }", 1);
    let parse = |text: &str| manifest::parse(text, "m.toml", Path::new("")).unwrap();
    let job = parse(&huge);
    assert_eq!(job.points.len(), 10_000_000);
    assert!(job.points.variants().len() < 100_000);
    let gaps = &job.axes[0].values;
    for id in [0, 1, 4_444_443, 9_999_999] {
        let point = job.points.at(id);
        let gap = gaps.get(id / 2);
        assert_eq!(point.mesh.half_gap.to_bits(), gap.to_bits());
        assert_eq!((point.axis_values[0], point.fault.clone()), (gap, None));
        let alone = huge.replacen(
            "{ from = 1e-6, to = 1e-5, count = 5000000 }",
            &format!("{gap:e}"),
            1,
        );
        let alone = parse(&alone).points.at(id % 2);
        assert_eq!((point.model, point.mesh), (alone.model, alone.mesh));
        assert_eq!(
            (point.run, point.load, point.speed),
            (alone.run, alone.load, alone.speed)
        );
    }
    // Points share their common parts, including points that were not checked.
    assert!(std::sync::Arc::ptr_eq(
        &job.points.at(7_777_777).run,
        &job.points.at(0).run
    ));
    // The hash depends on all relevant keys, and on nothing else.
    let hash = |text: &str| parse(text).hash;
    assert_eq!(
        hash(&huge),
        hash(
            &huge
                .replace("[mesh] ", "[mesh]\n")
                .replace("quickstart\"", "q\"")
        )
    );
    assert_ne!(
        hash(&huge),
        hash(&huge.replace("single_pair_drop = 0.25", "single_pair_drop = 0.26"))
    );
    assert_ne!(
        hash(&huge),
        hash(&huge.replace("count = 5000000", "count = 4999999"))
    );
}

/// One value in a hundred thousand is incompatible with the others, and is not among the checked ones. Its points
/// report it, and the rest is valid.
#[test]
fn a_combination_without_a_drive_is_a_failed_point() {
    const ODD: usize = 50_001;
    let cycles = (0..100_000).map(|i| if i == ODD { 5 } else { 1000 + i });
    let cycles: Vec<String> = cycles.map(|cycles| cycles.to_string()).collect();
    let grid = format!(
        "\"run.cycles\" = {{ values = [{}] }}\nload = 0.1",
        cycles.join(",")
    );
    let text = with(LOAD, &grid).replacen("cycles = 160000", "audit_cycles = 20", 1);
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    let parts = Prepared::new(TableStore::open(tempfile::tempdir().unwrap().path()));
    for (combination, valid) in [(ODD - 1, true), (ODD, false), (ODD + 1, true)] {
        let point = job.points.at(4 * combination);
        let built = parts.model(&point);
        assert_eq!(built.is_ok(), valid, "{combination}");
        if let Err(error) = built {
            assert!(error.to_string().contains("audit_cycles"), "{error}");
        }
    }
    // With few other values, the incompatible value is an error of the manifest.
    let few = with(LOAD, "\"run.cycles\" = { values = [5, 1000] }\nload = 0.1").replacen(
        "cycles = 160000",
        "audit_cycles = 20",
        1,
    );
    let errors = manifest::parse(&few, "m.toml", Path::new("")).unwrap_err();
    assert!(errors.to_string().contains("audit_cycles"), "{errors}");
}

#[test]
fn steps_have_a_limit_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let text = with(
        "cycles = 160000",
        "kernel = \"stepping\"\nsteps = 100000000\ncycles = 160000",
    );
    let output = check(folder.path(), text.as_bytes(), &[]);
    let said = words(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("16 to 1e6") && said.contains("bytes"),
        "{said}"
    );
}

#[test]
fn programs_are_told_of_every_analysis() {
    let folder = tempfile::tempdir().unwrap();
    let text = with("[analyses]", "[analyses]\norbits = { periods = [1] }");
    let output = check(folder.path(), text.as_bytes(), &["--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let analyses = json["analyses"].as_array().unwrap();
    assert!(analyses.contains(&"orbits".into()), "{analyses:?}");
}

#[test]
fn a_negative_angle_needs_no_equals_sign() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), "[job]\n").unwrap();
    let arguments = ["table", "m.toml", "--misalignment", "-0.4 mrad,0.1 mrad"];
    let output = within(folder.path(), 4 * ADDRESSES, &arguments);
    // The message names the manifest, not the angles.
    let said = words(&output.stderr);
    assert!(
        said.contains("[model]") && !said.contains("unexpected"),
        "{said}"
    );
}
