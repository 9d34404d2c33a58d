//! A list of points as a spreadsheet writes it: a header line with names and units, `speed [rpm]`, then a line of
//! numbers per point. Commas, semicolons or tabs separate columns, except in quotes and in indices in brackets.
//! Empty lines and lines that begin with `#` are ignored.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};

/// Characters that may separate columns. The first of these that occurs in the header separates the columns of a list.
const SEPARATORS: [char; 3] = [',', ';', '\t'];

/// Texts for messages about a list of points.
#[derive(Debug)]
pub(super) struct ListOf {
    /// The key that holds the list or names its file.
    pub path: &'static str,
    /// Example of a point in the manifest.
    pub row: &'static str,
    /// Example of a header line of a file.
    pub header: &'static str,
}

/// A unit with its place, if any.
type Unit = Option<(String, Span)>;

/// A column of numbers.
#[derive(Debug)]
pub(super) struct SheetColumn {
    pub name: String,
    pub span: Span,
    pub unit: Unit,
    /// Place, value and text of each number.
    pub cells: Vec<(Span, f64, String)>,
}

/// Text of a cell without surrounding blanks and quotes, and the byte at which it starts.
#[derive(Debug, Clone, Copy)]
struct Cell<'t> {
    text: &'t str,
    start: usize,
}

/// The columns of a text; `None` if it has faults, which are reported.
pub(super) fn read(
    source: usize,
    text: &str,
    list: &ListOf,
    issues: &Issues,
) -> Option<Vec<SheetColumn>> {
    let before = issues.count();
    let mut lines = lines(text);
    let Some((start, head)) = lines.next() else {
        let at = Cell { text: "", start: 0 };
        let mut reader = Reader::new(source, ',', list, issues);
        let message = "the list of points is empty".to_owned();
        let remedy = format!(
            "begin with a header line of names and units, such as {}; then give one line of numbers per point",
            list.header
        );
        reader.fault(DiagnosticKind::Empty, at, message, "no entries", remedy);
        return None;
    };
    let parting = (SEPARATORS.into_iter())
        .find(|wanted| separators(head).any(|(_, separator)| separator == *wanted));
    let mut reader = Reader::new(source, parting.unwrap_or(','), list, issues);
    let mut columns = reader.header(start, head)?;
    let mut points = 0;
    for (start, line) in lines {
        points += usize::from(reader.line(start, line, &mut columns));
    }
    if points == 0 && reader.issues.count() == before {
        let message = "the list has a header but no points".to_owned();
        let (at, remedy) = (
            Cell { text: head, start },
            "give at least one line of numbers",
        );
        reader.fault(DiagnosticKind::Empty, at, message, "no lines below", remedy);
    }
    (reader.issues.count() == before).then_some(columns)
}

/// Reads lines and reports their faults.
struct Reader<'i> {
    source: usize,
    parting: char,
    list: &'i ListOf,
    issues: &'i Issues,
}

impl<'i> Reader<'i> {
    fn new(source: usize, parting: char, list: &'i ListOf, issues: &'i Issues) -> Self {
        Self {
            source,
            parting,
            list,
            issues,
        }
    }

    fn span(&self, start: usize, length: usize) -> Span {
        Span {
            source: self.source,
            start,
            end: start + length,
        }
    }

    fn fault(
        &mut self,
        kind: DiagnosticKind,
        at: Cell<'_>,
        message: String,
        label: &str,
        remedy: impl Into<String>,
    ) {
        let at = self.span(at.start, at.text.len());
        let diagnostic = Diagnostic::new(kind, at, self.list.path, message);
        self.issues.push(diagnostic.label(label).remedy(remedy));
    }

    /// The columns that a header line names, without numbers; `None` after a fault, which is reported.
    fn header(&mut self, start: usize, head: &str) -> Option<Vec<SheetColumn>> {
        let mut columns: Vec<SheetColumn> = Vec::new();
        for cell in cells(head, start, self.parting) {
            let (name, unit) = self.name_and_unit(cell)?;
            if name.is_empty() {
                let message = "a column has no name".to_owned();
                let remedy = "name the column, or remove it";
                self.fault(DiagnosticKind::UnknownAxis, cell, message, "here", remedy);
                return None;
            }
            if columns.iter().any(|column| column.name == name) {
                let message = format!("the column `{name}` is given twice");
                let (kind, remedy) = (DiagnosticKind::DuplicateKey, "keep one of the two");
                self.fault(kind, cell, message, "second time", remedy);
                return None;
            }
            columns.push(SheetColumn {
                name: name.to_owned(),
                span: self.span(cell.start, name.len()),
                unit,
                cells: Vec::new(),
            });
        }
        Some(columns)
    }

