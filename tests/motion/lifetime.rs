//! How long does chaos last, what is reported when it ends, and how much of it is seen first? An impact oscillator with
//! transient chaos at amplitudes of its ripple from 25.963 to 26.12, and a motion on a torus.

#![allow(clippy::unwrap_used)]

use crate::{common, place, results};
use common::advance::volterra;
use gearatlas::analysis::{
    Class, Effort, LyapunovConfig, LyapunovMethod, PointConfig, PointOutcome, Section, Status,
    investigate,
};
use gearatlas::manifest;
use gearatlas::model::{Division, InitialState, MeshHarmonic, Model, TrajectoryState};
use gearatlas::numerics::random::{PointSeed, Stream};
use gearatlas::numerics::statistics::mean;
use gearatlas::store::{ResultTable, TableKind};
use place::Place;
use results::assert_same;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const MANIFEST: &str = include_str!("../manifests/oscillator.toml");

/// Measured cycles at the first look at verified errors.
const FIRST_LOOK: u64 = 40_000;

/// The oscillator at an amplitude of its ripple.
fn oscillator(amplitude: f64) -> Model {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/manifests");
    let known = "amplitude = 27,";
    assert!(MANIFEST.contains(known));
    let text = MANIFEST.replace(known, &format!("amplitude = {amplitude:?},"));
    let job = manifest::parse(&text, "oscillator.toml", &folder).unwrap();
    common::parts().model(&job.points.at(0)).unwrap()
}

fn questions(cycles: u64, lyapunov: LyapunovConfig) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 1,
            point_id: 0,
        },
        transient: 300,
        cycles,
        settle: true,
        audit_cycles: 0,
        lyapunov: Some(LyapunovConfig {
            twin: false,
            ..lyapunov
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: None,
    }
}

/// Requests an exponent to 0.01.
fn usual() -> LyapunovConfig {
    LyapunovConfig {
        stop_at_stderr: Some(0.01),
        ..LyapunovConfig::default()
    }
}

fn ask_from(model: &Model, start: TrajectoryState, questions: &PointConfig) -> PointOutcome {
    let interrupt = AtomicBool::new(false);
    investigate(model, &volterra(model), start, questions, &interrupt).unwrap()
}

fn ask(model: &Model, questions: &PointConfig) -> PointOutcome {
    ask_from(model, model.start(&InitialState::Static), questions)
}

#[test]
fn chaos_that_lasts_has_a_lower_bound_of_its_life() {
    assert_eq!(Effort::Verified.first_look(), FIRST_LOOK);
    let found = ask(&oscillator(27.0), &questions(160_000, usual()));
    let ended = (found.status, found.class);
    assert_eq!(
        ended,
        (Status::Ok, Some(Class::Chaotic)),
        "{}",
        found.reason
    );
    let lyapunov = found.lyapunov.unwrap();
    assert_eq!(lyapunov.method, LyapunovMethod::Tangent);
    assert!(lyapunov.stderr() <= 0.01);
    // One look is enough; trajectories have whole hundreds of cycles.
    let measured = found.measured_cycles;
    assert!(
        (FIRST_LOOK..FIRST_LOOK + 800).contains(&measured),
        "{measured}"
    );

    let evidence = found.evidence.unwrap();
    assert_eq!((evidence.trajectories, evidence.verified), (8, true));
    let (memory, rhat) = (evidence.correlation_cycles.unwrap(), evidence.rhat.unwrap());
    assert!((1.0..1000.0).contains(&memory), "{memory}");
    assert!((0.99..1.1).contains(&rhat), "{rhat}");
    let ess = evidence.ess.unwrap();
    assert!(ess > 100.0 && ess < measured as f64, "{ess}");
    assert_eq!((evidence.rotation_number, evidence.chains), (None, None));

    let chaos = found.chaos.unwrap();
    // Seven branches separate from the pilot over 200 cycles before they are measured.
    let chaotic = measured + 7 * 200;
    assert_eq!((chaos.cycles, chaos.exits), (chaotic, 0));
    assert_eq!((chaos.trajectories, chaos.lifetime()), (8, None));
    assert_eq!(chaos.interval(), (chaotic as f64 / 3.0, None));
    assert_eq!((chaos.ended_on, chaos.averages_before_exit), (None, None));
    let said = format!(
        "no trajectory left chaos within {chaotic} cycles; its mean life is at least {:.0} cycles",
        chaotic as f64 / 3.0
    );
    assert!(found.reason.contains(&said), "{}", found.reason);
}

