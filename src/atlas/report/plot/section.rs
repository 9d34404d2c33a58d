//! On which section of phase space are the samples of poincare.parquet, and in which quantities do they differ?

use super::error::PlotError;
use crate::report::numbers::number;
use crate::store::ResultTable;

/// A quantity of a sample: column of poincare.parquet, and its name on an axis.
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
    /// `at mesh phase 0`.
    pub words: String,
    /// Two quantities in which its samples differ, the second with more information. All samples at entries or releases
    /// have one deflection, those at an extreme one rate, and those of a strobe one phase.
    pub plane: [Quantity; 2],
}

impl Section {
    /// The section of a table's samples: that of the first, because a job has only one.
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
