//! Drives whose speed varies: run-ups and the drive of an FMU.

use super::kernels::{EXTENDED, error};
use super::report::worse;
use super::{CheckError, Line, Subjects, drives};
use crate::analysis::EnergyNorm;
use crate::fmu::{Drive, INPUTS, LiveState, Mode, Plant};
use crate::model::ActiveSet;
use crate::propagate::varying_speed::{MotionObserver, MovingEvent, SpeedInterval, VaryingSpeed};
use crate::propagate::{Counters, InstructionSet};
use crate::reference::Extended;
use crate::store::TableStore;
use crate::sweep::Prepared;

/// Largest number of events in a mesh cycle.
const EVENT_LIMIT: u32 = 1000;

/// Events of a motion: phase, closed contacts after it.
#[derive(Default)]
struct Events(Vec<(f64, ActiveSet)>);

impl MotionObserver for Events {
    fn event(&mut self, event: &MovingEvent) {
        self.0.push((event.phase, event.to));
    }
}

/// Compares mesh cycles in which the speed grows by 5 %, far more than on a test bench. Each cycle starts from the rounded
/// end of the last one.
pub fn run_up(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    const GROWTH: f64 = 0.05;
    let cycles = subjects.extent.pick(10, 200);
    let (mut state, mut time) = (0.0f64, 0.0f64);
    let (mut events, mut strays, mut compared) = (0, 0, 0);
    for case in &subjects.cases {
        let model = case.model()?;
        let kernel =
            VaryingSpeed::new(&case.structure, &model, EVENT_LIMIT, InstructionSet::best())?;
        let (period, norm) = (model.period(), EnergyNorm::new(&model));
        // The phase grows as t + a t²/2. It passes one period T at (√(1 + 2 a T) − 1)/a.
        let duration = 2.0 * period / (1.0 + (1.0 + 2.0 * GROWTH).sqrt());
        let speed = 1.0 / (kernel.cycles_per_radian() * period);
        let mut interval = SpeedInterval::steady(duration, speed, model.load);
        interval.rotation[2] = 0.5 * GROWTH / period * speed;
        let extended = Extended::new(&model).accelerated(GROWTH / period);
        let mut start = drives::rattling(&model)?;
        let mut workspace = kernel.workspace();
        for _ in 0..cycles {
            let exact = extended.advance(&start, 1)?;
            let mut motion = kernel.start(&start);
            let (mut seen, mut counters) = (Events::default(), Counters::default());
            kernel.advance(
                &mut motion,
                &interval,
                &mut workspace,
                &mut seen,
                &mut counters,
            )?;
            let pairs = || seen.0.iter().zip(&exact.crossings);
            let same = seen.0.len() == exact.crossings.len()
                && pairs().all(|((_, to), known)| *to == known.to);
            strays += usize::from(!same);
            for ((phase, _), known) in pairs() {
                time = worse(time, (phase - known.time.value() / period).abs());
            }
            state = worse(state, error(&norm, &exact, &motion.state));
            events += seen.0.len();
            start = exact.end();
        }
        compared += cycles;
    }
    Ok(vec![
        Line::at_most(
            format!(
                "speed that grows by 5 % a cycle, {} drives: state",
                subjects.cases.len()
            ),
            EXTENDED,
            state,
            1e-12,
            "half gaps",
        ),
        Line::at_most(
            format!("the same: phases of {events} events"),
            EXTENDED,
            time,
            1e-12,
            "cycles",
        ),
        Line::at_most(
            format!("the same: sequence of events, {compared} cycles"),
            EXTENDED,
            strays as f64,
            0.0,
            "cycles",
        ),
    ])
}

/// Steps of an importer, as parts of a mesh cycle. One more step ends the cycle.
const STEPS: [f64; 5] = [0.07, 0.31, 0.02, 0.25, 0.2];

