//! `atlas plot` through the real program: files for jobs over one, two and three axes, traces and damaged folders, and
//! messages if nothing can be drawn.

#![allow(clippy::unwrap_used)]

use crate::{program, seal};
use program::{atlas, said};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A one-degree oscillator in a gap: a point takes milliseconds.
const STRUCTURE: &str = include_str!("../manifests/oscillator.modal.toml");

const HEAD: &str = concat!(
    include_str!("../manifests/oscillator.head.toml"),
    "transient = 50\n"
);

const ANALYSES: &str = r#"
[analyses]
lyapunov = { exponents = 1, effort = "survey" }
poincare = { samples = 20 }
nvh = { harmonics = 3, spectrum = {} }
"#;

const ONE_AXIS: &str = "speed = { from = 600, to = 1500, count = 4 }\nload = 0.1";
const TWO_AXES: &str = "speed = { from = 600, to = 1500, count = 3 }\nload = [0.05, 0.1]";

/// A job's manifest in a new folder.
fn job(grid: &str, analyses: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let grid = grid.replace("[0.05, 0.1]", "{ values = [0.05, 0.1] }");
    let text = format!("{HEAD}{analyses}\n[grid]\n{grid}\n");
    fs::write(folder.path().join("m.toml"), text).unwrap();
    fs::write(folder.path().join("oscillator.modal.toml"), STRUCTURE).unwrap();
    folder
}

/// A finished job in `results/case`.
fn finished(grid: &str, analyses: &str) -> tempfile::TempDir {
    let folder = job(grid, analyses);
    said(folder.path(), &["run", "m.toml", "--quiet"]);
    folder
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Plots into `out` and returns the names of the files and the notes.
fn plotted(folder: &Path, source: &str, arguments: &[&str]) -> (Vec<String>, Vec<String>) {
    let fixed = ["plot", source, "--json", "--out", "out"];
    let output = atlas(folder, &[&fixed, arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let strings = |key: &str| -> Vec<String> {
        let list = said[key].as_array().unwrap().iter();
        list.map(|entry| entry.as_str().unwrap().to_owned())
            .collect()
    };
    let files = strings("files").into_iter().map(|path| {
        assert!(folder.join(&path).is_file(), "{path}");
        path.strip_prefix("out/").unwrap().to_owned()
    });
    (files.collect(), strings("notes"))
}

/// The error line of a plot that must fail.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = atlas(folder, &[&["plot"], arguments].concat());
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), "");
    text(&output.stderr)
}

/// All texts of an SVG picture, which must be well-formed.
fn labels(folder: &Path, name: &str) -> Vec<String> {
    let source = fs::read_to_string(folder.join("out").join(name)).unwrap();
    let document = roxmltree::Document::parse(&source).unwrap();
    let root = document.root_element();
    assert_eq!(root.tag_name().name(), "svg");
    assert_eq!(root.attribute("width"), Some("960"));
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    texts
        .map(|node| node.text().unwrap().trim().to_owned())
        .collect()
}

#[track_caller]
fn holds(labels: &[String], wanted: &[&str]) {
    for wanted in wanted {
        let found = labels.iter().any(|label| label.contains(wanted));
        assert!(found, "`{wanted}` is not among {labels:?}");
    }
}

/// Width and height of a PNG picture, and the share of its pixels that are not white.
fn image(path: &Path) -> ([u32; 2], f64) {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(frame.color_type, png::ColorType::Rgb);
    let marked = pixels.chunks_exact(3).filter(|rgb| *rgb != [255; 3]);
    let share = marked.count() as f64 / (pixels.len() / 3) as f64;
    ([frame.width, frame.height], share)
}

#[test]
fn a_job_over_one_axis_gives_curves_with_units() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let (files, notes) = plotted(folder.path(), "results/case", &[]);
    let of_point = |kind: &str, extension: &str| {
        let found = files
            .iter()
            .find(|name| name.starts_with(kind) && name.ends_with(extension));
        found.unwrap_or_else(|| panic!("no {kind} in {files:?}"))
    };
    assert_eq!(files.len(), 14, "{files:?}");
    assert_eq!(notes, [] as [&str; 0]);
    let path = folder.path();
    let lambda = labels(path, "lambda.svg");
    holds(&lambda, &["case: ", "load 0.1", "4 points"]);
    holds(&lambda, &["speed [rad/s]", "λ [1/cycle]", "λ = 0"]);
    let bifurcation = labels(path, "bifurcation.svg");
    let named = ["deflection at mesh phase 0 [µm]", "speed [rad/s]"];
    holds(&bifurcation, &named);
    holds(&bifurcation, &["λ [1/cycle]"]);
    holds(&labels(path, "classes.svg"), &["speed [rad/s]", "points"]);
    let spectrum = labels(path, of_point("spectrum-point", ".svg"));
    holds(
        &spectrum,
        &["mesh order [–]", "amplitude [", "largest deflection_rms"],
    );
    assert!(spectrum.iter().any(|label| label.ends_with("m]")));
    assert!(spectrum.iter().any(|label| label.ends_with("N]")));
    let phase = labels(path, of_point("phase-point", ".svg"));
    holds(
        &phase,
        &["at mesh phase 0", "rate of the deflection [", "m/s]"],
    );
    for name in files.iter().filter(|name| name.ends_with(".png")) {
        let ([width, height], marked) = image(&path.join("out").join(name));
        assert_eq!(width, 1920, "{name}");
        if !name.starts_with("classes") {
            assert_eq!(height, 1200, "{name}");
        }
        assert!(marked > 0.01 && marked < 0.9, "{name}: {marked}");
    }
}

