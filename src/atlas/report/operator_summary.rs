//! What the bases of kernels are like: their size beside that of dyadic tables of the same model,
//! condition numbers, what a propagator loses when it is rebuilt from its basis.

use std::fmt::Write;

use serde::Serialize;

use super::numbers::{number, size_text};
use crate::propagate::DYADIC_BYTES;
use crate::store::{CacheKind, MappedTable};

/// Arrays of operators.
const OPERATORS: [&str; 2] = ["inverse", "matrix"];

/// The bases of a kernel's table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OperatorSummary {
    /// Bases of segments in contact, and of free flight.
    pub bases: [usize; 2],
    /// Operators \[bytes\].
    pub bytes: u64,
    /// Tables of the dyadic kernel for the same model at one speed, in cells of one length
    /// \[bytes\].
    pub dyadic_bytes: u64,
    /// Largest condition number of an eigenvector basis, in contact and in free flight.
    pub condition: [f64; 2],
    /// Largest error of a propagator rebuilt from its basis, relative to its largest entry, in
    /// contact and in free flight.
    pub reconstruction: [f64; 2],
}

impl OperatorSummary {
    /// The summary of a table; none where it holds no bases.
    pub fn of(table: &MappedTable) -> Option<Self> {
        if table.header().kind != CacheKind::Bases {
            return None;
        }
        let values = |name: &str| table.array(name).ok().map(|(_, values)| values);
        let touching = values("touching")?;
        let of = |contact: bool, name: &str| -> Option<(usize, f64)> {
            let own = touching.iter().zip(values(name)?);
            let own = own.filter(|(touching, _)| (**touching == 1.0) == contact);
            Some(own.fold((0, 0.0), |(count, most), (_, value)| {
                (count + 1, value.max(most))
            }))
        };
        let [contact, free] = [of(true, "condition")?, of(false, "condition")?];
        let bytes = |name: &str| values(name).map_or(0, |values| size_of_val(values) as u64);
        Some(Self {
            bases: [contact.0, free.0],
            bytes: OPERATORS.into_iter().map(bytes).sum(),
            dyadic_bytes: *values(DYADIC_BYTES)?.first()? as u64,
            condition: [contact.1, free.1],
            reconstruction: [
                of(true, "reconstruction")?.1,
                of(false, "reconstruction")?.1,
            ],
        })
    }

    /// Adds the lines of the summary.
    pub(super) fn render(&self, text: &mut String) {
        let ([contact, free], [own, dyadic]) = (self.bases, [self.bytes, self.dyadic_bytes]);
        let ratio = dyadic as f64 / own as f64;
        let pair = |values: [f64; 2]| {
            let [contact, free] = values.map(number);
            format!("up to {contact} in contact, {free} in free flight")
        };
        for (name, value) in [
            (
                "bases",
                format!("{contact} of contact, {free} of free flight"),
            ),
            (
                "operators",
                format!(
                    "{}; dyadic tables of the same model: {} ({ratio:.1} times) a speed",
                    size_text(own),
                    size_text(dyadic)
                ),
            ),
            ("condition", pair(self.condition)),
            ("rebuilt to", pair(self.reconstruction)),
        ] {
            _ = writeln!(text, "{name:<13}{value}");
        }
    }
}
