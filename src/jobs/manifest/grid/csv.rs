//! A list of points as a spreadsheet writes it: a head line with names and units, `speed [rpm]`, then a line of
//! numbers a point. Columns are parted by commas, semicolons or tabs; empty lines and lines that begin with `#`
//! count for nothing.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};

/// A sheet of numbers.
#[derive(Debug)]
pub(super) struct Sheet {
    pub columns: Vec<SheetColumn>,
}

/// A column of a sheet.
#[derive(Debug)]
pub(super) struct SheetColumn {
    pub name: String,
    pub span: Span,
    pub unit: Option<(String, Span)>,
    /// Where each number stands, the number, and how it is written.
    pub cells: Vec<(Span, f64, String)>,
}

/// A stretch of the text without blanks and quotes around it.
#[derive(Debug, Clone, Copy)]
struct Cell<'t> {
    text: &'t str,
    start: usize,
}

/// The columns of a text; none where it has faults, reported.
pub(super) fn read(source: usize, text: &str, issues: &mut Issues) -> Option<Sheet> {
    let span = |start: usize, length: usize| Span {
        source,
        start,
        end: start + length,
    };
    let fault = |kind, at: Span, message: String| Diagnostic::new(kind, at, "grid.points", message);
    let mut lines = lines(text);
    let Some((start, head)) = lines.next() else {
        let nothing = fault(
            DiagnosticKind::Empty,
            span(0, 0),
            "the list of points is empty".to_owned(),
        );
        issues.push(nothing.label("no entries").remedy(
            "begin with a header line of names and units, such as speed [rpm],torque [N m]; then give one line of numbers per point",
        ));
        return None;
    };
    let parting = *[',', ';', '\t']
        .iter()
        .find(|c| head.contains(**c))
        .unwrap_or(&',');
    let mut columns: Vec<SheetColumn> = Vec::new();
    for cell in cells(head, start, parting) {
        let (name, unit) = match cell.text.split_once('[') {
            None => (cell.text, None),
            Some((name, rest)) => {
                let at = cell.start + name.len() + 1;
                let Some(unit) = rest.trim_end().strip_suffix(']') else {
                    let open = fault(
                        DiagnosticKind::Syntax,
                        span(cell.start, cell.text.len()),
                        format!("the bracket of the unit in `{}` is not closed", cell.text),
                    );
                    issues.push(
                        open.label("no ]")
                            .remedy("write the unit in brackets, such as speed [rpm]"),
                    );
                    return None;
                };
                let own = (unit.trim().to_owned(), span(at, unit.len()));
                // A ratio has no unit, or 1.
                (
                    name.trim_end(),
                    (!["", "1", "-"].contains(&own.0.as_str())).then_some(own),
                )
            }
        };
        let at = span(cell.start, cell.text.len());
        let twice = columns.iter().any(|column| column.name == name);
        if name.is_empty() || twice {
            let (kind, message, label, remedy) = if twice {
                (
                    DiagnosticKind::DuplicateKey,
                    format!("the column `{name}` is given twice"),
                    "second time",
                    "keep one of the two",
                )
            } else {
                (
                    DiagnosticKind::UnknownAxis,
                    "a column has no name".to_owned(),
                    "here",
                    "name the column after an axis of the grid, or remove it",
                )
            };
            issues.push(fault(kind, at, message).label(label).remedy(remedy));
            return None;
        }
        columns.push(SheetColumn {
            name: name.to_owned(),
            span: span(cell.start, name.len()),
            unit,
            cells: Vec::new(),
        });
    }
    let before = issues.count();
    let mut points = 0;
    for (start, line) in lines {
        let found: Vec<Cell<'_>> = cells(line, start, parting).collect();
        if found.len() != columns.len() {
            let message = format!(
                "a line has {} values, but the header has {} columns",
                found.len(),
                columns.len()
            );
            let remedy = match parting {
                ',' if found.len() > columns.len() => {
                    "give one value per column; write numbers with a decimal point"
                }
                _ => "give one value per column",
            };
            let wrong = fault(
                DiagnosticKind::Inconsistent,
                span(start, line.len()),
                message,
            );
            issues.push(wrong.label("this line").remedy(remedy));
            continue;
        }
        points += 1;
        for (column, cell) in columns.iter_mut().zip(found) {
            let at = span(cell.start, cell.text.len());
            match cell.text.parse::<f64>() {
                Ok(number) if number.is_finite() => {
                    column.cells.push((at, number, cell.text.to_owned()));
                }
                _ => {
                    let message = match cell.text {
                        "" => format!("`{}` has no value here", column.name),
                        text => format!("`{text}` of `{}` is not a number", column.name),
                    };
                    let remedy = if cell.text.contains(',') {
                        format!(
                            "write it with a decimal point: {}",
                            cell.text.replace(',', ".")
                        )
                    } else {
                        "give a number; the unit belongs in the header of the column, such as speed [rpm]"
                                .to_owned()
                    };
                    issues.push(
                        fault(DiagnosticKind::WrongType, at, message)
                            .label("not a number")
                            .remedy(remedy),
                    );
                }
            }
        }
    }
    if points == 0 && issues.count() == before {
        let none = fault(
            DiagnosticKind::Empty,
            span(start, head.len()),
            "the list has a header but no points".to_owned(),
        );
        issues.push(
            none.label("no lines below")
                .remedy("give at least one line of numbers"),
        );
    }
    (issues.count() == before).then_some(Sheet { columns })
}

