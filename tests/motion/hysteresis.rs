//! Dry sliders in series with springs: closed forms, other integrators, energy, tangents.

#![allow(clippy::unwrap_used)]

mod pieces;

use crate::common;
use common::advance::{Events, advance, advance_with, volterra};
use gearatlas::analysis::{EnergyAudit, EnergyNorm, Power, TangentGrowth, orbits};
use gearatlas::manifest;
use gearatlas::model::{DRIVE_FLANK, Drive, InitialState, Model, OperatingPoint, TrajectoryState};
use gearatlas::numerics::random::Stream;
use gearatlas::propagate::{Counters, Kernel, Observer, Tangents, Window};
use gearatlas::reference::{Extended, Reference};
use gearatlas::structure::{Coupling, HarmonicLoad, ModalStructure, StructureContact};
use pieces::{Oscillator, State};
use std::f64::consts::TAU;
use std::path::Path;

/// A gap of the mesh larger than all motions in these tests.
const WIDE: f64 = 100.0;

/// A structure whose mesh is never met, in mesh cycles of a period \[s\], with sliders `(participation, k, F)`.
fn model(structure: ModalStructure, period: f64, sliders: &[(&[f64], f64, f64)]) -> Model {
    let contacts = sliders.iter().flat_map(|&(felt, stiffness, limit)| {
        StructureContact::slider("element", felt, stiffness, limit)
    });
    let structure = ModalStructure {
        contacts: contacts.collect(),
        ..structure
    };
    let point = OperatingPoint {
        load: 0.0,
        speed: TAU / period,
    };
    Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap()
}

impl Oscillator {
    fn structure(&self) -> ModalStructure {
        let frequency = self.stiffness.sqrt();
        let ratio = 0.5 * self.damping / frequency;
        let mut structure = ModalStructure::of_modes(&[frequency], ratio, &[1.0], &[1.0]);
        if self.load != 0.0 {
            structure.harmonic_loads = vec![HarmonicLoad {
                name: "load".to_owned(),
                force: vec![self.load],
                turns_per_cycle: 1.0,
                phase: 0.0,
            }];
        }
        structure
    }

    /// The model of the oscillator; a mesh cycle is one period of the load.
    fn model(&self) -> Model {
        model(
            self.structure(),
            TAU / self.frequency,
            &[(&[1.0], self.spring, self.limit)],
        )
    }

    /// The state of the oscillator, with the state of its slider, from a trajectory of its model.
    fn state(&self, model: &Model, at: &TrajectoryState) -> State {
        let [forwards, backwards] = model.sliders[0].slips().map(|slip| at.contact.holds(slip));
        State {
            time: 0.0,
            x: at.state[0],
            v: at.state[2],
            s: at.state[1],
            way: f64::from(u8::from(forwards)) - f64::from(u8::from(backwards)),
        }
    }
}

const FREE: Oscillator = Oscillator {
    stiffness: 1.0,
    damping: 0.0,
    spring: 2.5,
    limit: 0.3,
    load: 0.0,
    frequency: 0.7,
};

const FORCED: Oscillator = Oscillator {
    damping: 0.04,
    load: 0.8,
    ..FREE
};

/// Times since the start of the events of a model's trajectory.
fn times(model: &Model, seen: &Events) -> Vec<f64> {
    (seen.0.iter())
        .map(|event| event.cycle as f64 * model.period() + event.time)
        .collect()
}

/// Free decay and a forced motion, event by event.
#[test]
fn an_element_follows_its_closed_form() {
    // A free motion without further slips touches the limit in every period: exclude this.
    for (name, own, cycles) in [("free decay", FREE, 3), ("forced", FORCED, 12)] {
        let model = own.model();
        let start = TrajectoryState::new(&model, vec![3.0, 2.9, 0.4, 0.0], 0);
        let mut seen = Events::default();
        let (end, _) = advance_with(&volterra(&model), &start, cycles, &mut seen);
        let end_time = cycles as f64 * model.period();
        let (exact, events) = own.follow(own.state(&model, &start), end_time);
        let own_times = times(&model, &seen);
        assert_eq!(
            seen.0.len(),
            events.len(),
            "{name}: {own_times:?} {events:?}"
        );
        assert!(events.len() > 8, "{name} slips {} times", events.len());
        let late =
            (own_times.iter().zip(&events)).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        let off = [
            end.state[0] - exact.x,
            end.state[2] - exact.v,
            end.state[1] - exact.s,
        ];
        let off = off.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
        println!(
            "{name}: {} events, off by {off:.1e}, {late:.1e} s",
            events.len()
        );
        assert!(off < 1e-10 && late < 1e-7, "{name}: {off:e} {late:e}");
        assert_eq!(own.state(&model, &end).way, exact.way);
    }
}

