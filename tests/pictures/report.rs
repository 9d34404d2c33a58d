//! `atlas report` through the real program: contents of its page, omissions, refusals. tests/python/test_report.py
//! tests the page in a browser, on the folders stored here in `target/tmp/reported/`.

#![allow(clippy::unwrap_used)]

use crate::program;
use program::atlas;
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use gearatlas::analysis::{
    ChaosOutcome, Class, EvidenceOutcome, LyapunovMethod, LyapunovOutcome, NvhOutcome,
    NvhStatistics, PoincareSample, PointOutcome, SampleKind, Status,
};
use gearatlas::report::{PageRequest, results_page};
use gearatlas::store::{
    AxisColumn, ColumnKind, Placement, PointRow, ResultLayout, ResultTable, ResultWriter, TableKind,
};
use serde_json::Value;

/// Folder of the stored results.
const WRITTEN: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/reported");

/// Markup that would run if any text of a folder were interpreted.
const MARKUP: &str = "</script><img src=x onerror=alert(1)>";

/// A one-degree oscillator in a gap.
const STRUCTURE: &str = include_str!("../manifests/oscillator.modal.toml");

const HEAD: &str = concat!(
    include_str!("../manifests/oscillator.head.toml"),
    "transient = 300\n"
);

const ANALYSES: &str = r#"
[analyses]
lyapunov = { exponents = 1, effort = "survey" }
nvh = { harmonics = 3, spectrum = {}, orders = {} }
poincare = { samples = 50 }
"#;

const GRID: &str = r#"
[grid]
load = { from = 0.02, to = 0.16, count = 8 }
speed = { from = "6000 rpm", to = "15000 rpm", count = 10 }
"#;

const POINT: &str = r#"
[grid]
load = 0.05
speed = 900
"#;

const LINE: &str = r#"
[grid]
load = { values = [0.05, 0.1] }
speed = { from = 600, to = 1500, count = 6 }
[continuation]
over = "speed"
second = "load"
starts = 3
longest_period = 2
"#;

const SWEEP: &str = r#"
[grid]
load = { values = [0.05, 0.1] }
speed = { from = 600, to = 1500, count = 6 }
order = "both"
along = "speed"
"#;

/// Two points that differ only in their load, one that differs only in its gap, and one in both.
const LIST: &str = r#"
[grid]
speed = 900
points = [
    { load = 0.05, "mesh.half_gap" = "15 um" },
    { load = 0.1, "mesh.half_gap" = "15 um" },
    { load = 0.1, "mesh.half_gap" = "20 um" },
    { load = 0.15, "mesh.half_gap" = "25 um" },
]
"#;

/// Output of a command in the folder of all folders.
fn said(arguments: &[&str]) -> String {
    program::said(WRITTEN, arguments)
}

/// The one-line message of a refused call.
fn refusal(arguments: &[&str]) -> String {
    let output = atlas(WRITTEN, arguments);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(text.lines().count(), 1, "{text}");
    text
}

/// The folders: `grid` of 80 points, `<img …>` of one, `followed` orbits with their run, a `sweep` up and down, a
/// `list` of points, a `trace`, and `chaos` that lasts, is transient, or has ended.
static FOLDERS: LazyLock<PathBuf> = LazyLock::new(|| {
    _ = fs::remove_dir_all(WRITTEN);
    fs::create_dir_all(WRITTEN).unwrap();
    let root = Path::new(WRITTEN);
    fs::write(root.join("atlas"), env!("CARGO_BIN_EXE_atlas")).unwrap();
    fs::write(root.join("oscillator.modal.toml"), STRUCTURE).unwrap();
    let comment = format!("# {MARKUP} <!-- {{{{blocks}}}}\n");
    for (name, parts) in [
        ("grid", [&comment, HEAD, ANALYSES, GRID]),
        ("point", ["", HEAD, "", POINT]),
        ("line", ["", HEAD, ANALYSES, LINE]),
        ("sweep", ["", HEAD, ANALYSES, SWEEP]),
        ("list", ["", HEAD, ANALYSES, LIST]),
    ] {
        fs::write(root.join(format!("{name}.toml")), parts.concat()).unwrap();
    }
    said(&["run", "grid.toml", "--out", "grid", "--quiet"]);
    said(&["run", "point.toml", "--out", "<img src=x>", "--quiet"]);
    said(&["run", "line.toml", "--out", "followed", "--quiet"]);
    said(&["run", "sweep.toml", "--out", "sweep", "--quiet"]);
    said(&["run", "list.toml", "--out", "list", "--quiet"]);
    said(&["follow", "line.toml", "--out", "followed", "--quiet"]);
    let point = ["--point", "load=0.05,speed=900", "--cycles", "20"];
    said(&[&["trace", "grid.toml", "--out", "trace"], &point[..]].concat());
    write_chaos(&root.join("chaos"));
    root.to_path_buf()
});

