//! NVH statistics compared with closed forms and with brute-force counting along a trajectory.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance_with, settled, volterra};
use common::{forty_modes, model, model_at, one_degree, six_modes, two_modes};
use gearatlas::analysis::{
    Effort, LyapunovConfig, Nvh, NvhConfig, NvhOutcome, NvhStatistics, OrderConfig, PointConfig,
    PointOutcome, Section, Signals, Spectrum, SpectrumConfig, investigate,
};
use gearatlas::model::{
    ActiveSet, Division, DriveShaft, InitialState, MeshHarmonic, Model, OperatingPoint, Quantity,
    TorqueRipple,
};
use gearatlas::numerics::exponential::legendre_series;
use gearatlas::numerics::random::{PointSeed, Stream};
use gearatlas::propagate::{ClosedModes, Event, InstructionSet, Observer, Window};
use gearatlas::structure::{BearingGain, MotionKind, OmittedModeForces, PlaceMotion, TorqueGain};
use num_complex::{Complex64, c64};
use std::f64::consts::{SQRT_2, TAU};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::channel;
use std::time::Duration;

/// A mean \[m\] and cosines: (order of the mesh frequency, amplitude \[m\], phase \[rad\]).
struct Signal(f64, Vec<(f64, f64, f64)>);

/// Passes a signal as deflection over some mesh cycles, with a force of a thousand N/m times it.
fn show(model: &Model, nvh: &mut Nvh, signal: &Signal, cycles: std::ops::Range<u64>) {
    // The windows are uneven on purpose: some are cut, some are regular.
    let places = [0.0, 0.1, 0.2, 0.3, 0.37, 0.5, 0.6, 0.7, 0.81, 0.9, 1.0];
    let period = model.period();
    for cycle in cycles {
        for ends in places.windows(2) {
            let [start, duration] = [ends[0] * period, (ends[1] - ends[0]) * period];
            let mut deflection = [0.0; 16];
            deflection[0] = signal.0;
            for (order, amplitude, phase) in &signal.1 {
                let omega = TAU * order / period;
                let mut series = [Complex64::ZERO; 16];
                legendre_series(c64(0.0, omega), duration, &mut series);
                let turned = TAU * (order * cycle as f64).fract() + omega * start + phase;
                for (a, u) in deflection.iter_mut().zip(series) {
                    *a += amplitude * (Complex64::cis(turned) * u).re;
                }
            }
            nvh.window(&Window {
                cycle,
                start,
                duration,
                deflection: &deflection,
                force: &deflection.map(|a| 1e3 * a),
                ..Window::default()
            });
        }
    }
}

#[track_caller]
fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1e-12), "{a} {b}");
}

#[test]
fn a_sine_has_its_crest_and_kurtosis() {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 4);
    let signal = Signal(2e-5, vec![(2.0, 3e-6, 0.7)]);
    show(&model, &mut nvh, &signal, 5..45);
    nvh.repeats(1);
    let found = nvh.outcome().unwrap();
    close(found.values.deflection_mean, 2e-5, 1e-13);
    close(found.values.deflection_rms, 3e-6 / SQRT_2, 1e-12);
    close(found.deflection_crest, SQRT_2, 1e-9);
    close(found.values.deflection_kurtosis, 1.5, 1e-11);
    close(found.deflection_pp, 6e-6, 1e-9);
    close(found.values.harmonics[1], 3e-6, 1e-12);
    assert!([0, 2, 3].iter().all(|&h| found.values.harmonics[h] < 1e-17));
    close(found.values.force_std, 3e-3 / SQRT_2, 1e-12);
    assert_eq!(found.values.suborders, [0.0; 5]);
    assert_eq!(found.stderr, None);
}

