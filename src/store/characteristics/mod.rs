//! What `atlas machine` found out about a machine: a folder with one Parquet file a measurement
//! and `machine.json`, which holds all of it.

mod description;
mod rows;
mod tables;

pub use description::{CacheRecord, Description, HugePages, NodeRecord};
pub use rows::{
    ArithmeticRow, BandwidthRow, Cliff, Figure, Keyed, LatencyRow, MountainRow, Noise, OperatorRow,
    RoofRow, SolverRow,
};

use super::StoreError;
use super::file::{TableFile, create_folder, publish, remove_stale, temporary_file};
use super::run::ProgramRecord;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Version of `machine.json`.
const FORMAT: &str = "atlas-machine-1";

/// The file that holds everything.
const RECORD: &str = "machine.json";

/// Hands the names of all measurements with a file, which are those of the fields and of their columns,
/// to a macro.
macro_rules! of_all {
    ($then:ident) => {
        $then!(
            mountain, operators, bandwidth, latency, arithmetic, solver, roofline
        )
    };
}

/// Everything that was found out about a machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Characteristics {
    /// Version of this layout.
    pub format: String,
    /// Name of the machine.
    pub host: String,
    /// When the measurements started, RFC 3339, UTC.
    pub started: String,
    /// Wall time \[s\].
    pub seconds: f64,
    /// How much was measured: quick, default or full.
    pub extent: String,
    /// The program that measured.
    pub program: ProgramRecord,
    /// What the system says of the machine.
    pub description: Description,
    /// What disturbed the measurements.
    pub noise: Noise,
    /// Reading buffers of many sizes with many strides, one thread.
    pub mountain: Vec<MountainRow>,
    /// Kernels that go round a set of tables, one thread.
    pub operators: Vec<OperatorRow>,
    /// Where their cost jumps.
    pub cliffs: Vec<Cliff>,
    /// Reading, copying and combining large arrays on many threads.
    pub bandwidth: Vec<BandwidthRow>,
    /// Time of a load that depends on the one before.
    pub latency: Vec<LatencyRow>,
    /// Multiply-adds of numbers in registers.
    pub arithmetic: Vec<ArithmeticRow>,
    /// Integrating the default drive on many threads.
    pub solver: Vec<SolverRow>,
    /// Kernels under the roof of arithmetic and bandwidth.
    pub roofline: Vec<RoofRow>,
    /// What could not be measured, and why, a sentence each.
    pub missing: Vec<String>,
}

impl Characteristics {
    /// The version that this program writes.
    pub fn format() -> String {
        FORMAT.to_owned()
    }

    /// Writes the Parquet files and, last, `machine.json` into a folder, which is created where
    /// needed.
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
        macro_rules! tables {
            ($($name:ident),*) => {
                $({
                    let table = tables::$name();
                    let name = concat!(stringify!($name), ".parquet");
                    let mut file = TableFile::create_alone(folder, name, table, &metadata)?;
                    self.$name.iter().try_for_each(|row| file.push(row.clone()))?;
                    file.finish()?;
                })*
            };
        }
        of_all!(tables);
        let path = folder.join(RECORD);
        let refused = |source| StoreError::io(&path, "write", source);
        let mut text = serde_json::to_string_pretty(self).map_err(|error| refused(error.into()))?;
        text.push('\n');
        let mut temporary = temporary_file(folder, ".machine.")?;
        temporary.write_all(text.as_bytes()).map_err(refused)?;
        let (file, temporary) = temporary.into_parts();
        publish(&file, temporary, &path)
    }

    /// Reads what [`Self::write`] wrote.
    ///
    /// # Errors
    /// There is none in this folder, it cannot be read, or it is not of this program.
    pub fn read(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(RECORD);
        let text = fs::read_to_string(&path).map_err(|source| match source.kind() {
            ErrorKind::NotFound => StoreError::Missing {
                folder: folder.to_path_buf(),
                missing: path.clone(),
            },
            _ => StoreError::io(&path, "read", source),
        })?;
        let foreign = |detail: String| StoreError::Foreign {
            path: path.clone(),
            detail,
        };
        let found: Self =
            serde_json::from_str(&text).map_err(|error| foreign(error.to_string()))?;
        match found.format == FORMAT {
            true => Ok(found),
            false => Err(foreign(format!(
                "format `{}`, not `{FORMAT}`",
                found.format
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_units_and_descriptions() {
        macro_rules! listed {
            ($($name:ident),*) => {
                $(insta::assert_snapshot!(stringify!($name), tables::$name().listing());)*
            };
        }
        of_all!(listed);
    }
}
