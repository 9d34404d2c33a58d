//! Power of the vibration: closed forms, every term compared with an independent integrator, and sums that balance.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance_with, settled, volterra};
use gearatlas::analysis::{
    Effort, LyapunovConfig, NvhConfig, PointConfig, Power, PowerOutcome, Section, Signals,
    investigate,
};
use gearatlas::manifest;
use gearatlas::model::{
    CoastFlank, Division, Drive, DriveShaft, FlankError, InitialState, MeshHarmonic, Model,
    OperatingPoint, Release, Segment, Stiffness, TorqueRipple, TrajectoryState,
};
use gearatlas::numerics::random::PointSeed;
use gearatlas::reference::{Moment, Reference};
use gearatlas::structure::{ContactLaw, Coupling, HarmonicLoad, ModalStructure, StructureContact};
use gearatlas::verify::drives::disturbed;
use num_complex::{Complex64, c64};
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Powers in the order of their columns, and the residual of the balance.
fn terms(power: &PowerOutcome) -> ([f64; 7], f64) {
    let p = power;
    let all = [
        p.loads,
        p.error,
        p.stiffness,
        p.contact,
        p.structure,
        p.friction,
        p.stored,
    ];
    (
        all,
        all[..3].iter().sum::<f64>() - all[3..].iter().sum::<f64>(),
    )
}

/// A lower bound of the input power.
fn throughput(power: &PowerOutcome) -> f64 {
    terms(power).0[..6].iter().map(|p| p.abs()).sum::<f64>() / 2.0
}

/// Adds cycles to a record.
fn gather(
    model: &Model,
    start: &TrajectoryState,
    cycles: u64,
    power: &mut Power,
) -> TrajectoryState {
    let kernel = volterra(model);
    let mut at = start.clone();
    for _ in 0..cycles {
        at = advance_with(&kernel, &at, 1, power).0;
        power.cycle(&at);
    }
    at
}

fn record(model: &Model, start: &TrajectoryState, cycles: u64) -> Power {
    let mut power = Power::new(model);
    gather(model, start, cycles, &mut power);
    power
}

fn mean(power: &Power) -> PowerOutcome {
    power.outcome().unwrap()[0]
}

fn questions(power: bool, cycles: u64) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 3,
            point_id: 1,
        },
        transient: 1000,
        cycles,
        settle: true,
        audit_cycles: 20,
        lyapunov: Some(LyapunovConfig {
            align: 20,
            twin: false,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: Some(NvhConfig {
            harmonics: 0,
            outputs: Signals::NONE,
            power,
            spectrum: None,
            orders: None,
            stop_at_stderr: None,
        }),
    }
}

