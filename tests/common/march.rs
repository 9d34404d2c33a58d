//! Marching with any kernel, and what was met on the way.

use atlas::model::{InitialState, Model, TrajectoryState};
use atlas::propagate::{Counters, Event, Kernel, Observer, Tangents, Volterra, Window};

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

/// Marches whole cycles without tangents; gives the end and the work done.
pub fn march_with<K: Kernel, O: Observer>(
    kernel: &K,
    start: &TrajectoryState,
    cycles: u64,
    observer: &mut O,
) -> (TrajectoryState, Counters) {
    let mut workspace = kernel.workspace();
    let mut trajectory = start.clone();
    let mut counters = Counters::default();
    for _ in 0..cycles {
        kernel
            .march(
                &mut trajectory,
                &mut Tangents::none(),
                &mut workspace,
                observer,
                &mut counters,
            )
            .unwrap();
    }
    assert_eq!(counters.cycles, cycles);
    (trajectory, counters)
}

/// Marches whole cycles unwatched.
pub fn march<K: Kernel>(kernel: &K, start: &TrajectoryState, cycles: u64) -> TrajectoryState {
    march_with(kernel, start, cycles, &mut ()).0
}

/// The state after some cycles from static equilibrium.
pub fn settled(model: &Model, cycles: u64) -> TrajectoryState {
    march(
        &volterra(model),
        &model.start(&InitialState::Static),
        cycles,
    )
}