/// Stores the largest displacement.
#[derive(Default)]
struct Largest([f64; 2]);

impl Observer for Largest {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let [low, high] = self.0;
        self.0 = [low.min(window.first[1]), high.max(window.first[1])];
    }
}

/// Area of the hysteresis loop `4 F (Δ − F/k)` of a motion of amplitude Δ, from the dissipated power of a settled
/// motion.
#[test]
fn a_settled_loop_has_its_area() {
    let model = FORCED.model();
    let kernel = volterra(&model);
    let start = advance(&kernel, &model.start(&InitialState::Rest), 400);
    let mut seen = (Power::new(&model), Largest::default());
    let (end, _) = advance_with(&kernel, &start, 1, &mut seen);
    seen.0.cycle(&end);
    let power = seen.0.outcome().unwrap()[0];
    // The slider reverses at Δ − F/k on either side.
    let [low, high] = seen.1.0;
    let area = 2.0 * FORCED.limit * (high - low);
    let found = power.contact * model.period();
    println!(
        "area {area}, dissipated {found}: {:.1e}",
        found / area - 1.0
    );
    assert!((found / area - 1.0).abs() < 1e-10, "{found} {area}");
}

/// Total force of all elements over the displacement at the starts of windows.
#[derive(Default)]
struct Loop(Vec<[f64; 2]>);

impl Observer for Loop {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        // Series have Legendre terms: at the start the odd ones have the opposite sign of the even ones.
        let start = |series: &[f64]| -> f64 {
            let terms = series.iter().enumerate();
            terms.map(|(n, a)| if n % 2 == 0 { *a } else { -a }).sum()
        };
        let force = window.closed.iter().map(|own| start(own.force)).sum();
        self.0.push([start(window.deflection), force]);
    }
}

/// Masing's rule: a branch after a reversal at Δ is the first loading curve f₀, twice as large:
/// `f = f₀(Δ) − 2 f₀((Δ − δ)/2)`.
#[test]
fn an_iwan_set_obeys_masing() {
    let elements: [(&[f64], f64, f64); 4] = [
        (&[1.0], 1.0, 0.05),
        (&[1.0], 0.7, 0.12),
        (&[1.0], 0.5, 0.2),
        (&[1.0], 0.3, 0.21),
    ];
    let first = |x: f64| -> f64 {
        let of = |&(_, k, limit): &(&[f64], f64, f64)| (k * x).min(limit);
        elements.iter().map(of).sum()
    };
    let model = model(FREE.structure(), 1e-2, &elements);
    let mut state = vec![0.0; 2 * model.modes()];
    state[model.modes()] = 1.4;
    let start = TrajectoryState::new(&model, state, 0);
    let mut seen = Loop::default();
    let (_, counters) = advance_with(&volterra(&model), &start, 420, &mut seen);
    let turn = (0..seen.0.len())
        .max_by(|a, b| seen.0[*a][0].total_cmp(&seen.0[*b][0]))
        .unwrap();
    let [largest, _] = seen.0[turn];
    let back = (turn + 1..seen.0.len()).take_while(|i| seen.0[*i][0] < seen.0[i - 1][0]);
    let mut worst = 0.0_f64;
    for number in (0..=turn).chain(back) {
        let [x, force] = &seen.0[number];
        let exact = if number <= turn {
            first(*x)
        } else {
            first(largest) - 2.0 * first(0.5 * (largest - x))
        };
        worst = worst.max((force - exact).abs());
    }
    println!(
        "turn at {largest}, {} events, off by {worst:.1e}",
        counters.events
    );
    assert!(largest > 0.7 && counters.events >= 12, "{largest}");
    assert!(worst < 1e-10 * first(largest), "{worst:e}");
}