/// The lines that count, each with the place where it starts.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut next = 0;
    text.split_inclusive('\n')
        .map(move |line| {
            let start = next;
            next += line.len();
            // Some spreadsheets begin a file with a byte order mark.
            let own = line.strip_prefix('\u{feff}').unwrap_or(line);
            (start + line.len() - own.len(), own.trim_end())
        })
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// The cells of a line; quotes about a cell are dropped.
fn cells(line: &str, start: usize, parting: char) -> impl Iterator<Item = Cell<'_>> {
    let mut next = start;
    line.split(parting).map(move |cell| {
        let mut at = next + (cell.len() - cell.trim_start().len());
        next += cell.len() + 1;
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

    fn sheet(text: &str) -> Result<Sheet, Issues> {
        let mut issues = Issues::default();
        let source = issues.add_source("p.csv".to_owned(), text.to_owned());
        read(source, text, &mut issues).ok_or(issues)
    }

    #[test]
    fn spreadsheets_write_it_in_several_ways() {
        for text in [
            "speed [rpm],load\n1000,0.1\n2000,-2e-1\n",
            "\u{feff}\"speed [rpm]\";load [-]\r\n\r\n# a remark\r\n1000;0.1\r\n2000; -2e-1",
            "speed [rpm]\tload\n 1000\t 0.1\n2000\t\"-2e-1\"\n",
        ] {
            let sheet = sheet(text).unwrap();
            let [speed, load] = &sheet.columns[..] else {
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
    fn faults_stand_where_they_are() {
        for (text, spot, remedy) in [
            ("", "", "begin with"),
            ("speed,load\n", "speed,load", "at least one line"),
            ("speed,load\n1,2,3\n", "1,2,3", "decimal point"),
            ("speed;load\n1;0,5\n", "0,5", "0.5"),
            ("speed,load\n1,\n", "", "give a number"),
            ("speed,speed\n1,2\n", "speed", "keep one"),
            ("speed [rpm,load\n1,2\n", "speed [rpm", "brackets"),
            ("speed,load\n1,nan\n", "nan", "give a number"),
        ] {
            let issues = sheet(text).unwrap_err();
            let fault = &issues.found[0];
            assert_eq!(&text[fault.span.start..fault.span.end], spot, "{text}");
            assert!(fault.remedy.as_ref().unwrap().contains(remedy), "{fault:?}");
        }
    }
}
