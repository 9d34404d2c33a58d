//! Counts of points whose standard errors are not verified, for the line below a title.

use crate::report::PointSummary;
use crate::report::numbers::plural;

/// Number of points that have averages with standard errors, and number of these whose errors are not verified.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Evidence {
    known: usize,
    unverified: usize,
}

impl Evidence {
    /// The evidence of some points.
    pub fn of<'p>(points: impl IntoIterator<Item = &'p PointSummary>) -> Self {
        let mut evidence = Self::default();
        for point in points {
            evidence.known += usize::from(point.errors_verified.is_some());
            evidence.unverified += usize::from(point.errors_verified == Some(false));
        }
        evidence
    }

    /// The evidence of these points and others.
    pub fn and(self, other: Self) -> Self {
        Self {
            known: self.known + other.known,
            unverified: self.unverified + other.unverified,
        }
    }

    /// Words for the line below a title; empty if all standard errors are verified.
    pub fn words(self) -> String {
        match self.unverified {
            0 => String::new(),
            all if all == self.known => "errors not verified".into(),
            some => format!("errors of {} not verified", plural(some, "point")),
        }
    }
}
