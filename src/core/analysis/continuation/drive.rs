//! The map over whole mesh cycles of a drive, for continuation.

use super::map::{CycleMap, Details, Image, MapError, MapParameters};
use super::orbit::{Orbit, length};
use super::touches::TouchObserver;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::orbits::floquet::monodromy;
use crate::analysis::recurrence::excitation_period;
use crate::analysis::sensitivity::tangent::ParameterTangent;
use crate::model::{Basis, Model, ModelDerivative, StateChange, TrajectoryState};
use crate::propagate::{Counters, Interruptible, Kernel, Observer, Volterra};
use faer::Mat;
use std::sync::atomic::AtomicBool;

/// Smallest size of a motion, relative to the length of its states. For smaller motions, round-off would make equal
/// orbits look different.
const LEAST_SWING: f64 = 1e-4;

/// A drive whose model depends on two parameters.
pub trait ParametricDrive {
    /// The model at these values of the parameters.
    ///
    /// # Errors
    /// The reason why there is no model.
    fn model(&self, at: MapParameters) -> Result<Model, String>;

    /// The derivative of the model with respect to a parameter, per unit. It is a difference of models whose states
    /// become comparable in the basis `through` ([`Model::combined`]).
    ///
    /// # Errors
    /// The reason why there is no derivative.
    fn derivative(
        &self,
        at: MapParameters,
        axis: usize,
        through: &Basis,
    ) -> Result<ModelDerivative, String>;

    /// Largest number of events allowed in a mesh cycle.
    fn event_limit(&self) -> u32;
}

/// The flag of a map that is never interrupted.
static NEVER: AtomicBool = AtomicBool::new(false);

/// The cycle map of a family of drives, computed with the kernel [`Volterra`].
#[derive(Debug)]
pub struct DriveMap<'f, F> {
    family: &'f F,
    interrupt: &'f AtomicBool,
    /// The basis of the first model. Coordinates are those of its states, because the modes change with the parameters.
    basis: Basis,
    /// The norm of the first model.
    norm: EnergyNorm,
    /// Factor from each weighted component x of a state to its coordinate u = scale x: the weight divided by
    /// the unit of the norm.
    scales: Vec<f64>,
    weighted: Vec<usize>,
    unit: u32,
    built: CurrentModel,
    /// Models built so far.
    pub models: u64,
}

/// The model, its kernel and its norm at the last requested parameters.
#[derive(Debug)]
struct CurrentModel {
    at: MapParameters,
    kernel: Volterra<'static>,
    norm: EnergyNorm,
    /// From states of this model to those of the first model.
    change: StateChange,
    workspace: <Volterra<'static> as Kernel>::Workspace,
}

impl CurrentModel {
    /// The model, with the change to states of the basis `first`, or to its own states without it.
    fn new(
        family: &impl ParametricDrive,
        at: MapParameters,
        first: Option<&Basis>,
    ) -> Result<Self, MapError> {
        let model = family.model(at).map_err(MapError::NoModel)?;
        let change = model.basis.change_to(first.unwrap_or(&model.basis));
        let change = change.map_err(|change| MapError::NoModel(change.to_string()))?;
        let norm = EnergyNorm::new(&model);
        let kernel = Volterra::of(model, f64::EPSILON, family.event_limit());
        let workspace = kernel.workspace();
        Ok(Self {
            at,
            kernel,
            norm,
            change,
            workspace,
        })
    }
}

impl<'f, F: ParametricDrive> DriveMap<'f, F> {
    /// The map of a family of drives. The scales of its coordinates are those at the given parameters.
    ///
    /// # Errors
    /// [`MapError`] if there is no model, or if the excitation is not periodic.
    pub fn new(family: &'f F, at: MapParameters) -> Result<Self, MapError> {
        let built = CurrentModel::new(family, at, None)?;
        let unit = excitation_period(built.kernel.model()).ok_or(MapError::NeverRepeats)?;
        let norm = built.norm.clone();
        let weighted = norm.weighted_components().to_vec();
        let scales = weighted
            .iter()
            .map(|&i| norm.weights()[i] / norm.unit())
            .collect();
        Ok(Self {
            family,
            interrupt: &NEVER,
            basis: built.kernel.model().basis.clone(),
            norm,
            scales,
            weighted,
            unit: unit as u32,
            built,
            models: 1,
        })
    }

