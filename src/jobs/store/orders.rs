//! `orders.parquet`: signals at multiples of the mesh frequency and of the shafts' speeds.

use std::sync::Arc;

use super::point_row::PointRow;
use super::table::{Table, columns};
use crate::analysis::OrderLine;

/// A row of `orders.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderRow {
    /// Id of the point, as in `points.parquet`.
    pub point_id: u64,
    /// Name of the signal, as in `spectra.parquet`. All orders of a signal share the text.
    pub signal: Arc<str>,
    /// Unit of the signal. All orders of a signal share the text.
    pub unit: Arc<str>,
    /// The signal at one order.
    pub line: OrderLine,
}

/// Takes the rows of a point.
pub(super) fn order_rows(point: &mut PointRow) -> Vec<OrderRow> {
    let point_id = point.point_id;
    let orders = std::mem::take(&mut point.outcome.orders).into_iter();
    let rows = orders.flat_map(|signal_orders| {
        let (signal, unit): (Arc<str>, Arc<str>) =
            (signal_orders.signal.into(), signal_orders.unit.into());
        signal_orders.lines.into_iter().map(move |line| OrderRow {
            point_id,
            signal: Arc::clone(&signal),
            unit: Arc::clone(&unit),
            line,
        })
    });
    rows.collect()
}

/// Unit of an amplitude, by signal.
pub(super) const AMPLITUDE_UNITS: &str = "m (deflection) or N (force) or m (mesh deflection) or N (mesh force) or N (bearing) or N m (torque) or m/s^2 (acceleration) or rad/s^2 (angular acceleration)";

/// The available signals.
pub(super) const SIGNALS: &str = "deflection; force; mesh deflection and mesh force with both gears; bearing with shaft, number and direction; torque with \
                                  shaft or coupling; acceleration with bearing and direction; angular \
                                  acceleration with shaft or loose gear";

/// Columns of `orders.parquet`.
pub fn orders_table() -> Table<OrderRow> {
    Table::new(columns![row: OrderRow;
        u64 "point_id", "1", row.point_id, "The point, as in points.parquet";
        text "signal", "", &*row.signal, SIGNALS;
        text "unit", "", &*row.unit, "Unit of the signal, its amplitude and its standard error";
        text "reference", "", &*row.line.reference,
            "Base frequency of the order: mesh (frequency of the first mesh), pinion or wheel (speed of its shaft), a further \
             mesh with its gears, or a further shaft";
        u32 "multiple", "1", row.line.multiple, "Multiple of the base frequency";
        f64 "order", "1", row.line.order, "Multiple of the mesh frequency";
        f64 "frequency", "Hz", row.line.frequency, "Frequency";
        f64 "amplitude", AMPLITUDE_UNITS, row.line.amplitude,
            "Peak value of signal = ... + amplitude cos(2 pi frequency t + phase), where t = 0 at the start of mesh \
             cycle 0. If the motion does not repeat, it is the amplitude of the part with a constant phase";
        f64 "amplitude_stderr", AMPLITUDE_UNITS, row.line.stderr?,
            "Standard error of amplitude; null if the motion repeats and the value is exact, or if too little was measured";
        f64 "phase", "rad", row.line.phase?, "Phase, in (-pi, pi]; null without amplitude";
        f64 "phase_stderr", "rad", row.line.phase_stderr?,
            "Standard error of phase; null if the standard error of amplitude is null. A value near 1 or above means \
             that the signal has no constant phase at this order";
    ])
}
