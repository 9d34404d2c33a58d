//! The columns of `probes.parquet`.

use super::file::Row;
use super::point_row::PointRow;
use super::table::{Table, columns};
use crate::analysis::{Class, ProbeOutcome};

/// A row of `probes.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeRow {
    /// The point.
    pub point_id: u64,
    /// A probe of the point.
    pub probe: ProbeOutcome,
}

impl Row for ProbeRow {
    fn list_bytes(&self) -> usize {
        self.probe.reason.len()
    }
}

/// Takes the rows of a point.
pub(super) fn probe_rows(point: &mut PointRow) -> Vec<ProbeRow> {
    let found = point.multistability.as_mut();
    let probes = found.map_or(Vec::new(), |found| std::mem::take(&mut found.probes));
    let point_id = point.point_id;
    (probes.into_iter())
        .map(|probe| ProbeRow { point_id, probe })
        .collect()
}

/// Columns of `probes.parquet`.
pub fn probes_table() -> Table<ProbeRow> {
    Table::new(columns![row: ProbeRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        u32 "probe_id", "1", row.probe.probe_id, "Initial condition of the point; 0 is run.initial";
        f64 "amplitude", "half gaps", row.probe.amplitude,
            "Distance of the initial state from run.initial, in the energy norm. 1 is a rigid displacement \
             by the half gap; the energy is the square";
        u32 "attractor_id", "1", row.probe.attractor,
            "Attractor of the point, numbered from 0 in the order of probes; null if the probe settled on none";
        text "status", "", row.probe.status.name(),
            "Status of the probe: ok, not_converged, diverged, event_storm";
        text "reason", "", row.probe.reason.as_str(), "Reason for the status and the class";
        text "class", "", row.probe.class.as_ref().map(Class::name),
            "Class of motion: steady_contact, periodic, quasi_periodic, chaotic, not_converged";
        u32 "period", "mesh cycles", row.probe.class.as_ref()?.period(),
            "Period of steady_contact and periodic motion";
        f64 "lambda", "1/cycle", row.probe.lambda, "Largest Lyapunov exponent per mesh cycle";
        f64 "lambda_stderr", "1/cycle", row.probe.lambda_stderr,
            "Standard error of lambda, from block averages";
        f64 "deflection_rms", "m", row.probe.deflection_rms, "Root mean square of the deflection about its mean";
        f64 "force_peak", "N", row.probe.force_peak, "Largest |mesh force|";
        f64 "events_per_cycle", "1/cycle", row.probe.events_per_cycle,
            "Contact-state changes per measured mesh cycle";
        u64 "cycles", "mesh cycles", row.probe.cycles, "Mesh cycles integrated, including the transient";
        f64 "basin_share", "1", row.probe.basin.share,
            "Fraction of the point's probes that end on this attractor, or with this status if they settle on none";
        f64 "basin_low", "1", row.probe.basin.low,
            "Lower end of the 95 % interval of basin_share (Wilson)";
        f64 "basin_high", "1", row.probe.basin.high,
            "Upper end of the 95 % interval of basin_share (Wilson)";
    ])
}
