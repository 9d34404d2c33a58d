//! The results of `atlas machine`: a folder with one Parquet file per measurement, and `machine.json` with all of them.

mod description;
mod findings;
mod keys;
mod measurement;

pub use description::{Description, HugePages, NodeRecord};
pub use findings::{Noise, RoofRow};
pub use keys::{ArithmeticKey, BandwidthKey, LatencyKey, MountainKey, SolverKey};
pub use measurement::{Figure, Measurement};

use super::StoreError;
use super::atomic_file::write_atomically;
use super::file::{UnfinishedTable, create_folder, remove_stale};
use super::run::ProgramRecord;
use super::table::Table;
use measurement::Key;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Version of `machine.json`.
const FORMAT: &str = "atlas-machine-4";

/// The file with all measurements.
pub(super) use crate::store::error::MACHINE as RECORD;

/// The fields that every version of the record has.
#[derive(Deserialize)]
struct Format {
    format: String,
}

/// All results about a machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Characteristics {
    /// Version of this layout.
    pub format: String,
    /// Name of the machine.
    pub host: String,
    /// Start of the measurements, RFC 3339, UTC.
    pub started: String,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Extent of the measurements: quick, default or full.
    pub extent: String,
    /// The program that measured.
    pub program: ProgramRecord,
    /// The machine as its system describes it.
    pub description: Description,
    /// Disturbances of the measurements.
    pub noise: Noise,
    /// Reading buffers of many sizes with many strides, one thread.
    pub mountain: Vec<Measurement<MountainKey>>,
    /// Reading, copying and combining large arrays on many threads.
    pub bandwidth: Vec<Measurement<BandwidthKey>>,
    /// Time of a load that depends on the one before.
    pub latency: Vec<Measurement<LatencyKey>>,
    /// Multiply-adds of numbers in registers.
    pub arithmetic: Vec<Measurement<ArithmeticKey>>,
    /// Integrating the default drive on many threads.
    pub solver: Vec<Measurement<SolverKey>>,
    /// Kernels in the roofline model: their rates, limited by arithmetic and bandwidth.
    pub roofline: Vec<RoofRow>,
    /// Measurements that were not possible, with the reason, one sentence each.
    pub missing: Vec<String>,
}

impl Characteristics {
    /// The version that this program writes.
    pub fn format() -> String {
        FORMAT.to_owned()
    }

    /// Writes the Parquet files and, last, `machine.json` into a folder, which is created if necessary.
    ///
    /// # Errors
    /// The folder cannot be created or written.
    pub fn write(&self, folder: &Path) -> Result<(), StoreError> {
        create_folder(folder)?;
        remove_stale(folder)?;
        let metadata = [
            ("host", self.host.clone()),
            ("cpu", self.description.cpu.clone()),
            ("started", self.started.clone()),
        ];
        let file = TableFolder { folder, metadata };
        file.measurements(&self.mountain)?;
        file.measurements(&self.bandwidth)?;
        file.measurements(&self.latency)?;
        file.measurements(&self.arithmetic)?;
        file.measurements(&self.solver)?;
        file.rows("roofline", RoofRow::table(), &self.roofline)?;
        let path = folder.join(RECORD);
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| StoreError::io(&path, "write", error.into()))?;
        text.push('\n');
        write_atomically(&path, text.as_bytes())
    }

    /// Reads the results that [`Self::write`] wrote.
    ///
    /// # Errors
    /// The folder has no record, or it cannot be read, or it was not written by this program.
    pub fn read(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(RECORD);
        let text = fs::read_to_string(&path).map_err(|source| match source.kind() {
            ErrorKind::NotFound => StoreError::missing(folder, path.clone()),
            _ => StoreError::io(&path, "read", source),
        })?;
        let foreign = |detail: String| StoreError::foreign(&path, detail);
        // Check the format first: other versions have other fields.
        let Format { format } =
            serde_json::from_str(&text).map_err(|error| foreign(error.to_string()))?;
        if format == FORMAT {
            serde_json::from_str(&text).map_err(|error| foreign(error.to_string()))
        } else {
            Err(foreign(format!("format `{format}`, not `{FORMAT}`")))
        }
    }

    /// All measured figures, each with its key in words.
    pub fn figures(&self) -> impl Iterator<Item = (String, Figure)> {
        fn of<K: Key>(rows: &[Measurement<K>]) -> impl Iterator<Item = (String, Figure)> {
            rows.iter().map(|row| (row.words(), row.figure))
        }
        of(&self.mountain)
            .chain(of(&self.bandwidth))
            .chain(of(&self.latency))
            .chain(of(&self.arithmetic))
            .chain(of(&self.solver))
    }
}

/// The folder of the Parquet files, and the metadata about the machine in each of them.
struct TableFolder<'a> {
    folder: &'a Path,
    metadata: [(&'static str, String); 3],
}

impl TableFolder<'_> {
    fn measurements<K: Key + Clone>(&self, rows: &[Measurement<K>]) -> Result<(), StoreError> {
        self.rows(K::NAME, Measurement::table(), rows)
    }

    fn rows<R: Clone>(&self, name: &str, table: Table<R>, rows: &[R]) -> Result<(), StoreError> {
        let name = format!("{name}.parquet");
        let mut file =
            UnfinishedTable::create_standalone(self.folder, &name, table, &self.metadata)?;
        rows.iter().try_for_each(|row| file.push(row.clone()))?;
        file.finish()?;
        Ok(())
    }
}
