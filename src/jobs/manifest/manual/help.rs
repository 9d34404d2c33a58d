//! The manual in a terminal: all keys with one line each, or one key in detail.

use super::DRIVE;
use super::words::{default, first_sentence, home, name, range, stands_alone, takes};
use crate::manifest::schema::{self, HOUSING_FILE, Key, Kind, MANIFEST, MODAL_FILE, Schema};

/// Characters per line.
const WIDTH: usize = 96;

/// A topic that is neither a table nor a key.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no table or key `{topic}` in a manifest or in a file that it names{}", advice(.nearest))]
pub struct NoSuchKey {
    /// The topic.
    pub topic: String,
    /// The nearest key, if one is similar enough.
    pub nearest: Option<String>,
}

fn advice(nearest: &Option<String>) -> String {
    match nearest {
        Some(near) => format!("; did you mean `{near}`?"),
        None => "; `atlas help manifest` lists all".to_owned(),
    }
}

/// Every table and key of a manifest, a modal file and a housing file, with one line each.
pub fn overview() -> String {
    let mut text = String::from(
        "Keys of a manifest. `atlas help KEY` describes one in full, for example `atlas help mesh.half_gap`.\n",
    );
    for table in schema::all(MANIFEST).filter(|key| is_header(key)) {
        text += &format!("\n[{}]\n", table.path);
        text += &listed(MANIFEST, table.path);
    }
    text + "\nA modal file\n"
        + &listed(MODAL_FILE, "")
        + "\nA housing file\n"
        + &listed(HOUSING_FILE, "")
}

fn is_header(key: &Key) -> bool {
    key.kind == Kind::Table && stands_alone(key)
}

/// The keys of one table, with one line each.
fn listed(schema: Schema, table: &str) -> String {
    let keys: Vec<&Key> = schema::all(schema)
        .filter(|key| key.kind != Kind::Table && stands_alone(key) && home(key) == table)
        .collect();
    let width = keys.iter().map(|key| name(key).len()).max().unwrap_or(0);
    keys.iter()
        .map(|key| {
            format!(
                "  {:width$}  {}\n",
                name(key),
                first_sentence(key.about).trim_end_matches('.')
            )
        })
        .collect()
}

/// All keys of a manifest and of the files that it may name.
fn every_key() -> impl Iterator<Item = &'static Key> {
    let schemas = [MANIFEST, MODAL_FILE, HOUSING_FILE].into_iter();
    schemas.flat_map(schema::all)
}

/// The full names of tables and keys of a manifest and of the files that it may name, except keys in entries of lists
/// and keys of either shaft.
pub fn topics() -> impl Iterator<Item = &'static str> {
    every_key()
        .map(|key| key.path)
        .filter(|path| !path.contains(['*', '<']))
}

/// A table or a key in detail. A table's name may have brackets. The last part of a path alone means all tables and
/// keys of a manifest that have it.
///
/// # Errors
///
/// There is no such key; the error has the nearest one.
pub fn explain(topic: &str) -> Result<String, NoSuchKey> {
    let plain = topic.trim_start_matches('[').trim_end_matches(']');
    let exact = |schema| schema::find(schema, plain).map(|key| (schema, key, plain.to_owned()));
    let mut found: Vec<_> = exact(MANIFEST).into_iter().collect();
    if found.is_empty() {
        let named = |key: &&Key| stands_alone(key) && key.path.rsplit('.').next() == Some(plain);
        let keys = schema::all(MANIFEST).filter(named);
        found.extend(keys.map(|key| (MANIFEST, key, key.path.to_owned())));
    }
    found.extend(exact(MODAL_FILE).into_iter().chain(exact(HOUSING_FILE)));
    if found.is_empty() {
        return Err(NoSuchKey {
            topic: topic.to_owned(),
            nearest: nearest(plain),
        });
    }
    let texts = found.iter().map(|(schema, key, path)| match key.kind {
        Kind::Table if stands_alone(key) => of_table(key, path),
        _ => of_key(schema, key, path),
    });
    Ok(texts.collect::<Vec<_>>().join("\n"))
}

/// The nearest path, by its whole or by its last part.
fn nearest(topic: &str) -> Option<String> {
    let paths: Vec<&str> = every_key()
        .filter(|key| stands_alone(key))
        .map(|key| key.path)
        .collect();
    schema::nearest_path(topic, &paths).map(str::to_owned)
}

fn of_table(key: &Key, path: &str) -> String {
    let mut text = format!("[{path}]\n\n{}\n", wrapped(key.about, 0));
    let shared = (path != key.path).then_some(path);
    let keys = listed(MANIFEST, key.path);
    if !keys.is_empty() {
        text += &format!("\n{keys}");
    }
    let below: Vec<&str> = schema::children(MANIFEST, shared.unwrap_or(key.path))
        .into_iter()
        .filter(|child| {
            let child = schema::find(MANIFEST, &format!("{path}.{child}"));
            child.is_some_and(|child| child.kind == Kind::Table)
        })
        .collect();
    if !below.is_empty() {
        text += &format!("\nTables in it: {}.\n", below.join(", "));
    }
    text += &format!("\n  default  {}\n", default(key));
    if key.path == "shafts" {
        text += &format!("\n{DRIVE}");
    }
    text
}

fn of_key(schema: Schema, key: &Key, path: &str) -> String {
    let is = |other: Schema| std::ptr::eq(schema, other);
    let place = match () {
        () if is(MODAL_FILE) => " (of a modal file)",
        () if is(HOUSING_FILE) => " (of a housing file)",
        () => "",
    };
    // A list's description covers its elements.
    let list = key.path.strip_suffix(".*");
    let about = list
        .and_then(|list| schema::find(schema, list))
        .unwrap_or(key)
        .about;
    let mut text = format!("{path}{place}\n\n{}\n\n", wrapped(about, 0));
    let last = path.rsplit('.').next().unwrap_or(path);
    let units = match key.kind {
        Kind::Quantity(dimension) | Kind::Axis(dimension) => dimension.units(),
        _ => "",
    };
    let mut range = range(schema, key);
    if !key.why.is_empty() {
        range += &format!(" ({})", key.why);
    }
    let axis = if key.can_be_axis() && is(MANIFEST) {
        format!("\"{path}\" in [grid]")
    } else {
        String::new()
    };
    let example = if list.is_some() || last.parse::<usize>().is_ok() {
        key.example.to_owned()
    } else {
        format!("{last} = {}", key.example)
    };
    let facts = [
        ("takes", takes(key)),
        ("units", units.to_owned()),
        ("range", range),
        ("default", default(key)),
        ("example", example),
        ("as an axis", axis),
    ];
    for (head, fact) in facts.iter().filter(|(_, fact)| !fact.is_empty()) {
        text += &format!("  {head:<12}{}\n", wrapped(fact, 14));
    }
    text
}

/// A text wrapped into lines, all but the first indented.
fn wrapped(text: &str, indent: usize) -> String {
    let mut out = String::new();
    let mut column = indent;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if column > indent && column + 1 + length > WIDTH {
            out += &format!("\n{:indent$}", "");
            column = indent;
        } else if column > indent {
            out.push(' ');
            column += 1;
        }
        out += word;
        column += length;
    }
    out
}
