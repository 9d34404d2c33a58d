//! Results of the checks: lines with a value and its bound.

use super::{CheckError, Extent};
use serde::{Serialize, Serializer};
use std::fmt;

/// Bound of a value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// At most this value.
    AtMost(f64),
    /// From the first value to the second one, both included.
    Between(f64, f64),
}

impl Bound {
    /// Whether a value satisfies the bound. NaN never does.
    pub fn holds(self, value: f64) -> bool {
        match self {
            Self::AtMost(most) => value <= most,
            Self::Between(low, high) => (low..=high).contains(&value),
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(most) => write!(f, "<= {}", number(*most)),
            Self::Between(low, high) => write!(f, "{} .. {}", number(*low), number(*high)),
        }
    }
}

/// A number in the format of the report. It is short, and a nonzero number is never shown as zero.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-2..1e4).contains(&size) {
        let text = format!("{value:.3}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        text.to_owned()
    } else {
        let text = format!("{value:.1e}");
        text.replace(".0e", "e")
    }
}

/// The larger of two deviations. NaN counts as larger than any number.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() { a } else { b }
}

/// The number of drives of a check that were tested with a kernel, in words.
pub(super) fn drives_of(tested: usize, all: usize) -> String {
    if tested == all {
        format!("{all} drives")
    } else {
        format!("{tested} of {all} drives")
    }
}

/// One comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Compared quantity.
    pub what: String,
    /// Reference.
    pub against: &'static str,
    /// Value: a difference, or the compared quantity if the bound is a range.
    pub value: f64,
    /// Bound of the value.
    pub bound: Bound,
    /// Unit of the value and its bound.
    pub unit: &'static str,
    /// Whether the comparison was skipped, for the reason in `against`. It then neither passes nor fails.
    pub skipped: bool,
}

impl Line {
    /// A value that may be at most `most`.
    pub fn at_most(
        what: impl Into<String>,
        against: &'static str,
        value: f64,
        most: f64,
        unit: &'static str,
    ) -> Self {
        Self {
            what: what.into(),
            against,
            value,
            bound: Bound::AtMost(most),
            unit,
            skipped: false,
        }
    }

    /// A value that must lie between two others.
    pub fn between(
        what: impl Into<String>,
        against: &'static str,
        value: f64,
        range: [f64; 2],
        unit: &'static str,
    ) -> Self {
        Self {
            bound: Bound::Between(range[0], range[1]),
            ..Self::at_most(what, against, value, 0.0, unit)
        }
    }

    /// The line of a comparison on a drive that the kernel does not support.
    pub(super) fn skipped(what: impl Into<String>, reason: &'static str) -> Self {
        Self {
            skipped: true,
            ..Self::at_most(what, reason, f64::NAN, 0.0, "")
        }
    }

    /// The failed line of a check that could not run.
    pub(super) fn failed(trouble: &CheckError) -> Self {
        Self::at_most(format!("not carried out: {trouble}"), "", f64::NAN, 0.0, "")
    }

    /// Whether the value satisfies its bound.
    pub fn passed(&self) -> bool {
        !self.skipped && self.bound.holds(self.value)
    }

    /// Whether the value violates its bound.
    pub fn breaks_bound(&self) -> bool {
        !self.skipped && !self.bound.holds(self.value)
    }
}

impl Serialize for Line {
    /// All fields except `skipped`, and `passed`, which is null for a skipped line. A value that is not finite becomes
    /// null.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut line = serializer.serialize_struct("Line", 6)?;
        line.serialize_field("what", &self.what)?;
        line.serialize_field("against", self.against)?;
        line.serialize_field("value", &self.value)?;
        line.serialize_field("bound", &self.bound)?;
        line.serialize_field("unit", self.unit)?;
        line.serialize_field("passed", &(!self.skipped).then(|| self.passed()))?;
        line.end()
    }
}

/// Groups of checks. Checks of exactness have bounds near round-off. Checks of fidelity have tolerances of a
/// few per cent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// Exactness: closed forms.
    ClosedForms,
    /// Exactness: structures against published frequencies and another assembly.
    Structure,
    /// Exactness: gears and their mesh tables.
    Gears,
    /// Exactness: kernels compared with independent integrators.
    Kernels,
    /// Exactness: conserved quantities.
    Balances,
    /// Exactness: tangents and exponents.
    Exponents,
    /// Exactness: equal bits.
    Bits,
    /// Fidelity: deliberate approximations.
    Fidelity,
}

impl Group {
    /// Heading of the group.
    pub fn heading(self) -> &'static str {
        match self {
            Self::ClosedForms => "Exactness: closed forms",
            Self::Structure => "Exactness: natural frequencies",
            Self::Gears => "Exactness: gears",
            Self::Kernels => "Exactness: kernels against independent integrators",
            Self::Balances => "Exactness: balances over many cycles",
            Self::Exponents => "Exactness: tangents and Lyapunov exponents",
            Self::Bits => "Exactness: equal bits",
            Self::Fidelity => "Fidelity: approximate on purpose, physical tolerances",
        }
    }
}

/// Results of one check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the check.
    pub check: &'static str,
    /// Group of its lines.
    pub group: Group,
    /// Duration of the check \[s\].
    pub seconds: f64,
    /// Results of the check, one per line of the report.
    pub lines: Vec<Line>,
}

/// Results of all checks.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// How much is verified: quick or full.
    pub extent: Extent,
    /// Duration of all checks \[s\].
    pub seconds: f64,
    /// Results by check.
    pub findings: Vec<Finding>,
}

impl Report {
    /// All lines.
    pub fn lines(&self) -> impl Iterator<Item = &Line> {
        self.findings.iter().flat_map(|finding| &finding.lines)
    }

    /// Number of lines that fail.
    pub fn failures(&self) -> usize {
        self.lines().filter(|line| line.breaks_bound()).count()
    }

    /// Number of skipped lines.
    pub fn skips(&self) -> usize {
        self.lines().filter(|line| line.skipped).count()
    }

    /// Whether some lines pass and none fails.
    pub fn passed(&self) -> bool {
        self.failures() == 0 && self.lines().any(Line::passed)
    }

    /// Exit status of a program: 0 if the report passed, else 1.
    pub fn status(&self) -> u8 {
        u8::from(!self.passed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_is_not_a_number_keeps_no_bound() {
        assert!(Bound::AtMost(0.0).holds(0.0) && !Bound::AtMost(0.0).holds(1e-300));
        assert!(Bound::Between(1.9, 2.1).holds(2.0) && !Bound::Between(1.9, 2.1).holds(2.2));
        for bound in [Bound::AtMost(f64::INFINITY), Bound::Between(-1e300, 1e300)] {
            assert!(!bound.holds(f64::NAN));
        }
        assert!(worse(f64::NAN, 1.0).is_nan() && worse(1.0, f64::NAN).is_nan());
        assert_eq!((worse(1.0, 2.0), worse(2.0, 1.0)), (2.0, 2.0));
    }

    #[test]
    fn numbers_are_short_and_never_zero_by_rounding() {
        for (value, text) in [
            (0.0, "0"),
            (1e-13, "1e-13"),
            (3.24e-16, "3.2e-16"),
            (1.9, "1.9"),
            (0.0123, "0.012"),
            (12345.0, "1.2e4"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