#[test]
fn a_life_that_is_asked_for_is_shown_or_missed() {
    let model = oscillator(27.0);
    let asked = LyapunovConfig {
        lifetime: Some(25_000),
        ..usual()
    };
    let shown = ask(&model, &questions(160_000, asked));
    assert_eq!(shown.status, Status::Ok, "{}", shown.reason);
    let (low, high) = shown.chaos.unwrap().interval();
    assert!(low >= 25_000.0 && high.is_none(), "{low}");
    let short = ask(&model, &questions(50_000, asked));
    assert_eq!(short.status, Status::NotConverged, "{}", short.reason);
    let said = "but evidence for a mean life of 25000 cycles needs 75000";
    assert!(short.reason.contains(said), "{}", short.reason);
}

/// Mean lives were measured on 600 and 150 other trajectories, without their first thousand cycles: 1850 ± 110 and 10
/// 800 ± 940 cycles.
#[test]
fn the_life_of_transient_chaos_is_within_its_interval() {
    let (mut intervals, mut held) = (0, 0);
    for (amplitude, life, starts) in [(25.98, 1850.0, 40), (25.967, 10_800.0, 6)] {
        let model = oscillator(amplitude);
        for seed in 0..starts {
            let mut stream = Stream::new(seed, 1, 2);
            let mut start = model.start(&InitialState::Static);
            (start.state.iter_mut()).for_each(|x| *x *= 1.0 + 1e-6 * stream.normal());
            let start = TrajectoryState::new(&model, start.state, 0);
            let found = ask_from(&model, start, &questions(160_000, usual()));
            // If the first trajectory leaves within the transient, nothing is reported.
            let Some(chaos) = found.chaos else {
                assert_eq!(found.class, Some(Class::Periodic(12)), "{}", found.reason);
                continue;
            };
            println!("{amplitude}: {:?}, {chaos:?}", found.class);
            let all = chaos.exits == chaos.trajectories;
            let class = match (chaos.exits, all) {
                (0, _) => Class::Chaotic,
                (_, false) => Class::TransientChaos,
                (_, true) => Class::Periodic(12),
            };
            assert_eq!(found.class, Some(class), "{}", found.reason);
            assert_eq!(found.status, Status::Ok, "{}", found.reason);
            let lyapunov = found.lyapunov.unwrap();
            match chaos.averages_before_exit {
                // The properties of the chaos are kept if the results of the point are those of the orbit.
                Some(left) => {
                    let [lambda, error] = left.lambda;
                    assert!(
                        all && (lambda - 0.22).abs() < 0.02 + 4.0 * error,
                        "{left:?}"
                    );
                    assert_eq!(lyapunov.method, LyapunovMethod::Multipliers);
                    assert!(found.reason.contains("left chaos; its mean life is"));
                }
                None => {
                    let lambda = lyapunov.exponents[0];
                    assert!(!all && (lambda - 0.22).abs() < 0.04, "{lambda}");
                }
            }
            if chaos.exits > 0 {
                let ended_on = format!("periodic 12 ({})", chaos.exits);
                assert_eq!(chaos.ended_on, Some(ended_on));
            }
            let (low, high) = chaos.interval();
            intervals += 1;
            held += u32::from(low <= life && high.is_none_or(|high| life <= high));
        }
    }
    println!("{held} of {intervals} intervals hold the life");
    assert!(
        intervals >= 20 && 20 * held >= 17 * intervals,
        "{held} of {intervals}"
    );
}

