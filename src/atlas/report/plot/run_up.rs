//! Pictures of a run-up: a spectrogram over the speed, and the tracks of orders.

use std::path::Path;

use super::axis::{Axis, range};
use super::canvas::{Canvas, INK, SOFT};
use super::categories::colour;
use super::display::{Scale, Unit};
use super::error::PlotError;
use super::over_axis::{MARGIN, RIGHT};
use super::panel::{BOTTOM, LEFT, Panel, TICK_SIZE, TOP};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::ramp::{bar, viridis};
use super::request::PlotRequest;
use crate::report::numbers::number;
use crate::store::{ResultTable, StoreError, TableKind};

/// Numbers of columns and rows of a spectrogram.
const CELLS: [usize; 2] = [342, 227];
/// Lowest shown level, relative to the largest amplitude: −80 dB.
const FLOOR: f64 = 1e-4;

/// The rows of a table that belong to one signal.
struct SignalRows {
    job: String,
    name: String,
    unit: String,
    table: ResultTable,
    rows: Vec<usize>,
    /// Speed in each row \[rpm\].
    speeds: Vec<f64>,
}

impl SignalRows {
    fn read(
        folder: &Path,
        kind: TableKind,
        what: PictureKind,
        signal_name: Option<&str>,
    ) -> Result<Self, PlotError> {
        let table = ResultTable::read(folder, kind)?;
        let signals = table.text("signal")?;
        let Some(name) = signal_name.or(signals.first().and_then(|name| name.as_deref())) else {
            return Err(what.unfit(
                "the run-up is too short for it; make it longer, or lower runup.revolutions",
            ));
        };
        let of_signal = |row: &usize| signals[*row].as_deref() == Some(name);
        let rows: Vec<usize> = (0..signals.len()).filter(of_signal).collect();
        let Some(&first) = rows.first() else {
            let mut names: Vec<&str> = signals.iter().flatten().map(String::as_str).collect();
            names.sort_unstable();
            names.dedup();
            return Err(what.unfit(format!(
                "the run-up has no signal `{name}`; it has {}",
                names.join(", ")
            )));
        };
        let name = name.to_owned();
        let (speeds, rpm) = (column(&table, "speed")?, Unit::or_si(Some("rpm"), "rad/s"));
        Ok(Self {
            job: table.metadata("job").unwrap_or("run-up").to_owned(),
            unit: table.text("unit")?.swap_remove(first).unwrap_or_default(),
            speeds: rows.iter().map(|row| rpm.factor * speeds[*row]).collect(),
            name,
            rows,
            table,
        })
    }

    fn across(&self) -> Axis {
        Axis::linear(
            "speed of the pinion",
            "rpm",
            range(self.speeds.iter().copied()),
        )
    }
}

fn column(table: &ResultTable, name: &str) -> Result<Vec<f64>, StoreError> {
    Ok(table
        .f64(name)?
        .into_iter()
        .map(|value| value.unwrap_or(f64::NAN))
        .collect())
}

/// Draws one kind of picture of the run-up in a folder.
pub(super) fn draw(
    folder: &Path,
    what: PictureKind,
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    let read = |table| SignalRows::read(folder, table, what, request.signal.as_deref());
    match what {
        PictureKind::Spectrogram => spectrogram(read(TableKind::Spectrogram)?, request),
        _ => tracks(read(TableKind::OrderTracks)?, request),
    }
}

