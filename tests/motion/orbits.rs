//! Are periodic orbits, stable or not, found and described correctly?

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{mean_equilibrium, volterra};
use common::relative_difference;
use gearatlas::analysis::{Bifurcation, EnergyNorm, OrbitConfig, OrbitSurvey, survey_orbits};
use gearatlas::model::{DriveShaft, InitialState, Model, TorqueRipple, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel};
use gearatlas::reference::Reference;
use std::process::Command;
use std::sync::atomic::AtomicBool;

fn one_degree(load: f64, speed: f64) -> Model {
    common::model_at(&common::one_degree(), load, speed)
}

/// A survey from the state some cycles after the equilibrium of the mean stiffness, and that state.
fn survey(model: &Model, after: u32, periods: &[u32]) -> (OrbitSurvey, TrajectoryState) {
    let kernel = volterra(model);
    let mut trajectory = mean_equilibrium(model);
    let mut workspace = kernel.workspace();
    kernel
        .advance(
            u64::from(after),
            &mut trajectory,
            &mut workspace,
            &mut (),
            &mut Counters::default(),
        )
        .unwrap();
    let config = OrbitConfig {
        periods: periods.to_vec(),
        guesses: 24,
        cycles: 600,
        floquet: true,
        returns: 3,
        states: Vec::new(),
    };
    let mut onward = trajectory.clone();
    let interrupt = AtomicBool::new(false);
    let found = survey_orbits(model, &kernel, &mut onward, &config, &interrupt).unwrap();
    (found, trajectory)
}

/// A settled motion has an orbit, and the flip that created it left the shorter one unstable.
#[test]
fn a_doubled_period_has_an_unstable_parent() {
    let model = one_degree(0.5, 590.0);
    let (found, settled) = survey(&model, 2000, &[2, 1]);
    let periods: Vec<u32> = found.orbits.iter().map(|o| o.period).collect();
    assert_eq!(periods, [1, 2], "{found:?}");
    let [parent, doubled] = [&found.orbits[0], &found.orbits[1]];
    assert!(!parent.character.stable && doubled.character.stable);
    assert_eq!(parent.character.bifurcation, Some(Bifurcation::Flip));
    assert!(parent.multipliers[0].re < -1.0 && parent.lambda > 0.0);
    assert!(doubled.lambda < 0.0);
    // The stable orbit is that of the settled motion.
    let norm = EnergyNorm::new(&model);
    let kernel = volterra(&model);
    let mut next = settled.clone();
    kernel
        .advance(
            1,
            &mut next,
            &mut kernel.workspace(),
            &mut (),
            &mut Counters::default(),
        )
        .unwrap();
    assert!(norm.distance(&next.state, &settled.state) > 1e-3 * norm.unit());
    let smallest = [&settled, &next]
        .map(|state| model.deflection(&state.state, 0.0).0)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    assert!((doubled.deflection - smallest).abs() < 1e-9 * model.half_gap);
}

/// Unstable orbits within a chaotic set: the reference confirms that they close, and no two are equal.
#[test]
fn a_chaotic_set_is_threaded_by_unstable_orbits() {
    let model = one_degree(0.05, 1200.0);
    let (found, _) = survey(&model, 200, &[1, 2, 3, 4]);
    println!("{found:#?}");
    assert!(found.orbits.len() >= 3, "{} orbits", found.orbits.len());
    let reference = Reference::new(&model);
    for orbit in &found.orbits {
        assert!(orbit.residual < 1e-11, "{orbit:?}");
        assert!(!orbit.character.stable, "chaos settles on none: {orbit:?}");
        let start = at_strobe(&model, orbit.deflection, orbit.velocity);
        let end = reference
            .advance(&start, u64::from(orbit.period))
            .unwrap()
            .end;
        let open = relative_difference(&end.state, &start.state);
        // A start with round-off error ends with an error that the orbit has amplified.
        let amplified = 1e-12 * orbit.character.kick_growth_linear.max(1.0);
        assert!(open < amplified, "open by {open:e}: {orbit:?}");
        let product: f64 = orbit.multipliers.iter().map(|m| m.norm()).product();
        assert!(product < 1.0, "a damped drive contracts volume: {orbit:?}");
    }
    for (i, a) in found.orbits.iter().enumerate() {
        for b in &found.orbits[..i] {
            let apart = (a.deflection - b.deflection).abs() / model.half_gap;
            assert!(a.period != b.period || apart > 1e-6, "{a:?} {b:?}");
        }
    }
}

/// The state of one degree of freedom with given mesh deflection and rate.
fn at_strobe(model: &Model, deflection: f64, velocity: f64) -> TrajectoryState {
    let zero = model.deflection(&[0.0, 0.0], 0.0);
    let gain = model.deflection(&[1.0, 0.0], 0.0).0 - zero.0;
    let state = vec![(deflection - zero.0) / gain, (velocity - zero.1) / gain];
    TrajectoryState::new(model, state, 0)
}

