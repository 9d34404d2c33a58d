//! The columns of every result table: names, units, descriptions and the source of each value.

use super::StoreError;
use super::chains::direction_columns;
use super::covariant::covariant_columns;
use super::horizon::horizon_columns;
use super::layout::ResultLayout;
use super::mesh_columns::mesh_columns;
use super::nvh::{listed, nvh_columns};
use super::orders::{AMPLITUDE_UNITS, SIGNALS};
use super::point_row::{PointRow, ResultOfPoint};
use super::refined::level_columns;
use super::samples::sample_columns;
use super::table::{Column, Table, columns};
use crate::analysis::{Class, PoincareSample, SpectrumLine, SpectrumMethod};
use std::sync::Arc;

/// A row of `spectra.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumRow {
    /// Id of the point, as in `points.parquet`.
    pub point_id: u64,
    /// `deflection`, `force`, or a quantity with its location. All lines of a spectrum share the text.
    pub signal: Arc<str>,
    /// Unit of the signal. All lines of a spectrum share the text.
    pub unit: Arc<str>,
    /// Method that computed the spectrum.
    pub method: SpectrumMethod,
    /// Noise bandwidth of a line \[Hz\]; `None` for exact lines.
    pub bandwidth: Option<f64>,
    /// The line, with its frequency and amplitude.
    pub line: SpectrumLine,
}

/// Takes the samples of a point.
pub(super) fn poincare_rows(point: &mut PointRow) -> Vec<ResultOfPoint<PoincareSample>> {
    ResultOfPoint::all(point.point_id, std::mem::take(&mut point.outcome.poincare))
}

/// Takes the spectral lines of a point.
pub(super) fn spectrum_rows(point: &mut PointRow) -> Vec<SpectrumRow> {
    let point_id = point.point_id;
    let spectra = std::mem::take(&mut point.outcome.spectra).into_iter();
    let rows = spectra.flat_map(|spectrum| {
        let (signal, unit): (Arc<str>, Arc<str>) = (spectrum.signal.into(), spectrum.unit.into());
        spectrum.lines.into_iter().map(move |line| SpectrumRow {
            point_id,
            signal: Arc::clone(&signal),
            unit: Arc::clone(&unit),
            method: spectrum.method,
            bandwidth: spectrum.bandwidth,
            line,
        })
    });
    rows.collect()
}

/// Columns of `points.parquet`, which depend on the axes, the swept axis and the refinement of the grid.
///
/// # Errors
/// An axis has the name of another column.
pub fn points_table(layout: &ResultLayout) -> Result<Table<PointRow>, StoreError> {
    let ResultLayout {
        axes,
        swept,
        refined,
        samples,
        elements,
        ..
    } = layout;
    let point_id = match (swept, refined) {
        (None, None) => "Row-major index into the grid",
        (Some(_), _) => {
            "Index of the point: other axes vary slowest, then the direction, then the swept axis in sweep order"
        }
        (None, Some(_)) => {
            "Index of the point: by level, then row-major over the points that are new at this level"
        }
    };
    let mut columns = columns![row: PointRow;
        u64 "point_id", "1", row.point_id, point_id;
    ];
    for (index, axis) in axes.iter().enumerate() {
        columns.extend(columns![row: PointRow;
            f64 &axis.name, &axis.unit, row.axis_values.get(index).copied(),
                &format!("Grid axis {}", axis.name);
        ]);
    }
    columns.extend(samples.iter().flat_map(sample_columns));
    columns.extend(swept.iter().flat_map(direction_columns));
    let nested = refined.iter().map(|refined| refined.nested);
    columns.extend(nested.flat_map(level_columns));
    columns.extend(motion_columns());
    columns.extend(horizon_columns());
    columns.extend(covariant_columns());
    columns.extend(nvh_columns());
    columns.extend(mesh_columns());
    columns.extend(work_columns());
    for column in &mut columns {
        let column_list = listed(&column.name);
        let list_elements = elements.iter().find(|(list, _)| Some(*list) == column_list);
        column.elements = list_elements
            .map(|(_, names)| names.clone())
            .unwrap_or_default();
    }
    for axis in axes {
        if columns
            .iter()
            .filter(|column| column.name == axis.name)
            .count()
            > 1
        {
            return Err(StoreError::AxisNameTaken {
                name: axis.name.clone(),
            });
        }
    }
    Ok(Table::new(columns))
}