    /// Name of a column and its unit. The unit is in the last brackets. Earlier brackets belong to the name, and so do
    /// indices directly after it: `harmonics[1] [um]`, `stiffness_matrix[1,2]`. `None` if a bracket is not closed.
    fn name_and_unit<'t>(&mut self, cell: Cell<'t>) -> Option<(&'t str, Unit)> {
        let Some((name, rest)) = cell.text.rsplit_once('[') else {
            return Some((cell.text, None));
        };
        let Some(unit) = rest.trim_end().strip_suffix(']') else {
            let message = format!("the bracket of the unit in `{}` is not closed", cell.text);
            let remedy = "write the unit in brackets, such as speed [rpm]";
            self.fault(DiagnosticKind::Syntax, cell, message, "no ]", remedy);
            return None;
        };
        let is_index = !unit.is_empty() && unit.bytes().all(|b| b.is_ascii_digit() || b == b',');
        if is_index && name.ends_with(|c: char| !c.is_whitespace()) {
            return Some((cell.text, None));
        }
        let span = self.span(cell.start + name.len() + 1, unit.len());
        let unit = unit.trim();
        // A ratio has an empty unit, or 1.
        let has_unit = !["", "1", "-"].contains(&unit);
        Some((name.trim_end(), has_unit.then(|| (unit.to_owned(), span))))
    }

    /// Adds the numbers of a line to their columns. Returns whether the line has one cell per column.
    fn line(&mut self, start: usize, line: &str, columns: &mut [SheetColumn]) -> bool {
        let found: Vec<Cell<'_>> = cells(line, start, self.parting).collect();
        let (given, expected) = (found.len(), columns.len());
        if given != expected {
            let message =
                format!("a line has {given} values, but the header has {expected} columns");
            let remedy = if self.parting == ',' && given > expected {
                "give one value per column; write numbers with a decimal point"
            } else {
                "give one value per column"
            };
            let at = Cell { text: line, start };
            self.fault(
                DiagnosticKind::Inconsistent,
                at,
                message,
                "this line",
                remedy,
            );
            return false;
        }
        for (column, cell) in columns.iter_mut().zip(found) {
            self.number(cell, column);
        }
        true
    }

    /// Adds a number to its column, or reports that the cell is not a finite number.
    fn number(&mut self, cell: Cell<'_>, column: &mut SheetColumn) {
        let Cell { text, start } = cell;
        if let Some(number) = text.parse().ok().filter(|number: &f64| number.is_finite()) {
            let at = self.span(start, text.len());
            column.cells.push((at, number, text.to_owned()));
            return;
        }
        let message = match text {
            "" => format!("`{}` has no value here", column.name),
            text => format!("`{text}` of `{}` is not a number", column.name),
        };
        let remedy = if text.contains(',') {
            format!("write it with a decimal point: {}", text.replace(',', "."))
        } else {
            "give a number; the unit belongs in the header of the column, such as speed [rpm]"
                .to_owned()
        };
        self.fault(
            DiagnosticKind::WrongType,
            cell,
            message,
            "not a number",
            remedy,
        );
    }
}

/// The lines that are not ignored, each with the byte at which it starts.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut next = 0;
    text.split_inclusive('\n')
        .map(move |line| {
            let start = next;
            next += line.len();
            // Some spreadsheets start a file with a byte order mark.
            let content = line.strip_prefix('\u{feff}').unwrap_or(line);
            (start + line.len() - content.len(), content.trim_end())
        })
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// The separators of a line with their bytes, except those in quotes around a cell and in indices in brackets.
fn separators(line: &str) -> impl Iterator<Item = (usize, char)> {
    let (mut end, mut cell_begins) = (0, true);
    line.char_indices().filter(move |&(at, character)| {
        if at < end {
            return false;
        }
        let rest = &line[at + character.len_utf8()..];
        let is_of_index = |c: char| c.is_ascii_digit() || c == ',';
        let length = match character {
            '"' if cell_begins => rest.find('"'),
            '[' => rest
                .find(|c: char| !is_of_index(c))
                .filter(|&length| rest[length..].starts_with(']')),
            _ => None,
        };
        end = length.map_or(at, |length| at + 1 + length);
        let separates = SEPARATORS.contains(&character);
        cell_begins = separates || cell_begins && character.is_whitespace();
        separates
    })
}

