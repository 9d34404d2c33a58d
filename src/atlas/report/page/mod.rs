//! One HTML file that explores a results folder: it needs no other file and no network, only a browser.
//!
//! The page consists of a skeleton (`assets/page.html`) with styles and JavaScript programs, the plot library
//! [uPlot](https://github.com/leeoniya/uPlot) (MIT, `vendor/`), and the tables of the folder as arrays. The
//! JavaScript only displays: all counts, classes and summaries come from the code of `atlas show` and
//! `atlas plot`. The same folder gives the same bytes.

mod block;
mod columns;
mod head;
mod table;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use strum::VariantArray;

use super::error::ReportError;
use super::plot::slice_axes;
use super::summary::Summary;
use crate::store::{
    ResultTable, StoreError, TableKind, present_tables, read_runs, table_path, verify,
};
use block::Blocks;
use table::{Embedded, embed, embed_points};

/// The skeleton, with a placeholder `{{name}}` for each part of the page.
const PAGE: &str = include_str!("assets/page.html");

/// Styles: first those of the library, then those of the page.
const STYLES: [&str; 2] = [
    include_str!("vendor/uPlot-1.6.32.min.css"),
    include_str!("assets/style.css"),
];

/// Licence of the library.
const LICENCE: &str = include_str!("vendor/LICENSE-uPlot.txt");

/// JavaScript programs: first the library, then those of the page, in the order of their dependencies.
const PROGRAMS: [&str; 13] = [
    include_str!("vendor/uPlot-1.6.32.iife.min.js"),
    include_str!("assets/data.js"),
    include_str!("assets/format.js"),
    include_str!("assets/dom.js"),
    include_str!("assets/chart.js"),
    include_str!("assets/grid.js"),
    include_str!("assets/map.js"),
    include_str!("assets/detail.js"),
    include_str!("assets/basins.js"),
    include_str!("assets/branches.js"),
    include_str!("assets/tables.js"),
    include_str!("assets/about.js"),
    include_str!("assets/main.js"),
];

/// Options of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PageRequest {
    /// Largest number of characters of all tables; skeleton, programs and records are additional.
    pub most_bytes: u64,
}

impl Default for PageRequest {
    /// 40 MiB.
    fn default() -> Self {
        Self {
            most_bytes: 40 << 20,
        }
    }
}

/// A page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultsPage {
    /// The file.
    pub html: String,
    /// Parts that did not fit, one line per table.
    pub left_out: Vec<String>,
}

/// The page of a folder that `atlas run`, `atlas follow` or `atlas trace` wrote. The points get at most three
/// quarters of the room. The other tables share the remaining room equally, and what a small table does not
/// use goes to later ones.
///
/// # Errors
/// There are no results in the folder, or they cannot be read, or a table has a wrong checksum.
pub fn results_page(folder: &Path, request: PageRequest) -> Result<ResultsPage, ReportError> {
    let runs = if folder.is_dir() { read_runs(folder)? } else { Vec::new() };
    for run in &runs {
        verify(folder, run)?;
    }
    let present = present_tables(folder)?;
    let holds = |kind: TableKind| present.contains(&kind);
    let mut blocks = Blocks::default();
    let mut header = if holds(TableKind::Points) || holds(TableKind::Branches) {
        let summary = Summary {
            folder: name(folder),
            ..Summary::with_points(folder)?
        };
        head::of_results(&summary, &runs, folder, &mut blocks)?
    } else if holds(TableKind::Trace) {
        head::of_trace(folder)?
    } else {
        let points = table_path(folder, TableKind::Points, None);
        return Err(StoreError::missing(folder, points).into());
    };
    // The first picture, the map, needs the axes and the kinds of motion.
    blocks.mark_for_first_picture(0);
    head::complete(&mut header, &runs, folder, holds(TableKind::Trace))?;
    if holds(TableKind::Basins) {
        let table = ResultTable::head(folder, TableKind::Basins)?;
        header["slice"] = json!(slice_axes(&table));
    }
    header["folder"] = json!(name(folder).to_string_lossy());
    let (mut tables, mut left_out) = (Vec::new(), Vec::new());
    let mut take = |embedded: Embedded| {
        tables.push(embedded.description);
        left_out.extend(embedded.left_out);
    };
    if holds(TableKind::Points) {
        // A quarter of the room is kept for the tables with details of single points.
        let most = request.most_bytes - request.most_bytes / 4;
        take(embed_points(folder, &axes(&header), most, &mut blocks)?);
    }
    let others = in_order(&present);
    for (place, kind) in others.iter().enumerate() {
        let room = request.most_bytes.saturating_sub(blocks.bytes());
        let share = room / (others.len() - place) as u64;
        take(embed(folder, *kind, share, &mut blocks)?);
    }
    header["tables"] = json!(tables);
    header["left_out"] = json!(left_out);
    Ok(ResultsPage {
        html: written(&header, blocks),
        left_out,
    })
}

/// The tables besides the points. Small tables come first, so that the others can use the rest of the room.
fn in_order(present: &[TableKind]) -> Vec<TableKind> {
    const LARGE: [TableKind; 7] = [
        TableKind::Orders,
        TableKind::Basins,
        TableKind::Probes,
        TableKind::Spectra,
        TableKind::Events,
        TableKind::Trace,
        TableKind::Poincare,
    ];
    let small = (TableKind::VARIANTS.iter().copied())
        .filter(|kind| !LARGE.contains(kind) && *kind != TableKind::Points);
    let all = small.chain(LARGE);
    all.filter(|kind| present.contains(kind)).collect()
}

/// Names of the axes in the head of a page.
fn axes(header: &Value) -> Vec<String> {
    let axes = header["axes"].as_array().into_iter().flatten();
    axes.filter_map(|axis| Some(axis["name"].as_str()?.to_owned()))
        .collect()
}

/// The name of the folder without its path.
fn name(folder: &Path) -> PathBuf {
    let whole = folder
        .canonicalize()
        .unwrap_or_else(|_| folder.to_path_buf());
    whole.file_name().map(PathBuf::from).unwrap_or(whole)
}

/// The skeleton with its parts inserted. Only the skeleton is searched for placeholders, because text from the
/// folder may look like one.
fn written(header: &Value, mut blocks: Blocks) -> String {
    let title = header["job"].as_str().or(header["folder"].as_str());
    // Pages with many points are large: allocate the whole size at once, and copy no block.
    let mut html = String::with_capacity(blocks.bytes() as usize + PAGE.len());
    let mut rest = PAGE;
    while let Some((before, (place, after))) = (rest.split_once("{{"))
        .and_then(|(before, behind)| Some((before, behind.split_once("}}")?)))
    {
        html += before;
        match place {
            "licence" => html += LICENCE,
            "styles" => html += &STYLES.join("\n"),
            "title" => html += &in_html(title.unwrap_or_default()),
            "head" => html += &in_script(header),
            "first" => blocks.write(true, &mut html),
            "programs" => html += &PROGRAMS.join("\n"),
            "blocks" => blocks.write(false, &mut html),
            _ => {}
        }
        rest = after;
    }
    html + rest
}

/// A text, escaped for use as the content of an HTML element.
fn in_html(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// JSON as the content of a script element. It must neither end the element nor start a comment.
fn in_script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests;
