//! Are statistics, audits and classes right? Brute-force sampling of the same trajectory,
//! planted errors, small oscillators of known kind.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, advance_with, cut_short, settled, volterra};
use common::{drives, relative_difference};
use gearatlas::analysis::{
    Class, Effort, EnergyAudit, LyapunovConfig, Nvh, NvhConfig, NvhOutcome, NvhStatistics,
    PointConfig, PointOutcome, Section, Signals, SpectrumConfig, Status, investigate,
};
use gearatlas::model::{
    Division, DriveShaft, InitialState, MeshHarmonic, Model, OperatingPoint, TorqueRipple,
    TrajectoryState,
};
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::{
    ClosedContact, ClosedModes, Counters, Event, InstructionSet, Kernel, Observer, Stepping, Stop,
    Tangents, Volterra, Window,
};
use gearatlas::reference::Reference;
use gearatlas::structure::ModalStructure;
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

/// Stores all windows.
#[derive(Default)]
struct Record {
    windows: Vec<Piece>,
    impacts: Vec<f64>,
}

/// One window, owned.
struct Piece {
    start: f64,
    duration: f64,
    contact: usize,
    deflection: Vec<f64>,
    force: Vec<f64>,
}

impl Observer for Record {
    const WINDOWS: bool = true;

    fn window(&mut self, w: &Window<'_>) {
        self.windows.push(Piece {
            start: w.start,
            duration: w.duration,
            contact: w.contact.flanks().index(),
            deflection: w.deflection.to_vec(),
            force: w.force.to_vec(),
        });
    }

    fn event(&mut self, event: &Event) {
        if event.to.touching() {
            self.impacts.push(event.rate.abs());
        }
    }
}

/// Value of a Legendre series by the definition of the polynomials.
fn value(series: &[f64], x: f64) -> f64 {
    let (mut p, mut q, mut sum) = (1.0, x, 0.0);
    for (n, a) in series.iter().enumerate() {
        sum += a * p;
        let k = n as f64;
        (p, q) = (q, ((2.0 * k + 3.0) * x * q - (k + 1.0) * p) / (k + 2.0));
    }
    sum
}

/// Equidistant samples per window: Simpson's rule converges with the fourth power.
const SAMPLES: usize = 3000;

/// One sample with its weight in Simpson's rule.
struct Sample {
    weight: f64,
    time: f64,
    deflection: f64,
    force: f64,
}