/// A kick within the margin of the event sequence grows according to the monodromy matrix.
#[test]
fn a_kick_grows_as_predicted_away_from_grazing() {
    let forty = common::model_at(&common::forty_modes(), 0.1, 700.0);
    for (name, model) in [
        ("one degree", one_degree(0.3, 600.0)),
        ("forty modes", forty),
    ] {
        let (found, _) = survey(&model, 300, &[1]);
        assert_eq!(found.orbits.len(), 1, "{name}: {found:?}");
        let orbit = &found.orbits[0];
        println!("{name}: {:?}", orbit.character);
        assert!(orbit.character.stable);
        assert!(orbit.character.grazing_margin.unwrap() > 1e-3);
        let ratio = orbit.character.kick_growth / orbit.character.kick_growth_linear;
        assert!((ratio - 1.0).abs() < 1e-3, "{name}: {ratio}");
    }
}

/// In the linear regime, the kick changes between returns by the monodromy matrix, and in the long run by the leading
/// multiplier.
#[test]
fn a_kick_is_followed_over_returns() {
    let (settled, _) = survey(&one_degree(0.3, 600.0), 300, &[1]);
    let (chaotic, _) = survey(&one_degree(0.05, 1200.0), 200, &[1, 2]);
    assert!(chaotic.orbits.iter().any(|o| o.multipliers[0].im == 0.0));
    for orbit in settled.orbits.iter().chain(&chaotic.orbits) {
        let kick = &orbit.kick;
        assert_eq!([kick.distance.len(), kick.linear.len()], [4, 4]);
        assert_eq!([kick.distance[0], kick.linear[0]], [1e-5, 1e-5]);
        assert_eq!(kick.distance[1] / 1e-5, orbit.character.kick_growth);
        assert!(orbit.character.grazing_margin.unwrap() > 1e-3);
        for (full, linear) in kick.distance.iter().zip(&kick.linear) {
            // The deviation is due to the curvature of the map, which is of the order of the distance.
            assert!(
                (full / linear - 1.0).abs() < 1e-3 + 100.0 * full,
                "{orbit:?}"
            );
        }
        let radius = orbit.multipliers[0].norm();
        let last = kick.linear[3] / kick.linear[2];
        let second = orbit.multipliers[1].norm();
        if second < 0.2 * radius {
            assert!((last / radius - 1.0).abs() < 0.2, "{last} {radius}");
        }
    }
}

/// A state on an orbit leads back to it; one that leads to none is reported with the reason.
#[test]
fn given_states_are_searched_from() {
    let model = one_degree(0.05, 1200.0);
    let (found, settled) = survey(&model, 200, &[1, 2]);
    let known = found.orbits.last().unwrap();
    let modal = |displacement: f64, velocity: f64| InitialState::Modal {
        displacement: vec![displacement],
        velocity: vec![velocity],
    };
    let [displacement, velocity] = known.start.each_ref().map(|part| part[0]);
    let config = OrbitConfig {
        periods: vec![1, known.period],
        guesses: 1,
        cycles: 1,
        floquet: false,
        returns: 1,
        states: vec![modal(displacement, velocity), modal(1e3, 0.0)],
    };
    let (kernel, interrupt) = (volterra(&model), AtomicBool::new(false));
    let again = survey_orbits(&model, &kernel, &mut settled.clone(), &config, &interrupt);
    let again = again.unwrap();
    let led = again
        .orbits
        .iter()
        .find(|o| o.state == Some(0) && o.period == known.period);
    let apart = (led.unwrap().deflection - known.deflection).abs();
    assert!(apart < 1e-9 * model.half_gap, "{again:?}");
    let missed: Vec<[u32; 2]> = again.missed.iter().map(|m| [m.state, m.period]).collect();
    assert!(
        missed.contains(&[1, 1]) && missed.contains(&[1, known.period]),
        "{missed:?}"
    );
    assert!(again.missed.iter().all(|missed| !missed.reason.is_empty()));
}

/// Motion without events: the margin contains all grazes.
#[test]
fn steady_contact_keeps_its_distance() {
    let model = one_degree(1.0, 400.0);
    let (found, _) = survey(&model, 300, &[1, 2]);
    assert_eq!(found.orbits.len(), 1);
    let orbit = &found.orbits[0];
    assert_eq!((orbit.period, orbit.character.events), (1, 0));
    let smallest = (0..=4000)
        .map(|i| i as f64 / 4000.0)
        .map(|phase| deflection_at(&model, orbit.deflection, orbit.velocity, phase))
        .fold(f64::INFINITY, f64::min);
    let margin = (smallest - model.half_gap) / model.half_gap;
    let reported = orbit.character.grazing_margin.unwrap();
    assert!((reported - margin).abs() < 1e-6, "{reported} {margin}");
}

