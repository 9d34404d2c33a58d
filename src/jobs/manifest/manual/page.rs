//! The manual as a page: `docs/manifest.md`.

use super::DRIVE;
use super::words::{default, first_sentence, home, name, range, stands_alone, takes};
use crate::manifest::schema::{
    self, DefaultValue, HOUSING_FILE, Key, Kind, MANIFEST, MODAL_FILE, Schema, VARIABLE_TABLES,
};
use crate::units::Dimension;

const INTRODUCTION: &str = include_str!("introduction.md");

/// The keys that most manifests have, for the start of the page.
const MOST_USED: [&str; 12] = [
    "job.name",
    "model.kind",
    "gear.teeth",
    "gear.module",
    "gear.rated_torque",
    "mesh.half_gap",
    "mesh.stiffness",
    "mesh.contact_damping",
    "excitation.transmission_error",
    "grid.load",
    "grid.speed",
    "run.cycles",
];

/// The page, in Markdown.
pub fn page() -> String {
    let mut text = INTRODUCTION
        .replace(
            "{tables}",
            &VARIABLE_TABLES.map(|t| format!("`{t}`")).join(", "),
        )
        .replace("{most_used}", &most_used())
        .replace("{units}", &units())
        .replace("{drive}", DRIVE.trim_end());
    for table in schema::all(MANIFEST).filter(|key| key.kind == Kind::Table && stands_alone(key)) {
        let level = if table.path.contains('.') { "###" } else { "##" };
        text += &format!("\n{level} `[{}]`\n\n{}\n", table.path, table.about);
        if let DefaultValue::Words(words) = table.default {
            text += &format!("\nWithout the table: {words}.\n");
        }
        text += &rows(MANIFEST, table.path);
    }
    text += "\n## A modal file\n\nA structure from any finite-element code. `model.file` names the file, \
             with `model.kind = \"modal\"`. Lists have one entry per mode, in the order of `frequency`.\n";
    text += &rows(MODAL_FILE, "");
    text += "\n## A housing file\n\nA housing from any finite-element code. `train.housing.file` names the file. [Housings of \
             trains](housings.md) describes how to write it.\n";
    text + &rows(HOUSING_FILE, "")
}

/// A table of the most used keys, with links to their tables.
fn most_used() -> String {
    let row = |path: &&str| {
        let key = schema::find(MANIFEST, path).expect("a key of the manifest");
        let (takes, about) = (cell(&takes(key)), cell(first_sentence(key.about)));
        let about = about.trim_end_matches('.');
        format!("| [`{path}`](#{}) | {takes} | {about}. |\n", home(key))
    };
    MOST_USED.iter().map(row).collect()
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

/// A text escaped for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('*', "\\*")
}
