//! The section of phase space on which the samples of poincare.parquet lie, and the quantities that vary on
//! it.

use super::error::PlotError;
use crate::report::numbers::number;
use crate::store::ResultTable;

/// A quantity of a sample: its column in poincare.parquet, its name on an axis, and its symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Quantity {
    pub column: &'static str,
    pub name: &'static str,
    pub symbol: &'static str,
}

const PHASE: Quantity = Quantity {
    column: "phase",
    name: "mesh phase",
    symbol: "φ",
};
const DEFLECTION: Quantity = Quantity {
    column: "deflection",
    name: "deflection",
    symbol: "δ",
};
const RATE: Quantity = Quantity {
    column: "velocity",
    name: "rate of the deflection",
    symbol: "δ'",
};

/// A section.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Section {
    /// The section as text: `at mesh phase 0`.
    pub words: String,
    /// Two quantities that vary on the section; a bifurcation diagram shows the second. All samples at entries or
    /// releases have about the same deflection, those at extrema the same rate, and those of a strobe the same
    /// phase.
    pub plane: [Quantity; 2],
}

impl Section {
    /// The section of the samples of a table. It is that of the first sample, because a job has only one
    /// section.
    pub fn of(table: &ResultTable) -> Result<Self, PlotError> {
        let kind = table.text("section")?.into_iter().flatten().next();
        let phase = table.f64("phase")?.into_iter().flatten().next();
        Ok(Self::named(kind.as_deref(), phase.unwrap_or(0.0)))
    }

    fn named(kind: Option<&str>, phase: f64) -> Self {
        let (words, plane) = match kind {
            Some("entry") => ("on entry into drive contact".to_owned(), [PHASE, RATE]),
            Some("release") => ("where drive contact ends".to_owned(), [PHASE, RATE]),
            Some("coast_entry") => ("on entry into coast contact".to_owned(), [PHASE, RATE]),
            Some("coast_release") => ("where coast contact ends".to_owned(), [PHASE, RATE]),
            Some("maximum" | "minimum") => (
                "at extrema of the deflection".to_owned(),
                [PHASE, DEFLECTION],
            ),
            Some("force_maximum") => (
                "at maxima of the mesh force".to_owned(),
                [PHASE, DEFLECTION],
            ),
            Some("surface_up" | "surface_down") => {
                ("on the given surface".to_owned(), [RATE, DEFLECTION])
            }
            _ => (
                format!("at mesh phase {}", number(phase)),
                [RATE, DEFLECTION],
            ),
        };
        Self { words, plane }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_section_is_drawn_over_what_is_one_value_on_it() {
        let columns = |kind| Section::named(Some(kind), 0.25).plane.map(|q| q.column);
        assert_eq!(columns("entry"), ["phase", "velocity"]);
        assert_eq!(columns("release"), ["phase", "velocity"]);
        assert_eq!(columns("coast_entry"), ["phase", "velocity"]);
        assert_eq!(columns("force_maximum"), ["phase", "deflection"]);
        assert_eq!(columns("maximum"), ["phase", "deflection"]);
        assert_eq!(columns("minimum"), ["phase", "deflection"]);
        assert_eq!(columns("strobe"), ["velocity", "deflection"]);
        assert_eq!(Section::named(None, 0.25).words, "at mesh phase 0.25");
    }
}
