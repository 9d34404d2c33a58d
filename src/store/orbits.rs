//! The columns of `orbits.parquet`.

use super::table::{Table, columns};
use crate::analysis::{Bifurcation, OrbitOutcome};
use num_complex::Complex64;

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
        let part = |of: fn(&Complex64) -> f64| orbit.multipliers.iter().map(of).collect();
        let multipliers = (!orbit.multipliers.is_empty()).then(|| [part(|m| m.re), part(|m| m.im)]);
        Self {
            point_id,
            orbit,
            multipliers,
        }
    }
}

/// Columns of `orbits.parquet`.
pub fn orbits_table() -> Table<OrbitRow> {
    Table::new(columns![row: OrbitRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        u32 "period", "mesh cycles", row.orbit.period, "Shortest period of the orbit";
        f64 "residual", "half gaps", row.orbit.residual,
            "Distance between start and end of a period in the energy norm";
        bool "stable", "", row.orbit.character.stable,
            "Whether all multipliers lie inside the unit circle";
        f64 "deflection", "m", row.orbit.deflection,
            "Mesh deflection at the start of the mesh cycle at which it is smallest";
        f64 "velocity", "m/s", row.orbit.velocity, "Its rate there";
        f64 "deflection_pp", "m", row.orbit.character.deflection_pp,
            "Largest minus smallest deflection over the period";
        u64 "events", "1", row.orbit.character.events, "Contact-state changes in a period";
        f64 "lambda", "1/cycle", row.orbit.lambda,
            "Largest exponent: logarithm of the largest multiplier over the period";
        list "multipliers_re", "1", &*row.multipliers.as_ref()?[0],
            "Real parts of the Floquet multipliers, largest modulus first; null without `floquet`";
        list "multipliers_im", "1", &*row.multipliers.as_ref()?[1],
            "Imaginary parts of the Floquet multipliers, in the same order";
        text "bifurcation", "", row.orbit.character.bifurcation.map(Bifurcation::name),
            "What the largest multiplier crosses the unit circle as: fold (+1), flip (-1), neimark_sacker (a pair); null where its modulus is below 0.9";
        f64 "grazing_margin", "half gaps", row.orbit.character.grazing_margin,
            "Smallest distance of an extreme of the deflection from a contact surface; at 0 the event sequence changes";
        f64 "kick_growth", "1", row.orbit.character.kick_growth,
            "Growth over one period of a kick of 1e-5 half gaps in the direction of strongest growth, integrated in full";
        f64 "kick_growth_linear", "1", row.orbit.character.kick_growth_linear,
            "The same as the monodromy matrix predicts it; far from kick_growth where the kick changes the event sequence";
    ])
}
