//! An oscillator of unit mass with one dry slider, piece by piece in closed form:
//! `x'' + c x' + κ x + f = P cos ωt`, `f = k (x − s)` while it sticks, `f = ±F` while it slips.

use num_complex::{Complex64, c64};

/// The oscillator.
#[derive(Debug, Clone, Copy)]
pub struct Oscillator {
    /// Stiffness κ to the ground.
    pub stiffness: f64,
    /// Damping c.
    pub damping: f64,
    /// Stiffness k of the element.
    pub spring: f64,
    /// Force F at which the slider slips.
    pub limit: f64,
    /// Amplitude of the load P.
    pub load: f64,
    /// Frequency of the load ω.
    pub frequency: f64,
}

/// A state of the oscillator.
#[derive(Debug, Clone, Copy)]
pub struct State {
    pub time: f64,
    pub x: f64,
    pub v: f64,
    /// Position of the slider.
    pub s: f64,
    /// 0 while it sticks, else the direction of its slip.
    pub way: f64,
}

/// Number of samples of a sign per shorter natural period.
const LOOKS: f64 = 2e3;

impl Oscillator {
    /// Displacement and velocity some time after a state, without an event in between.
    fn after(&self, from: &State, tau: f64) -> [f64; 2] {
        let sticks = from.way == 0.0;
        let stiffness = self.stiffness + if sticks { self.spring } else { 0.0 };
        let force = if sticks { self.spring * from.s } else { -from.way * self.limit };
        let (omega, c) = (self.frequency, self.damping);
        let response = self.load / c64(stiffness - omega * omega, c * omega);
        let forced = |time: f64| {
            let turned = response * Complex64::cis(omega * time);
            [force / stiffness + turned.re, (turned * c64(0.0, omega)).re]
        };
        let natural = (stiffness - 0.25 * c * c).sqrt();
        let [x0, v0] = forced(from.time);
        let (a, growth) = (from.x - x0, -0.5 * c);
        let b = (from.v - v0 - growth * a) / natural;
        let [x1, v1] = forced(from.time + tau);
        let (sin, cos) = (natural * tau).sin_cos();
        let fall = (growth * tau).exp();
        [
            x1 + fall * (a * cos + b * sin),
            v1 + fall * ((growth * a + natural * b) * cos + (growth * b - natural * a) * sin),
        ]
    }

    /// Margins that are positive until the next event, and the slip direction after it.
    fn margins(&self, from: &State, [x, v]: [f64; 2]) -> [(f64, f64); 2] {
        if from.way != 0.0 {
            return [(from.way * v, 0.0); 2];
        }
        let most = self.limit / self.spring;
        [1.0, -1.0].map(|way| (most - way * (x - from.s), way))
    }

    /// The state at a time, and the times of all events until then.
    pub fn follow(&self, start: State, end: f64) -> (State, Vec<f64>) {
        let (mut state, mut events) = (start, Vec::new());
        let look = 1.0 / (self.stiffness + self.spring).sqrt().max(self.frequency) / LOOKS;
        loop {
            let gone = |tau: f64| {
                let margins = self.margins(&state, self.after(&state, tau));
                margins.into_iter().find(|(margin, _)| *margin < 0.0)
            };
            let mut tau = 0.0;
            let mut met = None;
            while state.time + tau < end {
                let next = (tau + look * std::f64::consts::TAU).min(end - state.time);
                if let Some((_, way)) = gone(next) {
                    let (mut left, mut right) = (tau, next);
                    for _ in 0..80 {
                        let middle = 0.5 * (left + right);
                        match gone(middle) {
                            Some(_) => right = middle,
                            None => left = middle,
                        }
                    }
                    met = Some((left, way));
                    break;
                }
                tau = next;
                if state.time + tau >= end {
                    break;
                }
            }
            let (tau, way) = met.unwrap_or((end - state.time, state.way));
            let [x, v] = self.after(&state, tau);
            let slid = x - state.way * self.limit / self.spring;
            state = State {
                time: state.time + tau,
                s: if state.way == 0.0 { state.s } else { slid },
                x,
                v,
                way,
            };
            if met.is_none() {
                return (state, events);
            }
            events.push(state.time);
        }
    }
}
