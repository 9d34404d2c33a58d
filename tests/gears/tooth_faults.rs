//! Single different teeth (`[[mesh.tooth_fault]]`): the sidebands of a cracked and worn tooth compared with a closed
//! form, kernels compared with one another in rattle, and refusals.

#![allow(clippy::unwrap_used)]

use crate::common;
use crate::fixtures;
use common::advance::{advance, volterra};
use common::relative_difference;
use gearatlas::analysis::{
    NvhConfig, OrderConfig, PointConfig, PointOutcome, Section, Signals, investigate,
};
use gearatlas::gear::{RootCrack, ToothForm};
use gearatlas::manifest;
use gearatlas::model::{InitialState, Model};
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::{ClosedModes, InstructionSet};
use gearatlas::reference::Extended;
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const MANIFEST: &str = include_str!("../../manifests/tiers/torsional.toml");

/// The 20/30 teeth of the manifest, without friction and errors, with one different tooth of the pinion.
fn text(fault: &str) -> String {
    MANIFEST
        .replace("friction = 0.05 ", "friction = 0 ")
        .replace("transmission_error = [{", "transmission_error = [] # [{")
        + &format!("\n[[mesh.tooth_fault]]\n{fault}\n")
}

fn model(fault: &str, speed: f64, load: f64) -> Model {
    let text = text(fault);
    let mut point = manifest::parse(&text, "m.toml", Path::new(""))
        .unwrap()
        .points
        .at(0);
    (point.speed, point.load) = (speed, load);
    common::parts().model(&point).unwrap()
}

const CRACKED: &str =
    "gear = \"pinion\"\ntooth = 4\nstiffness = 0.7\nloss = \"3 um\"\nflanks = \"drive\"";

/// One mass on a spring with steps of stiffness and gap: its motion in closed form, step by step.
struct Stepped {
    /// Relative mass \[kg\], damping \[N s/m\] and force \[N\].
    mass: f64,
    damping: f64,
    force: f64,
    /// Duration \[s\], stiffness \[N/m\] and gap \[m\] of each step.
    steps: Vec<[f64; 3]>,
}

impl Stepped {
    /// Displacement and velocity some time after a state.
    fn at(&self, [_, stiffness, gap]: [f64; 3], [x, v]: [f64; 2], time: f64) -> [f64; 2] {
        let rest = gap + self.force / stiffness;
        let half = 0.5 * self.damping / self.mass;
        let turning = (stiffness / self.mass - half * half).sqrt();
        let sine = (v + half * (x - rest)) / turning;
        let (sin, cos) = (turning * time).sin_cos();
        let decay = (-half * time).exp();
        let off = decay * ((x - rest) * cos + sine * sin);
        let speed = decay * turning * (sine * cos - (x - rest) * sin) - half * off;
        [rest + off, speed]
    }

    /// The state at the start of the periodic motion.
    fn repeated(&self) -> [f64; 2] {
        let rest = self.steps[0][2] + self.force / self.steps[0][1];
        let rounds = std::iter::repeat_n(&self.steps, 30).flatten();
        rounds.fold([rest, 0.0], |state, step| self.at(*step, state, step[0]))
    }

    /// `2/T ∫ x e^{−iωt} dt` over a period, by Simpson's rule on each step.
    fn line(&self, frequency: f64) -> Complex64 {
        let (mut state, mut begin, mut sum) = (self.repeated(), 0.0, Complex64::ZERO);
        for step in &self.steps {
            let count = 4000;
            let h = step[0] / f64::from(count);
            for k in 0..=count {
                let weight = match k {
                    0 => 1.0,
                    k if k == count => 1.0,
                    k => f64::from(2 + 2 * (k % 2)),
                };
                let time = f64::from(k) * h;
                let turned = Complex64::from_polar(weight * h / 3.0, -frequency * (begin + time));
                sum += turned * self.at(*step, state, time)[0];
            }
            state = self.at(*step, state, step[0]);
            begin += step[0];
        }
        sum * (2.0 / begin)
    }
}

