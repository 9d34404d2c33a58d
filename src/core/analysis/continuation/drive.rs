//! The cycle map of a drive, as continuation sees it.

pub use super::integrator::bases;
use super::integrator::{Integrator, Work};
use super::map::{At, CycleMap, Details, Image, MapError};
use super::orbit::length;
use super::touches::Watch;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::recurrence::excitation_period;
use crate::analysis::sensitivity::tangent::ParameterTangent;
use crate::model::{MeshGain, Model, TrajectoryState};
use crate::propagate::{
    Counters, Interruptible, Kernel, Leg, Observer, SharedBases, Stop, Volterra,
};
use faer::Mat;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Smallest size of a motion, as a part of the length of its states: below it round-off would tell orbits apart.
const LEAST_SWING: f64 = 1e-4;

/// Which coordinates no contact sees, and which none pushes: such modes move by themselves, or move nothing else.
#[derive(Debug)]
struct Apart {
    unseen: Vec<bool>,
    unpushed: Vec<usize>,
}

impl Apart {
    fn new(model: &Model, norm: &EnergyNorm) -> Self {
        let (n, felt) = (model.modes(), norm.felt());
        let none = |part: fn(&MeshGain) -> [f64; 2], i: usize| {
            let mut all = model.directions.iter();
            norm.keeps_components() && all.all(|own| part(&own.gains[i % n]) == [0.0; 2])
        };
        Self {
            unseen: (felt.iter().map(|&i| none(|gain| gain.deflection, i))).collect(),
            unpushed: (0..felt.len())
                .filter(|&place| none(|gain| gain.mesh_input, felt[place]))
                .collect(),
        }
    }

    /// Takes the round-off out of what a coordinate of a mode, `mode` of each, moves.
    fn clean(&self, from: usize, mode: impl Fn(usize) -> usize, column: &mut [f64]) {
        let keeps = |to: usize| mode(to) == mode(from);
        if self.unseen[from] {
            let other = (0..column.len()).filter(|&to| !keeps(to));
            other.for_each(|to| column[to] = 0.0);
        }
        for &to in self.unpushed.iter().filter(|&&to| !keeps(to)) {
            column[to] = 0.0;
        }
    }
}

/// A drive whose model depends on two parameters.
pub trait Family {
    /// The model where the parameters have these values.
    ///
    /// # Errors
    /// A sentence that says why there is none.
    fn model(&self, at: At) -> Result<Model, String>;

    /// The derivative of the model by a parameter, per unit ([`Model::combined`]).
    ///
    /// # Errors
    /// A sentence that says why there is none.
    fn derivative(&self, at: At, axis: usize) -> Result<Model, String>;

    /// Bases for closed modes of a model of the family and of others like it; none where closed modes do not serve.
    fn bases(&self, model: &Model) -> Option<Arc<SharedBases>> {
        bases(model).map(Arc::new)
    }

    /// Most events in a mesh cycle before integration stops.
    fn event_limit(&self) -> u32;
}

/// The flag of a map that nothing calls off.
static NEVER: AtomicBool = AtomicBool::new(false);

/// The map of a family of drives.
#[derive(Debug)]
pub struct DriveMap<'f, F> {
    family: &'f F,
    called_off: &'f AtomicBool,
    /// Weight of every coordinate over the unit: u = scale x.
    scales: Vec<f64>,
    felt: Vec<usize>,
    unit: u32,
    /// Bases of the structure and the mesh, where kernels share some.
    shared: Option<Arc<SharedBases>>,
    built: Built,
    /// What transients are integrated by, where some were.
    transient: Option<Transient>,
    /// Models built so far.
    pub models: u64,
}

/// What is kept of the parameters last asked for.
#[derive(Debug)]
struct Built {
    at: At,
    kernel: Integrator,
    norm: EnergyNorm,
    apart: Apart,
    workspace: Work,
    /// The trajectory that was traced last.
    traced: Option<Traced>,
}

/// The structured kernel at some parameters.
type Transient = (
    At,
    Box<Volterra<'static>>,
    <Volterra<'static> as Kernel>::Workspace,
);

/// A trajectory at the parameters that are kept.
#[derive(Debug)]
struct Traced {
    u: Vec<f64>,
    period: u32,
    end: Vec<f64>,
    legs: Vec<Leg>,
}

impl Built {
    fn new(
        model: Model,
        at: At,
        event_limit: u32,
        shared: Option<&SharedBases>,
    ) -> Result<Self, MapError> {
        let norm = EnergyNorm::new(&model);
        let apart = Apart::new(&model, &norm);
        let kernel = Integrator::new(model, event_limit, shared)
            .map_err(|error| MapError::NoModel(error.to_string()))?;
        let workspace = kernel.workspace();
        Ok(Self {
            at,
            kernel,
            norm,
            apart,
            workspace,
            traced: None,
        })
    }
}