/// The cells of a line, without quotes around them.
fn cells(line: &str, start: usize, parting: char) -> impl Iterator<Item = Cell<'_>> {
    let ends = separators(line).filter(move |(_, separator)| *separator == parting);
    let mut next = 0;
    ends.map(|(end, _)| end)
        .chain([line.len()])
        .map(move |end| {
            let cell = &line[next..end];
            let mut at = start + next + (cell.len() - cell.trim_start().len());
            next = end + 1;
            let trimmed = cell.trim();
            let bare = trimmed
                .strip_prefix('"')
                .and_then(|rest| rest.strip_suffix('"'));
            at += usize::from(bare.is_some());
            Cell {
                text: bare.unwrap_or(trimmed),
                start: at,
            }
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(text: &str) -> Result<Vec<SheetColumn>, Issues> {
        let issues = Issues::default();
        let source = issues.add_source("p.csv".to_owned(), text.to_owned());
        let list = ListOf {
            path: "grid.points",
            row: "",
            header: "speed [rpm]",
        };
        read(source, text, &list, &issues).ok_or(issues)
    }

    #[test]
    fn spreadsheets_write_it_in_several_ways() {
        for text in [
            "speed [rpm],load\n1000,0.1\n2000,-2e-1\n",
            "\u{feff}\"speed [rpm]\";load [-]\r\n\r\n# a remark\r\n1000;0.1\r\n2000; -2e-1",
            "speed [rpm]\tload\n 1000\t 0.1\n2000\t\"-2e-1\"\n",
        ] {
            let sheet = sheet(text).unwrap();
            let [speed, load] = &sheet[..] else {
                panic!("{text}")
            };
            assert_eq!((speed.name.as_str(), load.name.as_str()), ("speed", "load"));
            assert_eq!(speed.unit.as_ref().unwrap().0, "rpm");
            assert!(load.unit.is_none());
            let numbers: Vec<f64> = load.cells.iter().map(|cell| cell.1).collect();
            assert_eq!(numbers, [0.1, -0.2]);
            for column in [speed, load] {
                for (span, _, typed) in &column.cells {
                    assert_eq!(&text[span.start..span.end], typed);
                }
                let span = column.span;
                assert_eq!(text[span.start..span.end], column.name);
            }
        }
    }

    #[test]
    fn indices_belong_to_the_name() {
        for (text, names, units) in [
            (
                "m[1,2];speed [rpm]\n1;2\n",
                ["m[1,2]", "speed"],
                [None, Some("rpm")],
            ),
            (
                "\"m[1,2]\",f[1]\n1,\"2\"\n",
                ["m[1,2]", "f[1]"],
                [None, None],
            ),
            (
                "f[2] [rad/s],load [1]\n1,2\n",
                ["f[2]", "load"],
                [Some("rad/s"), None],
            ),
        ] {
            let sheet = sheet(text).unwrap();
            let found: Vec<&str> = sheet.iter().map(|column| column.name.as_str()).collect();
            let unit = |column: &SheetColumn| column.unit.as_ref().map(|(unit, _)| unit.clone());
            assert_eq!(found, names, "{text}");
            assert_eq!(
                sheet.iter().map(unit).collect::<Vec<_>>(),
                units.map(|unit| unit.map(str::to_owned)),
                "{text}"
            );
            assert_eq!(
                sheet.iter().map(|column| column.cells[0].1).sum::<f64>(),
                3.0
            );
        }
    }

    #[test]
    fn faults_stand_where_they_are() {
        for (text, spot, remedy) in [
            ("", "", "begin with"),
            ("speed,load\n", "speed,load", "at least one line"),
            ("speed,load\n1,2,3\n", "1,2,3", "decimal point"),
            ("speed;load\n1;0,5\n", "0,5", "0.5"),
            ("speed,load\n1,\"0,5\"\n", "0,5", "0.5"),
            ("speed,load\n1,\n", "", "give a number"),
            ("speed,speed\n1,2\n", "speed", "keep one"),
            ("speed [rpm,load\n1,2\n", "speed [rpm", "brackets"),
            ("speed,load\n1,nan\n", "nan", "give a number"),
        ] {
            let issues = sheet(text).unwrap_err();
            let fault = &issues.found.borrow()[0];
            assert_eq!(&text[fault.span.start..fault.span.end], spot, "{text}");
            assert!(fault.remedy.as_ref().unwrap().contains(remedy), "{fault:?}");
        }
    }
}