/// The orbit near the state of a model after some cycles.
fn orbit(model: &Model, cycles: u64) -> orbits::shooting::PeriodicOrbit {
    let (kernel, norm) = (volterra(model), EnergyNorm::new(model));
    let guess = advance(&kernel, &model.start(&InitialState::Rest), cycles);
    let mut workspace = kernel.workspace();
    let found = orbits::shooting::shoot(model, &kernel, &norm, &guess, 1, &mut workspace);
    found.unwrap().unwrap()
}

/// Largest displacement of a piecewise motion over a period from an orbit's start, and the distance of the motion's end
/// from its start.
fn amplitude(own: &Oscillator, start: State) -> [f64; 2] {
    let period = TAU / own.frequency;
    let (end, events) = own.follow(start, period);
    let turns = events.iter().map(|&time| own.follow(start, time).0.x.abs());
    let open = [end.x - start.x, end.v - start.v, end.s - start.s];
    [
        turns.fold(0.0, f64::max),
        open.iter().fold(0.0, |most: f64, d| most.max(d.abs())),
    ]
}

/// Den Hartog's oscillator at half the force below which nothing stops: `A² = V² − f² U²` (Den Hartog 1931). The
/// element approaches it as its spring stiffens.
#[test]
fn a_stiff_element_is_a_coulomb_damper() {
    for (beta, limit, amplitudes) in [(0.6, 0.26576, 1.541_430_92), (1.5, 0.323_295, 0.707_560_08)]
    {
        let at = |spring: f64| {
            let own = Oscillator {
                stiffness: 1.0,
                damping: 0.0,
                spring,
                limit,
                load: 1.0,
                frequency: beta,
            };
            let model = own.model();
            let found = orbit(&model, 200);
            let [largest, open] = amplitude(&own, own.state(&model, &found.start));
            assert!(open < 1e-10, "{beta} {spring}: open by {open:e}");
            largest
        };
        let (v, u) = (
            1.0 / (1.0 - beta * beta),
            (TAU / 2.0 / beta).sin() / (beta * (1.0 + (TAU / 2.0 / beta).cos())),
        );
        let exact = (v * v - (limit * u) * (limit * u)).sqrt();
        assert!((exact - amplitudes).abs() < 1e-5, "{exact} {amplitudes}");
        // From rest the force takes a time of about √(F/k) to change its sign, which delays the motion.
        let found = [1e2, 1e3, 1e4].map(at);
        let off = found.map(|found| (found - exact).abs());
        let orders = [0, 1].map(|i| (off[i] / off[i + 1]).log10());
        let limit = found[2] + (found[2] - found[1]) / (10_f64.sqrt() - 1.0);
        println!(
            "beta {beta}: off by {off:?}, orders {orders:?} in 1/k, limit off by {:.1e}",
            limit - exact
        );
        assert!(
            orders.iter().all(|order| (order - 0.5).abs() < 0.05),
            "{orders:?}"
        );
        assert!((limit - exact).abs() < 1e-4, "{limit} {exact}");
    }
}

/// Two modes and a rigid rotation with three elements, two of them on one line, under a load.
fn train() -> Model {
    let mut structure =
        ModalStructure::of_modes(&[0.0, 1.1, 2.7], 0.02, &[0.5, 0.3, 0.1], &[1.0; 3]);
    structure.harmonic_loads = vec![HarmonicLoad {
        name: "load".to_owned(),
        force: vec![0.1, 0.9, -0.6],
        turns_per_cycle: 1.0,
        phase: 0.4,
    }];
    let felt: [&[f64]; 2] = [&[0.4, 0.8, -0.5], &[0.0, 0.6, 0.9]];
    let sliders = [
        (felt[0], 1.5, 0.2),
        (felt[0], 0.9, 0.4),
        (felt[1], 2.0, 0.3),
    ];
    model(structure, 6.5, &sliders)
}

