//! The columns of `orbits.parquet`.

use super::point_row::PointRow;
use super::table::{Table, columns};
use crate::analysis::{Bifurcation, MissedState, OrbitOutcome};
use num_complex::Complex64;

/// A row of `orbits.parquet`: an orbit, or a given state from which no orbit was found.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitRow {
    point_id: u64,
    /// Result of the search.
    search: Result<OrbitOutcome, MissedState>,
    /// Real and imaginary parts of the multipliers, if requested.
    multipliers: Option<[Vec<f64>; 2]>,
}

impl OrbitRow {
    /// The row of an orbit of a point.
    pub fn found(point_id: u64, orbit: OrbitOutcome) -> Self {
        let part = |of: fn(&Complex64) -> f64| orbit.multipliers.iter().map(of).collect();
        let multipliers = (!orbit.multipliers.is_empty()).then(|| [part(|m| m.re), part(|m| m.im)]);
        Self {
            point_id,
            search: Ok(orbit),
            multipliers,
        }
    }

    /// The row of a given state of a point from which no orbit was found.
    pub fn missed(point_id: u64, missed: MissedState) -> Self {
        Self {
            point_id,
            search: Err(missed),
            multipliers: None,
        }
    }

    fn orbit(&self) -> Option<&OrbitOutcome> {
        self.search.as_ref().ok()
    }

    /// Number of the given state at which the search started, from 1.
    fn state(&self) -> Option<u32> {
        let counted_from_zero = match &self.search {
            Ok(orbit) => orbit.state?,
            Err(missed) => missed.state,
        };
        Some(counted_from_zero + 1)
    }

    fn period(&self) -> u32 {
        match &self.search {
            Ok(orbit) => orbit.period,
            Err(missed) => missed.period,
        }
    }
}

/// Takes the rows of a point.
pub(super) fn orbit_rows(point: &mut PointRow) -> Vec<OrbitRow> {
    let Some(found) = &mut point.orbits else {
        return Vec::new();
    };
    let (orbits, missed) = (
        std::mem::take(&mut found.orbits),
        std::mem::take(&mut found.missed),
    );
    let orbits = orbits
        .into_iter()
        .map(|orbit| OrbitRow::found(point.point_id, orbit));
    let missed = missed
        .into_iter()
        .map(|missed| OrbitRow::missed(point.point_id, missed));
    orbits.chain(missed).collect()
}

/// Columns of `orbits.parquet`.
pub fn orbits_table() -> Table<OrbitRow> {
    Table::new(columns![row: OrbitRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        bool "found", "", row.search.is_ok(),
            "Whether the row is an orbit. If false, a state of analyses.orbits.states led to none, and most columns are null";
        text "reason", "", row.search.as_ref().err()?.reason.as_str(), "Reason why there is no orbit";
        u32 "state", "1", row.state(),
            "State of analyses.orbits.states, counted from 1, from which the search started; null if it started from a close return";
        u32 "period", "mesh cycles", row.period(),
            "Shortest period of the orbit, or the period sought if there is no orbit";
        f64 "residual", "half gaps", row.orbit()?.residual,
            "Distance between the start and the end of a period, in the energy norm";
        bool "stable", "", row.orbit()?.character.stable,
            "Whether all multipliers lie inside the unit circle";
        f64 "deflection", "m", row.orbit()?.deflection,
            "Smallest mesh deflection at the start of a mesh cycle of the orbit";
        f64 "velocity", "m/s", row.orbit()?.velocity, "Rate of mesh deflection at that instant";
        f64 "deflection_pp", "m", row.orbit()?.character.deflection_pp,
            "Largest minus smallest deflection over the period";
        u64 "events", "1", row.orbit()?.character.events, "Contact-state changes in one period";
        f64 "lambda", "1/cycle", row.orbit()?.lambda,
            "Largest exponent: logarithm of the largest multiplier, divided by the period";
        list "multipliers_re", "1", &*row.multipliers.as_ref()?[0],
            "Real parts of the Floquet multipliers, largest modulus first; null without `floquet`";
        list "multipliers_im", "1", &*row.multipliers.as_ref()?[1],
            "Imaginary parts of the Floquet multipliers, in the same order";
        text "bifurcation", "", row.orbit()?.character.bifurcation.map(Bifurcation::name),
            "Type of crossing of the unit circle by the largest multiplier: fold (+1), flip (-1), \
             neimark_sacker (a pair); null if its modulus is below 0.9";
        f64 "grazing_margin", "half gaps", row.orbit()?.character.grazing_margin,
            "Smallest distance between an extreme of a contact's depth and its surface; the event sequence changes at 0";
        f64 "kick_growth", "1", row.orbit()?.character.kick_growth,
            "Growth over one period of a kick of 1e-5 half gaps in the direction of strongest growth, from full integration";
        f64 "kick_growth_linear", "1", row.orbit()?.character.kick_growth_linear,
            "The same growth as predicted by the monodromy matrix; it differs from kick_growth if the kick changes the event sequence";
        list "kick_distance", "half gaps", &*row.orbit()?.kick.distance,
            "Distance from the orbit after 0, 1, 2 ... returns of that kick, from full integration";
        list "kick_distance_linear", "half gaps", &*row.orbit()?.kick.linear,
            "The same distances as predicted by powers of the monodromy matrix";
        list "displacement", "m sqrt(kg)", &*row.orbit()?.start[0],
            "Modal displacements on the orbit at mesh phase 0, one per mode, as used by run.initial and analyses.orbits.states";
        list "modal_velocity", "m sqrt(kg)/s", &*row.orbit()?.start[1],
            "Modal velocities on the orbit at mesh phase 0, one per mode";
    ])
}
