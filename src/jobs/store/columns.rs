//! The columns of every result table: names, units, descriptions and where each value
//! comes from.

use super::StoreError;
use super::chains::direction_columns;
use super::covariant::covariant_columns;
use super::horizon::horizon_columns;
use super::layout::ResultLayout;
use super::mesh_columns::mesh_columns;
use super::nvh::{nvh_columns, quantity};
use super::orders::{AMPLITUDE_UNITS, SIGNALS};
use super::point_row::PointRow;
use super::refined::level_columns;
use super::table::{Column, Table, columns};
use crate::analysis::{Class, PoincareSample, SpectrumLine, SpectrumMethod};
use std::sync::Arc;

/// A row of `poincare.parquet`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoincareRow {
    /// The point.
    pub point_id: u64,
    /// Its sample.
    pub sample: PoincareSample,
}

/// A row of `spectra.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumRow {
    /// The point.
    pub point_id: u64,
    /// `deflection`, `force`, or a quantity with its place; one text for all lines.
    pub signal: Arc<str>,
    /// Its unit; one text for all lines.
    pub unit: Arc<str>,
    /// How the spectrum was found.
    pub method: SpectrumMethod,
    /// Noise bandwidth of a line \[Hz\]; none of exact lines.
    pub bandwidth: Option<f64>,
    /// The line.
    pub line: SpectrumLine,
}

