//! The columns that a chain adds to `points.parquet`, and `transitions.parquet` with the changes of motion
//! between neighbours of a chain.

use super::chain_part::Transition;
use super::point_row::{AxisColumn, PointRow};
use super::table::{Column, Table, columns};

/// Name of a direction in result files.
pub(super) fn direction(upwards: bool) -> &'static str {
    if upwards { "up" } else { "down" }
}

/// The column of `points.parquet` that distinguishes the two sweeps along one axis.
pub(super) fn direction_columns(axis: &AxisColumn) -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        text "direction", "", row.chain.as_ref().map(|chain| direction(chain.upwards)),
            &format!("Sweep along {}: up or down; each point starts from the final state of the previous point", axis.name);
    ]
}

/// A row of `transitions.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct TransitionRow {
    /// The first point after the change.
    pub point_id: u64,
    /// Name of the swept axis.
    pub axis: String,
    /// Whether the sweep runs towards larger values.
    pub upwards: bool,
    /// The change.
    pub transition: Transition,
}

/// The row of a point, if the motion changes at it.
pub(super) fn transition_rows(point: &mut PointRow, axis: &AxisColumn) -> Vec<TransitionRow> {
    let row = || {
        let chain = point.chain.as_ref()?;
        Some(TransitionRow {
            point_id: point.point_id,
            axis: axis.name.clone(),
            upwards: chain.upwards,
            transition: chain.transition?,
        })
    };
    row().into_iter().collect()
}

/// Columns of `transitions.parquet`; `lower` and `upper` have the swept axis's unit.
pub fn transitions_table(axis: &AxisColumn) -> Table<TransitionRow> {
    let unit = &axis.unit;
    Table::new(columns![row: TransitionRow;
        u64 "point_id", "1", row.point_id,
            "First grid point after the change, in sweep order";
        text "axis", "", row.axis.as_str(), "Swept axis";
        text "direction", "", direction(row.upwards), "Sweep along the axis: up or down";
        text "from_class", "", row.transition.from.name(),
            "Class of motion before the change, in sweep order";
        text "what", "", row.transition.what(),
            "Quantity that changes: class, period, or deflection (a jump at constant class and period)";
        u32 "from_period", "mesh cycles", row.transition.from.period(),
            "Period before the change; null if the motion has none";
        text "to_class", "", row.transition.to.name(), "Class of motion after the change";
        u32 "to_period", "mesh cycles", row.transition.to.period(), "Period after the change; null if the motion has none";
        f64 "lower", unit, row.transition.bracket[0].min(row.transition.bracket[1]),
            "Smaller of the two values of the swept axis that bracket the change";
        f64 "upper", unit, row.transition.bracket[0].max(row.transition.bracket[1]),
            "Larger of the two values of the swept axis that bracket the change";
        f64 "from_deflection_mean", "m", row.transition.jump?[0].mean[0],
            "Mean deflection before a jump; null for other changes";
        f64 "to_deflection_mean", "m", row.transition.jump?[1].mean[0], "Mean deflection after a jump; null for other changes";
        f64 "from_deflection_rms", "m", row.transition.jump?[0].rms[0],
            "RMS of the deflection about its mean before a jump; null for other changes";
        f64 "to_deflection_rms", "m", row.transition.jump?[1].rms[0], "RMS of the deflection about its mean \
                                                                       after a jump; null for other changes";
        u32 "trials", "1", row.transition.trials,
            "Number of points added between points of the grid to narrow the bracket; 0 without refinement";
    ])
}
