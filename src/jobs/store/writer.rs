//! Takes points in any order and writes the result files of a job in `point_id` order.
//!
//! Rows, row groups and values depend on the points alone, so every physics column has the same bytes for any number of
//! threads.

use std::path::{Path, PathBuf};

use super::attractors::{attractor_rows, attractors_table};
use super::basins::{basins_table, cell_rows};
use super::chains::{transition_rows, transitions_table};
use super::checksum::TableRecord;
use super::columns::{poincare_rows, poincare_table, points_table, spectra_table, spectrum_rows};
use super::command_record::remove;
use super::file::{ClosedTable, Shard, UnfinishedTable, create_folder, remove_stale, table_path};
use super::horizon::{horizon_rows, horizon_table};
use super::layout::ResultLayout;
use super::orbits::{orbit_rows, orbits_table};
use super::orders::{order_rows, orders_table};
use super::probes::{probe_rows, probes_table};
use super::reorder::Reorder;
use super::run::run_path;
use super::table::Table;
use super::table_kind::TableKind;
use super::{PointRow, StoreError};

/// The output of a finished [`ResultWriter`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// The tables.
    pub tables: Vec<TableRecord>,
    /// Number of expected points that never came (an interrupted run).
    pub missing: u64,
}

impl Written {
    /// Number of rows of a table; 0 if it was not written.
    pub fn rows(&self, kind: TableKind) -> u64 {
        let of_kind = |table: &&TableRecord| table.name.starts_with(kind.file_name());
        self.tables
            .iter()
            .filter(of_kind)
            .map(|table| table.rows)
            .sum()
    }
}

/// Folder and shard of the results.
struct Destination {
    folder: PathBuf,
    shard: Option<Shard>,
}

/// Streams points into result files. If it is dropped without [`ResultWriter::finish`], no new file remains,
/// and results of an earlier run in the same folder stay unchanged.
pub struct ResultWriter {
    destination: Destination,
    order: Reorder<PointRow>,
    points: UnfinishedTable<PointRow>,
    /// The other tables, in the order in which they get their names.
    others: PointTables,
}

/// Tables whose rows come from the results of points, with their kinds.
type PointTables = Vec<(TableKind, Box<dyn PointTable>)>;

/// A table whose rows come from the results of points.
trait PointTable: Send {
    /// Moves the rows of a point into the file.
    fn take(&mut self, point: &mut PointRow) -> Result<(), StoreError>;

    /// Completes the file, still under its temporary name.
    fn close(self: Box<Self>) -> Result<ClosedTable, StoreError>;
}

/// A file, and the function that returns the rows of a point.
struct RowsOfPoint<R, F> {
    file: UnfinishedTable<R>,
    rows: F,
}

impl<R, F> PointTable for RowsOfPoint<R, F>
where
    R: Send,
    F: Fn(&mut PointRow) -> Vec<R> + Send,
{
    fn take(&mut self, point: &mut PointRow) -> Result<(), StoreError> {
        let mut rows = (self.rows)(point).into_iter();
        rows.try_for_each(|row| self.file.push(row))
    }

    fn close(self: Box<Self>) -> Result<ClosedTable, StoreError> {
        self.file.close()
    }
}

impl Destination {
    /// The tables of a layout besides `points.parquet`, in the order of [`TableKind::OF_A_JOB`].
    fn tables(&self, layout: &ResultLayout) -> Result<PointTables, StoreError> {
        let mut tables = Vec::new();
        for kind in TableKind::OF_A_JOB {
            tables.extend(self.table(kind, layout)?.map(|table| (kind, table)));
        }
        Ok(tables)
    }

    fn table(
        &self,
        kind: TableKind,
        layout: &ResultLayout,
    ) -> Result<Option<Box<dyn PointTable>>, StoreError> {
        match kind {
            TableKind::Transitions => {
                let Some(axis) = layout.swept.clone() else {
                    return Ok(None);
                };
                let table = transitions_table(&axis);
                self.open(kind, table, &[], move |point| transition_rows(point, &axis))
            }
            TableKind::Basins => {
                let Some(axes) = &layout.basin_axes else {
                    return Ok(None);
                };
                let axes = axes.each_ref().map(|axis| [&axis.name, &axis.unit]);
                let metadata = [("slice", serde_json::json!(axes).to_string())];
                self.open(kind, basins_table(), &metadata, cell_rows)
            }
            _ if !layout.requested.contains(&kind) => Ok(None),
            TableKind::Orbits => self.open(kind, orbits_table(), &[], orbit_rows),
            TableKind::Attractors => self.open(kind, attractors_table(), &[], attractor_rows),
            TableKind::Horizon => self.open(kind, horizon_table(), &[], horizon_rows),
            TableKind::Probes => self.open(kind, probes_table(), &[], probe_rows),
            TableKind::Spectra => self.open(kind, spectra_table(), &[], spectrum_rows),
            TableKind::Orders => self.open(kind, orders_table(), &[], order_rows),
            TableKind::Poincare => self.open(kind, poincare_table(), &[], poincare_rows),
            _ => Ok(None),
        }
    }

    /// Starts a table's file.
    fn open<R, F>(
        &self,
        kind: TableKind,
        table: Table<R>,
        metadata: &[(&str, String)],
        rows: F,
    ) -> Result<Option<Box<dyn PointTable>>, StoreError>
    where
        R: Send + 'static,
        F: Fn(&mut PointRow) -> Vec<R> + Send + 'static,
    {
        let file = UnfinishedTable::create(&self.folder, kind, self.shard, table, metadata)?;
        Ok(Some(Box::new(RowsOfPoint { file, rows })))
    }
}

