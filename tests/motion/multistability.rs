//! Are coexisting attractors found, distinguished and counted? Small oscillators with two attractors each, one of which
//! is known in closed form; results through the program.

#![allow(clippy::unwrap_used)]

use crate::{common, program};
use common::advance::volterra;
use gearatlas::analysis::{
    Class, MultistabilityConfig, MultistabilityOutcome, ProbeOutcome, Probes, SliceConfig, SliceOf,
    Status, probe_basins,
};
use gearatlas::model::{
    Drive, DriveShaft, InitialState, MeshHarmonic, Model, OperatingPoint, TorqueRipple,
};
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::Volterra;
use gearatlas::store::{ResultTable, TableKind};
use gearatlas::structure::{ContactLaw, HarmonicLoad, ModalStructure, StructureContact};
use program::said;
use std::f64::consts::{SQRT_2, TAU};
use std::sync::atomic::AtomicBool;

const SEEDS: u64 = 20;
const PROBES: u32 = 16;

fn question() -> MultistabilityConfig {
    MultistabilityConfig {
        initial_conditions: PROBES,
        decades: 4.0,
        transient: 100,
        cycles: 1000,
        slice: None,
    }
}

fn probes(model: &Model, seed: u64, question: MultistabilityConfig) -> Probes {
    Probes::new(model, question, PointSeed { seed, point_id: 0 }, true).unwrap()
}

fn probe(model: &Model, seed: u64, question: MultistabilityConfig) -> MultistabilityOutcome {
    probe_with(&volterra(model), model, seed, question)
}

fn probe_with(
    kernel: &Volterra<'_>,
    model: &Model,
    seed: u64,
    question: MultistabilityConfig,
) -> MultistabilityOutcome {
    let start = model.start(&InitialState::Static);
    let interrupt = AtomicBool::new(false);
    let probes = probes(model, seed, question);
    probe_basins(model, kernel, &start, &probes, &interrupt).unwrap()
}

/// Modes on springs between two symmetric stops, with excitation at the mesh frequency.
struct Shaken {
    frequency: &'static [f64],
    mesh: &'static [f64],
    /// Modal force amplitudes \[N/√kg\].
    force: &'static [f64],
}

const DAMPING: f64 = 0.02;

const ONE_DEGREE: Shaken = Shaken {
    frequency: &[4000.0],
    mesh: &[1.0],
    force: &[56.0],
};

const TWO_DEGREES: Shaken = Shaken {
    frequency: &[4000.0, 9000.0],
    mesh: &[1.0, 0.5],
    force: &[56.0, 16.8],
};

impl Shaken {
    fn model(&self, half_gap: f64, speed: f64) -> Model {
        let none = vec![0.0; self.mesh.len()];
        let mut structure = common::structure(self.frequency, DAMPING, self.mesh, &none);
        structure.pinion_torque = Some(self.force.to_vec());
        let drive = Drive {
            damping: 480.0,
            // Order 20 of a shaft with 20 teeth: the mesh frequency.
            torque_ripple: vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                order: 20.0,
                amplitude: 1.0,
                phase: 0.0,
            }],
            ..common::constant_mesh(half_gap, 1.44e8)
        };
        Model::new(&structure, &drive, OperatingPoint { load: 1.0, speed }).unwrap()
    }

    /// RMS deflection and largest exponent of the motion without contact: a sum of forced linear oscillators.
    fn untouched(&self, speed: f64) -> (f64, f64) {
        let forcing = 20.0 * speed;
        let (mut re, mut im) = (0.0, 0.0);
        for ((natural, w), force) in self.frequency.iter().zip(self.mesh).zip(self.force) {
            let stiff = natural * natural - forcing * forcing;
            let loss = 2.0 * DAMPING * natural * forcing;
            let square = stiff * stiff + loss * loss;
            re += w * force * stiff / square;
            im -= w * force * loss / square;
        }
        let slowest = self.frequency.iter().copied().fold(f64::INFINITY, f64::min);
        (re.hypot(im) / SQRT_2, -DAMPING * slowest * TAU / forcing)
    }
}