#[test]
fn maps_show_every_point_of_two_axes() {
    let folder = finished(TWO_AXES, ANALYSES);
    let arguments = ["--what", "lambda,classes", "--format", "svg"];
    let (files, _) = plotted(folder.path(), "results/case", &arguments);
    assert_eq!(files, ["lambda.svg", "classes.svg"]);
    let classes = labels(folder.path(), "classes.svg");
    holds(&classes, &["speed [rad/s]", "load [–]", "6 points", "1050"]);
    // A key entry `chaotic (2)` for each kind of motion; the sum of counts is the number of points.
    let counted: usize = classes
        .iter()
        .filter_map(|label| label.strip_suffix(')')?.rsplit_once(" (")?.1.parse().ok())
        .reduce(|sum: usize, count| sum + count)
        .unwrap();
    assert_eq!(counted, 6);
    let over_load = ["--what", "lambda", "--over", "load", "--format", "svg"];
    let (files, _) = plotted(folder.path(), "results/case", &over_load);
    let expected = ["600", "1050", "1500"].map(|speed| format!("lambda-speed={speed}.svg"));
    assert_eq!(files, expected);
    holds(
        &labels(folder.path(), &files[1]),
        &["speed 1050 rad/s", "load [–]"],
    );
}

#[test]
fn further_axes_give_a_picture_a_slice() {
    let grid = format!("{TWO_AXES}\n\"mesh.half_gap\" = {{ values = [\"10 um\", \"15 um\"] }}");
    let folder = finished(&grid, ANALYSES);
    let arguments = ["--format", "svg", "--what", "classes,bifurcation"];
    let (files, notes) = plotted(folder.path(), "results/case", &arguments);
    assert_eq!(notes, [] as [&str; 0]);
    let maps = files.iter().filter(|name| name.starts_with("classes-"));
    // Two of the three axes span a map; the third has two or three values.
    assert!([2, 3].contains(&maps.count()), "{files:?}");
    let diagrams = files.iter().filter(|name| name.starts_with("bifurcation-"));
    let diagrams: Vec<&String> = diagrams.collect();
    assert_eq!(diagrams.len(), 4, "{files:?}");
    for name in diagrams {
        let labels = labels(folder.path(), name);
        holds(&labels, &["mesh.half_gap 1", " µm", "load 0.", "3 points"]);
    }
}

#[test]
fn the_same_files_give_the_same_bytes() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let contents = || -> Vec<Vec<u8>> {
        let (files, _) = plotted(folder.path(), "results/case", &[]);
        let paths = files
            .iter()
            .map(|name| folder.path().join("out").join(name));
        paths.map(|path| fs::read(path).unwrap()).collect()
    };
    assert!(contents() == contents());
}

#[test]
fn missing_tables_are_said_and_the_rest_is_drawn() {
    let folder = finished(
        ONE_AXIS,
        "[analyses]\nlyapunov = { exponents = 1, effort = \"survey\" }",
    );
    let path = folder.path();
    let (files, notes) = plotted(path, "results/case", &["--format", "png"]);
    assert_eq!(files, ["lambda.png", "classes.png"]);
    assert_eq!(notes.len(), 3, "{notes:?}");
    holds(
        &notes,
        &["bifurcation: ", "spectrum: ", "phase: ", "poincare"],
    );
    let said = refused(path, &["results/case", "--what", "spectrum"]);
    assert!(said.contains("spectrum = {}"), "{said}");
    assert!(said.contains("available here: lambda, classes\n"), "{said}");
    assert!(!path.join("results/case/pictures").exists());
}

#[test]
fn an_incomplete_run_is_drawn_and_called_so() {
    let folder = finished(TWO_AXES, ANALYSES);
    let path = folder.path();
    let classes = |source: &str| {
        plotted(path, source, &["--format", "svg", "--what", "classes"]);
        labels(path, "classes.svg")
    };
    // Compute every second point of the grid: three cells stay empty.
    let shard = [
        "run", "m.toml", "--quiet", "--out", "part", "--shard", "1/2",
    ];
    let output = atlas(path, &shard);
    assert!(output.status.code() != Some(2), "{}", text(&output.stderr));
    let said = classes("part");
    holds(
        &said,
        &["3 points", "incomplete: 1 of 2 shards", "not computed (3)"],
    );
    // Change the record as an interruption would.
    let record = path.join("results/case/run.json");
    seal::reseal(&record, |run| {
        run["state"] = "interrupted".into();
        run["totals"]["points"] = 10.into();
    });
    holds(&classes("results/case"), &["interrupted: 6 of 10 points"]);
    // Without the record it is unknown whether points are missing.
    fs::remove_file(&record).unwrap();
    holds(&classes("results/case"), &["without run.json"]);
}

/// A point can be named by its number or by the values of its axes; values between those of the grid name none.
#[test]
fn a_point_to_draw_is_named_by_number_or_by_axes() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let drawn = |point: &str| {
        let arguments = ["--what", "spectrum", "--point", point];
        let (files, _) = plotted(path, "results/case", &arguments);
        (
            files[0].clone(),
            fs::read(path.join("out").join(&files[0])).unwrap(),
        )
    };
    let third = drawn("2");
    assert!(drawn("speed=1200") == third && drawn("speed=1.2 krad/s,load=10 %") == third);
    assert!(drawn("3") != third);
    let said = refused(path, &["results/case", "--point", "speed=1000"]);
    assert!(said.contains("no point at these values"), "{said}");
}

