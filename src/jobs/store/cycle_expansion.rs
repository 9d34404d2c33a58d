//! The columns of `cycle_expansion.parquet`.

use super::table::{Table, columns};
use crate::analysis::{ExpansionAverage, ExpansionOrder};
use std::sync::Arc;

/// A row of `cycle_expansion.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpansionRow {
    /// The point.
    pub point_id: u64,
    /// Mesh cycles that the orbits took, over which time averages are.
    pub cycles: u64,
    /// The order, without its averages.
    pub order: Arc<ExpansionOrder>,
    /// An average at this order.
    pub average: ExpansionAverage,
}

/// Columns of `cycle_expansion.parquet`.
pub fn cycle_expansion_table() -> Table<ExpansionRow> {
    const UNIT: &str = "m (deflection), N (forces), 1 (fraction_free) or 1/cycle";
    Table::new(columns![row: ExpansionRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        u32 "order", "mesh cycles", row.order.order,
            "Period up to which orbits are taken";
        u32 "orbits", "1", row.order.orbits,
            "Unstable prime orbits of this very period on the chaotic set";
        f64 "unseen", "1", row.order.unseen,
            "How many more there may be, by how many of them one search and two found (Chao)";
        u32 "apart", "1", row.order.apart,
            "Unstable prime orbits of this period that the trajectory does not come near, left out";
        u64 "searches", "1", row.order.searches, "Newton searches for this period";
        u64 "closed", "1", row.order.closed, "Searches that ended on an orbit, of this or a shorter period";
        f64 "entropy", "1/cycle", row.order.entropy,
            "Topological entropy: growth rate of the number of points that return";
        f64 "conservation", "1", row.order.conservation,
            "Sum of 1/|det(1 - M)| over the points of this period; 1 where all are there and far from neutral";
        f64 "escape_zeta", "1/cycle", row.order.escape_zeta,
            "Escape rate by the dynamical zeta function, 0 where no orbit is missing; null where it has no zero";
        f64 "escape_determinant", "1/cycle", row.order.escape_determinant,
            "The same by the spectral determinant";
        text "quantity", "", row.average.quantity.name(),
            "deflection_mean, deflection_rms, contact_force: of the force that presses flanks together, cycle_peak: mean of its largest value in each mesh cycle, fraction_free, events_per_cycle, lambda_max";
        f64 "zeta", UNIT, row.average.zeta?.value, "Average by the dynamical zeta function";
        f64 "zeta_error", UNIT, row.average.zeta?.error,
            "Change from the order before plus change without orbits that a single search found";
        f64 "determinant", UNIT, row.average.determinant?.value, "Average by the spectral determinant";
        f64 "determinant_error", UNIT, row.average.determinant?.error, "Its error, as of zeta";
        f64 "plain", UNIT, row.average.plain?.value,
            "Average over the points of this period with weights 1/|det(1 - M)|";
        f64 "plain_error", UNIT, row.average.plain?.error, "Its error, as of zeta";
        f64 "time", UNIT, row.average.time.value, "Average over time";
        f64 "time_stderr", UNIT, row.average.time.error, "Its standard error";
        u64 "cycles", "mesh cycles", row.cycles,
            "Integrated for the orbits, by the searches with all tangents; the time averages are over as many";
    ])
}