/// A rigid relative rotation under load: stiff in contact, free in the gap.
fn loaded(load: f64, speed: f64) -> Model {
    let structure = common::structure(&[0.0], 0.0, &[1.3], &[1.3]);
    let drive = Drive {
        damping: 1483.0,
        transmission_error: vec![MeshHarmonic::new(1, 1e-6, 0.0)],
        ..common::constant_mesh(10e-6, 4e8)
    };
    Model::new(&structure, &drive, OperatingPoint { load, speed }).unwrap()
}

/// RMS deflection and exponent of the loaded oscillator's motion in contact: `δ'' + c w² δ' + k w² (δ − b) = −e''` and
/// a constant.
fn locked(speed: f64) -> (f64, f64) {
    let (forcing, square) = (20.0 * speed, 1.3f64 * 1.3);
    let (stiff, loss) = (4e8 * square - forcing * forcing, 1483.0 * square * forcing);
    let amplitude = 1e-6 * forcing * forcing / stiff.hypot(loss);
    (amplitude / SQRT_2, -0.5 * 1483.0 * square * TAU / forcing)
}

/// The first probe on each attractor, and the number of probes on each.
fn attractors(found: &MultistabilityOutcome) -> Vec<(&ProbeOutcome, u32)> {
    let on = |id| found.probes.iter().filter(move |p| p.attractor == Some(id));
    (0..found.attractors.len() as u32)
        .map(|id| (on(id).next().unwrap(), on(id).count() as u32))
        .collect()
}

/// Two attractors for every seed: the one in closed form, and one of period 1 with the given events per cycle. Shares
/// of different seeds estimate the same basins.
fn found_for_every_seed(model: &Model, quiet: (Class, f64, f64), events: f64) {
    let (class, rms, lambda) = quiet;
    let mut intervals = Vec::new();
    let mut on_quiet = 0;
    for seed in 0..SEEDS {
        let found = probe(model, seed, question());
        assert_eq!(found.attractors.len(), 2, "seed {seed}");
        assert_eq!(found.probes[0].attractor, Some(0));
        let both = attractors(&found);
        assert_eq!(both.iter().map(|(_, count)| count).sum::<u32>(), PROBES);
        let (quiet, rest): (Vec<_>, Vec<_>) = both
            .into_iter()
            .partition(|(p, _)| p.events_per_cycle == Some(0.0));
        let [(quiet, count)] = quiet[..] else {
            panic!("seed {seed}: {found:?}")
        };
        assert_eq!((&quiet.status, quiet.class), (&Status::Ok, Some(class)));
        assert!((quiet.deflection_rms.unwrap() / rms - 1.0).abs() < 1e-7);
        assert!((quiet.lambda.unwrap() / lambda - 1.0).abs() < 1e-7);
        let (loud, _) = rest[0];
        assert_eq!(loud.class, Some(Class::Periodic(1)), "seed {seed}");
        assert_eq!(loud.events_per_cycle, Some(events), "seed {seed}");
        assert!(loud.deflection_rms.unwrap() > 2.0 * rms && loud.lambda.unwrap() < 0.0);
        assert_eq!(quiet.basin.share, f64::from(count) / f64::from(PROBES));
        on_quiet += count;
        intervals.push(quiet.basin);
    }
    let pooled = f64::from(on_quiet) / (SEEDS as f64 * f64::from(PROBES));
    let covering = intervals
        .iter()
        .filter(|basin| basin.low <= pooled && pooled <= basin.high)
        .count();
    // More than four misses of 95 % intervals in 20 have a chance of 0.3 %.
    assert!(covering >= 16, "{covering} intervals hold {pooled}");
}

#[test]
fn rest_in_the_gap_beside_impacts() {
    let (rms, lambda) = ONE_DEGREE.untouched(300.0);
    let quiet = (Class::Periodic(1), rms, lambda);
    found_for_every_seed(&ONE_DEGREE.model(10e-6, 300.0), quiet, 4.0);
}

#[test]
fn two_degrees_between_stops() {
    let (rms, lambda) = TWO_DEGREES.untouched(280.0);
    let quiet = (Class::Periodic(1), rms, lambda);
    found_for_every_seed(&TWO_DEGREES.model(10e-6, 280.0), quiet, 4.0);
}

#[test]
fn steady_contact_beside_rattle() {
    let (rms, lambda) = locked(950.0);
    found_for_every_seed(
        &loaded(0.5, 950.0),
        (Class::SteadyContact(Some(1)), rms, lambda),
        2.0,
    );
}

