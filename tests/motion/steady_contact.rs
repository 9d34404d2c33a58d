//! Motions that end in steady contact: the orbit from one map of a period agrees with integration.

#![allow(clippy::unwrap_used)]

use crate::common;
use gearatlas::analysis::{
    Class, Effort, EnergyNorm, LyapunovConfig, PointConfig, PointOutcome, Section,
    investigate_onward,
};
use gearatlas::model::{DriveShaft, InitialState, Model, TorqueRipple, TrajectoryState};
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::{Counters, Kernel, Observer, Stop, Tangents, Volterra};
use std::cell::Cell;
use std::sync::atomic::AtomicBool;

/// Mesh cycles of the ripple's period.
const PERIOD: u64 = 20;

/// A kernel that counts its work.
struct Counted {
    kernel: Volterra<'static>,
    cycles: Cell<u64>,
    /// Number of integrated cycles times tangents.
    tangents: Cell<u64>,
}

impl Counted {
    fn new(model: &Model) -> Self {
        Self {
            kernel: Volterra::of(model.clone(), f64::EPSILON, 1000),
            cycles: Cell::new(0),
            tangents: Cell::new(0),
        }
    }
}

impl Kernel for Counted {
    type Workspace = <Volterra<'static> as Kernel>::Workspace;

    fn workspace(&self) -> Self::Workspace {
        self.kernel.workspace()
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        self.cycles.set(self.cycles.get() + 1);
        self.tangents
            .set(self.tangents.get() + tangents.count() as u64);
        self.kernel
            .advance_cycle(trajectory, tangents, workspace, observer, counters)
    }
}

fn questions(settle: bool) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 3,
            point_id: 1,
        },
        transient: 4000,
        cycles: 12_000,
        settle,
        audit_cycles: 0,
        lyapunov: Some(LyapunovConfig {
            stop_at_stderr: Some(0.02),
            align: 50,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: None,
    }
}

/// The result of a point, and the end of its trajectory.
fn ask<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &InitialState,
    settle: bool,
) -> (PointOutcome, TrajectoryState) {
    let mut trajectory = model.start(start);
    let outcome = investigate_onward(
        model,
        kernel,
        &mut trajectory,
        &questions(settle),
        &AtomicBool::new(false),
    )
    .unwrap();
    (outcome, trajectory)
}

/// The state of a trajectory some cycles later, and its events until then.
fn advance<K: Kernel>(kernel: &K, start: &TrajectoryState, cycles: u64) -> (TrajectoryState, u64) {
    let (mut end, mut counters) = (start.clone(), Counters::default());
    kernel
        .advance(
            cycles,
            &mut end,
            &mut kernel.workspace(),
            &mut (),
            &mut counters,
        )
        .unwrap();
    (end, counters.events)
}

/// Forty modes under ripple of half a revolution of the pinion, under a load that keeps teeth in contact.
fn rippled(load: f64, speed: f64) -> Model {
    let (mut structure, mut drive, mut point) = common::forty_modes();
    structure.teeth = 2 * PERIOD as u32;
    structure.pinion_torque = Some(vec![10.0; structure.frequency.len()]);
    drive.torque_ripple = vec![TorqueRipple {
        shaft: DriveShaft::Pinion,
        order: 2.0,
        amplitude: 1.0,
        phase: 0.4,
    }];
    (point.load, point.speed) = (load, speed);
    Model::new(&structure, &drive, point).unwrap()
}

