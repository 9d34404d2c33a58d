//! The map of whole mesh cycles at one operating point, for many states at once, with tangents, derivatives by keys of
//! the manifest, and events.
//!
//! The kernel of the manifest integrates every state as a run would. The bits are those of a run for any requests and
//! any number of threads.

use super::build::BuildError;
use super::family::PointFamily;
use super::parts::Prepared;
use super::point_kernel::PointKernel;
use crate::analysis::continuation::drive::ParametricDrive;
use crate::analysis::sensitivity::tangent::ParameterTangent;
use crate::analysis::{EnergyNorm, excitation_period};
use crate::manifest::{Job, Parameter, PointSpec};
use crate::model::{InitialState, Model, ModelDerivative, TrajectoryState};
use crate::propagate::{
    Counters, Event, Interruptible, Kernel, KernelChoice, KernelSetting, KernelUse, Observer, Stop,
    Tangents, Volterra, Window,
};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Pieces of work per thread. Several pieces even out the times of states.
const PIECES: usize = 4;

/// The map of an operating point.
#[derive(Debug)]
pub struct CycleMap {
    point: PointSpec,
    kernel: MapKernel,
    parts: Arc<Prepared>,
}

/// The kernel `volterra` is kept between calls. Other kernels borrow their model and are built for each call.
#[derive(Debug)]
enum MapKernel {
    Kept(Box<Volterra<'static>>),
    Built(Box<(Model, PointKernel)>),
}

/// Largest change of the modes per relative change of a key, above which states have no derivative.
const FASTEST_TURN: f64 = 30.0;

/// Why there is no map, or no derivative.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// The drive cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The map has no derivative by this key. The text is a sentence.
    #[error("{0}")]
    NoDerivative(String),
}

/// The tangents that are integrated with every state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MapTangents<'a> {
    /// None.
    None,
    /// Tangents along all coordinates: the result is the matrix `∂end_i/∂start_j`, row by row.
    Jacobian,
    /// Given tangents of each state, one after the other (n × count × 2N).
    Given {
        /// Number per state.
        count: usize,
        /// Components of all tangents.
        vectors: &'a [f64],
    },
}

impl MapTangents<'_> {
    fn count(&self, dimension: usize) -> usize {
        match self {
            Self::None => 0,
            Self::Jacobian => dimension,
            Self::Given { count, .. } => *count,
        }
    }
}

/// The input of a map.
#[derive(Debug, Clone, Copy)]
pub struct MapConfig<'a> {
    /// n states, one after the other, each of length 2N as [`TrajectoryState::state`].
    pub states: &'a [f64],
    /// Mesh cycle in which the states start; it matters if the base period is longer than one cycle.
    pub first_cycle: u64,
    /// Number of mesh cycles.
    pub cycles: u64,
    /// Tangents of each state.
    pub tangents: MapTangents<'a>,
    /// Derivatives of the model ([`CycleMap::derivative`]), by which the map is differentiated at fixed mesh phase.
    pub by: &'a [ModelDerivative],
    /// Whether events are recorded.
    pub events: bool,
    /// Threads of the current rayon pool that share the work; a single one computes on the calling thread.
    pub threads: usize,
}

/// The output of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapImage {
    /// The states (n × 2N); NaN if one could not be integrated.
    pub states: Vec<f64>,
    /// The tangents (n × count × 2N), or the matrices (n × 2N × 2N).
    pub tangents: Vec<f64>,
    /// The derivatives (n × by.len() × 2N), in the unit of a state divided by the SI unit of the key.
    pub by: Vec<f64>,
    /// Events in order, each with the index of its state.
    pub events: Vec<(usize, Event)>,
    /// States that could not be integrated, with the reason.
    pub stops: Vec<(usize, Stop)>,
}

impl CycleMap {
    /// The map of a point.
    ///
    /// # Errors
    /// [`MapError::Build`] if the drive cannot be built, or its kernel takes too long.
    pub fn new(mut point: PointSpec, parts: Arc<Prepared>) -> Result<Self, MapError> {
        let model = parts.model(&point)?;
        let point_kernel = PointKernel::of(&point, &model, &parts)?;
        Arc::make_mut(&mut point.run).kernel = KernelSetting::Named(point_kernel.choice);
        let kernel = match point_kernel.choice {
            KernelChoice::Volterra => MapKernel::Kept(Box::new(Volterra::of(
                model,
                f64::EPSILON,
                point.run.event_limit,
            ))),
            _ => MapKernel::Built(Box::new((model, point_kernel))),
        };
        Ok(Self {
            point,
            kernel,
            parts,
        })
    }

    /// The operating point, with the chosen kernel.
    pub fn point(&self) -> &PointSpec {
        &self.point
    }

    /// The system that is integrated.
    pub fn model(&self) -> &Model {
        match &self.kernel {
            MapKernel::Kept(kernel) => kernel.model(),
            MapKernel::Built(built) => &built.0,
        }
    }