/// The equations are invariant under δ → −δ with a shift of half a cycle. An orbit that is not its own image has one,
/// with the same numbers and other strobe points.
#[test]
fn mirror_images_are_two_attractors() {
    let model = ONE_DEGREE.model(3e-6, 160.0);
    for seed in 0..SEEDS {
        let found = probe(&model, seed, question());
        let both = attractors(&found);
        let [(a, _), (b, _)] = both[..] else {
            panic!("seed {seed}: {found:?}")
        };
        let same = |get: fn(&ProbeOutcome) -> Option<f64>| {
            let (a, b) = (get(a).unwrap(), get(b).unwrap());
            assert!((a - b).abs() <= 1e-7 * a.abs(), "seed {seed}: {a} {b}");
        };
        assert_eq!(a.class, Some(Class::Periodic(1)));
        assert_eq!(a.class, b.class);
        same(|p| p.lambda);
        same(|p| p.deflection_rms);
        same(|p| p.force_peak);
        same(|p| p.events_per_cycle);
    }
}

#[test]
fn one_attractor_is_not_split() {
    // In chaos, the statistics of probes differ within their errors.
    let chaos = common::model(&common::one_degree());
    for seed in 0..SEEDS {
        let found = probe(&chaos, seed, question());
        assert_eq!(found.attractors.len(), 1, "seed {seed}: {found:?}");
        let first = &found.probes[0];
        assert_eq!(first.class, Some(Class::Chaotic), "{}", first.reason);
        assert_eq!(first.basin.share, 1.0);
        assert_eq!(first.basin.high, 1.0);
        assert!((0.8..0.81).contains(&first.basin.low), "{:?}", first.basin);
    }
}

fn plane(extent: f64, count: u32) -> SliceConfig {
    SliceConfig {
        modes: [0, 1],
        of: SliceOf::Displacement,
        extent,
        speed: None,
        count,
    }
}

/// A cell that is decided by its approach to a known orbit ends where full integration ends.
#[test]
fn cells_are_decided_as_they_are_when_integrated_to_the_end() {
    let model = TWO_DEGREES.model(10e-6, 280.0);
    for (seed, extent) in [(0, 20e-6), (1, 200e-6)] {
        let watched = MultistabilityConfig {
            slice: Some(plane(extent, 16)),
            ..question()
        };
        let integrated = MultistabilityConfig {
            transient: 0,
            ..watched
        };
        let [watched, integrated] =
            [watched, integrated].map(|question| probe(&model, seed, question));
        assert_eq!(watched.cells.len(), 256);
        assert_eq!(watched.attractors.len(), 2);
        for (a, b) in watched.cells.iter().zip(&integrated.cells) {
            assert_eq!((a.column, a.row, a.place), (b.column, b.row, b.place));
            assert_eq!(
                (a.attractor, a.class),
                (b.attractor, b.class),
                "{a:?}\n{b:?}"
            );
            assert_eq!(a.status, Status::Ok);
            assert!(b.in_full);
        }
        let in_full = watched.cells.iter().filter(|cell| cell.in_full).count();
        assert!(in_full < 26, "{in_full} cells were investigated in full");
        let cycles = |found: &MultistabilityOutcome| -> u64 {
            found.cells.iter().map(|cell| cell.cycles).sum()
        };
        assert!(4 * cycles(&watched) < cycles(&integrated));
        for (id, attractor) in (0..).zip(&watched.attractors) {
            let on = |cell: &&gearatlas::analysis::CellOutcome| cell.attractor == Some(id);
            let cells = watched.cells.iter().filter(on).count();
            assert!(cells > 10, "{cells} cells on attractor {id}");
            assert_eq!(attractor.cells, Some(cells as u32));
            assert_eq!(attractor.strobe.len(), 1);
        }
    }
}