/// A random state; some of the springs are stretched beyond their limits.
fn random_start(model: &Model, stream: &mut Stream) -> TrajectoryState {
    let mut state: Vec<f64> = (0..2 * model.modes()).map(|_| stream.normal()).collect();
    for slider in &model.sliders {
        state[model.modes() + slider.block] = 0.0;
    }
    TrajectoryState::new(model, state, 3)
}

#[test]
fn kernel_reference_and_extended_precision_agree() {
    let mut events = 0;
    let mut worst = [0.0_f64; 2];
    for model in [FORCED.model(), train()] {
        let mut stream = Stream::new(5, 0, 0);
        for _ in 0..20 {
            let start = random_start(&model, &mut stream);
            let mut seen = Events::default();
            let (end, _) = advance_with(&volterra(&model), &start, 2, &mut seen);
            let exact = Extended::new(&model).advance(&start, 2).unwrap();
            let passage = Reference::new(&model).advance(&start, 2).unwrap();
            let sets = |from, to| (from, to);
            let [a, b, c]: [Vec<_>; 3] = [
                seen.0.iter().map(|e| sets(e.from, e.to)).collect(),
                passage
                    .crossings
                    .iter()
                    .map(|e| sets(e.from, e.to))
                    .collect(),
                exact.crossings.iter().map(|e| sets(e.from, e.to)).collect(),
            ];
            assert_eq!(a.len(), c.len(), "{a:?} {c:?}");
            assert_eq!(b.len(), c.len());
            events += a.len();
            for (worst, state) in worst.iter_mut().zip([&end.state, &passage.end.state]) {
                let off = exact.difference(state);
                *worst = off.iter().fold(*worst, |most, d| most.max(d.abs()));
            }
        }
    }
    println!(
        "{events} events; kernel off by {:.1e}, reference by {:.1e}",
        worst[0], worst[1]
    );
    assert!(events > 100, "{events}");
    assert!(worst[0] < 1e-10 && worst[1] < 1e-10, "{worst:?}");
}

#[test]
fn energy_balance_closes() {
    for model in [FREE.model(), FORCED.model(), train()] {
        let mut audit = EnergyAudit::new(&model);
        let start = random_start(&model, &mut Stream::new(8, 0, 0));
        let (end, counters) = advance_with(&volterra(&model), &start, 20, &mut audit);
        let residual = audit.residual(&end).unwrap();
        println!("{} events: {residual:.1e}", counters.events);
        assert!(counters.events > 8 && residual < 1e-12, "{residual:e}");
    }
}

/// Derivatives of the map of two cycles compared with differences, and one multiplier 0 for every orbit with slip.
#[test]
fn tangents_are_derivatives() {
    for model in [FORCED.model(), train()] {
        let kernel = volterra(&model);
        let norm = EnergyNorm::new(&model);
        let felt = norm.weighted_components();
        let mut stream = Stream::new(6, 0, 0);
        let mut compared = 0;
        for _ in 0..10 {
            let start = advance(&kernel, &random_start(&model, &mut stream), 1);
            let mut tangents = Tangents::zeros(model.modes(), felt.len());
            for (column, &i) in felt.iter().enumerate() {
                tangents.vector_mut(column)[i] = 1.0;
            }
            let mut end = start.clone();
            let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
            for _ in 0..2 {
                kernel
                    .advance_cycle(
                        &mut end,
                        &mut tangents,
                        &mut workspace,
                        &mut (),
                        &mut counters,
                    )
                    .unwrap();
            }
            for (column, &i) in felt.iter().enumerate() {
                let moved = |step: f64| {
                    let mut state = start.state.clone();
                    state[i] += step;
                    advance(
                        &kernel,
                        &TrajectoryState::new(&model, state, start.cycle),
                        2,
                    )
                };
                let step = 1e-6;
                let [ahead, behind] = [moved(step), moved(-step)];
                let difference: Vec<f64> = (ahead.state.iter().zip(&behind.state))
                    .map(|(a, b)| (a - b) / (2.0 * step))
                    .collect();
                let off = (tangents.vector(column).iter().zip(&difference))
                    .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                assert!(off < 1e-5, "{i}: {off:e} of {difference:?}");
                compared += 1;
            }
        }
        println!("{compared} tangents compared");
    }
    let found = orbit(&FORCED.model(), 400);
    let sizes: Vec<f64> = found.multipliers.iter().map(|m| m.norm()).collect();
    println!("multipliers {sizes:?}, residual {:.1e}", found.residual);
    assert!(
        found.events == 4 && sizes.len() == 3 && sizes[2] < 1e-12,
        "{sizes:?}"
    );
}