/// Random loads and speeds: both exact kernels have different windows, but the statistics of the rattle are the same.
#[test]
fn statistics_do_not_depend_on_the_kernel() {
    let mut stream = Stream::new(43, 0, 3);
    let mut rattling = 0;
    for modes in [two_modes(), six_modes(), forty_modes()] {
        for _ in 0..6 {
            let load = 0.03 + 0.2 * stream.uniform();
            let model = model_at(&modes, load, 600.0 + 1800.0 * stream.uniform());
            let closed = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
            let structured = volterra(&model);
            let start = settled(&model, 100);
            let mut found = [Nvh::new(&model, 10), Nvh::new(&model, 10)];
            advance_with(&structured, &start, 6, &mut found[0]);
            advance_with(&closed, &start, 6, &mut found[1]);
            let [a, b] = found.map(|nvh| nvh.outcome().unwrap());
            assert_eq!((a.impacts, a.cycles), (b.impacts, b.cycles));
            rattling += u32::from(a.impacts != [0; 2]);
            let numbers = |n: &NvhOutcome| {
                let v = &n.values;
                let deflections = [v.deflection_mean, v.deflection_rms, n.deflection_pp];
                let forces = [v.force_mean, v.force_std, n.force_peak];
                let impacts = [v.impact_velocity, n.impact_velocity_max.unwrap_or(0.0)];
                [
                    (model.half_gap, [&deflections[..], &v.harmonics].concat()),
                    (
                        n.force_peak,
                        [&forces[..], &v.force_peak_quantiles].concat(),
                    ),
                    (v.impact_velocity, impacts.to_vec()),
                    (1.0, [&v.fractions[..], &[v.deflection_kurtosis]].concat()),
                    (v.impact_rate, vec![v.impact_rate]),
                ]
            };
            for ((size, a), (_, b)) in numbers(&a).into_iter().zip(numbers(&b)) {
                assert_eq!(a.len(), b.len());
                for (a, b) in a.into_iter().zip(b) {
                    assert!((a - b).abs() <= 1e-9 * size, "{a} {b} of {size}");
                }
            }
        }
    }
    assert!(rattling > 9, "{rattling} of 18 rattle");
}

/// A wave that rises and falls over many cycles: the quantiles of its peaks are those of the cycles of one period, by a
/// count.
#[test]
fn peaks_of_a_motion_that_repeats_are_those_of_its_period() {
    let model = model(&one_degree());
    for period in [1, 2, 200_u32] {
        let slow = 1.0 / f64::from(period);
        let signal = Signal(2e-5, vec![(1.0, 4e-6, 0.3), (slow, 3e-6, 1.0)]);
        let mut nvh = Nvh::new(&model, 0);
        show(&model, &mut nvh, &signal, 7..7 + 2 * u64::from(period));
        nvh.repeats(period);
        let found = nvh.outcome().unwrap();

        let steps = 4000;
        let mut peaks: Vec<f64> = (7..7 + period)
            .map(|cycle| {
                let turned = |step: i32| f64::from(cycle) + f64::from(step) / f64::from(steps);
                let values = (0..=steps).map(|step| {
                    let turned = TAU * turned(step);
                    4e-6 * (turned + 0.3).cos() + 3e-6 * (slow * turned + 1.0).cos()
                });
                values.map(f64::abs).fold(0.0, f64::max)
            })
            .collect();
        peaks.sort_by(f64::total_cmp);
        let last = peaks.len() - 1;
        close(found.deflection_peak, peaks[last], 1e-6);
        // 198 of 200 cycles are 99 %.
        let places = [if period == 200 { 197 } else { last }, last];
        assert_eq!(found.values.deflection_peak_quantiles.len(), 2);
        for (quantile, place) in found.values.deflection_peak_quantiles.iter().zip(places) {
            close(*quantile, peaks[place], 1e-6);
        }
        assert_eq!(found.values.force_peak_quantiles[1], found.force_peak);
        assert_eq!(found.stderr, None);
    }
}

/// Amplitudes at 1/4, 1/3, 1/2, 2/3, 3/4 of a motion with a period of `period` cycles.
fn suborders(signal: &Signal, period: Option<u32>, cycles: u64) -> NvhOutcome {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 2);
    show(&model, &mut nvh, signal, 7..7 + cycles);
    if let Some(period) = period {
        nvh.repeats(period);
    }
    nvh.outcome().unwrap()
}