/// A motion that settles at once was never chaotic.
#[test]
fn an_orbit_has_no_life_of_chaos() {
    let found = ask(&oscillator(20.0), &questions(160_000, usual()));
    assert!(
        matches!(found.class, Some(Class::Periodic(_))),
        "{}",
        found.reason
    );
    assert_eq!((found.chaos, found.evidence), (None, None));
}

#[test]
fn an_error_out_of_reach_ends_the_point_with_the_cycles_that_it_takes() {
    let asked = LyapunovConfig {
        stop_at_stderr: Some(1e-4),
        ..LyapunovConfig::default()
    };
    let found = ask(&oscillator(27.0), &questions(160_000, asked));
    let ended = (found.status, found.class);
    assert_eq!(ended, (Status::NotConverged, Some(Class::Chaotic)));
    let measured = found.measured_cycles;
    assert!(measured < 2 * FIRST_LOOK, "{measured}: one look is enough");
    let (_, takes) = found.reason.split_once("this would take about ").unwrap();
    let takes: f64 = takes.split(' ').next().unwrap().parse().unwrap();
    let needed = measured as f64 * (found.lyapunov.unwrap().stderr() / 1e-4).powi(2);
    assert!((takes / needed - 1.0).abs() < 0.1, "{takes} {needed}");
}

/// Below the first look one trajectory is measured: a survey accepts this, and reports its errors as not verified.
#[test]
fn few_cycles_are_for_surveys() {
    let model = oscillator(27.0);
    for (effort, status) in [
        (Effort::Verified, Status::NotConverged),
        (Effort::Survey, Status::Ok),
    ] {
        let asked = LyapunovConfig {
            effort,
            ..LyapunovConfig::default()
        };
        let found = ask(&model, &questions(FIRST_LOOK - 1, asked));
        let ended = (found.status, found.class);
        assert_eq!(
            ended,
            (status.clone(), Some(Class::Chaotic)),
            "{}",
            found.reason
        );
        assert_eq!(found.measured_cycles, FIRST_LOOK - 1);
        let evidence = found.evidence.unwrap();
        assert_eq!((evidence.trajectories, evidence.verified), (1, false));
        assert_eq!(evidence.rhat, None);
        let told = found
            .reason
            .contains("measured cycles that verified errors need");
        assert_eq!(told, status == Status::NotConverged, "{}", found.reason);
    }
    // A survey stops at its own first look.
    let asked = LyapunovConfig {
        stop_at_stderr: Some(0.05),
        effort: Effort::Survey,
        ..LyapunovConfig::default()
    };
    let found = ask(&model, &questions(160_000, asked));
    assert_eq!(found.status, Status::Ok, "{}", found.reason);
    assert_eq!(found.measured_cycles, Effort::Survey.first_look());
}

#[test]
fn chains_are_the_averages_of_every_trajectory() {
    let asked = LyapunovConfig {
        chains: true,
        ..usual()
    };
    let found = ask(&oscillator(27.0), &questions(160_000, asked));
    let chains = found.evidence.unwrap().chains.unwrap();
    assert_eq!(chains.lengths.len(), 8);
    let averages: f64 = chains.lengths.iter().sum();
    assert_eq!(averages as usize, chains.growth.len());
    assert_eq!(10 * chains.growth.len() as u64, found.measured_cycles);
    let lambda = found.lyapunov.unwrap().exponents[0];
    assert!((mean(&chains.growth) - lambda).abs() < 1e-12);
}