#[test]
fn a_trace_shows_flanks_force_and_events() {
    let folder = job(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let arguments = ["trace", "m.toml", "--point", "speed=1500", "--out", "t"];
    let output = atlas(path, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let (files, notes) = plotted(path, "t", &[]);
    assert_eq!(files, ["phase.svg", "phase.png", "trace.svg", "trace.png"]);
    assert_eq!(notes, [] as [&str; 0]);
    let trace = labels(path, "trace.svg");
    holds(
        &trace,
        &["case: ", "load 0.1", "drive flank", "coast flank"],
    );
    holds(
        &trace,
        &["deflection [µm]", "mesh force [", "N]", "mesh cycles of"],
    );
    holds(&trace, &["drive", "free", "coast", "contact begins"]);
    let phase = labels(path, "phase.svg");
    holds(&phase, &["deflection [µm]", "m/s]", "mesh phase 0"]);
    for name in ["phase.png", "trace.png"] {
        let (size, marked) = image(&path.join("out").join(name));
        assert_eq!(size, [1920, 1200], "{name}");
        assert!(marked > 0.01, "{name}: {marked}");
    }
    let said = refused(path, &["t", "--what", "bifurcation"]);
    assert!(said.contains("`atlas run` wrote"), "{said}");
    assert!(said.contains("available here: phase, trace"), "{said}");
}

#[test]
fn bad_input_is_explained() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let said = refused(path, &["nowhere"]);
    assert!(
        said.starts_with("error: nothing to draw in `nowhere`"),
        "{said}"
    );
    let said = refused(path, &["results/case", "--what", "music"]);
    assert!(
        said.contains("no kind of picture and no column of numbers has the name `music`"),
        "{said}"
    );
    let said = refused(path, &["results/case", "--over", "load"]);
    assert!(said.contains("these have several: speed"), "{said}");
    let said = refused(path, &["results/case", "--point", "77"]);
    assert!(said.contains("no point 77"), "{said}");
    let said = refused(path, &["results/case", "--what", "trace"]);
    assert!(
        said.contains("available here: lambda, classes, bifurcation"),
        "{said}"
    );
    fs::write(path.join("results/case/points.parquet"), "not a table").unwrap();
    let said = refused(path, &["results/case"]);
    assert!(said.contains("points.parquet"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

#[test]
fn quiet_says_nothing() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let arguments = ["plot", "results/case", "--quiet", "--format", "svg"];
    let output = atlas(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(
        (text(&output.stdout), text(&output.stderr)),
        Default::default()
    );
    let pictures = folder.path().join("results/case/pictures");
    assert!(pictures.join("lambda.svg").is_file());
    assert!(!pictures.join("lambda.png").exists());
}

/// Marks of a picture: circles, polygons and polylines of SVG.
fn marks(folder: &Path, name: &str) -> [usize; 3] {
    let source = fs::read_to_string(folder.join("out").join(name)).unwrap();
    let document = roxmltree::Document::parse(&source).unwrap();
    ["circle", "polygon", "rect"].map(|kind| {
        let all = document.descendants();
        all.filter(|node| node.has_tag_name(kind)).count()
    })
}

const SVG: [&str; 2] = ["--format", "svg"];

#[test]
fn columns_of_one_unit_are_curves_of_one_picture() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let draw = |arguments: &[&str]| plotted(path, "results/case", &[&SVG, arguments].concat());
    let (files, notes) = draw(&["--what", "deflection_rms,force_peak,deflection_pp"]);
    assert_eq!(
        files,
        ["deflection_rms+deflection_pp.svg", "force_peak.svg"]
    );
    assert_eq!(notes, [] as [&str; 0]);
    let both = labels(path, &files[0]);
    holds(
        &both,
        &[
            "case: deflection_rms, deflection_pp over speed",
            "load 0.1",
            "4 points",
        ],
    );
    holds(
        &both,
        &[
            "deflection [µm]",
            "speed [rad/s]",
            "deflection_rms",
            "deflection_pp",
        ],
    );
    // Two curves with four points and a legend entry each: discs and squares, each drawn as fill and edge.
    let [discs, squares, _] = marks(path, &files[0]);
    assert_eq!((discs, squares), (10, 10));
    let (files, _) = draw(&["--what", "harmonics[2],lambda_max"]);
    assert_eq!(files, ["harmonics-mesh-order-2.svg", "lambda_max.svg"]);
    holds(&labels(path, &files[0]), &["harmonics, mesh order 2 ["]);
    let (files, _) = draw(&[
        "--what",
        "force_peak",
        "--db",
        "1 N",
        "--unit",
        "rpm",
        "--log",
        "x",
    ]);
    holds(
        &labels(path, &files[0]),
        &["force_peak [dB re 1 N]", "speed [rpm]"],
    );
    let (files, _) = draw(&["--what", "deflection_rms", "--range", "0:40 um"]);
    holds(
        &labels(path, &files[0]),
        &["deflection_rms [µm]", "0", "10", "40"],
    );
}

/// Number of discs of ink, behind the curves' marks: those of measured points and of the legend.
fn discs(folder: &Path, name: &str) -> usize {
    let source = fs::read_to_string(folder.join("out").join(name)).unwrap();
    let document = roxmltree::Document::parse(&source).unwrap();
    let circles = document.descendants().filter(|n| n.has_tag_name("circle"));
    circles.count()
}

#[test]
fn measured_points_lie_over_the_curves_of_their_column() {
    let folder = finished(TWO_AXES, ANALYSES);
    let path = folder.path();
    let plain = [
        "--what",
        "deflection_rms",
        "--over",
        "speed",
        "--format",
        "svg",
    ];
    let (files, _) = plotted(path, "results/case", &plain);
    let without: Vec<usize> = files.iter().map(|name| discs(path, name)).collect();
    fs::write(
        path.join("points.csv"),
        "# of a bench\nspeed [rpm];deflection_rms [um];stderr [um]\n6000;2;0.5\n9000;3;0\n20000;1;0.1\n",
    )
    .unwrap();
    let laid = [
        "--measured",
        "points.csv",
        "--format",
        "svg",
        "--unit",
        "rpm",
    ];
    let (with, _) = plotted(path, "results/case", &laid);
    assert_eq!(with, files, "they choose the column and its axis");
    for (name, before) in with.iter().zip(without) {
        let words = labels(path, name);
        holds(
            &words,
            &[
                "measured",
                "computed",
                "3 measured points",
                "± standard error",
            ],
        );
        holds(&words, &["speed [rpm]", "20"]);
        // A disc has two circles; the legend shows a computed and a measured one.
        assert_eq!(discs(path, name), before + 10, "{name}");
    }
    // With curves by value there is always a legend.
    let by = [
        "--measured",
        "points.csv",
        "--by",
        "load",
        "--format",
        "svg",
    ];
    let (by, _) = plotted(path, "results/case", &by);
    assert_eq!(by.len(), 1);
    holds(&labels(path, &by[0]), &["load 0.05", "measured"]);
    let (several, _) = plotted(
        path,
        "results/case",
        &[
            "--measured",
            "points.csv",
            "--what",
            "deflection_rms,force_peak",
            "--format",
            "svg",
        ],
    );
    for name in &several {
        let is_measured = labels(path, name).iter().any(|label| label == "measured");
        assert_eq!(is_measured, name.starts_with("deflection"), "{name}");
    }
}

#[test]
fn measured_points_that_fit_nothing_are_refused() {
    let folder = finished(ONE_AXIS, "");
    let path = folder.path();
    for (text, more, wanted) in [
        (
            "load,deflection_rms [um]\n0.1,2\n",
            &["--over", "speed"][..],
            "give --over load",
        ),
        (
            "pressure,deflection_rms [um]\n0.1,2\n",
            &[],
            "no grid axis `pressure`",
        ),
        (
            "speed [rpm],deflection_rsm [um]\n6000,2\n",
            &[],
            "did you mean deflection_rms",
        ),
        (
            "speed [rpm],deflection_rms [N]\n6000,2\n",
            &[],
            "whose unit is m",
        ),
        (
            "speed [um],deflection_rms [um]\n6000,2\n",
            &[],
            "whose unit is rad/s",
        ),
        (
            "speed [rpm],deflection_rms [um]\n6000,2\n",
            &["--what", "force_peak"],
            "--what deflection_rms",
        ),
        (
            "speed [rpm],deflection_rms [um]\n6000,2,3\n",
            &[],
            "the header has 2 columns",
        ),
        (
            "speed [rpm],deflection_rms [furlong]\n6000,2\n",
            &[],
            "`furlong` is not a known unit",
        ),
    ] {
        fs::write(path.join("points.csv"), text).unwrap();
        let arguments = [&["results/case", "--measured", "points.csv"], more].concat();
        let said = refused(path, &arguments);
        assert!(said.contains(wanted), "{text}: {said}");
    }
    let said = refused(path, &["results/case", "--measured", "absent.csv"]);
    assert!(said.contains("`absent.csv` cannot be read"), "{said}");
}

#[test]
fn a_column_over_two_axes_is_a_map_or_a_curve_by_value() {
    let folder = finished(TWO_AXES, ANALYSES);
    let path = folder.path();
    let column = ["--what", "deflection_rms"];
    let draw =
        |arguments: &[&str]| plotted(path, "results/case", &[&SVG, &column, arguments].concat());
    let (files, _) = draw(&[]);
    assert_eq!(files, ["deflection_rms.svg"]);
    holds(
        &labels(path, &files[0]),
        &["over load and speed", "deflection_rms [µm]", "6 points"],
    );
    // The white background, six cells, and the bar's 64 steps.
    assert_eq!(marks(path, &files[0])[2], 1 + 6 + 64);
    let (files, _) = draw(&["--by", "load"]);
    assert_eq!(files, ["deflection_rms-over-speed-by-load.svg"]);
    holds(
        &labels(path, &files[0]),
        &["load 0.05", "load 0.1", "6 points"],
    );
    let (files, _) = draw(&["--over", "load"]);
    assert_eq!(files.len(), 3, "{files:?}");
    holds(
        &labels(path, &files[1]),
        &["speed 1050 rad/s", "load [–]", "2 points"],
    );
}

#[test]
fn several_folders_are_curves_of_one_picture() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let other = fs::read_to_string(path.join("m.toml")).unwrap();
    let other = other.replace("load = 0.1", "load = 0.2");
    fs::write(path.join("n.toml"), other).unwrap();
    let output = atlas(
        path,
        &["run", "n.toml", "--quiet", "--out", "results/heavy"],
    );
    assert!(output.status.code() != Some(2), "{}", text(&output.stderr));
    let both = ["results/heavy", "--what", "force_mean", "--format", "svg"];
    let (files, _) = plotted(path, "results/case", &both);
    assert_eq!(files, ["force_mean-with-heavy.svg"]);
    // The legend shows the differences of the runs, not the common job.
    holds(
        &labels(path, &files[0]),
        &["case, load 0.1", "heavy, load 0.2", "8 points"],
    );
    let said = refused(
        path,
        &["results/case", "results/heavy", "--what", "classes"],
    );
    assert!(
        said.contains("classes pictures need a single folder"),
        "{said}"
    );
}

#[test]
fn spectra_are_waterfalls_and_order_cuts() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let draw = |arguments: &[&str]| plotted(path, "results/case", &[&SVG, arguments].concat());
    let (files, _) = draw(&["--what", "waterfall"]);
    assert_eq!(files, ["waterfall.svg"]);
    let said = labels(path, "waterfall.svg");
    holds(
        &said,
        &[
            "mesh order [–]",
            "speed [rad/s]",
            "deflection amplitude [",
            "white: no spectrum",
        ],
    );
    // The background, one strip per point, the bar's steps, and cells in every strip.
    assert!(marks(path, "waterfall.svg")[2] >= 1 + 4 + 64 + 4);
    draw(&[
        "--what",
        "waterfall",
        "--frequency",
        "--signal",
        "force",
        "--db",
        "1 N",
    ]);
    holds(
        &labels(path, "waterfall.svg"),
        &["frequency [kHz]", "force amplitude [dB re 1 N]"],
    );
    let (files, _) = draw(&["--what", "orders", "--orders", "1,2,1/2"]);
    assert_eq!(files, ["deflection-amplitude.svg"]);
    let said = labels(path, &files[0]);
    holds(
        &said,
        &[
            "mesh order 1",
            "mesh order 2",
            "mesh order 0.5",
            "deflection amplitude [",
        ],
    );
    let said = refused(
        path,
        &["results/case", "--what", "orders", "--signal", "sound"],
    );
    assert!(said.contains("its signals: deflection, force"), "{said}");
    let said = refused(
        path,
        &["results/case", "--what", "orders", "--orders", "99"],
    );
    assert!(said.contains("do not reach mesh order 99"), "{said}");
}

#[test]
fn a_campbell_diagram_comes_from_the_manifest() {
    // Mode at 2 kHz open; 20 teeth at 1050 rad/s mesh at 3342 Hz.
    let folder = job(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let (files, _) = plotted(path, "m.toml", &["--what", "campbell", "--format", "svg"]);
    assert_eq!(files, ["campbell.svg"]);
    let said = labels(path, "campbell.svg");
    holds(
        &said,
        &[
            "case: Campbell diagram",
            "speed [rad/s]",
            "frequency [kHz]",
            "× mesh",
        ],
    );
    holds(&said, &["1 × pinion", "dashed: mode, contacts open"]);
}

/// Keys from `--set` count as part of the manifest for all users of a run's record.
#[test]
fn pictures_of_a_run_are_of_its_drive_with_what_was_set() {
    let folder = job(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let speed = "speed = { from = \"6000 rpm\", to = \"14000 rpm\", count = 4 }";
    let stiffness = "mean_stiffness = \"4e8 N/m\"";
    let soft = "mean_stiffness = \"1e8 N/m\"";
    let manifest = fs::read_to_string(path.join("m.toml")).unwrap();
    let written = manifest
        .replace(stiffness, soft)
        .replace("speed = { from = 600, to = 1500, count = 4 }", speed);
    fs::write(path.join("soft.toml"), written).unwrap();
    let set = [
        "--set",
        &format!("mesh.{soft}"),
        "--set",
        &format!("grid.{speed}"),
    ];
    let set: Vec<&str> = set.into_iter().collect();
    let output = atlas(path, &[&["run", "m.toml", "--quiet"], &set[..]].concat());
    assert!(
        [0, 3].contains(&output.status.code().unwrap()),
        "{}",
        text(&output.stderr)
    );
    let resonances = |source: &str| -> serde_json::Value {
        let arguments = [
            "plot", source, "--what", "campbell", "--json", "--out", "out",
        ];
        let output = atlas(path, &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        said["resonances"].clone()
    };
    let of_run = resonances("results/case");
    assert_eq!(of_run, resonances("soft.toml"));
    assert_ne!(of_run, resonances("m.toml"));
    holds(&labels(path, "campbell.svg"), &["speed [rad/s]"]);
    resonances("results/case");
    holds(&labels(path, "campbell.svg"), &["speed [rpm]"]);
    plotted(
        path,
        "results/case",
        &["--what", "deflection_rms", "--format", "svg"],
    );
    holds(&labels(path, "deflection_rms.svg"), &["speed [rpm]"]);
}

/// Bearing forces by the names of the bearings: spur gears load the axial ones only by round-off.
#[test]
fn elements_of_lists_are_called_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let settings = [
        "run.transient=20",
        "run.cycles=60",
        "run.settle=false",
        "grid.load={ values = [0.1, 0.2, 0.3] }",
        "analyses={ nvh = { bearings = true, torques = true, accelerations = true } }",
    ];
    let quickstart = include_str!("../../manifests/quickstart.toml");
    fs::write(path.join("m.toml"), quickstart).unwrap();
    let set = settings.iter().flat_map(|change| ["--set", *change]);
    let run = ["run", "m.toml", "--quiet", "--out", "results"].into_iter();
    let output = atlas(path, &run.chain(set).collect::<Vec<_>>());
    assert!(
        [0, 3].contains(&output.status.code().unwrap()),
        "{}",
        text(&output.stderr)
    );
    let list = text(&atlas(path, &["plot", "results", "--list"]).stdout);
    holds(
        &list.lines().map(str::to_owned).collect::<Vec<_>>(),
        &[
            "elements: pinion 1 x, pinion 1 y, pinion 1 axial, pinion 2 x",
            "elements: pinion, wheel",
        ],
    );
    let drawn = |arguments: &[&str]| {
        let over = ["--over", "speed", "--by", "load", "--format", "svg"];
        let (files, _) = plotted(path, "results", &[arguments, &over].concat());
        labels(path, &files[0])
    };
    let all = drawn(&["--what", "bearing_rms"]);
    // Thirty curves: colours distinguish bearings, dashes loads.
    for entry in ["pinion 1 x", "wheel 2 y", "pinion 1 axial", "load 0.2"] {
        assert!(all.iter().any(|label| label == entry), "{entry}: {all:?}");
    }
    assert!(
        !all.iter().any(|label| label.contains("element")),
        "{all:?}"
    );
    let one = drawn(&["--what", "bearing_rms[pinion 1 x]"]);
    holds(&one, &["bearing_rms, pinion 1 x [N]"]);
    let some = drawn(&["--what", "bearing_rms[wheel x]"]);
    holds(&some, &["wheel 1 x", "wheel 2 x"]);
    assert!(
        !some.iter().any(|label| label.contains("pinion")),
        "{some:?}"
    );
    // Round-off also has a level, which must not stretch the axis.
    let levels = drawn(&["--what", "bearing_rms", "--db", "1 N"]);
    holds(&levels, &["24 values of round-off below the axis"]);
    let ticks = levels
        .iter()
        .filter_map(|label| label.replace('−', "-").parse::<f64>().ok());
    assert!(ticks.fold(0.0, f64::min) > -100.0, "{levels:?}");
    let said = refused(path, &["results", "--what", "bearing_rms[motor]"]);
    assert!(
        said.contains("its elements are pinion 1 x, pinion 1 y"),
        "{said}"
    );
    let exported = atlas(
        path,
        &[
            "export",
            "results",
            "--out",
            "csv",
            "--columns",
            "bearing_rms",
        ],
    );
    assert_eq!(
        exported.status.code(),
        Some(0),
        "{}",
        text(&exported.stderr)
    );
    let table = fs::read_to_string(path.join("csv/points.csv")).unwrap();
    assert!(
        table.starts_with("bearing_rms_pinion_1_x [N],bearing_rms_pinion_1_y [N],"),
        "{table}"
    );
}

#[test]
fn columns_that_cannot_be_drawn_are_refused() {
    let folder = finished(ONE_AXIS, ANALYSES);
    let path = folder.path();
    let said = |arguments: &[&str]| refused(path, &[&["results/case"], arguments].concat());
    let misspelt = said(&["--what", "deflection_rsm"]);
    assert!(
        misspelt.contains("did you mean deflection_rms"),
        "{misspelt}"
    );
    assert!(
        misspelt.contains("`atlas plot results/case --list` lists all"),
        "{misspelt}"
    );
    assert!(said(&["--what", "class"]).contains("this column contains text"));
    assert!(said(&["--what", "harmonics[9]"]).contains("have 3 elements"));
    assert!(said(&["--what", "force_peak[1]"]).contains("contains numbers, not lists"));
    assert!(said(&["--what", "orbits.lambda"]).contains("there is no orbits.parquet"));
    let unit = said(&["--what", "force_peak", "--db", "1 um"]);
    assert!(
        unit.contains("`--db 1 um` does not fit force_peak, whose unit is N"),
        "{unit}"
    );
    let unused = said(&["--what", "force_peak", "--unit", "kg"]);
    assert!(
        unused.contains("`--unit kg` does not fit any drawn quantity"),
        "{unused}"
    );
    assert!(said(&["--what", "force_peak", "--unit", "furlong"]).contains("not a known unit"));
    assert!(
        said(&["--what", "force_peak", "--over", "torque"]).contains("its axes are: load, speed")
    );
    let same = said(&["--what", "force_peak", "--over", "speed", "--by", "speed"]);
    assert!(same.contains("name the same axis"), "{same}");
    let list = atlas(path, &["plot", "results/case", "--list"]);
    let list = text(&list.stdout);
    assert!(list.contains("kinds    lambda, classes"), "{list}");
    assert!(list.contains("deflection_rms               m "), "{list}");
}

/// One rigid rotation in chaotic rattle.
const RATTLE: &str = r#"
[job]
name = "case"
[model]
kind = "modal"
file = "rotation.modal.toml"
[mesh]
half_gap = "10 um"
stiffness = "piecewise"
mean_stiffness = "4e8 N/m"
contact_ratio = 1.6
single_pair_drop = 0.25
contact_damping = "1483 N*s/m"
[excitation]
transmission_error = [{ harmonic = 1, amplitude = "5 um" }]
[run]
transient = 300
cycles = 1200
settle = false
[analyses]
lyapunov = { twin = false, effort = "survey" }
nvh = { bearings = true, spectrum = {} }
horizon = { twins = 8, cycles = 40, averages = 50 }
[grid]
load = 0.05
speed = 1200
"#;

#[test]
fn a_horizon_is_drawn_with_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), RATTLE).unwrap();
    let structure = r#"
teeth = 20
rated_force = 1330.0
frequency = [0.0]
damping = [0.0]
mesh = [1.3]
torque = [1.3]
[[bearing]]
name = "somewhere"
gain = [0.0]
"#;
    fs::write(folder.path().join("rotation.modal.toml"), structure).unwrap();
    let output = atlas(folder.path(), &["run", "m.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let (files, notes) = plotted(
        folder.path(),
        "results/case",
        &["--what", "horizon", "--format", "svg"],
    );
    assert_eq!(files, ["horizon-point0.svg"]);
    assert!(notes.is_empty(), "{notes:?}");
    let labels = labels(folder.path(), "horizon-point0.svg");
    holds(
        &labels,
        &[
            "separation of twins [half gaps]",
            "time [mesh cycles]",
            "standard error of a mean force",
            "dashes: λ = 0.",
            "horizon 1",
            "unrelated states:",
            "contact force:",
            "mesh force:",
        ],
    );
}

#[test]
fn a_job_without_twins_has_no_horizon() {
    let folder = finished("load = 0.1\nspeed = 1200", "");
    let said = refused(folder.path(), &["results/case", "--what", "horizon"]);
    assert!(said.contains("`horizon = {}` to [analyses]"), "{said}");
}

/// Values that no motion has, but that a file may contain.
const EXTREMES: [f64; 14] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    1e308,
    -1e300,
    5e-324,
    2.3e-308,
    -1e-310,
    0.0,
    -0.0,
    1.0,
    1.0 + f64::EPSILON,
];

