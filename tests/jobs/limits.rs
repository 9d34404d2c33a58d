//! Missing resources and obstacles: too few threads, far too many requested, symbolic links instead of files to be
//! written.

#![allow(clippy::unwrap_used)]

use crate::{place, results, skipped};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use skipped::skipped;
use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt, symlink};

const TABLES: [&str; 3] = ["points.parquet", "poincare.parquet", "spectra.parquet"];

/// Runs `$ATLAS` as a separate user with a limit of threads, from none to enough.
const FEW_THREADS: &str = r#"
set -u
[ "$(id -u)" = 0 ] || { echo "only root becomes another user"; exit 99; }
cp "$ATLAS" atlas && chmod 755 atlas || exit 98
for most in 1 2 3 4 5 6 12; do
    setpriv --reuid=61273 --regid=61273 --clear-groups \
        bash -c 'ulimit -u "$1" && exec ./atlas "${@:2}"' - "$most" "$@" \
        >"said.$most" 2>"errors.$most"
    echo "$most $?"
done
"#;

#[test]
fn threads_that_cannot_be_had_are_said_in_one_line() {
    let swept = OSCILLATOR.replace("count = 3", "count = 12");
    let place = Place::new(&swept);
    fs::set_permissions(place.0.path(), Permissions::from_mode(0o777)).unwrap();
    // Only the second mesh is computed from its drawing.
    let levels = r#"levels = ["5e8 N/m", "5e8 N/m", "5e8 N/m", "3.8e8 N/m", "3.8e8 N/m"]"#;
    let two_stage = include_str!("../../manifests/trains/two-stage.toml");
    assert!(two_stage.contains(levels));
    let drawn = two_stage.replace(levels, r#"law = "continuous""#);
    fs::write(place.path("drawn.toml"), drawn).unwrap();
    for (command, remedy) in [
        ("run m.toml --threads 4 --out few --overwrite", "--threads"),
        ("plan m.toml --threads 4", "--threads"),
        (
            "trace m.toml --point load=0.05,speed=600 --cycles 2 --out traced --overwrite",
            "ulimit -u",
        ),
        ("export few --overwrite", "ulimit -u"),
        ("check drawn.toml", "ulimit -u"),
    ] {
        let output = place.shell(&format!("set -- {command}\n{FEW_THREADS}"));
        if status(&output) == 99 {
            skipped(stdout(&output));
            return;
        }
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let (mut failed, mut done) = (0, 0);
        for line in stdout(&output).lines() {
            let (most, code) = line.split_once(' ').unwrap();
            let said = fs::read_to_string(place.path(&format!("errors.{most}"))).unwrap();
            assert!(
                !said.contains("panicked"),
                "{command}, {most} threads: {said}"
            );
            match code {
                "0" | "3" => done += 1,
                "1" => {
                    failed += 1;
                    assert_eq!(said.lines().count(), 1, "{said}");
                    assert!(said.contains("threads") && said.contains(remedy), "{said}");
                }
                _ => panic!("{command}, {most} threads: status {code}: {said}"),
            }
        }
        assert!(failed > 0 && done > 0, "{command}: {failed} {done}");
    }
}

#[test]
fn threads_beyond_all_use_are_not_started() {
    let quick = OSCILLATOR
        .replace("cycles = 300", "cycles = 20")
        .replace("transient = 50", "transient = 0")
        .replace("lyapunov = { exponents = 2 }", "");
    let place = Place::new(&quick.replace("count = 3", "count = 300"));
    let few = place.whole("few", &["--threads", "2"]);
    let many = place.whole("many", &["--threads", "4096"]);
    results::assert_same(&TABLES[..2], &few, &many);
    let placement = &place.record("many")["placement"];
    assert_eq!(placement["threads_asked"], 4096);
    let here = std::thread::available_parallelism().unwrap().get() as u64;
    let started = placement["threads"].as_u64().unwrap();
    assert!(
        started >= here && started <= (4 * here).max(32),
        "{started} on {here}"
    );
}

#[test]
fn links_are_replaced_or_refused_and_never_written_through() {
    let place = Place::new(OSCILLATOR);
    let mine = place.path("mine");
    fs::write(&mine, "mine").unwrap();
    let untouched = || assert_eq!(fs::read(&mine).unwrap(), b"mine");
    let out = place.whole("r", &[]);
    for name in TABLES.iter().chain(&["run.json"]) {
        fs::remove_file(out.join(name)).unwrap();
        symlink(&mine, out.join(name)).unwrap();
    }
    place.whole("r", &["--overwrite"]);
    untouched();
    for name in TABLES.iter().chain(&["run.json"]) {
        assert!(!out.join(name).is_symlink(), "{name}");
    }

    let drawn = |arguments: &[&str]| {
        let all = [
            &["plot", "r", "--what", "classes", "--format", "svg"],
            arguments,
        ]
        .concat();
        let output = place.atlas(&all);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        stdout(&output)
    };
    let picture = place.path(drawn(&[]).lines().next().unwrap());
    fs::remove_file(&picture).unwrap();
    symlink(&mine, &picture).unwrap();
    drawn(&[]);
    untouched();
    assert!(!picture.is_symlink());

    // The journal is also opened for reading: the target of a link is not the run's file.
    for (link, arguments) in [
        (".journal", &["--overwrite"][..]),
        (".journal", &["--retry", "failed"]),
        (".retry", &["--retry", "failed"]),
    ] {
        symlink(&mine, out.join(link)).unwrap();
        let output = place.run("r", arguments);
        let said = stderr(&output);
        assert_eq!((status(&output), said.lines().count()), (2, 1), "{said}");
        assert!(
            said.contains(link) && said.contains("symbolic link"),
            "{said}"
        );
        untouched();
        fs::remove_file(out.join(link)).unwrap();
    }
}