/// A plane of four by six points. By the remainder of their number over four: lasting chaos, chaos that three of eight
/// trajectories left, an orbit after chaos that all trajectories left, and an orbit without chaos before it. Errors of
/// the second half of the points are not verified.
fn write_chaos(folder: &Path) {
    let axis = |name: &str, unit: &str| AxisColumn {
        name: name.to_owned(),
        unit: unit.to_owned(),
    };
    let layout = ResultLayout {
        axes: vec![axis("load", "1"), axis("speed", "rad/s")],
        ..ResultLayout::default()
    };
    let mut writer = ResultWriter::create(folder, &layout, 0..24).unwrap();
    for point_id in 0..24 {
        let (class, exits, lambda) = match point_id % 4 {
            0 => (Class::Chaotic, 0, 0.2 + 0.01 * point_id as f64),
            1 => (Class::TransientChaos, 3, 0.1 + 0.01 * point_id as f64),
            2 => (Class::Periodic(3), 8, -0.2),
            _ => (Class::Periodic(1), 0, -0.1),
        };
        let unsettled = (point_id % 4 < 3).then_some(());
        let outcome = PointOutcome {
            class: Some(class),
            lyapunov: Some(LyapunovOutcome {
                exponents: vec![lambda],
                errors: vec![if lambda > 0.0 { 0.01 } else { 0.0 }],
                dimension: None,
                twin: None,
                twin_stderr: None,
                twin_agrees: None,
                method: LyapunovMethod::Tangent,
                convergence: None,
            }),
            evidence: unsettled.map(|()| EvidenceOutcome {
                trajectories: 8,
                verified: point_id < 12,
                correlation_cycles: Some(50.0),
                ess: Some(800.0),
                rhat: Some(1.01),
                ..EvidenceOutcome::default()
            }),
            chaos: unsettled.map(|()| ChaosOutcome {
                cycles: 24_000,
                exits,
                trajectories: 8,
                ended_on: (exits > 0).then(|| format!("periodic 3 ({exits})")),
                averages_before_exit: None,
            }),
            ..PointOutcome::without_results(Status::Ok, "as designed".into())
        };
        let (row, column) = (point_id / 6, point_id % 6);
        writer
            .push(PointRow {
                point_id,
                axis_values: vec![0.05 * (1 + row) as f64, 600.0 + 100.0 * column as f64],
                outcome,
                horizon: None,
                covariant: None,
                mesh: None,
                multistability: None,
                orbits: None,
                chain: None,
                kernel: "volterra".into(),
                placement: Placement::default(),
            })
            .unwrap();
    }
    writer.finish().unwrap();
}

/// The parts of a page.
struct Page {
    html: String,
    head: Value,
}

impl Page {
    fn of(html: String) -> Self {
        let start = "<script type=\"application/json\" id=\"head\">";
        let text = html.split(start).nth(1).unwrap();
        let head = serde_json::from_str(text.split("</script>").next().unwrap()).unwrap();
        Self { html, head }
    }

    /// The page of a folder, written by the program.
    fn written(name: &str, options: &[&str]) -> Self {
        // Tests at the same time write pages of the same folder with different options.
        static WRITTEN_PAGES: AtomicUsize = AtomicUsize::new(0);
        let number = WRITTEN_PAGES.fetch_add(1, Ordering::Relaxed);
        let out = FOLDERS.join(format!("page-{number}.html"));
        let fixed = [
            "report",
            name,
            "--overwrite",
            "--quiet",
            "--out",
            out.to_str().unwrap(),
        ];
        said(&[&fixed, options].concat());
        Self::of(fs::read_to_string(out).unwrap())
    }

    fn table(&self, name: &str) -> Option<&Value> {
        let tables = self.head["tables"].as_array().unwrap();
        tables.iter().find(|table| table["name"] == name)
    }

    /// An array of the page, inflated.
    fn bytes(&self, number: &Value) -> Vec<u8> {
        let start = format!("id=\"block-{number}\">");
        let text = self.html.split(&start).nth(1).unwrap();
        let packed = STANDARD
            .decode(text.split("</script>").next().unwrap())
            .unwrap();
        let mut bytes = Vec::new();
        ZlibDecoder::new(&packed[..])
            .read_to_end(&mut bytes)
            .unwrap();
        bytes
    }

