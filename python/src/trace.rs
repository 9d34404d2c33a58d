//! Traced trajectories.

use crate::attended::attended;
use crate::errors::{failed, refused};
use crate::point::Point;
use crate::table::Table;
use gearatlas::analysis::{Signals, TraceConfig, named_outputs};
use gearatlas::store::{TableStore, TraceTables};
use gearatlas::sweep::{PointTrace, PointTraceError, Prepared};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Samples and events of a point's trajectory, and the reason if it ended early.
#[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
#[pyfunction]
#[pyo3(signature = (point, *, cycles, skip, samples_per_cycle, modal, outputs, swept, tables))]
pub fn trace(
    py: Python<'_>,
    point: &Point,
    cycles: u64,
    skip: Option<u64>,
    samples_per_cycle: u32,
    modal: bool,
    outputs: bool,
    swept: bool,
    tables: PathBuf,
) -> PyResult<(Table, Table, Option<String>)> {
    if samples_per_cycle == 0 {
        return Err(refused(py, "samples_per_cycle must be at least 1"));
    }
    let config = TraceConfig {
        skip: skip.unwrap_or(point.spec.run.transient),
        cycles,
        samples_per_cycle,
        modal,
        outputs: Signals {
            bearings: true,
            torques: outputs,
            accelerations: outputs,
            meshes: outputs,
            rotations: outputs,
            ..Signals::NONE
        },
    };
    let parts = Prepared::new(TableStore::open(tables));
    let trace = PointTrace {
        job: point.job(),
        point: &point.spec,
        swept,
        config,
        parts: &parts,
    };
    let work = |interrupt: &_| {
        let model = trace.model()?;
        let signals: Vec<[String; 2]> = named_outputs(&model, config.outputs)
            .map(|(name, quantity)| [name, quantity.unit().to_owned()])
            .collect();
        let open = || Ok(TraceTables::new(model.period(), modal, &signals));
        let (outcome, tables) = trace.record(&model, interrupt, open)?;
        let tables = tables.finish().map_err(PointTraceError::Sink)?;
        Ok::<_, PointTraceError<_>>((outcome, tables))
    };
    let (outcome, tables) = attended(py, work, |_| Ok(()))?.map_err(|error| failed(py, &error))?;
    let [samples, events] = tables.map(|(schema, batches)| Table::new(schema, batches));
    Ok((samples, events, outcome.stop.map(|stop| stop.to_string())))
}
