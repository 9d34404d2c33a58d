//! Control of a solver of smooth equations across breakpoints and events: it restarts at each.

use crate::field::Field;
use gearatlas::model::{Model, TrajectoryState};

/// A failed solver.
#[derive(Debug)]
pub struct Failure(pub String);

/// A solver of smooth initial-value problems that stops at an event.
pub trait SmoothSolver {
    /// Advances `state` from `start` to `end`, or to the first event, whose time and contact it returns. The equations
    /// changed since the last call.
    fn piece(
        &mut self,
        field: &Field,
        start: f64,
        end: f64,
        state: &mut [f64],
    ) -> Result<Option<(f64, usize)>, Failure>;
}

/// Advances whole mesh cycles; returns the state and the number of derivative evaluations.
///
/// In flight the mesh stiffness does not matter, so that breakpoints need no restart.
pub fn advance(
    solver: &mut impl SmoothSolver,
    model: &Model,
    start: &TrajectoryState,
    cycles: u64,
) -> Result<(Vec<f64>, u64), Failure> {
    let cycle = model.first_cycle();
    let segments = cycle.segments.len();
    let mut field = Field::new(model, start.cycle);
    let mut state = start.state.clone();
    let mut contact = start.contact;
    let stop = cycle.period * cycles as f64;
    // Segments are counted through all cycles.
    let end_of = |place: usize| {
        let (whole, index) = (place / segments, place % segments);
        cycle.period * (whole as f64 + cycle.segments[index].end)
    };
    let (mut time, mut place, mut events) = (0.0, 0, 0);
    while time < stop {
        while end_of(place) <= time {
            place += 1;
        }
        let segment = &cycle.segments[place % segments];
        field.switch(contact, segment.stiffness.mean(), segment.damping);
        let end = if contact.touching() { end_of(place) } else { stop };
        match solver.piece(&field, time, end, &mut state)? {
            Some((reached, crossed)) => {
                time = reached;
                contact = contact.toggled(crossed);
                events += 1;
            }
            None => time = end,
        }
        if events > 100 * cycles {
            return Err(Failure("more than 100 events a cycle".into()));
        }
    }
    Ok((state, field.evaluations()))
}
