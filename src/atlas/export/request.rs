//! An export: the request, the selection of tables and columns, and the written files.

use super::error::ExportError;
use super::format::{Format, Lists};
use super::survey::{Surveyed, survey};
use super::{arrow, csv};
use crate::store::{ResultTable, TableKind, create_folder, present_tables, remove_stale};
use std::path::{Path, PathBuf};

/// An export from a folder of results.
#[derive(Debug, Clone)]
pub struct ExportRequest {
    /// Names of tables; empty for all.
    pub tables: Vec<String>,
    /// Names of columns; empty for all. Tables without any of them are left out.
    pub columns: Vec<String>,
    /// The format.
    pub format: Format,
    /// Placement of lists.
    pub lists: Lists,
    /// Whether existing files are replaced.
    pub overwrite: bool,
}

/// The written files and their tables.
#[derive(Debug)]
pub struct Exported {
    /// The files, in the order of their tables.
    pub files: Vec<PathBuf>,
    /// The tables in the files.
    pub tables: Vec<Surveyed>,
}

/// Writes the requested tables of `folder` as files in the folder `out`, which is created if necessary.
///
/// # Errors
/// A table or column does not exist, a file would be replaced, a format does not fit a table, or a file cannot be read
/// or written.
pub fn export(folder: &Path, request: &ExportRequest, out: &Path) -> Result<Exported, ExportError> {
    if request.lists == Lists::Long && request.format == Format::Arrow {
        return Err(ExportError::ListsAreKept { format: "arrow" });
    }
    let tables = survey_folder(folder, request)?;
    let files = files(&tables, request, out);
    let exists = |file: &&File<'_>| file.path.symlink_metadata().is_ok();
    if let Some(file) = files.iter().find(exists).filter(|_| !request.overwrite) {
        let path = file.path.clone();
        return Err(ExportError::Exists { path });
    }
    create_folder(out)?;
    remove_stale(out)?;
    for File { table, path, lists } in &files {
        match request.format {
            Format::Arrow => arrow::write(folder, table, path)?,
            Format::Csv if *lists => csv::lists(folder, table, path)?,
            Format::Csv => csv::table(folder, table, request.lists, path)?,
        }
    }
    let files = files.into_iter().map(|file| file.path).collect();
    Ok(Exported { files, tables })
}

/// The requested tables of a folder, with the counts from one pass through them.
///
/// # Errors
/// A table or column does not exist, or a table cannot be read.
pub fn survey_folder(folder: &Path, request: &ExportRequest) -> Result<Vec<Surveyed>, ExportError> {
    let surveyed = |kind| Ok(survey(folder, kind, &request.columns)?);
    chosen(folder, request)?.into_iter().map(surveyed).collect()
}

/// The requested tables that have at least one of the requested columns.
fn chosen(folder: &Path, request: &ExportRequest) -> Result<Vec<TableKind>, ExportError> {
    let present = present_tables(folder)?;
    if present.is_empty() {
        return Err(ExportError::NoTables {
            folder: folder.to_path_buf(),
        });
    }
    let listed = |kinds: &[TableKind]| {
        kinds
            .iter()
            .map(|kind| kind.name())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let unknown = |name: &&String| !present.iter().any(|kind| kind.name() == name.as_str());
    if let Some(name) = request.tables.iter().find(unknown) {
        return Err(ExportError::NoTable {
            folder: folder.to_path_buf(),
            name: name.clone(),
            present: listed(&present),
        });
    }
    let is_requested = |kind: &TableKind| {
        request.tables.is_empty() || request.tables.iter().any(|name| name == kind.name())
    };
    let kinds: Vec<TableKind> = present.into_iter().filter(is_requested).collect();
    if request.columns.is_empty() {
        return Ok(kinds);
    }
    let mut known: Vec<(TableKind, Vec<String>)> = Vec::new();
    for &kind in &kinds {
        let heads = ResultTable::head(folder, kind)?.columns()?;
        known.push((kind, heads.into_iter().map(|head| head.name).collect()));
    }
    let everywhere = || known.iter().flat_map(|(_, names)| names);
    if let Some(name) = request
        .columns
        .iter()
        .find(|name| !everywhere().any(|n| n == *name))
    {
        let near = |known: &&String| strsim::jaro_winkler(known, name);
        let nearest = everywhere().max_by(|a, b| near(a).total_cmp(&near(b)));
        return Err(ExportError::NoColumn {
            name: name.clone(),
            tables: listed(&kinds),
            nearest: nearest.filter(|known| near(known) > 0.8).cloned(),
        });
    }
    let has = |names: &[String]| request.columns.iter().any(|name| names.contains(name));
    Ok(known
        .into_iter()
        .filter(|(_, names)| has(names))
        .map(|(kind, _)| kind)
        .collect())
}

/// A file to be written: a table, or only its lists.
struct File<'t> {
    table: &'t Surveyed,
    path: PathBuf,
    lists: bool,
}

/// The files to be written: one per table. With [`Lists::Long`], the lists of a table get a separate file. A table
/// that has only lists then gets only this file.
fn files<'t>(tables: &'t [Surveyed], request: &ExportRequest, out: &Path) -> Vec<File<'t>> {
    let extension = request.format.extension();
    let mut files = Vec::new();
    for table in tables {
        let long = table.has_long_lists(request.lists);
        let mut add = |suffix: &str, lists: bool| {
            let path = out.join(format!("{}{suffix}.{extension}", table.name()));
            files.push(File { table, path, lists });
        };
        if !long || table.columns.iter().any(|column| !column.is_list()) {
            add("", false);
        }
        if long {
            add("_lists", true);
        }
    }
    files
}
