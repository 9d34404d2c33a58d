//! The columns of `attractors.parquet`.
//!
//! No column follows an attractor from point to point. The branch of an attractor depends on neighbouring points, which
//! a shard does not have. `report::branches` finds the branches from the whole table.

use super::point_row::PointRow;
use super::table::{Table, columns};
use crate::analysis::AttractorOutcome;

/// A row of `attractors.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct AttractorRow {
    point_id: u64,
    attractor_id: u32,
    attractor: AttractorOutcome,
    /// Coordinates of the strobe states on the slice.
    places: [Vec<f64>; 2],
}

impl AttractorRow {
    /// The row of an attractor of a point.
    pub fn new(point_id: u64, attractor_id: u32, attractor: AttractorOutcome) -> Self {
        let places = [0, 1].map(|axis| attractor.strobe.iter().map(|at| at[axis]).collect());
        Self {
            point_id,
            attractor_id,
            attractor,
            places,
        }
    }

    /// One coordinate of the attractor's strobe states on the slice; `None` without a slice.
    fn place(&self, axis: usize) -> Option<&[f64]> {
        self.attractor.cells.map(|_| &*self.places[axis])
    }
}

/// The rows of a point.
pub(super) fn attractor_rows(point: &mut PointRow) -> Vec<AttractorRow> {
    let outcomes = point
        .multistability
        .iter()
        .flat_map(|outcome| &outcome.attractors);
    let row = |(id, outcome): (u32, &AttractorOutcome)| {
        AttractorRow::new(point.point_id, id, outcome.clone())
    };
    (0..).zip(outcomes).map(row).collect()
}

/// Columns of `attractors.parquet`. Exponent, statistics and events are those of the first probe or
/// cell on the attractor.
pub fn attractors_table() -> Table<AttractorRow> {
    let slice = |name: &str| {
        format!(
            "Strobe states over one period, projected on the {name} axis of basins.parquet; empty if the \
             motion does not repeat, null without a slice"
        )
    };
    Table::new(columns![row: AttractorRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        u32 "attractor_id", "1", row.attractor_id,
            "Attractor of the point. Numbers start at 0, in the order of the probes, then in the order of the cells of the slice";
        text "class", "", row.attractor.class.name(),
            "Class of motion: steady_contact, periodic, quasi_periodic, chaotic";
        u32 "period", "mesh cycles", row.attractor.class.period(),
            "Period of steady_contact and periodic motion";
        f64 "lambda", "1/cycle", row.attractor.lambda,
            "Largest Lyapunov exponent per mesh cycle, from the first probe on this attractor";
        f64 "lambda_stderr", "1/cycle", row.attractor.lambda_stderr,
            "Standard error of lambda, from block averages";
        f64 "chaos_lifetime_low", "mesh cycles", row.attractor.chaos_lifetime_low,
            "Lower end of the 95 % interval of the mean life of chaos, from all probes of the point together; null for other motions";
        f64 "deflection_rms", "m", row.attractor.deflection_rms,
            "Root mean square of the deflection about its mean";
        f64 "force_peak", "N", row.attractor.force_peak, "Largest |mesh force|";
        f64 "events_per_cycle", "1/cycle", row.attractor.events_per_cycle,
            "Contact-state changes per measured mesh cycle";
        u32 "probes", "1", row.attractor.probes, "Number of probes that settled on this attractor";
        f64 "basin_share", "1", row.attractor.basin.share, "Fraction of the point's probes that settled on this attractor";
        f64 "basin_low", "1", row.attractor.basin.low,
            "Lower end of the 95 % interval of basin_share (Wilson)";
        f64 "basin_high", "1", row.attractor.basin.high,
            "Upper end of the 95 % interval of basin_share (Wilson)";
        u32 "cells", "1", row.attractor.cells,
            "Number of cells of the slice that settled on this attractor; null without a slice";
        list "slice_x", "m", row.place(0), &slice("x");
        list "slice_y", "m", row.place(1), &slice("y");
    ])
}
