//! Which of the standard errors that a picture shows are verified?

use crate::report::PointSummary;
use crate::report::numbers::plural;

/// How many points have averages with standard errors, and of how many these are not verified.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Evidence {
    known: usize,
    unverified: usize,
}

impl Evidence {
    /// Of some points.
    pub fn of<'p>(points: impl IntoIterator<Item = &'p PointSummary>) -> Self {
        let mut evidence = Self::default();
        for point in points {
            evidence.known += usize::from(point.errors_verified.is_some());
            evidence.unverified += usize::from(point.errors_verified == Some(false));
        }
        evidence
    }

    /// Of these points and others.
    pub fn and(self, other: Self) -> Self {
        Self {
            known: self.known + other.known,
            unverified: self.unverified + other.unverified,
        }
    }

    /// For the line below a title; empty where all standard errors are verified.
    pub fn words(self) -> String {
        match self.unverified {
            0 => String::new(),
            all if all == self.known => "errors not verified".into(),
            some => format!("errors of {} not verified", plural(some, "point")),
        }
    }
}