/// Statistics by brute force: two passes of Simpson's rule over fine samples.
fn brute_force(model: &Model, record: &Record, harmonics: usize) -> NvhOutcome {
    let mut samples = Vec::new();
    for piece in &record.windows {
        for i in 0..=SAMPLES {
            let s = i as f64 / SAMPLES as f64;
            let simpson = match i {
                0 | SAMPLES => 1.0,
                _ if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let weight = simpson * piece.duration / (3.0 * SAMPLES as f64);
            let x = 2.0 * s - 1.0;
            let force = value(&piece.force, x);
            let deflection = value(&piece.deflection, x);
            samples.push(Sample {
                weight,
                time: piece.start + s * piece.duration,
                deflection,
                force,
            });
        }
    }
    let time: f64 = samples.iter().map(|s| s.weight).sum();
    let average = |f: fn(&Sample, f64) -> f64, parameter: f64| -> f64 {
        samples
            .iter()
            .map(|s| s.weight * f(s, parameter))
            .sum::<f64>()
            / time
    };
    let mean = average(|s, _| s.deflection, 0.0);
    let variance = average(|s, mean| (s.deflection - mean).powi(2), mean);
    let force_mean = average(|s, _| s.force, 0.0);
    let extreme = |f: fn(f64, f64) -> f64| samples.iter().map(|s| s.deflection).reduce(f).unwrap();
    let (low, high) = (extreme(f64::min), extreme(f64::max));
    let mut fractions = [0.0; 4];
    for piece in &record.windows {
        fractions[piece.contact] += piece.duration / time;
    }
    let impacts = record.impacts.len();
    let values = NvhStatistics {
        deflection_mean: mean,
        deflection_rms: variance.sqrt(),
        deflection_kurtosis: average(|s, mean| (s.deflection - mean).powi(4), mean)
            / variance.powi(2),
        harmonics: (1..=harmonics)
            .map(|h| {
                let omega = TAU * h as f64 / model.period();
                let re = average(|s, omega| s.deflection * (omega * s.time).cos(), omega);
                let im = average(|s, omega| s.deflection * (omega * s.time).sin(), omega);
                2.0 * re.hypot(im)
            })
            .collect(),
        force_mean,
        force_std: average(|s, mean| (s.force - mean).powi(2), force_mean).sqrt(),
        impact_rate: impacts as f64 / time,
        impact_velocity: record.impacts.iter().sum::<f64>() / impacts.max(1) as f64,
        fractions,
        ..NvhStatistics::default()
    };
    NvhOutcome {
        values,
        deflection_pp: high - low,
        deflection_crest: (high - mean).max(mean - low) / variance.sqrt(),
        force_peak: samples.iter().map(|s| s.force.abs()).fold(0.0, f64::max),
        ..NvhOutcome::default()
    }
}

/// Largest relative difference of two sets of statistics: of integrals and of extremes, which samples miss by the
/// square of their distance. Harmonics are relative to the RMS.
fn difference(a: &NvhOutcome, b: &NvhOutcome) -> [f64; 2] {
    let relative = |a: f64, b: f64| if a == b { 0.0 } else { (a - b).abs() / b.abs() };
    let extremes = [
        relative(a.deflection_pp, b.deflection_pp),
        relative(a.deflection_crest, b.deflection_crest),
        relative(a.force_peak, b.force_peak),
    ];
    let [a, b] = [&a.values, &b.values];
    assert_eq!(a.harmonics.len(), b.harmonics.len());
    let harmonics = a.harmonics.iter().zip(&b.harmonics);
    let fractions = a.fractions.iter().zip(&b.fractions);
    let integrals = [
        relative(a.deflection_mean, b.deflection_mean),
        relative(a.deflection_rms, b.deflection_rms),
        relative(a.deflection_kurtosis, b.deflection_kurtosis),
        relative(a.force_mean, b.force_mean),
        relative(a.force_std, b.force_std),
        relative(a.impact_rate, b.impact_rate),
        relative(a.impact_velocity, b.impact_velocity),
    ]
    .into_iter()
    .chain(harmonics.map(|(x, y)| (x - y).abs() / b.deflection_rms))
    .chain(fractions.map(|(x, y)| (x - y).abs()));
    let worst = |m: f64, v: f64| if v.is_nan() { f64::NAN } else { v.max(m) };
    [
        integrals.fold(0.0, worst),
        extremes.into_iter().fold(0.0, worst),
    ]
}

/// A drive in permanent contact, with an excitation so small that its spread is far below its mean.
fn nearly_still() -> Model {
    let (structure, mut drive, mut point) = common::one_degree();
    drive.mesh = Division::levels(&[4e8], &[]);
    drive.transmission_error = vec![MeshHarmonic::new(1, 1e-10, 0.2)];
    point.load = 1.0;
    Model::new(&structure, &drive, point).unwrap()
}

#[test]
fn statistics_are_those_of_fine_samples() {
    let mut models: Vec<_> = drives()
        .into_iter()
        .map(|(name, case)| (name, common::model(&case)))
        .collect();
    models.push(("nearly still", nearly_still()));
    for (name, model) in models {
        let start = settled(&model, 100);
        let mut both = (Record::default(), Nvh::new(&model, 8));
        advance_with(&volterra(&model), &start, 25, &mut both);
        let exact = brute_force(&model, &both.0, 8);
        let found = both.1.outcome().unwrap();
        let [integrals, extremes] = difference(&found, &exact);
        println!("{name}: integrals {integrals:.1e}, extremes {extremes:.1e}");
        assert!(
            integrals < 1e-9,
            "{name}: {integrals:e}\n{found:?}\n{exact:?}"
        );
        assert!(
            extremes < 1e-6,
            "{name}: {extremes:e}\n{found:?}\n{exact:?}"
        );
        assert!((found.values.fractions.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

/// Statistics from a kernel without windows agree to the first order of its step.
#[test]
fn statistics_agree_with_those_of_small_steps() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let mut start = settled(&model, 40);
        let mut close = 0;
        for _ in 0..8 {
            let mut exact = Nvh::new(&model, 4);
            let (end, counters) = advance_with(&volterra(&model), &start, 1, &mut exact);
            let mut stepped = Nvh::new(&model, 4);
            let small = Stepping::new(&model, 30_000, 1000);
            advance_with(&small, &start, 1, &mut stepped);
            let error = difference(&stepped.outcome().unwrap(), &exact.outcome().unwrap());
            let error = error[0].max(error[1]);
            assert!(counters.events == 0 || error > 0.0);
            // A crossing that is late by a step affects peaks of the force.
            assert!(error < 1e-2, "{name}: {error:e}");
            close += u32::from(error < 2e-3);
            start = end;
        }
        assert!(close >= 4, "{name}: {close} of 8 cycles");
    }
}

/// An audit that sees slightly increased forces.
struct Planted<'m>(EnergyAudit<'m>, f64);

impl Observer for Planted<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let larger =
            |force: &[f64]| -> Vec<f64> { force.iter().map(|f| f * (1.0 + self.1)).collect() };
        let forces: Vec<_> = window
            .closed
            .iter()
            .map(|closed| larger(closed.force))
            .collect();
        let closed: Vec<_> = (window.closed.iter().zip(&forces))
            .map(|(closed, force)| ClosedContact { force, ..*closed })
            .collect();
        self.0.window(&Window {
            closed: &closed,
            ..*window
        });
    }

    fn event(&mut self, event: &Event) {
        self.0.event(event);
    }
}

