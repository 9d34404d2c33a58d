//! Adaptive solvers of smooth equations, for constant contact: Dormand and Prince's 5(4) (1980) and extrapolation of
//! the explicit midpoint rule (Gragg 1965). Both restart where the stiffness jumps, and use a right-hand side with O(N)
//! work.

use super::field::Field;
use gearatlas_core::model::{Model, TrajectoryState};
use gearatlas_core::numerics::linalg::add_scaled;

/// A solver with its tolerance.
pub trait Adaptive {
    /// Integrates one smooth stretch.
    fn stretch(&mut self, field: &Field, start: f64, end: f64, state: &mut [f64]);

    /// Integrates some mesh cycles of contact: the final state and the number of derivative evaluations.
    fn contact(&mut self, model: &Model, start: &TrajectoryState, cycles: u64) -> (Vec<f64>, u64) {
        let cycle = model.first_cycle();
        let mut field = Field::new(model, start.cycle);
        let mut state = start.state.clone();
        for whole in 0..cycles {
            let offset = whole as f64 * cycle.period;
            let mut from = 0;
            while from < cycle.segments.len() {
                let segment = &cycle.segments[from];
                // Neighbouring segments with equal stiffness form one stretch.
                let mut to = from + 1;
                while cycle
                    .segments
                    .get(to)
                    .is_some_and(|s| s.stiffness == segment.stiffness)
                {
                    to += 1;
                }
                field.switch(start.contact, segment.stiffness.mean(), segment.damping);
                let (begin, end) = (offset + cycle.start(from), offset + cycle.end(to - 1));
                self.stretch(&field, begin, end, &mut state);
                from = to;
            }
        }
        (state, field.evaluations())
    }
}

/// Control of the step size by the error.
struct Control {
    scale: Vec<f64>,
    tolerance: f64,
    order: f64,
    step: f64,
}

impl Control {
    fn new(scale: &[f64], tolerance: f64, order: f64) -> Self {
        Self {
            scale: scale.to_vec(),
            tolerance,
            order,
            step: 1e-7,
        }
    }

    /// Error of a step in units of the tolerance.
    fn size(&self, error: &[f64], state: &[f64]) -> f64 {
        let terms = error.iter().zip(state).zip(&self.scale);
        let sum: f64 = terms
            .map(|((e, y), s)| (e / (self.tolerance * (s + y.abs()))).powi(2))
            .sum();
        (sum / state.len() as f64).sqrt()
    }

    /// Updates the step size after a step; returns whether the step is accepted.
    fn judge(&mut self, h: f64, cut: bool, error: f64) -> bool {
        let growth = (0.9 * error.powf(-1.0 / self.order)).clamp(0.2, 5.0);
        let good = error <= 1.0;
        let next = h * if good { growth } else { growth.min(0.9) };
        // A step that a breakpoint cuts does not shorten the next step.
        self.step = if good && cut { self.step.max(next) } else { next };
        good
    }
}

fn integrate(
    control: &mut Control,
    [start, end]: [f64; 2],
    state: &mut [f64],
    mut attempt: impl FnMut(f64, f64, &[f64], &mut [f64], &mut [f64]),
) {
    let (mut next, mut error) = (vec![0.0; state.len()], vec![0.0; state.len()]);
    let mut time = start;
    while time < end {
        let cut = time + 1.000_001 * control.step >= end;
        let h = if cut { end - time } else { control.step };
        attempt(time, h, state, &mut next, &mut error);
        let size = control.size(&error, &next);
        assert!(size.is_finite() && h > 1e-16, "the step vanishes");
        if control.judge(h, cut, size) {
            state.copy_from_slice(&next);
            time = if cut { end } else { time + h };
        }
    }
}

/// Dormand and Prince's pair.
pub struct RungeKutta {
    control: Control,
    slopes: [Vec<f64>; 7],
    stage: Vec<f64>,
}

const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const ROWS: [&[f64]; 7] = [
    &[],
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
    ],
    &[
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
    ],
    &[
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

impl RungeKutta {
    pub fn new(scale: &[f64], tolerance: f64) -> Self {
        let room = vec![0.0; scale.len()];
        Self {
            control: Control::new(scale, tolerance, 5.0),
            slopes: std::array::from_fn(|_| room.clone()),
            stage: room,
        }
    }
}

impl Adaptive for RungeKutta {
    fn stretch(&mut self, field: &Field, start: f64, end: f64, state: &mut [f64]) {
        let (slopes, stage) = (&mut self.slopes, &mut self.stage);
        integrate(
            &mut self.control,
            [start, end],
            state,
            |time, h, state, next, error| {
                for i in 0..7 {
                    stage.copy_from_slice(state);
                    for (slope, a) in slopes.iter().zip(ROWS[i]) {
                        add_scaled(stage, h * a, slope);
                    }
                    field.derivative(time + NODES[i] * h, stage, &mut slopes[i]);
                }
                // The last stage is the solution.
                next.copy_from_slice(stage);
                error.fill(0.0);
                for (slope, e) in slopes.iter().zip(ERROR) {
                    add_scaled(error, h * e, slope);
                }
            },
        );
    }
}

/// Columns of the extrapolation table; its order is twice this number.
const COLUMNS: usize = 7;

/// Extrapolation of the midpoint rule with 2, 4, 6, … substeps.
pub struct Extrapolation {
    control: Control,
    table: [Vec<f64>; COLUMNS],
    room: [Vec<f64>; 3],
}

impl Extrapolation {
    pub fn new(scale: &[f64], tolerance: f64) -> Self {
        let room = vec![0.0; scale.len()];
        Self {
            // The error estimate comes from the column before the last.
            control: Control::new(scale, tolerance, (2 * COLUMNS - 1) as f64),
            table: std::array::from_fn(|_| room.clone()),
            room: std::array::from_fn(|_| room.clone()),
        }
    }
}

impl Adaptive for Extrapolation {
    fn stretch(&mut self, field: &Field, start: f64, end: f64, state: &mut [f64]) {
        let (table, [before, now, slope]) = (&mut self.table, &mut self.room);
        integrate(
            &mut self.control,
            [start, end],
            state,
            |time, h, state, next, error| {
                for row in 0..COLUMNS {
                    let count = 2 * (row + 1);
                    let part = h / count as f64;
                    before.copy_from_slice(state);
                    now.copy_from_slice(state);
                    field.derivative(time, state, slope);
                    add_scaled(now, part, slope);
                    for i in 1..count {
                        field.derivative(time + i as f64 * part, now, slope);
                        add_scaled(before, 2.0 * part, slope);
                        std::mem::swap(before, now);
                    }
                    // Row by row, entry k of the table becomes column k of this row.
                    let mut fresh = now.clone();
                    for column in 0..row {
                        let ratio = (count as f64 / (2 * (row - column)) as f64).powi(2);
                        for (fresh, old) in fresh.iter_mut().zip(&mut table[column]) {
                            let better = *fresh + (*fresh - *old) / (ratio - 1.0);
                            *old = *fresh;
                            *fresh = better;
                        }
                    }
                    table[row] = fresh;
                }
                next.copy_from_slice(&table[COLUMNS - 1]);
                let last_but_one = &table[COLUMNS - 2];
                for ((error, a), b) in error.iter_mut().zip(next.iter()).zip(last_but_one) {
                    *error = a - b;
                }
            },
        );
    }
}
