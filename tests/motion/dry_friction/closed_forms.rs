//! A mass on a belt, Den Hartog's motions without stops, free motions that friction ends, sticks that a load ends.

use crate::common::advance::{Events, volterra};
use gearatlas::model::{Drive, Model, OperatingPoint, TrajectoryState};
use gearatlas::propagate::{Counters, Event, Kernel, Stop, Tangents};
use gearatlas::structure::{
    ContactLaw, Coupling, FrictionLaw, HarmonicLoad, ModalStructure, StructureContact,
};
use std::f64::consts::{PI, TAU};

/// A gap of the mesh that no motion in these tests crosses.
const WIDE: f64 = 100.0;

/// A mass of 1 kg on a spring of 1 N/m with dry friction under a load `cos(2π t/period + phase)`. The mesh cycle has
/// this period.
fn model(law: FrictionLaw, period: f64, phase: Option<f64>) -> Model {
    let mut structure = ModalStructure::of_modes(&[1.0], 0.0, &[1.0], &[1.0]);
    structure.contacts = StructureContact::dry_friction("rub", &[1.0], law).into();
    structure.harmonic_loads = phase
        .map(|phase| HarmonicLoad {
            name: "load".to_owned(),
            force: vec![1.0],
            turns_per_cycle: 1.0,
            phase,
        })
        .into_iter()
        .collect();
    let point = OperatingPoint {
        load: 0.0,
        speed: TAU / period,
    };
    Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap()
}

/// Advances cycles with the identity as tangents. Returns the trajectory, the columns of its derivative, the events and
/// the counters.
fn follow(
    model: &Model,
    start: &TrajectoryState,
    cycles: u64,
) -> (TrajectoryState, [[f64; 2]; 2], Vec<Event>) {
    let kernel = volterra(model);
    let mut trajectory = start.clone();
    let mut tangents = Tangents::zeros(1, 2);
    (0..2).for_each(|i| tangents.vector_mut(i)[i] = 1.0);
    let (mut seen, mut counters) = (Events::default(), Counters::default());
    let mut workspace = kernel.workspace();
    for _ in 0..cycles {
        (kernel.advance_cycle(
            &mut trajectory,
            &mut tangents,
            &mut workspace,
            &mut seen,
            &mut counters,
        ))
        .unwrap();
    }
    let columns = [0, 1].map(|i| [tangents.vector(i)[0], tangents.vector(i)[1]]);
    (trajectory, columns, seen.0)
}

/// Times of events since the start of cycle 0.
fn times(model: &Model, events: &[Event]) -> Vec<f64> {
    (events.iter())
        .map(|event| event.cycle as f64 * model.period() + event.time)
        .collect()
}

/// Stick and slip of a mass on a belt in closed form. With a = F_s − F it slips for `2π − 2 arctan(a/u)` and sticks for
/// 2 a/u, between F − a and F_s. Its greatest displacement is `F + √(a² + u²)`.
#[test]
fn a_mass_on_a_belt_sticks_and_slips() {
    for (force, static_force, u) in [(0.7, 1.0, 0.2), (0.5, 2.0, 0.9), (1.0, 1.001, 0.01)] {
        for way in [1.0, -1.0] {
            let law = FrictionLaw {
                force,
                static_force,
                belt_speed: way * u,
            };
            let a = static_force - force;
            let [slips, sticks] = [TAU - 2.0 * (a / u).atan(), 2.0 * a / u];
            let model = model(law, slips + sticks, None);
            // The mass starts to stick at the force F.
            let start = TrajectoryState::new(&model, vec![way * force, way * u], 0);
            let [own] = model.frictions[..] else { panic!() };
            assert!(start.contact.holds(own.stick()));
            let (end, columns, events) = follow(&model, &start, 7);
            let mut late = 0.0_f64;
            for (number, pair) in times(&model, &events).chunks(2).enumerate() {
                let period = number as f64 * model.period();
                let begins = a / u + period;
                late = late.max((pair[0] - begins).abs());
                late = late.max((pair[1] - begins - slips).abs());
            }
            assert_eq!(events.len(), 14);
            let backwards = own.slip_towards(-way);
            assert!(events.iter().all(|event| event.contact == backwards));
            let off = (end.state[0] - way * force).abs();
            println!("{law:?}: late by {late:.1e} s, off by {off:.1e} m");
            // The error of the time of release from a slow belt is the error of the displacement divided by the speed.
            assert!(
                late < 3e-13 * (1.0 + 1.0 / u) && off < 1e-12,
                "{late:e} {off:e}"
            );
            assert_eq!(end.state[1], way * u);
            // A stick removes one dimension. An autonomous motion keeps the other one.
            assert!((columns[0][0] - 1.0).abs() < 1e-12, "{columns:?}");
            let speeds = [columns[0][1], columns[1][0], columns[1][1]];
            assert!(
                speeds[0].abs() < 1e-12 && speeds[2].abs() < 1e-12,
                "{speeds:?}"
            );
        }
    }
}

