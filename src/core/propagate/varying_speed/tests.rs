//! At constant speed, the motion is that of the other kernels. At varying speed, it agrees with closed forms.

use super::*;
use crate::model::{
    Drive, DriveShaft, ImposedMotion, InitialState, OperatingPoint, Release, fixtures,
};
use crate::propagate::{Counters, Event, Kernel, Observer, Volterra};
use crate::structure::Coupling;

/// Phases of events with the closed contacts after them, and the mesh period.
struct Events(Vec<(f64, ActiveSet)>, f64);

impl Observer for Events {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0
            .push((event.cycle as f64 + event.time / self.1, event.to));
    }
}

/// Phases of events at a varying speed, with the closed contacts after them.
#[derive(Default)]
struct Phases(Vec<(f64, ActiveSet)>);

impl MotionObserver for Phases {
    fn event(&mut self, event: &MovingEvent) {
        self.0.push((event.cycle as f64 + event.phase, event.to));
    }
}

fn structure() -> ModalStructure {
    let mesh = [0.8, 0.6, 0.5, 0.4];
    let mut own = fixtures::structure(&[0.0, 0.0, 2500.0, 9000.0], 0.02, &mesh, &mesh);
    own.pinion_torque = Some(vec![16.0, 0.0, 5.0, 3.0]);
    own.wheel_torque = Some(vec![0.0, -8.0, 2.0, 1.0]);
    own
}

