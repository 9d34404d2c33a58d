//! Is regular motion ever classified as chaotic, or chaotic motion as anything else? Random drives whose motion is
//! known to be regular without an exponent ([`common::motions`]), with budgets from a hundred cycles up, and drives
//! that another integrator proves to be chaotic in `planted.rs`.
//!
//! Requirements for every motion:
//!
//! 1. it is not classified as chaotic, not even for a time;
//! 2. its twin does not contradict its tangents;
//! 3. from 320 measured cycles on, an exponent has an error bar. From there on, motion under ripple without a
//!    period has a verdict once neighbours have approached by e⁻²⁵: `quasi_periodic` if
//!    it rattles, else `steady_contact`;
//! 4. of the others, at least nine of ten have a verdict from 800 cycles on.
//!
//! Drives planned as linear that leave their contact state do not count. Neither do drives planned as tori whose
//! motions from two distant states do not become one within the transient: those may be chaotic for a time, and nothing
//! is known about the others.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::volterra;
use common::motions::{Kind, Planted, contracts, planted};
use gearatlas::analysis::{
    Class, Effort, LyapunovConfig, PointConfig, PointOutcome, Section, Status, investigate,
};
use gearatlas::model::{InitialState, MeshHarmonic, Model, TrajectoryState};
use gearatlas::numerics::random::PointSeed;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;

/// Cycles skipped before a motion is measured.
const TRANSIENT: u64 = 200;

/// Measured cycles.
const BUDGETS: [u64; 5] = [100, 150, 320, 800, 4000];

