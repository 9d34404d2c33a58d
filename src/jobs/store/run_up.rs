//! The tables of `atlas runup`: signals at equidistant instants, order tracks, levels, spectra, openings and closings
//! of contacts.

use std::path::Path;
use std::sync::Arc;

use super::StoreError;
use super::command_record::CommandTables;
use super::orders::{AMPLITUDE_UNITS, SIGNALS};
use super::table::{Table, columns};
use super::table_kind::{RUNUP_RECORD, TableKind};
use super::trace::{column_names, event_kind};
use crate::analysis::run_up::{Level, OrderPoint, RunUp, RunUpConfig, SpectrumRow};
use crate::propagate::varying_speed::MovingEvent;

/// Name and unit of a signal, which all its rows share.
type Named = [Arc<str>; 2];

/// A row of `signals.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct InstantRow {
    time: f64,
    speed: f64,
    load: f64,
    values: Vec<f64>,
}

/// A row about one signal.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalRow<T> {
    signal: Named,
    value: T,
}

const TIME: &str = "Time since the start of the run-up";
const SPEED: &str = "Mean speed of the pinion";
const LOAD: &str = "Load, as a fraction of the rated one";
const UNIT: &str = "Unit of the signal";

/// Columns of `signals.parquet`: time, speed, load, and one for each signal (name and unit).
pub fn signals_table(signals: &[[String; 2]]) -> Table<InstantRow> {
    let mut columns = columns![row: InstantRow;
        f64 "time", "s", row.time, TIME;
        f64 "speed", "rad/s", row.speed, SPEED;
        f64 "load", "1", row.load, LOAD;
    ];
    let names = column_names(signals);
    for (index, (name, [signal, unit])) in names.iter().zip(signals).enumerate() {
        columns.extend(columns![row: InstantRow;
            f64 name, unit, row.values.get(index).copied(), &format!("The signal {signal}");
        ]);
    }
    Table::new(columns)
}

/// Columns of `order_tracks.parquet`.
pub fn order_tracks_table() -> Table<SignalRow<OrderPoint>> {
    Table::new(columns![row: SignalRow<OrderPoint>;
        f64 "time", "s", row.value.time, TIME;
        f64 "speed", "rad/s", row.value.speed, SPEED;
        text "signal", "", &*row.signal[0], SIGNALS;
        text "unit", "", &*row.signal[1], UNIT;
        f64 "order", "1", row.value.order, "Multiple of the rotation of the pinion";
        f64 "amplitude", AMPLITUDE_UNITS, row.value.amplitude, "Peak value under a Hann window over some revolutions";
        f64 "phase", "rad", row.value.phase,
            "Phase: signal = ... + amplitude cos(order angle + phase), the mean angle of the pinion counted from mesh cycle 0";
    ])
}

/// Columns of `levels.parquet`.
pub fn levels_table() -> Table<SignalRow<Level>> {
    Table::new(columns![row: SignalRow<Level>;
        f64 "time", "s", row.value.time, TIME;
        f64 "speed", "rad/s", row.value.speed, SPEED;
        f64 "load", "1", row.value.load, LOAD;
        text "signal", "", &*row.signal[0], SIGNALS;
        text "unit", "", &*row.signal[1], UNIT;
        f64 "mean", AMPLITUDE_UNITS, row.value.mean, "Mean over some revolutions";
        f64 "rms", AMPLITUDE_UNITS, row.value.rms, "Root mean square about the mean";
        f64 "smallest", AMPLITUDE_UNITS, row.value.range[0], "Smallest value";
        f64 "largest", AMPLITUDE_UNITS, row.value.range[1], "Largest value";
        f64 "fraction_drive", "1", row.value.fractions[0], "Part of the rotation with the drive flank in contact";
        f64 "fraction_free", "1", row.value.fractions[1], "Part of the rotation without contact";
        f64 "fraction_coast", "1", row.value.fractions[2], "Part of the rotation with the coast flank in contact";
        f64 "fraction_both", "1", row.value.fractions[3], "Part of the rotation with both flanks in contact";
        f64 "impacts_per_cycle", "1", row.value.closings, "Closings of contacts per mesh cycle";
    ])
}

