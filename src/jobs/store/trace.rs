//! The tables of a traced trajectory: `trace.parquet` has one row per instant, and `events.parquet` one row per change
//! of contact state.

use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;
use arrow_schema::{ArrowError, SchemaRef};

use super::StoreError;
use super::command_record::{TablesRecord, remove};
use super::file::{ClosedTable, UnfinishedTable, create_folder, remove_stale};
use super::table::{Table, columns};
use super::table_kind::{TRACE_RECORD, TableKind};
use crate::analysis::{TraceSample, TraceSink};
use crate::model::{COAST_FLANK, DRIVE_FLANK};
use crate::propagate::Event;

/// A row of `events.parquet`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventRow {
    event: Event,
    /// Mesh period \[s\].
    period: f64,
}

impl EventRow {
    fn phase(&self) -> f64 {
        self.event.time / self.period
    }
}

/// Name of the closing or opening of a contact.
pub(super) fn event_kind(contact: usize, closes: bool) -> &'static str {
    match (contact, closes) {
        (DRIVE_FLANK, true) => "drive_entry",
        (DRIVE_FLANK, false) => "drive_release",
        (COAST_FLANK, true) => "coast_entry",
        (COAST_FLANK, false) => "coast_release",
        (_, true) => "entry",
        (_, false) => "release",
    }
}

const TIME: &str = "Time since the start of the simulation";
const CYCLE: &str = "Mesh cycle, counted from the start of the simulation";
const PHASE: &str = "Mesh phase: elapsed fraction of the mesh cycle";

/// Columns of `trace.parquet`. `outputs` has signal and unit of further columns. Modal columns exist only if `modal`.
pub fn trace_table(modal: bool, outputs: &[[String; 2]]) -> Table<TraceSample> {
    let mut columns = columns![row: TraceSample;
        f64 "time", "s", row.time, TIME;
        u64 "cycle", "mesh cycles", row.cycle, CYCLE;
        f64 "phase", "1", row.phase, PHASE;
        f64 "deflection", "m", row.deflection, "Mesh deflection";
        f64 "velocity", "m/s", row.velocity, "Rate of the mesh deflection";
        f64 "force", "N", row.force, "Mesh force";
        text "contact", "", row.contact.name(), "Flanks in contact: drive, coast, both or free";
        u64 "closed", "", row.contact.words()[0],
            "The closed ones of the first 64 contacts as a sum: 1 for the drive flank, 2 for the coast flank, 4, 8, ... for further contacts";
        u64 "closed_from_65", "", row.contact.words()[1],
            "The closed contacts from the 65th on as a sum: 1, 2, 4, ...";
    ];
    let names = column_names(outputs);
    for (index, (name, [signal, unit])) in names.iter().zip(outputs).enumerate() {
        columns.extend(columns![row: TraceSample;
            f64 name, unit, row.outputs.get(index).copied(),
                &format!("The signal {signal}, named as in orders.parquet and spectra.parquet");
        ]);
    }
    if modal {
        columns.extend(columns![row: TraceSample;
            list "displacement", "m sqrt(kg)", &*row.modal.as_ref()?.displacement,
                "Modal displacements, one per mode, as run.initial takes them at mesh phase 0";
            list "modal_velocity", "m sqrt(kg)/s", &*row.modal.as_ref()?.velocity,
                "Modal velocities, one per mode, as run.initial takes them at mesh phase 0";
        ]);
    }
    Table::new(columns)
}

/// Column names of outputs, such as `bearing_pinion_1_x`. If several outputs have one name, all but the first
/// get a number.
pub(super) fn column_names(outputs: &[[String; 2]]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for [signal, _] in outputs {
        let base = signal.replace(' ', "_");
        let numbered = (2..).map(|number| format!("{base}_{number}"));
        let mut candidates = std::iter::once(base.clone()).chain(numbered);
        let free = candidates.find(|name| !names.contains(name));
        names.extend(free);
    }
    names
}

/// Columns of `events.parquet`.
pub fn events_table() -> Table<EventRow> {
    Table::new(columns![row: EventRow;
        f64 "time", "s", (row.event.cycle as f64 + row.phase()) * row.period, TIME;
        u64 "cycle", "mesh cycles", row.event.cycle, CYCLE;
        f64 "phase", "1", row.phase(), PHASE;
        text "kind", "", event_kind(row.event.contact, row.event.closes()),
            "drive_entry, drive_release, coast_entry or coast_release; entry or release of a further contact";
        f64 "rate", "m/s", row.event.rate, "Rate of the deflection at the event, along the line of the contact";
        u64 "contact", "", row.event.contact as u64 + 1,
            "The contact: 1 for the drive flank, 2 for the coast flank, then further contacts in the order of the modal file";
    ])
}

/// Number of rows that are converted to columns together.
const PIECE_ROWS: usize = 1024;

/// A trace in memory, with the columns of its files.
pub struct TraceTables {
    period: f64,
    trace: Buffered<TraceSample>,
    events: Buffered<EventRow>,
}

