//! The defaults of keys as values of a file, so that one reader serves given and absent keys.

use crate::manifest::diagnostic::Issues;
use crate::manifest::schema::{self, DefaultValue, HOUSING_FILE, Key, MANIFEST, MODAL_FILE};
use crate::manifest::tree::{self, Entry, Value};
use std::collections::HashMap;
use std::sync::LazyLock;
use toml::de::DeTable;

/// All defaults, by their text in the schema.
static DEFAULTS: LazyLock<HashMap<&'static str, Entry>> = LazyLock::new(|| {
    let keys = [MANIFEST, MODAL_FILE, HOUSING_FILE]
        .into_iter()
        .flat_map(schema::all);
    keys.filter_map(|key| match key.default {
        DefaultValue::Value(text) => Some((text, parsed(text))),
        DefaultValue::Required | DefaultValue::Words(_) => None,
    })
    .collect()
});

fn parsed(text: &str) -> Entry {
    let file = format!("value = {text}");
    let Ok(table) = DeTable::parse(&file) else {
        unreachable!("the default {text} is not a value of a file")
    };
    match tree::of_table(0, table, &Issues::default()).value {
        Value::Table(mut entries) if entries.len() == 1 => entries.remove(0),
        other => unreachable!("the default {text} is {}", other.type_name()),
    }
}

/// The default of a key; `None` if the key is required, or if its default depends on other keys.
pub fn default_of(key: &Key) -> Option<&'static Entry> {
    match key.default {
        DefaultValue::Value(text) => DEFAULTS.get(text),
        DefaultValue::Required | DefaultValue::Words(_) => None,
    }
}
