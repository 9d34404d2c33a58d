//! The columns that covariant vectors add to `points.parquet`.

use super::PointRow;
use super::table::{Column, columns};
use crate::analysis::AngleOutcome;

impl PointRow {
    fn angle(&self) -> Option<&AngleOutcome> {
        self.covariant.as_ref()?.angle.as_ref()
    }
}

/// The columns of covariant vectors in `points.parquet`.
pub(super) fn covariant_columns() -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        list "covariant_exponents", "1/cycle", &*row.covariant.as_ref()?.exponents,
            "Mean growth of each covariant Lyapunov vector";
        list "covariant_exponents_stderr", "1/cycle", &*row.covariant.as_ref()?.errors,
            "Standard error of each value of covariant_exponents, from block averages";
        list "covariant_exponents_spread", "1/cycle", &*row.covariant.as_ref()?.spreads,
            "Standard deviation of the growth of each vector over a single mesh cycle";
        u32 "unstable_directions", "1", row.covariant.as_ref()?.unstable,
            "Number of covariant vectors that grow by more than two standard errors";
        u32 "stable_directions", "1", row.covariant.as_ref()?.stable,
            "Number of computed covariant vectors that shrink by more than two standard errors";
        f64 "angle_min", "rad", row.angle()?.min,
            "Smallest angle between the spaces of growing and of shrinking directions, in the energy norm";
        f64 "angle_mean", "rad", row.angle()?.mean, "Mean of that angle, sampled once per mesh cycle";
        f64 "angle_mean_stderr", "rad", row.angle()?.stderr,
            "Standard error of angle_mean, from block averages";
        list "angle_quantiles", "rad", &*row.angle()?.quantiles,
            "1, 10, 50, 90 and 99 % quantiles of that angle";
    ]
}