fn motion_columns() -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        text "status", "", row.outcome.status.name(),
            "Status of the point: ok, not_converged, inaccurate (the energy balance does not close), diverged, event_storm, failed";
        text "reason", "", row.outcome.reason.as_str(), "Reason for the status and the class";
        text "class", "", row.outcome.class.as_ref().map(Class::name),
            "Class of motion: steady_contact, periodic, quasi_periodic, chaotic, transient_chaos (some \
             trajectories left it), not_converged";
        u32 "period", "mesh cycles", row.outcome.class.as_ref()?.period(),
            "Period of steady_contact and periodic motion";
        f64 "lambda_max", "1/cycle", row.lyapunov()?.exponents.first().copied(),
            "Largest Lyapunov exponent per mesh cycle";
        f64 "lambda_stderr", "1/cycle", row.lyapunov()?.stderr(),
            "Standard error of lambda_max, from block averages";
        f64 "lambda_twin", "1/cycle", row.lyapunov()?.twin,
            "Largest exponent from a twin trajectory: lambda_max plus the excess growth of the twin over \
             the tangents during the first 320 cycles of the point";
        f64 "lambda_twin_stderr", "1/cycle", row.lyapunov()?.twin_stderr,
            "Standard error of lambda_twin, combined from the errors of lambda_max and of the excess";
        bool "twin_agrees", "", row.lyapunov()?.twin_agrees,
            "Whether twin and tangents agree over the same cycles within three standard errors of their difference";
        text "lambda_method", "", row.lyapunov()?.method.name(),
            "Method for lambda_max. tangent: mean growth of tangent vectors; multipliers: from the Floquet \
             multipliers of the settled orbit; birkhoff: weighted mean growth on a torus";
        list "exponents", "1/cycle", &*row.lyapunov()?.exponents,
            "Lyapunov exponents per mesh cycle, largest first; those of -infinity, of dry sliders that slip, are omitted";
        list "exponents_stderr", "1/cycle", &*row.lyapunov()?.errors,
            "Standard error of each exponent, from block averages";
        f64 "kaplan_yorke", "1", row.lyapunov()?.dimension?.value,
            "Kaplan–Yorke dimension of the states once per mesh cycle; null if the computed exponents do not determine it";
        f64 "kaplan_yorke_stderr", "1", row.lyapunov()?.dimension?.stderr,
            "Standard error of kaplan_yorke, from block averages";
        list "course_cycles", "mesh cycles", &*row.lyapunov()?.convergence.as_ref()?.cycles,
            "Mesh cycles measured at each entry of course_exponents";
        list "course_exponents", "1/cycle", &*row.lyapunov()?.convergence.as_ref()?.exponents,
            "Running mean of the largest exponent at all entries, then of the next exponent, and so on";
        list "course_stderr", "1/cycle", &*row.lyapunov()?.convergence.as_ref()?.errors,
            "Standard errors of course_exponents";
        u32 "trajectories", "1", row.outcome.evidence.as_ref()?.trajectories,
            "Number of trajectories measured for a motion that does not settle; null if it settles";
        bool "errors_verified", "", row.outcome.evidence.as_ref()?.verified,
            "Whether standard errors rest on enough cycles for their measured coverage; null if the motion settles";
        f64 "correlation_cycles", "mesh cycles", row.outcome.evidence.as_ref()?.correlation_cycles,
            "Mesh cycles over which successive growth is correlated: squared block error times measured \
             cycles, divided by the variance";
        f64 "ess", "1", row.outcome.evidence.as_ref()?.ess,
            "Effective sample size of the growth averages over ten mesh cycles, in trajectories that stay, \
             cut to the shortest; as in ArviZ (ess, method mean)";
        f64 "rhat", "1", row.outcome.evidence.as_ref()?.rhat,
            "Split R-hat of the same averages, as in ArviZ (rhat, method split). Above 1.2 the trajectories do not share one motion";
        f64 "rotation_number", "1", row.outcome.evidence.as_ref()?.rotation_number,
            "Frequency of the strongest line of the strobe deflection, per mesh cycle, from 0 to 1/2; for quasi_periodic motion";
        f64 "chaos_lifetime", "mesh cycles", row.outcome.chaos.as_ref()?.lifetime(),
            "Mean life of chaos: chaotic cycles of all trajectories, divided by the number that left it; null if none left";
        f64 "chaos_lifetime_low", "mesh cycles", row.outcome.chaos.as_ref()?.interval().0,
            "Lower end of the 95 % interval of chaos_lifetime; if none left, a lower bound at 95 %, a third of chaos_cycles";
        f64 "chaos_lifetime_high", "mesh cycles", row.outcome.chaos.as_ref()?.interval().1,
            "Upper end of the 95 % interval of chaos_lifetime; null if none left";
        u64 "chaos_cycles", "mesh cycles", row.outcome.chaos.as_ref()?.cycles,
            "Chaotic mesh cycles of all trajectories together, including the cycles in which new trajectories separate from the first one";
        u32 "chaos_exits", "1", row.outcome.chaos.as_ref()?.exits,
            "Number of trajectories that left chaos";
        text "ended_on", "", row.outcome.chaos.as_ref()?.ended_on.as_deref(),
            "Motions on which trajectories that left chaos ended: class, period, and number";
        f64 "transient_lambda", "1/cycle", row.chaos_averages()?.lambda[0],
            "Largest exponent of the chaos that every trajectory left; null if some stayed";
        f64 "transient_lambda_stderr", "1/cycle", row.chaos_averages()?.lambda[1],
            "Standard error of transient_lambda, from block averages";
        f64 "transient_deflection_rms", "m", row.chaos_averages()?.deflection_rms?[0],
            "Root mean square of the deflection about its mean in the chaos that every trajectory left";
        f64 "transient_deflection_rms_stderr", "m", row.chaos_averages()?.deflection_rms?[1],
            "Standard error of transient_deflection_rms";
        f64 "transient_force_std", "N", row.chaos_averages()?.force_std?[0],
            "Standard deviation of the mesh force in the chaos that every trajectory left";
        f64 "transient_force_std_stderr", "N", row.chaos_averages()?.force_std?[1],
            "Standard error of transient_force_std";
        f64 "transient_impact_velocity", "m/s", row.chaos_averages()?.impact_velocity?[0],
            "Mean speed of impacts in the chaos that every trajectory left";
        f64 "transient_impact_velocity_stderr", "m/s", row.chaos_averages()?.impact_velocity?[1],
            "Standard error of transient_impact_velocity";
        list "chain_lengths", "1", &*row.growth_record()?.lengths,
            "Number of growth averages over ten mesh cycles kept per trajectory; null without analyses.lyapunov.chains";
        list "chain_growth", "1/cycle", &*row.growth_record()?.growth,
            "These growth averages, one trajectory after the other";
        f64 "events_per_cycle", "1/cycle", row.outcome.events_per_cycle,
            "Contact-state changes per measured mesh cycle";
        u32 "attractors", "1", row.multistability.as_ref()?.attractors.len() as u32,
            "Number of different attractors on which the point's probes settled";
    ]
}

