//! A key in words: its values, range and default.

use crate::manifest::schema::{self, DefaultValue, Key, Kind, Schema};
use crate::units::Dimension;

/// A dimension and its SI unit in words: `length [m]`; `number` for a ratio.
fn measure(dimension: Dimension) -> String {
    let name = dimension.name();
    let noun = name.split_once(' ').map_or(name, |(_, noun)| noun);
    match dimension {
        Dimension::Ratio => "number".to_owned(),
        _ => format!("{noun} [{}]", dimension.unit()),
    }
}

/// The values of a key, with their unit.
pub(super) fn takes(key: &Key) -> String {
    let one = match key.kind {
        Kind::Quantity(dimension) => measure(dimension),
        Kind::Integer => "whole number".to_owned(),
        Kind::Boolean => "true or false".to_owned(),
        Kind::Text => "text".to_owned(),
        Kind::Choice(words) => schema::quoted(words),
        Kind::List(of) => format!("list of {of}"),
        Kind::ContactDamping => format!(
            "damping ratio, or damping coefficient [{}]",
            Dimension::Damping.unit()
        ),
        Kind::InitialState => "\"static\", \"rest\", or table".to_owned(),
        Kind::Table => "table".to_owned(),
        Kind::Points => "list of tables, or path of a file".to_owned(),
        Kind::Axis(dimension) => format!("{}, one value or an axis", measure(dimension)),
    };
    match key.pair {
        Some(names) => format!("{one}, or a pair: {names}"),
        None => one,
    }
}

/// The range of a key's numbers, or of its list's elements; empty if any number is accepted.
pub(super) fn range(schema: Schema, key: &Key) -> String {
    match key.kind {
        Kind::List(_) => {
            let elements = schema::find(schema, &format!("{}.*", key.path));
            elements.map_or(String::new(), |elements| elements.range())
        }
        Kind::ContactDamping => format!("ratio {}", key.range()),
        _ => key.range(),
    }
}

/// The value of an absent key.
pub(super) fn default(key: &Key) -> String {
    match key.default {
        DefaultValue::Required => "required".to_owned(),
        DefaultValue::Value(text) | DefaultValue::Words(text) => text.to_owned(),
    }
}

/// The first sentence of a description.
pub(super) fn first_sentence(about: &str) -> &str {
    about.split_once(". ").map_or(about, |(first, _)| first)
}

/// Whether a key has a separate entry: elements of lists belong to their list.
pub(super) fn stands_alone(key: &Key) -> bool {
    !key.path.ends_with(".*")
}

/// The table of a key, as its header names it: the innermost one that is not an entry of a list.
pub(super) fn home(key: &Key) -> &'static str {
    let of_list = key.path.split(".*.").next().unwrap_or(key.path);
    let parent = if of_list.len() < key.path.len() {
        of_list.rsplit_once('.')
    } else {
        key.path.rsplit_once('.')
    };
    let home = parent.map_or("", |(parent, _)| parent);
    // `run.initial` is a word or a table; the keys of this table are listed under `[run]`.
    home.strip_suffix(".initial").unwrap_or(home)
}

/// The path of a key, relative to its table.
pub(super) fn name(key: &Key) -> &'static str {
    match home(key) {
        "" => key.path,
        home => &key.path[home.len() + 1..],
    }
}