fn drives() -> Vec<Drive> {
    let mut sloping = fixtures::two_level_mesh(1e-5);
    sloping.mesh[0].stiffness =
        crate::model::Stiffness::series([4e8, 3e7, -1e7, 4e6, 0.0, 0.0, 0.0, 0.0]);
    sloping.mesh[1].error =
        crate::model::FlankError::series([2e-6, 1e-6, -5e-7, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut never_pulls = fixtures::two_level_mesh(1e-5);
    never_pulls.release = Release::Force;
    let mut both = sloping.clone();
    both.release = Release::Force;
    vec![fixtures::two_level_mesh(1e-5), sloping, never_pulls, both]
}

/// A mesh cycle that is divided into speed intervals has the same events and the same end as with the
/// Volterra kernel.
#[test]
fn constant_speed_is_the_motion_of_the_other_kernels() {
    let structure = structure();
    for (case, drive) in drives().into_iter().enumerate() {
        let point = fixtures::strong_rattle();
        let model = Model::new(&structure, &drive, point).unwrap();
        let mut trajectory = model.start(&InitialState::Static);
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let (mut counters, mut events) = (Counters::default(), 0);
        let mut room = kernel.workspace();
        let kernels: Vec<VaryingSpeed> = (InstructionSet::available().into_iter())
            .map(|set| VaryingSpeed::new(&structure, &model, 1000, set).unwrap())
            .collect();
        for _ in 0..40 {
            let mut motions: Vec<Motion> = kernels
                .iter()
                .map(|kernel| kernel.start(&trajectory))
                .collect();
            let mut observed = Events(Vec::new(), model.period());
            kernel
                .advance(1, &mut trajectory, &mut room, &mut observed, &mut counters)
                .unwrap();
            events += observed.0.len();
            for (own, motion) in kernels.iter().zip(&mut motions) {
                let (mut room, mut phases) = (own.workspace(), Phases::default());
                for part in [0.31, 0.009, 0.4, 0.281] {
                    let stretch =
                        SpeedInterval::steady(part * model.period(), point.speed, point.load);
                    own.advance(motion, &stretch, &mut room, &mut phases, &mut counters)
                        .unwrap();
                }
                // Events at the start of the next cycle do not belong to this one.
                let end = trajectory.cycle as f64 - 1e-12;
                phases.0.retain(|(phase, _)| *phase < end);
                assert_eq!(
                    phases.0.len(),
                    observed.0.len(),
                    "{case}: {:?} {:?}",
                    phases.0,
                    observed.0
                );
                for ((phase, to), (known, known_to)) in phases.0.iter().zip(&observed.0) {
                    assert_eq!(to, known_to);
                    let off = phase - known;
                    assert!(off.abs() < 2e-12, "{case} {phase}: {off:e}");
                }
                let passed = motion.cycle as f64 + motion.phase - trajectory.cycle as f64;
                assert!(passed.abs() < 1e-14, "{case}: {passed:e}");
                for (i, (x, known)) in motion.state.iter().zip(&trajectory.state).enumerate() {
                    let scale = [1e-5, 1e-5 / model.period()][i / model.modes()];
                    assert!(
                        (x - known).abs() < 1e-11 * scale,
                        "{case} {i}: {:e}",
                        (x - known) / scale
                    );
                }
            }
        }
        assert!(events > 60, "{case}: {events}");
    }
}

/// A torque accelerates the pinion of two rigid gears in lasting contact. The mesh force bears the load and
/// accelerates the wheel.
#[test]
fn acceleration_loads_the_mesh() {
    let (a, b) = (0.8, 0.6);
    let mut structure = fixtures::structure(&[0.0, 0.0], 0.0, &[a, b], &[a, b]);
    // Pitch radius 20 mm of the pinion, 30 mm of the wheel.
    let radii = [0.02, 0.03];
    structure.pinion_torque = Some(vec![a / radii[0], 0.0]);
    structure.wheel_torque = Some(vec![0.0, -b / radii[1]]);
    let drive = Drive {
        damping: 5e4,
        ..fixtures::constant_mesh(1e-5, 4e8)
    };
    let point = OperatingPoint {
        load: 0.5,
        speed: 60.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let kernel = VaryingSpeed::new(&structure, &model, 100, InstructionSet::best()).unwrap();
    // Moments of inertia: mass along the line of action 1/a² and 1/b².
    let inertia = [radii[0].powi(2) / (a * a), radii[1].powi(2) / (b * b)];
    let ratio = radii[0] / radii[1];
    let reduced = inertia[0] + ratio * ratio * inertia[1];
    let found = 1.0 / kernel.mean_acceleration([1.0, 0.0]).unwrap();
    assert!((found / reduced - 1.0).abs() < 1e-13, "{found} {reduced}");
    // A torque on the wheel acts like one on the pinion, times the ratio of the numbers of teeth.
    let of_wheel = kernel.mean_acceleration([0.0, 1.0]).unwrap() * reduced;
    assert!((of_wheel - ratio).abs() < 1e-13, "{of_wheel}");

    /// The mesh force at the end of the last window.
    struct Last(MovingSignal, Instant, f64);
    impl MotionObserver for Last {
        fn window(&mut self, window: &VaryingSpeedWindow<'_>) {
            window.evaluate_at(window.part, false, &mut self.1);
            self.2 = self.0.value(window, &self.1);
        }
    }
    let acceleration = 400.0;
    let after = |structure: &ModalStructure| {
        let model = Model::new(structure, &drive, point).unwrap();
        let kernel = VaryingSpeed::new(structure, &model, 100, InstructionSet::best()).unwrap();
        let mut stretch = SpeedInterval::steady(0.5, point.speed, point.load);
        stretch.rotation[2] = 0.5 * acceleration;
        let stretch = stretch.accelerated(&kernel);
        let mut motion = kernel.start(&model.start(&InitialState::Static));
        let mut signals = MovingSignal::of_model(&model).into_iter();
        let force = signals.find(|signal| signal.named()[0] == "force").unwrap();
        let mut last = Last(force, Instant::new(&kernel), 0.0);
        let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
        kernel
            .advance(
                &mut motion,
                &stretch,
                &mut workspace,
                &mut last,
                &mut counters,
            )
            .unwrap();
        (last.2, motion, kernel.mean_acceleration([1.0, 0.0]))
    };
    let (force, motion, _) = after(&structure);
    let exact = point.load * structure.rated_force + inertia[1] * acceleration * ratio / radii[1];
    assert!((force / exact - 1.0).abs() < 1e-10, "{force} {exact}");
    // A very small drag does not change the force, but the torques alone no longer determine the speed.
    structure.coupling = Some(Coupling {
        damping: vec![1e-9, 0.0, 0.0, 1e-9],
        gyroscopic: vec![0.0; 4],
        stiffness: vec![0.0; 4],
    });
    let (with_drag, _, free) = after(&structure);
    assert!(
        (with_drag / exact - 1.0).abs() < 1e-7,
        "{with_drag} {exact}"
    );
    assert_eq!(free, None);
    // 60 rad/s · 0.5 s + ½ · 400 rad/s² · (0.5 s)² = 80 rad.
    let cycles = motion.cycle as f64 + motion.phase;
    assert!(
        (cycles / (80.0 * 20.0 / TAU) - 1.0).abs() < 1e-14,
        "{cycles}"
    );
}

/// An end with a large inertia follows the imposed angle ψ while the speed rises. A spring connects it to a
/// light inertia, whose relative vibration obeys `z'' + 2 ζ ω z' + ω² z = −ψ''`.
#[test]
fn an_imposed_motion_follows_the_rotation() {
    let (heavy, light, own, ratio) = (1e7f64, 2e-3, 900.0, 0.03);
    let total = heavy + light;
    // A common rotation, and the light end relative to the heavy one.
    let elastic = [
        -(light / (heavy * total)).sqrt(),
        (heavy / (light * total)).sqrt(),
    ];
    let mut structure = fixtures::structure(&[0.0, own], ratio, &[0.0, 1e-3], &[0.0, 1e-3]);
    structure.pinion_torque = Some(vec![total.sqrt().recip(), elastic[0]]);
    structure.torque = vec![0.0; 2];
    let motion = ImposedMotion {
        shaft: DriveShaft::Pinion,
        order: 2.5,
        amplitude: 0.01,
        phase: 0.4,
    };
    let drive = Drive {
        imposed_motion: vec![motion],
        ..Drive::constant(1.0, 4e8)
    };
    let point = OperatingPoint {
        load: 0.0,
        speed: 60.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let kernel = VaryingSpeed::new(&structure, &model, 100, InstructionSet::best()).unwrap();
    let (time, acceleration) = (0.3, 800.0);
    let angle = |t: f64| 2.5 * (point.speed * t + 0.5 * acceleration * t * t) + 0.4;
    let rate = |t: f64| 2.5 * (point.speed + acceleration * t);
    let imposed = |t: f64| 0.01 * angle(t).cos();
    let imposed_rate = |t: f64| -0.01 * rate(t) * angle(t).sin();
    let second = |t: f64| {
        let bent = 2.5 * acceleration * angle(t).sin();
        -0.01 * (rate(t) * rate(t) * angle(t).cos() + bent)
    };
    let mut stretch = SpeedInterval::steady(time, point.speed, 0.0);
    stretch.rotation[2] = 0.5 * acceleration;
    let start = model.start(&InitialState::Modal {
        displacement: vec![0.0; 2],
        velocity: vec![0.0; 2],
    });
    let mut motion = kernel.start(&start);
    let mut room = kernel.workspace();
    let mut counters = Counters::default();
    kernel
        .advance(&mut motion, &stretch, &mut room, &mut (), &mut counters)
        .unwrap();
    // Initially, the heavy end has no displacement and no velocity.
    let exact = imposed(time) - imposed(0.0) - time * imposed_rate(0.0);
    let rotation = motion.state[0] / total.sqrt();
    assert!((rotation - exact).abs() < 1e-11, "{rotation} {exact}");
    // Duhamel's integral by Simpson's rule.
    let damped = own * (1.0 - ratio * ratio).sqrt();
    let answer = |t: f64| {
        let since = time - t;
        -second(t) * (-ratio * own * since).exp() * (damped * since).sin() / damped
    };
    let steps = 40_000;
    let h = time / f64::from(steps);
    let weight = |k: i32| match k {
        0 => 1.0,
        k if k == steps => 1.0,
        k => f64::from(2 + 2 * (k % 2)),
    };
    let sum: f64 = (0..=steps)
        .map(|k| weight(k) * answer(f64::from(k) * h))
        .sum();
    let exact = sum * h / 3.0;
    let twist = motion.state[1] * (elastic[1] - elastic[0]);
    assert!((twist / exact - 1.0).abs() < 1e-8, "{twist} {exact}");
}

/// A drive that comes to rest and a NaN state end the integration.
#[test]
fn what_cannot_go_on_stops() {
    let structure = structure();
    let drive = fixtures::two_level_mesh(1e-5);
    let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
    let kernel = VaryingSpeed::new(&structure, &model, 2, InstructionSet::best()).unwrap();
    let start = model.start(&InitialState::Static);
    let advanced = |stretch: &SpeedInterval, motion: &mut Motion| {
        let mut counters = Counters::default();
        kernel.advance(
            motion,
            stretch,
            &mut kernel.workspace(),
            &mut (),
            &mut counters,
        )
    };
    let mut braked = SpeedInterval::steady(0.1, 10.0, 0.1);
    braked.rotation[2] = -51.0;
    let found = advanced(&braked, &mut kernel.start(&start));
    assert_eq!(found, Err(crate::propagate::Stop::Backwards { cycle: 0 }));
    let mut lost = kernel.start(&start);
    lost.state[3] = f64::NAN;
    let steady = SpeedInterval::steady(0.1, 1200.0, 0.05);
    let found = advanced(&steady, &mut lost);
    assert!(
        matches!(found, Err(crate::propagate::Stop::Diverged { .. })),
        "{found:?}"
    );
    let found = advanced(&steady, &mut kernel.start(&start));
    assert!(
        matches!(
            found,
            Err(crate::propagate::Stop::EventStorm { limit: 2, .. })
        ),
        "{found:?}"
    );
}