#[test]
fn energy_balance_closes_and_a_planted_error_opens_it() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let start = settled(&model, 20);
        let residual = |planted: f64| {
            let mut audit = Planted(EnergyAudit::new(&model), planted);
            let (end, counters) = advance_with(&volterra(&model), &start, 100, &mut audit);
            assert!(counters.events > 100, "{name} does not rattle");
            audit.0.residual(&end).unwrap()
        };
        let (closed, open) = (residual(0.0), residual(1e-9));
        println!("{name}: {closed:.1e}, planted {open:.1e}");
        assert!(closed < 1e-13, "{name}: {closed:e}");
        assert!(open > 1e-12 && open > 20.0 * closed, "{name}: {open:e}");
    }
}

fn questions(transient: u64, cycles: u64) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 11,
            point_id: 5,
        },
        transient,
        cycles,
        settle: false,
        audit_cycles: 20,
        lyapunov: Some(LyapunovConfig {
            exponents: 2,
            align: 50,
            twin: false,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 100,
        section: Section::default(),
        nvh: Some(NvhConfig {
            harmonics: 4,
            spectrum: Some(SpectrumConfig {
                signals: Signals {
                    deflection: true,
                    force: true,
                    ..Signals::NONE
                },
                highest_order: 32,
                resolution: 64,
            }),
            outputs: Signals::NONE,
            power: false,
            orders: None,
            stop_at_stderr: None,
        }),
    }
}

fn ask(model: &Model, questions: &PointConfig) -> PointOutcome {
    investigate(
        model,
        &volterra(model),
        model.start(&InitialState::Static),
        questions,
        &AtomicBool::new(false),
    )
    .unwrap()
}

#[test]
fn poincare_samples_are_the_states_at_mesh_phase_zero() {
    let model = common::model(&common::six_modes());
    let outcome = ask(&model, &questions(30, 200));
    assert_eq!(outcome.poincare.len(), 100);
    let kernel = volterra(&model);
    let mut state: TrajectoryState = model.start(&InitialState::Static);
    for sample in &outcome.poincare {
        state = advance(&kernel, &state, sample.cycle - state.cycle);
        let (deflection, velocity) = model.deflection(&state.state, 0.0);
        assert_eq!((sample.deflection, sample.velocity), (deflection, velocity));
    }
    assert_eq!(state.cycle, outcome.cycles);
}

/// One degree at a load and a speed.
fn small_oscillator(load: f64, speed: f64) -> Model {
    common::model_at(&common::one_degree(), load, speed)
}

