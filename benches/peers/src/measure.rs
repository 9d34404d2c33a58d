//! Problems, their exact solutions, and the timing of solvers on them.

use crate::clock;
use crate::common;
use crate::events::{self, Failure, SmoothSolver};
use gearatlas::analysis::EnergyNorm;
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel, Tangents};
use gearatlas::reference::{Extended, ExtendedPassage};
use serde_json::{Value, json};
use std::cell::Cell;

/// Mesh cycles of a stretch.
pub const CYCLES: u64 = 5;

/// Consecutive stretches of one trajectory.
const STRETCHES: usize = 4;

/// Cycles integrated before the first stretch.
const TRANSIENT: u64 = 200;

/// Time \[s\] for which one sweep repeats a solver.
const PATIENCE: f64 = 0.07;

/// Largest number of repetitions of a solver in one sweep.
const MOST: usize = 100;

/// A rattling drive, with the starts and the exact ends of its stretches.
pub struct Problem {
    pub name: &'static str,
    pub model: Model,
    pub starts: Vec<TrajectoryState>,
    exact: Vec<ExtendedPassage>,
    norm: EnergyNorm,
    /// Derivative evaluations of the adaptive solvers.
    evaluations: Cell<u64>,
    pub events_per_cycle: f64,
    /// Change of the exact solutions with half the step, half gaps.
    pub uncertainty: f64,
}

/// Results of one solver at one setting.
pub struct Sample {
    solver: String,
    /// Tolerance, or step \[s\].
    setting: f64,
    outcome: Result<Outcome, String>,
}

struct Outcome {
    /// Largest and geometric mean of the stretches' errors, half gaps.
    largest: f64,
    mean: f64,
    /// Derivative evaluations per cycle; zero for solvers without.
    evaluations: f64,
    /// Seconds per cycle of each repetition, ascending.
    times: Vec<f64>,
}

impl Problem {
    /// The problem of a drive.
    pub fn new(name: &'static str, case: &common::Case) -> Self {
        let model = common::model(case);
        let norm = EnergyNorm::new(&model);
        let mut starts = vec![common::advance::settled(&model, TRANSIENT)];
        let mut exact = Vec::new();
        let mut uncertainty = 0.0f64;
        for i in 0..STRETCHES {
            let passage = Extended::new(&model)
                .advance(&starts[i], CYCLES)
                .expect("the stretch has no touch");
            let again = Extended::new(&model)
                .refined(2)
                .advance(&starts[i], CYCLES)
                .expect("the stretch has no touch");
            let difference: Vec<f64> = passage
                .state
                .iter()
                .zip(&again.state)
                .map(|(a, b)| (*a - *b).value())
                .collect();
            uncertainty = uncertainty.max(norm.length(&difference) / norm.unit());
            starts.push(passage.end());
            exact.push(passage);
        }
        starts.truncate(STRETCHES);
        let events: usize = exact.iter().map(|p| p.crossings.len()).sum();
        let events_per_cycle = events as f64 / (STRETCHES as f64 * CYCLES as f64);
        assert!(events_per_cycle > 1.0, "{name} does not rattle");
        Self {
            name,
            model,
            starts,
            exact,
            norm,
            evaluations: Cell::new(0),
            events_per_cycle,
            uncertainty,
        }
    }

    /// The problem in the record.
    pub fn json(&self) -> Value {
        json!({
            "name": self.name,
            "period": self.model.period(),
            "stretches": STRETCHES,
            "events_per_cycle": self.events_per_cycle,
            "uncertainty": self.uncertainty,
        })
    }

    /// The magnitude of each component with the energy of a displacement by half a gap: the unit of the absolute
    /// tolerances. Components outside the norm are not controlled.
    pub fn scale(&self) -> Vec<f64> {
        let scale = |weight: &f64| {
            if *weight > 0.0 { self.norm.unit() / weight } else { 1e30 }
        };
        self.norm.weights().iter().map(scale).collect()
    }

    /// Integrates a stretch by a general-purpose solver.
    pub fn adaptive(
        &self,
        solver: &mut impl SmoothSolver,
        stretch: usize,
    ) -> Result<Vec<f64>, Failure> {
        let (state, evaluations) =
            events::advance(solver, &self.model, &self.starts[stretch], CYCLES)?;
        self.evaluations.set(self.evaluations.get() + evaluations);
        Ok(state)
    }