    /// Elements of `N` bytes from their byte planes.
    fn elements<const N: usize>(&self, number: &Value) -> Vec<[u8; N]> {
        let planes = self.bytes(number);
        let count = planes.len() / N;
        let element = |row: usize| std::array::from_fn(|plane| planes[plane * count + row]);
        (0..count).map(element).collect()
    }

    fn numbers(&self, number: &Value) -> Vec<Option<f64>> {
        let values = self
            .elements::<8>(number)
            .into_iter()
            .map(f64::from_le_bytes);
        values
            .map(|value| Some(value).filter(|value| !value.is_nan()))
            .collect()
    }

    fn codes(&self, number: &Value) -> Vec<u32> {
        self.elements::<4>(number)
            .into_iter()
            .map(u32::from_le_bytes)
            .collect()
    }

    fn texts(&self, column: &Value) -> Vec<Option<String>> {
        let texts: Vec<String> = serde_json::from_slice(&self.bytes(&column["texts"])).unwrap();
        let text = |code: u32| Some(texts[code.checked_sub(1)? as usize].clone());
        self.codes(&column["block"]).into_iter().map(text).collect()
    }

    fn lists(&self, column: &Value) -> Vec<Option<Vec<Option<f64>>>> {
        let mut elements = self.numbers(&column["block"]).into_iter();
        let list = |length: u32| {
            (length != u32::MAX).then(|| elements.by_ref().take(length as usize).collect())
        };
        self.codes(&column["lengths"])
            .into_iter()
            .map(list)
            .collect()
    }

    /// Compares every column of a table with the file.
    fn agrees_with(&self, folder: &Path, kind: TableKind) {
        let own = self.table(kind.name()).unwrap();
        let table = ResultTable::read(folder, kind).unwrap();
        assert_eq!(own["kept"], table.rows());
        assert_eq!(own["rows"], table.rows());
        let columns: BTreeMap<&str, &Value> = (own["columns"].as_array().unwrap().iter())
            .map(|column| (column["name"].as_str().unwrap(), column))
            .collect();
        let empty: Vec<&str> = (own["empty"].as_array().unwrap().iter())
            .map(|name| name.as_str().unwrap())
            .collect();
        for head in table.columns().unwrap() {
            let name = head.name.as_str();
            let absent = |there: bool| assert!(!there, "{name} has values and is left out");
            let Some(column) = columns.get(name) else {
                assert!(
                    empty.contains(&name),
                    "{name} is neither told nor named as empty"
                );
                match head.kind {
                    ColumnKind::Text => {
                        absent(table.text(name).unwrap().iter().any(Option::is_some))
                    }
                    ColumnKind::Truth => {
                        absent(table.bool(name).unwrap().iter().any(Option::is_some))
                    }
                    ColumnKind::List => {
                        absent(table.lists(name).unwrap().iter().any(Option::is_some))
                    }
                    _ => absent(
                        table
                            .numbers(name)
                            .unwrap()
                            .iter()
                            .any(|row| !row.is_empty()),
                    ),
                }
                continue;
            };
            assert_eq!(column["unit"], head.unit, "{name}");
            assert_eq!(column["description"], head.description, "{name}");
            match head.kind {
                ColumnKind::Number => {
                    assert_eq!(self.numbers(&column["block"]), table.f64(name).unwrap())
                }
                ColumnKind::Whole => {
                    let wanted = table.u64(name).unwrap().into_iter();
                    let wanted: Vec<_> = wanted
                        .map(|value| value.map(|value| value as f64))
                        .collect();
                    assert_eq!(self.numbers(&column["block"]), wanted);
                }
                ColumnKind::Text => assert_eq!(self.texts(column), table.text(name).unwrap()),
                ColumnKind::Truth => {
                    let word = |truth: bool| if truth { "yes" } else { "no" }.to_owned();
                    let wanted = table.bool(name).unwrap().into_iter();
                    let wanted: Vec<_> = wanted.map(|truth| truth.map(word)).collect();
                    assert_eq!(self.texts(column), wanted);
                }
                ColumnKind::List => {
                    assert_eq!(self.lists(column), table.lists(name).unwrap(), "{name}")
                }
            }
        }
    }
}

