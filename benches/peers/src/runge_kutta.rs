//! Explicit Runge–Kutta pairs of high order, written for speed: DOP853 (Hairer, Nørsett & Wanner 1993) and Verner's
//! (2010) 9(8). Coefficients from the `differential-equations` crate.
//!
//! Integration allocates nothing, zero coefficients cost nothing, and events keep the step size. Newton's method
//! locates an event. Each of its evaluations is a separate step, so that no interpolant limits the accuracy.

use crate::events::{Failure, SmoothSolver};
use crate::field::Field;
use differential_equations::tableau::ButcherTableau;

/// Coefficients with their stages, without zeros.
type Row = Vec<(usize, f64)>;

/// Estimate of the local error.
enum Estimate {
    /// Difference of the two weights of a pair.
    Pair(Row),
    /// Hairer's combination of a fifth- and a third-order estimate.
    Combined(Row, Row),
}

/// An explicit pair with its step control.
pub struct RungeKutta {
    nodes: Vec<f64>,
    rows: Vec<Row>,
    weights: Row,
    estimate: Estimate,
    order: f64,
    tolerance: f64,
    scale: Vec<f64>,
    /// Next trial step \[s\].
    step: f64,
    slopes: Vec<Vec<f64>>,
    stage: Vec<f64>,
    next: Vec<f64>,
    errors: [Vec<f64>; 2],
}

fn row(coefficients: impl IntoIterator<Item = f64>) -> Row {
    let all = coefficients.into_iter().enumerate();
    all.filter(|(_, a)| *a != 0.0).collect()
}

impl RungeKutta {
    /// DOP853: order 8, 12 stages.
    pub fn dop853(tolerance: f64, scale: &[f64]) -> Self {
        let tableau = ButcherTableau::<f64, 12, 16>::dop853();
        let third = tableau.bh.expect("DOP853 has a third-order weight");
        let fifth = tableau.er.expect("DOP853 has a fifth-order estimate");
        let third = row(tableau.b.iter().zip(third).map(|(b, h)| b - h));
        let estimate = Estimate::Combined(row(fifth), third);
        Self::new(&tableau, estimate, 8.0, tolerance, scale)
    }

    /// Verner's efficient 9(8): 16 stages.
    pub fn verner98(tolerance: f64, scale: &[f64]) -> Self {
        let tableau = ButcherTableau::<f64, 16, 21>::rkv988e();
        let lower = tableau.bh.expect("the pair has lower-order weights");
        let estimate = Estimate::Pair(row(tableau.b.iter().zip(lower).map(|(b, h)| b - h)));
        Self::new(&tableau, estimate, 9.0, tolerance, scale)
    }

    fn new<const S: usize, const I: usize>(
        tableau: &ButcherTableau<f64, S, I>,
        estimate: Estimate,
        order: f64,
        tolerance: f64,
        scale: &[f64],
    ) -> Self {
        let n = scale.len();
        Self {
            nodes: tableau.c[..S].to_vec(),
            rows: (0..S).map(|i| row(tableau.a[i][..i].to_vec())).collect(),
            weights: row(tableau.b),
            estimate,
            order,
            tolerance,
            scale: scale.to_vec(),
            step: 1e-7,
            slopes: vec![vec![0.0; n]; S],
            stage: vec![0.0; n],
            next: vec![0.0; n],
            errors: [vec![0.0; n], vec![0.0; n]],
        }
    }

    /// Sets `next` to the state after `h`, with a known first slope.
    fn advance(&mut self, field: &Field, time: f64, h: f64, state: &[f64]) {
        for i in 1..self.nodes.len() {
            self.stage.copy_from_slice(state);
            for &(j, a) in &self.rows[i] {
                add_scaled(&mut self.stage, h * a, &self.slopes[j]);
            }
            field.derivative(time + self.nodes[i] * h, &self.stage, &mut self.slopes[i]);
        }
        self.next.copy_from_slice(state);
        for &(j, b) in &self.weights {
            add_scaled(&mut self.next, h * b, &self.slopes[j]);
        }
    }