#[test]
fn periods_of_two_three_and_four_have_their_suborders() {
    let two = Signal(1e-6, vec![(1.0, 4e-6, 0.1), (0.5, 3e-6, 1.0)]);
    // Whole periods, but not whole windows of 24 cycles.
    let found = suborders(&two, Some(2), 30).values.suborders;
    close(found[2], 3e-6, 1e-12);
    assert_eq!(
        [found[0], found[1], found[3], found[4]].map(|a| a > 1e-18),
        [false; 4]
    );

    let three = Signal(
        1e-6,
        vec![
            (1.0, 4e-6, 0.1),
            (1.0 / 3.0, 2e-6, 0.4),
            (2.0 / 3.0, 1e-6, 2.0),
        ],
    );
    let found = suborders(&three, Some(3), 33).values.suborders;
    close(found[1], 2e-6, 1e-12);
    close(found[3], 1e-6, 1e-12);

    let four = Signal(
        0.0,
        vec![(0.25, 5e-6, 0.0), (0.5, 1e-6, 0.2), (0.75, 2e-6, 0.3)],
    );
    for (period, cycles) in [(Some(4), 28), (None, 72)] {
        let found = suborders(&four, period, cycles).values.suborders;
        for (index, exact) in [(0, 5e-6), (2, 1e-6), (4, 2e-6)] {
            close(found[index], exact, 1e-12);
        }
        assert!(found[1] < 1e-17 && found[3] < 1e-17, "{found:?}");
    }
    assert!(suborders(&four, None, 20).values.suborders.is_empty());
}

/// Durations and impacts by a second count along a rattling trajectory.
#[test]
fn impacts_and_stays_are_those_of_the_events() {
    let model = model(&forty_modes());
    let start = settled(&model, 200);
    let (mut nvh, mut events) = (Nvh::new(&model, 0), Events::default());
    advance_with(&volterra(&model), &start, 400, &mut (&mut nvh, &mut events));
    let found = nvh.outcome().unwrap();
    let events = events.0;
    let time = |e: &Event| e.cycle as f64 * model.period() + e.time;
    let entries = |to: ActiveSet| events.iter().filter(|e| e.to == to).count() as u64;
    assert_eq!(
        found.impacts,
        [entries(ActiveSet::DRIVE), entries(ActiveSet::COAST)]
    );
    assert!(found.impacts[0] > 200);

    let mut speeds: Vec<f64> = (events.iter().filter(|e| e.to.touching()))
        .map(|e| e.rate.abs())
        .collect();
    speeds.sort_by(f64::total_cmp);
    let below = |speed: f64| speeds.iter().filter(|s| **s <= speed).count() as f64;
    let shares = [0.5, 0.9, 0.99];
    for (quantile, share) in found.values.impact_velocity_quantiles.iter().zip(shares) {
        let n = speeds.len() as f64;
        assert!((below(*quantile) - share * n).abs() <= 1.5, "{share}");
    }
    assert_eq!(found.impact_velocity_max, speeds.last().copied());

    let NvhStatistics {
        flight_mean,
        flight_median,
        contact_mean,
        contact_median,
        ..
    } = found.values;
    for (touching, count, [mean, median]) in [
        (false, found.flights, [flight_mean, flight_median]),
        (true, found.contacts, [contact_mean, contact_median]),
    ] {
        let pairs = events.windows(2).filter(|p| p[0].to.touching() == touching);
        let mut lengths: Vec<f64> = pairs.map(|p| time(&p[1]) - time(&p[0])).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(count, lengths.len() as u64);
        close(
            mean.unwrap(),
            lengths.iter().sum::<f64>() / lengths.len() as f64,
            1e-9,
        );
        let middle = [(lengths.len() - 1) / 2, lengths.len() / 2].map(|i| lengths[i]);
        close(median.unwrap(), 0.5 * (middle[0] + middle[1]), 1e-9);
    }
}

