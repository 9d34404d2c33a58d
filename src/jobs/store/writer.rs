//! Takes points in any order and writes the result files of a job in `point_id` order.
//!
//! Rows, row groups and values depend on the points alone, so every physics column has the same bytes for any number of
//! threads.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::checksum::TableRecord;
use super::covariant::list_length;
use super::file::{ClosedTable, Row, Shard, TableFile, create_folder, remove_stale, table_path};
use super::layout::ResultLayout;
use super::reorder::Reorder;
use super::run::run_path;
use super::table::Table;
use super::table_kind::TableKind;
use super::{
    AttractorRow, CellRow, HorizonRow, OrbitRow, OrderRow, PoincareRow, PointRow, ProbeRow,
    SpectrumRow, StoreError, TransitionRow, attractors_table, basins_table, horizon_table,
    orbits_table, orders_table, poincare_table, points_table, probes_table, spectra_table,
    transitions_table,
};

impl Row for PointRow {
    fn list_bytes(&self) -> usize {
        let exponents = self.outcome.lyapunov.as_ref().map_or(0, |found| {
            let course = found.course.as_ref();
            let course = course.map_or(0, |c| c.cycles.len() + 2 * c.exponents.len());
            found.exponents.len() + found.errors.len() + course
        });
        let covariant = self.covariant.as_ref().map_or(0, list_length);
        let nvh = self.outcome.nvh.as_ref().map_or(0, |found| {
            // With their standard errors.
            let lists = [
                &found.harmonics,
                &found.suborders,
                &found.deflection_peak_quantiles,
                &found.force_peak_quantiles,
                &found.contact_force,
                &found.contact_fraction,
                &found.contact_impact_rate,
                &found.contact_rattle_index,
                &found.contact_loss,
                &found.impact_velocity_quantiles,
                &found.bearing_mean,
                &found.bearing_rms,
                &found.torque_mean,
                &found.torque_rms,
                &found.acceleration_rms,
                &found.angular_acceleration_rms,
                &found.mesh_deflection_rms,
                &found.mesh_force_rms,
            ];
            2 * lists.iter().map(|list| list.len()).sum::<usize>()
        });
        size_of::<f64>() * (exponents + covariant + nvh) + self.outcome.reason.len()
    }
}

impl Row for PoincareRow {}

impl Row for SpectrumRow {}

impl Row for HorizonRow {}

impl Row for ProbeRow {
    fn list_bytes(&self) -> usize {
        self.probe.reason.len()
    }
}

impl Row for AttractorRow {
    fn list_bytes(&self) -> usize {
        size_of::<f64>() * (self.places[0].len() + self.places[1].len())
    }
}

impl Row for CellRow {}

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
        let own = |table: &&TableRecord| table.name.starts_with(kind.file_name());
        self.tables.iter().filter(own).map(|table| table.rows).sum()
    }
}

/// Folder and shard of the results.
struct Destination {
    folder: PathBuf,
    shard: Option<Shard>,
}

/// Streams points into result files. Dropped without [`ResultWriter::finish`], it leaves
/// no file, and results of an earlier run in the same folder stay as they are.
pub struct ResultWriter {
    destination: Destination,
    order: Reorder<PointRow>,
    points: TableFile<PointRow>,
    poincare: Option<TableFile<PoincareRow>>,
    spectra: Option<TableFile<SpectrumRow>>,
    orders: Option<TableFile<OrderRow>>,
    probes: Option<TableFile<ProbeRow>>,
    orbits: Option<TableFile<OrbitRow>>,
    transitions: Option<TransitionFile>,
    attractors: Option<TableFile<AttractorRow>>,
    basins: Option<TableFile<CellRow>>,
    horizon: Option<TableFile<HorizonRow>>,
}

/// The unfinished `transitions.parquet`, and the name of the swept axis.
struct TransitionFile {
    axis: String,
    file: TableFile<TransitionRow>,
}

