//! A results folder, prepared for pictures: its summary, the other tables, and slices of the grid over one or
//! two axes.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use super::axis::Axis;
use super::axis_units::AxisUnits;
use super::canvas::Canvas;
use super::error::PlotError;
use super::picture::{Drawn, Picture};
use super::picture_kind::PictureKind;
use crate::report::numbers::{number, plural};
use crate::report::point::varied;
use crate::report::{Axis as GridAxis, PointSummary, Summary};
use crate::store::{ResultTable, RunState, StoreError, TableKind, read_runs, verify};

/// Largest number of slices drawn per kind of picture.
pub(super) const MOST_SLICES: usize = 24;

/// A results folder, read for pictures.
pub(super) struct Results {
    pub folder: PathBuf,
    pub summary: Summary,
    pub job: String,
    /// Unit of every column of points.parquet.
    pub units: BTreeMap<String, String>,
    /// RMS of the deflection about its mean of every point \[m\], if measured, in the order of `summary.all`.
    /// Empty if the folder has no table whose pictures need it.
    pub deflection_rms: Vec<Option<f64>>,
    /// A note on missing parts of the results, if any.
    caveat: Option<String>,
    /// Units of axes in pictures.
    pub shown: AxisUnits,
}

/// Points with the same values on all fixed axes of a picture.
pub(super) struct Slice<'a> {
    pub points: Vec<&'a PointSummary>,
    /// The fixed axes with their values, and the size: `load 0.1  ·  60 points`.
    pub words: String,
    /// The fixed axes for a file name, `-load=0.1`; empty if there is only one slice.
    pub suffix: String,
    /// Indices of the fixed axes, with their values.
    pub fixed_values: Vec<(usize, f64)>,
}

impl Results {
    /// Reads a folder. Axes have the first of `units` that fits them, else the unit of the manifest.
    pub fn read(folder: &Path, units: &[String]) -> Result<Self, PlotError> {
        // The available pictures depend on the tables that exist. The check of the records finds a lost
        // table, which would otherwise look like a table that the job did not request.
        let runs = read_runs(folder)?;
        for run in &runs {
            verify(folder, run)?;
        }
        let summary = Summary::with_points(folder)?;
        let of_columns = ResultTable::head(folder, TableKind::Points)?.units()?;
        let mut deflection_rms = Vec::new();
        let of_points = [TableKind::Poincare, TableKind::Spectra, TableKind::Branches];
        if (of_points.iter()).any(|kind| folder.join(kind.file_name()).exists()) {
            let columns = ["point_id", "deflection_rms"];
            ResultTable::scan(folder, TableKind::Points, &columns, |part| {
                let ids = part.u64("point_id")?.into_iter();
                deflection_rms.extend(ids.zip(part.f64("deflection_rms")?));
                Ok::<_, StoreError>(())
            })?;
            deflection_rms.sort_by_key(|(id, _)| *id);
        }
        let name = folder.file_name().map(|name| name.to_string_lossy());
        let job = summary.job.clone().or(name.map(Into::into));
        let caveat = match summary.state {
            Some(RunState::Complete) => None,
            Some(RunState::Interrupted) if summary.points as u64 == summary.expected => summary
                .shards
                .map(|[found, all]| format!("incomplete: {found} of {all} shards")),
            Some(RunState::Interrupted) => Some(format!(
                "interrupted: {} of {} points",
                summary.points, summary.expected
            )),
            None => Some("without run.json: may be incomplete".into()),
        };
        Ok(Self {
            shown: AxisUnits::new(&summary.axes, &summary.units, units),
            folder: folder.to_path_buf(),
            job: job.unwrap_or_default(),
            units: of_columns,
            deflection_rms: deflection_rms.into_iter().map(|(_, value)| value).collect(),
            summary,
            caveat,
        })
    }

    /// A table besides the points; `None` if it does not exist.
    pub fn table(&self, kind: TableKind) -> Result<Option<ResultTable>, PlotError> {
        Ok(ResultTable::read_if_there(&self.folder, kind)?)
    }