/// Kinds of motion of one degree; the reference integrator confirms each.
#[test]
fn small_oscillators_are_of_their_known_kind() {
    for (load, speed, class, events) in [
        (1.0, 400.0, Class::SteadyContact(Some(1)), 0.0),
        (0.3, 600.0, Class::Periodic(1), 4.0),
        (0.2, 1800.0, Class::Periodic(2), 2.0),
        (2.0, 1500.0, Class::Periodic(3), 4.0 / 3.0),
    ] {
        let model = small_oscillator(load, speed);
        let outcome = ask(&model, &questions(500, 1000));
        assert_eq!((&outcome.status, outcome.class), (&Status::Ok, Some(class)));
        assert_eq!(outcome.events_per_cycle, Some(events), "{class:?}");
        let period = u64::from(class.period().unwrap());
        let state = settled(&model, outcome.cycles);
        for cycles in 1..=period {
            let end = Reference::new(&model).advance(&state, cycles).unwrap().end;
            let moved = relative_difference(&end.state, &state.state);
            if cycles == period {
                assert!(moved < 1e-9, "{class:?}: {moved:e}");
            } else {
                assert!(moved > 1e-3, "{class:?}: {moved:e}");
            }
        }
        // The damping during contact determines the product of both multipliers.
        let lyapunov = outcome.lyapunov.unwrap();
        let [drive, _, coast, _] = outcome.nvh.unwrap().values.fractions;
        let (w, c) = (
            model.first_gains()[0].deflection[0],
            model.first_cycle().segments[0].damping,
        );
        let exact = -c * w * w * model.period() * (drive + coast);
        let sum: f64 = lyapunov.exponents.iter().sum();
        assert!((sum - exact).abs() < 1e-9, "{class:?}: {sum} {exact}");
        assert!(lyapunov.exponents[0] < 0.0);
    }
    let chaotic = ask(&small_oscillator(0.05, 1200.0), &questions(500, 1000));
    assert_eq!(
        (chaotic.status, chaotic.class),
        (Status::Ok, Some(Class::Chaotic))
    );
    let lyapunov = chaotic.lyapunov.unwrap();
    assert!(lyapunov.exponents[0] > 20.0 * lyapunov.stderr() && lyapunov.exponents[1] < 0.0);
}

/// Torque ripple of a shaft order extends the period to the shaft's teeth; ripple without a period leaves steady
/// contact steady.
#[test]
fn ripple_sets_the_period() {
    for (load, speed, order, class) in [
        (1.0, 400.0, 1.0, Class::SteadyContact(Some(40))),
        (0.3, 600.0, 1.0, Class::Periodic(40)),
        (0.3, 600.0, 4.0, Class::Periodic(10)),
        (
            1.0,
            400.0,
            std::f64::consts::SQRT_2,
            Class::SteadyContact(None),
        ),
    ] {
        let (mut structure, mut drive, mut point) = common::one_degree();
        structure.teeth = 40;
        structure.pinion_torque = Some(vec![10.0]);
        drive.torque_ripple = vec![TorqueRipple {
            shaft: DriveShaft::Pinion,
            order,
            amplitude: 1.0,
            phase: 0.4,
        }];
        // Twice the teeth at half the speed give the same mesh frequency.
        (point.load, point.speed) = (load, 0.5 * speed);
        let model = Model::new(&structure, &drive, point).unwrap();
        let outcome = ask(&model, &questions(500, 1000));
        assert_eq!(outcome.class, Some(class), "{}", outcome.reason);
        assert_eq!(outcome.status, Status::Ok, "{}", outcome.reason);
        assert!(outcome.lyapunov.unwrap().exponents[0] < 0.0);
    }
}

/// One degree under a transmission error of 2 µm, with torque ripple of a pinion order.
fn shaken(load: f64, speed: f64, ripple: (f64, f64)) -> Model {
    let mut structure = common::structure(&[0.0], 0.01, &[1.0], &[1.0]);
    structure.pinion_torque = Some(vec![10.0]);
    let (_, mut drive, mut point) = common::one_degree();
    drive.mesh = Division::levels(&[4e8], &[]);
    drive.transmission_error = vec![MeshHarmonic::new(1, 2e-6, 0.0)];
    let (order, amplitude) = ripple;
    drive.torque_ripple = vec![TorqueRipple {
        shaft: DriveShaft::Pinion,
        order,
        amplitude,
        phase: 0.4,
    }];
    (point.load, point.speed) = (load, speed);
    Model::new(&structure, &drive, point).unwrap()
}

/// A motion of period 3 under a faint ripple that returns after a revolution of the pinion, 20 cycles. The motion
/// repeats after 60, longer than the ripple and than any period searched without it.
#[test]
fn a_period_may_be_a_multiple_of_the_ripples() {
    let model = shaken(0.3, 1430.0, (1.0, 1e-3));
    for settle in [true, false] {
        let asked = PointConfig {
            settle,
            ..questions(500, 2000)
        };
        let outcome = ask(&model, &asked);
        let expected = (Status::Ok, Some(Class::Periodic(60)));
        assert_eq!(
            (outcome.status, outcome.class),
            expected,
            "{}",
            outcome.reason
        );
        // The reference integrator's motion also repeats after 60 cycles, and not earlier.
        let state = settled(&model, 4000);
        for (cycles, returns) in [(20, false), (30, false), (60, true)] {
            let end = Reference::new(&model).advance(&state, cycles).unwrap().end;
            let moved = relative_difference(&end.state, &state.state);
            assert_eq!(moved < 1e-9, returns, "{cycles}: {moved:e}");
        }
    }
}