/// Reproducible pseudo-random numbers (SplitMix64).
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % sides as u64) as usize
    }

    fn extreme(&mut self) -> f64 {
        EXTREMES[self.roll(EXTREMES.len())]
    }
}

/// Rewrites a table with extreme values in some columns: all equal, two different ones, or any; or with some, or all,
/// values missing.
fn distort(path: &Path, dice: &mut Dice) {
    use arrow_array::cast::AsArray;
    use arrow_array::types::Float64Type;
    use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
    use arrow_schema::DataType;
    use parquet::arrow::ArrowWriter;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use parquet::file::properties::WriterProperties;

    let builder = ParquetRecordBatchReaderBuilder::try_new(fs::File::open(path).unwrap()).unwrap();
    let metadata = builder
        .metadata()
        .file_metadata()
        .key_value_metadata()
        .cloned();
    let (schema, batches) = (builder.schema().clone(), builder.build().unwrap());
    let batches: Vec<RecordBatch> = batches.map(Result::unwrap).collect();
    let kinds: Vec<usize> = schema.fields().iter().map(|_| dice.roll(8)).collect();
    let pair = [dice.extreme(), dice.extreme()];
    let mut column = |kind: usize, array: &ArrayRef| -> ArrayRef {
        let rows = array.len();
        match array.data_type() {
            DataType::Float64 => {
                let old = array.as_primitive::<Float64Type>();
                let new = (0..rows).map(|row| match kind {
                    0 => Some(pair[0]),
                    1 => Some(pair[dice.roll(2)]),
                    2 => Some(dice.extreme()),
                    3 => (dice.roll(2) == 0).then(|| dice.extreme()),
                    4 => None,
                    _ => old.is_valid(row).then(|| old.value(row)),
                });
                std::sync::Arc::new(new.collect::<Float64Array>())
            }
            DataType::UInt64 if kind < 2 => {
                let wild = [0, 1, 7, u64::from(u32::MAX), u64::MAX];
                let new = (0..rows).map(|_| wild[dice.roll(wild.len())]);
                std::sync::Arc::new(new.collect::<UInt64Array>())
            }
            DataType::Utf8 if kind < 2 => {
                let wild = [
                    "chaotic",
                    "failed",
                    "up",
                    "\u{1b}[31m<&\u{0}",
                    "",
                    "deflection",
                ];
                let new = (0..rows).map(|_| Some(wild[dice.roll(wild.len())]));
                std::sync::Arc::new(new.collect::<StringArray>())
            }
            _ => array.clone(),
        }
    };
    let distorted: Vec<RecordBatch> = batches
        .iter()
        .map(|batch| {
            let columns = kinds.iter().zip(batch.columns());
            let columns = columns.map(|(kind, array)| column(*kind, array)).collect();
            RecordBatch::try_new(schema.clone(), columns).unwrap()
        })
        .collect();
    let properties = WriterProperties::builder()
        .set_key_value_metadata(metadata)
        .build();
    let file = fs::File::create(path).unwrap();
    let mut writer = ArrowWriter::try_new(file, schema, Some(properties)).unwrap();
    for batch in &distorted {
        writer.write(batch).unwrap();
    }
    writer.close().unwrap();
}