impl ResultWriter {
    /// Creates `folder` if necessary and starts the files. `expected` gives the `point_id`s of this run (of this
    /// shard), strictly ascending.
    ///
    /// # Errors
    /// The folder cannot be created or written, holds results of the other layout (sharded or not), or an axis has the
    /// name of a result column.
    pub fn create<I>(folder: &Path, layout: &ResultLayout, expected: I) -> Result<Self, StoreError>
    where
        I: IntoIterator<Item = u64>,
        I::IntoIter: Send + 'static,
    {
        create_folder(folder)?;
        remove_stale(folder)?;
        let axes: Vec<&str> = layout.axes.iter().map(|axis| axis.name.as_str()).collect();
        let mut metadata = vec![("axes", serde_json::json!(axes).to_string())];
        if !layout.tied.is_empty() {
            metadata.push(("tied", serde_json::json!(layout.tied).to_string()));
        }
        if let Some(refined) = &layout.refined {
            metadata.push(("refined", serde_json::json!(refined).to_string()));
        }
        if let Some(samples) = &layout.samples {
            metadata.push(("samples", serde_json::json!(samples).to_string()));
        }
        if let Some(swept) = &layout.swept {
            metadata.push(("carried_along", swept.name.clone()));
        }
        let shard = layout.shard;
        let points = points_table(layout)?;
        let destination = Destination {
            folder: folder.to_path_buf(),
            shard,
        };
        Ok(Self {
            order: Reorder::new(expected.into_iter()),
            points: UnfinishedTable::create(folder, TableKind::Points, shard, points, &metadata)?,
            others: destination.tables(layout)?,
            destination,
        })
    }

    /// Sets the expected points, strictly ascending, if they were not known before.
    pub fn expect<I>(&mut self, expected: I)
    where
        I: IntoIterator<Item = u64>,
        I::IntoIter: Send + 'static,
    {
        self.order.expect(expected.into_iter());
    }

    /// Adds a point; it is written once every point before it has come. The state for the next point of its chain is
    /// dropped.
    ///
    /// # Errors
    /// The point was not expected, or a file cannot be written.
    pub fn push(&mut self, mut row: PointRow) -> Result<(), StoreError> {
        if let Some(chain) = &mut row.chain {
            chain.end = None;
        }
        self.order.insert(row.point_id, row)?;
        self.drain()
    }

    /// Number of points in memory that wait for an earlier one. A scheduler that starts points in order keeps this near
    /// its number of workers.
    pub fn waiting(&self) -> usize {
        self.order.waiting()
    }

    /// Writes the waiting points, skips points that never came, and gives the files their final names, `points.parquet`
    /// last.
    ///
    /// # Errors
    /// A point does not belong to this run, or a file cannot be written.
    pub fn finish(mut self) -> Result<Written, StoreError> {
        let mut missing = 0;
        self.drain()?;
        while self.order.skip() {
            missing += 1;
            self.drain()?;
        }
        if let Some(point_id) = self.order.leftover() {
            return Err(StoreError::UnexpectedPoint { point_id });
        }
        let old = self.in_the_way();
        let others = self.others.into_iter().map(|(_, table)| table.close());
        let mut closed = others.collect::<Result<Vec<_>, _>>()?;
        closed.push(self.points.close()?);
        // On a full disk, `close` has failed before. So either all tables get their names or none does.
        old.iter().try_for_each(|path| remove(path))?;
        let tables = closed.into_iter().map(ClosedTable::publish);
        Ok(Written {
            tables: tables.collect::<Result<_, _>>()?,
            missing,
        })
    }

    /// Files to remove before the new ones get their names: the record of an earlier run, which would not describe the
    /// new tables, and the earlier tables that this run does not write.
    fn in_the_way(&self) -> Vec<PathBuf> {
        let Destination { folder, shard } = &self.destination;
        let written = |kind: &TableKind| {
            self.others
                .iter()
                .any(|(written_kind, _)| written_kind == kind)
        };
        let others = TableKind::OF_A_JOB.into_iter();
        let others = others.filter(|kind| *kind != TableKind::Points && !written(kind));
        let others = others.map(|kind| table_path(folder, kind, *shard));
        std::iter::once(run_path(folder, *shard))
            .chain(others)
            .collect()
    }

    fn drain(&mut self) -> Result<(), StoreError> {
        while let Some(row) = self.order.pop() {
            self.write(row)?;
        }
        Ok(())
    }

    fn write(&mut self, mut row: PointRow) -> Result<(), StoreError> {
        for (_, table) in &mut self.others {
            table.take(&mut row)?;
        }
        self.note_non_finite_values(&mut row);
        self.points.push(row)
    }

    /// A number that is not finite is stored as a null. The reason then names its column, so that it differs from an
    /// analysis that was not requested.
    fn note_non_finite_values(&self, row: &mut PointRow) {
        let columns = self.points.table().columns();
        let names: Vec<&str> = columns
            .iter()
            .filter(|column| column.is_not_finite(row))
            .map(|column| column.name.as_str())
            .collect();
        if !names.is_empty() {
            let note = format!(" (not a finite number: {})", names.join(", "));
            row.outcome.reason.push_str(&note);
        }
    }
}

#[cfg(test)]
mod tests;