    /// A table that a kind of picture needs.
    pub fn needed(&self, kind: TableKind, what: PictureKind) -> Result<ResultTable, PlotError> {
        let reason = || format!("there is no {}; {}", kind.file_name(), kind.remedy());
        self.table(kind)?.ok_or_else(|| what.unfit(reason()))
    }

    /// The head of a table besides the points, without its rows; `None` if it does not exist.
    pub fn head(&self, kind: TableKind) -> Result<Option<ResultTable>, PlotError> {
        Ok(StoreError::if_there(ResultTable::head(&self.folder, kind))?)
    }

    /// Unit of a column of points.parquet.
    pub fn unit(&self, column: &str) -> &str {
        self.units.get(column).map_or("", String::as_str)
    }

    /// Indices of the axes with more than one value, slowest first.
    pub fn varied(&self) -> Vec<usize> {
        varied(&self.summary.axes).collect()
    }

    /// Indices of the axes with more than one value that maps use, slowest first.
    pub fn spanning(&self) -> Vec<usize> {
        let Summary { axes, tied, .. } = &self.summary;
        let free = tied.free(axes.len()).into_iter();
        free.filter(|&axis| axes[axis].values.len() > 1).collect()
    }

    /// The axis for a picture over one axis: the named axis, else the swept axis, else the axis with most
    /// values. If several axes have equally many, the fastest of them.
    pub fn along(&self, what: PictureKind, name: Option<&str>) -> Result<usize, PlotError> {
        let varied = self.varied();
        let axis = |index: &usize| &self.summary.axes[*index];
        let swept = self.summary.carried_along.as_deref();
        // A sweep that has only begun has one value of its axis.
        let swept = swept.filter(|swept| varied.iter().any(|index| axis(index).name == *swept));
        match name.or(swept) {
            Some(name) => varied
                .iter()
                .copied()
                .find(|index| axis(index).name == name)
                .ok_or_else(|| PlotError::UnknownAxis {
                    name: name.to_owned(),
                    known: if varied.is_empty() {
                        "none".into()
                    } else {
                        let names: Vec<&str> =
                            varied.iter().map(|i| axis(i).name.as_str()).collect();
                        names.join(", ")
                    },
                }),
            None => varied
                .iter()
                .copied()
                .max_by_key(|index| axis(index).values.len())
                .ok_or_else(|| what.unfit("no grid axis has more than one value")),
        }
    }

    /// As [`Self::along`], but an axis with a single value is allowed too. Without a name, the axis is not
    /// `except`.
    pub fn along_any(&self, name: Option<&str>, except: Option<&str>) -> Result<usize, PlotError> {
        let axes = &self.summary.axes;
        let swept = self.summary.carried_along.as_deref();
        match name.or(swept.filter(|swept| Some(*swept) != except)) {
            Some(name) => (axes.iter().position(|axis| axis.name == name)).ok_or_else(|| {
                let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
                PlotError::NoAxis {
                    name: name.to_owned(),
                    folder: self.folder.clone(),
                    known: names.join(", "),
                }
            }),
            None => (0..axes.len())
                .filter(|&index| Some(axes[index].name.as_str()) != except)
                .max_by_key(|&index| axes[index].values.len())
                .ok_or_else(|| PlotError::NoOtherAxis {
                    folder: self.folder.clone(),
                    except: except.map(str::to_owned),
                }),
        }
    }

    /// The slices of the grid over the axes `free`, in the order of the values on the fixed axes, and their
    /// number. Sweeps up and down are separate slices. At most [`MOST_SLICES`] slices are returned; the
    /// number counts all.
    pub fn slices(&self, free: &[usize]) -> (Vec<Slice<'_>>, usize) {
        self.cut(free, true)
    }

    /// As [`Self::slices`], with sweeps up and down in one slice.
    pub fn slices_of_both(&self, free: &[usize]) -> (Vec<Slice<'_>>, usize) {
        self.cut(free, false)
    }