/// One mode in steady contact under a transmission error and a torque at the mesh frequency: `s Q = f − g F`,
/// `s = Ω² − ω² + 2iζΩω`, `F = (k + iωc)(w Q − E)`. The input of the error and the torque equals the loss in damper,
/// mode and friction, each from its complex amplitudes.
#[test]
fn one_mode_in_steady_contact_has_its_closed_form() {
    let (natural, ratio, w, k, c) = (6000.0, 0.03, 1.3, 4e8, 1483.0);
    let (error, torque) = (2e-7, 0.7);
    for (friction, shaken) in [(0.0, 0.0), (0.0, 1.0), (0.06, 1.0)] {
        let mut structure = common::structure(&[natural], ratio, &[w], &[w]);
        structure.pinion_torque = Some(vec![11.0]);
        structure.friction = vec![2.0];
        let mut drive = common::constant_mesh(10e-6, k);
        (drive.damping, drive.friction) = (c, friction);
        drive.transmission_error = vec![MeshHarmonic::new(1, error, 0.4)];
        drive.torque_ripple = vec![TorqueRipple {
            shaft: DriveShaft::Pinion,
            order: 20.0,
            amplitude: shaken * torque,
            phase: 1.1,
        }];
        let (load, speed) = (0.6, 1200.0);
        let model = Model::new(&structure, &drive, OperatingPoint { load, speed }).unwrap();
        let g = model.first_gains()[0].mesh_input[1];
        assert_eq!(g != w, friction > 0.0);

        let omega = TAU / model.period();
        let s = c64(
            natural * natural - omega * omega,
            2.0 * ratio * natural * omega,
        );
        let f = 11.0 * shaken * torque * Complex64::cis(1.1);
        let e = error * Complex64::cis(0.4);
        let z = c64(k, omega * c);
        let q = (f + g * z * e) / (s + g * w * z);
        let [deflection, force] = [w * q - e, z * (w * q - e)];
        // Mean product of a quantity with amplitude a and the rate of one with amplitude b.
        let times_rate = |a: Complex64, b: Complex64| 0.5 * (a * (c64(0.0, omega) * b).conj()).re;
        let exact = PowerOutcome {
            loads: times_rate(f, q),
            error: -times_rate(force, e),
            stiffness: 0.0,
            contact: 0.5 * c * (omega * deflection.norm()).powi(2),
            structure: ratio * natural * (omega * q.norm()).powi(2),
            friction: (g - w) * times_rate(force, q),
            stored: 0.0,
        };

        let start = model.start(&InitialState::Static);
        let asked = questions(true, 2000);
        let never = AtomicBool::new(false);
        let found = investigate(&model, &volterra(&model), start, &asked, &never).unwrap();
        assert_eq!(found.class.unwrap().name(), "steady_contact");
        let nvh = found.nvh.unwrap();
        assert!(nvh.stderr.is_none());
        let (found, miss) = terms(&nvh.values.power.unwrap());
        let (exact, _) = terms(&exact);
        let scale = throughput(&nvh.values.power.unwrap());
        println!(
            "friction {friction}: {found:?}\n{exact:?}, misses {:.1e}",
            miss / scale
        );
        assert!(
            exact[1] > 0.1 && exact[3] > 0.1 && exact[4] > 0.01,
            "{exact:?}"
        );
        for (own, exact) in found.iter().zip(exact) {
            assert!((own - exact).abs() < 1e-11 * scale, "{own} {exact}");
        }
        assert!(miss.abs() < 1e-12 * scale, "{miss:e}");
    }
}

/// A pair with both flanks on separate lines, error, stiffness that jumps and varies, flanks with an error under load,
/// friction, ripple, contact and modal damping.
fn pair(release: Release) -> Model {
    let (mut structure, mut drive, point) = common::six_modes();
    structure.coast = Some(common::coast_line(&structure));
    drive.release = release;
    let mut bent = [0.0; 8];
    (bent[0], bent[1], bent[2]) = (4e-7, 3e-7, -1e-7);
    let mut stiffness = [0.0; 8];
    (stiffness[0], stiffness[1], stiffness[2]) = (3.4e8, 3e7, -2e7);
    drive.mesh[1].error = FlankError::series(bent);
    drive.mesh[1].stiffness = Stiffness::series(stiffness);
    drive.coast = Some(CoastFlank {
        mesh: Division::mirrored(&drive.mesh, 0.17),
        transmission_error: vec![
            MeshHarmonic::new(1, 4e-6, 0.4),
            MeshHarmonic::new(2, 1e-6, 0.0),
        ],
        further: Vec::new(),
    });
    Model::new(&structure, &drive, point).unwrap()
}

/// The pair with modes coupled by dampers, gyroscopic terms and cross-coupled springs.
fn coupled() -> Model {
    let (mut structure, drive, point) = common::six_modes();
    let matrix = |entries: &[(usize, usize, f64)]| {
        let mut out = vec![0.0; 36];
        for &(i, j, value) in entries {
            out[i * 6 + j] += value;
        }
        out
    };
    structure.coupling = Some(Coupling {
        damping: matrix(&[(2, 2, 40.0), (3, 3, 60.0), (2, 3, -15.0), (3, 2, -15.0)]),
        gyroscopic: matrix(&[(2, 3, 0.3), (3, 2, -0.3)]),
        stiffness: matrix(&[(2, 3, 1e6), (3, 2, -5e5)]),
    });
    Model::new(&structure, &drive, point).unwrap()
}

