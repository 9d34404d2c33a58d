//! Followed orbits of a folder: the tables of branches, bifurcations and curves that `atlas follow` wrote.

mod summary;

use std::collections::BTreeMap;
use std::path::Path;

use super::error::ReportError;
use super::point::Axis;
use crate::input::printable;
use crate::store::{ResultTable, TableKind, table_path};

pub use summary::FollowedSummary;

/// The three tables of followed orbits, in memory.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Followed {
    pub job: Option<String>,
    /// The axes, each with the values that occur among the orbits, ascending.
    pub axes: Vec<Axis>,
    /// Units of the axes in the manifest, by name.
    pub units: BTreeMap<String, String>,
    /// Index of the axis over which orbits are followed.
    pub over: usize,
    /// Index of the second axis of the bifurcation curves; `None` without curves.
    pub second: Option<usize>,
    /// Indices of the axes whose values are expressions of the axes `over` and `second`.
    derived: Vec<usize>,
    /// Orbits of every branch, by the number of the branch, in order along it.
    pub branches: BTreeMap<u64, Vec<Orbit>>,
    /// Bifurcations of all branches, and their ends.
    pub bifurcations: Vec<Bifurcation>,
    /// Bifurcation curves, by their numbers.
    pub curves: BTreeMap<u64, Curve>,
}

/// An orbit of a branch.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Orbit {
    /// Value of every axis.
    pub at: Vec<f64>,
    /// Period in mesh cycles.
    pub period: u64,
    pub stable: bool,
    /// Changes of contact over a period, in order.
    pub sequence: String,
    /// Root mean square deflection \[m\].
    pub rms: f64,
}

/// A bifurcation of a branch, or one of its ends.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bifurcation {
    /// Value of every axis.
    pub at: Vec<f64>,
    pub branch: u64,
    /// Index of the orbit before the bifurcation.
    pub after: usize,
    pub kind: String,
    pub detail: String,
    /// Root mean square deflection \[m\].
    pub rms: f64,
}

/// A bifurcation curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    pub kind: String,
    /// Points along the curve: the value of every axis, and a note, if any.
    pub points: Vec<(Vec<f64>, Option<String>)>,
}

impl Bifurcation {
    /// Whether this row is an end of the branch instead of a bifurcation.
    pub fn is_end(&self) -> bool {
        self.kind == "end"
    }

    /// The reason for the end of the branch, without the place and the origin of the branch. `None` if this
    /// is no end, or if it is the first orbit of a branch that is followed in one direction only.
    pub fn end(&self) -> Option<&str> {
        let reason = self.detail.split("; from ").next()?.split(": ").next()?;
        (self.is_end() && reason != "its first orbit").then_some(reason)
    }
}

impl Curve {
    /// Bifurcations of codimension two on the curve: values of the axes, and the note. A note at an end of a
    /// curve is excluded, because it gives the reason for the end. A curve of the onset of rattle has none.
    pub fn codimension_two(&self) -> impl Iterator<Item = (&[f64], &str)> {
        let inner = self.points.len().saturating_sub(1);
        let points = self.points.iter().take(inner).skip(1);
        let noted = points.filter_map(|(at, note)| Some((&at[..], note.as_deref()?)));
        noted.filter(|_| self.kind != "onset")
    }
}

/// The axes that are fixed in a picture, with their values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FixedValues {
    /// Name and value of each fixed axis.
    pub values: Vec<(String, f64)>,
    places: Vec<usize>,
}

impl FixedValues {
    /// Whether a row of the tables has these values.
    pub fn holds(&self, at: &[f64]) -> bool {
        let fixed = self.places.iter().zip(&self.values);
        fixed
            .clone()
            .all(|(&place, (_, value))| at[place] == *value)
    }

    /// Whether the values `at` of the axes `names`, possibly in another order, agree with the fixed values.
    pub fn holds_named(&self, names: &[String], at: &[f64]) -> bool {
        self.values.iter().all(|(name, value)| {
            let place = names.iter().position(|known| known == name);
            place.is_some_and(|place| (at[place] - value).abs() <= 1e-9 * value.abs())
        })
    }
}

impl Followed {
    /// Reads the tables; `None` if the folder has no followed orbits.
    ///
    /// # Errors
    /// A table cannot be read, a value is missing, or the followed axis is not named.
    pub fn read(folder: &Path) -> Result<Option<Self>, ReportError> {
        let Some(table) = ResultTable::read_if_there(folder, TableKind::Branches)? else {
            return Ok(None);
        };
        let names = table.axes()?;
        let axis = |name: &str| names.iter().position(|axis| axis == name);
        let place = |key: &str| axis(table.metadata(key)?);
        let derived = table.metadata("derived").unwrap_or("[]");
        let derived: Vec<String> = serde_json::from_str(derived).unwrap_or_default();
        let over = place("over").ok_or_else(|| ReportError::NoFollowedAxis {
            path: table_path(folder, TableKind::Branches, None),
        })?;
        let mut branches: BTreeMap<u64, Vec<Orbit>> = BTreeMap::new();
        let table_rows = Rows::of(folder, &table, &names)?;
        let (numbers, stable) = (table_rows.whole("branch")?, table.bool("stable")?);
        let (periods, rms) = (
            table_rows.whole("period")?,
            table_rows.numbers("deflection_rms")?,
        );
        let sequences = table_rows.texts("sequence")?;
        for (row, at) in table_rows.at.iter().enumerate() {
            branches.entry(numbers[row]).or_default().push(Orbit {
                at: at.clone(),
                period: periods[row],
                stable: stable[row].unwrap_or_default(),
                sequence: sequences[row].clone(),
                rms: rms[row],
            });
        }
        let units = table.units()?;
        let values = |place: usize| {
            let mut axis_values: Vec<f64> = table_rows.at.iter().map(|at| at[place]).collect();
            axis_values.sort_by(f64::total_cmp);
            axis_values.dedup();
            axis_values
        };
        let axes = names.iter().enumerate().map(|(place, name)| Axis {
            name: printable(name).into_owned(),
            unit: printable(units.get(name).map_or("", String::as_str)).into_owned(),
            values: values(place),
        });
        Ok(Some(Self {
            job: table.metadata("job").map(|job| printable(job).into_owned()),
            axes: axes.collect(),
            units: table.axis_units(),
            over,
            second: place("second"),
            derived: derived.iter().filter_map(|name| axis(name)).collect(),
            branches,
            bifurcations: bifurcations(folder, &names)?,
            curves: curves(folder, &names)?,
        }))
    }

