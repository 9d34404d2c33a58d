//! The report as a text with aligned columns.

use super::Report;
use super::report::number;
use std::fmt::{self, Display, Formatter};

/// One line of the table, before it is aligned.
struct Row {
    verdict: &'static str,
    check: &'static str,
    what: String,
    against: &'static str,
    value: String,
    bound: String,
    unit: &'static str,
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut group = None;
        let widths = self.widths();
        for finding in &self.findings {
            if group != Some(finding.group) {
                let gap = if group.is_some() { "\n" } else { "" };
                writeln!(f, "{gap}{}", finding.group.heading())?;
                group = Some(finding.group);
            }
            for row in rows(finding) {
                let [check, what, against, value, bound] = widths;
                let line = format!(
                    "  {:4}  {:check$}  {:what$}  {:against$}  {:>value$}  {:bound$}  {}",
                    row.verdict, row.check, row.what, row.against, row.value, row.bound, row.unit
                );
                writeln!(f, "{}", line.trim_end())?;
            }
        }
        let (failures, skips) = (self.failures(), self.skips());
        let lines = self.lines().count() - skips;
        let left_out = match skips {
            0 => String::new(),
            _ => format!(", {skips} skipped"),
        };
        writeln!(
            f,
            "\n{} of {lines} lines pass, {failures} fail{left_out} ({}, {:.1} s)",
            lines - failures,
            self.extent.name(),
            self.seconds
        )
    }
}

impl Report {
    /// Widths of all columns except the first and the last, in characters.
    fn widths(&self) -> [usize; 5] {
        let mut widths = [0; 5];
        for row in self.findings.iter().flat_map(rows) {
            let cells = [row.check, &row.what, row.against, &row.value, &row.bound];
            // The reason of a failed or skipped check is a long text, which must not widen its column.
            let long = match row.verdict {
                "skip" => Some(2),
                _ => row.against.is_empty().then_some(1),
            };
            for (column, (width, cell)) in widths.iter_mut().zip(cells).enumerate() {
                if long != Some(column) {
                    *width = (*width).max(cell.chars().count());
                }
            }
        }
        widths
    }
}

fn rows(finding: &super::Finding) -> impl Iterator<Item = Row> {
    finding.lines.iter().map(|line| {
        let figure = |text: String| if line.skipped { String::new() } else { text };
        Row {
            verdict: match (line.skipped, line.passed()) {
                (true, _) => "skip",
                (false, true) => "pass",
                (false, false) => "FAIL",
            },
            check: finding.check,
            what: line.what.clone(),
            against: line.against,
            value: figure(number(line.value)),
            bound: figure(line.bound.to_string()),
            unit: line.unit,
        }
    })
}