/// The drive in contact with two levels of stiffness; tooth 4 is in contact in mesh cycles 3 and 4.
fn stepped(model: &Model, load: f64) -> Stepped {
    let (mean, drop) = (4e8, 0.25);
    let double = mean / (1.0 - 0.4 * drop);
    let single = double * (1.0 - drop);
    let steps = (0..20).flat_map(|cycle| {
        let (kept, lost) = if cycle == 3 || cycle == 4 { (0.85, 1.5e-6) } else { (1.0, 0.0) };
        let alone = if cycle == 3 { (0.7, 3e-6) } else { (1.0, 0.0) };
        [
            [0.6 * model.period(), kept * double, 10e-6 + lost],
            [0.4 * model.period(), alone.0 * single, 10e-6 + alone.1],
        ]
    });
    Stepped {
        mass: model.effective_mass,
        damping: 1483.0,
        force: load * 50.0 / (40e-3 * 20f64.to_radians().cos()),
        steps: steps.collect(),
    }
}

fn asked() -> PointConfig {
    let signals = Signals {
        deflection: true,
        ..Signals::NONE
    };
    PointConfig {
        point: PointSeed {
            seed: 1,
            point_id: 0,
        },
        transient: 400,
        cycles: 4000,
        settle: true,
        audit_cycles: 0,
        lyapunov: None,
        poincare_samples: 0,
        section: Section::default(),
        nvh: Some(NvhConfig {
            harmonics: 3,
            outputs: Signals::NONE,
            power: false,
            spectrum: None,
            orders: Some(OrderConfig {
                signals,
                mesh: 3,
                shafts: 45,
            }),
            stop_at_stderr: None,
        }),
    }
}

/// Amplitude and phase of every order of the pinion's shaft up to beyond the second mesh order agree.
#[test]
fn a_cracked_tooth_has_the_sidebands_of_the_closed_form() {
    let load = 2.0;
    let model = model(CRACKED, 300.0, load);
    let exact = stepped(&model, load);
    let start = model.start(&InitialState::Static);
    let never = AtomicBool::new(false);
    let found: PointOutcome =
        investigate(&model, &volterra(&model), start, &asked(), &never).unwrap();
    let largest = exact.line(TAU / model.period()).norm();
    let mut sidebands = 0;
    for multiple in 1..=45 {
        let lines = &found.orders[0].lines;
        // The orders of the shaft include those of the mesh.
        let wanted = f64::from(multiple) / 20.0;
        let line = (lines.iter())
            .find(|line| line.reference != "wheel" && (line.order - wanted).abs() < 1e-12)
            .unwrap();
        let value = Complex64::from_polar(line.amplitude, line.phase.unwrap_or(0.0));
        let known = exact.line(TAU * f64::from(multiple) / (20.0 * model.period()));
        assert!(
            (value - known).norm() < 1e-9 * largest,
            "{multiple}: {value} {known}"
        );
        sidebands += u32::from(multiple % 20 != 0 && known.norm() > 0.02 * largest);
    }
    assert!(sidebands > 20, "{sidebands}");
}

/// Kernels compared with an integrator with thirty digits, cycle by cycle through a revolution of the wheel in rattle.
#[test]
fn kernels_rattle_over_the_revolution() {
    let fault = "gear = \"wheel\"\ntooth = 30\nstiffness = 0.5";
    let text = text(fault).replace("[] # [{", "[{");
    let mut point = manifest::parse(&text, "m.toml", Path::new(""))
        .unwrap()
        .points
        .at(0);
    (point.speed, point.load) = (1200.0, 0.05);
    let model = common::parts().model(&point).unwrap();
    assert_eq!(model.base_cycles(), 30);
    let closed = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
    let mut state = advance(&volterra(&model), &model.start(&InitialState::Static), 26);
    for _ in 0..8 {
        let exact = Extended::new(&model).advance(&state, 1).unwrap();
        let modes = advance(&closed, &state, 1);
        state = advance(&volterra(&model), &state, 1);
        for found in [&state, &modes] {
            let off = relative_difference(&found.state, &exact.end().state);
            assert!(off < 1e-10, "{}: {off:e}", state.cycle);
        }
    }
}