fn ask(model: &Model, start: &TrajectoryState, seed: u64, cycles: u64) -> PointOutcome {
    let questions = PointConfig {
        point: PointSeed { seed, point_id: 0 },
        transient: TRANSIENT,
        cycles,
        settle: true,
        audit_cycles: 0,
        lyapunov: Some(LyapunovConfig {
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: None,
    };
    let interrupt = AtomicBool::new(false);
    investigate(
        model,
        &volterra(model),
        start.clone(),
        &questions,
        &interrupt,
    )
    .unwrap()
}

/// Whether the known property of a kind holds for a drive, according to the longest integration.
fn known(kind: Kind, planted: &Planted, longest: &PointOutcome) -> bool {
    match kind {
        Kind::Integrable | Kind::Beside => true,
        Kind::Linear | Kind::Rippled | Kind::Parametric => longest.events_per_cycle == Some(0.0),
        Kind::Torus => contracts(&planted.model, &planted.start, TRANSIENT),
    }
}

/// Results for a kind at a budget: counts of classes, and violated rules.
#[derive(Debug, Default)]
struct Tally {
    classes: BTreeMap<&'static str, usize>,
    left_out: usize,
    broken: Vec<String>,
}

impl Tally {
    fn of(kind: Kind, cycles: u64, cases: &[(u64, Planted, bool)]) -> Self {
        let mut tally = Self::default();
        let mut undecided = Vec::new();
        let follows = matches!(kind, Kind::Torus | Kind::Rippled);
        for (seed, planted, known) in cases {
            if !known {
                tally.left_out += 1;
                continue;
            }
            let found = ask(&planted.model, &planted.start, *seed, cycles);
            let class = found
                .class
                .map_or(found.status.name(), |class| class.name());
            *tally.classes.entry(class).or_default() += 1;
            let case = format!("{kind:?} {seed} at {cycles}: {class}: {}", found.reason);
            let chaos = found.class.is_some_and(|class| class.is_chaos());
            if chaos || found.chaos.is_some() {
                tally.broken.push(case.clone());
            }
            let exponent = found.lyapunov.as_ref().map_or(0.0, |l| l.exponents[0]);
            if let Some(lyapunov) = found.lyapunov.filter(|l| l.twin_agrees == Some(false)) {
                tally.broken.push(format!("twin of {case}: {lyapunov:?}"));
            }
            let settled = exponent * cycles as f64 <= -25.0;
            if found.status != Status::Ok && (settled || !follows) {
                undecided.push(case);
            }
        }
        let allowed = match (follows, cycles) {
            (true, 320..) => 0,
            (false, 800..) => (cases.len() - tally.left_out) / 10,
            _ => usize::MAX,
        };
        if undecided.len() > allowed {
            tally.broken.extend(undecided);
        }
        tally
    }
}

/// Tallies of all kinds and budgets for some seeds, on two cores, which every machine has.
fn tallies(seeds: std::ops::Range<u64>) -> Vec<(Kind, u64, Tally)> {
    let tally = |kind: Kind| -> Vec<(Kind, u64, Tally)> {
        let cases: Vec<(u64, Planted, bool)> = seeds
            .clone()
            .map(|seed| {
                let planted = planted(kind, seed);
                let longest = ask(&planted.model, &planted.start, seed, BUDGETS[4]);
                let known = !longest.status.is_failure() && known(kind, &planted, &longest);
                (seed, planted, known)
            })
            .collect();
        BUDGETS
            .map(|cycles| (kind, cycles, Tally::of(kind, cycles, &cases)))
            .into()
    };
    let (one, two) = Kind::ALL.split_at(3);
    std::thread::scope(|scope| {
        let other = scope.spawn(|| two.iter().map(|kind| tally(*kind)).collect::<Vec<_>>());
        let mut all: Vec<_> = one.iter().map(|kind| tally(*kind)).collect();
        all.extend(other.join().unwrap());
        all.into_iter().flatten().collect()
    })
}

fn table(tallies: &[(Kind, u64, Tally)]) -> String {
    let mut text =
        "| motion | cycles | left out | classes | rules broken |\n|---|---|---|---|---|\n"
            .to_owned();
    for (kind, cycles, tally) in tallies {
        let classes: Vec<String> = (tally.classes.iter())
            .map(|(class, count)| format!("{count} {class}"))
            .collect();
        let (left_out, broken) = (tally.left_out, tally.broken.len());
        let classes = classes.join(", ");
        _ = writeln!(
            text,
            "| {kind:?} | {cycles} | {left_out} | {classes} | {broken} |"
        );
    }
    text
}

fn hold(tallies: &[(Kind, u64, Tally)]) {
    let broken: Vec<&String> = tallies.iter().flat_map(|(_, _, t)| &t.broken).collect();
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn regular_motion_is_never_called_chaotic() {
    let found = tallies(0..12);
    println!("{}", table(&found));
    hold(&found);
}

/// Tests `ATLAS_FUZZ_SEEDS` seeds, from `ATLAS_FUZZ_FIRST` on: `scripts/record verdicts`.
#[test]
#[ignore = "takes minutes; scripts/record verdicts runs it"]
fn much_regular_motion_is_never_called_chaotic() {
    let number = |name: &str, default: u64| {
        std::env::var(name).map_or(default, |text| text.parse().unwrap())
    };
    let first = number("ATLAS_FUZZ_FIRST", 1000);
    let seeds = number("ATLAS_FUZZ_SEEDS", 100);
    let found = tallies(first..first + seeds);
    println!(
        "seeds {first} to {}\n\n{}",
        first + seeds - 1,
        table(&found)
    );
    hold(&found);
}

/// One degree near the end of a cascade and in a chaotic band, and forty modes in strong rattle: `planted.rs` and
/// `exponents.rs` prove independently that they are chaotic.
#[test]
fn chaotic_motion_is_found_at_any_budget_with_an_error_bar() {
    let band = |load, speed| {
        let structure = common::structure(&[0.0], 0.01, &[1.0], &[1.0]);
        let (_, mut drive, mut point) = common::one_degree();
        drive.mesh = gearatlas::model::Division::levels(&[4e8], &[]);
        drive.transmission_error = vec![MeshHarmonic::new(1, 2e-6, 0.0)];
        (point.load, point.speed) = (load, speed);
        Model::new(&structure, &drive, point).unwrap()
    };
    let drives = [
        ("cascade", band(0.3727, 1000.0)),
        ("band", band(0.5, 1320.0)),
        ("band", band(0.5, 1480.0)),
        ("rattle", common::model(&common::one_degree())),
        ("six modes", common::model(&common::six_modes())),
        ("forty modes", common::model(&common::forty_modes())),
    ];
    for (name, model) in &drives {
        for cycles in [320, 800] {
            let found = ask(model, &model.start(&InitialState::Static), 1, cycles);
            let expected = (Status::Ok, Some(Class::Chaotic));
            assert_eq!(
                (found.status, found.class),
                expected,
                "{name} {cycles}: {}",
                found.reason
            );
        }
    }
}