/// Columns of `points.parquet`, by axes, the swept one and refinement of the grid.
///
/// # Errors
/// An axis that has the name of another column.
pub fn points_table(layout: &ResultLayout) -> Result<Table<PointRow>, StoreError> {
    let ResultLayout {
        axes,
        swept,
        refined,
        elements,
        ..
    } = layout;
    let point_id = match (swept, refined) {
        (None, None) => "Row-major index into the grid",
        (Some(_), _) => {
            "Index into the points: other axes slowest, then direction, then the swept axis in sweep order"
        }
        (None, Some(_)) => {
            "Number of the place: by level, then row-major over the places that are new with it"
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
        let own = quantity(&column.name);
        let named = elements.iter().find(|(told, _)| Some(*told) == own);
        column.elements = named.map(|(_, names)| names.clone()).unwrap_or_default();
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
            "How the work ended: ok, not_converged, inaccurate (the energy balance does not close), diverged, event_storm, failed";
        text "reason", "", row.outcome.reason.as_str(), "Why this status and this class";
        text "class", "", row.outcome.class.as_ref().map(Class::name),
            "Kind of motion: steady_contact, periodic, quasi_periodic, chaotic, transient_chaos (some trajectories left it), not_converged";
        u32 "period", "mesh cycles", row.outcome.class.as_ref()?.period(),
            "Period of steady_contact and periodic motion";
        f64 "lambda_max", "1/cycle", row.lyapunov()?.exponents.first().copied(),
            "Largest Lyapunov exponent per mesh cycle";
        f64 "lambda_stderr", "1/cycle", row.lyapunov()?.stderr(),
            "Standard error of lambda_max, from block averages";
        f64 "lambda_twin", "1/cycle", row.lyapunov()?.twin,
            "Largest exponent by a twin trajectory: lambda_max and what the twin grew more than the tangents over the same cycles, the first 320 of the point";
        f64 "lambda_twin_stderr", "1/cycle", row.lyapunov()?.twin_stderr,
            "Standard error of lambda_twin: of lambda_max and of that difference";
        bool "twin_agrees", "", row.lyapunov()?.twin_agrees,
            "Whether twin and tangents agree, over the same cycles, within three standard errors of their difference";
        text "lambda_method", "", row.lyapunov()?.method.name(),
            "tangent: mean growth of tangent vectors; multipliers: of the settled orbit; birkhoff: weighted mean growth on a torus";
        list "exponents", "1/cycle", &*row.lyapunov()?.exponents,
            "Lyapunov exponents per mesh cycle, largest first";
        list "exponents_stderr", "1/cycle", &*row.lyapunov()?.errors,
            "Standard error of each exponent, from block averages";
        f64 "kaplan_yorke", "1", row.lyapunov()?.dimension?.value,
            "Kaplan–Yorke dimension of the states once a mesh cycle; absent where the exponents asked for do not tell";
        f64 "kaplan_yorke_stderr", "1", row.lyapunov()?.dimension?.stderr,
            "Standard error of kaplan_yorke, from block averages";
        list "course_cycles", "mesh cycles", &*row.lyapunov()?.course.as_ref()?.cycles,
            "Mesh cycles measured at each place of the course of the exponents";
        list "course_exponents", "1/cycle", &*row.lyapunov()?.course.as_ref()?.exponents,
            "Running mean of the largest exponent at all places, then of the next, and so on";
        list "course_stderr", "1/cycle", &*row.lyapunov()?.course.as_ref()?.errors,
            "Standard errors of course_exponents";
        u32 "trajectories", "1", row.outcome.evidence.as_ref()?.trajectories,
            "Trajectories measured of a motion that does not settle; null where it settles";
        bool "errors_verified", "", row.outcome.evidence.as_ref()?.verified,
            "Whether standard errors were read after as many cycles as their measured coverage takes; null where the motion settles";
        f64 "correlation_cycles", "mesh cycles", row.outcome.evidence.as_ref()?.correlation_cycles,
            "Mesh cycles over which the growth of neighbours is correlated: its squared block error times the measured cycles over its variance";
        f64 "ess", "1", row.outcome.evidence.as_ref()?.ess,
            "Effective sample size of the averages of growth over ten mesh cycles in trajectories that stay, cut to the shortest, as of ArviZ (ess, method mean)";
        f64 "rhat", "1", row.outcome.evidence.as_ref()?.rhat,
            "Split R-hat of the same averages, as of ArviZ (rhat, method split): above 1.2 trajectories do not share one motion";
        f64 "rotation_number", "1", row.outcome.evidence.as_ref()?.rotation_number,
            "Frequency of the strongest line of the strobe deflection per mesh cycle, from 0 to 1/2, of quasi_periodic motion";
        f64 "chaos_lifetime", "mesh cycles", row.outcome.chaos.as_ref()?.lifetime(),
            "Mean life of chaos: chaotic cycles of all trajectories over those that left it; null where none left";
        f64 "chaos_lifetime_low", "mesh cycles", row.outcome.chaos.as_ref()?.interval().0,
            "Lower end of its 95 % interval; a lower bound at 95 %, a third of chaos_cycles, where none left";
        f64 "chaos_lifetime_high", "mesh cycles", row.outcome.chaos.as_ref()?.interval().1,
            "Upper end of its 95 % interval; null where none left";
        u64 "chaos_cycles", "mesh cycles", row.outcome.chaos.as_ref()?.cycles,
            "Chaotic mesh cycles of all trajectories together, those in which branches part from their pilot included";
        u32 "chaos_exits", "1", row.outcome.chaos.as_ref()?.exits,
            "Trajectories that left chaos";
        text "ended_on", "", row.outcome.chaos.as_ref()?.ended_on.as_deref(),
            "What trajectories that left chaos ended on: class, period, and how many";
        f64 "transient_lambda", "1/cycle", row.left_chaos()?.lambda[0],
            "Largest exponent of the chaos that every trajectory left; null where some stayed";
        f64 "transient_lambda_stderr", "1/cycle", row.left_chaos()?.lambda[1],
            "Standard error of transient_lambda, from block averages";
        f64 "transient_deflection_rms", "m", row.left_chaos()?.deflection_rms?[0],
            "Root mean square of the deflection about its mean in the chaos that every trajectory left";
        f64 "transient_deflection_rms_stderr", "m", row.left_chaos()?.deflection_rms?[1],
            "Standard error of transient_deflection_rms";
        f64 "transient_force_std", "N", row.left_chaos()?.force_std?[0],
            "Standard deviation of the mesh force in the chaos that every trajectory left";
        f64 "transient_force_std_stderr", "N", row.left_chaos()?.force_std?[1],
            "Standard error of transient_force_std";
        f64 "transient_impact_velocity", "m/s", row.left_chaos()?.impact_velocity?[0],
            "Mean speed of impacts in the chaos that every trajectory left";
        f64 "transient_impact_velocity_stderr", "m/s", row.left_chaos()?.impact_velocity?[1],
            "Standard error of transient_impact_velocity";
        list "chain_lengths", "1", &*row.chain_record()?.lengths,
            "Averages of growth over ten mesh cycles kept of each trajectory, where analyses.lyapunov.chains asks for them";
        list "chain_growth", "1/cycle", &*row.chain_record()?.growth,
            "These averages, one trajectory behind the other";
        f64 "events_per_cycle", "1/cycle", row.outcome.events_per_cycle,
            "Contact-state changes per measured mesh cycle";
        u32 "attractors", "1", row.multistability.as_ref()?.attractors.len() as u32,
            "Different attractors that the point's probes settled on";
    ]
}

fn work_columns() -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        f64 "energy_residual", "1", row.outcome.energy_residual,
            "Energy imbalance over the audited cycles, relative to the energy turned over and stored";
        u64 "grazing_count", "1", row.outcome.grazing_count,
            "Tangencies met over the whole simulation";
        u64 "cycles", "mesh cycles", row.outcome.cycles,
            "Mesh cycles integrated; transient, probes and refinement included";
        u64 "measured_cycles", "mesh cycles", row.outcome.measured_cycles, "Mesh cycles measured";
        u64 "nvh_cycles", "mesh cycles", row.outcome.nvh.as_ref()?.cycles,
            "Mesh cycles that NVH statistics, spectra and orders are of: fewer than measured_cycles where analyses.nvh.stop_at_stderr ended them";
        text "kernel", "", row.kernel.as_str(), "Kernel that integrated the point";
        f64 "wall_time", "s", row.placement.wall_time,
            "Wall time spent on the point (differs from run to run)";
        u32 "worker", "1", row.placement.worker,
            "Worker that computed the point (differs from run to run)";
        u32 "numa_node", "1", row.placement.numa_node,
            "NUMA node it ran on, where the machine tells (differs from run to run)";
    ]
}