fn of_manifest(name: &str, edits: &[(&str, &str)], point: usize) -> Model {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("manifests")
        .join(name);
    let mut text = std::fs::read_to_string(file).unwrap();
    for (from, to) in edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap_or_else(|e| panic!("{e}"));
    common::parts().model(&job.points.at(point)).unwrap()
}

fn train() -> Model {
    of_manifest("trains/two-stage.toml", &[("modes = 30", "modes = 10")], 3)
}

/// A state in rattle; for a train, a few half gaps from its static state.
fn rattling(model: &Model) -> TrajectoryState {
    if model.contacts.len() == 2 {
        return settled(model, 60);
    }
    disturbed(model)
}

/// Cases with the terms that must not vanish.
fn cases() -> Vec<(&'static str, Model, [bool; 6])> {
    let all = [true; 6];
    vec![
        ("pair", pair(Release::Deflection), all),
        ("pair, by force", pair(Release::Force), all),
        ("coupled", coupled(), all),
        ("train", train(), [true, true, true, true, true, false]),
    ]
}

/// Input equals output plus stored energy for any motion, and every term is present.
#[test]
fn the_balance_closes_to_round_off() {
    for (name, model, present) in cases() {
        let start = rattling(&model);
        let power = mean(&record(&model, &start, 200));
        let (all, miss) = terms(&power);
        let scale = throughput(&power);
        println!(
            "{name}: {all:.4?} W, misses {:.1e} of {scale:.3} W",
            miss / scale
        );
        assert!(miss.abs() < 1e-12 * scale, "{name}: {miss:e} of {scale}");
        for (own, present) in all.iter().zip(present) {
            assert!(!present || own.abs() > 1e-6 * scale, "{name}: {all:?}");
        }
        assert!(
            power.contact > 0.0 && power.structure > 0.0,
            "{name}: {all:?}"
        );
    }
}

/// Stiffness and stretch of each closed contact.
type Springs = Vec<Option<[f64; 2]>>;

/// The powers of a model's terms, from its parts alone, summed over the moments of another integrator.
struct Sampled<'m> {
    model: &'m Model,
    /// Work of each cause in the order of columns \[J\], with the increase of stored energy last; and the time \[s\].
    work: [f64; 7],
    time: f64,
    /// Stored energy at the start \[J\].
    start: Option<f64>,
    /// Whether the present moment is inside a smooth piece.
    inside: bool,
    /// Segments and springs at the end of the last smooth piece.
    last: Option<(Vec<Segment>, Springs)>,
}

impl<'m> Sampled<'m> {
    fn new(model: &'m Model) -> Self {
        Self {
            model,
            work: [0.0; 7],
            time: 0.0,
            start: None,
            inside: false,
            last: None,
        }
    }

    /// Stiffness and compression of the closed contacts' springs.
    fn springs(&self, at: &Moment<'_>) -> Vec<Option<[f64; 2]>> {
        let model = self.model;
        let own = model.contacts.iter().zip(at.segments).enumerate();
        own.map(|(number, (contact, segment))| {
            let (deflection, _) = model.deflection_on(segment, at.cycle, at.state, at.time);
            let [gap, _] = contact.gap(segment, at.time);
            let stiffness = segment.stiffness_at(at.time / model.period());
            (at.contact.holds(number)).then_some([stiffness, deflection - contact.side * gap])
        })
        .collect()
    }