/// The slice finds attractors that no probe found, once, and their orbits decide cells of later rounds.
#[test]
fn a_slice_finds_what_no_probe_found() {
    let model = TWO_DEGREES.model(10e-6, 280.0);
    let found = probe(
        &model,
        0,
        MultistabilityConfig {
            initial_conditions: 1,
            slice: Some(plane(200e-6, 16)),
            ..question()
        },
    );
    assert_eq!(found.probes.len(), 1);
    assert_eq!(
        (found.probes[0].amplitude, found.probes[0].basin.share),
        (0.0, 1.0)
    );
    assert_eq!(found.attractors.len(), 2);
    assert_eq!(
        [found.attractors[0].probes, found.attractors[1].probes],
        [1, 0]
    );
    assert!(found.attractors[1].cells > Some(10));
    let on_second = |cell: &&gearatlas::analysis::CellOutcome| cell.attractor == Some(1);
    let in_full = found
        .cells
        .iter()
        .filter(on_second)
        .filter(|cell| cell.in_full);
    let in_full = in_full.count();
    assert!((1..=16).contains(&in_full), "{in_full}");
}

/// An undamped oscillator in its gap without excitation: rest and every free vibration are points of one continuum, not
/// separate attractors.
#[test]
fn a_continuum_is_one() {
    let mut structure = common::structure(&[4000.0], 0.0, &[1.0], &[0.0]);
    structure.damping = vec![0.0];
    let drive = Drive {
        damping: 480.0,
        ..common::constant_mesh(10e-6, 1.44e8)
    };
    let point = OperatingPoint {
        load: 0.0,
        speed: 300.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    for seed in 0..3 {
        let config = MultistabilityConfig {
            decades: 8.0,
            ..question()
        };
        let found = probe(&model, seed, config);
        let free: Vec<&ProbeOutcome> = found
            .probes
            .iter()
            .filter(|p| p.events_per_cycle == Some(0.0) && p.attractor.is_some())
            .collect();
        assert!(free.len() >= 5, "{}", free.len());
        assert!(free.iter().all(|p| p.attractor == Some(0)), "{free:?}");
        // One probe is at rest, the others are on two of the circles.
        let rms = |p: &ProbeOutcome| p.deflection_rms.unwrap();
        assert!(rms(free[0]) < 1e-15 && rms(free[2]) > 1.2 * rms(free[1]));
        assert!(free.iter().all(|p| p.lambda.unwrap().abs() < 1e-3));
    }
}

/// If every probe diverges, there is no attractor, and the status has the whole share.
#[test]
fn all_may_storm() {
    let model = ONE_DEGREE.model(0.3e-6, 160.0);
    let kernel = Volterra::new(&model, f64::EPSILON, 1);
    let two = TWO_DEGREES.model(0.3e-6, 160.0);
    let found = probe_with(&kernel, &model, 1, question());
    assert!(found.attractors.is_empty());
    for probe in &found.probes {
        assert_eq!(
            (&probe.status, probe.basin.share),
            (&Status::EventStorm, 1.0)
        );
    }
    let sliced = MultistabilityConfig {
        slice: Some(plane(1e-6, 4)),
        ..question()
    };
    let kernel = Volterra::new(&two, f64::EPSILON, 1);
    let found = probe_with(&kernel, &two, 1, sliced);
    assert!(found.attractors.is_empty());
    assert_eq!(found.cells.len(), 16);
    for cell in &found.cells {
        let ending = (cell.attractor, &cell.status, cell.class, cell.in_full);
        assert_eq!(ending, (None, &Status::EventStorm, None, false));
    }
}

/// Probes that fail are separate endings and keep their share.
#[test]
fn troubled_probes_are_counted() {
    let model = ONE_DEGREE.model(10e-6, 300.0);
    let start = model.start(&InitialState::Static);
    let interrupt = AtomicBool::new(false);
    // The motion between the stops has four events per cycle.
    let kernel = Volterra::new(&model, f64::EPSILON, 3);
    let found = probe_with(&kernel, &model, 1, question());
    assert_eq!(found.attractors.len(), 1);
    assert_eq!(found.probes.len(), PROBES as usize);
    let (settled, stormed): (Vec<_>, Vec<_>) =
        found.probes.iter().partition(|p| p.attractor == Some(0));
    assert!(!settled.is_empty() && !stormed.is_empty());
    for probe in &stormed {
        assert_eq!(probe.status, Status::EventStorm);
        assert_eq!((probe.attractor, probe.lambda), (None, None));
        assert!(probe.reason.contains("more than 3 events"));
        let share = stormed.len() as f64 / f64::from(PROBES);
        assert_eq!(probe.basin.share, share);
        assert!((settled[0].basin.share + share - 1.0).abs() < 1e-15);
    }
    interrupt.store(true, std::sync::atomic::Ordering::Relaxed);
    assert!(
        probe_basins(
            &model,
            &kernel,
            &start,
            &probes(&model, 1, question()),
            &interrupt
        )
        .is_err()
    );
}

const STRUCTURE: &str = include_str!("../manifests/one.modal.toml");

const MANIFEST: &str = concat!(
    r#"
[job]
name = "planted"
seed = 5

"#,
    include_str!("../manifests/one.head.toml"),
    r#"
[grid]
load = 1.0
speed = { from = 900, to = 1100, count = 5 }

[run]
transient = 100
cycles = 1000

[analyses]
multistability = { initial_conditions = 12 }
"#
);

#[test]
fn probes_do_not_depend_on_threads_and_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("one.modal.toml"), STRUCTURE).unwrap();
    std::fs::write(path.join("m.toml"), MANIFEST).unwrap();
    let line =
        "multistability (12 initial conditions over 4 decades of energy, 100 + 1000 cycles each)";
    assert!(said(path, &["check", "m.toml"]).contains(line));
    for threads in ["1", "2"] {
        said(
            path,
            &[
                "run",
                "m.toml",
                "--out",
                threads,
                "--threads",
                threads,
                "--quiet",
            ],
        );
    }
    let bytes = |threads: &str| std::fs::read(path.join(threads).join("probes.parquet")).unwrap();
    assert_eq!(bytes("1"), bytes("2"));

    let points = ResultTable::read(&path.join("1"), TableKind::Points).unwrap();
    let probes = ResultTable::read(&path.join("1"), TableKind::Probes).unwrap();
    assert_eq!(probes.rows(), 5 * 12);
    let counts = points.u64("attractors").unwrap();
    let (ids, attractors) = (
        probes.u64("point_id").unwrap(),
        probes.u64("attractor_id").unwrap(),
    );
    for (point, count) in counts.iter().enumerate() {
        let found = ids.iter().zip(&attractors);
        let largest = found
            .filter(|(id, _)| **id == Some(point as u64))
            .filter_map(|(_, attractor)| *attractor)
            .max();
        assert_eq!(largest.map(|id| id + 1), *count);
    }
    let several = counts.iter().filter(|count| **count > Some(1)).count();
    assert!(several >= 2, "{counts:?}");
    let cycles: u64 = probes.u64("cycles").unwrap().into_iter().flatten().sum();
    let all: u64 = points.u64("cycles").unwrap().into_iter().flatten().sum();
    assert!(cycles < all && all < cycles + 5 * 2000);

    let shown = said(path, &["show", "1"]);
    let heading = "more than one attractor, shares of the probes with 95 % intervals";
    assert!(shown.contains(heading), "{shown}");
    let lines = shown
        .lines()
        .filter(|line| line.contains("steady contact, RMS"));
    let lines: Vec<&str> = lines.collect();
    assert_eq!(lines.len(), several, "{shown}");
    assert!(lines.iter().all(|line| line.contains("period 1, RMS")));
}

