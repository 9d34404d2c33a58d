//! A drive with growing speed, compared with the integrator in extended precision, and slow growth compared with fixed
//! speeds.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::settled;
use gearatlas::analysis::EnergyNorm;
use gearatlas::model::{ActiveSet, InitialState};
use gearatlas::propagate::Kernel;
use gearatlas::propagate::varying_speed::{
    MotionObserver, MovingEvent, SpeedInterval, VaryingSpeed,
};
use gearatlas::propagate::{Counters, InstructionSet};
use gearatlas::reference::Extended;

/// Events: phase, closed contacts after it.
#[derive(Default)]
struct Events(Vec<(f64, ActiveSet)>);

impl MotionObserver for Events {
    fn event(&mut self, event: &MovingEvent) {
        self.0.push((event.phase, event.to));
    }
}

/// Consecutive mesh cycles of a growing speed, each from the state of the last: events and ends. The growth of 5 % per
/// cycle is far beyond that of test benches.
#[test]
fn growing_speed_is_exact_to_round_off() {
    let drives = [
        ("one degree", common::one_degree()),
        ("six modes", common::six_modes()),
        ("forty modes", common::forty_modes()),
    ];
    for (name, drive) in drives {
        let model = common::model(&drive);
        let kernel = VaryingSpeed::new(&drive.0, &model, 1000, InstructionSet::best()).unwrap();
        let (period, growth) = (model.period(), 0.05);
        // ṡ = 1 + a t passes one period T after τ = (√(1 + 2 a T) − 1)/a.
        let a = growth / period;
        let duration = 2.0 * period / (1.0 + (1.0 + 2.0 * growth).sqrt());
        let speed = 1.0 / (kernel.cycles_per_radian() * period);
        let mut stretch = SpeedInterval::steady(duration, speed, model.load);
        stretch.rotation[2] = 0.5 * a * speed;
        let extended = Extended::new(&model).accelerated(a);
        let mut start = settled(&model, 40);
        let (mut state, mut time, mut events) = (0.0f64, 0.0f64, 0);
        for _ in 0..40 {
            let exact = extended.advance(&start, 1).unwrap();
            let mut motion = kernel.start(&start);
            let (mut seen, mut counters) = (Events::default(), Counters::default());
            let mut room = kernel.workspace();
            kernel
                .advance(&mut motion, &stretch, &mut room, &mut seen, &mut counters)
                .unwrap();
            assert_eq!(seen.0.len(), exact.crossings.len(), "{name}");
            for ((phase, to), known) in seen.0.iter().zip(&exact.crossings) {
                assert_eq!(*to, known.to, "{name}");
                time = time.max((phase - known.time.value() / period).abs());
            }
            let norm = EnergyNorm::new(&model);
            let off = norm.length(&exact.difference(&motion.state)) / norm.unit();
            state = state.max(off);
            events += seen.0.len();
            start = exact.end();
        }
        println!("{name}: state {state:.1e}, event phase {time:.1e}, {events} events");
        assert!(events > 40, "{name} does not rattle");
        assert!(state < 1e-12, "{name}: {state:e}");
        assert!(time < 1e-12, "{name}: {time:e}");
    }
}

/// In permanent contact, a run-up through a speed differs from the motion at this speed in proportion to its rate.
#[test]
fn slow_run_ups_pass_the_motions_of_fixed_speeds() {
    let drive = common::six_modes();
    let (from, to, load) = (180.0, 200.0, 0.8);
    let teeth = drive.0.cycles_per_turn() / std::f64::consts::TAU;
    let model = common::model_at(&drive, load, to);
    let kernel = common::advance::volterra(&model);
    let mut fixed = model.start(&InitialState::Static);
    let (mut room, mut counters) = (kernel.workspace(), Counters::default());
    kernel
        .advance(3000, &mut fixed, &mut room, &mut (), &mut counters)
        .unwrap();
    let varying = VaryingSpeed::new(&drive.0, &model, 1000, InstructionSet::best()).unwrap();
    let norm = EnergyNorm::new(&model);
    let off = |cycles: f64| -> f64 {
        // There is a whole number of cycles between the two speeds.
        let duration = cycles / (0.5 * (from + to) * teeth);
        let mut stretch = SpeedInterval::steady(duration, from, load);
        stretch.rotation[2] = 0.5 * (to - from) / duration;
        let mut motion = varying.start(&fixed);
        let mut counters = Counters::default();
        let mut room = varying.workspace();
        let settling = SpeedInterval::steady(3000.0 / (from * teeth), from, load);
        for stretch in [settling, stretch] {
            varying
                .advance(&mut motion, &stretch, &mut room, &mut (), &mut counters)
                .unwrap();
        }
        assert_eq!(counters.events, 0);
        let passed = (motion.phase + 0.5).fract() - 0.5;
        assert!(passed.abs() < 1e-9, "{passed:e}");
        // Rotations without mesh participation are not compared.
        let mut difference: Vec<f64> = motion
            .state
            .iter()
            .zip(&fixed.state)
            .map(|(a, b)| a - b)
            .collect();
        let n = model.modes();
        for &block in &model.neutral {
            difference[block] = 0.0;
            difference[n + block] = 0.0;
        }
        norm.length(&difference) / norm.unit()
    };
    let [coarse, fine] = [4000.0, 8000.0].map(off);
    let order = (coarse / fine).log2();
    println!("{coarse:.2e} {fine:.2e} half gaps: order {order:.3}");
    assert!((order - 1.0).abs() < 0.05, "{coarse:e} {fine:e}");
    assert!(fine < 1e-2, "{fine:e}");
}
