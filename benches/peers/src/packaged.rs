//! DOP853 from the `differential-equations` crate, with its steps and step control.
//!
//! The crate's interpolant is right only up to the cubic part (version 0.7.0 exchanges s and 1 − s in the terms of
//! higher degree). Therefore Newton's method locates events with steps of the crate, as in `runge_kutta`.

use crate::events::{Failure, SmoothSolver};
use crate::field::Field;
use crate::runge_kutta::hermite_zero;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};

/// The crate's DOP853 at one tolerance.
pub struct Packaged {
    tolerance: f64,
    absolute: Vec<f64>,
    /// First step of the next piece \[s\].
    step: f64,
}

impl Packaged {
    /// The solver with relative tolerance `tolerance` and absolute tolerances `tolerance · scale`.
    pub fn new(tolerance: f64, scale: &[f64]) -> Self {
        Self {
            tolerance,
            absolute: scale.iter().map(|s| tolerance * s).collect(),
            step: 1e-7,
        }
    }
}

impl Packaged {
    /// Writes the state at the event of a step to `state`; returns its time from the step's start.
    fn locate(
        &self,
        field: &Field,
        time: f64,
        h: f64,
        previous: &Vec<f64>,
        after: (f64, f64),
        state: &mut [f64],
    ) -> Result<f64, Failure> {
        let mut tau = h * hermite_zero(field.margin(time, previous), after, h);
        let precise = field.half_gap * (1e-3 * self.tolerance).max(4e-16);
        for _ in 0..10 {
            // Take one step and accept any error, because the longer step was accepted.
            let mut single = ExplicitRungeKutta::dop853().rtol(1e30).atol(1e30).h0(tau);
            let there = (single.init(&Equations(field), time, time + 2.0 * tau, previous))
                .and_then(|_| single.step(&Equations(field)));
            there.map_err(|e| failed(&e))?;
            state.copy_from_slice(single.y());
            let (margin, rate) = field.margin(time + tau, state);
            if margin.abs() <= precise {
                break;
            }
            let next = tau - margin / rate;
            tau = if next > 0.0 && next <= h { next } else { 0.5 * tau };
        }
        Ok(tau)
    }
}

fn failed(error: &dyn std::fmt::Debug) -> Failure {
    Failure(format!("{error:?}").chars().take(60).collect())
}

struct Equations<'f>(&'f Field);

impl ODE<f64, Vec<f64>> for Equations<'_> {
    fn diff(&self, time: f64, state: &Vec<f64>, out: &mut Vec<f64>) {
        self.0.derivative(time, state, out);
    }
}

impl SmoothSolver for Packaged {
    fn piece(
        &mut self,
        field: &Field,
        start: f64,
        end: f64,
        state: &mut [f64],
    ) -> Result<Option<(f64, usize)>, Failure> {
        if end - start <= f64::EPSILON * end {
            return Ok(None);
        }
        let equations = Equations(field);
        let mut solver = ExplicitRungeKutta::dop853()
            .rtol(self.tolerance)
            .atol(self.absolute.clone())
            .max_steps(1_000_000)
            .h0(self.step.min(0.5 * (end - start)));
        solver
            .init(&equations, start, end, &state.to_vec())
            .map_err(|e| failed(&e))?;
        loop {
            let wanted = solver.h();
            let rest = end - solver.t();
            if wanted > rest {
                solver.set_h(rest);
            }
            let before = solver.t();
            solver.step(&equations).map_err(|e| failed(&e))?;
            let reached = solver.t();
            if reached == before {
                continue;
            }
            self.step = solver.h().max(wanted.min(rest));
            let after = field.margin(reached, solver.y());
            if after.0 < 0.0 {
                let previous = solver.y_prev().clone();
                let tau = self.locate(field, before, reached - before, &previous, after, state)?;
                let reached = before + tau;
                return Ok(Some((reached, field.nearest(reached, state))));
            }
            if reached >= end * (1.0 - f64::EPSILON) {
                state.copy_from_slice(solver.y());
                return Ok(None);
            }
        }
    }
}