    fn stored(&self, at: &Moment<'_>) -> f64 {
        let n = self.model.modes();
        let blocks = self.model.blocks.iter().enumerate();
        let structure: f64 = blocks
            .filter(|(i, _)| !self.model.neutral.contains(i))
            .map(|(i, block)| {
                let turned = block.natural_frequency() * at.state[i];
                0.5 * (turned * turned + at.state[n + i] * at.state[n + i])
            })
            .sum();
        let springs = self.springs(at).into_iter().flatten();
        structure + springs.map(|[k, s]| 0.5 * k * s * s).sum::<f64>()
    }

    fn take(&mut self, at: Moment<'_>) {
        if at.weight == 0.0 {
            return self.edge(&at);
        }
        let (model, n) = (self.model, self.model.modes());
        self.time += at.weight;
        let mut rate = [0.0; 6];
        let velocity = |i: usize| {
            if model.neutral.contains(&i) { 0.0 } else { at.state[n + i] }
        };
        for (i, block) in model.blocks.iter().enumerate() {
            let shaken = model
                .ripple
                .iter()
                .map(|ripple| ripple.input[i][1] * ripple.phase_at(at.cycle, at.time).cos());
            rate[0] += (block.static_input[1] + shaken.sum::<f64>()) * velocity(i);
            // q'' + 2ζω q' + …: the generator's damping is −2ζω.
            rate[4] -= block.generator[1][1] * velocity(i).powi(2);
        }
        for number in at.contact.iter() {
            let (contact, segment) = (&model.contacts[number], &at.segments[number]);
            let (deflection, speed) = model.deflection_on(segment, at.cycle, at.state, at.time);
            let force = contact.force(segment, at.time, deflection, speed);
            let [gap, opening] = contact.gap(segment, at.time);
            let line = &model.lines[model.line(segment)];
            let (_, error_rate) = line.transmission_error_at(at.cycle, at.time);
            rate[1] -= force * (error_rate + contact.side * opening);
            // Fourth-order difference: exact enough for a polynomial of a few terms.
            let k = |step: f64| segment.stiffness_at(at.time / model.period() + step);
            let h = 1e-3 * (segment.end - segment.start);
            let slope = (8.0 * (k(h) - k(-h)) - (k(2.0 * h) - k(-2.0 * h))) / (12.0 * h);
            let stretch = deflection - contact.side * gap;
            rate[2] += 0.5 * slope / model.period() * stretch * stretch;
            rate[3] += segment.damping * (speed - contact.side * opening).powi(2);
            let gains = model.gains(segment).iter().enumerate();
            rate[5] += force
                * gains
                    .map(|(i, gain)| (gain.mesh_input[1] - gain.deflection[0]) * velocity(i))
                    .sum::<f64>();
        }
        for (work, rate) in self.work.iter_mut().zip(rate) {
            *work += at.weight * rate;
        }
    }

    /// Start or end of a smooth piece.
    fn edge(&mut self, at: &Moment<'_>) {
        let springs = self.springs(at);
        let energy = |spring: Option<[f64; 2]>| spring.map_or(0.0, |[k, s]| 0.5 * k * s * s);
        let stored = self.stored(at);
        let start = *self.start.get_or_insert(stored);
        self.work[6] = stored - start;
        self.inside = !self.inside;
        if !self.inside {
            self.last = Some((at.segments.to_vec(), springs));
            return;
        }
        if let Some((segments, before)) = self.last.take() {
            let pairs = before.iter().zip(&springs).enumerate();
            for (number, (&before, &after)) in pairs {
                let gained = energy(after) - energy(before);
                match (before, after) {
                    // Take the mean of two orders: first the stiffness changes, then the length, and the reverse.
                    (Some([k, s]), Some([stepped, stretched])) => {
                        let one = 0.5 * (stepped - k) * s * s;
                        let other = 0.5 * (stepped - k) * stretched * stretched;
                        let stiffness = 0.5 * (one + other);
                        self.work[2] += stiffness;
                        self.work[1] += gained - stiffness;
                    }
                    (None, None) => {}
                    _ if self.model.contacts[number].release == Release::Force => {
                        self.work[3] -= gained;
                    }
                    _ if segments[number] != at.segments[number] => self.work[1] += gained,
                    // At an event the spring has no stretch.
                    _ => assert!(gained.abs() < 1e-12 * stored, "{gained:e} J"),
                }
            }
        }
    }
}

