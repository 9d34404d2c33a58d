//! The tables of a trace folder, prepared for pictures.

use std::collections::BTreeMap;
use std::path::Path;

use super::axis::value_words;
use super::error::PlotError;
use crate::report::numbers::number;
use crate::store::{ResultTable, StoreError, TableKind};

/// A change of contact state of the drive or the coast flank.
pub(super) struct ContactChange {
    /// Mesh cycles since the start of the simulation.
    pub time: f64,
    /// True for the drive flank, false for the coast flank.
    pub on_drive_flank: bool,
    /// True if contact begins, false if it ends.
    pub is_entry: bool,
}

/// A traced trajectory.
pub(super) struct Recording {
    pub job: String,
    point: String,
    /// Mesh cycles since the start of the simulation, one value per sample.
    pub time: Vec<f64>,
    phase: Vec<f64>,
    pub deflection: Vec<f64>,
    pub velocity: Vec<f64>,
    pub force: Vec<f64>,
    pub contact: Vec<String>,
    /// Half the backlash \[m\], if known.
    pub half_gap: Option<f64>,
    /// Mesh period \[s\].
    pub period: Option<f64>,
    pub changes: Vec<ContactChange>,
    units: BTreeMap<String, String>,
}

impl Recording {
    pub fn read(folder: &Path) -> Result<Self, PlotError> {
        let table = ResultTable::read(folder, TableKind::Trace)?;
        let events = ResultTable::read_if_there(folder, TableKind::Events)?;
        // A value that is not finite is a null in the file.
        let column = |name: &str| -> Result<Vec<f64>, StoreError> {
            let values = table.f64(name)?.into_iter();
            Ok(values.map(|value| value.unwrap_or(f64::NAN)).collect())
        };
        let phase = column("phase")?;
        Ok(Self {
            job: table.metadata("job").unwrap_or("trace").to_owned(),
            point: point_words(table.metadata("point"), table.metadata("point_units")),
            time: times(&table)?,
            deflection: column("deflection")?,
            velocity: column("velocity")?,
            force: column("force")?,
            contact: (table.text("contact")?.into_iter())
                .map(Option::unwrap_or_default)
                .collect(),
            half_gap: quantity(table.metadata("half_gap")),
            period: quantity(table.metadata("mesh_period")),
            changes: events.as_ref().map_or(Ok(Vec::new()), changes)?,
            units: table.units()?,
            phase,
        })
    }

    /// Unit of a column of trace.parquet.
    pub fn unit(&self, column: &str) -> &str {
        self.units.get(column).map_or("", String::as_str)
    }

    /// Number of samples in the first `cycles` mesh cycles.
    pub fn first_cycles(&self, cycles: u64) -> usize {
        let start = self.time.first().copied().unwrap_or(0.0);
        let end = start + cycles as f64 + 1e-9;
        self.time.partition_point(|time| *time <= end)
    }

    /// Whether a sample is at mesh phase 0.
    pub fn starts_cycle(&self, row: usize) -> bool {
        self.phase[row] == 0.0
    }

    /// The line below a title: the point, and the shown part of the recording if this is not all of it.
    pub fn subtitle(&self, rows: usize) -> String {
        let mut parts = Vec::new();
        if !self.point.is_empty() {
            parts.push(self.point.clone());
        }
        if rows < self.time.len() {
            let cycles = |row: Option<&f64>| row.copied().unwrap_or(0.0) - self.time[0];
            parts.push(format!(
                "the first {} of {} mesh cycles",
                number(cycles(rows.checked_sub(1).map(|row| &self.time[row])).round()),
                number(cycles(self.time.last()).round())
            ));
        }
        parts.join("  ·  ")
    }
}

/// Mesh cycles since the start of the simulation.
fn times(table: &ResultTable) -> Result<Vec<f64>, StoreError> {
    let cycles = table.u64("cycle")?.into_iter();
    let times = cycles.zip(table.f64("phase")?);
    Ok(times
        .map(|(cycle, phase)| cycle.unwrap_or(0) as f64 + phase.unwrap_or(0.0))
        .collect())
}

/// The contact changes of the two flanks of the first mesh. Pictures do not show further contacts.
fn changes(events: &ResultTable) -> Result<Vec<ContactChange>, StoreError> {
    let kinds = events.text("kind")?.into_iter();
    Ok(times(events)?
        .into_iter()
        .zip(kinds)
        .filter_map(|(time, kind)| {
            let kind = kind?;
            let (flank, change) = kind.split_once('_')?;
            Some(ContactChange {
                time,
                on_drive_flank: flank == "drive",
                is_entry: change == "entry",
            })
        })
        .collect())
}

/// The value of a quantity in the metadata, such as `{"value":1e-5,"unit":"m"}`.
fn quantity(text: Option<&str>) -> Option<f64> {
    let value: serde_json::Value = serde_json::from_str(text?).ok()?;
    value.get("value")?.as_f64()
}

/// `{"load":0.1,"speed":1150.0}` in words, with the units of `{"load":"1","speed":"rad/s"}`.
fn point_words(values: Option<&str>, units: Option<&str>) -> String {
    type Map = serde_json::Map<String, serde_json::Value>;
    let map = |text: Option<&str>| -> Map {
        let parsed = text.and_then(|text| serde_json::from_str(text).ok());
        parsed.unwrap_or_default()
    };
    let units = map(units);
    let words = map(values).into_iter().map(|(name, value)| {
        let unit = units.get(&name).and_then(|unit| unit.as_str());
        match value.as_f64() {
            Some(value) => format!("{name} {}", value_words(value, unit.unwrap_or(""))),
            None => format!("{name} {value}"),
        }
    });
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_told_with_its_units() {
        let values = r#"{"load":0.1,"speed":1200.0,"mesh.half_gap":1.5e-5}"#;
        let units = r#"{"load":"1","speed":"rad/s","mesh.half_gap":"m"}"#;
        let mut words: Vec<String> = (point_words(Some(values), Some(units)).split(", "))
            .map(str::to_owned)
            .collect();
        words.sort();
        assert_eq!(
            words,
            ["load 0.1", "mesh.half_gap 15 µm", "speed 1200 rad/s"]
        );
        assert_eq!(point_words(None, None), "");
    }
}