#[test]
fn every_value_of_every_table_is_in_the_page() {
    for (name, wanted) in [
        (
            "grid",
            &[
                TableKind::Points,
                TableKind::Poincare,
                TableKind::Spectra,
                TableKind::Orders,
            ][..],
        ),
        ("<img src=x>", &[TableKind::Points]),
        (
            "followed",
            &[
                TableKind::Points,
                TableKind::Branches,
                TableKind::Bifurcations,
            ],
        ),
        ("trace", &[TableKind::Trace, TableKind::Events]),
    ] {
        let page = Page::written(name, &[]);
        assert_eq!(page.head["left_out"], serde_json::json!([]));
        for kind in wanted {
            page.agrees_with(&FOLDERS.join(name), *kind);
        }
        assert!(
            page.table("basins").is_none(),
            "a table that was not asked for"
        );
    }
}

#[test]
fn the_page_says_where_the_results_come_from() {
    let page = Page::written("grid", &[]);
    let folder = FOLDERS.join("grid");
    let record: Value =
        serde_json::from_slice(&fs::read(folder.join("run.json")).unwrap()).unwrap();
    assert_eq!(page.head["job"], "case");
    assert_eq!(page.head["state"], "complete");
    assert_eq!(page.head["runs"][0]["manifest"], record["manifest"]);
    assert_eq!(page.head["runs"][0]["machine"], record["machine"]);
    assert_eq!(
        page.head["checked"],
        record["tables"].as_array().unwrap().len()
    );
    let shown = said(&["show", "grid", "--color", "never"]);
    assert_eq!(
        page.head["summary"],
        shown.trim_end_matches('\n').to_owned() + "\n"
    );
    let axes = &page.head["axes"];
    assert_eq!(axes[1]["shown"], "rpm");
    assert!((axes[1]["factor"].as_f64().unwrap() - 9.549_296_585_513_72).abs() < 1e-12);
    // Motions are counted and coloured as in the pictures of `atlas plot`.
    let motions = page.head["motions"].as_array().unwrap();
    let points: u64 = motions
        .iter()
        .map(|motion| motion["points"].as_u64().unwrap())
        .sum();
    assert_eq!(points, 80);
    let codes = page.codes(&page.head["motion"]);
    let classes = page.table("points").unwrap()["columns"]
        .as_array()
        .unwrap()
        .iter();
    let classes = page.texts(
        classes
            .clone()
            .find(|column| column["name"] == "class")
            .unwrap(),
    );
    for (code, class) in codes.iter().zip(classes) {
        let motion = motions[*code as usize]["name"].as_str().unwrap();
        match class.unwrap().as_str() {
            "periodic" => assert!(motion.starts_with("period "), "{motion}"),
            class => assert_eq!(motion, class.replace("quasi_", "quasi-").replace('_', " ")),
        }
    }
}

/// `atlas show` and the page report chaos that lasts, is transient, or has ended.
#[test]
fn the_page_and_the_summary_tell_how_long_chaos_lasts() {
    let page = Page::written("chaos", &[]);
    page.agrees_with(&FOLDERS.join("chaos"), TableKind::Points);
    let motions = page.head["motions"].as_array().unwrap();
    let hatched: Vec<&str> = (motions.iter())
        .filter(|motion| motion["hatched"] == true)
        .map(|motion| motion["name"].as_str().unwrap())
        .collect();
    assert_eq!(hatched, ["transient chaos"]);
    let shown = said(&["show", "chaos", "--color", "never"]);
    for wanted in [
        "6 points: no trajectory left chaos; its mean life is at least 8000 (95 %)",
        "6 points: some trajectories left chaos",
        "6 points: all trajectories left chaos; its mean life is 3000",
        "standard errors are not verified for 9 of 18 points",
    ] {
        assert!(shown.contains(wanted), "{wanted}\n{shown}");
    }
    assert_eq!(shown.matches("life 8000 (95 %: ").count(), 6, "{shown}");
    let json: Value = serde_json::from_str(&said(&["show", "chaos", "--json"])).unwrap();
    assert_eq!(json["lifetimes"]["lasting"]["points"], 6);
    assert_eq!(json["lifetimes"]["transient"][0]["chaos"]["exits"], 3);
    assert_eq!(json["unverified_points"], 9);
}

