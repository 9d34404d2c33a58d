//! Spectral lines of one signal for all points of a results folder. They come from spectra.parquet. If this
//! table does not exist, order cuts use orders.parquet, and the deflection uses its harmonics in
//! points.parquet.

use super::column::{SUBORDERS, nearest};
use super::error::PlotError;
use super::picture_kind::PictureKind;
use super::results::Results;
use super::spectrum::unit_of;
use crate::store::{ResultTable, StoreError, TableKind};

/// The word for a signal in `signals` of the manifest: `bearings` for `bearing pinion 1 x`. `None` for an
/// unknown signal.
fn group(signal: &str) -> Option<&'static str> {
    const GROUPS: [(&str, &str); 7] = [
        ("deflection", "deflection"),
        ("force", "force"),
        ("bearing", "bearings"),
        ("torque", "torques"),
        ("acceleration", "accelerations"),
        ("angular acceleration", "accelerations"),
        ("mesh", "meshes"),
    ];
    let of = |(name, _): &&(&str, &str)| signal.starts_with(name);
    GROUPS.iter().find(of).map(|(_, word)| *word)
}

/// Largest distance of a line from an order to which it counts \[mesh orders\]: the spacing of averaged
/// spectra.
const REACH: f64 = 1.0 / 64.0;

/// The amplitudes of a list of a point.
type Amplitudes = Vec<Option<f64>>;

/// A spectral line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Multiple of the mesh frequency.
    pub order: f64,
    /// \[Hz\], if known.
    pub frequency: Option<f64>,
    /// Amplitude, in the unit of the signal.
    pub amplitude: f64,
}

/// Lines of one signal over the points.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpectralLines {
    /// Name of the quantity: `force amplitude`.
    pub name: String,
    /// SI unit of the amplitudes.
    pub unit: String,
    /// For each point of the summary, its lines in ascending `order`; empty for a point without lines.
    pub lines: Vec<Vec<Line>>,
}

impl SpectralLines {
    /// Reads the lines of a signal.
    ///
    /// # Errors
    /// There are none, or the signal does not exist.
    pub fn read(results: &Results, what: PictureKind, signal: &str) -> Result<Self, PlotError> {
        if let Some(table) = results.table(TableKind::Spectra)? {
            return Self::of_lines(results, &table, "spectra.parquet", what, signal);
        }
        if what == PictureKind::Orders
            && signal != "deflection"
            && let Some(table) = results.table(TableKind::Orders)?
        {
            return Self::of_lines(results, &table, "orders.parquet", what, signal);
        }
        Self::of_harmonics(results, what, signal)
    }

    /// Reads the lines from a table with one row per line.
    fn of_lines(
        results: &Results,
        table: &ResultTable,
        file: &str,
        what: PictureKind,
        signal: &str,
    ) -> Result<Self, PlotError> {
        let ids = table.u64("point_id")?;
        let signals = table.text("signal")?;
        let [orders, frequencies, amplitudes] = [
            table.f64("order")?,
            table.f64("frequency")?,
            table.f64("amplitude")?,
        ];
        let mut lines = vec![Vec::new(); results.summary.all.len()];
        for (row, id) in ids.iter().enumerate() {
            let place = id.and_then(|id| results.place(id));
            if let (Some(place), Some(order), Some(amplitude)) =
                (place, orders[row], amplitudes[row])
                && signals[row].as_deref() == Some(signal)
            {
                lines[place].push(Line {
                    order,
                    frequency: frequencies[row],
                    amplitude,
                });
            }
        }
        if lines.iter().all(Vec::is_empty) {
            let mut known: Vec<String> = signals.into_iter().flatten().collect();
            known.sort_unstable();
            known.dedup();
            let near = match &nearest(signal, &known)[..] {
                [] => String::new(),
                near => format!("; did you mean {}?", near.join(", ")),
            };
            let group_words = group(signal).map_or(String::new(), |word| {
                format!("; name \"{word}\" in `signals` of that analysis to compute more")
            });
            return Err(what.unfit(format!(
                "{file} has no lines of the signal `{signal}`{near}; its signals: {}{group_words}",
                known.join(", ")
            )));
        }
        for lines in &mut lines {
            lines.sort_by(|a, b| a.order.total_cmp(&b.order));
        }
        let units = table.units()?.remove("amplitude").unwrap_or_default();
        let unit = unit_of(&units, signal);
        Ok(Self {
            name: format!("{signal} amplitude"),
            unit: unit.to_owned(),
            lines,
        })
    }

