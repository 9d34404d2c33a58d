//! The exact map of mesh cycles, over arrays of states.

use crate::attended::attended;
use crate::errors::{failed, refused};
use crate::point::Point;
use crate::table::{Table, with_unit};
use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, UInt64Array};
use arrow_schema::{DataType, Schema};
use gearatlas::model::{InitialState, ModelDerivative};
use gearatlas::propagate::Event;
use gearatlas::store::TableStore;
use gearatlas::sweep::{self, MapConfig, MapError, MapImage, MapTangents, Prepared, WORKER};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods, ToPyArray,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Largest number of mesh cycles, over all trajectories and tangents, that is computed without checks for Ctrl-C: some
/// milliseconds.
const CYCLES_PER_CHECK: u64 = 2000;

/// The number of cycles below which starting other threads takes longer than it saves.
const FEWEST_PARALLEL_CYCLES: u64 = 16;

/// The map of an operating point.
#[pyclass(frozen, module = "gearatlas._gearatlas")]
pub struct CycleMap {
    point: Py<Point>,
    map: sweep::CycleMap,
    pool: ThreadPool,
}

/// An image: states; tangents, derivatives and events if requested; index and reason of every state that stopped.
type Image<'py> = (
    Bound<'py, PyArray2<f64>>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Option<Table>,
    Vec<(usize, String)>,
);

#[pymethods]
impl CycleMap {
    #[new]
    fn new(
        py: Python<'_>,
        point: Py<Point>,
        threads: Option<usize>,
        tables: PathBuf,
    ) -> PyResult<Self> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|i| format!("{WORKER}{i}"))
            .build()
            .map_err(|error| refused(py, &format!("cannot start worker threads: {error}")))?;
        let spec = point.get().spec.clone();
        let work = |_: &AtomicBool| {
            let parts = Arc::new(Prepared::new(TableStore::open(tables)));
            pool.install(|| sweep::CycleMap::new(spec, parts))
        };
        let map = attended(py, work, |_| Ok(()))?.map_err(|error| failed(py, &error))?;
        Ok(Self { point, map, pool })
    }

    #[getter]
    fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Modes N; a state has 2N components.
    #[getter]
    fn modes(&self) -> usize {
        self.map.model().modes()
    }

    #[getter]
    fn dimension(&self) -> usize {
        self.map.dimension()
    }

    /// Mesh period \[s\].
    #[getter]
    fn period(&self) -> f64 {
        self.map.model().period()
    }

    /// Half gap \[m\].
    #[getter]
    fn half_gap(&self) -> f64 {
        self.map.model().half_gap
    }

    #[getter]
    fn base_period(&self) -> Option<usize> {
        self.map.base_period()
    }

    #[getter]
    fn kernel(&self) -> &'static str {
        self.map.point().run.kernel.name()
    }

    /// Components with an effect on the dynamics: all except those of the neutral pair.
    #[getter]
    fn weighted_components<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<usize>> {
        self.map.norm().weighted_components().to_pyarray(py)
    }

    /// Weight of each component in the energy norm, divided by that of a displacement of half a gap.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let norm = self.map.norm();
        let weights = norm.weights().iter().map(|weight| weight / norm.unit());
        PyArray1::from_iter(py, weights)
    }

    /// The state from `run.initial`.
    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.map.start().into_pyarray(py)
    }

    /// The state of modal displacements \[m √kg\] and velocities \[m √kg/s\].
    fn state_of_modal<'py>(
        &self,
        py: Python<'py>,
        displacement: PyReadonlyArray1<'py, f64>,
        velocity: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let modes = self.modes();
        if displacement.len() != modes || velocity.len() != modes {
            let sentence =
                format!("a modal state needs {modes} displacements and {modes} velocities");
            return Err(PyValueError::new_err(sentence));
        }
        let initial = InitialState::Modal {
            displacement: displacement.as_slice()?.to_vec(),
            velocity: velocity.as_slice()?.to_vec(),
        };
        Ok(self.map.start_of(&initial).into_pyarray(py))
    }

    /// Modal displacements and velocities of states.
    fn to_modal<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<[Bound<'py, PyArray2<f64>>; 2]> {
        let count = self.count(&states)?;
        let mut halves = [Vec::new(), Vec::new()];
        for state in states.as_slice()?.chunks_exact(self.dimension()) {
            let modes = self.map.model().basis.modes(state);
            for (half, own) in halves.iter_mut().zip(modes) {
                half.extend(own);
            }
        }
        let shape = [count, self.modes()];
        let [displacement, velocity] = halves.map(|half| half.into_pyarray(py).reshape(shape));
        Ok([displacement?, velocity?])
    }

    /// Mesh deflection \[m\] and its rate \[m/s\] of states at the start of a mesh cycle.
    fn deflection<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        self.count(&states)?;
        let states = states.as_slice()?.chunks_exact(self.dimension());
        let model = self.map.model();
        let (deflection, rate): (Vec<f64>, Vec<f64>) =
            states.map(|state| model.deflection(state, 0.0)).unzip();
        Ok([deflection, rate].map(|values| values.into_pyarray(py)))
    }

    /// Maps states over some mesh cycles.
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    #[pyo3(signature = (states, cycles, first_cycle, jacobian, tangents, by, events))]
    fn image<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray2<'py, f64>,
        cycles: u64,
        first_cycle: u64,
        jacobian: bool,
        tangents: Option<PyReadonlyArray3<'py, f64>>,
        by: Vec<String>,
        events: bool,
    ) -> PyResult<Image<'py>> {
        let count = self.count(&states)?;
        let dimension = self.dimension();
        let each = match &tangents {
            Some(tangents) => {
                let shape = tangents.shape();
                if shape[0] != count || shape[2] != dimension {
                    return Err(PyValueError::new_err(format!(
                        "tangents must have the shape ({count}, k, {dimension}), not {shape:?}"
                    )));
                }
                shape[1]
            }
            None if jacobian => dimension,
            None => 0,
        };
        let derivatives = self.derivatives(py, &by)?;
        let columns = (1 + each) as u64;
        let work = (count as u64)
            .saturating_mul(cycles)
            .saturating_mul(columns);
        let config = MapConfig {
            states: states.as_slice()?,
            first_cycle,
            cycles,
            tangents: match &tangents {
                Some(tangents) => MapTangents::Given {
                    count: each,
                    vectors: tangents.as_slice()?,
                },
                None if jacobian => MapTangents::Jacobian,
                None => MapTangents::None,
            },
            by: &derivatives,
            events,
            threads: if work < FEWEST_PARALLEL_CYCLES { 1 } else { self.threads() },
        };
        let image = self.work(py, &config, work)?;
        let MapImage {
            states,
            tangents: ends,
            by: along,
            events: met,
            stops,
        } = image.map_err(|error| failed(py, &error))?;
        let shaped = |values: Vec<f64>, each: usize| {
            let shape = [count, each, dimension];
            Ok::<_, PyErr>(values.into_pyarray(py).reshape(shape)?.into_any())
        };
        let ends = (jacobian || tangents.is_some()).then(|| shaped(ends, each));
        let along = (!by.is_empty()).then(|| shaped(along, by.len()));
        let events = events.then(|| events_table(&met, self.period()));
        let stops = stops.iter().map(|(index, stop)| (*index, stop.to_string()));
        Ok((
            states.into_pyarray(py).reshape([count, dimension])?,
            ends.transpose()?,
            along.transpose()?,
            events
                .transpose()
                .map_err(|error| PyValueError::new_err(error.to_string()))?,
            stops.collect(),
        ))
    }
}

