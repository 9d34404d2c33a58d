//! Refined grids through the real program: a boundary known in closed form is found within the resolution, and the bits
//! are the same after any interruption.

#![allow(clippy::unwrap_used)]

use crate::{place, results};
use gearatlas::numerics::nested_grid::NestedGrid;
use gearatlas::store::{ResultTable, TableKind};
use place::{Place, status, stderr, stdout};
use results::assert_same;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// A rigid relative rotation under load: stiff in contact, free in the gap.
const STRUCTURE: &str = include_str!("../manifests/one.modal.toml");

const MANIFEST: &str = concat!(
    r#"
[job]
name = "plane"

"#,
    include_str!("../manifests/one.head.toml"),
    r#"
[grid]
load = { from = 0.6, to = 1.0, count = 3 }
speed = { from = 1400, to = 2200, count = 4 }

[grid.refine]
levels = 5

[run]
transient = 200
cycles = 1000
audit_cycles = 0

[analyses]
poincare = { samples = 4 }
lyapunov = { twin = false }
"#
);

const NESTED: NestedGrid = NestedGrid {
    coarse: [3, 4],
    levels: 5,
};

const TABLES: [&str; 2] = ["points.parquet", "poincare.parquet"];

/// A folder with the manifest, with some replacements in its text.
fn place(changes: &[(&str, &str)]) -> Place {
    let mut text = MANIFEST.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let place = Place::new(&text);
    fs::write(place.path("one.modal.toml"), STRUCTURE).unwrap();
    place
}

/// The speed above which motion in constant contact exists: its amplitude
/// `e Ω²/|k w² − Ω² + i c w² Ω|`, Ω the mesh frequency, reaches the static deflection `F/k` there.
fn contact_is_regained(load: f64) -> f64 {
    let (square, k, c, e) = (1.3f64 * 1.3, 4e8, 1483.0, 1e-6);
    let excess = |speed: f64| {
        let forcing = 20.0 * speed;
        let (stiff, loss) = (k * square - forcing * forcing, c * square * forcing);
        e * forcing * forcing / stiff.hypot(loss) - 1330.0 * load / k
    };
    let (mut loud, mut quiet) = ((k * square).sqrt() / 20.0, 5000.0);
    for _ in 0..200 {
        let middle = 0.5 * (quiet + loud);
        if excess(middle) > 0.0 { loud = middle } else { quiet = middle }
    }
    0.5 * (quiet + loud)
}