    fn cut(&self, free: &[usize], by_direction: bool) -> (Vec<Slice<'_>>, usize) {
        let axes = &self.summary.axes;
        let fixed_axes = self.summary.tied.fixed_axes(axes.len(), free);
        let values = |point: &PointSummary| -> Vec<f64> {
            fixed_axes
                .iter()
                .map(|&index| point.axis_values[index])
                .collect()
        };
        type Key<'p> = (Vec<f64>, Option<&'p str>);
        let mut all: Vec<(Key<'_>, Vec<&PointSummary>)> = Vec::new();
        let mut slice_index: HashMap<(Vec<u64>, Option<&str>), usize> = HashMap::new();
        let several = self.directions().len() > 1;
        for point in &self.summary.all {
            let key = values(point);
            let direction = point
                .direction
                .as_deref()
                .filter(|_| by_direction && several);
            let bits = key.iter().map(|value| value.to_bits()).collect();
            let index = *slice_index.entry((bits, direction)).or_insert(all.len());
            match all.get_mut(index) {
                Some((_, points)) => points.push(point),
                None => all.push(((key, direction), vec![point])),
            }
        }
        // The sort is stable: of two slices with equal values, the one with the first point stays first.
        all.sort_by(|((a, _), _), ((b, _), _)| {
            let order = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
            order.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        });
        let count = all.len();
        let slices = all
            .into_iter()
            .take(MOST_SLICES)
            .map(|((key, direction), points)| {
                let axes_with_values = || fixed_axes.iter().map(|&index| &axes[index]).zip(&key);
                let swept = direction.map(|direction| format!("sweep {direction}"));
                let words: Vec<String> = axes_with_values()
                    .map(|(axis, value)| self.axis_value_text(axis, *value))
                    .chain(swept)
                    .collect();
                let parts: Vec<String> = axes_with_values()
                    .filter(|(axis, _)| axis.values.len() > 1)
                    .map(|(axis, value)| format!("{}={}", axis.name, distinct(axis, *value)))
                    .chain(direction.map(str::to_owned))
                    .collect();
                let mut count_words = plural(points.len(), "point");
                if let Some(refined) = &self.summary.refined {
                    let [rows, columns] = refined.nested.sides(refined.nested.levels);
                    count_words += &format!(" of {rows} x {columns} positions");
                }
                Slice {
                    points,
                    fixed_values: fixed_axes
                        .iter()
                        .copied()
                        .zip(key.iter().copied())
                        .collect(),
                    words: if words.is_empty() {
                        count_words
                    } else {
                        format!("{}  ·  {count_words}", words.join(", "))
                    },
                    suffix: if parts.is_empty() {
                        String::new()
                    } else {
                        format!("-{}", parts.join(","))
                    },
                }
            });
        (slices.collect(), count)
    }

    /// Axes on which the points of a slice differ, except the axes `free`: tied axes that are not fixed. Empty
    /// if the first free axis is the swept one, because the points of a chain form one line.
    pub fn companion_axes(&self, free: &[usize]) -> Vec<usize> {
        let Summary {
            axes,
            tied,
            carried_along,
            ..
        } = &self.summary;
        let is_chain = |&axis: &usize| Some(&axes[axis].name) == carried_along.as_ref();
        if free.first().is_some_and(is_chain) {
            return Vec::new();
        }
        let fixed_axes = tied.fixed_axes(axes.len(), free);
        let mut varied = self.varied();
        varied.retain(|axis| !free.contains(axis) && !fixed_axes.contains(axis));
        varied
    }

    /// Lines through the points of a slice over its first axis, as indices of `points`. Points with different
    /// values on [`Self::companion_axes`] are on different lines.
    pub fn lines(&self, free: &[usize], points: &[&PointSummary]) -> Vec<Vec<usize>> {
        let others = self.companion_axes(free);
        let mut lines: BTreeMap<Vec<u64>, Vec<usize>> = BTreeMap::new();
        for (place, point) in points.iter().enumerate() {
            let key = others.iter().map(|&axis| point.axis_values[axis].to_bits());
            lines.entry(key.collect()).or_default().push(place);
        }
        let along = |place: &usize| points[*place].axis_values[free[0]];
        for line in lines.values_mut() {
            line.sort_by(|a, b| along(a).total_cmp(&along(b)));
        }
        lines.into_values().collect()
    }

