//! One HTML file that explores a results folder: it needs no other file, no network and no program but a browser.
//!
//! The page is a skeleton (`assets/page.html`) with styles and programs of its own, the library of plots
//! [uPlot](https://github.com/leeoniya/uPlot) (MIT, `vendor/`), and the tables of the folder as arrays. Its programs
//! only show: whatever is counted, classified or summarised is so by the same code as for `atlas show`
//! and `atlas plot`. Same folder, same bytes.

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

/// The skeleton, with a place for each of the parts below.
const PAGE: &str = include_str!("assets/page.html");

/// Styles: those of the library, then the page's own.
const STYLES: [&str; 2] = [
    include_str!("vendor/uPlot-1.6.32.min.css"),
    include_str!("assets/style.css"),
];

/// Licence of the library.
const LICENCE: &str = include_str!("vendor/LICENSE-uPlot.txt");

/// Programs: the library, then the page's own, one a view, in the order in which they need each other.
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

/// What a page is to hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PageRequest {
    /// Characters that tables may take in the file; skeleton, programs and records come on top.
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
    /// What it leaves out for want of room, a line a table.
    pub left_out: Vec<String>,
}

/// Makes the page of a folder that `atlas run`, `atlas follow` or `atlas trace` wrote. Points, followed orbits and small
/// tables come first; of what is left of the room each further table gets an even share.
///
/// # Errors
/// There are no results in the folder, or they cannot be read, or are not what was written.
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
        return Err(StoreError::Missing {
            folder: folder.to_path_buf(),
            missing: table_path(folder, TableKind::Points, None),
        }
        .into());
    };
    // Axes and motions, which the map begins with.
    blocks.come_first(0);
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
        // A quarter is kept for the tables that tell more of single points.
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

/// The tables beside the points, those that are small come first: what they do not take is left to the others.
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

/// Names of the axes that the head of a page tells.
fn axes(header: &Value) -> Vec<String> {
    let axes = header["axes"].as_array().into_iter().flatten();
    axes.filter_map(|axis| Some(axis["name"].as_str()?.to_owned()))
        .collect()
}

/// The folder's own name, wherever it lies.
fn name(folder: &Path) -> PathBuf {
    let whole = folder
        .canonicalize()
        .unwrap_or_else(|_| folder.to_path_buf());
    whole.file_name().map(PathBuf::from).unwrap_or(whole)
}

/// The skeleton with its parts in their places. What the folder says comes last and is not looked at again.
fn written(header: &Value, mut blocks: Blocks) -> String {
    let title = header["job"].as_str().or(header["folder"].as_str());
    // Pages of many points are large: room for all of it at once, and no copy of a block.
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

/// A text as the content of an element.
fn in_html(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// JSON as the content of a script element, which neither ends it nor starts a comment.
fn in_script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests;
