//! The columns of `probes.parquet`.

use super::point_row::{PointRow, ResultOfPoint};
use super::table::{Table, columns};
use crate::analysis::{Class, ProbeOutcome};

/// Takes the rows of a point.
pub(super) fn probe_rows(point: &mut PointRow) -> Vec<ResultOfPoint<ProbeOutcome>> {
    let outcomes = point.multistability.iter_mut();
    let probes = outcomes.flat_map(|outcome| std::mem::take(&mut outcome.probes));
    ResultOfPoint::all(point.point_id, probes)
}

/// Columns of `probes.parquet`.
pub fn probes_table() -> Table<ResultOfPoint<ProbeOutcome>> {
    Table::new(columns![row: ResultOfPoint<ProbeOutcome>;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        u32 "probe_id", "1", row.result.probe_id, "Initial condition of the point; 0 is run.initial";
        f64 "amplitude", "half gaps", row.result.amplitude,
            "Distance of the initial state from run.initial, in the energy norm. 1 is a rigid displacement \
             by the half gap; the energy is the square";
        u32 "attractor_id", "1", row.result.attractor,
            "Attractor of the point, numbered from 0 in the order of probes; null if the probe settled on none";
        text "status", "", row.result.status.name(),
            "Status of the probe: ok, not_converged, diverged, event_storm";
        text "reason", "", row.result.reason.as_str(), "Reason for the status and the class";
        text "class", "", row.result.class.as_ref().map(Class::name),
            "Class of motion: steady_contact, periodic, quasi_periodic, chaotic, not_converged";
        u32 "period", "mesh cycles", row.result.class.as_ref()?.period(),
            "Period of steady_contact and periodic motion";
        f64 "lambda", "1/cycle", row.result.lambda, "Largest Lyapunov exponent per mesh cycle";
        f64 "lambda_stderr", "1/cycle", row.result.lambda_stderr,
            "Standard error of lambda, from block averages";
        f64 "deflection_rms", "m", row.result.deflection_rms, "Root mean square of the deflection about its mean";
        f64 "force_peak", "N", row.result.force_peak, "Largest |mesh force|";
        f64 "events_per_cycle", "1/cycle", row.result.events_per_cycle,
            "Contact-state changes per measured mesh cycle";
        u64 "cycles", "mesh cycles", row.result.cycles, "Mesh cycles integrated, including the transient";
        f64 "basin_share", "1", row.result.basin.share,
            "Fraction of the point's probes that end on this attractor, or with this status if they settle on none";
        f64 "basin_low", "1", row.result.basin.low,
            "Lower end of the 95 % interval of basin_share (Wilson)";
        f64 "basin_high", "1", row.result.basin.high,
            "Upper end of the 95 % interval of basin_share (Wilson)";
    ])
}
