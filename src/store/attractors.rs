//! The columns of `attractors.parquet`.
//!
//! There is no column that follows an attractor from point to point: which branch it belongs
//! to depends on the neighbouring points, which a shard does not have. `report::branches` tells
//! it from the whole table.

use super::table::{Column, Table, Value};
use crate::analysis::AttractorOutcome;

/// A row of `attractors.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct AttractorRow {
    point_id: u64,
    attractor_id: u32,
    attractor: AttractorOutcome,
    /// Coordinates of the strobe states on the slice.
    pub(super) places: [Vec<f64>; 2],
}

impl AttractorRow {
    /// The row of a point's attractor.
    pub fn new(point_id: u64, attractor_id: u32, attractor: AttractorOutcome) -> Self {
        let places = [0, 1].map(|axis| attractor.strobe.iter().map(|at| at[axis]).collect());
        Self {
            point_id,
            attractor_id,
            attractor,
            places,
        }
    }
}

/// Columns of `attractors.parquet`.
pub fn attractors_table() -> Table<AttractorRow> {
    let mut columns = vec![
        Column::new(
            "point_id",
            "1",
            "Row-major index into the grid",
            Value::U64(Box::new(|row: &AttractorRow| Some(row.point_id))),
        ),
        Column::new(
            "attractor_id",
            "1",
            "Attractor of the point, numbered from 0 by the first probe on it, then by the first cell of the slice",
            Value::U32(Box::new(|row: &AttractorRow| Some(row.attractor_id))),
        ),
        Column::new(
            "class",
            "",
            "Kind of motion: locked, periodic, quasi_periodic, chaotic",
            Value::Text(Box::new(|row: &AttractorRow| {
                Some(row.attractor.class.name())
            })),
        ),
        Column::new(
            "period",
            "mesh cycles",
            "Period of locked and periodic motion",
            Value::U32(Box::new(|row: &AttractorRow| row.attractor.class.period())),
        ),
    ];
    columns.extend(motion_columns());
    columns.extend(basin_columns());
    columns.extend(["x", "y"].into_iter().enumerate().map(|(axis, name)| {
        Column::new(
            &format!("slice_{name}"),
            "m",
            &format!(
                "Strobe states over a period, projected on the {name} axis of basins.parquet; empty where the motion does not repeat, null without a slice"
            ),
            Value::List(Box::new(move |row: &AttractorRow| {
                row.attractor.cells.map(|_| row.places[axis].as_slice())
            })),
        )
    }));
    Table::new(columns)
}

fn number(
    name: &str,
    unit: &str,
    description: &str,
    get: fn(&AttractorOutcome) -> Option<f64>,
) -> Column<AttractorRow> {
    let value = move |row: &AttractorRow| get(&row.attractor);
    Column::new(name, unit, description, Value::F64(Box::new(value)))
}

/// Of the first probe or cell on the attractor.
fn motion_columns() -> Vec<Column<AttractorRow>> {
    vec![
        number(
            "lambda",
            "1/cycle",
            "Largest Lyapunov exponent per mesh cycle, of the first probe on it",
            |found| found.lambda,
        ),
        number(
            "lambda_stderr",
            "1/cycle",
            "Standard error of lambda, from block averages",
            |found| found.lambda_stderr,
        ),
        number(
            "dte_rms",
            "m",
            "Root mean square of the deflection about its mean",
            |found| found.dte_rms,
        ),
        number("force_peak", "N", "Largest |mesh force|", |found| {
            found.force_peak
        }),
        number(
            "events_per_cycle",
            "1/cycle",
            "Contact-state changes per measured mesh cycle",
            |found| found.events_per_cycle,
        ),
    ]
}

fn basin_columns() -> Vec<Column<AttractorRow>> {
    vec![
        Column::new(
            "probes",
            "1",
            "Probes that settled on it",
            Value::U32(Box::new(|row: &AttractorRow| Some(row.attractor.probes))),
        ),
        number(
            "basin_share",
            "1",
            "Their share of the point's probes",
            |found| Some(found.basin.share),
        ),
        number(
            "basin_low",
            "1",
            "Lower end of the 95 % interval of basin_share (Wilson)",
            |found| Some(found.basin.low),
        ),
        number(
            "basin_high",
            "1",
            "Upper end of the 95 % interval of basin_share (Wilson)",
            |found| Some(found.basin.high),
        ),
        Column::new(
            "cells",
            "1",
            "Cells of the slice that settled on it; null without a slice",
            Value::U32(Box::new(|row: &AttractorRow| row.attractor.cells)),
        ),
    ]
}
