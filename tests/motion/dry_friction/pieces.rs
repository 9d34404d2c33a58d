//! An oscillator of unit mass and unit stiffness with dry friction, in pieces with closed forms:
//! `x'' + c x' + x + f = P cos ωt`, `f = ±F` while it slips, `x' = u` while it sticks.

use gearatlas::model::{Model, TrajectoryState};
use num_complex::{Complex64, c64};

/// The oscillator.
#[derive(Debug, Clone, Copy)]
pub struct Rubbing {
    /// Damping c.
    pub damping: f64,
    /// Force of sliding friction F.
    pub force: f64,
    /// Largest force of static friction F_s.
    pub static_force: f64,
    /// Speed of the belt u.
    pub belt_speed: f64,
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
    /// 0 while it sticks, else the direction of its slip.
    pub way: f64,
}

/// Number of checks of signs per unit of time.
const LOOKS: f64 = 2000.0;

impl Rubbing {
    /// The direction in which the trajectory of a model slips.
    pub fn way(&self, model: &Model, at: &TrajectoryState) -> f64 {
        let [forwards, backwards] = model.frictions[0]
            .slips()
            .map(|slip| at.contact.holds(slip));
        f64::from(u8::from(forwards)) - f64::from(u8::from(backwards))
    }

    /// Displacement and velocity at a time `tau` after a state, without an event in between.
    fn after(&self, from: &State, tau: f64) -> [f64; 2] {
        if from.way == 0.0 {
            return [from.x + self.belt_speed * tau, self.belt_speed];
        }
        let (omega, c) = (self.frequency, self.damping);
        let response = self.load / c64(1.0 - omega * omega, c * omega);
        let forced = |time: f64| {
            let turned = response * Complex64::cis(omega * time);
            [
                turned.re - from.way * self.force,
                (turned * c64(0.0, omega)).re,
            ]
        };
        let natural = (1.0 - 0.25 * c * c).sqrt();
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

    /// The force that holds the mass on the belt.
    fn holding(&self, x: f64, time: f64) -> f64 {
        self.load * (self.frequency * time).cos() - x - self.damping * self.belt_speed
    }

    /// The next state after a time `tau`; `None` if the present one continues.
    fn follows(&self, from: &State, tau: f64) -> Option<f64> {
        let [x, v] = self.after(from, tau);
        let held = self.holding(x, from.time + tau);
        if from.way == 0.0 {
            return (held.abs() > self.static_force).then(|| held.signum());
        }
        let ends = from.way * (v - self.belt_speed) < 0.0;
        let turns = from.way * held < -self.static_force;
        ends.then(|| if turns { -from.way } else { 0.0 })
    }

    /// The state at a time, and the times of all events up to it with the states after them.
    pub fn follow(&self, start: State, end: f64) -> (State, Vec<(f64, f64)>) {
        let (mut state, mut events) = (start, Vec::new());
        while state.time < end {
            let left = end - state.time;
            let looks = (left * LOOKS).ceil();
            // A slip that begins at rest has a speed of round-off at first.
            let found = (1..=looks as u64).find_map(|look| {
                let tau = left * (look as f64 / looks);
                self.follows(&state, tau).map(|_| tau)
            });
            let Some(mut right) = found else {
                let [x, v] = self.after(&state, left);
                return (
                    State {
                        time: end,
                        x,
                        v,
                        ..state
                    },
                    events,
                );
            };
            let mut from = (right - left / looks).max(0.0);
            for _ in 0..200 {
                let middle = 0.5 * (from + right);
                if self.follows(&state, middle).is_some() {
                    right = middle
                } else {
                    from = middle
                }
            }
            let way = self.follows(&state, right).unwrap_or(0.0);
            let [x, v] = self.after(&state, right);
            let rests = way == 0.0 || state.way != 0.0;
            state = State {
                time: state.time + right,
                x,
                v: if rests { self.belt_speed } else { v },
                way,
            };
            events.push((state.time, way));
        }
        (state, events)
    }
}
