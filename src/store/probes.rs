//! The columns of `probes.parquet`.

use super::table::{Column, Table, Value};
use crate::analysis::{Class, ProbeOutcome};

/// A row of `probes.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeRow {
    /// The point.
    pub point_id: u64,
    /// Its probe.
    pub probe: ProbeOutcome,
}

/// Columns of `probes.parquet`.
pub fn probes_table() -> Table<ProbeRow> {
    let mut columns = vec![
        Column::new(
            "point_id",
            "1",
            "Row-major index into the grid",
            Value::U64(Box::new(|row: &ProbeRow| Some(row.point_id))),
        ),
        Column::new(
            "probe_id",
            "1",
            "Initial condition of the point; 0 is run.initial",
            Value::U32(Box::new(|row: &ProbeRow| Some(row.probe.probe_id))),
        ),
        number(
            "amplitude",
            "half gaps",
            "Distance of the initial state from run.initial in the energy norm; 1 is a rigid displacement by the half gap, the energy is its square",
            |probe| Some(probe.amplitude),
        ),
        Column::new(
            "attractor_id",
            "1",
            "Attractor of the point, numbered from 0 by first probe; null where the probe settled on none",
            Value::U32(Box::new(|row: &ProbeRow| row.probe.attractor)),
        ),
    ];
    columns.extend(ending_columns());
    columns.extend(motion_columns());
    columns.extend(basin_columns());
    Table::new(columns)
}

fn number(
    name: &str,
    unit: &str,
    description: &str,
    get: fn(&ProbeOutcome) -> Option<f64>,
) -> Column<ProbeRow> {
    let value = move |row: &ProbeRow| get(&row.probe);
    Column::new(name, unit, description, Value::F64(Box::new(value)))
}

fn ending_columns() -> Vec<Column<ProbeRow>> {
    vec![
        Column::new(
            "status",
            "",
            "How the probe ended: ok, not_converged, diverged, event_storm",
            Value::Text(Box::new(|row: &ProbeRow| Some(row.probe.status.name()))),
        ),
        Column::new(
            "reason",
            "",
            "Why this status and this class",
            Value::Text(Box::new(|row: &ProbeRow| Some(row.probe.reason.as_str()))),
        ),
        Column::new(
            "class",
            "",
            "Kind of motion: locked, periodic, quasi_periodic, chaotic, not_converged",
            Value::Text(Box::new(|row: &ProbeRow| {
                row.probe.class.as_ref().map(Class::name)
            })),
        ),
        Column::new(
            "period",
            "mesh cycles",
            "Period of locked and periodic motion",
            Value::U32(Box::new(|row: &ProbeRow| {
                row.probe.class.as_ref()?.period()
            })),
        ),
    ]
}

fn motion_columns() -> Vec<Column<ProbeRow>> {
    vec![
        number(
            "lambda",
            "1/cycle",
            "Largest Lyapunov exponent per mesh cycle",
            |probe| probe.lambda,
        ),
        number(
            "lambda_stderr",
            "1/cycle",
            "Standard error of lambda, from block averages",
            |probe| probe.lambda_stderr,
        ),
        number(
            "dte_rms",
            "m",
            "Root mean square of the deflection about its mean",
            |probe| probe.dte_rms,
        ),
        number("force_peak", "N", "Largest |mesh force|", |probe| {
            probe.force_peak
        }),
        number(
            "events_per_cycle",
            "1/cycle",
            "Contact-state changes per measured mesh cycle",
            |probe| probe.events_per_cycle,
        ),
        Column::new(
            "cycles",
            "mesh cycles",
            "Mesh cycles marched, transient included",
            Value::U64(Box::new(|row: &ProbeRow| Some(row.probe.cycles))),
        ),
    ]
}

fn basin_columns() -> Vec<Column<ProbeRow>> {
    vec![
        number(
            "basin_share",
            "1",
            "Share of the point's probes that end on this attractor, or with this status where they settle on none",
            |probe| Some(probe.basin.share),
        ),
        number(
            "basin_low",
            "1",
            "Lower end of the 95 % interval of basin_share (Wilson)",
            |probe| Some(probe.basin.low),
        ),
        number(
            "basin_high",
            "1",
            "Upper end of the 95 % interval of basin_share (Wilson)",
            |probe| Some(probe.basin.high),
        ),
    ]
}