/// Den Hartog 1931: no stops, `A² = V² − f²U²`, `V = 1/(1 − β²)`, `U = sin(π/β)/(β(1 + cos(π/β)))`. Derived figures:
/// the f at which stops begin, and the amplitude at half of it.
#[test]
fn a_forced_motion_without_stops_has_the_amplitude_of_den_hartog() {
    for (beta, most, amplitude) in [
        (0.3, 0.08641, 1.070_217_33),
        (0.4, 0.14389, 1.176_810_47),
        (0.6, 0.53152, 1.541_430_92),
        (0.7, 0.72208, 1.851_047_26),
        (0.8, 0.81741, 2.488_939_02),
        (0.9, 0.81965, 4.586_021_06),
        (1.1, 0.74677, 4.135_458_00),
        (1.2, 0.71321, 1.983_754_91),
        (1.5, 0.64659, 0.707_560_08),
        (2.0, 0.59630, 0.298_140_16),
        (3.0, 0.56253, 0.112_671_98),
    ] {
        let (sin, cos) = (PI / beta).sin_cos();
        let v: f64 = 1.0 / (1.0 - beta * beta);
        let u = sin / (beta * (1.0 + cos));
        let at = |part: f64| {
            let force: f64 = part * most;
            let amplitude = (v * v - (force * u).powi(2)).max(0.0).sqrt();
            let sine = (-force * u / v).clamp(-1.0, 1.0);
            // The phase of the load where x is largest.
            let phase = f64::atan2(sine, v.signum() * (1.0 - sine * sine).sqrt());
            let law = FrictionLaw {
                force,
                static_force: force,
                belt_speed: 0.0,
            };
            (amplitude, model(law, TAU / beta, Some(phase)), phase)
        };
        let (exact, model, phase_of_load) = at(0.5);
        let force_of_friction = 0.5 * most;
        // The printed limits have five digits.
        assert!(
            (exact / amplitude - 1.0).abs() < 2e-4,
            "{beta} {exact} {amplitude}"
        );
        let start = TrajectoryState::new(&model, vec![exact, 0.0], 0);
        let [own] = model.frictions[..] else { panic!() };
        assert!(start.contact.holds(own.slip_towards(-1.0)), "{beta}");
        let (end, columns, events) = follow(&model, &start, 1);
        let off = [end.state[0] - exact, end.state[1]];
        println!("{beta}: off by {:.1e} m, {:.1e} m/s", off[0], off[1]);
        assert!(off.iter().all(|off| off.abs() < 4e-14), "{beta} {off:?}");
        // Half a period later the mass turns: one slip ends, the other begins. The turn at the end of the cycle may be
        // within round-off of that end.
        let half = model.period() / 2.0;
        assert!((events[0].time - half).abs() < 1e-6 && events[1].time == events[0].time);
        assert_eq!(
            [events[0].contact, events[1].contact],
            [own.slip_towards(-1.0), own.forwards]
        );
        // Without a damper, phase volume shrinks only at the turns, by the ratio of the accelerations after and before
        // a turn.
        let spring = -exact + phase_of_load.cos();
        let ratio = (spring + force_of_friction) / (spring - force_of_friction);
        // Round-off decides whether the cycle includes the turn at its end.
        let expected = ratio.powi(events.len() as i32 / 2);
        let volume = columns[0][0] * columns[1][1] - columns[0][1] * columns[1][0];
        assert!(
            (volume / expected - 1.0).abs() < 1e-9,
            "{beta} {volume} {expected}"
        );
        for (part, sticks) in [(0.98, false), (1.02, true)] {
            let (exact, model, _) = at(part);
            let start = TrajectoryState::new(&model, vec![exact, 0.0], 0);
            let (.., events) = follow(&model, &start, 40);
            let stuck = |event: &Event| event.to.holds(own.stick());
            let times = times(&model, &events);
            let long = (events.iter().zip(&times).zip(&times[1..]))
                .any(|((event, begin), end)| stuck(event) && end - begin > 1e-6);
            assert_eq!(long, sticks, "{beta} {part}");
        }
    }
}

