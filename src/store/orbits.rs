//! The columns of `orbits.parquet`.

use super::table::{Column, Table, Value};
use crate::analysis::{Bifurcation, OrbitOutcome};

/// A row of `orbits.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitRow {
    /// The point.
    pub point_id: u64,
    /// Its orbit.
    pub orbit: OrbitOutcome,
    /// Real and imaginary parts of the multipliers, where they were asked for.
    pub multipliers: Option<[Vec<f64>; 2]>,
}

impl OrbitRow {
    /// The row of an orbit of a point.
    pub fn new(point_id: u64, orbit: OrbitOutcome) -> Self {
        let part = |of: fn(&(f64, f64)) -> f64| orbit.multipliers.iter().map(of).collect();
        let multipliers = (!orbit.multipliers.is_empty()).then(|| [part(|m| m.0), part(|m| m.1)]);
        Self {
            point_id,
            orbit,
            multipliers,
        }
    }
}

/// Columns of `orbits.parquet`.
pub fn orbits_table() -> Table<OrbitRow> {
    let mut columns = vec![
        Column::new(
            "point_id",
            "1",
            "Row-major index into the grid",
            Value::U64(Box::new(|row: &OrbitRow| Some(row.point_id))),
        ),
        Column::new(
            "period",
            "mesh cycles",
            "Shortest period of the orbit",
            Value::U32(Box::new(|row: &OrbitRow| Some(row.orbit.period))),
        ),
        number(
            "residual",
            "half gaps",
            "Distance between start and end of a period in the energy norm",
            |orbit| Some(orbit.residual),
        ),
        Column::new(
            "stable",
            "",
            "Whether all multipliers lie inside the unit circle",
            Value::Bool(Box::new(|row: &OrbitRow| Some(row.orbit.character.stable))),
        ),
    ];
    columns.extend(place_columns());
    columns.extend(stability_columns());
    Table::new(columns)
}

fn number(
    name: &str,
    unit: &str,
    description: &str,
    get: fn(&OrbitOutcome) -> Option<f64>,
) -> Column<OrbitRow> {
    let value = move |row: &OrbitRow| get(&row.orbit);
    Column::new(name, unit, description, Value::F64(Box::new(value)))
}

fn place_columns() -> Vec<Column<OrbitRow>> {
    vec![
        number(
            "deflection",
            "m",
            "Mesh deflection at the start of the mesh cycle at which it is smallest",
            |orbit| Some(orbit.deflection),
        ),
        number("velocity", "m/s", "Its rate there", |orbit| {
            Some(orbit.velocity)
        }),
        number(
            "dte_pp",
            "m",
            "Largest minus smallest deflection over the period",
            |orbit| Some(orbit.character.dte_pp),
        ),
        Column::new(
            "events",
            "1",
            "Contact-state changes in a period",
            Value::U64(Box::new(|row: &OrbitRow| Some(row.orbit.character.events))),
        ),
    ]
}

fn stability_columns() -> Vec<Column<OrbitRow>> {
    vec![
        number(
            "lambda",
            "1/cycle",
            "Largest exponent: logarithm of the largest multiplier over the period",
            |orbit| Some(orbit.lambda),
        ),
        Column::new(
            "multipliers_re",
            "1",
            "Real parts of the Floquet multipliers, largest modulus first; null without `floquet`",
            Value::List(Box::new(|row: &OrbitRow| {
                Some(&row.multipliers.as_ref()?[0])
            })),
        ),
        Column::new(
            "multipliers_im",
            "1",
            "Imaginary parts of the Floquet multipliers, in the same order",
            Value::List(Box::new(|row: &OrbitRow| {
                Some(&row.multipliers.as_ref()?[1])
            })),
        ),
        Column::new(
            "bifurcation",
            "",
            "What the largest multiplier crosses the unit circle as: fold (+1), flip (-1), neimark_sacker (a pair); null where its modulus is below 0.9",
            Value::Text(Box::new(|row: &OrbitRow| {
                row.orbit.character.bifurcation.map(Bifurcation::name)
            })),
        ),
        number(
            "grazing_margin",
            "half gaps",
            "Smallest distance of an extreme of the deflection from a contact surface; at 0 the event sequence changes",
            |orbit| orbit.character.grazing_margin,
        ),
        number(
            "kick_growth",
            "1",
            "Growth over one period of a kick of 1e-5 half gaps in the direction of strongest growth, marched in full",
            |orbit| Some(orbit.character.kick_growth),
        ),
        number(
            "kick_growth_linear",
            "1",
            "The same as the monodromy matrix predicts it; far from kick_growth where the kick changes the event sequence",
            |orbit| Some(orbit.character.kick_growth_linear),
        ),
    ]
}