    /// Length 2N of a state.
    pub fn dimension(&self) -> usize {
        2 * self.model().modes()
    }

    /// The norm in which distances of states are measured.
    pub fn norm(&self) -> EnergyNorm {
        EnergyNorm::new(self.model())
    }

    /// Mesh cycles after which the map repeats; `None` if it never does.
    pub fn base_period(&self) -> Option<usize> {
        excitation_period(self.model())
    }

    /// The state at the start of mesh cycle 0 according to the manifest.
    pub fn start(&self) -> Vec<f64> {
        self.start_of(&self.point.run.initial)
    }

    /// The state at the start of mesh cycle 0 for another initial state.
    pub fn start_of(&self, initial: &InitialState) -> Vec<f64> {
        self.model().start(initial).state
    }

    /// The derivative of the model by a key of the manifest, per SI unit. `fixed_values` are the keys whose
    /// values at the point differ from the manifest, with these values.
    ///
    /// # Errors
    /// [`MapError::NoDerivative`] if the model does not depend on it smoothly.
    pub fn derivative(
        &self,
        job: &Job,
        parameter: Parameter,
        fixed_values: &[(Parameter, f64)],
    ) -> Result<ModelDerivative, MapError> {
        let parameters = vec![parameter];
        let family = PointFamily::new(self.point.clone(), parameters, &job.between, &self.parts)
            .holding(fixed_values);
        let (at, basis) = (family.values(), &self.model().basis);
        let by = family
            .derivative(at, 0, basis)
            .map_err(MapError::NoDerivative)?;
        let turning = by.change.as_ref().map_or(0.0, |change| change.norm_max());
        if turning * family.size(at, 0) > FASTEST_TURN {
            let key = family.parameters[0].name();
            return Err(MapError::NoDerivative(format!(
                "no derivative by `{key}`: frequencies are nearly equal, so that the modes of the map jump with it"
            )));
        }
        Ok(by)
    }

    /// Maps states. Raising `interrupt` ends the work; the result is then incomplete.
    ///
    /// # Errors
    /// [`MapError::Build`] if the tables of a kernel could not be loaded or computed.
    pub fn image(
        &self,
        config: &MapConfig<'_>,
        interrupt: &AtomicBool,
    ) -> Result<MapImage, MapError> {
        let work = MapRequest {
            model: self.model(),
            config,
            interrupt,
        };
        match &self.kernel {
            MapKernel::Kept(kernel) => Ok(work.with(&**kernel)),
            MapKernel::Built(built) => {
                let (model, kernel) = &**built;
                Ok(kernel.apply(model, &self.parts, |_| work)?)
            }
        }
    }
}

/// A request to the map, which a kernel carries out.
#[derive(Clone, Copy)]
struct MapRequest<'a> {
    model: &'a Model,
    config: &'a MapConfig<'a>,
    interrupt: &'a AtomicBool,
}

/// Splits the first `count` numbers off a slice.
fn take<'a>(left: &mut &'a mut [f64], count: usize) -> &'a mut [f64] {
    let (taken, rest) = std::mem::take(left).split_at_mut(count);
    *left = rest;
    taken
}

/// Some consecutive states, and the output for them.
struct StateChunk<'a> {
    first: usize,
    states: &'a mut [f64],
    tangents: &'a mut [f64],
    by: &'a mut [f64],
    events: Vec<(usize, Event)>,
    stops: Vec<(usize, Stop)>,
}

impl KernelUse for MapRequest<'_> {
    type Output = MapImage;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> MapImage {
        let config = self.config;
        let dimension = 2 * self.model.modes();
        let count = config.states.len() / dimension;
        let columns = [config.tangents.count(dimension), config.by.len()];
        let mut states = config.states.to_vec();
        let [mut tangents, mut by] = columns.map(|each| vec![0.0; count * each * dimension]);
        let threads = config.threads.max(1);
        let size = match threads {
            1 => count,
            _ => count.div_ceil(PIECES * threads),
        };
        let mut pieces = Vec::new();
        let (mut states_left, mut tangents_left, mut by_left) =
            (&mut states[..], &mut tangents[..], &mut by[..]);
        let mut first = 0;
        while first < count {
            let share = size.min(count - first);
            let room = share * dimension;
            pieces.push(StateChunk {
                first,
                states: take(&mut states_left, room),
                tangents: take(&mut tangents_left, room * columns[0]),
                by: take(&mut by_left, room * columns[1]),
                events: Vec::new(),
                stops: Vec::new(),
            });
            first += share;
        }
        match &mut pieces[..] {
            [piece] => self.map(kernel, piece),
            pieces => pieces
                .par_iter_mut()
                .for_each(|piece| self.map(kernel, piece)),
        }
        let (mut events, mut stops) = (Vec::new(), Vec::new());
        for mut piece in pieces {
            events.append(&mut piece.events);
            stops.append(&mut piece.stops);
        }
        MapImage {
            states,
            tangents,
            by,
            events,
            stops,
        }
    }
}

