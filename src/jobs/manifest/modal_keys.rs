//! Numbers of the modal file as keys of a job: `rated_force`, `frequency[1]`, `stiffness_matrix[1,2]`,
//! `contact.stop.gap`, `harmonic_load.shaker.force[2]`.
//!
//! Indices in brackets count from 1, as modes do. Named tables are addressed by their names. The values go into the
//! tree of the modal file, which is part of the manifest's tree if any value is changed. The same code then reads a
//! changed file and an unchanged one.

use super::schema::{self, Key, Kind, MANIFEST, MODAL_FILE};
use super::tree::{Entry, MissingElement, Node, Value};
use std::borrow::Cow;

/// Name of the entry in the manifest's tree that has the tree of the modal file.
const ROOT: &str = "modal file";

/// Lists of named tables.
const NAMED: [&str; 5] = [
    "contact",
    "harmonic_load",
    "slider",
    "dry_friction",
    "bearing",
];

/// Key of the skew-symmetric matrix.
const SKEW: &str = "gyroscopic_matrix";

/// A parsed name.
struct Place<'n> {
    key: &'static Key,
    /// The list and the name of the table in it.
    table: Option<(&'static str, &'n str)>,
    /// Keys and indices from 0 below that table, or from the top.
    below: Vec<String>,
}

/// Whether a name looks like that of a number in a modal file, even if there is no such number.
pub(super) fn is_modal_number_name(name: &str) -> bool {
    let in_table = |list| {
        name.strip_prefix(list)
            .is_some_and(|rest: &str| rest.starts_with('.'))
    };
    name.contains('[') || NAMED.into_iter().any(in_table) || place(name).is_some()
}

/// The schema's entry for a key of the manifest, or for a number of a modal file.
pub(super) fn find(name: &str) -> Option<&'static Key> {
    schema::find(MANIFEST, name).or_else(|| place(name).map(|place| place.key))
}

/// Patterns of the names of numbers of a modal file, with the schema's entries: `contact.NAME.levels[N]`.
pub(super) fn forms() -> impl Iterator<Item = (String, &'static Key)> {
    let numbers = schema::all(MODAL_FILE).filter(|key| matches!(key.kind, Kind::Quantity(_)));
    numbers.map(|key| (form(key.path, "NAME", "N"), key))
}

/// The nearest valid name to an invalid one.
pub(super) fn nearest(name: &str) -> Option<String> {
    let entry_name = name.split(['.', '[']).nth(1).unwrap_or("NAME");
    let names: Vec<String> = forms()
        .map(|(_, key)| form(key.path, entry_name, "1"))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    schema::nearest_path(name, &names).map(str::to_owned)
}

fn form(path: &str, name: &str, index: &str) -> String {
    let below_named_table = NAMED.iter().find_map(|list| {
        let rest = path.strip_prefix(list)?.strip_prefix(".*.")?;
        Some((format!("{list}.{name}."), rest))
    });
    let (table, below) = below_named_table.unwrap_or((String::new(), path));
    let indexed = below.replace(".*.*", &format!("[{index},{index}]"));
    table + &indexed.replace(".*", &format!("[{index}]"))
}

fn place(name: &str) -> Option<Place<'_>> {
    if schema::find(MANIFEST, name).is_some() {
        return None;
    }
    let quantity_key = |path: String| {
        schema::find(MODAL_FILE, &path).filter(|key| matches!(key.kind, Kind::Quantity(_)))
    };
    let in_table = |list: &'static str| {
        let rest = name.strip_prefix(list)?.strip_prefix('.')?;
        // The name of a table may contain dots.
        rest.match_indices('.').find_map(|(dot, _)| {
            let below = parts(&rest[dot + 1..])?;
            let key = quantity_key(format!("{list}.0.{}", below.join(".")))?;
            let table = Some((list, &rest[..dot]));
            Some(Place { key, table, below })
        })
    };
    NAMED.into_iter().find_map(in_table).or_else(|| {
        let below = parts(name)?;
        let key = quantity_key(below.join("."))?;
        let unnamed = below.len() == 1 || !NAMED.contains(&below[0].as_str());
        unnamed.then_some(Place {
            key,
            table: None,
            below,
        })
    })
}

/// The keys and indices in a name, with indices from 0: `force` and `1` for `force[2]`; `None` for any other text.
fn parts(text: &str) -> Option<Vec<String>> {
    let mut parts = Vec::new();
    for segment in text.split('.') {
        let (key, indices) = match segment.split_once('[') {
            None => (segment, None),
            Some((key, rest)) => (key, Some(rest.strip_suffix(']')?)),
        };
        if key.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        parts.push(key.to_owned());
        for index in indices.into_iter().flat_map(|all| all.split(',')) {
            parts.push(index.parse::<usize>().ok()?.checked_sub(1)?.to_string());
        }
    }
    Some(parts)
}