/// The map of one mesh cycle has a fixed point, too, but the ripple of a shaft repeats later.
#[test]
fn an_orbit_in_contact_has_the_period_of_its_ripple() {
    let (mut structure, mut drive, mut point) = common::one_degree();
    structure.teeth = 40;
    structure.pinion_torque = Some(vec![10.0]);
    drive.torque_ripple = vec![TorqueRipple {
        shaft: DriveShaft::Pinion,
        order: 2.0,
        amplitude: 0.1,
        phase: 0.4,
    }];
    (point.load, point.speed) = (30.0, 400.0);
    let model = Model::new(&structure, &drive, point).unwrap();
    let (found, _) = survey(&model, 300, &[20]);
    let orbits: Vec<_> = found
        .orbits
        .iter()
        .map(|o| (o.period, o.character.events))
        .collect();
    assert_eq!(orbits, [(20, 0)]);
}

/// δ at a mesh phase, from the kernel's windows.
fn deflection_at(model: &Model, deflection: f64, velocity: f64, phase: f64) -> f64 {
    struct At {
        time: f64,
        value: f64,
    }
    impl gearatlas::propagate::Observer for At {
        const WINDOWS: bool = true;
        fn window(&mut self, w: &gearatlas::propagate::Window<'_>) {
            if (w.start..=w.start + w.duration * (1.0 + 1e-12)).contains(&self.time) {
                let x = 2.0 * (self.time - w.start) / w.duration - 1.0;
                let mut previous = 1.0;
                let mut polynomial = x;
                self.value = w.deflection[0] + w.deflection[1] * x;
                for (n, a) in w.deflection.iter().enumerate().skip(2) {
                    let n = n as f64;
                    let next = ((2.0 * n - 1.0) * x * polynomial - (n - 1.0) * previous) / n;
                    (previous, polynomial) = (polynomial, next);
                    self.value += a * next;
                }
            }
        }
    }
    let mut at = At {
        time: phase * model.period(),
        value: f64::NAN,
    };
    let kernel = volterra(model);
    let mut state = at_strobe(model, deflection, velocity);
    kernel
        .advance(
            1,
            &mut state,
            &mut kernel.workspace(),
            &mut at,
            &mut Counters::default(),
        )
        .unwrap();
    at.value
}

/// The table, through the program, for one and for two threads.
#[test]
fn orbits_are_a_table_that_threads_do_not_change() {
    let folder = tempfile::tempdir().unwrap();
    let drive = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/quickstart.toml"),
    )
    .unwrap();
    let (head, _) = drive.split_once("[analyses]").unwrap();
    assert!(head.contains("cycles = 160000"));
    let head = head.replace("cycles = 160000", "cycles = 5000");
    let manifest = folder.path().join("orbits.toml");
    let text =
        format!("{head}[analyses]\norbits = {{ periods = [1, 2], guesses = 4, cycles = 60 }}\n");
    std::fs::write(&manifest, text).unwrap();
    let mut bytes = Vec::new();
    for threads in ["1", "2"] {
        let out = folder.path().join(threads);
        let run = Command::new(env!("CARGO_BIN_EXE_atlas"))
            .arg("run")
            .arg(&manifest)
            .args(["--quiet", "--threads", threads, "--out"])
            .arg(&out)
            .output()
            .unwrap();
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        bytes.push(std::fs::read(out.join("orbits.parquet")).unwrap());
    }
    assert_eq!(bytes[0], bytes[1]);
    assert!(bytes[0].len() > 1000);
}

const OSCILLATOR: &str = concat!(
    include_str!("../manifests/oscillator.head.toml"),
    r#"
transient = 50
[grid]
load = { values = [0.05, 0.1] }
speed = 1200
[analyses.orbits]
periods = [1, 3]
guesses = 4
cycles = 100
returns = 7
states = [{ displacement = [0, 0, 1e9], velocity = [0, 0, 0] }]
"#
);

