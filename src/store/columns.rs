//! The columns of every result table: names, units, descriptions and where each value
//! comes from.

use super::StoreError;
use super::chains::{ChainColumns, ChainPart, direction_column};
use super::horizon::horizon_columns;
use super::nvh::nvh_columns;
use super::table::{Column, Table, Value};
use crate::analysis::{
    Class, HorizonOutcome, LyapunovOutcome, MultistabilityOutcome, OrbitSurvey, PoincareSample,
    PointOutcome, SpectrumLine, SpectrumMethod,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// One axis of the grid as a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AxisColumn {
    /// `load`, `speed`, or the dotted manifest key.
    pub name: String,
    /// SI unit, `1` when dimensionless.
    pub unit: String,
}

/// Where and for how long a point was computed. These columns differ from run to run;
/// all others depend on the manifest alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Worker that computed the point, from 0.
    pub worker: u32,
    /// NUMA node it ran on, where the machine tells.
    pub numa_node: Option<u32>,
    /// Wall time \[s\].
    pub wall_time: f64,
}

/// A row of `points.parquet`, with what the point adds to the other tables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointRow {
    /// Place in the job's list of points.
    pub point_id: u64,
    /// Value of each axis, in the order of the axis columns.
    pub axis_values: Vec<f64>,
    /// What was found.
    pub outcome: PointOutcome,
    /// What its probes found, where they were asked for.
    pub multistability: Option<MultistabilityOutcome>,
    /// The periodic orbits found, where they were asked for.
    pub orbits: Option<OrbitSurvey>,
    /// Its part in a chain, where the state is carried from point to point.
    pub chain: Option<Box<ChainPart>>,
    /// How far ahead it can be foretold, where asked for and chaotic.
    pub horizon: Option<HorizonOutcome>,
    /// Name of the kernel that marched it.
    pub kernel: String,
    /// Where and for how long.
    pub placement: Placement,
}

impl PointRow {
    /// The row without what it adds to other tables.
    pub fn without_tables(mut self) -> Self {
        self.outcome.poincare.clear();
        self.outcome.spectra.clear();
        if let Some(found) = &mut self.multistability {
            found.probes.clear();
            found.attractors.clear();
            found.cells.clear();
        }
        if let Some(found) = &mut self.orbits {
            found.orbits.clear();
        }
        if let Some(found) = &mut self.horizon {
            found.measures.clear();
        }
        if let Some(chain) = &mut self.chain {
            chain.end = None;
        }
        self
    }
}

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
    /// `deflection`, `force` or `bearing …`; one text for all lines.
    pub signal: Arc<str>,
    /// How the spectrum was found.
    pub method: SpectrumMethod,
    /// The line.
    pub line: SpectrumLine,
}

