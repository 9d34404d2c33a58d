//! The report as text: aligned, readable without colour.

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
        let (lines, failures) = (self.lines().count(), self.failures());
        writeln!(
            f,
            "\n{} of {lines} lines pass, {failures} fail ({}, {:.1} s)",
            lines - failures,
            self.extent.name(),
            self.seconds
        )
    }
}

impl Report {
    /// Widths of the columns but the first and the last, in characters.
    fn widths(&self) -> [usize; 5] {
        let mut widths = [0; 5];
        for row in self.findings.iter().flat_map(rows) {
            let cells = [row.check, &row.what, row.against, &row.value, &row.bound];
            // What could not be carried out says why, at length.
            let skip = row.against.is_empty();
            for (column, (width, cell)) in widths.iter_mut().zip(cells).enumerate() {
                if !(skip && column == 1) {
                    *width = (*width).max(cell.chars().count());
                }
            }
        }
        widths
    }
}

fn rows(finding: &super::Finding) -> impl Iterator<Item = Row> {
    finding.lines.iter().map(|line| Row {
        verdict: if line.passed() { "pass" } else { "FAIL" },
        check: finding.check,
        what: line.what.clone(),
        against: line.against,
        value: number(line.value),
        bound: line.bound.to_string(),
        unit: line.unit,
    })
}
