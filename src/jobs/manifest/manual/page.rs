//! The manual as a page: `docs/manifest.md`.

use super::DRIVE;
use super::words::{default, home, name, range, stands_alone, takes};
use crate::manifest::schema::{
    self, DefaultValue, Key, Kind, MANIFEST, MODAL_FILE, Schema, VARIABLE_TABLES,
};
use crate::units::Dimension;

const INTRODUCTION: &str = include_str!("introduction.md");

/// The page, in Markdown.
pub fn page() -> String {
    let mut text = INTRODUCTION
        .replace(
            "{tables}",
            &VARIABLE_TABLES.map(|t| format!("`{t}`")).join(", "),
        )
        .replace("{units}", &units())
        .replace("{drive}", DRIVE.trim_end());
    for table in schema::all(MANIFEST).filter(|key| key.kind == Kind::Table && stands_alone(key)) {
        let level = match table.path.contains('.') {
            true => "###",
            false => "##",
        };
        text += &format!("\n{level} `[{}]`\n\n{}\n", table.path, table.about);
        if let DefaultValue::Words(words) = table.default {
            text += &format!("\nWithout the table: {words}.\n");
        }
        text += &rows(MANIFEST, table.path);
    }
    text += "\n## A modal file\n\nThe structure from any finite-element code: with `model.kind = \"modal\"`, the file \
             that `model.file` names. A list has an entry a mode, in the order of `frequency`.\n";
    text + &rows(MODAL_FILE, "")
}

fn units() -> String {
    let mut text = String::from("| quantity | SI | units |\n|---|---|---|\n");
    for dimension in Dimension::with_text_form() {
        let name = dimension.name();
        let noun = name.split_once(' ').map_or(name, |(_, noun)| noun);
        let units: Vec<String> = (dimension.units().split(", "))
            .map(|unit| format!("`{unit}`"))
            .collect();
        let si = dimension.unit().replace('*', " ");
        text += &format!("| {noun} | {si} | {} |\n", units.join(", "));
    }
    text
}

/// The keys of one table.
fn rows(schema: Schema, table: &str) -> String {
    let keys: Vec<&Key> = schema::all(schema)
        .filter(|key| key.kind != Kind::Table && stands_alone(key) && home(key) == table)
        .collect();
    if keys.is_empty() {
        return String::new();
    }
    let mut text =
        String::from("\n| key | takes | default | range | meaning |\n|---|---|---|---|---|\n");
    for key in keys {
        let default = match key.default {
            DefaultValue::Value(value) => format!("`{value}`"),
            _ => default(key),
        };
        text += &format!(
            "| `{}` | {} | {} | {} | {} |\n",
            name(key),
            cell(&takes(key)),
            cell(&default),
            cell(&range(schema, key)),
            cell(key.about)
        );
    }
    text
}

/// A text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('*', "\\*")
}