fn work_columns() -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        f64 "energy_residual", "1", row.outcome.energy_residual,
            "Energy imbalance over the audited cycles, relative to the energy converted and stored";
        u64 "grazing_count", "1", row.outcome.grazing_count,
            "Number of grazing events (tangencies) in the whole simulation";
        u64 "cycles", "mesh cycles", row.outcome.cycles,
            "Mesh cycles integrated, including transient, probes and refinement";
        u64 "measured_cycles", "mesh cycles", row.outcome.measured_cycles, "Mesh cycles measured";
        u64 "nvh_cycles", "mesh cycles", row.outcome.nvh.as_ref()?.cycles,
            "Mesh cycles used for NVH statistics, spectra and orders; fewer than measured_cycles if \
             analyses.nvh.stop_at_stderr stopped them";
        text "kernel", "", row.kernel.as_str(), "Kernel that integrated the point";
        f64 "wall_time", "s", row.placement.wall_time,
            "Wall time spent on the point (differs from run to run). Points of few modes share it, because they are computed \
             side by side";
        u32 "worker", "1", row.placement.worker,
            "Worker that computed the point (differs from run to run)";
        u32 "numa_node", "1", row.placement.numa_node,
            "NUMA node of the worker, if the machine reports it (differs from run to run)";
    ]
}

/// Columns of `poincare.parquet`.
pub fn poincare_table() -> Table<ResultOfPoint<PoincareSample>> {
    Table::new(columns![row: ResultOfPoint<PoincareSample>;
        u64 "point_id", "1", row.point_id, "The point, as in points.parquet";
        u64 "cycle", "mesh cycles", row.result.cycle,
            "Mesh cycle, counted from the start of the simulation";
        f64 "phase", "1", row.result.phase, "Mesh phase of the sample, in [0, 1)";
        f64 "deflection", "m", row.result.deflection, "Mesh deflection";
        f64 "velocity", "m/s", row.result.velocity, "Rate of the mesh deflection";
        text "section", "", row.result.kind.name(),
            "Reason for the sample: strobe, entry (into drive contact), release (out of it), coast_entry, \
             coast_release, maximum or minimum (of the deflection), force_maximum, surface_up or \
             surface_down (towards larger or smaller values)";
    ])
}

/// Columns of `spectra.parquet`.
pub fn spectra_table() -> Table<SpectrumRow> {
    Table::new(columns![row: SpectrumRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        text "signal", "", &*row.signal,
            SIGNALS;
        text "unit", "", &*row.unit, "Unit of the signal, its amplitude and its standard error";
        text "method", "", row.method.name(),
            "Method. fourier: exact lines of a motion that repeats, at multiples of its frequency. welch: for any \
             other motion, the power averaged over segments with a Hann window and an overlap of one half. A sine \
             half-way between two lines appears 15 % (1.42 dB) too low on both. A sine at an order of the excitation \
             lies on a line if segments are whole periods of the excitation";
        f64 "bandwidth", "Hz", row.bandwidth?,
            "Noise bandwidth of a line, 1.5 times the line spacing. The power density of broad-band motion \
             is amplitude^2/(2 bandwidth); null for exact lines";
        f64 "frequency", "Hz", row.line.frequency, "Frequency of the line";
        f64 "order", "1", row.line.order, "Multiple of the mesh frequency";
        f64 "amplitude", AMPLITUDE_UNITS, row.line.amplitude,
            "Peak value of an equivalent sine, in the unit of the signal";
        f64 "amplitude_stderr", AMPLITUDE_UNITS, row.line.stderr?,
            "Standard error of amplitude, from the spread of segments; null for exact lines and for fewer than 8 segments";
    ])
}