    /// Reads the spectral lines of the deflection from the columns `harmonics` and `suborders` of points.parquet.
    fn of_harmonics(results: &Results, what: PictureKind, signal: &str) -> Result<Self, PlotError> {
        if signal != "deflection" {
            return Err(what.unfit(&match group(signal) {
                None => format!(
                    "`{signal}` is not a signal; signals are deflection, force, and the bearings, torques and \
                     accelerations by name, such as \"bearing pinion 1 x\""
                ),
                Some("deflection" | "force") => {
                    "there is no spectra.parquet; add `nvh = { spectrum = {} }` \
                                                 to [analyses] of the manifest"
                        .to_owned()
                }
                Some(word) => format!(
                    "there is no spectra.parquet; add `nvh = {{ spectrum = {{ signals = [\"{word}\"] }} }}` \
                     to [analyses] of the manifest"
                ),
            }));
        }
        let of_lists = |(whole, parts): (Option<Amplitudes>, Option<Amplitudes>)| -> Vec<Line> {
            let line = |(order, amplitude): (f64, Option<f64>)| {
                Some(Line {
                    order,
                    frequency: None,
                    amplitude: amplitude?,
                })
            };
            let orders = SUBORDERS.iter().map(|(_, order)| *order);
            let parts = orders.zip(parts.unwrap_or_default());
            let whole = (1..).map(f64::from).zip(whole.unwrap_or_default());
            parts.chain(whole).filter_map(line).collect()
        };
        let mut points: Vec<(Option<u64>, Vec<Line>)> = Vec::new();
        let columns = ["point_id", "harmonics", "suborders"];
        ResultTable::scan(&results.folder, TableKind::Points, &columns, |part| {
            let lists = part
                .lists("harmonics")?
                .into_iter()
                .zip(part.lists("suborders")?);
            points.extend(part.u64("point_id")?.into_iter().zip(lists.map(of_lists)));
            Ok::<_, StoreError>(())
        })?;
        points.sort_by_key(|(id, _)| *id);
        let lines: Vec<Vec<Line>> = points.into_iter().map(|(_, lines)| lines).collect();
        if lines.iter().all(Vec::is_empty) {
            return Err(what.unfit(
                "no point has harmonics; add `nvh = { harmonics = 5, spectrum = {} }` to [analyses] of the manifest",
            ));
        }
        Ok(Self {
            name: "deflection amplitude".to_owned(),
            unit: "m".to_owned(),
            lines,
        })
    }

    /// The amplitude of a point at an order: its largest line within a 64th of a mesh order. It is 0 if the point has
    /// lines, but none near this order; `None` if it has no lines.
    pub fn at(&self, point: usize, order: f64) -> Option<f64> {
        let lines = &self.lines[point];
        let near = lines
            .iter()
            .filter(|line| (line.order - order).abs() < REACH);
        (!lines.is_empty()).then(|| near.map(|line| line.amplitude).fold(0.0, f64::max))
    }

    /// Whether any point has lines up to this order.
    pub fn reach(&self, order: f64) -> bool {
        let last = self.lines.iter().filter_map(|lines| lines.last());
        last.fold(0.0_f64, |most, line| most.max(line.order)) + REACH > order
    }

    /// Whether frequencies are known.
    pub fn has_frequencies(&self) -> bool {
        self.lines
            .iter()
            .flatten()
            .any(|line| line.frequency.is_some())
    }
}