/// For any contents of the columns there are pictures or an error: no panic, no end by a signal, no hang.
/// ATLAS_PLOT_TRIALS sets the number of folders per job.
#[test]
fn extreme_columns_are_drawn_or_refused() {
    let trials = std::env::var("ATLAS_PLOT_TRIALS").map_or(12, |text| text.parse().unwrap());
    let all = "[analyses]\nlyapunov = { exponents = 1, effort = \"survey\" }\npoincare = { samples = 20 }\n\
               nvh = { harmonics = 3, spectrum = {} }\n\
               horizon = { twins = 4, cycles = 20, averages = 40 }\n";
    let swept = format!("{ONE_AXIS}\norder = \"both\"");
    let mut drawn = 0;
    for (job, grid) in [ONE_AXIS, TWO_AXES, &swept].into_iter().enumerate() {
        let folder = finished(grid, all);
        let results = folder.path().join("results/case");
        // With a record, every changed bit would be refused.
        fs::remove_file(results.join("run.json")).unwrap();
        let tables: Vec<_> = fs::read_dir(&results)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|e| e == "parquet"))
            .collect();
        for trial in 0..trials {
            let mut dice = Dice(1000 * job as u64 + trial);
            let torn = folder.path().join("torn");
            fs::create_dir_all(&torn).unwrap();
            for table in &tables {
                let copy = torn.join(table.file_name().unwrap());
                fs::copy(table, &copy).unwrap();
                if dice.roll(3) > 0 {
                    distort(&copy, &mut dice);
                }
            }
            let what = format!("job {job}, trial {trial}");
            let format = ["svg", "png"][dice.roll(2)];
            for arguments in [
                &[
                    "plot", "torn", "--format", format, "--out", "out", "--quiet",
                ][..],
                &["show", "torn"],
            ] {
                let output = patient(folder.path(), arguments, &what);
                let said = text(&output.stderr);
                let status = output.status.code();
                assert!(matches!(status, Some(0 | 2)), "{what}: {status:?} {said}");
                assert!(!said.contains("panicked"), "{what}: {said}");
                drawn += usize::from(status == Some(0));
            }
            fs::remove_dir_all(&torn).unwrap();
        }
    }
    assert!(drawn > 0, "everything was refused");
}