/// A cracked tooth that is alone in contact deflects more than the others by the deflection of the crack, and less near
/// its root. Load on the coast flank closes the crack.
#[test]
fn a_crack_adds_its_deflection_on_its_flank() {
    let fault = "gear = \"pinion\"\ntooth = 4\ncrack = \"1.5 mm\"\nflanks = \"drive\"";
    let model = model(fault, 1000.0, 0.2);
    let gears = fixtures::pair([20, 30], ToothForm::default());
    let crack = RootCrack::new(&gears, 0, 1.5e-3).unwrap();
    // Stiffness of a piece of a mesh cycle, and the deflection of the crack in its middle.
    let piece = |contact: usize, cycle: u64, phase: f64| {
        let cycle = model.contacts[contact].cycle(cycle);
        let segment = cycle.segment_at(phase * cycle.period);
        (
            segment.stiffness.mean(),
            crack.at(0.5 * (segment.start + segment.end)),
        )
    };
    let [(cracked, bent), (whole, _)] = [3, 2].map(|cycle| piece(0, cycle, 0.8));
    let added = 1.0 / cracked - 1.0 / whole;
    assert!((added / bent - 1.0).abs() < 1e-12, "{added:e} {bent:e}");
    assert!(crack.at(0.1) < 0.7 * crack.at(0.8) && added > 0.02 / whole);
    // Half of the load with a neighbour: f = 1/(1 + k c/2) of half of the stiffness.
    let [(left, bent), (both, _)] = [3, 2].map(|cycle| piece(0, cycle, 0.3));
    let exact = both - 0.5 * both * (1.0 - 1.0 / (1.0 + 0.5 * both * bent));
    assert!((left / exact - 1.0).abs() < 1e-12, "{left:e} {exact:e}");
    assert!((0..20).all(|cycle| piece(1, cycle, 0.8).0 == piece(1, 0, 0.8).0));
}

/// The drive with a mesh from the drawing, of linear contact, with all pairs in one spring or each in its own.
fn drawn(resolution: &str, fault: &str) -> String {
    let law = [
        "mean_stiffness",
        "contact_ratio",
        "single_pair_drop",
        "segments",
    ];
    let text = text(fault);
    let kept = |line: &&str| !law.iter().any(|key| line.starts_with(&format!("{key} =")));
    let lines: Vec<&str> = text.lines().filter(kept).collect();
    let own = format!(
        "stiffness = \"continuous\"\nresolution = \"{resolution}\"\ncontact = \"linear\" #"
    );
    // Stiff bodies, through which pairs hardly support each other.
    (lines.join("\n"))
        .replace("stiffness = \"piecewise\"", &own)
        .replace(
            "rated_torque =",
            "bore = [\"48 mm\", \"76 mm\"]\nrated_torque =",
        )
}

fn drawn_model(resolution: &str, fault: &str) -> Model {
    let job = manifest::parse(&drawn(resolution, fault), "m.toml", Path::new("")).unwrap();
    let mut point = job.points.at(0);
    (point.speed, point.load) = (1200.0, 0.05);
    common::parts().model(&point).unwrap()
}

/// Stiffness of the springs of a flank (0 drive, 1 coast) that touch at once on sound flanks, and their smallest gap error.
fn bearing(model: &Model, flank: usize, cycle: u64, phase: f64) -> [f64; 2] {
    let flanks = model.contacts.iter().skip(flank).step_by(2);
    let springs = flanks.map(|contact| {
        let cycle = contact.cycle(cycle);
        let segment = cycle.segment_at(phase * cycle.period);
        [segment.stiffness_at(phase), segment.error_at(phase)[0]]
    });
    springs.fold([0.0, f64::INFINITY], |[sum, least], [stiffness, gap]| {
        // Off the path of contact, tip edges touch across a small gap.
        [
            sum + if gap < 1e-8 { stiffness } else { 0.0 },
            least.min(gap),
        ]
    })
}