/// Output about orbits for users: `show`, its JSON, and pictures.
#[test]
fn orbits_are_shown_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), OSCILLATOR).unwrap();
    let structure = include_str!("../manifests/oscillator.modal.toml");
    std::fs::write(folder.path().join("oscillator.modal.toml"), structure).unwrap();
    let atlas = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_atlas"));
        let output = command.args(arguments).current_dir(folder.path()).output();
        let output = output.unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(matches!(output.status.code(), Some(0 | 3)), "{error}");
        String::from_utf8(output.stdout).unwrap()
    };
    atlas(&["run", "m.toml", "--quiet"]);
    let said = atlas(&["show", "results/case"]);
    for wanted in [
        "periodic orbits, at 2 points",
        "leading multiplier",
        "grazing margin",
        "where\n",
        "searches from given states that found no orbit",
    ] {
        assert!(said.contains(wanted), "{wanted}: {said}");
    }
    let json = atlas(&["show", "results/case", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let orbits = &json["orbits"];
    assert_eq!(orbits["points"], 2);
    // There are searches from one given state for two periods at two points.
    assert_eq!(orbits["missed"].as_array().unwrap().len(), 4);
    assert_eq!(orbits["missed"][0]["state"], 1);
    let listed = orbits["orbits"].as_array().unwrap();
    let counted = orbits["periods"].as_array().unwrap();
    let count: u64 = counted.iter().map(|c| c["orbits"].as_u64().unwrap()).sum();
    assert_eq!(listed.len() as u64, count);
    for counted in counted {
        let alike = |orbit: &&serde_json::Value| {
            ["period", "stable"]
                .iter()
                .all(|key| orbit[key] == counted[key])
        };
        let count = listed.iter().filter(alike).count() as u64;
        assert_eq!(counted["orbits"], count, "{counted}");
    }
    for orbit in listed {
        let leading = orbit["leading"].as_array().unwrap();
        let part = |i: usize| leading[i].as_f64().unwrap();
        let modulus = orbit["modulus"].as_f64().unwrap();
        assert!(
            (part(0).hypot(part(1)) / modulus - 1.0).abs() < 1e-9,
            "{orbit}"
        );
        assert_eq!(orbit["stable"], modulus < 1.0);
    }
    let drawn = atlas(&[
        "plot",
        "results/case",
        "--what",
        "multipliers,kicks",
        "--json",
    ]);
    let drawn: serde_json::Value = serde_json::from_str(&drawn).unwrap();
    assert_eq!(drawn["files"].as_array().unwrap().len(), 8, "{drawn}");
    for (name, wanted) in [
        ("multipliers-point=0", ["imaginary part [–]", "period 3, "]),
        (
            "kicks-point=1",
            ["distance from the orbit [", "first return × "],
        ),
    ] {
        let path = folder
            .path()
            .join(format!("results/case/pictures/{name}.svg"));
        let picture = std::fs::read_to_string(path).unwrap();
        for wanted in wanted {
            assert!(picture.contains(wanted), "{name}: {wanted}");
        }
    }
    // Pictures do not mention orbits if none were requested.
    let manifest = OSCILLATOR.split("[analyses.orbits]").next().unwrap();
    std::fs::write(folder.path().join("m.toml"), manifest).unwrap();
    atlas(&["run", "m.toml", "--quiet", "--out", "plain"]);
    let drawn = atlas(&["plot", "plain", "--json"]);
    assert!(!drawn.contains("orbits"), "{drawn}");
    assert!(!atlas(&["show", "plain"]).contains("orbit"));
}

/// The orbits that the shipped manifests state, with multipliers to the given digits.
#[test]
fn shipped_manifests_have_their_orbits() {
    let folder = tempfile::tempdir().unwrap();
    for (name, wanted) in [
        ("strong", vec![(0, 1, -2.98, 0.0), (1, 1, 0.17, 0.98)]),
        (
            "sparse",
            vec![
                (0, 2, -1.38, 0.0),
                (1, 1, -2.64, 0.0),
                (1, 2, -1.55, 0.0),
                (2, 2, -0.89, 0.375),
                (3, 1, 0.373, 0.921),
            ],
        ),
    ] {
        let manifest = format!(
            "{}/manifests/orbits/{name}.toml",
            env!("CARGO_MANIFEST_DIR")
        );
        let atlas = |arguments: &[&str]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_atlas"));
            let output = command.args(arguments).current_dir(folder.path()).output();
            let output = output.unwrap();
            assert!(output.status.success(), "{name}: {output:?}");
            output.stdout
        };
        atlas(&["run", &manifest, "--quiet", "--out", name]);
        let shown: serde_json::Value =
            serde_json::from_slice(&atlas(&["show", name, "--json"])).unwrap();
        let orbits = shown["orbits"]["orbits"].as_array().unwrap();
        for (point, period, re, im) in wanted {
            let near = |orbit: &serde_json::Value| {
                let part = |i: usize| orbit["leading"][i].as_f64().unwrap();
                (part(0) - re).abs() < 6e-3 && (part(1).abs() - im).abs() < 6e-3
            };
            let mut own = orbits
                .iter()
                .filter(|o| o["point_id"] == point && o["period"] == period);
            assert!(
                own.any(near),
                "{name} {point} {period} {re} {im}: {orbits:?}"
            );
        }
    }
}
