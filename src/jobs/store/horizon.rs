//! The columns of `horizon.parquet`, and the columns of predictability in `points.parquet`.

use super::PointRow;
use super::point_row::ResultOfPoint;
use super::table::{Column, Table, columns};
use crate::analysis::HorizonMeasure;

/// Takes the rows of a point.
pub(super) fn horizon_rows(point: &mut PointRow) -> Vec<ResultOfPoint<HorizonMeasure>> {
    let outcomes = point.horizon.iter_mut();
    let measures = outcomes.flat_map(|outcome| std::mem::take(&mut outcome.measures));
    ResultOfPoint::all(point.point_id, measures)
}

/// Columns of `horizon.parquet`.
pub fn horizon_table() -> Table<ResultOfPoint<HorizonMeasure>> {
    const UNIT: &str = "half gaps (separation), 1/cycle (exponent), N (forces) or m (deflection)";
    Table::new(columns![row: ResultOfPoint<HorizonMeasure>;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        text "quantity", "", row.result.quantity.name(),
            "separation: distance of twins; exponent: growth of a tangent vector; force, deflection: \
             averages of mesh force and deflection; contact_force: average of the force that presses flanks \
             together";
        u64 "cycles", "mesh cycles", row.result.cycles,
            "Mesh cycles since the twins started (separation), or of the average";
        f64 "value", UNIT, row.result.value, "Mean; for separations, the geometric mean";
        f64 "spread", "1 (separation), 1/cycle (exponent), N (forces) or m (deflection)", row.result.spread,
            "Standard deviation of one sample: of the natural logarithm of separations, of finite-time \
             exponents, and of averages (their standard error)";
        u64 "samples", "1", row.result.samples, "Number of twins, or of successive windows of this length";
    ])
}

/// The columns of predictability in `points.parquet`.
pub(super) fn horizon_columns() -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        f64 "horizon", "mesh cycles", row.horizon.as_ref()?.horizon,
            "Mesh cycles until the separation of twins is a tenth of the saturation; null if the motion is \
             not chaotic or the twins stay closer";
        f64 "horizon_stderr", "mesh cycles", row.horizon.as_ref()?.stderr,
            "Standard error of horizon, estimated by leaving out one twin at a time";
        f64 "saturation", "half gaps", row.horizon.as_ref()?.saturation,
            "Geometric mean distance of unrelated states of the motion, in the energy norm";
        f64 "averaging_exponent", "1", row.horizon.as_ref()?.averaging_exponent,
            "Exponent of n in the standard error of a mean contact force over n cycles; -0.5 for independent cycles";
    ]
}
