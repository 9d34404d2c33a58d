//! Comparison of kernels with independent integrators that share only the model: one in doubles, and one in extended
//! precision with about 30 digits.

use super::candidate::{Candidate, Passage};
use super::drives::{self, Case};
use super::report::worse;
use super::{CheckError, Line, Subjects};
use crate::analysis::EnergyNorm;
use crate::model::{InitialState, Model, TrajectoryState};
use crate::reference::{Extended, ExtendedPassage, Reference};

/// A trajectory in extended precision, cycle by cycle. Each cycle starts from the end of the previous one, rounded to
/// doubles.
pub(super) struct ExactTrajectory {
    model: Model,
    norm: EnergyNorm,
    cycles: Vec<(TrajectoryState, ExtendedPassage)>,
}

/// Errors of a kernel.
#[derive(Debug, Clone, Copy, Default)]
struct KernelErrors {
    /// Largest error of a state after one cycle, in the energy norm \[half gaps\].
    state: f64,
    /// Largest error of an event time \[cycles\].
    time: f64,
    /// Number of cycles with a different sequence of events or final contact state, or with a wrong count of events.
    strays: usize,
}

impl ExactTrajectory {
    fn of_case(case: &Case, cycles: u64) -> Result<Self, CheckError> {
        let model = case.model()?;
        let start = drives::rattling(&model)?;
        Self::new(model, start, cycles)
    }

    pub(super) fn new(
        model: Model,
        mut start: TrajectoryState,
        cycles: u64,
    ) -> Result<Self, CheckError> {
        let mut passages = Vec::new();
        let extended = Extended::new(&model);
        for _ in 0..cycles {
            let passage = extended.advance(&start, 1)?;
            let end = passage.end();
            passages.push((start, passage));
            start = end;
        }
        Ok(Self {
            norm: EnergyNorm::new(&model),
            cycles: passages,
            model,
        })
    }

    fn events(&self) -> usize {
        let events = self.cycles.iter().map(|(_, exact)| exact.crossings.len());
        events.sum()
    }

    fn departure(&self, kernel: &Candidate) -> Result<KernelErrors, CheckError> {
        let kernel = kernel.on(&self.model)?;
        let mut worst = KernelErrors::default();
        for (start, exact) in &self.cycles {
            let Passage {
                end,
                events,
                counters,
            } = kernel.passage(start, 1)?;
            let pairs = || events.iter().zip(&exact.crossings);
            let same = events.len() == exact.crossings.len()
                && counters.events == events.len() as u64
                && end.contact == exact.contact
                && pairs().all(|(a, b)| (a.cycle, a.from, a.to) == (b.cycle, b.from, b.to));
            worst.strays += usize::from(!same);
            worst.state = worse(worst.state, error(&self.norm, exact, &end.state));
            for (event, crossing) in pairs() {
                let late = (event.time - crossing.time.value()) - crossing.time.rest();
                worst.time = worse(worst.time, late.abs() / self.model.period());
            }
        }
        Ok(worst)
    }

    /// Largest error of the states of the reference integrator \[half gaps\].
    fn departure_of_reference(&self, cycles: usize) -> Result<f64, CheckError> {
        let reference = Reference::new(&self.model);
        let mut worst = 0.0f64;
        for (start, exact) in self.cycles.iter().take(cycles) {
            let end = reference.advance(start, 1)?.end;
            worst = worse(worst, error(&self.norm, exact, &end.state));
        }
        Ok(worst)
    }
}

pub(super) const EXTENDED: &str = "integrator of 30 digits";

/// Why a kernel with tables is not compared on a drive.
const VARYING: &str = "tables cannot follow stiffness that varies within a segment";

/// Error of a state at the end of an exact passage \[half gaps\].
pub(super) fn error(norm: &EnergyNorm, exact: &ExtendedPassage, state: &[f64]) -> f64 {
    norm.length(&exact.difference(state)) / norm.unit()
}

/// Exact trajectories, with a name for the report.
pub(super) struct Truths {
    pub name: String,
    pub trajectories: Vec<ExactTrajectory>,
}