    /// Integrates stretches by a kernel.
    pub fn kernel<'a, K: Kernel>(
        &'a self,
        kernel: &'a K,
    ) -> impl FnMut(usize) -> Result<Vec<f64>, Failure> + 'a {
        let mut workspace = kernel.workspace();
        move |stretch| {
            let mut trajectory = self.starts[stretch].clone();
            for _ in 0..CYCLES {
                kernel
                    .advance_cycle(
                        &mut trajectory,
                        &mut Tangents::none(),
                        &mut workspace,
                        &mut (),
                        &mut Counters::default(),
                    )
                    .map_err(|stop| Failure(stop.to_string()))?;
            }
            Ok(trajectory.state)
        }
    }

    /// Runs a solver over all stretches, first for its errors and then for its time.
    pub fn measure(
        &self,
        name: &str,
        setting: f64,
        solver: &mut dyn FnMut(usize) -> Result<Vec<f64>, Failure>,
    ) -> Sample {
        Sample {
            solver: name.to_owned(),
            setting,
            outcome: self.outcome(solver).map_err(|Failure(why)| why),
        }
    }

    fn outcome(
        &self,
        solver: &mut dyn FnMut(usize) -> Result<Vec<f64>, Failure>,
    ) -> Result<Outcome, Failure> {
        let mut errors = Vec::new();
        self.evaluations.set(0);
        let mut integrating = 0.0;
        for (i, exact) in self.exact.iter().enumerate() {
            let start = clock::now();
            let state = solver(i)?;
            integrating += clock::now() - start;
            let error = self.norm.length(&exact.difference(&state)) / self.norm.unit();
            if !error.is_finite() {
                return Err(Failure("the state is not finite".into()));
            }
            // An error can be zero in doubles, which has no logarithm.
            errors.push(error.max(f64::EPSILON));
        }
        let logarithms: f64 = errors.iter().map(|e| e.ln()).sum();
        let cycles = STRETCHES as f64 * CYCLES as f64;
        let evaluations = self.evaluations.get() as f64 / cycles;
        let begin = clock::now();
        // A long run needs no warm-up.
        let mut times =
            if integrating > PATIENCE { vec![integrating / cycles] } else { Vec::new() };
        while times.is_empty()
            || (integrating <= PATIENCE && clock::now() - begin < PATIENCE && times.len() < MOST)
        {
            let start = clock::now();
            for i in 0..STRETCHES {
                std::hint::black_box(solver(std::hint::black_box(i))?);
            }
            times.push((clock::now() - start) / cycles);
        }
        times.sort_by(f64::total_cmp);
        Ok(Outcome {
            largest: errors.iter().copied().fold(0.0, f64::max),
            mean: (logarithms / errors.len() as f64).exp(),
            evaluations,
            times,
        })
    }
}

impl Outcome {
    fn quantile(&self, fraction: f64) -> f64 {
        self.times[((self.times.len() - 1) as f64 * fraction).round() as usize]
    }
}

impl Sample {
    /// Adds the repetitions of another sweep.
    pub fn merge(&mut self, again: Self) {
        assert!(self.solver == again.solver && self.setting == again.setting);
        if let (Ok(own), Ok(more)) = (&mut self.outcome, again.outcome) {
            own.times.extend(more.times);
            own.times.sort_by(f64::total_cmp);
        }
    }

    /// One line of progress for the user.
    pub fn line(&self) -> String {
        let what = format!("{:<16} {:>8.0e}", self.solver, self.setting);
        match &self.outcome {
            Ok(o) => format!(
                "{what}: error {:.1e}, {:.1} µs and {:.0} derivatives a cycle, {} repetitions",
                o.largest,
                o.quantile(0.5) * 1e6,
                o.evaluations,
                o.times.len()
            ),
            Err(why) => format!("{what}: {why}"),
        }
    }

    /// The record of the sample; times in seconds per cycle.
    pub fn json(&self, problem: &Problem) -> Value {
        let mut record = json!({
            "problem": problem.name,
            "solver": self.solver,
            "setting": self.setting,
        });
        let more = match &self.outcome {
            Ok(o) => json!({
                "error": o.largest,
                "mean_error": o.mean,
                "derivatives": o.evaluations,
                "time": o.quantile(0.5),
                "time_quartiles": [o.quantile(0.25), o.quantile(0.75)],
                "repetitions": o.times.len(),
            }),
            Err(why) => json!({ "failure": why }),
        };
        if let (Value::Object(record), Value::Object(more)) = (&mut record, more) {
            record.extend(more);
        }
        record
    }
}
