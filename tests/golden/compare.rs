//! Results of a case, its recorded results, and their differences.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use crate::program::said;
use serde_json::Value;

/// Tolerance of a number, relative to its size. Rounding differs between processors, libraries and harmless changes of
/// the code; the cases amplify it to less than a tenth of this.
const RELATIVE: f64 = 1e-7;

/// Additional tolerance, relative to the largest number of its kind in the table. Differences of large numbers, such as
/// the force of a bearing along an axis without load, are only rounding.
const FLOOR: f64 = 1e-10;

/// Columns and keys that depend on the machine and the time, or that are only rounding.
const LEFT_OUT: [&str; 13] = [
    "points/wall_time",
    "points/worker",
    "points/numa_node",
    "points/energy_residual",
    "printed/hash",
    "printed/file",
    // The order of equal speeds depends on rounding.
    "printed/resonances",
    // These depend on rounding near a zero of the exponent.
    "bifurcations/lambda",
    "bifurcations/stable",
    "bifurcations/unstable",
    "curves/lambda",
    "curves/stable",
    "curves/unstable",
];

/// Columns with larger rounding errors: an exponent from the growth of a tiny distance.
const ROUGH: [&str; 2] = ["lambda_twin", "lambda_twin_stderr"];

/// Factor on the tolerance of [`ROUGH`] columns.
const ROUGHNESS: f64 = 1e5;

/// A column of a table, one value per row; or a printed number or text, with its path.
#[derive(Debug, Clone, PartialEq)]
struct Column {
    table: String,
    name: String,
    values: Vec<String>,
}

/// Computes a case and compares it with its recorded results; writes these anew if ATLAS_WRITE_GOLDEN is set.
pub fn check(case: &str, command: &str, set: &[&str]) {
    let found = computed(command, set);
    let path = recorded_in().join(format!("{case}.tsv"));
    if writes() {
        fs::write(path, text(&found)).unwrap();
        return;
    }
    let recorded = parsed(&fs::read_to_string(path).expect("a case that was recorded"));
    let faults = differences(&recorded, &found);
    let shown = faults
        .iter()
        .take(20)
        .fold(String::new(), |mut all, fault| {
            writeln!(all, "  {fault}").unwrap();
            all
        });
    assert!(
        faults.is_empty(),
        "case {case}: {} values differ (tests/golden/README.md)\n{shown}",
        faults.len()
    );
}

/// Whether recorded results are written anew.
pub fn writes() -> bool {
    std::env::var_os("ATLAS_WRITE_GOLDEN").is_some()
}

/// The folder of the recorded values.
pub fn recorded_in() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/values")
}

/// Runs the command of a case from the root of the repository.
fn computed(command: &str, set: &[&str]) -> Vec<Column> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scratch = tempfile::tempdir().unwrap();
    let place = |name: &str| scratch.path().join(name).to_str().unwrap().to_owned();
    let [results, tables, exported] = ["results", "tables", "exported"].map(place);
    let mut arguments: Vec<&str> = command.split(' ').collect();
    arguments.extend(set.iter().flat_map(|set| ["--set", set]));
    let (tabled, printed) = match arguments[0] {
        "check" => (false, true),
        "sensitivity" => (true, true),
        _ => (true, false),
    };
    if tabled {
        arguments.extend(["--tables", &tables]);
    }
    if printed {
        arguments.push("--json");
        let mut found = Vec::new();
        flatten(
            "",
            &serde_json::from_str(&said(root, &arguments)).unwrap(),
            &mut found,
        );
        return found;
    }
    arguments.extend(["--out", &results]);
    said(root, &arguments);
    said(root, &["export", &results, "--quiet", "--out", &exported]);
    let mut files: Vec<PathBuf> = fs::read_dir(exported)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    files.iter().flat_map(|file| columns(file)).collect()
}

/// A name without its unit.
fn stem(name: &str) -> &str {
    name.split(" [").next().unwrap()
}

fn is_left_out(table: &str, name: &str) -> bool {
    LEFT_OUT.contains(&&format!("{table}/{}", stem(name))[..])
}