/// Exact trajectories of the drives.
fn truths(subjects: &Subjects) -> Result<Vec<Truths>, CheckError> {
    let cycles = subjects.extent.pick(24, 240);
    let mut all = Vec::new();
    for case in &subjects.cases {
        all.push(Truths {
            name: case.name.clone(),
            trajectories: vec![ExactTrajectory::of_case(case, cycles)?],
        });
    }
    if !subjects.grid.is_empty() {
        let cycles = subjects.extent.pick(2, 200);
        let truths = subjects
            .grid
            .iter()
            .map(|case| ExactTrajectory::of_case(case, cycles));
        let name = format!("flex80, {} points", subjects.grid.len());
        let trajectories = truths.collect::<Result<_, _>>()?;
        all.push(Truths { name, trajectories });
    }
    Ok(all)
}

/// Compares single mesh cycles of rattle: state, event times, sequence of events.
pub fn cycle(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    compare(subjects, &truths(subjects)?, 1e-13)
}

/// Compares all kernels with exact trajectories. `bound` is the largest error of an event time \[cycles\]; multiplied
/// by the allowed round-off of each kernel, the largest error of a state \[half gaps\].
pub(super) fn compare(
    subjects: &Subjects,
    truths: &[Truths],
    bound: f64,
) -> Result<Vec<Line>, CheckError> {
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let mut all = KernelErrors::default();
        let (mut events, mut integrated) = (0, 0);
        for Truths { name, trajectories } in truths {
            let what = format!("{}: state after a cycle, {name}", kernel.name);
            if !trajectories
                .iter()
                .all(|truth| kernel.supports(&truth.model))
            {
                lines.push(Line::skipped(what, VARYING));
                continue;
            }
            let mut worst = 0.0f64;
            for truth in trajectories {
                let one = truth.departure(kernel)?;
                events += truth.events();
                integrated += truth.cycles.len();
                worst = worse(worst, one.state);
                all.time = worse(all.time, one.time);
                all.strays += one.strays;
            }
            lines.push(Line::at_most(
                what,
                EXTENDED,
                worst,
                bound * kernel.round_off,
                "half gaps",
            ));
        }
        lines.push(Line::at_most(
            format!("{}: times of {events} events", kernel.name),
            EXTENDED,
            all.time,
            // The error of an event time is large if the surface is crossed slowly. Among many events some
            // are slow.
            subjects.extent.pick(bound, 10.0 * bound),
            "cycles",
        ));
        lines.push(Line::at_most(
            format!("{}: sequence of events, {integrated} cycles", kernel.name),
            EXTENDED,
            all.strays as f64,
            0.0,
            "cycles",
        ));
    }
    let mut worst = 0.0f64;
    for Truths { trajectories, .. } in truths {
        if let Some(truth) = trajectories.first() {
            worst = worse(worst, truth.departure_of_reference(4)?);
        }
    }
    lines.push(Line::at_most(
        "the reference integrator: state after a cycle",
        EXTENDED,
        worst,
        bound,
        "half gaps",
    ));
    Ok(lines)
}

/// Compares many cycles without an event, in which errors only accumulate.
pub fn constant_contact(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let cycles = subjects.extent.pick(20, 1000);
    let mut known = Vec::new();
    for case in &subjects.cases {
        let case = case.in_constant_contact();
        let model = case.model()?;
        let start = model.start(&InitialState::Static);
        let exact = Reference::new(&model).advance(&start, cycles)?;
        known.push((model, start, exact));
    }
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let (mut worst, mut events) = (0.0f64, 0);
        for (model, start, exact) in &known {
            let passage = kernel.on(model)?.passage(start, cycles)?;
            let norm = EnergyNorm::new(model);
            let distance = norm.distance(&passage.end.state, &exact.end.state) / norm.unit();
            worst = worse(worst, distance);
            events += passage.events.len() + exact.crossings.len();
        }
        lines.push(Line::at_most(
            format!(
                "{}: {cycles} cycles in contact, {} drives, {events} events",
                kernel.name,
                known.len()
            ),
            "reference integrator",
            worst,
            1e-12 * kernel.round_off,
            "half gaps",
        ));
    }
    Ok(lines)
}