/// An undamped mode in permanent contact: a torus, whose rotation number is the natural frequency per mesh cycle.
#[test]
fn a_torus_is_found_at_the_first_look_with_its_rotation_number() {
    let (w, k) = (1.3, 4e8);
    let structure = common::structure(&[0.0], 0.0, &[w], &[w]);
    let mut drive = common::two_level_mesh(10e-6);
    drive.mesh = Division::levels(&[k], &[]);
    drive.damping = 0.0;
    drive.transmission_error = vec![MeshHarmonic::new(1, 1e-7, 0.0)];
    let mut point = common::strong_rattle();
    (point.load, point.speed) = (3.0, 1234.5);
    let model = Model::new(&structure, &drive, point).unwrap();
    let mut start = model.start(&InitialState::Static);
    start.state[0] *= 1.01;
    let start = TrajectoryState::new(&model, start.state, 0);
    let found = ask_from(&model, start, &questions(160_000, usual()));
    let ended = (found.status, found.class);
    assert_eq!(
        ended,
        (Status::Ok, Some(Class::QuasiPeriodic)),
        "{}",
        found.reason
    );
    assert_eq!((found.events_per_cycle, found.chaos), (Some(0.0), None));
    assert_eq!(found.measured_cycles, 2000);
    let lyapunov = found.lyapunov.unwrap();
    assert_eq!(lyapunov.method, LyapunovMethod::Birkhoff);
    assert!(lyapunov.exponents[0].abs() <= lyapunov.stderr() && lyapunov.stderr() < 1e-4);
    let turns = (k * w * w).sqrt() * model.period() / TAU;
    let folded = (turns - turns.round()).abs();
    let rotation = found.evidence.unwrap().rotation_number.unwrap();
    assert!((rotation - folded).abs() < 1e-8, "{rotation} {folded}");
}

/// Two points with lasting chaos and two with transient chaos, with eight trajectories each, through the program.
fn place() -> Place {
    let text = MANIFEST
        .replace("amplitude = 27,", "amplitude = 1,")
        .replace(
            "[grid]\n",
            "[grid]\n\"excitation.torque_ripple.0.amplitude\" = { values = [27, 25.98, 27.5, 25.967] }\n",
        )
        .replace("twin = false", "chains = true")
        .replace("[analyses]\n", "[analyses]\npoincare = { samples = 20 }\n");
    for changed in ["amplitude = 1,", "values = [27,", "chains", "samples"] {
        assert!(text.contains(changed), "{changed}");
    }
    let place = Place::new(&text);
    let modal = include_str!("../manifests/impact.modal.toml");
    fs::write(place.path("impact.modal.toml"), modal).unwrap();
    place
}

#[test]
fn threads_shards_and_interruptions_change_nothing_of_eight_trajectories() {
    const TABLES: [&str; 2] = ["points.parquet", "poincare.parquet"];
    let place = place();
    let one = place.whole("one", &["--threads", "1"]);
    assert_same(&TABLES, &one, &place.whole("two", &["--threads", "2"]));
    for shard in ["1/2", "2/2"] {
        place.whole("parts", &["--shard", shard]);
    }
    assert_same(&TABLES, &one, &place.path("parts"));

    // Killed after its first point, which contains thousands of averages.
    let mut child = place
        .command("cut", &["--threads", "1", "--quiet"])
        .spawn()
        .unwrap();
    let journal = place.path("cut").join(".journal");
    let patience = Instant::now();
    while fs::metadata(&journal).map_or(0, |found| found.len()) < 10_000 {
        assert!(patience.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!place.path("cut/points.parquet").exists());
    place.whole("cut", &[]);
    assert!(place.record("cut")["totals"]["resumed"].as_u64().unwrap() > 0);
    assert_same(&TABLES, &one, &place.path("cut"));

    let points = ResultTable::read(&one, TableKind::Points).unwrap();
    let (cycles, exits) = (
        points.u64("chaos_cycles").unwrap(),
        points.u64("chaos_exits").unwrap(),
    );
    let trajectories = points.u64("trajectories").unwrap();
    for row in [0, 2] {
        assert_eq!((trajectories[row], exits[row]), (Some(8), Some(0)));
        assert!(cycles[row] >= Some(FIRST_LOOK));
    }
    assert!(exits[1].max(exits[3]) > Some(1), "{exits:?}");
}