/// A pair that is alone in contact has the same stiffness and gap, whether pairs share the load evenly or are springs. Two
/// pairs that touch together have nearly the same stiffness. Both hold on either flank, in every mesh cycle.
#[test]
fn pairs_as_springs_have_the_faults_of_shared_loads() {
    for flanks in ["drive", "coast"] {
        let flank = usize::from(flanks == "coast");
        for gear in ["pinion", "wheel"] {
            let soft = format!("gear = \"{gear}\"\ntooth = 4\nstiffness = 0.7");
            let worn = format!("{soft}\nloss = \"3 um\"\nflanks = \"{flanks}\"");
            let [alone, shared] = ["pairs", "mean_load"].map(|own| drawn_model(own, &worn));
            let [soft_alone, soft_shared] =
                ["pairs", "mean_load"].map(|own| drawn_model(own, &soft));
            let teeth = soft_alone.base_cycles() as u64;
            let (mut single, mut double, mut worn_first) = (0, 0, 0);
            for cycle in 0..teeth {
                for step in 0..20 {
                    let phase = 0.025 + 0.05 * f64::from(step);
                    let part = |model: &Model, cycle: u64| bearing(model, flank, cycle, phase)[0];
                    // Tooth 4 is not in contact ten cycles later.
                    let far = (cycle + 10) % teeth;
                    let sound = part(
                        &soft_alone,
                        if (2..=6).contains(&cycle) { far } else { cycle },
                    );
                    let [own, even] = [&soft_alone, &soft_shared].map(|model| part(model, cycle));
                    let even = even
                        / part(
                            &soft_shared,
                            if (2..=6).contains(&cycle) { far } else { cycle },
                        );
                    let own = own / sound;
                    let gaps =
                        [&alone, &shared].map(|model| bearing(model, flank, cycle, phase)[1]);
                    if (even - 0.7).abs() < 1e-9 {
                        assert!(
                            (own - 0.7).abs() < 1e-9,
                            "{flanks} {gear} {cycle} {phase}: {own}"
                        );
                        // Near the ends, the edge of a neighbour touches before the worn pair.
                        assert!(gaps[0] < 3e-6 + 1e-12, "{gaps:?}");
                        assert!((gaps[1] - 3e-6).abs() < 1e-12, "{gaps:?}");
                        single += 1;
                        worn_first += u32::from(gaps[0] > 3e-6 - 1e-12);
                    } else if even < 0.999 {
                        assert!((own - even).abs() < 0.06, "{cycle} {phase}: {own} {even}");
                        // The neighbour touches first.
                        assert!(gaps[0].abs() < 1e-12 && gaps[1] > 1e-6, "{gaps:?}");
                        double += 1;
                    } else {
                        assert!((own - 1.0).abs() < 1e-9, "{cycle} {phase}: {own}");
                    }
                }
            }
            assert!(
                single >= 6 && double >= 16 && worn_first >= 3,
                "{flanks} {gear}: {single} {double} {worn_first}"
            );
        }
    }
}

/// Springs of pairs compared with thirty digits through the cycles of a tooth that lacks more than the deflection, in
/// rattle.
#[test]
fn pairs_with_a_missing_flank_rattle_over_the_revolution() {
    let model = drawn_model(
        "pairs",
        "gear = \"pinion\"\ntooth = 4\nstiffness = 0.6\nloss = \"20 um\"",
    );
    assert_eq!(model.base_cycles(), 20);
    let mut state = advance(&volterra(&model), &model.start(&InitialState::Static), 20);
    for _ in 0..8 {
        let exact = Extended::new(&model).advance(&state, 1).unwrap();
        state = advance(&volterra(&model), &state, 1);
        let off = relative_difference(&state.state, &exact.end().state);
        assert!(off < 1e-9, "{}: {off:e}", state.cycle);
    }
}

#[test]
fn teeth_that_cannot_be_are_refused() {
    let cases = [
        (
            text("gear = \"pinion\"\ntooth = 21\nloss = 1e-6"),
            "tooth 21 of a gear with 20 teeth",
        ),
        (
            text("gear = \"pinion\"\ntooth = 2\nloss = 1"),
            "more than a module",
        ),
        (
            text("gear = \"pinion\"\ntooth = 2\nstiffness = 0"),
            "stiffness",
        ),
        (
            text("gear = \"pinion\"\ntooth = 2\ncrack = \"8 mm\""),
            "a crack of 8.0000 mm is too deep",
        ),
    ];
    for (text, said) in cases {
        let errors = manifest::parse(&text, "m.toml", Path::new("")).unwrap_err();
        assert!(errors.to_string().contains(said), "{said}: {errors}");
    }
}