/// Compares mesh cycles of an FMU's drive in uneven steps, at a constant speed under a load that does not accelerate it.
/// Each cycle starts from the rounded end of the last one.
fn stepped_cycles(subjects: &Subjects, drive: &Drive) -> Result<Line, CheckError> {
    let point = drive.point();
    let parts = Prepared::new(TableStore::in_memory());
    let model = parts.model(point).map_err(Box::new)?;
    let structure = parts.structure(&point.model)?;
    let starter = VaryingSpeed::new(&structure, &model, EVENT_LIMIT, InstructionSet::best())?;
    let (mut plant, mut live) = begun(drive)?;
    live.inputs = [0.0, 0.0, point.load];
    let (norm, period) = (EnergyNorm::new(&model), model.period());
    let extended = Extended::new(&model);
    let mut start = drives::rattling(&model)?;
    let cycles = subjects.extent.pick(10, 200);
    let mut worst = 0.0f64;
    for _ in 0..cycles {
        live.motion = Some(starter.start(&start));
        live.time = 0.0;
        for part in STEPS {
            plant.step(&mut live, part * period)?;
        }
        let rest = period - live.time;
        plant.step(&mut live, rest)?;
        let exact = extended.advance(&start, 1)?;
        let state = live.motion.as_ref().map(|motion| &motion.state);
        let off = state.map_or(f64::NAN, |state| error(&norm, &exact, state));
        worst = worse(worst, off);
        start = exact.end();
    }
    Ok(Line::at_most(
        format!(
            "FMU: state after a cycle in {} steps, {} events",
            STEPS.len() + 1,
            live.events
        ),
        EXTENDED,
        if live.events > cycles { worst } else { f64::NAN },
        1e-12,
        "half gaps",
    ))
}

/// Compares the mean speed under two torques that are not in balance with that of a rigid body,
/// `ω = ω₀ + (T₁ + T₂ u) t / (J₁ + J₂ u²)` with the ratio u of the numbers of teeth.
fn mean_speed(drive: &Drive) -> Result<Line, CheckError> {
    const STEP: f64 = 1e-4;
    const COUNT: u32 = 1000;
    let torques = [12.0, -3.0];
    let (mut plant, mut live) = begun(drive)?;
    (live.inputs[0], live.inputs[1]) = (torques[0], torques[1]);
    let first = live.speed;
    for _ in 0..COUNT {
        plant.step(&mut live, STEP)?;
    }
    let shafts = drives::shafts()?;
    let [pinion, wheel] = drives::inertias(&shafts);
    let [r, s] = shafts.gears.base_radii();
    let ratio = r / s;
    let acceleration = (torques[0] + torques[1] * ratio) / (pinion + wheel * ratio * ratio);
    let gained = acceleration * STEP * f64::from(COUNT);
    Ok(Line::at_most(
        "FMU: gain of mean speed under two torques",
        "(T1 + T2 u) t/(J1 + J2 u^2)",
        ((live.speed - first) / gained - 1.0).abs(),
        1e-9,
        "relative",
    ))
}

/// The plant and the state of an FMU after its initialization.
fn begun(drive: &Drive) -> Result<(Plant, LiveState), CheckError> {
    let description = drive.description();
    let parameters = description.parameters_at_start();
    let plant = drive.plant(&parameters).map_err(Box::new)?;
    let mut live = LiveState {
        mode: Mode::Step,
        parameters,
        inputs: description.inputs_at_start(),
        rates: [0.0; INPUTS],
        time: 0.0,
        speed: 0.0,
        events: 0,
        motion: None,
    };
    plant.begin(&mut live);
    Ok((plant, live))
}

/// Steps the drive of an FMU, as an importer does.
pub fn functional_mock_up_unit(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let job = drives::job(&[
        "grid={ load = 0.05, speed = 1200 }",
        "model.modes=12",
        "model.retained=12",
    ])?;
    let point = job.points.first().ok_or(CheckError::Missing {
        what: "an operating point of the default drive",
    })?;
    let drive = Drive::new(job, point, TableStore::in_memory()).map_err(Box::new)?;
    Ok(vec![stepped_cycles(subjects, &drive)?, mean_speed(&drive)?])
}
