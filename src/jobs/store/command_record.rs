//! `follow.json`, `trace.json` and `runup.json`: the records of the tables of `atlas follow`, `atlas trace`
//! and `atlas runup`. They correspond to `run.json` for the tables of `atlas run`.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::atomic_file::write_sealed;
use super::checksum::TableRecord;
use super::file::{ClosedTable, UnfinishedTable, create_folder, remove_stale, table_path};
use super::table::Table;
use super::table_kind::TableKind;
use super::{ProgramRecord, StoreError};

/// Record of the tables that a command wrote outside a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TablesRecord {
    /// Name of the job.
    pub job: String,
    /// Hash of the job's manifest, hexadecimal.
    pub manifest_hash: String,
    /// The program that wrote the tables.
    pub program: ProgramRecord,
    /// The tables as written; a file of another size or hash is damaged.
    pub tables: Vec<TableRecord>,
}

impl TablesRecord {
    /// A record of tables that this program wrote. Their `metadata` has the job and its hash.
    pub(super) fn new(metadata: &[(&str, String)], tables: Vec<TableRecord>) -> Self {
        let text_of = |key: &str| {
            let pair = metadata.iter().find(|(name, _)| *name == key);
            pair.map_or_else(String::new, |(_, value)| value.clone())
        };
        Self {
            job: text_of("job"),
            manifest_hash: text_of("manifest_hash"),
            program: ProgramRecord::current(),
            tables,
        }
    }

    /// Writes the record completely or not at all. Its last key, `blake3`, is the hash of the text before it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn write(&self, folder: &Path, name: &str) -> Result<(), StoreError> {
        write_sealed(&folder.join(name), self)
    }
}

/// The tables that a command writes at its end, and their record.
pub(super) struct CommandTables<'a> {
    folder: &'a Path,
    record: &'static str,
    metadata: &'a [(&'a str, String)],
    tables: Vec<ClosedTable>,
    /// Table of an earlier command, of a kind that this command does not write. [`Self::finish`] removes it.
    superseded: Option<PathBuf>,
}

impl<'a> CommandTables<'a> {
    /// Prepares the folder.
    pub(super) fn start(
        folder: &'a Path,
        record: &'static str,
        metadata: &'a [(&'a str, String)],
    ) -> Result<Self, StoreError> {
        create_folder(folder)?;
        remove_stale(folder)?;
        Ok(Self {
            folder,
            record,
            metadata,
            tables: Vec::new(),
            superseded: None,
        })
    }

    pub(super) fn write<R>(
        &mut self,
        kind: TableKind,
        table: Table<R>,
        rows: impl IntoIterator<Item = R>,
    ) -> Result<(), StoreError> {
        let mut file = UnfinishedTable::create(self.folder, kind, None, table, self.metadata)?;
        rows.into_iter().try_for_each(|row| file.push(row))?;
        self.tables.push(file.close()?);
        Ok(())
    }

    /// Marks an earlier table that [`Self::finish`] removes.
    pub(super) fn supersede(&mut self, kind: TableKind) {
        self.superseded = Some(table_path(self.folder, kind, None));
    }

    /// Gives the tables their final names, and writes and returns their records. All tables are complete: after an
    /// error in [`Self::write`], for example on a full disk, do not call this, so that the earlier tables remain.
    /// It removes the earlier record first, so no record exists while old and new tables are mixed.
    pub(super) fn finish(self) -> Result<Vec<TableRecord>, StoreError> {
        remove(&self.folder.join(self.record))?;
        self.superseded.as_deref().map_or(Ok(()), remove)?;
        let tables = self.tables.into_iter().map(ClosedTable::publish);
        let tables = tables.collect::<Result<Vec<_>, _>>()?;
        TablesRecord::new(self.metadata, tables.clone()).write(self.folder, self.record)?;
        Ok(tables)
    }
}

/// Removes a file if it exists. A record is removed before its tables are replaced.
pub(super) fn remove(path: &Path) -> Result<(), StoreError> {
    match fs::remove_file(path) {
        // The folder of a shard's table may be missing, or have the name of a file.
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            Ok(())
        }
        removed => removed.map_err(|source| StoreError::io(path, "remove", source)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::poincare_table;

    /// A command that cannot write its second table changes neither the earlier tables nor their record.
    #[test]
    fn a_failed_command_leaves_the_earlier_tables() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        let [first, second] = ["first", "second"].map(|job| [("job", job.to_owned())]);
        let mut tables = CommandTables::start(folder, "record.json", &first).unwrap();
        tables
            .write(TableKind::Branches, poincare_table(), [])
            .unwrap();
        tables.finish().unwrap();
        let record = folder.join("record.json");
        let paths = [table_path(folder, TableKind::Branches, None), record];
        let contents = || paths.each_ref().map(|path| fs::read(path).unwrap());
        let before = contents();
        // A folder has the name of the second table.
        fs::create_dir(table_path(folder, TableKind::Curves, None)).unwrap();
        let mut tables = CommandTables::start(folder, "record.json", &second).unwrap();
        tables
            .write(TableKind::Branches, poincare_table(), [])
            .unwrap();
        tables
            .write(TableKind::Curves, poincare_table(), [])
            .unwrap_err();
        drop(tables);
        assert!(contents() == before);
    }
}
