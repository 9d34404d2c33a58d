//! What integrates a drive at some parameters: closed modes on bases that all parameters share, where these leave structure
//! and mesh as they are; else the structured kernel.

use crate::model::{Model, TrajectoryState};
use crate::numerics::instructions::portable;
use crate::propagate::{
    ClosedModes, Counters, DenseError, InstructionSet, Interruptible, Kernel, Leg, Observer,
    SharedBases, Stop, Tangents, Volterra,
};
use faer::Mat;
use std::sync::atomic::AtomicBool;

/// The kernel of a model.
#[derive(Debug)]
pub(super) enum Integrator {
    /// Closed modes.
    Closed(Box<ClosedModes<'static>>),
    /// The structured kernel.
    Structured(Box<Volterra<'static>>),
}

/// Scratch memory of either.
#[derive(Debug)]
pub(super) enum Work {
    Closed(<ClosedModes<'static> as Kernel>::Workspace),
    Structured(<Volterra<'static> as Kernel>::Workspace),
}

/// The bases of a model's structure and mesh; none where every speed has its own, the bits are to be those of every
/// processor, or closed modes do not take the model.
pub fn bases(model: &Model) -> Option<SharedBases> {
    let turns = model.basis.coupled().is_some_and(|coupled| coupled.turns);
    match turns || portable() {
        true => None,
        false => SharedBases::new(model).ok(),
    }
}

impl Integrator {
    /// That of a model.
    ///
    /// # Errors
    /// [`DenseError`] where a kernel on shared bases cannot be built.
    pub fn new(
        model: Model,
        event_limit: u32,
        shared: Option<&SharedBases>,
    ) -> Result<Self, DenseError> {
        let model = match shared {
            Some(shared) => {
                let set = InstructionSet::best();
                match ClosedModes::on_shared(model, event_limit, shared, set)? {
                    Ok(kernel) => return Ok(Self::Closed(Box::new(kernel))),
                    Err(model) => *model,
                }
            }
            None => model,
        };
        let kernel = Volterra::of(model, f64::EPSILON, event_limit);
        Ok(Self::Structured(Box::new(kernel)))
    }

    pub fn model(&self) -> &Model {
        match self {
            Self::Closed(kernel) => kernel.model(),
            Self::Structured(kernel) => kernel.model(),
        }
    }

    /// Advances a trajectory by some cycles; where it has been, of closed modes.
    ///
    /// # Errors
    /// [`Stop`] as for any integration.
    pub fn trace(
        &self,
        state: &mut TrajectoryState,
        cycles: u32,
        work: &mut Work,
        called_off: &AtomicBool,
    ) -> Result<Vec<Leg>, Stop> {
        if let Work::Closed(own) = work {
            own.note_legs();
        }
        let mut counters = Counters::default();
        let attentive = Interruptible::new(self, called_off);
        let done = attentive.advance(u64::from(cycles), state, work, &mut (), &mut counters);
        let legs = match work {
            Work::Closed(own) => own.take_legs(),
            Work::Structured(_) => Vec::new(),
        };
        done.map(|()| legs)
    }

    /// The derivative of a trajectory's end by its start, 2N rows, first components of the model's blocks, then second ones,
    /// for the components `from` of the start: of closed modes from where the trajectory has been, else by tangents, with
    /// which it is advanced by some cycles again.
    ///
    /// # Errors
    /// [`Stop`] as for any integration.
    pub fn derivative(
        &self,
        (shared, legs): (Option<&SharedBases>, &[Leg]),
        from: &[usize],
        (mut state, cycles): (TrajectoryState, u32),
        work: &mut Work,
        called_off: &AtomicBool,
    ) -> Result<Mat<f64>, Stop> {
        if let (Self::Closed(kernel), Some(shared)) = (self, shared) {
            let cycle = state.cycle;
            return (kernel.derivative(shared, from, legs))
                .map_err(|error| Stop::Refused { cycle, error });
        }
        let mut tangents = Tangents::zeros(self.model().modes(), from.len());
        for (column, &i) in from.iter().enumerate() {
            tangents.vector_mut(column)[i] = 1.0;
        }
        let attentive = Interruptible::new(self, called_off);
        for _ in 0..cycles {
            let mut counters = Counters::default();
            attentive.advance_cycle(&mut state, &mut tangents, work, &mut (), &mut counters)?;
        }
        let mut moved = Mat::zeros(state.state.len(), from.len());
        for j in 0..from.len() {
            (moved.col_as_slice_mut(j)).copy_from_slice(tangents.vector(j));
        }
        Ok(moved)
    }
}

impl Kernel for Integrator {
    type Workspace = Work;

    fn workspace(&self) -> Work {
        match self {
            Self::Closed(kernel) => Work::Closed(kernel.workspace()),
            Self::Structured(kernel) => Work::Structured(kernel.workspace()),
        }
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Work,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        match (self, workspace) {
            (Self::Closed(kernel), Work::Closed(own)) => {
                kernel.advance_cycle(trajectory, tangents, own, observer, counters)
            }
            (Self::Structured(kernel), Work::Structured(own)) => {
                kernel.advance_cycle(trajectory, tangents, own, observer, counters)
            }
            _ => unreachable!("scratch memory is that of its own kernel"),
        }
    }
}