    /// The axis over which orbits are followed.
    pub fn axis(&self) -> &Axis {
        &self.axes[self.over]
    }

    /// The lines on which orbits are followed: the combinations of values of all axes except the followed one.
    pub fn lines(&self) -> Vec<FixedValues> {
        self.fixed_values(
            &[self.over],
            self.branches.values().flatten().map(|o| &o.at[..]),
        )
    }

    /// The planes of the curves: the combinations of values of all axes except the two axes of the curves.
    pub fn planes(&self, second: usize) -> Vec<FixedValues> {
        let points = self.curves.values().flat_map(|curve| &curve.points);
        self.fixed_values(&[self.over, second], points.map(|(at, _)| &at[..]))
    }

    fn fixed_values<'a>(
        &self,
        free: &[usize],
        axis_values: impl Iterator<Item = &'a [f64]>,
    ) -> Vec<FixedValues> {
        let places: Vec<usize> = (0..self.axes.len())
            .filter(|i| !free.contains(i) && !self.derived.contains(i))
            .collect();
        let mut all: Vec<Vec<f64>> = Vec::new();
        for at in axis_values {
            let values: Vec<f64> = places.iter().map(|&place| at[place]).collect();
            if all.last() != Some(&values) {
                all.push(values);
            }
        }
        all.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        all.dedup();
        let named = |values: Vec<f64>| {
            let names = places.iter().map(|&place| self.axes[place].name.clone());
            names.zip(values).collect()
        };
        let held = all.into_iter().map(|values| FixedValues {
            values: named(values),
            places: places.clone(),
        });
        held.collect()
    }
}

fn bifurcations(folder: &Path, names: &[String]) -> Result<Vec<Bifurcation>, ReportError> {
    let table = ResultTable::read(folder, TableKind::Bifurcations)?;
    let table_rows = Rows::of(folder, &table, names)?;
    let (branches, after) = (table_rows.whole("branch")?, table_rows.whole("after")?);
    let (kinds, details) = (table_rows.texts("kind")?, table_rows.texts("detail")?);
    let rms = table_rows.numbers("deflection_rms")?;
    let rows = table_rows
        .at
        .iter()
        .enumerate()
        .map(|(row, at)| Bifurcation {
            at: at.clone(),
            branch: branches[row],
            after: after[row] as usize,
            kind: kinds[row].clone(),
            detail: details[row].clone(),
            rms: rms[row],
        });
    Ok(rows.collect())
}

fn curves(folder: &Path, names: &[String]) -> Result<BTreeMap<u64, Curve>, ReportError> {
    let mut curves: BTreeMap<u64, Curve> = BTreeMap::new();
    let Some(table) = ResultTable::read_if_there(folder, TableKind::Curves)? else {
        return Ok(curves);
    };
    let table_rows = Rows::of(folder, &table, names)?;
    let (numbers, kinds) = (table_rows.whole("curve")?, table_rows.texts("kind")?);
    let notes = table.text("note")?;
    for (row, at) in table_rows.at.iter().enumerate() {
        let curve = curves.entry(numbers[row]).or_insert_with(|| Curve {
            kind: kinds[row].clone(),
            points: Vec::new(),
        });
        curve.points.push((at.clone(), notes[row].clone()));
    }
    Ok(curves)
}

/// Access to the columns of a table in which nulls are errors, and the values of the axes, row by row.
struct Rows<'t> {
    folder: &'t Path,
    table: &'t ResultTable,
    at: Vec<Vec<f64>>,
}

impl<'t> Rows<'t> {
    fn of(folder: &'t Path, table: &'t ResultTable, names: &[String]) -> Result<Self, ReportError> {
        let mut rows = Self {
            folder,
            table,
            at: vec![Vec::with_capacity(names.len()); table.rows()],
        };
        for name in names {
            for (at, value) in rows
                .at
                .iter_mut()
                .zip(non_null_values(folder, table, name)?)
            {
                at.push(value);
            }
        }
        Ok(rows)
    }

    fn whole(&self, name: &str) -> Result<Vec<u64>, ReportError> {
        filled(self.folder, name, self.table.u64(name)?)
    }

    fn numbers(&self, name: &str) -> Result<Vec<f64>, ReportError> {
        non_null_values(self.folder, self.table, name)
    }

    fn texts(&self, name: &str) -> Result<Vec<String>, ReportError> {
        filled(self.folder, name, self.table.text(name)?)
    }
}

fn non_null_values(
    folder: &Path,
    table: &ResultTable,
    name: &str,
) -> Result<Vec<f64>, ReportError> {
    filled(folder, name, table.f64(name)?)
}

fn filled<T>(folder: &Path, name: &str, column: Vec<Option<T>>) -> Result<Vec<T>, ReportError> {
    let all: Option<Vec<T>> = column.into_iter().collect();
    all.ok_or_else(|| ReportError::Incomplete {
        folder: folder.to_path_buf(),
        column: printable(name).into_owned(),
    })
}