/// A rigid stop with two attractors. The one of period 6 rests on the stop, so that its exponent is −∞.
#[test]
fn an_attractor_that_rests_on_a_stop_is_counted() {
    let mut structure = ModalStructure::of_modes(&[1.0], 0.02, &[1.0], &[1.0]);
    let law = ContactLaw {
        gap: 0.1,
        ..ContactLaw::default()
    };
    let stop = StructureContact::plain("stop".to_owned(), vec![1.0], law);
    structure.contacts.extend(stop.rigid(0.8));
    structure.harmonic_loads = vec![HarmonicLoad {
        name: "load".to_owned(),
        force: vec![1.0],
        turns_per_cycle: 1.0,
        phase: 0.0,
    }];
    let point = OperatingPoint {
        load: 0.0,
        speed: 2.7,
    };
    let model = Model::new(&structure, &Drive::constant(1.0, 1.0), point).unwrap();
    let found = probe(&model, 1, question());
    let mut periods: Vec<_> = found
        .attractors
        .iter()
        .map(|one| one.class.period())
        .collect();
    periods.sort_unstable();
    assert_eq!(periods, [Some(4), Some(6)]);
    let counted: u32 = found.attractors.iter().map(|one| one.probes).sum();
    assert_eq!(counted, PROBES);
}
