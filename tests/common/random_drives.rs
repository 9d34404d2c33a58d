//! Tests of random drives for any kernel: the rules of `tests/motion/fuzz_drives.rs`.

use crate::common::advance::{Events, volterra};
use crate::common::state_difference;
use crate::drawn::Drawn;
use crate::row::{broken, differs, questions};
use gearatlas::analysis::{Class, PointOutcome, Status, investigate_onward};
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel, Tangents, Volterra};
use gearatlas::reference::Reference;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;

pub const TRANSIENT: u64 = 100;
pub const CYCLES: u64 = 400;
pub const EVENT_LIMIT: u32 = 1000;

/// Largest number of steps per cycle for which the test runs the reference integrator.
const AFFORDABLE: f64 = 3000.0;

/// A violated rule, with the details.
#[derive(Debug)]
pub struct Fault {
    pub kernel: &'static str,
    pub rule: &'static str,
    pub how: String,
}

/// Counts over some drives.
#[derive(Debug, Default)]
pub struct Tally {
    /// Results by kernel and status.
    pub rows: BTreeMap<(&'static str, String), u64>,
    /// Results of motion that changed after its record.
    pub later: u64,
    /// Number of compared cycles by kernel.
    pub compared: BTreeMap<&'static str, u64>,
    /// Largest difference relative to its bound, by kernel.
    pub worst: BTreeMap<&'static str, f64>,
    pub faults: Vec<(u64, Fault)>,
}

fn investigate<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
) -> (PointOutcome, TrajectoryState) {
    let mut trajectory = start.clone();
    let found = investigate_onward(
        model,
        kernel,
        &mut trajectory,
        &questions(TRANSIENT, CYCLES),
        &AtomicBool::new(false),
    );
    (found.unwrap(), trajectory)
}

/// The test of one drive.
pub struct Trial<'a> {
    pub model: &'a Model,
    pub start: TrajectoryState,
    pub tally: &'a mut Tally,
    pub faults: Vec<Fault>,
}