/// Every term is that of the independent integrator, moment by moment from the model's parts, including steps of
/// stiffness and length between them; it uses no windows and no series.
#[test]
fn every_term_is_that_of_the_reference() {
    let table = of_manifest(
        "flex80-table.toml",
        &[
            ("stiffness = \"table\" ", "stiffness = \"continuous\" "),
            ("segments = 60", "#"),
            ("retained = 40", "retained = 12"),
        ],
        6,
    );
    let cases = [
        ("pair", pair(Release::Deflection)),
        ("pair, by force", pair(Release::Force)),
        ("table", table),
        ("train", train()),
    ];
    for (name, model) in cases {
        assert!(model.basis.coupled().is_none(), "{name}");
        let start = rattling(&model);
        let cycles = 4;
        let power = mean(&record(&model, &start, cycles));
        let mut sampled = Sampled::new(&model);
        let passage = Reference::new(&model)
            .advance_watched(&start, cycles, &mut |moment| sampled.take(moment))
            .unwrap();
        let (found, _) = terms(&power);
        let scale = throughput(&power);
        let exact = sampled.work.map(|work| work / sampled.time);
        println!(
            "{name}, {} crossings: {found:.5?}\n{exact:.5?}",
            passage.crossings.len()
        );
        assert!(!passage.crossings.is_empty(), "{name} does not rattle");
        for (own, exact) in found.iter().zip(exact) {
            let off = (own - exact).abs() / scale;
            assert!(off < 1e-9, "{name}: {own} {exact}, {off:e} of {scale}");
        }
    }
}

/// A periodic motion stores nothing over its period, including jumps at its start.
#[test]
fn a_motion_that_repeats_stores_nothing() {
    let model = common::model_at(&common::one_degree(), 1.0, 700.0);
    let never = AtomicBool::new(false);
    let start = model.start(&InitialState::Static);
    let asked = questions(true, 2000);
    let found = investigate(&model, &volterra(&model), start, &asked, &never).unwrap();
    assert!(found.class.unwrap().period().is_some(), "{}", found.reason);
    let power = found.nvh.unwrap().values.power.unwrap();
    let (all, miss) = terms(&power);
    let scale = throughput(&power);
    println!("{} {all:?}, misses {:.1e}", found.reason, miss / scale);
    assert!(power.stiffness.abs() > 1e-3 * scale, "{all:?}");
    assert!(power.stored.abs() < 1e-9 * scale, "{all:?}");
    assert!(miss.abs() < 1e-12 * scale, "{miss:e}");
}