/// The columns of an exported table.
fn columns(file: &Path) -> Vec<Column> {
    let table = file.file_stem().unwrap().to_str().unwrap();
    let text = fs::read_to_string(file).unwrap();
    let mut lines = text.lines().map(fields);
    let mut columns: Vec<Column> = lines
        .next()
        .unwrap()
        .into_iter()
        .map(|name| Column {
            table: table.to_owned(),
            name,
            values: Vec::new(),
        })
        .collect();
    for line in lines {
        assert_eq!(line.len(), columns.len(), "{}", file.display());
        for (column, value) in columns.iter_mut().zip(line) {
            column.values.push(rounded(&value));
        }
    }
    columns.retain(|column| !is_left_out(table, &column.name));
    columns
}

/// The fields of a line separated by commas; some are quoted.
fn fields(line: &str) -> Vec<String> {
    let (mut fields, mut quoted) = (vec![String::new()], false);
    for character in line.chars() {
        match character {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            other => fields.last_mut().unwrap().push(other),
        }
    }
    fields
}

/// Numbers and texts of JSON by their paths.
fn flatten(path: &str, value: &Value, found: &mut Vec<Column>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries
                .iter()
                .filter(|(key, _)| !is_left_out("printed", key))
            {
                flatten(&format!("{path}/{key}"), value, found);
            }
        }
        Value::Array(entries) => {
            for (index, value) in entries.iter().enumerate() {
                flatten(&format!("{path}/{index}"), value, found);
            }
        }
        Value::String(text) => found.push(printed(path, text)),
        other => found.push(printed(path, &other.to_string())),
    }
}

fn printed(path: &str, value: &str) -> Column {
    let values = vec![rounded(value)];
    Column {
        table: "printed".to_owned(),
        name: path.to_owned(),
        values,
    }
}

/// A number with ten digits, so that recorded results hide rounding; integers and texts are unchanged.
fn rounded(value: &str) -> String {
    match (value.parse::<i128>(), value.parse::<f64>()) {
        (Err(_), Ok(number)) => format!("{:?}", format!("{number:.9e}").parse::<f64>().unwrap()),
        _ => value.to_owned(),
    }
}

fn text(columns: &[Column]) -> String {
    let lines = columns.iter().map(|column| {
        let values = column.values.iter().map(|value| format!("\t{value}"));
        let values: String = values.collect();
        format!("{}\t{}{values}\n", column.table, column.name)
    });
    lines.collect()
}

fn parsed(text: &str) -> Vec<Column> {
    let columns = text.lines().map(|line| {
        let mut parts = line.split('\t').map(str::to_owned);
        let [table, name] = [(); 2].map(|()| parts.next().unwrap());
        Column {
            table,
            name,
            values: parts.collect(),
        }
    });
    columns.collect()
}

/// The value of another column of the same table and row, if it exists.
fn beside<'a>(columns: &'a [Column], column: &Column, row: usize, name: &str) -> Option<&'a str> {
    let mut others = columns.iter().filter(|other| other.table == column.table);
    let other = others.find(|other| other.name == name)?;
    other.values.get(row).map(String::as_str)
}

/// The kind of a number: a common unit, a numbered list, or signals with a unit.
fn kind(columns: &[Column], column: &Column, row: usize) -> (String, String, String) {
    let unit = column.name.split_once(" [").map(|(_, unit)| unit);
    let name = unit
        .unwrap_or(&column.name)
        .trim_end_matches(|c: char| c.is_ascii_digit());
    let name = name.replace(|c: char| c.is_ascii_digit(), "");
    let signal = beside(columns, column, row, "unit").unwrap_or_default();
    (column.table.clone(), name, signal.to_owned())
}

/// The largest number of each kind.
fn scales(columns: &[Column]) -> BTreeMap<(String, String, String), f64> {
    let mut scales = BTreeMap::new();
    for column in columns {
        for (row, value) in column.values.iter().enumerate() {
            if let Ok(number) = value.parse::<f64>()
                && number.is_finite()
            {
                let scale: &mut f64 = scales.entry(kind(columns, column, row)).or_default();
                *scale = scale.max(number.abs());
            }
        }
    }
    scales
}

