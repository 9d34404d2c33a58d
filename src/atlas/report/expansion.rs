//! Points with averages over unstable orbits: the orbits of every period, and the averages of the
//! last order beside those over time.

use std::path::Path;

use serde::Serialize;

use crate::store::{ResultTable, StoreError, TableKind};

/// What the unstable orbits of a point say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExpansionSummary {
    /// The point.
    pub point_id: u64,
    /// The last order: longest period of the orbits \[mesh cycles\].
    pub order: u64,
    /// Prime orbits of each order.
    pub orbits: Vec<u64>,
    /// How many more there may be, at each order.
    pub unseen: Vec<f64>,
    /// Sum of `1/|det(1 − M)|` over the points of each period.
    pub conservation: Vec<f64>,
    /// The averages.
    pub averages: Vec<Told>,
}

/// A quantity averaged in three ways, each with its error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Told {
    /// What.
    pub quantity: String,
    /// By the dynamical zeta function.
    pub zeta: [Option<f64>; 2],
    /// By the spectral determinant.
    pub determinant: [Option<f64>; 2],
    /// Over time.
    pub time: [Option<f64>; 2],
}

/// The points of a results folder that have such averages, in `point_id` order.
pub(super) fn read(folder: &Path) -> Result<Vec<ExpansionSummary>, StoreError> {
    let table = match ResultTable::read(folder, TableKind::CycleExpansion) {
        Err(StoreError::Missing { .. }) => return Ok(Vec::new()),
        table => table?,
    };
    let (ids, orders) = (table.u64("point_id")?, table.u64("order")?);
    let (orbits, quantities) = (table.u64("orbits")?, table.text("quantity")?);
    let (unseen, conservation) = (table.f64("unseen")?, table.f64("conservation")?);
    let with_error = |name: &str, error: &str| -> Result<_, StoreError> {
        Ok([table.f64(name)?, table.f64(error)?])
    };
    let zeta = with_error("zeta", "zeta_error")?;
    let determinant = with_error("determinant", "determinant_error")?;
    let time = with_error("time", "time_stderr")?;
    let mut points: Vec<ExpansionSummary> = Vec::new();
    for row in 0..table.rows() {
        let point_id = ids[row].unwrap_or_default();
        let order = orders[row].unwrap_or_default();
        if points.last().is_none_or(|last| last.point_id != point_id) {
            points.push(ExpansionSummary {
                point_id,
                order: 0,
                orbits: Vec::new(),
                unseen: Vec::new(),
                conservation: Vec::new(),
                averages: Vec::new(),
            });
        }
        let Some(point) = points.last_mut() else {
            continue;
        };
        if order != point.order {
            point.order = order;
            point.orbits.push(orbits[row].unwrap_or_default());
            point.unseen.push(unseen[row].unwrap_or_default());
            point
                .conservation
                .push(conservation[row].unwrap_or_default());
            point.averages.clear();
        }
        let at = |pair: &[Vec<Option<f64>>; 2]| pair.each_ref().map(|side| side[row]);
        point.averages.push(Told {
            quantity: quantities[row].clone().unwrap_or_default(),
            zeta: at(&zeta),
            determinant: at(&determinant),
            time: at(&time),
        });
    }
    Ok(points)
}