/// Rattle under ripple without a period: two motions from distant states become one, which follows the ripple's phase
/// and has no period.
#[test]
fn a_torus_that_ripple_drives_has_a_verdict() {
    let model = shaken(0.5, 880.0, (std::f64::consts::SQRT_2, 0.5));
    let outcome = ask(&model, &questions(500, 1000));
    assert!(outcome.events_per_cycle.unwrap() > 0.0);
    let expected = (Status::Ok, Some(Class::QuasiPeriodic));
    assert_eq!(
        (outcome.status, outcome.class),
        expected,
        "{}",
        outcome.reason
    );
    assert!(outcome.lyapunov.unwrap().exponents[0] < -0.01);
}

/// A free body at rest has no events, no spread and no class.
#[test]
fn free_rest_has_no_events_and_no_spread() {
    let mut case = common::one_degree();
    case.1.transmission_error.clear();
    case.2.load = 0.0;
    let model = common::model(&case);
    let start = model.start(&InitialState::Rest);
    let outcome = investigate(
        &model,
        &volterra(&model),
        start,
        &questions(10, 400),
        &AtomicBool::new(false),
    )
    .unwrap();
    assert_eq!(outcome.events_per_cycle, Some(0.0));
    assert_eq!((outcome.grazing_count, outcome.energy_residual), (0, None));
    let nvh = outcome.nvh.unwrap();
    assert_eq!(
        nvh.values.fractions.map(|f| (f * 1e12).round()),
        [0.0, 1e12, 0.0, 0.0]
    );
    assert_eq!(
        (
            nvh.values.deflection_rms,
            nvh.deflection_crest,
            nvh.values.deflection_kurtosis
        ),
        (0.0, 0.0, 0.0)
    );
    assert_eq!(
        outcome.class,
        Some(Class::Periodic(1)),
        "{}",
        outcome.reason
    );
}

/// A start that counts as diverged from the beginning: every kernel reports this with the key to change, at its bound.
/// Within the bound, motion is integrated.
#[test]
fn a_start_out_of_range_is_told_as_such() {
    let model = small_oscillator(0.3, 1200.0);
    let start = |half_gaps: f64| {
        let mut start = model.start(&InitialState::Rest);
        let felt = model.first_gains()[0].deflection[0];
        start.state[0] = half_gaps * model.half_gap / felt;
        TrajectoryState::new(&model, start.state, 0)
    };
    fn put<K: Kernel>(model: &Model, kernel: &K, start: TrajectoryState) -> PointOutcome {
        let interrupt = AtomicBool::new(false);
        investigate(model, kernel, start, &questions(10, 50), &interrupt).unwrap()
    }
    let closed_modes = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
    let stepping = Stepping::new(&model, 400, 1000);
    let far = [
        put(&model, &volterra(&model), start(1e10)),
        put(&model, &closed_modes, start(-1e10)),
        put(&model, &stepping, start(1e7)),
    ];
    for (outcome, said) in far.iter().zip(["1.0e10", "1.0e10", "1.0e7"]) {
        assert_eq!((&outcome.status, outcome.cycles), (&Status::Diverged, 0));
        let reason = &outcome.reason;
        assert!(
            reason.contains(said) && reason.contains("run.initial"),
            "{reason}"
        );
    }
    let near = put(&model, &closed_modes, start(1e3));
    assert!(
        near.cycles > 0 && !near.reason.contains("run.initial"),
        "{near:?}"
    );
}

/// The residual over twenty cycles from static equilibrium.
fn residual_at_rest(structure: &ModalStructure, half_gap: f64, load: f64) -> f64 {
    let mut drive = common::two_level_mesh(half_gap);
    drive.mesh = Division::levels(&[4e8], &[]);
    drive.transmission_error = vec![MeshHarmonic::new(1, 0.0, 0.0)];
    let point = OperatingPoint {
        load,
        speed: 1200.0,
    };
    let model = Model::new(structure, &drive, point).unwrap();
    let start = model.start(&InitialState::Static);
    let mut audit = EnergyAudit::new(&model);
    let (end, counters) = advance_with(&volterra(&model), &start, 20, &mut audit);
    assert_eq!(counters.events, 0);
    audit.residual(&end).unwrap()
}