/// The map is integrated with tangents once, and no other period is.
#[test]
fn one_map_of_a_period_answers_a_point() {
    let model = rippled(4.0, 250.0);
    let kernel = Counted::new(&model);
    let (quick, at) = ask(&model, &kernel, &InitialState::Static, true);
    assert_eq!(
        quick.class,
        Some(Class::SteadyContact(Some(PERIOD as u32))),
        "{}",
        quick.reason
    );
    let dimension = EnergyNorm::new(&model).dimension() as u64;
    assert_eq!(kernel.tangents.get(), PERIOD * dimension);
    // The end of the trajectory is on the orbit that integration reaches.
    let (slow, end) = ask(&model, &kernel, &InitialState::Static, false);
    assert_eq!(slow.class, quick.class, "{}", slow.reason);
    let norm = EnergyNorm::new(&model);
    let phase = (PERIOD + at.cycle % PERIOD - end.cycle % PERIOD) % PERIOD;
    let (end, _) = advance(&kernel, &end, phase);
    let apart = norm.distance(&at.state, &end.state) / norm.unit();
    assert!(apart < 1e-9, "{apart:e}");
    let (closed, events) = advance(&kernel, &at, PERIOD);
    assert_eq!(events, 0);
    let residual = norm.distance(&closed.state, &at.state) / norm.unit();
    assert!(residual < 1e-12, "{residual:e}");
}

/// One degree whose only damping is that of the contact.
fn one_degree(load: f64, speed: f64, damping: f64) -> Model {
    let (structure, mut drive, mut point) = common::one_degree();
    drive.damping *= damping;
    (point.load, point.speed) = (load, speed);
    Model::new(&structure, &drive, point).unwrap()
}

/// Cycles after which the orbit was found.
fn found_after(outcome: &PointOutcome) -> u64 {
    let (_, rest) = outcome.reason.split_once("method after ").unwrap();
    rest.split_once(' ').unwrap().0.parse().unwrap()
}

/// Teeth that start apart bounce until they stay in contact.
#[test]
fn contact_that_comes_to_last_is_found_when_it_does() {
    let model = one_degree(3.0, 400.0, 1.0);
    let kernel = Counted::new(&model);
    let (quick, at) = ask(&model, &kernel, &InitialState::Rest, true);
    assert_eq!(quick.class, Some(Class::SteadyContact(Some(1))));
    let (mut bouncing, mut last) = (model.start(&InitialState::Rest), 0);
    for cycle in 1..200 {
        let (next, events) = advance(&kernel, &bouncing, 1);
        bouncing = next;
        if events > 0 {
            last = cycle;
        }
    }
    assert!(last > 0, "teeth start apart");
    let after = found_after(&quick);
    println!("found after {after} cycles, the last event in cycle {last}");
    assert!((last..=2 * last + 2).contains(&after), "{after}, {last}");
    let (slow, end) = ask(&model, &kernel, &InitialState::Rest, false);
    assert_eq!(slow.class, quick.class);
    let norm = EnergyNorm::new(&model);
    assert!(norm.distance(&at.state, &end.state) < 1e-9 * norm.unit());
}

/// Near the load above which contact is permanent, with damping so small that observation takes long: motions certified
/// as permanent contact are, and every result agrees with integration.
#[test]
fn contact_is_certain_only_where_it_lasts() {
    let (mut certain, mut seen) = (0, 0);
    for step in 0..24 {
        let model = one_degree(0.2 + 0.15 * f64::from(step), 400.0, 0.1);
        let kernel = Counted::new(&model);
        let (quick, at) = ask(&model, &kernel, &InitialState::Static, true);
        if quick.reason.contains("certain to last") {
            certain += 1;
            let (_, events) = advance(&kernel, &model.start(&InitialState::Static), 2000);
            assert_eq!(events, 0, "{}", quick.reason);
        }
        let (slow, end) = ask(&model, &kernel, &InitialState::Static, false);
        assert_eq!(
            slow.class, quick.class,
            "{} / {}",
            quick.reason, slow.reason
        );
        if quick.class == Some(Class::SteadyContact(Some(1))) {
            seen += 1;
            let norm = EnergyNorm::new(&model);
            assert!(norm.distance(&at.state, &end.state) < 1e-8 * norm.unit());
        }
    }
    println!("{certain} of {seen} certain");
    assert!(certain > 4 && seen < 24, "{certain} of {seen}");
}