/// No text of a folder ends a script, starts a comment or becomes an element; and the page loads nothing.
#[test]
fn texts_are_no_markup_and_nothing_is_loaded() {
    for name in ["grid", "<img src=x>"] {
        let page = Page::written(name, &[]);
        assert!(
            !page.html.contains(MARKUP) && !page.html.contains("<img"),
            "{name}"
        );
        let json = page.html.split("id=\"head\">").nth(1).unwrap();
        assert!(!json.split("</script>").next().unwrap().contains('<'));
        // The page has as many ends of scripts as starts.
        let ends = page.html.matches("</script>").count();
        assert_eq!(ends, page.html.matches("<script").count());
        let (before, after) = page.html.split_once("id=\"head\">").unwrap();
        let own = before.to_owned() + after.split_once("</script>").unwrap().1;
        for loading in ["src=", "@import", "url(", "fetch(", "XMLHttpRequest"] {
            assert!(!own.contains(loading), "{name}: {loading}");
        }
        assert!(page.html.contains("default-src 'none'"));
    }
    let page = Page::written("grid", &[]);
    let manifest = page.head["runs"][0]["manifest"].as_str().unwrap();
    assert!(manifest.contains(MARKUP) && manifest.contains("{{blocks}}"));
    assert_eq!(
        Page::written("<img src=x>", &[]).head["folder"],
        "<img src=x>"
    );
}

#[test]
fn the_same_folder_gives_the_same_bytes() {
    let (first, second) = (Page::written("grid", &[]), Page::written("grid", &[]));
    assert!(first.html == second.html);
    // The page is the same for any path of the folder. The program states its commit.
    gearatlas::store::ProgramRecord::set_commit(gearatlas::COMMIT);
    let whole = FOLDERS.join("grid");
    let third = results_page(&whole, PageRequest::default()).unwrap();
    assert!(first.html == third.html);
}

/// Columns and points without room are left out from the end, and named.
#[test]
fn what_has_no_room_is_left_out_and_named() {
    let whole = Page::written("grid", &[]);
    let kept = |page: &Page, table: &str| page.table(table).unwrap()["kept"].as_u64().unwrap();
    let size = |page: &Page| {
        let blocks = page.html.split("id=\"block-").skip(1);
        blocks
            .map(|block| block.split("</script>").next().unwrap().len())
            .sum::<usize>()
    };
    let most = size(&whole) / 3;
    let page = Page::written("grid", &["--most-bytes", &most.to_string()]);
    assert!(size(&page) < most + 4000, "{} of {most}", size(&page));
    let told = page.head["left_out"].to_string();
    assert!(told.contains("spectra: the page has rows of "), "{told}");
    assert!(told.contains(" of 80 points"), "{told}");
    let points = page.table("points").unwrap();
    assert_eq!(points["kept"], 80, "no point is left out");
    for table in ["orders", "spectra"] {
        assert!(kept(&page, table) < kept(&whole, table));
    }
    // The data of a kept point are complete.
    let ids = |page: &Page| {
        let columns = page.table("spectra").unwrap()["columns"]
            .as_array()
            .unwrap()
            .clone();
        page.numbers(
            &columns
                .iter()
                .find(|column| column["name"] == "point_id")
                .unwrap()["block"],
        )
    };
    let (some, all) = (ids(&page), ids(&whole));
    assert!(!some.is_empty());
    for id in &some {
        let of = |ids: &[Option<f64>]| ids.iter().filter(|other| *other == id).count();
        assert_eq!(of(&some), of(&all));
    }
    // Without any room only the columns that identify points remain.
    let page = Page::written("grid", &["--most-bytes", "0"]);
    let columns = page.table("points").unwrap()["columns"]
        .as_array()
        .unwrap()
        .iter();
    let names: Vec<&str> = columns
        .map(|column| column["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "point_id", "load", "speed", "status", "reason", "class", "period"
        ]
    );
    assert_eq!(kept(&page, "spectra"), 0);
}

#[test]
fn files_are_not_replaced_unasked_and_other_folders_are_refused() {
    let root = &*FOLDERS;
    let out = root.join("once.html");
    let answer = said(&["report", "followed", "--out", "once.html", "--json"]);
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["file"], "once.html");
    assert_eq!(answer["bytes"], fs::metadata(&out).unwrap().len());
    let text = refusal(&["report", "followed", "--out", "once.html"]);
    assert!(
        text.contains("`once.html` already exists") && text.contains("--overwrite"),
        "{text}"
    );
    said(&["report", "followed", "--out", "once.html", "--overwrite"]);
    let text = refusal(&["report", "nowhere"]);
    assert!(text.contains("the folder does not exist"), "{text}");
    let text = {
        let output = atlas(WRITTEN, &["report", "grid", "--most-bytes", "3 apples"]);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(text.contains("a size such as"), "{text}");
    // A changed table.
    let damaged = root.join("damaged");
    fs::create_dir_all(&damaged).unwrap();
    for entry in fs::read_dir(root.join("grid")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, damaged.join(path.file_name().unwrap())).unwrap();
        }
    }
    let spectra = damaged.join("spectra.parquet");
    let mut bytes = fs::read(&spectra).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&spectra, bytes).unwrap();
    let text = refusal(&["report", "damaged"]);
    assert!(text.contains("spectra.parquet"), "{text}");
    assert!(!damaged.join("report.html").exists());
}