impl Trial<'_> {
    pub fn fault(&mut self, kernel: &'static str, rule: &'static str, how: String) {
        self.faults.push(Fault { kernel, rule, how });
    }

    /// Tests the results of a kernel by all rules; `reported_error`: the error of a cycle that the kernel reports.
    pub fn put<K: Kernel>(&mut self, name: &'static str, kernel: &K, reported_error: f64) {
        let (row, end) = investigate(self.model, kernel, &self.start);
        let key = (name, row.status.name().to_owned());
        *self.tally.rows.entry(key).or_default() += 1;
        if row.status != Status::Ok {
            return;
        }
        for (rule, how) in broken(&row, self.model.half_gap) {
            self.fault(name, rule, how);
        }
        self.balance(name, &row);
        let start = self.start.clone();
        self.cycles((name, reported_error), kernel, start, 3);
        self.cycles((name, reported_error), kernel, end.clone(), 2);
        self.onward((name, reported_error), &row, &end);
    }

    /// Checks the mean force of periodic motion.
    fn balance(&mut self, name: &'static str, row: &PointOutcome) {
        let repeats = matches!(
            row.class,
            Some(Class::SteadyContact(Some(_)) | Class::Periodic(_))
        );
        let Some(free) = self.model.relative_rotation().filter(|_| repeats) else {
            return;
        };
        let pushed = self.model.first_gains()[free].mesh_input[1];
        let expected = self.model.blocks[free].static_input[1] / pushed;
        let nvh = row.nvh.as_ref().unwrap();
        let off = (nvh.values.force_mean - expected).abs();
        if off > 1e-8 * nvh.force_peak.max(expected.abs()) + 1e-9 {
            let how = format!("mean force {} N of {expected} N", nvh.values.force_mean);
            self.fault(name, "balance", how);
        }
    }

    /// Tests single cycles of a kernel along the trajectory of the structured kernel.
    fn cycles<K: Kernel>(
        &mut self,
        (name, reported_error): (&'static str, f64),
        kernel: &K,
        mut start: TrajectoryState,
        count: u64,
    ) {
        let model = self.model;
        let exact = volterra(model);
        for _ in 0..count {
            let Some(end) = cycle(&exact, &start) else {
                return;
            };
            if let Some(felt) = felt(model, &exact, &start, &end).filter(|f| f.gain < 1e3) {
                if name == "volterra" {
                    self.reference(&start, &end, felt.state);
                } else {
                    match cycle(kernel, &start) {
                        None => self.fault(name, "state", "stopped".into()),
                        Some(own) => {
                            let state = felt.state + reported_error;
                            self.other(name, &own, &end, &Felt { state, ..felt });
                        }
                    }
                }
            }
            start = end.end;
        }
    }

    /// Compares a cycle of another kernel with a cycle of the structured kernel.
    fn other(&mut self, name: &'static str, own: &Cycle, end: &Cycle, felt: &Felt) {
        let off = state_difference(self.model, &own.end.state, &end.end.state);
        let touches = own.grazings + end.grazings > 0;
        let counts = [own.events, end.events];
        self.compare(name, "state", off / felt.state, counts, touches);
        let off = tangent_difference(&own.tangent, &end.tangent);
        if own.events == end.events && !touches && (off.is_nan() || off > felt.tangent) {
            let how = format!("{off:.1e}, {:.1e} allowed", felt.tangent);
            self.fault(name, "tangent", how);
        }
    }

    /// Compares a cycle of the structured kernel with the reference integrator.
    fn reference(&mut self, start: &TrajectoryState, end: &Cycle, allowed: f64) {
        let model = self.model;
        if Volterra::fastest_rate(model) * model.period() > AFFORDABLE {
            return;
        }
        // A cycle whose motion touches a surface to the last digit cannot be compared.
        if let Ok(passage) = Reference::new(model).advance(start, 1) {
            let off = state_difference(model, &end.end.state, &passage.end.state);
            let counts = [end.events, passage.crossings.len()];
            let touches = end.grazings > 0;
            self.compare("volterra", "reference", off / allowed, counts, touches);
        }
    }

    fn compare(
        &mut self,
        name: &'static str,
        rule: &'static str,
        off: f64,
        events: [usize; 2],
        touches: bool,
    ) {
        *self.tally.compared.entry(name).or_default() += 1;
        let worst = self.tally.worst.entry(name).or_default();
        *worst = worst.max(off);
        if (events[0] != events[1] && !touches) || off.is_nan() || off > 1.0 {
            let how = format!("{off:.1e} of what is allowed, events {events:?}");
            self.fault(name, rule, how);
        }
    }

    /// Computes the results again, from the end of the measured motion.
    fn onward(
        &mut self,
        (name, reported_error): (&'static str, f64),
        row: &PointOutcome,
        end: &TrajectoryState,
    ) {
        let exact = Volterra::new(self.model, f64::EPSILON, EVENT_LIMIT);
        let (again, _) = investigate(self.model, &exact, end);
        let same = again.status == Status::Ok && again.class == row.class;
        if !matches!(
            row.class,
            Some(Class::SteadyContact(Some(_)) | Class::Periodic(_))
        ) {
            self.tally.later += u64::from(!same);
            return;
        }
        if let Some(how) = differs(row, &again, self.model.half_gap) {
            self.fault(name, "onward", how);
        }
        if !same {
            return;
        }
        let [Some(one), Some(two)] = [&row.lyapunov, &again.lyapunov] else {
            return;
        };
        let lambda = [one, two].map(|l| l.exponents[0]);
        let reported_error = 1e-14 + reported_error;
        let allowed =
            1e-6 * (1.0 + lambda[0].abs()) + reported_error * (-lambda[0].min(lambda[1])).exp();
        if (lambda[0] - lambda[1]).abs() > allowed {
            let how = format!("λ {lambda:?}, {allowed:.1e} allowed, {:?}", row.class);
            self.fault(name, "onward", how);
        }
    }
}

/// Effect of a small change of the start on a cycle, and the resulting bounds for its end.
struct Felt {
    /// Growth of a change of all entries by the same fraction.
    gain: f64,
    /// Allowed difference of states.
    state: f64,
    /// Allowed difference of tangents.
    tangent: f64,
}

/// Measures the sensitivity to a cycle's start: with all entries larger by 1e-9, and with alternating changes, as by
/// rounding. The second case detects an event next to a tangency. The time of such an event, and with it the tangents,
/// changes with the square root of the change.
fn felt(model: &Model, exact: &Volterra<'_>, start: &TrajectoryState, end: &Cycle) -> Option<Felt> {
    let beside = |sign: [f64; 2]| {
        let entries = start.state.iter().enumerate();
        let state = entries.map(|(i, x)| x * (1.0 + 1e-9 * sign[i % 2]));
        let moved = TrajectoryState {
            state: state.collect(),
            ..start.clone()
        };
        cycle(exact, &moved).filter(|moved| moved.events == end.events)
    };
    let (along, across) = (beside([1.0, 1.0])?, beside([1.0, -1.0])?);
    let gain = 1e9 * state_difference(model, &along.end.state, &end.end.state);
    // If the load keeps open flanks far apart, displacements times rates are large compared with velocities.
    let farthest = start.state[..model.modes()]
        .iter()
        .fold(0.0f64, |m, x| m.max(x.abs()));
    let rounding = farthest * Volterra::fastest_rate(model) * model.period() / model.half_gap;
    Some(Felt {
        gain,
        state: 1e-11 * gain.max(1.0) + 1e-14 * rounding / std::f64::consts::TAU,
        tangent: 1e-8 + 1e-2 * tangent_difference(&across.tangent, &end.tangent),
    })
}

/// Results of a cycle.
struct Cycle {
    end: TrajectoryState,
    tangent: Vec<f64>,
    events: usize,
    grazings: u64,
}

/// A cycle of a kernel, with one tangent; `None` if the integration stops.
fn cycle<K: Kernel>(kernel: &K, start: &TrajectoryState) -> Option<Cycle> {
    let (mut end, mut events) = (start.clone(), Events::default());
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    let mut tangents = Tangents::zeros(start.state.len() / 2, 1);
    for (i, x) in tangents.vector_mut(0).iter_mut().enumerate() {
        *x = (1.0 + i as f64).sin();
    }
    let integrated = kernel.advance_cycle(
        &mut end,
        &mut tangents,
        &mut workspace,
        &mut events,
        &mut counters,
    );
    integrated.ok()?;
    Some(Cycle {
        end,
        tangent: tangents.vector(0).to_vec(),
        events: events.0.len(),
        grazings: counters.grazings,
    })
}

/// Largest difference of two tangents. First and second components are each relative to their largest entry, or, if a
/// cycle has shrunk them, to a thousandth of their initial entries.
fn tangent_difference(a: &[f64], b: &[f64]) -> f64 {
    let half = b.len() / 2;
    let part = |range: std::ops::Range<usize>| {
        let size = range.clone().map(|i| b[i].abs()).fold(1e-3, f64::max);
        let off = range.map(|i| (a[i] - b[i]).abs());
        off.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most }) / size
    };
    part(0..half).max(part(half..b.len()))
}

/// Tests kernels on one drive, each with its function in `kernels`; returns the violated rules.
pub fn put(drawn: &Drawn, tally: &mut Tally, kernels: &[(&'static str, KernelCall)]) -> Vec<Fault> {
    let model = match Model::new(&drawn.structure, &drawn.drive, drawn.point) {
        Ok(model) => model,
        Err(_) => {
            *tally.rows.entry(("model", "refused".into())).or_default() += 1;
            return Vec::new();
        }
    };
    let mut trial = Trial {
        start: model.start(&drawn.start),
        model: &model,
        tally,
        faults: Vec::new(),
    };
    for (name, ask) in kernels {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| ask(&mut trial, name))) {
            let text = panic.downcast_ref::<String>().cloned();
            trial.fault(name, "panic", text.unwrap_or_else(|| "no message".into()));
        }
    }
    trial.faults
}

/// Builds the named kernel for the model of a trial and tests it by the rules.
pub type KernelCall = fn(&mut Trial<'_>, &'static str);

/// Records that no kernel exists for the drive.
pub fn refuse(trial: &mut Trial<'_>, name: &'static str) {
    *trial.tally.rows.entry((name, "failed".into())).or_default() += 1;
}