/// Draws levels in colour over speed and frequency.
fn spectrogram(signal_rows: SignalRows, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let lists = signal_rows.table.lists("amplitudes")?;
    let step = column(&signal_rows.table, "frequency_step")?[signal_rows.rows[0]];
    let spectra: Vec<Vec<f64>> = (signal_rows.rows.iter())
        .map(|row| {
            lists[*row]
                .iter()
                .flatten()
                .map(|a| a.unwrap_or(0.0))
                .collect()
        })
        .collect();
    // The mean of the signal is not vibration. It is in line 0, and the window spreads it to line 1.
    let largest = spectra
        .iter()
        .flat_map(|spectrum| spectrum.iter().skip(2))
        .copied()
        .fold(0.0, f64::max);
    let scale = scale(&signal_rows, request)?;
    let [Some(low), Some(high)] = [FLOOR * largest, largest].map(|end| scale.shown(end)) else {
        return Err(silent(PictureKind::Spectrogram));
    };
    let level = scale.axis_over([low, high]);
    let lines = spectra.iter().map(Vec::len).min().unwrap_or(0);
    let up = Axis::linear("frequency", "Hz", [0.0, lines as f64 * step]);
    let (mut canvas, panel) = framed(&signal_rows, "spectrogram", up);
    canvas.rectangle([panel.left, TOP], [panel.right, BOTTOM], viridis(0.0));
    let [columns, rows] = CELLS;
    let mut cells = vec![0.0_f64; columns * rows];
    let [from, to] = range(signal_rows.speeds.iter().copied());
    for (speed, spectrum) in signal_rows.speeds.iter().zip(&spectra) {
        let at = (((speed - from) / (to - from) * columns as f64) as usize).min(columns - 1);
        for (line, amplitude) in spectrum.iter().enumerate().take(lines).skip(2) {
            let cell = &mut cells[at * rows + line * rows / lines];
            *cell = cell.max(*amplitude);
        }
    }
    // If spectra are farther apart than a column, each fills the columns up to the next spectrum.
    for at in 1..columns {
        let (before, present) = cells.split_at_mut(at * rows);
        if present[..rows].iter().all(|a| *a == 0.0) {
            present[..rows].copy_from_slice(&before[(at - 1) * rows..]);
        }
    }
    let x = |at: usize| panel.left + (panel.right - panel.left) * at as f64 / columns as f64;
    let y = |row: usize| BOTTOM - (BOTTOM - TOP) * row as f64 / rows as f64;
    for (cell, amplitude) in cells.iter().enumerate() {
        let fraction = scale
            .shown(*amplitude)
            .map_or(0.0, |shown| level.fraction(shown));
        if fraction > 0.0 {
            let (at, row) = (cell / rows, cell % rows);
            canvas.rectangle([x(at), y(row + 1)], [x(at + 1), y(row)], viridis(fraction));
        }
    }
    canvas.outline([panel.left, TOP], [panel.right, BOTTOM], INK, 1.0);
    bar(&mut canvas, RIGHT + 24.0, [TOP, TOP + 300.0], &level);
    Ok(Drawn::one("spectrogram", canvas))
}

/// Draws the amplitudes of orders over the speed.
fn tracks(signal_rows: SignalRows, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let (orders, amplitudes) = (
        column(&signal_rows.table, "order")?,
        column(&signal_rows.table, "amplitude")?,
    );
    let scale = scale(&signal_rows, request)?;
    let mut all_orders: Vec<f64> = signal_rows.rows.iter().map(|row| orders[*row]).collect();
    all_orders.sort_by(f64::total_cmp);
    all_orders.dedup();
    let largest = signal_rows
        .rows
        .iter()
        .map(|row| amplitudes[*row])
        .fold(0.0, f64::max);
    let shown = |row: usize| scale.shown(amplitudes[row].max(FLOOR * largest));
    let ends = range(signal_rows.rows.iter().filter_map(|row| shown(*row)));
    if largest == 0.0 {
        return Err(silent(PictureKind::Tracks));
    }
    let (mut canvas, panel) = framed(&signal_rows, "orders", scale.axis(ends));
    for (place, order) in all_orders.iter().enumerate() {
        let of_order = signal_rows
            .rows
            .iter()
            .zip(&signal_rows.speeds)
            .filter(|(row, _)| orders[**row] == *order);
        let line: Vec<_> = of_order
            .filter_map(|(row, speed)| Some(panel.at(*speed, shown(*row)?)))
            .collect();
        canvas.line(&line, colour(place), 1.6);
        let y = TOP + 14.0 + 20.0 * place as f64;
        canvas.line(&[[MARGIN, y], [MARGIN + 20.0, y]], colour(place), 2.4);
        let text = format!("order {}", number(*order));
        canvas.label([MARGIN + 28.0, y + 0.35 * TICK_SIZE], &text, SOFT);
    }
    Ok(Drawn::one("tracks", canvas))
}

/// The scale of a signal's amplitudes.
fn scale(signal_rows: &SignalRows, request: &PlotRequest) -> Result<Scale, PlotError> {
    Ok(Scale::new(&signal_rows.name, &signal_rows.unit, &request.display)?.in_decades())
}

/// A picture with an empty panel.
fn framed(signal_rows: &SignalRows, of: &str, up: Axis) -> (Canvas, Panel) {
    let title = format!("{}: {of} of {}", signal_rows.job, signal_rows.name);
    let mut canvas = Canvas::titled(&title, "");
    let panel = Panel::new([LEFT, RIGHT], [TOP, BOTTOM], signal_rows.across(), up);
    panel.frame(&mut canvas, true);
    (canvas, panel)
}

fn silent(what: PictureKind) -> PlotError {
    what.unfit("no amplitude is above zero")
}