/// A text without the residual of a search, which is rounding.
fn without_residual(text: &str) -> String {
    let mut words: Vec<&str> = text.split(' ').collect();
    if let Some(at) = words.iter().position(|word| *word == "(residual") {
        words.remove(at + 1);
    }
    words.join(" ")
}

/// Whether two values are equal: integers and texts exactly, others within a tolerance.
fn same(recorded: &str, found: &str, scale: f64, roughness: f64) -> bool {
    let whole = |text: &str| text.parse::<i128>().is_ok();
    match (recorded.parse::<f64>(), found.parse::<f64>()) {
        (Ok(a), Ok(b)) if a.is_finite() && !(whole(recorded) && whole(found)) => {
            (a - b).abs() <= roughness * (RELATIVE * a.abs() + FLOOR * scale)
        }
        _ => without_residual(recorded) == without_residual(found),
    }
}

/// Differences of two results, by table, point, row and column.
fn differences(recorded: &[Column], found: &[Column]) -> Vec<String> {
    let name = |column: &Column| (column.table.clone(), column.name.clone());
    let mut faults = Vec::new();
    let mut left: BTreeMap<_, _> = found.iter().map(|column| (name(column), column)).collect();
    let scales = scales(recorded);
    for column in recorded {
        let place = format!("{}, {}", column.table, column.name);
        let Some(now) = left.remove(&name(column)) else {
            faults.push(format!("{place}: is gone"));
            continue;
        };
        if now.values.len() != column.values.len() {
            let rows = [column, now].map(|column| column.values.len());
            faults.push(format!("{place}: {} rows were {} rows", rows[1], rows[0]));
        }
        for (row, (was, is)) in column.values.iter().zip(&now.values).enumerate() {
            let scale = scales
                .get(&kind(recorded, column, row))
                .copied()
                .unwrap_or_default();
            let roughness = if ROUGH.contains(&stem(&column.name)) { ROUGHNESS } else { 1.0 };
            if !same(was, is, scale, roughness) {
                let point = beside(recorded, column, row, "point_id")
                    .map_or_else(String::new, |point| format!("point {point}, "));
                faults.push(format!("{place}, {point}row {row}: {is} was {was}"));
            }
        }
    }
    faults.extend(
        left.keys()
            .map(|(table, name)| format!("{table}, {name}: is new")),
    );
    faults
}

#[test]
fn differences_are_told_and_rounding_is_not() {
    let column = |name: &str, values: &[&str]| Column {
        table: "points".to_owned(),
        name: name.to_owned(),
        values: values.iter().map(|value| (*value).to_owned()).collect(),
    };
    let recorded = [
        column("point_id", &["0", "4"]),
        column("force [N]", &["1234.5", "-2e-12"]),
        column("period", &["2", "3"]),
        column("reason", &["repeats (residual 2e-15 half gaps)", ""]),
    ];
    let mut rounding = recorded.clone();
    rounding[1].values = vec!["1234.500001".to_owned(), "3e-11".to_owned()];
    rounding[3].values[0] = "repeats (residual 0e0 half gaps)".to_owned();
    assert_eq!(differences(&recorded, &rounding), Vec::<String>::new());
    for (row, value, told) in [
        (
            1,
            ["1234.5", "1e-6"],
            "points, force [N], point 4, row 1: 1e-6 was -2e-12",
        ),
        (
            1,
            ["1234.501", "0"],
            "points, force [N], point 0, row 0: 1234.501 was 1234.5",
        ),
        (2, ["2", "4"], "points, period, point 4, row 1: 4 was 3"),
        (
            3,
            ["repeats", ""],
            "points, reason, point 0, row 0: repeats was repeats (residual 2e-15 half gaps)",
        ),
    ] {
        let mut other = recorded.clone();
        other[row].values = value.map(str::to_owned).to_vec();
        assert_eq!(differences(&recorded, &other), [told]);
    }
    let fewer = differences(&recorded, &recorded[..3]);
    assert_eq!(fewer, ["points, reason: is gone"]);
    assert_eq!(
        differences(&recorded[..3], &recorded),
        ["points, reason: is new"]
    );
    let empty = [column("cycle", &[]), column("reason", &[""])];
    for columns in [&recorded[..], &empty] {
        assert_eq!(parsed(&text(columns)), columns);
    }
}