/// The exponents are the logarithms of the multipliers: −∞ for the orbit with slip, 0 for a slider that sticks.
#[test]
fn exponents_of_slips_are_minus_infinity() {
    let sticking = Oscillator {
        load: 0.01,
        ..FORCED
    };
    for (own, slips) in [(FORCED, true), (sticking, false)] {
        let model = own.model();
        let (kernel, norm) = (volterra(&model), EnergyNorm::new(&model));
        let mut at = advance(&kernel, &model.start(&InitialState::Rest), 400);
        let mut growth = TangentGrowth::new(&norm, model.modes(), 3, &mut Stream::new(1, 0, 0));
        let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
        for cycle in 0..500 {
            if cycle == 100 {
                growth.restart();
            }
            let tangents = growth.tangents();
            kernel
                .advance_cycle(&mut at, tangents, &mut workspace, &mut (), &mut counters)
                .unwrap();
            growth.cycle(&norm);
        }
        let found = growth.exponents().unwrap();
        println!("{found:?}");
        let sum = found[..2].iter().sum::<f64>();
        if slips {
            let orbit = orbit(&model, 400);
            let expected: f64 = orbit.multipliers[..2].iter().map(|m| m.norm().ln()).sum();
            assert!((sum - expected).abs() < 1e-9, "{found:?} {expected}");
            assert_eq!(found[2], f64::NEG_INFINITY);
        } else {
            assert!(found[0].abs() < 1e-9 && found[2] > -10.0, "{found:?}");
        }
    }
}

/// A load exceeds the limit of its slider. Drag ends the acceleration, and the motion repeats except for the position
/// of the slider.
#[test]
fn a_slip_without_end_repeats() {
    let mut structure = ModalStructure::of_modes(&[0.0, 1.1], 0.05, &[0.0, 1.0], &[0.0, 1.0]);
    structure.coupling = Some(Coupling {
        damping: vec![0.4, 0.0, 0.0, 0.0],
        gyroscopic: vec![0.0; 4],
        stiffness: vec![0.0; 4],
    });
    structure.constant_load = vec![1.0, 0.0];
    structure.harmonic_loads = vec![HarmonicLoad {
        name: "load".to_owned(),
        force: vec![0.1, 0.5],
        turns_per_cycle: 1.0,
        phase: 0.4,
    }];
    let model = model(structure, 6.5, &[(&[1.0, 0.2], 2.0, 0.3)]);
    assert_eq!(EnergyNorm::new(&model).dimension(), 4);
    let found = orbit(&model, 100);
    let end = advance(&volterra(&model), &found.start, 1);
    let slipped = end.state[0] - found.start.state[0];
    println!("residual {:.1e}, slips by {slipped}", found.residual);
    let expected = 6.5 * (1.0 - 0.3) / 0.4;
    assert!(
        (slipped / expected - 1.0).abs() < 1e-9,
        "{slipped} {expected}"
    );
    assert!(found.multipliers.iter().all(|m| m.norm() < 0.9));
}