/// Two flights of different length per cycle: a flight that the ends of the record cut in two counts once.
#[test]
fn stays_of_a_motion_that_repeats_are_whole() {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 0);
    let period = model.period();
    let still = Signal(0.0, Vec::new());
    for cycle in 3..13 {
        show(&model, &mut nvh, &still, cycle..cycle + 1);
        let changes = [
            (0.1, ActiveSet::DRIVE),
            (0.3, ActiveSet::FREE),
            (0.4, ActiveSet::COAST),
            (0.7, ActiveSet::FREE),
        ];
        let mut from = ActiveSet::FREE;
        for (place, to) in changes {
            nvh.event(&Event {
                cycle,
                time: place * period,
                from,
                to,
                contact: usize::from(place > 0.35),
                rate: place,
            });
            from = to;
        }
    }
    nvh.repeats(1);
    let found = nvh.outcome().unwrap();
    assert_eq!([found.flights, found.contacts], [20, 20]);
    close(found.values.flight_mean.unwrap(), 0.25 * period, 1e-12);
    close(found.values.contact_mean.unwrap(), 0.25 * period, 1e-12);
    assert_eq!(found.impacts, [10, 10]);
    assert_eq!(found.impact_velocity_max, Some(0.4));
}

/// Sines with a new random amplitude every ten cycles: means over ten cycles are independent samples, so that standard
/// errors have closed forms.
#[test]
fn standard_errors_are_those_of_independent_draws() {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 1);
    let mut stream = Stream::new(5, 6, 7);
    let blocks = 1024u64;
    for block in 0..blocks {
        let amplitude = 1e-6 * (3.0 + stream.normal());
        let mean = 1e-7 * stream.normal();
        let signal = Signal(mean, vec![(1.0, amplitude, 0.3)]);
        show(&model, &mut nvh, &signal, 10 * block..10 * (block + 1));
    }
    let errors = nvh.outcome().unwrap().stderr.unwrap();
    let root = (blocks as f64).sqrt();
    // σ(a) = 1 µm, σ(a²) = √(4·9 + 2) µm²; the mean of squares a²/2 is 5 µm².
    let exact = [
        (errors.deflection_mean, 1e-7),
        (errors.harmonics[0], 1e-6),
        (
            errors.deflection_rms,
            38f64.sqrt() / 2.0 * 1e-12 / (2.0 * 5f64.sqrt() * 1e-6),
        ),
        (errors.force_mean, 1e-4),
    ];
    for (found, one) in exact {
        let ratio = found / (one / root);
        assert!((0.8..1.45).contains(&ratio), "{ratio}");
    }
    let flights = [errors.flight_mean, errors.flight_median];
    assert_eq!(flights, [Some(f64::INFINITY); 2]);
}