    /// The same map with an interrupt. Once the flag is raised, its integrations end with
    /// [`Stop::Interrupted`](crate::propagate::Stop::Interrupted).
    pub fn with_interrupt(self, interrupt: &'f AtomicBool) -> Self {
        Self { interrupt, ..self }
    }

    /// The model at the given parameters.
    ///
    /// # Errors
    /// [`MapError::NoModel`].
    pub fn model(&mut self, at: MapParameters) -> Result<&Model, MapError> {
        self.build(at)?;
        Ok(self.built.kernel.model())
    }

    fn build(&mut self, at: MapParameters) -> Result<(), MapError> {
        if self.built.at == at {
            return Ok(());
        }
        let built = CurrentModel::new(self.family, at, Some(&self.basis))?;
        let (own, weighted) = (built.norm.weighted_components(), &self.weighted);
        let same_states = built.change == StateChange::Same;
        if own.len() != weighted.len() || (same_states && own != weighted) {
            return Err(MapError::NoModel(
                "the number of relevant modes changes with the parameter".to_owned(),
            ));
        }
        self.models += 1;
        self.built = built;
        Ok(())
    }

    /// The unknowns of Newton's method for a state of the current model: the components with weight in the energy norm
    /// of the first model, scaled.
    pub fn coordinates(&self, state: &[f64]) -> Vec<f64> {
        let mut state = state.to_vec();
        self.built.norm.project(&mut state);
        let mut state = self.built.change.apply(&state);
        self.norm.project(&mut state);
        self.weighted
            .iter()
            .zip(&self.scales)
            .map(|(&i, scale)| scale * state[i])
            .collect()
    }

    /// The state with these coordinates, at the start of the first cycle.
    pub fn state(&self, u: &[f64]) -> TrajectoryState {
        TrajectoryState::new(self.built.kernel.model(), self.blocks(u), 0)
    }

    /// The blocks' state with these coordinates.
    fn blocks(&self, u: &[f64]) -> Vec<f64> {
        let model = self.built.kernel.model();
        let mut state = vec![0.0; 2 * model.modes()];
        for ((&i, scale), u) in self.weighted.iter().zip(&self.scales).zip(u) {
            state[i] = u / scale;
        }
        self.built.change.undo(&state)
    }

    /// An orbit of another map of the family, in the coordinates of this map.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn in_own_coordinates(&mut self, orbit: &Orbit) -> Result<Orbit, MapError> {
        let [displacement, velocity] = &orbit.details.start;
        let state = self.model(orbit.at)?.basis.state(displacement, velocity);
        let u = self.coordinates(&state);
        Ok(Orbit {
            monodromy: self.image(&u, orbit.at, orbit.period)?.monodromy,
            details: self.details(&u, orbit.at, orbit.period)?,
            u,
            ..orbit.clone()
        })
    }

    /// A monodromy matrix of the current model, in the coordinates of the map.
    fn in_coordinates(&self, matrix: &Mat<f64>) -> Mat<f64> {
        let n = self.weighted.len();
        let (model, norm) = (self.built.kernel.model(), &self.built.norm);
        let zero = vec![0.0; 2 * model.modes()];
        let unit = |j: usize| {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            unit
        };
        let mut from = Mat::zeros(n, n);
        let mut to = Mat::zeros(n, n);
        for j in 0..n {
            let start = norm.difference(&self.blocks(&unit(j)), &zero);
            let mut end = zero.clone();
            norm.displace(&mut end, 1.0, &unit(j));
            let end = self.coordinates(&end);
            for i in 0..n {
                (from[(i, j)], to[(i, j)]) = (start[i], end[i]);
            }
        }
        to * (matrix * from)
    }

    /// The end of the trajectory over `period` cycles from u.
    fn end(&mut self, u: &[f64], at: MapParameters, period: u32) -> Result<Vec<f64>, MapError> {
        self.build(at)?;
        let mut state = self.state(u);
        self.advance(at, u64::from(period), &mut state, &mut ())?;
        Ok(self.coordinates(&state.state))
    }

    /// Advances a trajectory at the given parameters and passes it to an observer.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn advance<O: Observer>(
        &mut self,
        at: MapParameters,
        cycles: u64,
        state: &mut TrajectoryState,
        observer: &mut O,
    ) -> Result<(), MapError> {
        self.build(at)?;
        let CurrentModel {
            kernel, workspace, ..
        } = &mut self.built;
        let kernel = Interruptible::new(&*kernel, self.interrupt);
        kernel.advance(cycles, state, workspace, observer, &mut Counters::default())?;
        Ok(())
    }
}