#[test]
fn its_options_are_explained() {
    insta::assert_snapshot!("help", said(&["report", "--help"]));
}

/// A folder of 100 000 points with every statistic and Poincaré samples, stored in `target/tmp/reported/large/` for
/// `tests/python/test_report.py`, which measures how fast its page opens: run it with `--ignored`.
#[test]
#[ignore = "writes 100 000 points"]
fn a_large_folder_has_a_page_within_its_room() {
    const SIDES: [u64; 2] = [250, 400];
    let axis = |name: &str, unit: &str| AxisColumn {
        name: name.to_owned(),
        unit: unit.to_owned(),
    };
    let layout = ResultLayout {
        requested: vec![TableKind::Poincare],
        axes: vec![axis("load", "1"), axis("speed", "rad/s")],
        ..ResultLayout::default()
    };
    let folder = FOLDERS.join("large");
    let all = SIDES[0] * SIDES[1];
    let mut writer = ResultWriter::create(&folder, &layout, 0..all).unwrap();
    for point_id in 0..all {
        writer.push(large_row(point_id, SIDES[1])).unwrap();
    }
    writer.finish().unwrap();
    let page = Page::written("large", &[]);
    assert!(page.html.len() < 50_000_000, "{}", page.html.len());
    assert_eq!(page.table("points").unwrap()["kept"], all);
}

/// A point of the large folder: no two have the same statistics.
fn large_row(point_id: u64, columns: u64) -> PointRow {
    let [row, column] = [point_id / columns, point_id % columns].map(|place| place as f64);
    let wave = (0.031 * row).sin() * (0.017 * column).cos();
    let noise = ((point_id.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64) / 2f64.powi(53);
    let chaotic = wave > 0.2;
    let known = |scale: f64| scale * (1.5 + wave + 0.01 * noise);
    let sample = |cycle: u64| PoincareSample {
        cycle,
        phase: 0.0,
        deflection: known(1e-5) * (1.0 + (cycle as f64).sin()),
        velocity: known(1e-2) * (cycle as f64).cos(),
        kind: SampleKind::Strobe,
    };
    PointRow {
        point_id,
        axis_values: vec![0.01 + 0.001 * row, 500.0 + 5.0 * column],
        outcome: PointOutcome {
            class: Some(if chaotic {
                Class::Chaotic
            } else {
                Class::Periodic(1 + (point_id % 4) as u32)
            }),
            lyapunov: Some(LyapunovOutcome {
                exponents: vec![wave + 0.01 * noise],
                errors: vec![0.01 + 0.01 * noise],
                dimension: None,
                twin: None,
                twin_stderr: None,
                twin_agrees: None,
                method: LyapunovMethod::Tangent,
                convergence: None,
            }),
            nvh: Some(NvhOutcome {
                cycles: 800,
                deflection_pp: known(4e-5),
                force_peak: known(4e3),
                values: NvhStatistics {
                    deflection_mean: known(2e-5),
                    deflection_rms: known(1e-5),
                    force_mean: known(1e3),
                    force_std: known(5e2),
                    impact_rate: known(300.0),
                    impact_velocity: known(1e-2),
                    harmonics: [1e-6, 2e-6, 3e-6].map(known).to_vec(),
                    ..NvhStatistics::default()
                },
                ..NvhOutcome::default()
            }),
            poincare: (0..20).map(sample).collect(),
            events_per_cycle: Some(known(2.0)),
            ..PointOutcome::without_results(
                Status::Ok,
                format!("settled after {} cycles", 100 + point_id % 900),
            )
        },
        horizon: None,
        covariant: None,
        mesh: None,
        multistability: None,
        orbits: None,
        chain: None,
        kernel: "volterra".into(),
        placement: Placement {
            wall_time: 0.01 * noise,
            worker: (point_id % 2) as u32,
            numa_node: None,
        },
    }
}
