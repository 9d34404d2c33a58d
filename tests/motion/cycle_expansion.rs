//! Are the unstable orbits of a chaotic set counted, and do averages over them hold what they promise?

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{mean_equilibrium, volterra};
use gearatlas::analysis::{
    ExpansionError, ExpansionOutcome, ExpansionQuantity, ExpansionQuestion, OrbitQuestion,
    cycle_expansion, survey_orbits,
};
use gearatlas::manifest;
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::{Counters, Kernel};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;

const MANIFEST: &str = include_str!("../../manifests/cycle-expansion.toml");

/// The drive of the manifest at its first load, and a state of its settled motion.
fn settled() -> (Model, TrajectoryState) {
    let job = manifest::parse(MANIFEST, "m.toml", Path::new("")).unwrap();
    let model = common::parts().model(&job.points.at(0)).unwrap();
    let mut trajectory = mean_equilibrium(&model);
    let kernel = volterra(&model);
    kernel
        .advance(
            500,
            &mut trajectory,
            &mut kernel.workspace(),
            &mut (),
            &mut Counters::default(),
        )
        .unwrap();
    (model, trajectory)
}

fn expanded(
    model: &Model,
    start: &TrajectoryState,
    question: &ExpansionQuestion,
) -> ExpansionOutcome {
    let seed = PointSeed {
        seed: 1,
        point_id: 0,
    };
    let called_off = AtomicBool::new(false);
    cycle_expansion(model, &volterra(model), start, question, seed, &called_off).unwrap()
}

#[test]
fn orbits_of_a_thin_set_are_all_found_and_average_to_what_time_does() {
    let (model, start) = settled();
    let question = ExpansionQuestion {
        longest: 6,
        guesses: 2000,
        cycles: 40_000,
    };
    let found = expanded(&model, &start, &question);
    let orbits: Vec<u32> = found.orders.iter().map(|o| o.orbits).collect();
    for order in &found.orders {
        println!("{order:?}");
    }
    // Counted twice: the same from another stretch of trajectory with fewer searches.
    assert_eq!(orbits, [1, 5, 4, 3, 14, 30]);
    let other = ExpansionQuestion {
        guesses: 1200,
        cycles: 25_000,
        ..question
    };
    let mut later = start.clone();
    let kernel = volterra(&model);
    let workspace = &mut kernel.workspace();
    kernel
        .advance(
            50_000,
            &mut later,
            workspace,
            &mut (),
            &mut Counters::default(),
        )
        .unwrap();
    let again = expanded(&model, &later, &other);
    let orbits: Vec<u32> = again.orders.iter().map(|o| o.orbits).collect();
    assert_eq!(orbits, [1, 5, 4, 3, 14, 30]);
    let last = found.orders.last().unwrap();
    assert!(
        found
            .orders
            .iter()
            .all(|o| o.unseen < 1.0 && o.closed > 100)
    );
    assert!((0.8..1.0).contains(&last.entropy.unwrap()));
    assert!(last.escape_determinant.unwrap().abs() < 0.1);
    for average in &last.averages {
        let [determinant, time] = [average.determinant.unwrap(), average.time];
        let apart = (determinant.value - time.value).abs();
        assert!(time.error.unwrap() < 0.02 * time.value.abs(), "{average:?}");
        assert!(apart < 0.2 * time.value.abs(), "{average:?}");
    }
}

/// Single shooting from the midpoints of near returns finds the short orbits as well.
#[test]
fn another_search_finds_the_same_short_orbits() {
    let (model, start) = settled();
    let question = ExpansionQuestion {
        longest: 3,
        guesses: 1500,
        cycles: 30_000,
    };
    let found = expanded(&model, &start, &question);
    let surveyed = OrbitQuestion {
        periods: vec![1, 2, 3],
        guesses: 300,
        cycles: 30_000,
        floquet: false,
        returns: 0,
        states: Vec::new(),
    };
    let called_off = AtomicBool::new(false);
    let kernel = volterra(&model);
    let survey =
        survey_orbits(&model, &kernel, &mut start.clone(), &surveyed, &called_off).unwrap();
    for (n, order) in (1..).zip(&found.orders) {
        let unstable = survey.orbits.iter().filter(|o| o.period == n);
        assert_eq!(unstable.count() as u32, order.orbits, "period {n}");
    }
    let lambda = |averages: &[gearatlas::analysis::ExpansionAverage]| {
        let of = |q| averages.iter().find(|a| a.quantity == q).unwrap().zeta;
        of(ExpansionQuantity::LambdaMax).unwrap().value
    };
    // One orbit alone averages to its own exponent.
    let only = survey.orbits.iter().find(|o| o.period == 1).unwrap();
    let first = lambda(&found.orders[0].averages);
    assert!(
        (first - only.lambda).abs() < 1e-9,
        "{first} {}",
        only.lambda
    );
}

#[test]
fn a_drive_that_repeats_later_has_no_short_orbits() {
    // Ripple of both shafts.
    let model = common::model(&common::six_modes());
    let question = ExpansionQuestion {
        longest: 4,
        guesses: 10,
        cycles: 100,
    };
    let seed = PointSeed {
        seed: 1,
        point_id: 0,
    };
    let refused = cycle_expansion(
        &model,
        &volterra(&model),
        &mean_equilibrium(&model),
        &question,
        seed,
        &AtomicBool::new(false),
    );
    assert_eq!(refused, Err(ExpansionError::LongerDrive { longest: 4 }));
}

/// The table and what is told of it, through the program, for one and for two threads.
#[test]
fn averages_are_a_table_that_threads_do_not_change() {
    let folder = tempfile::tempdir().unwrap();
    let text = MANIFEST.replace(
        "{ longest = 10, guesses = 3000, cycles = 100000 }",
        "{ longest = 4, guesses = 200, cycles = 4000 }",
    );
    assert!(text != MANIFEST);
    let manifest = folder.path().join("m.toml");
    std::fs::write(&manifest, text).unwrap();
    let atlas = |arguments: &[&str]| {
        let run = Command::new(env!("CARGO_BIN_EXE_atlas"))
            .current_dir(folder.path())
            .args(arguments)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.success(), "{said}");
        String::from_utf8(run.stdout).unwrap()
    };
    let mut bytes = Vec::new();
    for threads in ["1", "2"] {
        atlas(&[
            "run",
            "m.toml",
            "--quiet",
            "--threads",
            threads,
            "--out",
            threads,
        ]);
        let table = folder.path().join(threads).join("cycle_expansion.parquet");
        bytes.push(std::fs::read(table).unwrap());
    }
    assert_eq!(bytes[0], bytes[1]);
    let shown = atlas(&["show", "1"]);
    assert!(shown.contains("averages over unstable orbits"), "{shown}");
    assert!(shown.contains("up to period 4"), "{shown}");
    assert_eq!(shown.matches("lambda_max").count(), 2, "{shown}");
}