impl CycleMap {
    /// Number of states.
    fn count(&self, states: &PyReadonlyArray2<'_, f64>) -> PyResult<usize> {
        let (shape, dimension) = (states.shape(), self.dimension());
        if shape[1] == dimension {
            Ok(shape[0])
        } else {
            Err(PyValueError::new_err(format!(
                "states must have the shape (n, {dimension}), not {shape:?}"
            )))
        }
    }

    /// The derivatives of the model by keys of the manifest.
    fn derivatives(&self, py: Python<'_>, keys: &[String]) -> PyResult<Vec<ModelDerivative>> {
        let point = self.point.get();
        let derivative = |key: &String| {
            let parameter = point.parameter(py, key)?;
            let found = py.detach(|| (self.map).derivative(point.job(), parameter, &point.changes));
            found.map_err(|error| failed(py, &error))
        };
        keys.iter().map(derivative).collect()
    }

    /// Computes the map: directly if it takes some milliseconds, otherwise on a separate thread, for Ctrl-C.
    fn work(
        &self,
        py: Python<'_>,
        config: &MapConfig<'_>,
        work: u64,
    ) -> PyResult<Result<MapImage, MapError>> {
        let on_threads = |interrupt: &AtomicBool| match config.threads {
            1 => self.map.image(config, interrupt),
            _ => self.pool.install(|| self.map.image(config, interrupt)),
        };
        if work <= CYCLES_PER_CHECK {
            Ok(py.detach(|| on_threads(&AtomicBool::new(false))))
        } else {
            attended(py, on_threads, |_| Ok(()))
        }
    }
}

/// Events as a table.
fn events_table(events: &[(usize, Event)], period: f64) -> Result<Table, arrow_schema::ArrowError> {
    let whole = |of: fn(&(usize, Event)) -> u64| -> ArrayRef {
        Arc::new(events.iter().map(of).collect::<UInt64Array>())
    };
    let number = |of: &dyn Fn(&Event) -> f64| -> ArrayRef {
        let values: Vec<f64> = events.iter().map(|(_, event)| of(event)).collect();
        Arc::new(Float64Array::from(values))
    };
    let closes: Vec<bool> = events.iter().map(|(_, event)| event.closes()).collect();
    let columns = [
        (
            with_unit(
                "state",
                DataType::UInt64,
                "1",
                "Row of the state with this event",
            ),
            whole(|(state, _)| *state as u64),
        ),
        (
            with_unit("cycle", DataType::UInt64, "mesh cycles", "Mesh cycle"),
            whole(|(_, event)| event.cycle),
        ),
        (
            with_unit(
                "phase",
                DataType::Float64,
                "1",
                "Elapsed fraction of the mesh cycle",
            ),
            number(&|event| event.time / period),
        ),
        (
            with_unit("time", DataType::Float64, "s", "Time within the mesh cycle"),
            number(&|event| event.time),
        ),
        (
            with_unit(
                "contact",
                DataType::UInt64,
                "",
                "The contact: 1 for the drive flank, 2 for the coast flank, then further contacts in the order of the modal file",
            ),
            whole(|(_, event)| event.contact as u64 + 1),
        ),
        (
            with_unit(
                "closes",
                DataType::Boolean,
                "",
                "Whether the contact closes; otherwise it opens",
            ),
            Arc::new(BooleanArray::from(closes)) as ArrayRef,
        ),
        (
            with_unit(
                "rate",
                DataType::Float64,
                "m/s",
                "Rate of the deflection at the event, along the line of the contact",
            ),
            number(&|event| event.rate),
        ),
    ];
    let (fields, columns): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(schema.clone(), columns)?;
    Ok(Table::new(schema, vec![batch]))
}