impl Destination {
    /// Starts a table's file if it is requested.
    fn start<R: Row>(
        &self,
        wanted: bool,
        kind: TableKind,
        table: fn() -> Table<R>,
    ) -> Result<Option<TableFile<R>>, StoreError> {
        wanted
            .then(|| TableFile::create(&self.folder, kind, self.shard, table(), &[]))
            .transpose()
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
        let transitions = layout
            .swept
            .as_ref()
            .map(|axis| {
                let table = transitions_table(axis);
                Ok::<_, StoreError>(TransitionFile {
                    axis: axis.name.clone(),
                    file: TableFile::create(folder, TableKind::Transitions, shard, table, &[])?,
                })
            })
            .transpose()?;
        let basins = layout
            .basins
            .as_ref()
            .map(|axes| {
                let axes = axes.each_ref().map(|axis| [&axis.name, &axis.unit]);
                let metadata = [("slice", serde_json::json!(axes).to_string())];
                TableFile::create(folder, TableKind::Basins, shard, basins_table(), &metadata)
            })
            .transpose()?;
        Ok(Self {
            order: Reorder::new(expected.into_iter()),
            points: TableFile::create(folder, TableKind::Points, shard, points, &metadata)?,
            poincare: destination.start(layout.poincare, TableKind::Poincare, poincare_table)?,
            spectra: destination.start(layout.spectra, TableKind::Spectra, spectra_table)?,
            orders: destination.start(layout.orders, TableKind::Orders, orders_table)?,
            probes: destination.start(layout.probes, TableKind::Probes, probes_table)?,
            attractors: destination.start(
                layout.probes,
                TableKind::Attractors,
                attractors_table,
            )?,
            basins,
            orbits: destination.start(layout.orbits, TableKind::Orbits, orbits_table)?,
            transitions,
            horizon: destination.start(layout.horizon, TableKind::Horizon, horizon_table)?,
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
        let mut closed = Vec::new();
        if let Some(own) = self.transitions {
            closed.push(own.file.close()?);
        }
        close(self.orbits, &mut closed)?;
        close(self.basins, &mut closed)?;
        close(self.attractors, &mut closed)?;
        close(self.horizon, &mut closed)?;
        close(self.probes, &mut closed)?;
        close(self.spectra, &mut closed)?;
        close(self.orders, &mut closed)?;
        close(self.poincare, &mut closed)?;
        close(Some(self.points), &mut closed)?;
        // A full disk has caused an error by now, so either all tables get their names or none does.
        remove(old)?;
        let tables = closed.into_iter().map(ClosedTable::publish);
        Ok(Written {
            tables: tables.collect::<Result<_, _>>()?,
            missing,
        })
    }

    /// The record of an earlier run, and those of its tables that this run does not write. The record must never remain
    /// with tables that it does not describe.
    fn in_the_way(&self) -> Vec<PathBuf> {
        let Destination { folder, shard } = &self.destination;
        let mut old = vec![run_path(folder, *shard)];
        if self.poincare.is_none() {
            old.push(table_path(folder, TableKind::Poincare, *shard));
        }
        if self.spectra.is_none() {
            old.push(table_path(folder, TableKind::Spectra, *shard));
        }
        if self.orders.is_none() {
            old.push(table_path(folder, TableKind::Orders, *shard));
        }
        if self.probes.is_none() {
            old.push(table_path(folder, TableKind::Probes, *shard));
            old.push(table_path(folder, TableKind::Attractors, *shard));
        }
        if self.basins.is_none() {
            old.push(table_path(folder, TableKind::Basins, *shard));
        }
        if self.orbits.is_none() {
            old.push(table_path(folder, TableKind::Orbits, *shard));
        }
        if self.transitions.is_none() {
            old.push(table_path(folder, TableKind::Transitions, *shard));
        }
        if self.horizon.is_none() {
            old.push(table_path(folder, TableKind::Horizon, *shard));
        }
        old
    }

    fn drain(&mut self) -> Result<(), StoreError> {
        while let Some(row) = self.order.pop() {
            self.write(row)?;
        }
        Ok(())
    }

    fn write(&mut self, mut row: PointRow) -> Result<(), StoreError> {
        let point_id = row.point_id;
        let samples = std::mem::take(&mut row.outcome.poincare);
        let spectra = std::mem::take(&mut row.outcome.spectra);
        let orders = std::mem::take(&mut row.outcome.orders);
        if let Some(file) = &mut self.poincare {
            for sample in samples {
                file.push(PoincareRow { point_id, sample })?;
            }
        }
        if let Some(file) = &mut self.spectra {
            for spectrum in spectra {
                let signal: Arc<str> = spectrum.signal.into();
                let unit: Arc<str> = spectrum.unit.into();
                let (method, bandwidth) = (spectrum.method, spectrum.bandwidth);
                for line in spectrum.lines {
                    file.push(SpectrumRow {
                        point_id,
                        signal: Arc::clone(&signal),
                        unit: Arc::clone(&unit),
                        method,
                        bandwidth,
                        line,
                    })?;
                }
            }
        }
        if let Some(file) = &mut self.orders {
            for own in orders {
                let signal: Arc<str> = own.signal.into();
                let unit: Arc<str> = own.unit.into();
                for line in own.lines {
                    file.push(OrderRow {
                        point_id,
                        signal: Arc::clone(&signal),
                        unit: Arc::clone(&unit),
                        line,
                    })?;
                }
            }
        }
        if let Some(found) = &mut row.multistability {
            if let Some(file) = &mut self.probes {
                for probe in std::mem::take(&mut found.probes) {
                    file.push(ProbeRow { point_id, probe })?;
                }
            }
            if let Some(file) = &mut self.attractors {
                for (id, attractor) in (0..).zip(&found.attractors) {
                    file.push(AttractorRow::new(point_id, id, attractor.clone()))?;
                }
            }
            if let Some(file) = &mut self.basins {
                for cell in std::mem::take(&mut found.cells) {
                    file.push(CellRow { point_id, cell })?;
                }
            }
        }
        if let (Some(file), Some(found)) = (&mut self.orbits, &mut row.orbits) {
            for orbit in std::mem::take(&mut found.orbits) {
                file.push(OrbitRow::found(point_id, orbit))?;
            }
            for missed in std::mem::take(&mut found.missed) {
                file.push(OrbitRow::missed(point_id, missed))?;
            }
        }
        if let (Some(own), Some(chain)) = (&mut self.transitions, &row.chain)
            && let Some(transition) = chain.transition
        {
            own.file.push(TransitionRow {
                point_id,
                axis: own.axis.clone(),
                upwards: chain.upwards,
                transition,
            })?;
        }
        if let (Some(file), Some(found)) = (&mut self.horizon, &mut row.horizon) {
            for measure in std::mem::take(&mut found.measures) {
                file.push(HorizonRow { point_id, measure })?;
            }
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

/// Removes those files that exist.
fn remove(files: Vec<PathBuf>) -> Result<(), StoreError> {
    for path in files {
        match fs::remove_file(&path) {
            Err(error) if absent(&error) => {}
            removed => removed.map_err(|source| StoreError::io(&path, "replace", source))?,
        }
    }
    Ok(())
}

/// Completes a table if it is written.
fn close<R: Row>(
    file: Option<TableFile<R>>,
    closed: &mut Vec<ClosedTable>,
) -> Result<(), StoreError> {
    closed.extend(file.map(TableFile::close).transpose()?);
    Ok(())
}

fn absent(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
    )
}

#[cfg(test)]
mod tests;