/// An impact on a rigid stop loses `½ m (1 − ε²) v²`, and a stop that moves does work. The statistics of a point contain
/// both.
#[test]
fn impacts_on_a_rigid_stop_are_in_the_balance() {
    let restitution = 0.6;
    for moves in [0.0, 0.1] {
        let law = ContactLaw {
            gap: 0.5,
            error: vec![MeshHarmonic::new(1, moves, 0.3)],
            ..ContactLaw::default()
        };
        let mut structure = ModalStructure::of_modes(&[1.0], 0.05, &[1.0], &[1.0]);
        let stop = StructureContact::plain("stop".to_owned(), vec![1.0], law);
        structure.contacts.extend(stop.rigid(restitution));
        structure.harmonic_loads = vec![HarmonicLoad {
            name: "shaker".to_owned(),
            force: vec![1.0],
            turns_per_cycle: 1.0,
            phase: 0.0,
        }];
        let point = OperatingPoint {
            load: 0.0,
            speed: 0.8,
        };
        let model = Model::new(&structure, &Drive::constant(1e3, 1.0), point).unwrap();
        let start = model.start(&InitialState::Rest);

        let (mut power, mut lost, cycles) = (Power::new(&model), 0.0, 100);
        let (kernel, mut at) = (volterra(&model), start.clone());
        for _ in 0..cycles {
            let mut both = (power, Events::default());
            at = advance_with(&kernel, &at, 1, &mut both).0;
            power = both.0;
            power.cycle(&at);
            let impacts =
                (both.1.0.iter()).filter(|event| event.closes() && !model.is_rest(event.contact));
            lost += impacts
                .map(|event| 0.5 * (1.0 - restitution * restitution) * event.rate.powi(2))
                .sum::<f64>();
        }
        let transient = mean(&power);
        let exact = lost / (f64::from(cycles) * model.period());
        assert!(exact > 0.05, "{exact}");
        assert!(
            (transient.contact / exact - 1.0).abs() < 1e-10,
            "{transient:?} {exact}"
        );

        let never = AtomicBool::new(false);
        let asked = questions(true, 400);
        let found = investigate(&model, &volterra(&model), start, &asked, &never).unwrap();
        let settled = found.nvh.unwrap().values.power.unwrap();
        assert!(settled.contact > 0.05, "{settled:?}");
        assert_eq!(settled.error.abs() > 1e-3, moves > 0.0, "{settled:?}");
        for power in [transient, settled] {
            let (all, miss) = terms(&power);
            println!("{moves}: {all:.4?} W, misses {miss:.1e}");
            assert!(miss.abs() < 1e-11 * throughput(&power), "{all:?} {miss:e}");
        }
    }
}

/// Chaos has error bars, and its balance closes as well; powers that are not requested are not computed, and change
/// nothing.
#[test]
fn chaos_has_error_bars() {
    let (structure, drive, point) = common::six_modes();
    let model = Model::new(&structure, &drive, point).unwrap();
    let never = AtomicBool::new(false);
    let ask = |power: bool| {
        let start = model.start(&InitialState::Static);
        let asked = questions(power, 2000);
        let found = investigate(&model, &volterra(&model), start, &asked, &never).unwrap();
        assert!(found.class.unwrap().is_chaos(), "{}", found.reason);
        found.nvh.unwrap()
    };
    let mut with = ask(true);
    let (power, errors) = (
        with.values.power.take().unwrap(),
        with.stderr.as_mut().unwrap().power.take(),
    );
    let (errors, _) = terms(&errors.unwrap());
    let (all, miss) = terms(&power);
    let scale = throughput(&power);
    println!("{all:.4?} ± {errors:.4?}, misses {:.1e}", miss / scale);
    assert!(miss.abs() < 1e-12 * scale, "{miss:e}");
    for error in errors {
        assert!(error > 0.0 && error < 0.2 * scale, "{errors:?}");
    }
    let without = ask(false);
    assert!(without.values.power.is_none());
    assert_eq!(with, without);
}

/// Records of two trajectories can be joined, and truncation removes all traces of the rest.
#[test]
fn records_are_joined_and_cut() {
    let model = pair(Release::Deflection);
    let start = settled(&model, 40);
    let mut one = Power::new(&model);
    let middle = gather(&model, &start, 40, &mut one);
    let two = record(&model, &middle, 80);
    let (mut both, mut cut) = (one.clone(), two.clone());
    both.append(&two);
    cut.cut(40);
    let short = record(&model, &middle, 40);
    let [(one, _), (two, _), (both, miss), (cut, _), (short, _)] =
        [&one, &two, &both, &cut, &short].map(|power| terms(&mean(power)));
    let scale: f64 = both.iter().map(|p| p.abs()).sum();
    for i in 0..7 {
        let expected = (one[i] + 2.0 * two[i]) / 3.0;
        assert!((both[i] - expected).abs() < 1e-13 * scale, "{both:?}");
        assert!(
            (cut[i] - short[i]).abs() < 1e-13 * scale,
            "{cut:?} {short:?}"
        );
    }
    assert!(miss.abs() < 1e-12 * scale, "{miss:e}");
}