    /// Text that names the companion axes and says whether lines join points with equal values on them; empty
    /// without companion axes.
    pub fn lines_words(&self, free: &[usize], points: &[&PointSummary]) -> String {
        let others = self.companion_axes(free);
        let names: Vec<&str> = (others.iter())
            .map(|&axis| self.summary.axes[axis].name.as_str())
            .collect();
        let names = names.join(", ");
        match self.lines(free, points).iter().any(|line| line.len() > 1) {
            _ if others.is_empty() => String::new(),
            true => format!("lines join points with the same {names}"),
            false => format!("points also differ in {names}"),
        }
    }

    /// The directions of the sweeps, `up` before `down`; empty if points are independent.
    pub fn directions(&self) -> Vec<&str> {
        let occurs = |word: &&str| {
            let mut points = self.summary.all.iter();
            points.any(|point| point.direction.as_deref() == Some(*word))
        };
        ["up", "down"].into_iter().filter(occurs).collect()
    }

    /// The line below a title: the given parts, and the note on missing parts of the results.
    pub fn subtitle(&self, parts: &[&str]) -> String {
        let caveat = self.caveat.as_deref();
        let parts = parts.iter().copied().chain(caveat);
        let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
        parts.join("  ·  ")
    }

    /// A canvas with the job and a title, and `parts` in the line below it.
    pub fn canvas(&self, title: &str, parts: &[&str]) -> Canvas {
        Canvas::titled(&format!("{}: {title}", self.job), &self.subtitle(parts))
    }

    /// Draws one picture per slice of the grid; its name is the kind and the suffix of the slice.
    pub fn by_slice<'s>(
        &self,
        what: PictureKind,
        (slices, all): (Vec<Slice<'s>>, usize),
        mut draw: impl FnMut(&Slice<'s>) -> Canvas,
    ) -> Drawn {
        let mut drawn = Drawn::sliced(what.name(), slices.len(), all);
        for slice in &slices {
            let name = format!("{}{}", what.name(), slice.suffix);
            drawn.pictures.push(Picture::new(name, draw(slice)));
        }
        drawn
    }

    /// The index of a point in the summary.
    pub fn place(&self, point_id: u64) -> Option<usize> {
        let points = &self.summary.all;
        (points.binary_search_by_key(&point_id, |point| point.point_id)).ok()
    }

    /// The axis of a picture for a grid axis, in its shown unit. `make` makes it from name and SI unit.
    pub fn axis(&self, axis: &GridAxis, make: impl FnOnce(&str, &str) -> Axis) -> Axis {
        self.shown.axis(axis, make)
    }

    /// A value of an axis as text: `speed 6000 rpm`.
    pub fn axis_value_text(&self, axis: &GridAxis, value: f64) -> String {
        self.shown.words(axis, value)
    }

    /// The point with a number.
    pub fn point(&self, point_id: u64) -> Result<&PointSummary, PlotError> {
        (self.place(point_id).map(|place| &self.summary.all[place]))
            .ok_or(PlotError::UnknownPoint { point_id })
    }

    /// A point as text: `point 45: load 0.1, speed 1108 rad/s  ·  chaotic`.
    pub fn point_words(&self, point: &PointSummary) -> String {
        let values = self.summary.axes.iter().zip(&point.axis_values);
        let values: Vec<String> = values
            .map(|(axis, value)| self.axis_value_text(axis, *value))
            .chain(point.direction.as_ref().map(|word| format!("sweep {word}")))
            .collect();
        let motion = super::motion::Motion::of(point).name();
        if values.is_empty() {
            format!("point {}: {motion}", point.point_id)
        } else {
            format!(
                "point {}: {}  ·  {motion}",
                point.point_id,
                values.join(", ")
            )
        }
    }
}

/// A value of an axis as text, with four digits, or with all digits if four do not distinguish the values of
/// the axis.
pub(super) fn distinct(axis: &GridAxis, value: f64) -> String {
    let text = number(value);
    let same = axis.values.iter().filter(|other| number(**other) == text);
    if same.count() > 1 { format!("{value:e}") } else { text }
}