impl MapRequest<'_> {
    /// Maps the states of a piece one after the other.
    fn map<K: Kernel>(&self, kernel: &K, piece: &mut StateChunk<'_>) {
        let config = self.config;
        let kernel = &Interruptible::new(kernel, self.interrupt);
        let dimension = 2 * self.model.modes();
        let mut workspace = kernel.workspace();
        let count = config.tangents.count(dimension);
        let mut tangents = match count {
            0 => Tangents::none(),
            _ => Tangents::zeros(self.model.modes(), count),
        };
        for (index, state) in piece.states.chunks_exact_mut(dimension).enumerate() {
            let number = piece.first + index;
            let mut trajectory =
                TrajectoryState::new(self.model, state.to_vec(), config.first_cycle);
            let room = |each: usize| index * each * dimension..(index + 1) * each * dimension;
            self.set_out(number, &mut tangents);
            let mut watch = MapObservers::new(self, &trajectory);
            let advanced = kernel.accepts(self.model, &trajectory).and_then(|()| {
                watch.advance(kernel, &mut trajectory, &mut tangents, &mut workspace)
            });
            let ends = &mut piece.tangents[room(count)];
            let by = &mut piece.by[room(config.by.len())];
            match advanced {
                Ok(()) => {
                    state.copy_from_slice(&trajectory.state);
                    self.write_tangents(&tangents, ends);
                    for (column, tangent) in by.chunks_exact_mut(dimension).zip(&watch.tangents) {
                        column.copy_from_slice(&tangent.numbers());
                    }
                }
                Err(stop) => {
                    for values in [state, ends, by] {
                        values.fill(f64::NAN);
                    }
                    piece.stops.push((number, stop));
                }
            }
            let new_events = watch.events.into_iter().flatten();
            piece.events.extend(new_events.map(|event| (number, event)));
        }
    }

    /// Sets the initial tangents of state `number`.
    fn set_out(&self, number: usize, tangents: &mut Tangents) {
        for j in 0..tangents.count() {
            let vector = tangents.vector_mut(j);
            match self.config.tangents {
                MapTangents::None => {}
                MapTangents::Jacobian => {
                    vector.fill(0.0);
                    vector[j] = 1.0;
                }
                MapTangents::Given { count, vectors } => {
                    let from = (number * count + j) * vector.len();
                    vector.copy_from_slice(&vectors[from..from + vector.len()]);
                }
            }
        }
    }

    /// Writes the tangents at the end to the output.
    fn write_tangents(&self, tangents: &Tangents, out: &mut [f64]) {
        let count = tangents.count();
        for j in 0..count {
            let vector = tangents.vector(j);
            match self.config.tangents {
                MapTangents::Jacobian => {
                    for (i, value) in vector.iter().enumerate() {
                        out[i * count + j] = *value;
                    }
                }
                _ => out[j * vector.len()..][..vector.len()].copy_from_slice(vector),
            }
        }
    }
}

/// Observers of a trajectory: its events and its derivatives by parameters, if requested.
struct MapObservers<'a> {
    cycles: u64,
    events: Option<Vec<Event>>,
    tangents: Vec<ParameterTangent<'a, ()>>,
}

impl<'a> MapObservers<'a> {
    fn new(mapping: &MapRequest<'a>, start: &TrajectoryState) -> Self {
        let config = mapping.config;
        let tangent_of = |by: &'a ModelDerivative| {
            ParameterTangent::of_equal_numbers(mapping.model, by, &start.state, ())
        };
        Self {
            cycles: config.cycles,
            events: config.events.then(Vec::new),
            tangents: config.by.iter().map(tangent_of).collect(),
        }
    }

    fn advance<K: Kernel>(
        &mut self,
        kernel: &K,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut K::Workspace,
    ) -> Result<(), Stop> {
        let counters = &mut Counters::default();
        for _ in 0..self.cycles {
            match (&mut self.events, &mut self.tangents[..]) {
                (None, []) => {
                    kernel.advance_cycle(trajectory, tangents, workspace, &mut (), counters)
                }
                (Some(events), []) => {
                    let log = &mut EventLog(events);
                    kernel.advance_cycle(trajectory, tangents, workspace, log, counters)
                }
                (_, _) => kernel.advance_cycle(trajectory, tangents, workspace, self, counters),
            }?;
        }
        Ok(())
    }
}

impl Observer for MapObservers<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        for tangent in &mut self.tangents {
            tangent.window(window);
        }
    }

    fn event(&mut self, event: &Event) {
        for tangent in &mut self.tangents {
            tangent.event(event);
        }
        if let Some(events) = &mut self.events {
            events.push(*event);
        }
    }
}

/// Records events.
struct EventLog<'a>(&'a mut Vec<Event>);

impl Observer for EventLog<'_> {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}