/// The output of the program; a minute counts as a hang.
fn patient(folder: &Path, arguments: &[&str], what: &str) -> Output {
    let mut child = Command::new("timeout");
    let output = child
        .arg("60")
        .arg(env!("CARGO_BIN_EXE_atlas"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    assert_ne!(output.status.code(), Some(124), "{what} hangs");
    output
}

/// Number of points that each line of a picture joins, from left to right, without horizontal and vertical lines (axes,
/// ticks, bars) and outlines.
fn slanted(folder: &Path, name: &str) -> Vec<usize> {
    let source = fs::read_to_string(folder.join("out").join(name)).unwrap();
    let document = roxmltree::Document::parse(&source).unwrap();
    let lines = document
        .descendants()
        .filter(|node| node.has_tag_name("polyline"));
    let places = lines.map(|line| -> Vec<[f64; 2]> {
        let numbers = line.attribute("points").unwrap().split([' ', ',']);
        let numbers: Vec<f64> = numbers.filter_map(|number| number.parse().ok()).collect();
        numbers
            .chunks(2)
            .map(|place| [place[0], place[1]])
            .collect()
    });
    let slanted = places.filter(|line| {
        let differs = |side: usize| line.iter().any(|place| place[side] != line[0][side]);
        differs(0) && differs(1) && line.first() != line.last()
    });
    let counts = slanted.map(|line| {
        assert!(line.is_sorted_by(|a, b| a[0] <= b[0]), "{name}: {line:?}");
        line.len()
    });
    counts.collect()
}

/// Points in no order: three with one half gap, two with another, one alone.
const LIST: &str = "speed = 900\npoints = [
    { load = 0.3, \"mesh.half_gap\" = \"15 um\" },
    { load = 0.05, \"mesh.half_gap\" = \"15 um\" },
    { load = 0.2, \"mesh.half_gap\" = \"20 um\" },
    { load = 0.1, \"mesh.half_gap\" = \"15 um\" },
    { load = 0.1, \"mesh.half_gap\" = \"20 um\" },
    { load = 0.15, \"mesh.half_gap\" = \"25 um\" },
]";

/// As in the page of `atlas report`: a line joins points that differ only on its axis.
#[test]
fn points_of_a_list_are_joined_only_where_nothing_else_differs() {
    let folder = finished(LIST, ANALYSES);
    let path = folder.path();
    let draw = |arguments: &[&str]| {
        let (files, _) = plotted(path, "results/case", &[&SVG, arguments].concat());
        let lines = slanted(path, &files[0]);
        (lines, labels(path, &files[0]))
    };
    for what in ["lambda", "lambda_max", "deflection_pp"] {
        let (mut lines, words) = draw(&["--what", what, "--over", "load"]);
        lines.sort_unstable();
        assert_eq!(lines, [2, 3], "{what}");
        holds(&words, &["lines join points with the same mesh.half_gap"]);
    }
    let (lines, words) = draw(&["--what", "deflection_pp", "--over", "mesh.half_gap"]);
    assert_eq!(lines, [2]);
    holds(&words, &["lines join points with the same load"]);
    // Curves with one value of the other axis each need no such words.
    let by = [
        "--what",
        "deflection_pp",
        "--over",
        "load",
        "--by",
        "mesh.half_gap",
    ];
    let (mut lines, words) = draw(&by);
    lines.retain(|&places| places > 2);
    assert_eq!(lines, [3]);
    assert!(
        !words.iter().any(|word| word.contains("lines join")),
        "{words:?}"
    );
}

/// If the state is carried along a list, the points of the list form one line, for any other changes along it.
#[test]
fn a_chain_over_a_list_is_one_line() {
    let grid = format!("{LIST}\norder = \"sweep-up\"\nalong = \"load\"")
        .replace("{ load = 0.1, \"mesh.half_gap\" = \"20 um\" },", "");
    let folder = finished(&grid, ANALYSES);
    let (files, _) = plotted(
        folder.path(),
        "results/case",
        &[&SVG[..], &["--what", "deflection_pp"]].concat(),
    );
    assert_eq!(slanted(folder.path(), &files[0]), [5]);
}