/// Speed and class of the points of every load, by speed.
fn rows(folder: &Path) -> BTreeMap<u64, Vec<(f64, String)>> {
    let table = ResultTable::read(folder, TableKind::Points).unwrap();
    let (loads, speeds) = (table.f64("load").unwrap(), table.f64("speed").unwrap());
    let classes = table.text("class").unwrap();
    let mut rows: BTreeMap<u64, Vec<(f64, String)>> = BTreeMap::new();
    for ((load, speed), class) in loads.iter().zip(&speeds).zip(&classes) {
        let row = rows.entry(load.unwrap().to_bits()).or_default();
        row.push((speed.unwrap(), class.clone().unwrap()));
    }
    for row in rows.values_mut() {
        row.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    rows
}

#[test]
fn a_boundary_in_closed_form_is_found_within_the_resolution() {
    let place = place(&[]);
    let folder = place.whole("out", &[]);
    let rows = rows(&folder);
    let [loads, speeds] = NESTED.sides(NESTED.levels);
    // The boundary crosses every row. A steep part needs no points between two rows.
    assert!(10 * rows.len() > 9 * loads, "{} of {loads}", rows.len());
    let step = 800.0 / (speeds - 1) as f64;
    let mut points = 0;
    for (load, row) in &rows {
        points += row.len();
        let load = f64::from_bits(*load);
        let wanted = contact_is_regained(load);
        let brackets: Vec<[f64; 2]> = (row.windows(2))
            .filter(|pair| pair[0].1 != "steady_contact" && pair[1].1 == "steady_contact")
            .map(|pair| [pair[0].0, pair[1].0])
            .collect();
        let found = brackets.iter().any(|[low, high]| {
            high - low < 1.001 * step && *low - step <= wanted && wanted <= *high + step
        });
        assert!(found, "load {load}: {wanted} in {brackets:?}");
    }
    assert!(
        16 * points < loads * speeds,
        "{points} of {}",
        loads * speeds
    );
}

#[test]
fn threads_and_interruptions_change_nothing() {
    // The points take long enough to be interrupted.
    let place = place(&[("cycles = 1000", "cycles = 1000\nsettle = false")]);
    let one = place.whole("one", &["--threads", "1"]);
    for threads in ["2", "5"] {
        let many = place.whole(threads, &["--threads", threads]);
        assert_same(&TABLES, &one, &many);
    }
    let journal = place.path("cut").join(".journal");
    let length = || fs::metadata(&journal).map_or(0, |found| found.len());
    let mut cut = 0;
    for bytes in [15_000, 40_000, 70_000] {
        let mut child = place
            .command("cut", &["--threads", "2", "-q"])
            .spawn()
            .unwrap();
        let patience = Instant::now();
        while length() < bytes && child.try_wait().unwrap().is_none() {
            assert!(patience.elapsed() < Duration::from_secs(60), "{bytes}");
            std::thread::sleep(Duration::from_millis(1));
        }
        cut += u32::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert!(cut >= 2, "killed {cut} times");
    let resumed = place.whole("cut", &[]);
    assert!(place.record("cut")["totals"]["resumed"].as_u64().unwrap() > 20);
    assert_same(&TABLES, &one, &resumed);
}

/// An interrupted map is drawn as far as it is computed, with a note that more points may be missing.
#[test]
fn what_was_interrupted_says_so() {
    let place = place(&[("cycles = 1000", "cycles = 1000\nsettle = false")]);
    let child = place.command("out", &["--threads", "1"]).spawn().unwrap();
    let journal = place.path("out").join(".journal");
    let patience = Instant::now();
    while fs::metadata(&journal).map_or(0, |found| found.len()) < 30_000 {
        assert!(patience.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    place.shell(&format!("kill -s INT {}", child.id()));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let show = stdout(&place.atlas(&["show", "out"]));
    assert!(show.contains("interrupted: at least "), "{show}");
    let plotted = place.atlas(&["plot", "out", "--what", "classes"]);
    assert_eq!(status(&plotted), 0, "{}", stderr(&plotted));
}

/// Results of every point, bit for bit, by its number.
fn points(changes: &[(&str, &str)]) -> BTreeMap<u64, Vec<u64>> {
    let place = place(changes);
    let table = ResultTable::read(&place.whole("out", &[]), TableKind::Points).unwrap();
    let numbers = [
        "load",
        "speed",
        "lambda_max",
        "lambda_stderr",
        "events_per_cycle",
    ]
    .map(|name| table.f64(name).unwrap());
    let cycles = table.u64("cycles").unwrap();
    let ids = table.u64("point_id").unwrap();
    let row = |row: usize| {
        let bits = numbers
            .iter()
            .map(|column| column[row].map_or(0, f64::to_bits));
        bits.chain(cycles[row]).collect()
    };
    (ids.iter().zip(0..))
        .map(|(id, at)| (id.unwrap(), row(at)))
        .collect()
}

/// Numbers, and with them random streams, are those of the grid without levels: its results do not change, nor those of
/// a shallower map.
#[test]
fn further_levels_change_no_results() {
    let plain = points(&[("[grid.refine]\nlevels = 5", "")]);
    let [shallow, deep] =
        ["2", "4"].map(|levels| points(&[("levels = 5", &format!("levels = {levels}"))]));
    assert!(plain.len() < shallow.len() && shallow.len() < deep.len());
    for (id, found) in &plain {
        assert_eq!(shallow.get(id), Some(found), "point {id}");
    }
    let both = (shallow.iter()).filter_map(|(id, found)| Some((id, found, deep.get(id)?)));
    let mut shared = 0;
    for (id, found, again) in both {
        assert_eq!(again, found, "point {id}");
        shared += 1;
    }
    assert!(10 * shared > 9 * shallow.len());
    let known = TryInto::<u64>::try_into(NESTED.places(0)).unwrap();
    assert!(plain.keys().copied().eq(0..known));
}

/// Kind of motion and period of every computed place of a plane.
fn motions(count: &str, refine: &str) -> BTreeMap<[usize; 2], (String, Option<u64>)> {
    let (load, speed) = (
        format!("0.05, to = 1.0, count = {count}"),
        format!("600, to = 2200, count = {count}"),
    );
    let place = place(&[
        ("amplitude = \"1 um\"", "amplitude = \"5 um\""),
        ("0.6, to = 1.0, count = 3", &load),
        ("1400, to = 2200, count = 4", &speed),
        ("[grid.refine]\nlevels = 5", refine),
        (
            "poincare = { samples = 4 }\nlyapunov = { twin = false }",
            "lyapunov = { effort = \"survey\", twin = false }",
        ),
    ]);
    let table = ResultTable::read(&place.whole("out", &[]), TableKind::Points).unwrap();
    let (ids, periods) = (table.u64("point_id").unwrap(), table.u64("period").unwrap());
    let nested = NestedGrid {
        coarse: [9, 9],
        levels: 3,
    };
    let at = |id: u64| {
        let id = usize::try_from(id).unwrap();
        if refine.is_empty() { [id / 65, id % 65] } else { nested.at(id) }
    };
    let classes = table.text("class").unwrap();
    let motion = |row: usize| (classes[row].clone().unwrap(), periods[row]);
    (ids.iter().enumerate())
        .map(|(row, id)| (at(id.unwrap()), motion(row)))
        .collect()
}

/// One mode, 65 x 65 places: computing a third of them finds every region of at least four places in the whole grid.
#[test]
fn a_refined_map_misses_no_region_of_the_whole_grid() {
    let whole = motions("65", "");
    let found = motions("9", "[grid.refine]\nlevels = 3");
    assert!(
        20 * found.len() < 7 * whole.len(),
        "{} of {}",
        found.len(),
        whole.len()
    );
    for (place, motion) in &found {
        assert_eq!(whole.get(place), Some(motion), "{place:?}");
    }
    let mut rest = whole.clone();
    let mut regions = 0;
    while let Some((first, motion)) = rest.pop_first() {
        let (mut region, mut open) = (vec![first], vec![first]);
        while let Some([row, column]) = open.pop() {
            let around = [
                [row + 1, column],
                [row.wrapping_sub(1), column],
                [row, column + 1],
                [row, column.wrapping_sub(1)],
            ];
            for next in around {
                if rest.get(&next) == Some(&motion) {
                    rest.remove(&next);
                    region.push(next);
                    open.push(next);
                }
            }
        }
        if region.len() >= 4 && motion.0 != "not_converged" {
            regions += 1;
            assert!(
                region.iter().any(|place| found.contains_key(place)),
                "{motion:?} at {region:?}"
            );
        }
    }
    assert!(regions >= 25, "{regions}");
}

#[test]
fn shards_and_retries_are_refused() {
    let place = place(&[]);
    for arguments in [["--shard", "1/2"], ["--retry", "failed"]] {
        let output = place.run("out", &arguments);
        assert_eq!(status(&output), 2);
        let said = stderr(&output);
        assert!(
            said.contains(arguments[0]) && said.contains("grid.refine"),
            "{said}"
        );
    }
    let output = place.atlas(&["plan", "m.toml", "--shard", "1/2"]);
    assert_eq!(status(&output), 2);
    assert!(!place.path("out").exists());
}

#[test]
fn what_may_be_computed_is_said_before_and_after() {
    let place = place(&[("speed = {", "\"mesh.half_gap\" = \"10 um\"\nspeed = {")]);
    let known = "12 = 1 mesh.half_gap x 3 load x 4 speed; more where class, period differ, up to 5 \
                 halvings of each interval: at most 6305 = 1 mesh.half_gap x 65 load x 97 speed";
    for command in ["check", "plan"] {
        let said = stdout(&place.atlas(&[command, "m.toml"]));
        assert!(said.contains(known), "{said}");
    }
    place.whole("out", &["-q"]);
    let show = stdout(&place.atlas(&["show", "out"]));
    for part in [
        "refined by class, period: from 3 x 4 points by up to 5 halvings",
        "of 65 x 97",
        "every point starts from run.initial (static)",
        "load (down) over speed [rad/s]",
    ] {
        assert!(show.contains(part), "{part}: {show}");
    }
    let plotted = place.atlas(&["plot", "out", "--what", "classes,lambda"]);
    assert_eq!(status(&plotted), 0, "{}", stderr(&plotted));
}