/// Columns of `spectrogram.parquet`.
pub fn spectrogram_table() -> Table<SignalRow<SpectrumRow>> {
    Table::new(columns![row: SignalRow<SpectrumRow>;
        f64 "time", "s", row.value.time, TIME;
        f64 "speed", "rad/s", row.value.speed, SPEED;
        text "signal", "", &*row.signal[0], SIGNALS;
        text "unit", "", &*row.signal[1], UNIT;
        f64 "frequency_step", "Hz", row.value.step, "Distance between lines; the first is at frequency 0";
        list "amplitudes", AMPLITUDE_UNITS, &*row.value.amplitudes,
            "Peak value of the sine that would give each line, under a Hann window; first, the magnitude of the mean, which the other lines omit";
    ])
}

/// Columns of `contact_changes.parquet`.
pub fn contact_changes_table() -> Table<MovingEvent> {
    Table::new(columns![row: MovingEvent;
        f64 "time", "s", row.time, TIME;
        u64 "cycle", "mesh cycles", row.cycle, "Mesh cycle";
        f64 "phase", "1", row.phase, "Mesh phase: fraction of the mesh cycle";
        f64 "mesh_frequency", "Hz", row.speed, "Mesh frequency";
        text "kind", "", event_kind(row.contact, row.to.holds(row.contact)),
            "drive_entry, drive_release, coast_entry or coast_release; entry or release of a further contact";
        f64 "rate", "m/s", row.rate, "Rate at which the surfaces approach (positive) or part";
        u64 "contact", "", row.contact as u64 + 1, "The contact: 1 for the drive flank, 2 for the coast flank, then further contacts";
    ])
}

/// Rows about signals, with their names.
fn named<T>(
    rows: Vec<T>,
    names: &[Named],
    signal: impl Fn(&T) -> usize,
) -> impl Iterator<Item = SignalRow<T>> {
    rows.into_iter().map(move |value| SignalRow {
        signal: names[signal(&value)].clone(),
        value,
    })
}

