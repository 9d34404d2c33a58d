//! The columns of `horizon.parquet`, and those that predictability adds to `points.parquet`.

use super::PointRow;
use super::table::{Column, Table, Value};
use crate::analysis::{HorizonMeasure, HorizonOutcome};

/// A row of `horizon.parquet`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HorizonRow {
    /// The point.
    pub point_id: u64,
    /// A quantity over a number of mesh cycles.
    pub measure: HorizonMeasure,
}

/// Columns of `horizon.parquet`.
pub fn horizon_table() -> Table<HorizonRow> {
    const UNIT: &str = "half gaps (separation), 1/cycle (exponent), N (forces) or m (deflection)";
    Table::new(vec![
        Column::new(
            "point_id",
            "1",
            "Row-major index into the grid",
            Value::U64(Box::new(|row: &HorizonRow| Some(row.point_id))),
        ),
        Column::new(
            "quantity",
            "",
            "separation: distance of twins; exponent: growth of a tangent; force, deflection: averages of the mesh force and deflection; contact_force: of the force that presses flanks together",
            Value::Text(Box::new(|row: &HorizonRow| {
                Some(row.measure.quantity.name())
            })),
        ),
        Column::new(
            "cycles",
            "mesh cycles",
            "Since the twins started (separation), or over which growth or average is taken",
            Value::U64(Box::new(|row: &HorizonRow| Some(row.measure.cycles))),
        ),
        Column::new(
            "value",
            UNIT,
            "Mean; of separations the geometric mean",
            Value::F64(Box::new(|row: &HorizonRow| Some(row.measure.value))),
        ),
        Column::new(
            "spread",
            "1 (separation), 1/cycle (exponent), N (forces) or m (deflection)",
            "Standard deviation of one sample: of the natural logarithm of separations, of finite-time exponents, and of averages, whose standard error it is",
            Value::F64(Box::new(|row: &HorizonRow| Some(row.measure.spread))),
        ),
        Column::new(
            "samples",
            "1",
            "Twins, or successive stretches of so many cycles",
            Value::U64(Box::new(|row: &HorizonRow| Some(row.measure.samples))),
        ),
    ])
}

/// The columns of `points.parquet`.
pub(super) fn horizon_columns() -> Vec<Column<PointRow>> {
    fn number(
        name: &str,
        unit: &str,
        description: &str,
        get: fn(&HorizonOutcome) -> Option<f64>,
    ) -> Column<PointRow> {
        let value = move |row: &PointRow| row.horizon.as_ref().and_then(get);
        Column::new(name, unit, description, Value::F64(Box::new(value)))
    }
    vec![
        number(
            "horizon",
            "mesh cycles",
            "Cycles until the separation of twins is a tenth of the saturation; null where the motion is not chaotic or they stay closer",
            |found| found.horizon,
        ),
        number(
            "horizon_stderr",
            "mesh cycles",
            "Standard error of horizon, by leaving out one twin at a time",
            |found| found.stderr,
        ),
        number(
            "saturation",
            "half gaps",
            "Geometric mean distance of unrelated states of the motion in the energy norm",
            |found| Some(found.saturation),
        ),
        number(
            "averaging_exponent",
            "1",
            "Power of n with which the standard error of a mean contact force over n cycles changes; -0.5 for independent cycles",
            |found| found.averaging_exponent,
        ),
    ]
}