/// Requests for a model, including spectra.
fn questions(harmonics: usize) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 3,
            point_id: 0,
        },
        transient: 300,
        cycles: 1000,
        settle: true,
        audit_cycles: 20,
        lyapunov: Some(LyapunovConfig {
            align: 50,
            twin: false,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: Some(NvhConfig {
            harmonics,
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

/// Results of a model, including spectra.
fn ask(model: &Model, harmonics: usize) -> PointOutcome {
    let questions = questions(harmonics);
    let start = model.start(&InitialState::Static);
    let never = AtomicBool::new(false);
    investigate(model, &volterra(model), start, &questions, &never).unwrap()
}

/// The amplitude of the line at an order, which must exist.
#[track_caller]
fn line(spectrum: &Spectrum, order: f64) -> f64 {
    let mut lines = spectrum.lines.iter();
    let found = lines.find(|line| (line.order - order).abs() < 1e-12);
    found.expect("a line at the order").amplitude
}

/// Torque ripple of the second shaft order on 23 teeth, in permanent contact: the response of the closed oscillator is
/// known, and its order 2/23 is not a multiple of 1/64.
#[test]
fn a_line_of_a_shaft_order_has_its_exact_amplitude() {
    let (mut structure, mut drive, _) = one_degree();
    structure.teeth = 23;
    structure.pinion_torque = Some(vec![26.0]);
    drive.mesh = Division::levels(&[4e8], &[]);
    drive.transmission_error = vec![MeshHarmonic::new(1, 1e-7, 0.0)];
    drive.torque_ripple = vec![TorqueRipple {
        shaft: DriveShaft::Pinion,
        order: 2.0,
        amplitude: 8.0,
        phase: 0.4,
    }];
    let point = OperatingPoint {
        load: 1.0,
        speed: 900.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let found = ask(&model, 4);
    let kind = found.class.map(|class| class.name());
    assert_eq!(kind, Some("steady_contact"), "{}", found.reason);

    let (w, torque, k, c) = (1.3, 26.0 * 8.0, 4e8, drive.damping);
    let omega = 2.0 * point.speed;
    let dynamic = f64::hypot(k * w * w - omega * omega, c * w * w * omega);
    let deflection = w * torque / dynamic;
    let force = deflection * f64::hypot(k, c * omega);
    let order = 2.0 / 23.0;
    close(line(&found.spectra[0], order), deflection, 1e-11);
    close(line(&found.spectra[1], order), force, 1e-11);
    // The neighbours of the line are zero, and mesh order 1 is that of the error.
    for (spectrum, largest) in found.spectra.iter().zip([deflection, force]) {
        assert_eq!(spectrum.lines.len(), 32 * 23);
        for other in [1.0, 3.0, 4.0, 22.0, 24.0] {
            assert!(line(spectrum, other / 23.0) < 1e-11 * largest);
        }
    }
    let omega = 23.0 * point.speed;
    let dynamic = f64::hypot(k * w * w - omega * omega, c * w * w * omega);
    let response = 1e-7 * omega * omega / dynamic;
    close(line(&found.spectra[0], 1.0), response, 1e-9);
    close(found.nvh.unwrap().values.harmonics[0], response, 1e-9);
}

/// For periodic rattle the lines are those of the statistics, and contain all of its variance.
#[test]
fn lines_of_rattle_are_its_harmonics_and_suborders() {
    for (load, speed, period) in [(0.3, 600.0, 1), (0.2, 1800.0, 2), (2.0, 1500.0, 3)] {
        let model = model_at(&one_degree(), load, speed);
        let found = ask(&model, 8);
        let repeats = found.class.and_then(|class| class.period());
        assert_eq!(repeats, Some(period), "{}", found.reason);
        let nvh = found.nvh.unwrap();
        let spectrum = &found.spectra[0];
        assert_eq!(spectrum.lines.len(), 32 * period as usize);
        for (h, amplitude) in (1..).zip(&nvh.values.harmonics) {
            let error = (line(spectrum, f64::from(h)) - amplitude).abs();
            assert!(
                error < 1e-13 * nvh.values.deflection_rms,
                "{period}: {h}: {error:e}"
            );
        }
        for (order, amplitude) in [0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 0.75]
            .into_iter()
            .zip(&nvh.values.suborders)
            .filter(|(_, amplitude)| **amplitude > 0.0)
        {
            let error = (line(spectrum, order) - amplitude).abs();
            assert!(
                error < 1e-13 * nvh.values.deflection_rms,
                "{period}: {order}: {error:e}"
            );
        }
        let power: f64 = spectrum
            .lines
            .iter()
            .map(|l| 0.5 * l.amplitude.powi(2))
            .sum();
        close(power.sqrt(), nvh.values.deflection_rms, 1e-6);
    }
}

/// A thousand orders of rattle, whose windows are cut at events: the first are the same as with fewer orders. A rule
/// with enough nodes for the last one in every window would take hours here.
#[test]
fn a_thousand_harmonics_take_no_quadrature() {
    let (done, waiting) = channel();
    std::thread::spawn(move || {
        let model = model(&forty_modes());
        let start = settled(&model, 40);
        let kernel = volterra(&model);
        let found = [12, 32, 40, 1000].map(|harmonics| {
            let mut nvh = Nvh::new(&model, harmonics);
            let (_, counters) = advance_with(&kernel, &start, 120, &mut nvh);
            assert!(counters.events > 100);
            nvh.outcome().unwrap().values
        });
        let _ = done.send(found);
    });
    let [twelve, most_at_nodes, more, thousand] = (waiting.recv_timeout(Duration::from_secs(120)))
        .expect("work that grows with the harmonics, not with their square");
    assert_eq!(thousand.harmonics.len(), 1000);
    let largest = thousand.harmonics.iter().copied().fold(0.0, f64::max);
    for few in [&twelve, &most_at_nodes, &more] {
        for (a, b) in few.harmonics.iter().zip(&thousand.harmonics) {
            assert!((a - b).abs() < 1e-13 * largest, "{a} {b}");
        }
        for (a, b) in few.suborders.iter().zip(&thousand.suborders) {
            assert!((a - b).abs() < 1e-13 * largest, "{a} {b}");
        }
    }
    // Because δ'' jumps at events, amplitudes fall no faster than with the third power of the order.
    assert!(thousand.harmonics[999] > 1e-12 * largest);
}

/// All outputs of the structure at five mesh orders and three of each shaft.
const ALL_ORDERS: OrderConfig = OrderConfig {
    signals: Signals {
        deflection: true,
        force: true,
        bearings: true,
        torques: true,
        accelerations: true,
        meshes: false,
        rotations: true,
    },
    mesh: 5,
    shafts: 3,
};

/// Results of a model, including orders.
fn ask_orders(model: &Model, cycles: u64) -> PointOutcome {
    let mut questions = questions(5);
    questions.cycles = cycles;
    if let Some(nvh) = &mut questions.nvh {
        nvh.orders = Some(ALL_ORDERS);
    }
    let start = model.start(&InitialState::Static);
    let never = AtomicBool::new(false);
    investigate(model, &volterra(model), start, &questions, &never).unwrap()
}

/// A signal's amplitude and phase as a complex number, for an order of a reference.
fn order(found: &PointOutcome, signal: &str, reference: &str, multiple: u32) -> Complex64 {
    let own = found.orders.iter().find(|own| own.signal == signal);
    let mut lines = own.expect(signal).lines.iter();
    let line = lines.find(|line| line.reference == reference && line.multiple == multiple);
    let line = line.expect("a line at the order");
    Complex64::from_polar(line.amplitude, line.phase.unwrap_or(0.0))
}

/// The oscillator of the test of lines in closed form, `q̂ = T/(k w² − Ω² + iΩc w²)` under the torque and
/// `q̂ = w (k + iΩc) ê/(…)` under the error: a bearing force of it, a torque, an acceleration, with amplitude and
/// phase.
#[test]
fn orders_of_a_linear_oscillator_are_its_response() {
    let (mut structure, mut drive, _) = one_degree();
    structure.teeth = 23;
    structure.wheel_teeth = Some(31);
    structure.pinion_torque = Some(vec![26.0]);
    structure.bearings = vec![BearingGain {
        name: "somewhere x".into(),
        gain: vec![3e7],
        rate_gain: vec![2e3],
        left_out: OmittedModeForces::default(),
    }];
    structure.torques = vec![TorqueGain {
        name: "shaft".into(),
        gain: vec![-4e5],
        rate_gain: Vec::new(),
    }];
    structure.motions = vec![
        PlaceMotion {
            name: "somewhere x".into(),
            kind: MotionKind::Place,
            gain: vec![0.7],
        },
        PlaceMotion {
            name: "body".into(),
            kind: MotionKind::Body,
            gain: vec![-20.0],
        },
    ];
    drive.mesh = Division::levels(&[4e8], &[]);
    drive.transmission_error = vec![MeshHarmonic::new(1, 1e-7, -0.6)];
    drive.torque_ripple = vec![TorqueRipple {
        shaft: DriveShaft::Pinion,
        order: 2.0,
        amplitude: 8.0,
        phase: 0.4,
    }];
    let point = OperatingPoint {
        load: 1.0,
        speed: 900.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let found = ask_orders(&model, 1000);
    assert_eq!(
        found.class.map(|class| class.name()),
        Some("steady_contact")
    );

    let (w, k, c) = (1.3, 4e8, drive.damping);
    let response =
        |omega: f64, force: Complex64| force / c64(k * w * w - omega * omega, omega * c * w * w);
    let ripple = response(2.0 * point.speed, Complex64::from_polar(26.0 * 8.0, 0.4));
    let omega = 23.0 * point.speed;
    let error = Complex64::from_polar(1e-7, -0.6);
    let meshing = response(omega, w * c64(k, omega * c) * error);
    for (reference, multiple, omega, q, e) in [
        ("pinion", 2, 2.0 * point.speed, ripple, Complex64::ZERO),
        ("mesh", 1, omega, meshing, error),
    ] {
        let deflection = w * q - e;
        let rate = c64(0.0, omega);
        let exact = [
            ("deflection", deflection),
            ("force", c64(k, omega * c) * deflection),
            ("bearing somewhere x", (3e7 + 2e3 * rate) * q),
            ("torque shaft", -4e5 * q),
            ("acceleration somewhere x", 0.7 * rate * rate * q),
            ("angular acceleration body", -20.0 * rate * rate * q),
        ];
        for (signal, exact) in exact {
            let difference = (order(&found, signal, reference, multiple) - exact).norm();
            assert!(
                difference < 1e-9 * exact.norm(),
                "{signal}: {difference:e} of {exact}"
            );
        }
    }
    // All other orders are zero: the wheel's and further ones of the pinion.
    for own in &found.orders {
        let largest = own
            .lines
            .iter()
            .map(|line| line.amplitude)
            .fold(0.0, f64::max);
        for line in &own.lines {
            let driven = matches!(
                (line.reference.as_str(), line.multiple),
                ("pinion", 2) | ("mesh", 1)
            );
            assert!(
                driven || line.amplitude < 1e-9 * largest,
                "{} {line:?}",
                own.signal
            );
            assert_eq!((line.stderr, line.phase_stderr), (None, None));
        }
        assert_eq!(own.lines.len(), 5 + 3 + 3);
    }
    let nvh = found.nvh.unwrap();
    let rms = [ripple * 4.0 * point.speed.powi(2), meshing * omega * omega];
    let square: f64 = rms.iter().map(|a| 0.5 * (0.7 * a.norm()).powi(2)).sum();
    close(nvh.values.acceleration_rms[0], square.sqrt(), 1e-9);
    close(
        nvh.values.torque_mean[0],
        -4e5 / w * nvh.values.deflection_mean,
        1e-9,
    );
}

/// Rattle of the default drive with forty modes that repeats every cycle, compared with steps of fourth order on the
/// vector field alone, thirty thousand per cycle, and a discrete Fourier transform of the steps. Events fall between
/// steps, an error of second order.
#[test]
fn orders_of_rattle_are_those_of_fine_steps() {
    let manifest = include_str!("../../manifests/flex80.toml");
    let manifest = manifest
        .replacen("[mesh]", "[mesh]\ncoast_flank = \"same_line\"\n#", 1)
        .replacen("friction = 0.05", "friction = 0", 1);
    let job = gearatlas::manifest::parse(&manifest, "m.toml", std::path::Path::new("")).unwrap();
    let mut point = job.points.at(0);
    (point.load, point.speed) = (0.1, 600.0);
    let model = common::parts().model(&point).unwrap();
    let found = ask_orders(&model, 400);
    assert_eq!(
        found.class,
        Some(gearatlas::analysis::Class::Periodic(1)),
        "{}",
        found.reason
    );

    // 5 N m go in and 7.5 N m come out, except for the share of the omitted modes.
    let torques = &found.nvh.as_ref().unwrap().values.torque_mean;
    assert_eq!(torques.len(), 2);
    for (found, exact) in torques.iter().zip([5.0, 7.5]) {
        assert!((found / exact - 1.0).abs() < 0.02, "{found} of {exact}");
    }

    let start = settled(&model, 6000);
    let n = model.modes();
    let steps = 30_000;
    let h = model.period() / f64::from(steps);
    let field = |time: f64, state: &[f64]| {
        let segments = model.segments_at(0, time.min(model.period()));
        let active = model.active_set(&segments, 0, state, time);
        let mut out = vec![0.0; 2 * n];
        model.derivative(&segments, active, 0, time, state, &mut out);
        out
    };
    // All forty modes are retained; only bearing forces have a share of omitted ones, which other tests check.
    let outputs: Vec<_> = model.outputs.iter().collect();
    let mut sums = vec![[Complex64::ZERO; 5]; outputs.len()];
    let mut state = start.state.clone();
    for step in 0..steps {
        let time = f64::from(step) * h;
        let slope = field(time, &state);
        for (output, sums) in outputs.iter().zip(&mut sums) {
            let seen = if output.quantity.is_rate() { &slope } else { &state };
            let value: f64 = (output.gain.iter().enumerate())
                .map(|(i, gain)| gain[0] * seen[i] + gain[1] * seen[n + i])
                .sum();
            for (multiple, sum) in (1..).zip(sums) {
                let turned = TAU * f64::from(multiple * step) / f64::from(steps);
                *sum += 2.0 / f64::from(steps) * value * Complex64::cis(-turned);
            }
        }
        let moved = |slope: &[f64], h: f64| -> Vec<f64> {
            state.iter().zip(slope).map(|(x, s)| x + h * s).collect()
        };
        let second = field(time + 0.5 * h, &moved(&slope, 0.5 * h));
        let third = field(time + 0.5 * h, &moved(&second, 0.5 * h));
        let fourth = field(time + h, &moved(&third, h));
        for i in 0..2 * n {
            state[i] += h / 6.0 * (slope[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]);
        }
    }
    let mut quantities = Vec::new();
    for (output, sums) in outputs.iter().zip(&sums) {
        let largest = sums.iter().map(|c| c.norm()).fold(0.0, f64::max);
        if largest < 1e-9 {
            continue;
        }
        quantities.push(output.quantity);
        for (multiple, exact) in (1..).zip(sums) {
            let value = order(
                &found,
                &format!("{} {}", output.quantity.name(), output.name),
                "mesh",
                multiple,
            );
            let error = (value - exact).norm() / largest;
            assert!(error < 1e-4, "{} {multiple}: {error:e}", output.name);
        }
    }
    quantities.dedup();
    assert_eq!(
        quantities,
        [
            Quantity::Torque,
            Quantity::Acceleration,
            Quantity::AngularAcceleration,
            Quantity::Rotation
        ]
    );
}

/// In chaos the mesh orders of the deflection are those of the statistics, with their error bars; orders of a shaft
/// without excitation are zero within theirs.
#[test]
fn orders_of_chaos_have_error_bars() {
    let (mut structure, drive, point) = forty_modes();
    structure.teeth = 23;
    let model = Model::new(&structure, &drive, point).unwrap();
    let found = ask_orders(&model, 2300);
    assert_eq!(found.class.map(|class| class.name()), Some("chaotic"));
    let nvh = found.nvh.as_ref().unwrap();
    let errors = nvh.stderr.as_ref().unwrap();
    let own = found
        .orders
        .iter()
        .find(|own| own.signal == "deflection")
        .unwrap();
    for (h, line) in own.lines[..5].iter().enumerate() {
        close(line.amplitude, nvh.values.harmonics[h], 1e-9);
        close(line.stderr.unwrap(), errors.harmonics[h], 1e-9);
        let phase = line.phase_stderr.unwrap() * line.amplitude / line.stderr.unwrap();
        assert!((0.1..10.0).contains(&phase), "{phase}");
    }
    let shafts = &own.lines[5..];
    assert!(!shafts.is_empty());
    for line in shafts {
        let error = line
            .stderr
            .unwrap()
            .hypot(line.phase_stderr.unwrap() * line.amplitude);
        assert!(line.amplitude < 4.0 * error, "{line:?}");
        assert!(
            line.amplitude < 0.05 * nvh.values.deflection_rms,
            "{line:?}"
        );
    }
}