/// Writes the tables of a run-up into a folder, `signals.parquet` last, then `runup.json`. Each table has `metadata`.
///
/// # Errors
/// The folder cannot be created, or a file cannot be written.
pub fn write_run_up(
    folder: &Path,
    metadata: &[(&str, String)],
    config: &RunUpConfig,
    run: RunUp,
) -> Result<(), StoreError> {
    let names: Vec<Named> = (run.signals.iter())
        .map(|texts| texts.each_ref().map(|text| Arc::from(text.as_str())))
        .collect();
    let count = run.instants.values.first().map_or(0, Vec::len);
    let instants = (0..count).map(|index| {
        let time = index as f64 / run.instants.rate;
        InstantRow {
            time,
            speed: config.speed_at(time),
            load: config.load_at(time),
            values: (run.instants.values.iter().map(|values| values[index])).collect(),
        }
    });
    let tracks = named(run.orders, &names, |row| row.signal);
    let levels = named(run.levels, &names, |row| row.signal);
    let spectra = named(run.spectra, &names, |row| row.signal);
    let (changes, signals) = (contact_changes_table(), signals_table(&run.signals));
    let mut tables = CommandTables::start(folder, RUNUP_RECORD, metadata)?;
    tables.write(TableKind::ContactChanges, changes, run.events)?;
    tables.write(TableKind::Spectrogram, spectrogram_table(), spectra)?;
    tables.write(TableKind::Levels, levels_table(), levels)?;
    tables.write(TableKind::OrderTracks, order_tracks_table(), tracks)?;
    tables.write(TableKind::Signals, signals, instants)?;
    tables.finish().map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Signals;
    use crate::analysis::run_up::Instants;
    use crate::analysis::run_up::LoadLaw;
    use crate::model::ActiveSet;
    use crate::numerics::point_course::PointCourse;
    use crate::store::ResultTable;

    /// A row of each table reads back as written.
    #[test]
    fn every_column_of_a_run_up_comes_back() {
        let config = RunUpConfig {
            speed: PointCourse::line([0.0, 10.0], [2.0, 30.0]),
            load: LoadLaw::OverTime(PointCourse::line([0.0, 0.1], [2.0, 0.3])),
            settle: 0.0,
            sample_rate: 1.0,
            revolutions: 1,
            orders: vec![20.0],
            frequency_step: 1.0,
            signals: Signals::NONE,
        };
        let names = [["force", "N"], ["bearing pinion 1 x", "N"]];
        let run = RunUp {
            signals: names.map(|texts| texts.map(str::to_owned)).to_vec(),
            instants: Instants {
                rate: 1.0,
                values: vec![vec![5.0, 6.0], vec![7.0, 8.0]],
            },
            orders: vec![OrderPoint {
                time: 0.5,
                speed: 15.0,
                signal: 1,
                order: 20.0,
                amplitude: 3.0,
                phase: -0.5,
            }],
            levels: vec![Level {
                time: 0.6,
                speed: 16.0,
                load: 0.16,
                signal: 0,
                mean: 9.0,
                rms: 1.5,
                range: [4.0, 11.0],
                fractions: [0.4, 0.3, 0.2, 0.1],
                closings: 2.5,
            }],
            spectra: vec![SpectrumRow {
                time: 0.7,
                speed: 17.0,
                signal: 1,
                step: 12.5,
                amplitudes: vec![0.5, 0.25],
            }],
            events: vec![MovingEvent {
                time: 0.8,
                cycle: 3,
                phase: 0.375,
                speed: 55.0,
                from: ActiveSet::DRIVE,
                to: ActiveSet::FREE,
                contact: 0,
                rate: -0.01,
            }],
            cycles: 40.0,
            stop: None,
        };
        let folder = tempfile::tempdir().unwrap();
        write_run_up(folder.path(), &[("job", "test".to_owned())], &config, run).unwrap();
        let read = |kind| ResultTable::read(folder.path(), kind).unwrap();
        let numbers = |kind, known: &[(&str, f64)]| {
            let table = read(kind);
            for (name, value) in known {
                assert_eq!(table.f64(name).unwrap()[0], Some(*value), "{name}");
            }
        };
        let texts = |kind, known: [&str; 2]| {
            for (name, value) in ["signal", "unit"].into_iter().zip(known) {
                assert_eq!(read(kind).text(name).unwrap(), [Some(value.to_owned())]);
            }
        };
        let signals = read(TableKind::Signals);
        assert_eq!(signals.metadata("job"), Some("test"));
        for (name, values) in [
            ("time", [0.0, 1.0]),
            ("speed", [10.0, 20.0]),
            ("load", [0.1, 0.2]),
            ("force", [5.0, 6.0]),
            ("bearing_pinion_1_x", [7.0, 8.0]),
        ] {
            assert_eq!(signals.f64(name).unwrap(), values.map(Some), "{name}");
        }
        let tracks = [
            ("time", 0.5),
            ("speed", 15.0),
            ("order", 20.0),
            ("amplitude", 3.0),
            ("phase", -0.5),
        ];
        numbers(TableKind::OrderTracks, &tracks);
        texts(TableKind::OrderTracks, names[1]);
        let levels = [
            ("time", 0.6),
            ("speed", 16.0),
            ("load", 0.16),
            ("mean", 9.0),
            ("rms", 1.5),
            ("smallest", 4.0),
            ("largest", 11.0),
            ("fraction_drive", 0.4),
            ("fraction_free", 0.3),
            ("fraction_coast", 0.2),
            ("fraction_both", 0.1),
            ("impacts_per_cycle", 2.5),
        ];
        numbers(TableKind::Levels, &levels);
        texts(TableKind::Levels, names[0]);
        numbers(
            TableKind::Spectrogram,
            &[("time", 0.7), ("speed", 17.0), ("frequency_step", 12.5)],
        );
        texts(TableKind::Spectrogram, names[1]);
        let lists = read(TableKind::Spectrogram).lists("amplitudes").unwrap();
        assert_eq!(lists, [Some(vec![Some(0.5), Some(0.25)])]);
        let changes = [
            ("time", 0.8),
            ("phase", 0.375),
            ("mesh_frequency", 55.0),
            ("rate", -0.01),
        ];
        numbers(TableKind::ContactChanges, &changes);
        let changes = read(TableKind::ContactChanges);
        assert_eq!(changes.u64("cycle").unwrap(), [Some(3)]);
        assert_eq!(changes.u64("contact").unwrap(), [Some(1)]);
        assert_eq!(
            changes.text("kind").unwrap(),
            [Some("drive_release".to_owned())]
        );
    }
}