/// Each half cycle of a free motion reduces the amplitude by 2F/k, until the spring cannot overcome the friction.
#[test]
fn a_free_motion_stops_where_friction_holds_the_spring() {
    let law = FrictionLaw {
        force: 0.1,
        static_force: 0.13,
        belt_speed: 0.0,
    };
    let model = model(law, TAU, None);
    let start = TrajectoryState::new(&model, vec![1.05, 0.0], 0);
    let [own] = model.frictions[..] else { panic!() };
    for (cycles, place) in [(1, 0.65), (2, 0.25), (3, -0.05), (50, -0.05)] {
        let (end, columns, events) = follow(&model, &start, cycles);
        assert!(
            (end.state[0] - place).abs() < 1e-13,
            "{cycles} {:?}",
            end.state
        );
        if cycles >= 3 {
            // 1.05 − 5 · 2 · 0.1 = 0.05 after five half cycles, where it stays.
            assert_eq!(end.state[1], 0.0);
            assert!(end.contact.holds(own.stick()));
            let last = times(&model, &events);
            assert!((last[last.len() - 1] - 5.0 * PI).abs() < 1e-6, "{last:?}");
            assert_eq!([columns[0][1], columns[1][1]], [0.0; 2]);
        }
    }
}

/// A sticking mass slips from the moment at which the load exceeds the static force.
#[test]
fn a_stick_ends_where_the_load_exceeds_the_static_force() {
    for (static_force, force) in [(0.8, 0.8), (0.8, 0.5)] {
        let law = FrictionLaw {
            force,
            static_force,
            belt_speed: 0.0,
        };
        let model = model(law, TAU / 0.7, Some(-0.5 * PI));
        let start = TrajectoryState::new(&model, vec![0.0, 0.0], 0);
        let (_, _, events) = follow(&model, &start, 1);
        let exact = f64::asin(static_force) / 0.7;
        assert!((events[0].time - exact).abs() < 1e-13, "{:?}", events[0]);
        assert_eq!(events[0].contact, model.frictions[0].forwards);
    }
}

/// Models are refused with a static force below that of sliding, two elements along one line, or a belt without a
/// finite speed.
#[test]
fn faulty_elements_are_refused() {
    let made = |laws: &[FrictionLaw]| {
        let mut structure = ModalStructure::of_modes(&[1.0], 0.0, &[1.0], &[1.0]);
        let parts = laws
            .iter()
            .flat_map(|law| StructureContact::dry_friction("rub", &[1.0], *law));
        structure.contacts = parts.collect();
        let point = OperatingPoint {
            load: 0.0,
            speed: 1.0,
        };
        let refused = Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap_err();
        refused.to_string()
    };
    let law = FrictionLaw {
        force: 1.0,
        static_force: 1.0,
        belt_speed: 0.0,
    };
    let with = |force: f64, static_force: f64, belt_speed: f64| FrictionLaw {
        force,
        static_force,
        belt_speed,
    };
    for (laws, told) in [
        (
            &[with(-1.0, 1.0, 0.0)][..],
            "force of dry friction is -1, but must be above 0 N",
        ),
        (
            &[with(1.0, 0.5, 0.0)],
            "static force of dry friction is 0.5",
        ),
        (
            &[with(1.0, 1.0, f64::NAN)],
            "belt speed of dry friction is NaN",
        ),
        (&[law, law], "element 2 of dry friction"),
    ] {
        let said = made(laws);
        assert!(said.contains(told), "{said}");
    }
}