impl<'f, F: Family> DriveMap<'f, F> {
    /// The map, its coordinates scaled as at some values of the parameters.
    ///
    /// # Errors
    /// [`MapError`] where there is no model, or where what drives it does not repeat.
    pub fn new(family: &'f F, at: At) -> Result<Self, MapError> {
        let model = family.model(at).map_err(MapError::NoModel)?;
        let shared = family.bases(&model);
        let built = Built::new(model, at, family.event_limit(), shared.as_deref())?;
        let unit = excitation_period(built.kernel.model()).ok_or(MapError::NeverRepeats)?;
        let norm = &built.norm;
        let felt = norm.felt();
        let scales = felt
            .iter()
            .map(|&i| norm.weights()[i] / norm.unit())
            .collect();
        Ok(Self {
            family,
            called_off: &NEVER,
            scales,
            felt,
            unit: unit as u32,
            shared,
            built,
            transient: None,
            models: 1,
        })
    }

    /// The same map, whose integrations end with [`Stop::CalledOff`](crate::propagate::Stop::CalledOff) once the flag
    /// is raised.
    pub fn heeding(self, called_off: &'f AtomicBool) -> Self {
        Self { called_off, ..self }
    }

    /// The model at some values of the parameters.
    ///
    /// # Errors
    /// [`MapError::NoModel`].
    pub fn model(&mut self, at: At) -> Result<&Model, MapError> {
        self.build(at)?;
        Ok(self.built.kernel.model())
    }

    fn build(&mut self, at: At) -> Result<(), MapError> {
        if self.built.at == at {
            return Ok(());
        }
        let model = self.family.model(at).map_err(MapError::NoModel)?;
        let limit = self.family.event_limit();
        let built = Built::new(model, at, limit, self.shared.as_deref())?;
        if built.norm.felt() != self.felt {
            return Err(MapError::NoModel(
                "the modes that count change with the parameter".to_owned(),
            ));
        }
        self.models += 1;
        self.built = built;
        Ok(())
    }

    /// The coordinates of a state.
    pub fn coordinates(&self, state: &[f64]) -> Vec<f64> {
        let mut state = state.to_vec();
        self.built.norm.project(&mut state);
        self.felt
            .iter()
            .zip(&self.scales)
            .map(|(&i, scale)| scale * state[i])
            .collect()
    }

    /// The state with these coordinates, at the start of the first cycle.
    pub fn state(&self, u: &[f64]) -> TrajectoryState {
        let model = self.built.kernel.model();
        let mut state = vec![0.0; 2 * model.modes()];
        for ((&i, scale), u) in self.felt.iter().zip(&self.scales).zip(u) {
            state[i] = u / scale;
        }
        TrajectoryState::new(model, state, 0)
    }

    /// Does something with the map at some values of the parameters, and again by the structured kernel where a motion comes
    /// to a set of closed contacts without a basis.
    fn surely<T>(
        &mut self,
        at: At,
        mut done: impl FnMut(&mut Self) -> Result<T, MapError>,
    ) -> Result<T, MapError> {
        self.build(at)?;
        match done(self) {
            Err(MapError::Stop(Stop::Refused { .. })) if self.shared.is_some() => {
                self.shared = None;
                let model = self.built.kernel.model().clone();
                self.built = Built::new(model, at, self.family.event_limit(), None)?;
                done(self)
            }
            done => done,
        }
    }

