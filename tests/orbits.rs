//! Are periodic orbits, stable or not, found and described rightly?

#![allow(clippy::unwrap_used)]

mod common;

use atlas::analysis::{Bifurcation, EnergyNorm, OrbitQuestion, OrbitSurvey, survey_orbits};
use atlas::model::{Model, TrajectoryState};
use atlas::propagate::{Counters, Kernel};
use atlas::reference::Reference;
use common::advance::{mean_equilibrium, volterra};
use common::relative_difference;
use std::process::Command;
use std::sync::atomic::AtomicBool;

fn one_degree(load: f64, speed: f64) -> Model {
    common::model_at(&common::one_degree(), load, speed)
}

/// A survey from where the equilibrium of the mean stiffness has got to after some cycles, and where it started.
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
    let question = OrbitQuestion {
        periods: periods.to_vec(),
        guesses: 24,
        cycles: 600,
        floquet: true,
    };
    let mut onward = trajectory.clone();
    let called_off = AtomicBool::new(false);
    let found = survey_orbits(model, &kernel, &mut onward, &question, &called_off).unwrap();
    (found, trajectory)
}

/// A settled motion has its own orbit, and the flip that bore it left the shorter one unstable.
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
    // The stable one is where the motion has settled.
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

/// Unstable orbits within a chaotic set: closed by the reference, and no two the same.
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
        // A start that is known to round-off ends as far off as the orbit stretches it.
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

/// The state of one degree of freedom whose mesh deflection and rate are given.
fn at_strobe(model: &Model, deflection: f64, velocity: f64) -> TrajectoryState {
    let zero = model.deflection(&[0.0, 0.0], 0.0);
    let gain = model.deflection(&[1.0, 0.0], 0.0).0 - zero.0;
    let state = vec![(deflection - zero.0) / gain, (velocity - zero.1) / gain];
    TrajectoryState::new(model, state, 0)
}

/// A kick within the margin of the event sequence grows as the monodromy matrix says.
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

/// Motion without events: nothing grazes but what the margin says.
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

/// δ at a mesh phase, read off the kernel's windows.
fn deflection_at(model: &Model, deflection: f64, velocity: f64, phase: f64) -> f64 {
    struct At {
        time: f64,
        value: f64,
    }
    impl atlas::propagate::Observer for At {
        const WINDOWS: bool = true;
        fn window(&mut self, w: &atlas::propagate::Window<'_>) {
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
        fn event(&mut self, _: &atlas::propagate::Event) {}
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