/// A clutch with two elements behind a rattling mesh, its modes coupled by dampers and drag.
#[test]
fn a_clutch_follows_the_reference() {
    let text = include_str!("../../manifests/trains/clutch-hysteresis.toml");
    let text = text.replace("amplitude = \"120 N*m\"", "amplitude = \"800 N*m\"");
    let job = manifest::parse(&text, "clutch.toml", Path::new(".")).unwrap();
    let model = common::parts().model(&job.points.at(2)).unwrap();
    assert!(model.basis.coupled().is_some() && model.sliders.len() == 2);
    let (kernel, norm) = (volterra(&model), EnergyNorm::new(&model));
    let mut start = advance(&kernel, &model.start(&InitialState::Static), 2700);
    let (mut slips, mut rattles, mut worst) = (0, false, [0.0_f64; 2]);
    for _ in 0..12 {
        let mut seen = Events::default();
        let (end, _) = advance_with(&kernel, &start, 9, &mut seen);
        let exact = Extended::new(&model).advance(&start, 9).unwrap();
        let passage = Reference::new(&model).advance(&start, 9).unwrap();
        assert_eq!(seen.0.len(), exact.crossings.len());
        assert_eq!(passage.crossings.len(), exact.crossings.len());
        slips += seen
            .0
            .iter()
            .filter(|event| model.is_slip(event.contact))
            .count();
        rattles |= seen.0.iter().any(|event| event.contact == DRIVE_FLANK);
        for (worst, state) in worst.iter_mut().zip([&end.state, &passage.end.state]) {
            *worst = worst.max(norm.length(&exact.difference(state)) / norm.unit());
        }
        start = end;
    }
    assert!(rattles);
    println!(
        "{slips} slips; kernel off by {:.1e}, reference by {:.1e}",
        worst[0], worst[1]
    );
    assert!(slips > 10, "{slips}");
    assert!(worst[0] < 1e-10 && worst[1] < 1e-10, "{worst:?}");
}

/// A block on a spring, moved by a belt of constant speed: the force increases at a constant rate while it sticks.
#[test]
fn a_block_on_a_belt_sticks_and_slips() {
    let (speed, spring, limit) = (0.2, 4.0, 1.0);
    let [mut belt] = [ModalStructure::of_modes(
        &[0.0, 1.0],
        0.0,
        &[0.0, 1.0],
        &[1.0; 2],
    )];
    belt.contacts = StructureContact::slider("belt", &[-1.0, 1.0], spring, limit)
        .map(|part| StructureContact {
            force: vec![0.0, 1.0],
            ..part
        })
        .to_vec();
    let point = OperatingPoint {
        load: 0.0,
        speed: 1.0,
    };
    let model = Model::new(&belt, &Drive::constant(WIDE, 1.0), point).unwrap();
    let start = model.start(&InitialState::Modal {
        displacement: vec![0.0; 2],
        velocity: vec![speed; 2],
    });
    let mut seen = Events::default();
    let (end, _) = advance_with(&volterra(&model), &start, 2, &mut seen);
    // Sticking, x'' + x + k (x − v t) = 0; the force reaches −F at t₁.
    let natural = (1.0 + spring).sqrt();
    let drift = spring * speed / (1.0 + spring);
    let stuck = |t: f64| {
        let (sin, cos) = (natural * t).sin_cos();
        let swing = speed - drift;
        [drift * t + swing / natural * sin, drift + swing * cos]
    };
    let (mut left, mut right) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (left + right);
        let force = spring * (stuck(middle)[0] - speed * middle);
        if force > -limit { left = middle } else { right = middle }
    }
    let [x, v] = stuck(left);
    assert!(v < speed, "the slip begins as the block falls behind");
    // Slipping, x'' + x = F. The block swings about F more slowly than the belt, and never sticks again.
    assert!((x - limit).hypot(v) < speed);
    let times = times(&model, &seen);
    assert_eq!(times.len(), 1);
    let end_time = 2.0 * model.period();
    let (sin, cos) = (end_time - left).sin_cos();
    let at_end = limit + (x - limit) * cos + v * sin;
    let [displacement, _] = model.basis.modes(&end.state);
    let slider = end.state[model.sliders[0].block];
    let off = [
        times[0] - left,
        displacement[0] - speed * end_time,
        displacement[1] - at_end,
        slider - (at_end - speed * end_time + limit / spring),
    ];
    println!("slip at {left}, off by {off:?}");
    assert!(off.iter().all(|off| off.abs() < 1e-10), "{off:?}");
}