/// Columns of `poincare.parquet`.
pub fn poincare_table() -> Table<PoincareRow> {
    Table::new(columns![row: PoincareRow;
        u64 "point_id", "1", row.point_id, "The point, as in points.parquet";
        u64 "cycle", "mesh cycles", row.sample.cycle,
            "Mesh cycle, counted from the start of the simulation";
        f64 "phase", "1", row.sample.phase, "Mesh phase of the sample, in [0, 1)";
        f64 "deflection", "m", row.sample.deflection, "Mesh deflection";
        f64 "velocity", "m/s", row.sample.velocity, "Rate of the mesh deflection";
        text "section", "", row.sample.kind.name(),
            "Why the sample was taken: strobe, entry (into drive contact), release (out of it), coast_entry, coast_release, maximum or minimum (of the deflection), force_maximum, surface_up or surface_down (towards larger or smaller values)";
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
            "fourier: exact lines of a motion that repeats, at the multiples of its own frequency. welch: averaged power of segments that overlap by half under a Hann window, of any other motion; a sine half-way between two lines stands 15 % (1.42 dB) too low on both, one at an order of the excitation stands on a line where segments are whole periods of it";
        f64 "bandwidth", "Hz", row.bandwidth?,
            "Noise bandwidth of a line, 1.5 times the distance of lines: the power density of broad-band motion is amplitude^2/(2 bandwidth); null of exact lines";
        f64 "frequency", "Hz", row.line.frequency, "Frequency of the line";
        f64 "order", "1", row.line.order, "Multiple of the mesh frequency";
        f64 "amplitude", AMPLITUDE_UNITS, row.line.amplitude,
            "Peak value of an equivalent sine, in the unit of the signal";
        f64 "amplitude_stderr", AMPLITUDE_UNITS, row.line.stderr?,
            "Standard error of amplitude, from the spread of segments; null of exact lines and of fewer than 8 segments";
    ])
}
