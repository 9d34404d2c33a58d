//! Which section of phase space the samples of poincare.parquet lie on, in words.

use super::error::PlotError;
use crate::report::numbers::number;
use crate::store::ResultTable;

/// A section.
pub(super) struct Section {
    /// `at mesh phase 0`, for the label of an axis.
    pub words: String,
    /// Whether δ is the same for all its samples, so that only the rate tells them apart.
    pub fixed_deflection: bool,
}

impl Section {
    /// The section of a table's samples, which is that of the first: a job has one.
    pub fn of(table: &ResultTable) -> Result<Self, PlotError> {
        let kind = table.text("section")?.into_iter().flatten().next();
        let words = match kind.as_deref() {
            Some("entry") => "on entry into drive contact".to_owned(),
            Some("maximum" | "minimum") => "at extrema of the deflection".to_owned(),
            _ => {
                let phase = table.f64("phase")?.into_iter().flatten().next();
                format!("at mesh phase {}", number(phase.unwrap_or(0.0)))
            }
        };
        Ok(Self {
            words,
            fixed_deflection: kind.as_deref() == Some("entry"),
        })
    }
}