/// The tree of the modal file with changed values, if any is changed. The inner `None` is a file with faults, which
/// have been reported.
pub(super) fn tree(entries: &[Entry]) -> Option<Option<&Node>> {
    let entry = entries.iter().find(|entry| entry.key == ROOT)?;
    let whole = matches!(entry.node.value, Value::Table(_));
    Some(whole.then_some(&entry.node))
}

/// Adds the tree of a modal file to that of the manifest.
pub(super) fn attach(tree: &mut Node, file: Node) {
    if let Value::Table(entries) = &mut tree.value {
        entries.push(Entry {
            key: ROOT.to_owned(),
            key_span: file.span,
            node: file,
        });
    }
}

/// Removes the tree of the modal file from that of the manifest.
pub(super) fn detach(tree: &mut Node) -> Option<Node> {
    let Value::Table(entries) = &mut tree.value else {
        return None;
    };
    let place = entries.iter().position(|entry| entry.key == ROOT)?;
    Some(entries.remove(place).node)
}

/// The path of keys and indices to a named number in the tree of a modal file.
pub(super) fn path(file: &Node, name: &str) -> Result<Vec<String>, MissingElement> {
    let fault = |holder: &str, why: String| MissingElement {
        why,
        holder: holder.to_owned(),
        near: nearest(name),
    };
    let Some(Place { table, below, .. }) = place(name) else {
        return Err(fault(name, "is no number of a modal file".to_owned()));
    };
    let Some((list, entry_name)) = table else {
        return Ok(below);
    };
    let tables = match file.entry(list).map(|entry| &entry.node.value) {
        Some(Value::Array(tables)) => tables.as_slice(),
        _ => &[],
    };
    let names: Vec<&str> = (tables.iter())
        .map(
            |table| match table.entry("name").map(|entry| &entry.node.value) {
                Some(Value::Text(name)) => name.as_str(),
                _ => "",
            },
        )
        .collect();
    let Some(index) = names.iter().position(|listed| *listed == entry_name) else {
        let near = schema::nearest(entry_name, &names);
        return Err(MissingElement {
            near: near.map(|near| {
                let below = &name[list.len() + 1 + entry_name.len()..];
                format!("{list}.{near}{below}")
            }),
            ..fault(list, format!("has no entry named `{entry_name}`"))
        });
    };
    let mut path = vec![list.to_owned(), index.to_string()];
    path.extend(below);
    Ok(path)
}

/// Sets the value of a key of the manifest or of a number of the modal file. An axis value of a skew-symmetric matrix
/// also sets the mirrored entry. Nothing changes if the modal file has faults.
///
/// The error describes the element that does not exist, if the path names one.
pub(super) fn put(tree: &mut Node, name: &str, node: Node) -> Result<(), MissingElement> {
    if !is_modal_number_name(name) {
        let path: Vec<&str> = name.split('.').collect();
        return tree.put(&path, node);
    }
    let Some(file) = tree.entry(ROOT) else {
        return Err(MissingElement {
            why: "names no modal file".to_owned(),
            holder: "model".to_owned(),
            near: None,
        });
    };
    if !matches!(file.node.value, Value::Table(_)) {
        return Ok(());
    }
    let path = path(&file.node, name)?;
    let mut place: Vec<&str> = vec![ROOT];
    place.extend(path.iter().map(String::as_str));
    let mirrored = match (&place[1..], &node.value) {
        ([SKEW, row, column], value) if row != column => {
            let value = opposite(value);
            value.map(|value| ([ROOT, SKEW, column, row], Node { value, ..node }))
        }
        _ => None,
    };
    if let Some((place, node)) = mirrored {
        tree.put(&place, node)?;
    }
    tree.put(&place, node).map_err(|end| MissingElement {
        holder: end
            .holder
            .trim_start_matches(ROOT)
            .trim_start_matches('.')
            .to_owned(),
        ..end
    })
}

/// The opposite of a number or of a quantity; `None` for other values.
fn opposite(value: &Value) -> Option<Value> {
    match value {
        Value::Sample(value, dimension) => Some(Value::Sample(-value, *dimension)),
        Value::Float(value) => Some(Value::Float(-value)),
        Value::Integer(value) => Some(Value::Integer(-value)),
        Value::Text(text) => Some(Value::Text(match text.trim().strip_prefix('-') {
            Some(size) => size.to_owned(),
            None => format!("-{}", text.trim().trim_start_matches('+')),
        })),
        _ => None,
    }
}

/// A text `KEY=VALUE`, with the key in quotes if it is the name of a number: bare keys may not contain brackets.
pub(super) fn in_quotes(change: &str) -> Cow<'_, str> {
    match change.split_once('=') {
        Some((name, value)) if is_modal_number_name(name.trim()) && !name.contains(['"', '\'']) => {
            Cow::Owned(format!("\"{}\"={value}", name.trim()))
        }
        _ => Cow::Borrowed(change),
    }
}