/// For a drive at rest under its load the balance consists of round-off only, for any ratio of the load to the half gap
/// and to the stiffness of the mesh.
#[test]
fn the_round_off_of_a_drive_at_rest_is_no_residual() {
    let mesh = [0.0, 0.78, 0.47, -0.55, -0.56, -0.49];
    let torque = [0.0, 0.78, -0.6, 0.61, 0.2, 0.0];
    let frequency = [0.0, 0.0, 3660.0, 4290.0, 4570.0, 4680.0];
    let six = common::structure(&frequency, 0.01, &mesh, &torque);
    let one = common::structure(&[0.0], 0.0, &[1.3], &[1.3]);
    for structure in [&six, &one] {
        for half_gap in [1e-9, 1e-5, 1e-3] {
            for load in [1e-9, 1e-4, 0.3, 1.0, 100.0] {
                let residual = residual_at_rest(structure, half_gap, load);
                assert!(residual < 1e-12, "{half_gap:e} {load:e}: {residual:e}");
            }
        }
    }
}

/// A kernel that kicks the velocity of a mode once a cycle.
struct Kicking<'m> {
    kernel: Volterra<'m>,
    kick: f64,
}

impl Kernel for Kicking<'_> {
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
        (self.kernel).advance_cycle(trajectory, tangents, workspace, observer, counters)?;
        let last = trajectory.state.len() - 1;
        trajectory.state[last] *= 1.0 + self.kick;
        Ok(())
    }
}

/// The energy balance detects a kernel that does not follow the drive, and its results are not `ok`. The results of a
/// kernel that follows the drive are `ok`, settled or not.
#[test]
fn a_kernel_that_misses_the_balance_is_called_inaccurate() {
    for (load, speed) in [(1.0, 400.0), (0.2, 1800.0), (0.05, 1200.0)] {
        let model = small_oscillator(load, speed);
        for (kick, word) in [(0.0, "ok"), (1e-4, "inaccurate")] {
            let kernel = Kicking {
                kernel: volterra(&model),
                kick,
            };
            let start = model.start(&InitialState::Static);
            let asked = questions(500, 1000);
            let never = AtomicBool::new(false);
            let outcome = investigate(&model, &kernel, start, &asked, &never).unwrap();
            assert_eq!(outcome.status.name(), word, "{}", outcome.reason);
            // The results are kept.
            assert!(outcome.class.is_some() && outcome.nvh.is_some());
            let told = outcome.reason.contains("the energy balance is off by");
            assert_eq!(told, kick > 0.0, "{}", outcome.reason);
        }
    }
}

/// Small steps leave a residual by design, which is acceptable.
#[test]
fn a_kernel_that_approximates_is_not_called_inaccurate() {
    let model = small_oscillator(0.2, 1800.0);
    let start = model.start(&InitialState::Static);
    let kernel = Stepping::new(&model, 400, 1000);
    let asked = questions(500, 1000);
    let outcome = investigate(&model, &kernel, start, &asked, &AtomicBool::new(false)).unwrap();
    assert!(outcome.energy_residual.unwrap() > 1e-8);
    assert_ne!(outcome.status.name(), "inaccurate");
}

/// A flag that is raised during the first cycle: the integration ends within it.
#[test]
fn an_integration_ends_within_the_cycle_in_which_it_is_called_off() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let small = Stepping::new(&model, 4000, 1000);
        let closed_modes = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
        let cycles = [
            cut_short(&model, &volterra(&model)),
            cut_short(&model, &small),
            cut_short(&model, &closed_modes),
        ];
        for [shown, whole] in cycles {
            assert!(shown == 3 && whole > 3, "{name}: {shown} of {whole}");
        }
    }
}

#[test]
fn investigation_repeats_to_the_bit() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let q = questions(50, 400);
        let (a, b) = (ask(&model, &q), ask(&model, &q));
        assert!(
            a.lyapunov.is_some() && !a.spectra.is_empty(),
            "{name}: {}",
            a.reason
        );
        assert!(a.energy_residual.unwrap() < 1e-13);
        assert_eq!(format!("{a:?}"), format!("{b:?}"), "{name}");
    }
}