impl<F: ParametricDrive> CycleMap for DriveMap<'_, F> {
    fn dimension(&self) -> usize {
        self.weighted.len()
    }

    fn unit(&self) -> u32 {
        self.unit
    }

    fn image(&mut self, u: &[f64], at: MapParameters, period: u32) -> Result<Image, MapError> {
        self.build(at)?;
        let mut state = self.state(u);
        let CurrentModel {
            kernel,
            norm,
            workspace,
            ..
        } = &mut self.built;
        let mut counters = Counters::default();
        let mut matrix = monodromy(
            kernel.model(),
            &Interruptible::new(&*kernel, self.interrupt),
            norm,
            &mut state,
            period,
            workspace,
            &mut counters,
        )?;
        if self.built.change == StateChange::Same {
            let weights = self.built.norm.weights();
            let weighted = self.weighted.iter().zip(&self.scales);
            let ratios: Vec<f64> = weighted.map(|(&i, scale)| scale / weights[i]).collect();
            for j in 0..ratios.len() {
                for i in 0..ratios.len() {
                    matrix[(i, j)] *= ratios[i] / ratios[j];
                }
            }
        } else {
            matrix = self.in_coordinates(&matrix);
        }
        Ok(Image {
            end: self.coordinates(&state.state),
            monodromy: matrix,
        })
    }

    fn by_parameter(
        &mut self,
        u: &[f64],
        at: MapParameters,
        period: u32,
        axis: usize,
    ) -> Result<Vec<f64>, MapError> {
        self.build(at)?;
        let by = self
            .family
            .derivative(at, axis, &self.basis)
            .map_err(MapError::NoModel)?;
        let mut state = self.state(u);
        let start = vec![0.0; state.state.len()];
        let CurrentModel {
            kernel, workspace, ..
        } = &mut self.built;
        let mut tangent = ParameterTangent::new(kernel.model(), &by, &state.state, start, ());
        Interruptible::new(&*kernel, self.interrupt).advance(
            u64::from(period),
            &mut state,
            workspace,
            &mut tangent,
            &mut Counters::default(),
        )?;
        let end = tangent.state().to_vec();
        Ok(self.coordinates(&end))
    }

    /// Computes a difference quotient, because it costs two builds of a model and two integrations. An exact
    /// derivative needs seven models.
    fn near_derivative(
        &mut self,
        u: &[f64],
        at: MapParameters,
        period: u32,
        (axis, step): (usize, f64),
    ) -> Result<Vec<f64>, MapError> {
        let mut ahead = at;
        ahead[axis] += step;
        // Beyond `at`, the parameters may give no model.
        let Ok(later) = self.end(u, ahead, period) else {
            return self.by_parameter(u, at, period, axis);
        };
        let now = self.end(u, at, period)?;
        let rates = later
            .iter()
            .zip(&now)
            .map(|(later, now)| (later - now) / step);
        Ok(rates.collect())
    }

    fn details(&mut self, u: &[f64], at: MapParameters, period: u32) -> Result<Details, MapError> {
        self.build(at)?;
        let mut state = self.state(u);
        let mut strobes = Vec::with_capacity(period as usize);
        let CurrentModel {
            kernel, workspace, ..
        } = &mut self.built;
        let mut watch = TouchObserver::new(kernel.model());
        let mut starts = Vec::with_capacity(period as usize);
        for _ in 0..period {
            starts.push(state.state.clone());
            Interruptible::new(&*kernel, self.interrupt).advance(
                1,
                &mut state,
                workspace,
                &mut watch,
                &mut Counters::default(),
            )?;
        }
        let motion = watch.motion();
        let touches = watch.of_period();
        let half_gap = kernel.model().half_gap;
        let start = kernel.model().basis.modes(&starts[0]);
        strobes.extend(starts.iter().map(|state| self.coordinates(state)));
        let swing = 0.5 * (motion.largest - motion.smallest) / half_gap;
        let farthest = strobes.iter().map(|u| length(u)).fold(0.0, f64::max);
        Ok(Details {
            size: touches.swing().max(swing).max(LEAST_SWING * farthest),
            start,
            strobes,
            touches,
            motion,
        })
    }
}
