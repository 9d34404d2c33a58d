//! Integrating with any kernel, and what was met on the way.

use gearatlas::model::{FlankError, InitialState, Model, Stiffness, TrajectoryState};
use gearatlas::propagate::{Counters, Event, Kernel, Observer, Volterra, Window};

/// Tolerance of a kernel that works to round-off.
pub const ROUND_OFF: f64 = f64::EPSILON;

/// The structured kernel to round-off.
pub fn volterra(model: &Model) -> Volterra<'_> {
    Volterra::new(model, ROUND_OFF, 10_000)
}

/// Keeps every event.
#[derive(Debug, Default)]
pub struct Events(pub Vec<Event>);

impl Observer for Events {
    const WINDOWS: bool = false;

    fn window(&mut self, _: &Window<'_>) {}

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

/// Advances whole cycles without tangents; gives the end and the work done.
pub fn advance_with<K: Kernel, O: Observer>(
    kernel: &K,
    start: &TrajectoryState,
    cycles: u64,
    observer: &mut O,
) -> (TrajectoryState, Counters) {
    let mut workspace = kernel.workspace();
    let mut trajectory = start.clone();
    let mut counters = Counters::default();
    kernel
        .advance(
            cycles,
            &mut trajectory,
            &mut workspace,
            observer,
            &mut counters,
        )
        .unwrap();
    assert_eq!(counters.cycles, cycles);
    (trajectory, counters)
}

/// Advances whole cycles unwatched.
pub fn advance<K: Kernel>(kernel: &K, start: &TrajectoryState, cycles: u64) -> TrajectoryState {
    advance_with(kernel, start, cycles, &mut ()).0
}

/// Static equilibrium of the mean stiffness without errors: a start beside the balance of the mesh at
/// phase 0, from which every drive here comes to rattle.
pub fn mean_equilibrium(model: &Model) -> TrajectoryState {
    let mut mean = model.clone();
    mean.lines
        .iter_mut()
        .for_each(|line| line.transmission_error.clear());
    let cycles = mean
        .contacts
        .iter_mut()
        .flat_map(|contact| &mut contact.cycles);
    for segment in cycles.flat_map(|cycle| &mut cycle.segments) {
        segment.stiffness = Stiffness::constant(model.first_cycle().mean_stiffness());
        segment.error = FlankError::NONE;
    }
    let state = mean.start(&InitialState::Static).state;
    TrajectoryState::new(model, state, 0)
}

/// The state after some cycles from there.
pub fn settled(model: &Model, cycles: u64) -> TrajectoryState {
    advance(&volterra(model), &mean_equilibrium(model), cycles)
}