/// Columns of `points.parquet`; `chains` where the state is carried along an axis.
///
/// # Errors
/// An axis that has the name of another column.
pub fn points_table(
    axes: &[AxisColumn],
    chains: Option<&ChainColumns>,
) -> Result<Table<PointRow>, StoreError> {
    let mut columns = vec![Column::new(
        "point_id",
        "1",
        match chains {
            None => "Row-major index into the grid",
            Some(_) => {
                "Index into the points: other axes slowest, then direction, then the swept axis in marching order"
            }
        },
        Value::U64(Box::new(|row: &PointRow| Some(row.point_id))),
    )];
    for (index, axis) in axes.iter().enumerate() {
        columns.push(Column::new(
            &axis.name,
            &axis.unit,
            &format!("Grid axis {}", axis.name),
            Value::F64(Box::new(move |row: &PointRow| {
                row.axis_values.get(index).copied()
            })),
        ));
    }
    columns.extend(chains.map(|chains| direction_column(&chains.axis)));
    columns.extend(ending_columns());
    columns.extend(lyapunov_columns());
    columns.extend(motion_columns());
    columns.extend(horizon_columns());
    columns.extend(nvh_columns());
    columns.extend(work_columns());
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

fn ending_columns() -> Vec<Column<PointRow>> {
    vec![
        Column::new(
            "status",
            "",
            "How the work ended: ok, not_converged, inaccurate (the energy balance does not close), diverged, event_storm, failed",
            Value::Text(Box::new(|row: &PointRow| Some(row.outcome.status.name()))),
        ),
        Column::new(
            "reason",
            "",
            "Why this status and this class",
            Value::Text(Box::new(|row: &PointRow| Some(row.outcome.reason.as_str()))),
        ),
        Column::new(
            "class",
            "",
            "Kind of motion: locked, periodic, quasi_periodic, chaotic, not_converged",
            Value::Text(Box::new(|row: &PointRow| {
                row.outcome.class.as_ref().map(Class::name)
            })),
        ),
        Column::new(
            "period",
            "mesh cycles",
            "Period of locked and periodic motion",
            Value::U32(Box::new(|row: &PointRow| {
                row.outcome.class.as_ref()?.period()
            })),
        ),
    ]
}

fn lyapunov_columns() -> Vec<Column<PointRow>> {
    fn number(
        name: &str,
        description: &str,
        get: fn(&LyapunovOutcome) -> Option<f64>,
    ) -> Column<PointRow> {
        let value = move |row: &PointRow| row.outcome.lyapunov.as_ref().and_then(get);
        Column::new(name, "1/cycle", description, Value::F64(Box::new(value)))
    }
    vec![
        number(
            "lambda_max",
            "Largest Lyapunov exponent per mesh cycle",
            |found| found.exponents.first().copied(),
        ),
        number(
            "lambda_stderr",
            "Standard error of lambda_max, from block averages",
            |found| Some(found.stderr),
        ),
        number(
            "lambda_twin",
            "Largest exponent from a twin trajectory",
            |found| found.twin,
        ),
        number(
            "lambda_twin_stderr",
            "Standard error of lambda_twin, from block averages",
            |found| found.twin_stderr,
        ),
        Column::new(
            "twin_agrees",
            "",
            "Whether twin and tangents agree, over the same cycles, within three standard errors of their difference",
            Value::Bool(Box::new(|row: &PointRow| {
                row.outcome.lyapunov.as_ref()?.twin_agrees
            })),
        ),
        Column::new(
            "lambda_method",
            "",
            "tangent: mean growth of tangent vectors; multipliers: of the settled orbit",
            Value::Text(Box::new(|row: &PointRow| {
                row.outcome
                    .lyapunov
                    .as_ref()
                    .map(|found| found.method.name())
            })),
        ),
        Column::new(
            "exponents",
            "1/cycle",
            "Lyapunov exponents per mesh cycle, largest first",
            Value::List(Box::new(|row: &PointRow| {
                row.outcome
                    .lyapunov
                    .as_ref()
                    .map(|found| found.exponents.as_slice())
            })),
        ),
    ]
}

fn motion_columns() -> Vec<Column<PointRow>> {
    vec![
        Column::new(
            "events_per_cycle",
            "1/cycle",
            "Contact-state changes per measured mesh cycle",
            Value::F64(Box::new(|row: &PointRow| row.outcome.events_per_cycle)),
        ),
        Column::new(
            "attractors",
            "1",
            "Different attractors that the point's probes settled on",
            Value::U32(Box::new(|row: &PointRow| {
                let found = row.multistability.as_ref();
                found.map(|found| found.attractors.len() as u32)
            })),
        ),
    ]
}

fn work_columns() -> Vec<Column<PointRow>> {
    fn count(
        name: &str,
        unit: &str,
        description: &str,
        get: fn(&PointOutcome) -> u64,
    ) -> Column<PointRow> {
        let value = move |row: &PointRow| Some(get(&row.outcome));
        Column::new(name, unit, description, Value::U64(Box::new(value)))
    }
    vec![
        Column::new(
            "energy_residual",
            "1",
            "Energy imbalance over the audited cycles, relative to the energy turned over and stored",
            Value::F64(Box::new(|row: &PointRow| row.outcome.energy_residual)),
        ),
        count(
            "grazing_count",
            "1",
            "Tangencies met over the whole simulation",
            |outcome| outcome.grazing_count,
        ),
        count(
            "cycles",
            "mesh cycles",
            "Mesh cycles marched; transient, probes and refinement included",
            |outcome| outcome.cycles,
        ),
        count(
            "measured_cycles",
            "mesh cycles",
            "Mesh cycles measured",
            |outcome| outcome.measured_cycles,
        ),
        Column::new(
            "kernel",
            "",
            "Kernel that marched the point",
            Value::Text(Box::new(|row: &PointRow| Some(row.kernel.as_str()))),
        ),
        Column::new(
            "wall_time",
            "s",
            "Wall time spent on the point (differs from run to run)",
            Value::F64(Box::new(|row: &PointRow| Some(row.placement.wall_time))),
        ),
        Column::new(
            "worker",
            "1",
            "Worker that computed the point (differs from run to run)",
            Value::U32(Box::new(|row: &PointRow| Some(row.placement.worker))),
        ),
        Column::new(
            "numa_node",
            "1",
            "NUMA node it ran on, where the machine tells (differs from run to run)",
            Value::U32(Box::new(|row: &PointRow| row.placement.numa_node)),
        ),
    ]
}

/// Columns of `poincare.parquet`.
pub fn poincare_table() -> Table<PoincareRow> {
    Table::new(vec![
        Column::new(
            "point_id",
            "1",
            "The point, as in points.parquet",
            Value::U64(Box::new(|row: &PoincareRow| Some(row.point_id))),
        ),
        Column::new(
            "cycle",
            "mesh cycles",
            "Mesh cycle, counted from the start of the simulation",
            Value::U64(Box::new(|row: &PoincareRow| Some(row.sample.cycle))),
        ),
        Column::new(
            "phase",
            "1",
            "Mesh phase of the sample, in [0, 1)",
            Value::F64(Box::new(|row: &PoincareRow| Some(row.sample.phase))),
        ),
        Column::new(
            "deflection",
            "m",
            "Mesh deflection",
            Value::F64(Box::new(|row: &PoincareRow| Some(row.sample.deflection))),
        ),
        Column::new(
            "velocity",
            "m/s",
            "Rate of the mesh deflection",
            Value::F64(Box::new(|row: &PoincareRow| Some(row.sample.velocity))),
        ),
        Column::new(
            "section",
            "",
            "Why the sample was taken: strobe, entry (into drive contact), maximum or minimum (of the deflection)",
            Value::Text(Box::new(|row: &PoincareRow| Some(row.sample.kind.name()))),
        ),
    ])
}

/// Columns of `spectra.parquet`.
pub fn spectra_table() -> Table<SpectrumRow> {
    Table::new(vec![
        Column::new(
            "point_id",
            "1",
            "Row-major index into the grid",
            Value::U64(Box::new(|row: &SpectrumRow| Some(row.point_id))),
        ),
        Column::new(
            "signal",
            "",
            "deflection, force, or bearing with shaft, number and direction",
            Value::Text(Box::new(|row: &SpectrumRow| Some(&*row.signal))),
        ),
        Column::new(
            "method",
            "",
            "fourier: exact lines of a motion that repeats, at the multiples of its own frequency. welch: averaged power of segments of 64 mesh cycles that overlap by half under a Hann window, of any other motion; a line every 1/64 mesh order (bandwidth 1.5 lines), where a sine half-way between two lines stands 15 % (1.42 dB) too low on both",
            Value::Text(Box::new(|row: &SpectrumRow| Some(row.method.name()))),
        ),
        Column::new(
            "frequency",
            "Hz",
            "Frequency of the line",
            Value::F64(Box::new(|row: &SpectrumRow| Some(row.line.frequency))),
        ),
        Column::new(
            "order",
            "1",
            "Multiple of the mesh frequency",
            Value::F64(Box::new(|row: &SpectrumRow| Some(row.line.order))),
        ),
        Column::new(
            "amplitude",
            "m (deflection) or N (force)",
            "Peak value of an equivalent sine, in the unit of the signal; bearings are forces",
            Value::F64(Box::new(|row: &SpectrumRow| Some(row.line.amplitude))),
        ),
    ])
}
