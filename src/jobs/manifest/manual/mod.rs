//! The manual from the tables of keys, for people and for editors: the text of `atlas help`, the page
//! `docs/manifest.md`, the JSON Schema `docs/manifest.schema.json`.

mod help;
mod json_schema;
mod page;
#[cfg(test)]
mod tests;
mod words;

pub use help::{NoSuchKey, explain, overview, topics};
pub use json_schema::json_schema;
pub use page::page;

/// Picture of the drive with the keys of its dimensions.
const DRIVE: &str = include_str!("drive.txt");
