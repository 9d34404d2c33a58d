//! Integration with any kernel, and its events.

use super::state_difference;
use gearatlas::model::{FlankError, InitialState, Model, Stiffness, TrajectoryState};
use gearatlas::propagate::{
    Counters, Event, Interruptible, Kernel, Observer, Stop, Volterra, Window,
};
use std::sync::atomic::{AtomicBool, Ordering};

/// Tolerance of a kernel that works to round-off.
pub const ROUND_OFF: f64 = f64::EPSILON;

/// The structured kernel to round-off.
pub fn volterra(model: &Model) -> Volterra<'_> {
    Volterra::new(model, ROUND_OFF, 10_000)
}

/// Stores every event.
#[derive(Debug, Default)]
pub struct Events(pub Vec<Event>);

impl Observer for Events {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

/// Advances whole cycles without tangents; returns the end and the work.
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

/// Advances whole cycles without an observer.
pub fn advance<K: Kernel>(kernel: &K, start: &TrajectoryState, cycles: u64) -> TrajectoryState {
    advance_with(kernel, start, cycles, &mut ()).0
}

/// Static equilibrium of the mean stiffness without errors. It differs from the equilibrium of the mesh at phase 0, so
/// that every drive of the tests rattles from it.
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

/// The state after some cycles from [`mean_equilibrium`].
pub fn settled(model: &Model, cycles: u64) -> TrajectoryState {
    advance(&volterra(model), &mean_equilibrium(model), cycles)
}

/// Asserts over ten cycles that a kernel agrees with `volterra`, up to the growth of round-off.
pub fn follows_volterra<K: Kernel>(name: &str, model: &Model, kernel: &K) {
    let exact = Volterra::new(model, ROUND_OFF, 1000);
    let mut start = settled(model, 20);
    let mut compared = 0;
    for _ in 0..10 {
        let (mut seen, mut told) = (Events::default(), Events::default());
        let (end, _) = advance_with(&exact, &start, 1, &mut seen);
        let (found, _) = advance_with(kernel, &start, 1, &mut told);
        let moved: Vec<f64> = start.state.iter().map(|x| x * (1.0 + 1e-9)).collect();
        let beside = TrajectoryState {
            state: moved,
            ..start.clone()
        };
        let (beside, _) = advance_with(&exact, &beside, 1, &mut Events::default());
        let gain: f64 = 1e9 * state_difference(model, &beside.state, &end.state);
        if gain < 1e3 {
            let off = state_difference(model, &found.state, &end.state);
            assert!(off < 1e-12 * gain.max(1.0), "{name}: {off:e} {gain:e}");
            assert_eq!(told.0.len(), seen.0.len(), "{name}");
            compared += 1;
        }
        start = end;
    }
    assert!(compared > 3, "{name}: {compared}");
}

/// Counts the windows of a cycle that a flag interrupts at the third window, and the windows of a whole cycle.
pub fn cut_short<K: Kernel>(model: &Model, kernel: &K) -> [u64; 2] {
    struct Raising<'a>(u64, &'a AtomicBool);
    impl Observer for Raising<'_> {
        const WINDOWS: bool = true;

        fn window(&mut self, _: &Window<'_>) {
            self.0 += 1;
            self.1.store(self.0 == 3, Ordering::Relaxed);
        }
    }
    let flag = AtomicBool::new(false);
    let never = AtomicBool::new(false);
    [&flag, &never].map(|watched| {
        let kernel = Interruptible::new(kernel, watched);
        let mut raising = Raising(0, &flag);
        let ended = kernel.advance(
            1,
            &mut model.start(&InitialState::Static),
            &mut kernel.workspace(),
            &mut raising,
            &mut Counters::default(),
        );
        let off = matches!(ended, Err(Stop::Interrupted { cycle: 0 }));
        assert_eq!(off, std::ptr::eq(watched, &flag));
        raising.0
    })
}