    /// Local error of the last step in units of the tolerance.
    fn error(&mut self, h: f64, state: &[f64]) -> f64 {
        let rows = match &self.estimate {
            Estimate::Pair(row) => [Some(row), None],
            Estimate::Combined(fifth, third) => [Some(fifth), Some(third)],
        };
        let mut squares = [0.0; 2];
        for (slot, row) in rows.iter().enumerate() {
            let Some(row) = row else { continue };
            let error = &mut self.errors[slot];
            error.fill(0.0);
            for &(j, e) in *row {
                add_scaled(error, e, &self.slopes[j]);
            }
            for (((e, y), z), s) in error.iter().zip(state).zip(&self.next).zip(&self.scale) {
                let unit = self.tolerance * (s + y.abs().max(z.abs()));
                squares[slot] += (e / unit).powi(2);
            }
        }
        let n = state.len() as f64;
        match self.estimate {
            Estimate::Pair(_) => h * (squares[0] / n).sqrt(),
            Estimate::Combined(..) => {
                let sum = squares[0] + 0.01 * squares[1];
                if sum == 0.0 { 0.0 } else { h * squares[0] / (sum * n).sqrt() }
            }
        }
    }

    /// Shortens the last step to its event and writes the state there to `next`; returns the time from the step's
    /// start.
    fn locate(
        &mut self,
        field: &Field,
        time: f64,
        h: f64,
        state: &[f64],
        before: (f64, f64),
        after: (f64, f64),
    ) -> f64 {
        let mut tau = h * hermite_zero(before, after, h);
        let precise = field.half_gap * (1e-3 * self.tolerance).max(4e-16);
        for _ in 0..10 {
            self.advance(field, time, tau, state);
            let (margin, rate) = field.margin(time + tau, &self.next);
            if margin.abs() <= precise {
                break;
            }
            let next = tau - margin / rate;
            tau = if next > 0.0 && next <= h { next } else { 0.5 * tau };
        }
        tau
    }
}

impl SmoothSolver for RungeKutta {
    fn piece(
        &mut self,
        field: &Field,
        start: f64,
        end: f64,
        state: &mut [f64],
    ) -> Result<Option<(f64, usize)>, Failure> {
        let mut time = start;
        let mut rejected = false;
        let mut before = field.margin(time, state);
        field.derivative(time, state, &mut self.slopes[0]);
        while time < end {
            let cut = time + 1.000_001 * self.step >= end;
            let h = if cut { end - time } else { self.step };
            self.advance(field, time, h, state);
            let error = self.error(h, state);
            if error.is_nan() {
                return Err(Failure("the state is not finite".into()));
            }
            let growth = (0.9 * error.powf(-1.0 / self.order)).clamp(1.0 / 3.0, 6.0);
            if error > 1.0 {
                rejected = true;
                self.step = h * growth.min(0.9);
                if self.step < 1e-15 {
                    return Err(Failure("the step vanishes".into()));
                }
                continue;
            }
            let reached = if cut { end } else { time + h };
            let after = field.margin(reached, &self.next);
            if after.0 < 0.0 {
                let tau = self.locate(field, time, h, state, before, after);
                state.copy_from_slice(&self.next);
                let reached = time + tau;
                return Ok(Some((reached, field.nearest(reached, state))));
            }
            let growth = if rejected { growth.min(1.0) } else { growth };
            rejected = false;
            // A step that a breakpoint cuts does not shorten the next step.
            self.step = if cut { self.step.max(h * growth) } else { h * growth };
            state.copy_from_slice(&self.next);
            time = reached;
            before = after;
            if time < end {
                field.derivative(time, state, &mut self.slopes[0]);
            }
        }
        Ok(None)
    }
}

/// Position in (0, 1) where the cubic through values and rates at both ends becomes negative; it counts as positive at
/// 0.
pub fn hermite_zero(before: (f64, f64), after: (f64, f64), h: f64) -> f64 {
    let value = |x: f64| {
        let y = 1.0 - x;
        before.0 * y * y * (1.0 + 2.0 * x)
            + after.0 * x * x * (3.0 - 2.0 * x)
            + h * x * y * (before.1 * y - after.1 * x)
    };
    let (mut left, mut right) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (left + right);
        if value(middle) > 0.0 {
            left = middle;
        } else {
            right = middle;
        }
    }
    right
}

fn add_scaled(to: &mut [f64], scale: f64, by: &[f64]) {
    for (value, b) in to.iter_mut().zip(by) {
        *value += scale * b;
    }
}