/// A structure that gains energy from negative damping without limit ends with a status.
#[test]
fn an_unstable_motion_ends_as_diverged() {
    let mut structure = ModalStructure::of_modes(&[1.0], 0.0, &[1.0], &[1.0]);
    let law = FrictionLaw {
        force: 0.1,
        static_force: 0.1,
        belt_speed: 0.0,
    };
    structure.contacts = StructureContact::dry_friction("rub", &[1.0], law).into();
    structure.coupling = Some(Coupling {
        damping: vec![-0.5],
        gyroscopic: vec![0.0],
        stiffness: vec![0.0],
    });
    let point = OperatingPoint {
        load: 0.0,
        speed: 1.0,
    };
    let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap();
    let kernel = volterra(&model);
    let mut trajectory = TrajectoryState::new(&model, vec![1.0, 0.0], 0);
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    let ended = kernel.advance(
        10_000,
        &mut trajectory,
        &mut workspace,
        &mut (),
        &mut counters,
    );
    assert!(matches!(ended, Err(Stop::Diverged { .. })), "{ended:?}");
}

/// A softening spring: beyond 1 m a stiffness of 1 N/m becomes −3 N/m. From a start beyond the unstable rest at 4/3 m
/// the motion grows as `cosh` and ends as diverged. From a start below this rest the motion returns.
#[test]
fn a_contact_that_softens_lets_go_as_cosh() {
    let mut structure = ModalStructure::of_modes(&[1.0], 0.0, &[1.0], &[1.0]);
    let law = ContactLaw {
        gap: 1.0,
        stiffness: vec![(1.0, [-4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
        ..ContactLaw::default()
    };
    structure.contacts = vec![StructureContact::plain(
        "softening".to_owned(),
        vec![1.0],
        law,
    )];
    let point = OperatingPoint {
        load: 0.0,
        speed: TAU / 0.5,
    };
    let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap();
    let rest: f64 = 4.0 / 3.0;
    for start in [1.4, 1.3] {
        // x = r + (x₀ − r) cosh √3 t while x > 1.
        let from = TrajectoryState::new(&model, vec![start, 0.0], 0);
        let (end, columns, _) = follow(&model, &from, 2);
        let exact = rest + (start - rest) * f64::cosh(3.0_f64.sqrt());
        assert!(
            (end.state[0] - exact).abs() < 1e-13,
            "{start} {:?} {exact}",
            end.state
        );
        assert!((columns[0][0] - f64::cosh(3.0_f64.sqrt())).abs() < 1e-12);
        let kernel = volterra(&model);
        let (mut workspace, mut counters, mut trajectory) =
            (kernel.workspace(), Counters::default(), from);
        let ended = kernel.advance(
            1000,
            &mut trajectory,
            &mut workspace,
            &mut (),
            &mut counters,
        );
        if start > rest {
            assert!(matches!(ended, Err(Stop::Diverged { .. })), "{ended:?}");
        } else {
            // The mass swings through 0 to the other side, where the spring alone acts, and returns.
            let energy = 0.5 * start * start - 2.0 * (start - 1.0) * (start - 1.0);
            let [x, v] = [trajectory.state[0], trajectory.state[1]];
            let soft = 2.0 * (x - 1.0).max(0.0).powi(2);
            assert!(ended.is_ok());
            assert!((0.5 * (x * x + v * v) - soft - energy).abs() < 1e-11);
        }
    }
}