    /// Advances a trajectory at some values of the parameters, shown to an observer; by the structured kernel, so that what
    /// a transient leads to does not depend on what the orbits are followed by.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn advance<O: Observer>(
        &mut self,
        at: At,
        cycles: u64,
        state: &mut TrajectoryState,
        observer: &mut O,
    ) -> Result<(), MapError> {
        self.build(at)?;
        let transient = match self.transient.take() {
            Some(known) if known.0 == at => known,
            _ => {
                let model = self.built.kernel.model().clone();
                let kernel = Volterra::of(model, f64::EPSILON, self.family.event_limit());
                let workspace = kernel.workspace();
                (at, Box::new(kernel), workspace)
            }
        };
        let (_, kernel, workspace) = self.transient.insert(transient);
        let kernel = Interruptible::new(&**kernel, self.called_off);
        kernel.advance(cycles, state, workspace, observer, &mut Counters::default())?;
        Ok(())
    }

    /// Traces a trajectory from u at the parameters last asked for, unless that was done last.
    fn trace(&mut self, u: &[f64], period: u32) -> Result<(), MapError> {
        let traced = self.built.traced.as_ref();
        if traced.is_some_and(|traced| traced.period == period && traced.u == u) {
            return Ok(());
        }
        let mut state = self.state(u);
        let Built {
            kernel, workspace, ..
        } = &mut self.built;
        let legs = kernel.trace(&mut state, period, workspace, self.called_off)?;
        self.built.traced = Some(Traced {
            u: u.to_vec(),
            period,
            end: self.coordinates(&state.state),
            legs,
        });
        Ok(())
    }

    /// Where the trajectory that was traced ends.
    fn traced_end(&self) -> Vec<f64> {
        let traced = self.built.traced.as_ref();
        traced.map_or_else(Vec::new, |traced| traced.end.clone())
    }

    /// Derivative of the end of a trajectory that was traced by the coordinates of its start.
    fn derivative(&mut self, u: &[f64], period: u32) -> Result<Mat<f64>, MapError> {
        let state = self.state(u);
        let (felt, scales) = (&self.felt, &self.scales);
        let Built {
            kernel,
            norm,
            apart,
            workspace,
            traced,
            ..
        } = &mut self.built;
        let legs = traced.as_ref().map_or(&[][..], |traced| &traced.legs);
        let known = (self.shared.as_deref(), legs);
        let start = (state, period);
        let mut moved = kernel.derivative(known, felt, start, workspace, self.called_off)?;
        let (n, modes) = (felt.len(), kernel.model().modes());
        let mut matrix = Mat::zeros(n, n);
        for j in 0..n {
            let (own, column) = (moved.col_as_slice_mut(j), matrix.col_as_slice_mut(j));
            norm.project(own);
            for ((value, &i), scale) in column.iter_mut().zip(felt).zip(scales) {
                *value = scale * own[i] / scales[j];
            }
            apart.clean(j, |place| felt[place] % modes, column);
        }
        Ok(matrix)
    }
}

impl<F: Family> CycleMap for DriveMap<'_, F> {
    fn dimension(&self) -> usize {
        self.felt.len()
    }

    fn unit(&self) -> u32 {
        self.unit
    }

    fn image(&mut self, u: &[f64], at: At, period: u32) -> Result<Image, MapError> {
        self.surely(at, |own| {
            own.trace(u, period)?;
            Ok(Image {
                end: own.traced_end(),
                monodromy: own.derivative(u, period)?,
            })
        })
    }

    fn end(&mut self, u: &[f64], at: At, period: u32) -> Result<Vec<f64>, MapError> {
        self.surely(at, |own| {
            own.trace(u, period)?;
            Ok(own.traced_end())
        })
    }

    fn by_parameter(
        &mut self,
        u: &[f64],
        at: At,
        period: u32,
        axis: usize,
    ) -> Result<Vec<f64>, MapError> {
        let by = self
            .family
            .derivative(at, axis)
            .map_err(MapError::NoModel)?;
        self.surely(at, |own| {
            let mut state = own.state(u);
            let start = vec![0.0; state.state.len()];
            let Built {
                kernel, workspace, ..
            } = &mut own.built;
            let mut tangent = ParameterTangent::new(kernel.model(), &by, &state.state, start, ());
            Interruptible::new(&*kernel, own.called_off).advance(
                u64::from(period),
                &mut state,
                workspace,
                &mut tangent,
                &mut Counters::default(),
            )?;
            let end = tangent.state().to_vec();
            Ok(own.coordinates(&end))
        })
    }

    fn details(&mut self, u: &[f64], at: At, period: u32) -> Result<Details, MapError> {
        self.surely(at, |own| own.watched(u, period))
    }
}

impl<F: Family> DriveMap<'_, F> {
    /// What the way of some cycles from u is like at the parameters last asked for.
    fn watched(&mut self, u: &[f64], period: u32) -> Result<Details, MapError> {
        let mut state = self.state(u);
        let mut strobes = Vec::with_capacity(period as usize);
        let Built {
            kernel, workspace, ..
        } = &mut self.built;
        let mut watch = Watch::new(kernel.model());
        let mut starts = Vec::with_capacity(period as usize);
        for _ in 0..period {
            starts.push(state.state.clone());
            Interruptible::new(&*kernel, self.called_off).advance(
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
        strobes.extend(starts.iter().map(|state| self.coordinates(state)));
        let swing = 0.5 * (motion.largest - motion.smallest) / half_gap;
        let farthest = strobes.iter().map(|u| length(u)).fold(0.0, f64::max);
        Ok(Details {
            size: touches.swing().max(swing).max(LEAST_SWING * farthest),
            strobes,
            touches,
            motion,
        })
    }
}