/// A table that grows in memory.
struct Buffered<R> {
    table: Table<R>,
    rows: Vec<R>,
    batches: Vec<RecordBatch>,
}

impl<R> Buffered<R> {
    fn new(table: Table<R>) -> Self {
        Self {
            table,
            rows: Vec::new(),
            batches: Vec::new(),
        }
    }

    fn push(&mut self, row: R) -> Result<(), ArrowError> {
        self.rows.push(row);
        if self.rows.len() == PIECE_ROWS {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), ArrowError> {
        self.batches.push(self.table.batch(&self.rows)?);
        self.rows.clear();
        Ok(())
    }

    fn finish(mut self) -> Result<(SchemaRef, Vec<RecordBatch>), ArrowError> {
        if !self.rows.is_empty() {
            self.flush()?;
        }
        Ok((self.table.schema(), self.batches))
    }
}

impl TraceTables {
    /// Empty tables of a model with this mesh period \[s\]; `modal` and `outputs` as for [`trace_table`].
    pub fn new(period: f64, modal: bool, outputs: &[[String; 2]]) -> Self {
        Self {
            period,
            trace: Buffered::new(trace_table(modal, outputs)),
            events: Buffered::new(events_table()),
        }
    }

    /// The samples and the events, each with its schema.
    ///
    /// # Errors
    /// The last rows cannot be converted to columns.
    pub fn finish(self) -> Result<[(SchemaRef, Vec<RecordBatch>); 2], ArrowError> {
        Ok([self.trace.finish()?, self.events.finish()?])
    }
}

impl TraceSink for TraceTables {
    type Error = ArrowError;

    fn sample(&mut self, sample: TraceSample) -> Result<(), ArrowError> {
        self.trace.push(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), ArrowError> {
        self.events.push(EventRow {
            event: *event,
            period: self.period,
        })
    }
}

/// The drive and the point of a trace, for the metadata of both files.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceLabel {
    /// Name of the job.
    pub job: String,
    /// Hash of the job's manifest.
    pub manifest_hash: String,
    /// Name, SI value and SI unit of every axis of the grid.
    pub point: Vec<(String, f64, String)>,
    /// Mesh period \[s\].
    pub period: f64,
    /// Backlash half gap \[m\]; `None` for an oscillator.
    pub half_gap: Option<f64>,
    /// Signal and unit of every output in the samples.
    pub outputs: Vec<[String; 2]>,
}

/// Streams a trace into its files. If it is dropped without [`TraceWriter::finish`], no new file remains.
pub struct TraceWriter {
    folder: PathBuf,
    metadata: Vec<(&'static str, String)>,
    period: f64,
    trace: UnfinishedTable<TraceSample>,
    events: UnfinishedTable<EventRow>,
}

impl TraceWriter {
    /// Creates `folder` if necessary and starts both files.
    ///
    /// # Errors
    /// The folder cannot be created or written.
    pub fn create(folder: &Path, label: &TraceLabel, modal: bool) -> Result<Self, StoreError> {
        create_folder(folder)?;
        remove_stale(folder)?;
        let mut point = serde_json::Map::new();
        let mut units = serde_json::Map::new();
        for (name, value, unit) in &label.point {
            point.insert(name.clone(), serde_json::json!(value));
            units.insert(name.clone(), serde_json::json!(unit));
        }
        let mut metadata = vec![
            ("job", label.job.clone()),
            ("manifest_hash", label.manifest_hash.clone()),
            ("point", serde_json::Value::Object(point).to_string()),
            ("point_units", serde_json::Value::Object(units).to_string()),
            (
                "mesh_period",
                serde_json::json!({ "value": label.period, "unit": "s" }).to_string(),
            ),
        ];
        if let Some(half_gap) = label.half_gap {
            let half_gap = serde_json::json!({ "value": half_gap, "unit": "m" });
            metadata.push(("half_gap", half_gap.to_string()));
        }
        let (samples, events) = (trace_table(modal, &label.outputs), events_table());
        Ok(Self {
            folder: folder.to_path_buf(),
            period: label.period,
            trace: UnfinishedTable::create(folder, TableKind::Trace, None, samples, &metadata)?,
            events: UnfinishedTable::create(folder, TableKind::Events, None, events, &metadata)?,
            metadata,
        })
    }

    /// Gives the files their final names, `trace.parquet` after `events.parquet`, and writes `trace.json`.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(self) -> Result<(), StoreError> {
        let closed = [self.events.close()?, self.trace.close()?];
        // On a full disk, `close` has failed before. No record exists while old and new tables are mixed.
        remove(&self.folder.join(TRACE_RECORD))?;
        let tables = (closed.into_iter().map(ClosedTable::publish)).collect::<Result<_, _>>()?;
        TablesRecord::new(&self.metadata, tables).write(&self.folder, TRACE_RECORD)
    }
}

impl TraceSink for TraceWriter {
    type Error = StoreError;

    fn sample(&mut self, sample: TraceSample) -> Result<(), StoreError> {
        self.trace.push(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), StoreError> {
        self.events.push(EventRow {
            event: *event,
            period: self.period,
        })
    }
}
