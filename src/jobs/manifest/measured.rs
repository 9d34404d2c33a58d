//! Measured points: a text file with a header line of names and units, read like the lists of points of a manifest.

use super::ManifestErrors;
use super::csv::{self, ListOf, SheetColumn};
use super::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use super::text;
use crate::units;
use std::path::{Path, PathBuf};

const POINTS: ListOf = ListOf {
    path: "measured points",
    row: "",
    header: "speed [rpm],deflection_rms [um],stderr [um]",
};

/// Measured points.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// File.
    pub path: PathBuf,
    /// Values of the axis: the first column.
    pub axis: MeasuredColumn,
    /// Measured quantity: the second column.
    pub value: MeasuredColumn,
    /// Standard errors, none negative: the third column, if any. Its unit has the dimension of the values.
    pub stderr: Option<MeasuredColumn>,
}

/// A column of measured points.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredColumn {
    /// Name.
    pub name: String,
    /// Unit; `None` for numbers in SI.
    pub unit: Option<String>,
    /// One number per point.
    pub numbers: Vec<f64>,
}

impl MeasuredColumn {
    /// The numbers in the SI unit `si`; `None` if their unit has another dimension.
    pub fn in_si(&self, si: &str) -> Option<Vec<f64>> {
        let factor = match self.unit.as_deref() {
            None => 1.0,
            Some(unit) if unit == si => 1.0,
            Some(unit) => units::conversion(unit, si)?,
        };
        Some(self.numbers.iter().map(|number| number * factor).collect())
    }
}

impl Measured {
    /// Reads a file of measured points.
    ///
    /// # Errors
    /// The file cannot be read, does not have two or three columns of numbers, has an unknown unit, or a negative
    /// standard error. Every fault has its place in the file.
    pub fn read(path: &Path) -> Result<Self, ManifestErrors> {
        let issues = Issues::default();
        let columns = sheet(&issues, path).map(Vec::into_iter);
        if let Some(mut columns) = columns.filter(|_| issues.count() == 0)
            && let (Some(axis), Some(value)) = (columns.next(), columns.next())
        {
            return Ok(Self {
                path: path.to_path_buf(),
                axis: axis.into(),
                value: value.into(),
                stderr: columns.next().map(MeasuredColumn::from),
            });
        }
        Err(ManifestErrors::new(issues))
    }
}

impl From<SheetColumn> for MeasuredColumn {
    fn from(column: SheetColumn) -> Self {
        Self {
            name: column.name,
            unit: column.unit.map(|(unit, _)| unit),
            numbers: column.cells.iter().map(|cell| cell.1).collect(),
        }
    }
}

/// The columns of a file; `None` if its text has faults. All faults are recorded, also those of returned columns.
fn sheet(issues: &Issues, path: &Path) -> Option<Vec<SheetColumn>> {
    let source = text::read(issues, path, "the list of measured points");
    let named = (POINTS.path, "the measured points", &*path.to_string_lossy());
    let remedy = "check the path; measured points are a text file in UTF-8";
    let source = text::or_report(issues, source, named, remedy)?;
    let columns = csv::read(source, &issues.text(source), &POINTS, issues)?;
    check_columns(issues, &columns);
    Some(columns)
}

/// Records faults in the columns of a file.
fn check_columns(issues: &Issues, columns: &[SheetColumn]) {
    let header = format!("begin with a header such as {}", POINTS.header);
    let refuse = |kind, span, message: String| {
        let fault = Diagnostic::new(kind, span, POINTS.path, message);
        issues.push(fault.label("here").remedy(&*header));
    };
    if !(2..=3).contains(&columns.len()) {
        let message = format!(
            "measured points need an axis, a value and perhaps its standard error, but the number of columns is {}",
            columns.len()
        );
        let last = &columns[columns.len().min(4) - 1];
        refuse(DiagnosticKind::Inconsistent, last.span, message);
    }
    for (unit, span) in columns.iter().filter_map(|column| column.unit.as_ref()) {
        if units::conversion(unit, unit).is_none() {
            let message = format!("`{unit}` is not a known unit");
            refuse(DiagnosticKind::WrongUnit, *span, message);
        }
    }
    let [_, value, stderr] = columns else { return };
    let [of_value, of_stderr] =
        [value, stderr].map(|column| column.unit.as_ref().map_or("", |(unit, _)| unit.as_str()));
    if of_value != of_stderr && units::conversion(of_stderr, of_value).is_none() {
        let message = format!(
            "the standard error `{}` has another unit than `{}`",
            stderr.name, value.name
        );
        refuse(DiagnosticKind::WrongUnit, stderr.span, message);
    }
    if let Some((span, number, _)) = stderr.cells.iter().find(|cell| cell.1 < 0.0) {
        let message = format!("the standard error {number} is negative");
        refuse(DiagnosticKind::OutOfRange, *span, message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Measured, ManifestErrors> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        std::fs::write(&path, text).unwrap();
        Measured::read(&path)
    }

    #[test]
    fn columns_keep_their_units_and_become_si() {
        let found = read("speed [rpm];harmonics[1] [um];stderr [nm]\n3000;2.5;100\n6000;3;0\n");
        let found = found.unwrap();
        assert_eq!(found.value.name, "harmonics[1]");
        let speed = found.axis.in_si("rad/s").unwrap();
        assert!((speed[0] / std::f64::consts::PI - 100.0).abs() < 1e-12);
        let values = found.value.in_si("m").unwrap();
        assert!((values[0] - 2.5e-6).abs() < 1e-20 && (values[1] - 3e-6).abs() < 1e-20);
        let stderr = found.stderr.unwrap().in_si("m").unwrap();
        assert!((stderr[0] - 1e-7).abs() < 1e-20 && stderr[1] == 0.0);
        assert_eq!(found.axis.in_si("m"), None);
        let bare = read("load,lambda_max\n0.1,0.2\n").unwrap();
        assert_eq!(bare.value.in_si("1/cycle"), Some(vec![0.2]));
        assert_eq!(bare.stderr, None);
    }

    #[test]
    fn faults_stand_where_they_are() {
        for (text, kind, line, column) in [
            ("speed [rpm]\n1\n", DiagnosticKind::Inconsistent, 1, 1),
            ("a,b,c,d\n1,2,3,4\n", DiagnosticKind::Inconsistent, 1, 7),
            (
                "a [rpm],b [furlong]\n1,2\n",
                DiagnosticKind::WrongUnit,
                1,
                12,
            ),
            (
                "a,b [um],c [rpm]\n1,2,3\n",
                DiagnosticKind::WrongUnit,
                1,
                10,
            ),
            ("a,b,c\n1,2,3\n1,2,-3\n", DiagnosticKind::OutOfRange, 3, 5),
            ("a,b\n1,x\n", DiagnosticKind::WrongType, 2, 3),
            ("", DiagnosticKind::Empty, 1, 1),
        ] {
            let errors = read(text).unwrap_err();
            let found = &errors.diagnostics[0];
            assert_eq!(
                (found.kind, found.line, found.column),
                (kind, line, column),
                "{text}"
            );
            assert!(found.remedy.is_some(), "{text}");
        }
        let missing = Measured::read(Path::new("no-such-file.csv")).unwrap_err();
        assert!(
            missing
                .to_string()
                .contains("`no-such-file.csv` cannot be read")
        );
    }
}
