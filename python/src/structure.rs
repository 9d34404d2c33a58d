//! The structure and the mesh of an operating point, as arrays.

use crate::attended::attended;
use crate::errors::failed;
use crate::point::Point;
use crate::table::{Table, with_unit};
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{ArrowError, DataType, Schema};
use gearatlas::analysis::Frequencies;
use gearatlas::model::Model;
use gearatlas::store::TableStore;
use gearatlas::structure::ModalStructure;
use gearatlas::sweep::Prepared;
use gearatlas::sweep::build::{self, BuildError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A column of numbers: name, unit, description, values.
type Numbers = (&'static str, &'static str, &'static str, Vec<f64>);

/// Tables of the modes, of the natural frequencies, and of the mesh stiffness over the phase.
#[pyfunction]
#[pyo3(signature = (point, *, samples, tables))]
pub fn structure(
    py: Python<'_>,
    point: &Point,
    samples: u32,
    tables: PathBuf,
) -> PyResult<[Table; 3]> {
    let spec = &point.spec;
    let work = |_: &_| {
        let parts = Prepared::new(TableStore::open(tables));
        let structure = parts.structure(&spec.model)?;
        let frequencies = Frequencies::of(&build::mean_model(&structure, spec, parts.meshes())?);
        Ok::<_, BuildError>((structure, frequencies, parts.model(spec)?))
    };
    let (structure, frequencies, model) =
        attended(py, work, |_| Ok(()))?.map_err(|error| failed(py, &error))?;
    let tables = || {
        Ok::<_, ArrowError>([
            table(modes(&structure))?,
            table(natural(&frequencies))?,
            table(mesh(&model, samples))?,
        ])
    };
    tables().map_err(|error| PyValueError::new_err(error.to_string()))
}

fn table(columns: Vec<Numbers>) -> Result<Table, ArrowError> {
    let (mut fields, mut arrays) = (Vec::new(), Vec::<ArrayRef>::new());
    for (name, unit, description, values) in columns {
        fields.push(with_unit(name, DataType::Float64, unit, description));
        // NaN becomes null, as in result files.
        let values = values
            .into_iter()
            .map(|value| Some(value).filter(|v| !v.is_nan()));
        arrays.push(Arc::new(values.collect::<Float64Array>()));
    }
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(schema.clone(), arrays)?;
    Ok(Table::new(schema, vec![batch]))
}

/// The retained modes of the structure, one per row.
fn modes(structure: &ModalStructure) -> Vec<Numbers> {
    let none = || vec![f64::NAN; structure.frequency.len()];
    let of = |column: &Option<Vec<f64>>| column.clone().unwrap_or_else(none);
    let coast = structure.coast.as_ref();
    vec![
        (
            "frequency",
            "rad/s",
            "Undamped natural frequency, contacts open",
            structure.frequency.clone(),
        ),
        (
            "damping",
            "1",
            "Modal damping ratio",
            structure.damping.clone(),
        ),
        (
            "mesh",
            "1/sqrt(kg)",
            "Participation of the mesh deflection",
            structure.mesh.clone(),
        ),
        (
            "mesh_tilt",
            "1/(m sqrt(kg))",
            "Derivative of `mesh` with respect to the load centroid",
            structure.mesh_tilt.clone(),
        ),
        (
            "coast",
            "1/sqrt(kg)",
            "Participation of the coast flanks' deflection",
            coast.map_or_else(none, |own| own.mesh.clone()),
        ),
        (
            "torque",
            "1/sqrt(kg)",
            "Modal force of a unit static mesh force",
            structure.torque.clone(),
        ),
        (
            "pinion_torque",
            "1/(m sqrt(kg))",
            "Modal force of a unit torque on the pinion's shaft",
            of(&structure.pinion_torque),
        ),
        (
            "wheel_torque",
            "1/(m sqrt(kg))",
            "Modal force of a unit torque on the wheel's shaft",
            of(&structure.wheel_torque),
        ),
        (
            "friction",
            "1/sqrt(kg)",
            "Participation of a unit friction force",
            structure.friction.clone(),
        ),
    ]
}

/// Natural frequencies, in ascending order, contacts open and closed.
fn natural(frequencies: &Frequencies) -> Vec<Numbers> {
    let open = frequencies.open.iter();
    let closed = |of: fn(&gearatlas::analysis::ClosedMode) -> f64| -> Vec<f64> {
        let known = frequencies.closed.iter().map(of);
        let absent = std::iter::repeat(f64::NAN);
        known.chain(absent).take(frequencies.open.len()).collect()
    };
    vec![
        (
            "open",
            "rad/s",
            "Natural frequency, contacts open; 0 for a rigid motion",
            open.clone().map(|mode| mode.frequency).collect(),
        ),
        (
            "open_decay",
            "1/s",
            "Decay rate of the same mode",
            open.map(|mode| mode.decay).collect(),
        ),
        (
            "closed",
            "rad/s",
            "Natural frequency, with the contacts that bear the mean load closed at their mean stiffness",
            closed(|own| own.mode.frequency),
        ),
        (
            "closed_decay",
            "1/s",
            "Decay rate of the same mode",
            closed(|own| own.mode.decay),
        ),
        (
            "mesh_share",
            "1",
            "Fraction of the elastic energy that the closed contacts store",
            closed(|own| own.mesh_share),
        ),
    ]
}

/// The drive flanks over a mesh cycle in the kernel's model.
fn mesh(model: &Model, samples: u32) -> Vec<Numbers> {
    let (contact, cycle) = (&model.contacts[0], model.first_cycle());
    let phases: Vec<f64> = (0..samples)
        .map(|i| f64::from(i) / f64::from(samples))
        .collect();
    let times: Vec<f64> = phases.iter().map(|phase| phase * cycle.period).collect();
    let line = &model.lines[model.directions[cycle.segments[0].direction].line];
    let each = |of: &dyn Fn(f64) -> f64| times.iter().map(|&time| of(time)).collect();
    let segment = |time: f64| cycle.segment_at(time);
    vec![
        ("phase", "1", "Elapsed fraction of the mesh cycle", phases),
        (
            "stiffness",
            "N/m",
            "Tangent stiffness of the drive flanks",
            each(&|time| segment(time).stiffness_at(time / cycle.period)),
        ),
        (
            "damping",
            "N s/m",
            "Contact damping of the drive flanks",
            each(&|time| segment(time).damping),
        ),
        (
            "gap",
            "m",
            "Gap of the drive flanks: half the backlash plus the error of loaded flanks",
            each(&|time| contact.gap(segment(time), time)[0]),
        ),
        (
            "transmission_error",
            "m",
            "The imposed transmission error",
            each(&|time| line.transmission_error_at(0, time).0),
        ),
    ]
}