/// Removes the entry `name` of the modal file, such as `contact.stop.gap`. Returns whether it existed.
pub(super) fn take_out(tree: &mut Node, name: &str) -> bool {
    let Some(file) = tree.entry(ROOT) else {
        return false;
    };
    // The faults of a file that is no table are reported already.
    if !matches!(file.node.value, Value::Table(_)) {
        return true;
    }
    let Ok(path) = path(&file.node, name) else {
        return false;
    };
    let mut place = vec![ROOT];
    place.extend(path.iter().map(String::as_str));
    tree.take_out(&place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::diagnostic::Issues;
    use crate::units::Dimension;

    const FILE: &str = r#"
        frequency = [1.0, 2.0]
        gyroscopic_matrix = [[0.0, 0.3], [-0.3, 0.0]]
        [[contact]]
        name = "end stop. 2"
        gap = "20 um"
        levels = [1.0, 2.0]
        [[contact]]
        name = "stop"
        gap = 3.0
        [[contact]]
        name = "cone"
        gap = 4.0
    "#;

    fn tree_of(text: &str) -> Node {
        let issues = Issues::default();
        let source = issues.add_source("file".to_owned(), text.to_owned());
        super::super::tree::parse(source, &issues)
    }

    fn changed(name: &str, value: f64) -> Result<Node, MissingElement> {
        changed_to(name, Value::Sample(value, Dimension::Ratio))
    }

    fn changed_to(name: &str, value: Value) -> Result<Node, MissingElement> {
        let mut tree = tree_of("");
        attach(&mut tree, tree_of(FILE));
        let node = Node {
            span: tree.span,
            value,
        };
        put(&mut tree, name, node)?;
        Ok(detach(&mut tree).unwrap())
    }

    fn number(file: &Node, path: &str) -> f64 {
        match file.at(path).map(|node| &node.value) {
            Some(Value::Sample(value, _) | Value::Float(value)) => *value,
            other => panic!("{path}: {other:?}"),
        }
    }

    #[test]
    fn names_lead_to_their_numbers() {
        for (name, path) in [
            ("rated_force", "rated_force"),
            ("frequency[2]", "frequency.1"),
            ("contact.stop.gap", "contact.1.gap"),
            ("contact.stop.damping", "contact.1.damping"),
            ("contact.end stop. 2.gap", "contact.0.gap"),
            ("contact.end stop. 2.levels[1]", "contact.0.levels.0"),
        ] {
            assert!(is_modal_number_name(name), "{name}");
            assert_eq!(number(&changed(name, 7.5).unwrap(), path), 7.5, "{name}");
        }
        let skew = changed("gyroscopic_matrix[1,2]", 0.5).unwrap();
        assert_eq!(number(&skew, "gyroscopic_matrix.0.1"), 0.5);
        assert_eq!(number(&skew, "gyroscopic_matrix.1.0"), -0.5);
        let skew = changed_to("gyroscopic_matrix[2,1]", Value::Float(0.25)).unwrap();
        assert_eq!(number(&skew, "gyroscopic_matrix.0.1"), -0.25);
        for (given, mirrored) in [("0.5 N*s/m", "-0.5 N*s/m"), ("-0.5 N*s/m", "0.5 N*s/m")] {
            let skew = changed_to("gyroscopic_matrix[1,2]", Value::Text(given.to_owned())).unwrap();
            let value = skew.at("gyroscopic_matrix.1.0").map(|node| &node.value);
            assert!(
                matches!(value, Some(Value::Text(text)) if text == mirrored),
                "{value:?}"
            );
        }
    }

    #[test]
    fn names_that_lead_nowhere_tell_what_was_meant() {
        for (name, holder, near) in [
            ("contact.stp.gap", "contact", Some("contact.stop.gap")),
            ("contact.con.gap", "contact", Some("contact.cone.gap")),
            (
                "contact.stop.gapp",
                "contact.stop.gapp",
                Some("contact.stop.gap"),
            ),
            ("frequency[3]", "frequency", None),
            ("frequency[0]", "frequency[0]", Some("frequency[1]")),
            ("constant_load[1]", "constant_load", None),
        ] {
            assert!(is_modal_number_name(name), "{name}");
            let end = changed(name, 1.0).unwrap_err();
            assert_eq!(
                (end.holder.as_str(), end.near.as_deref()),
                (holder, near),
                "{name}"
            );
        }
        for other in [
            "mesh.half_gap",
            "torque",
            "load",
            "gear.teeth.0",
            "frequency.0",
            "damping",
        ] {
            assert!(!is_modal_number_name(other), "{other}");
        }
    }

    #[test]
    fn every_number_of_the_schema_has_a_name() {
        for (form, key) in forms() {
            let name = form.replace("[N", "[1").replace(",N]", ",1]");
            assert_eq!(find(&name).map(|key| key.path), Some(key.path), "{name}");
        }
        assert!(forms().count() >= 30);
    }
}
