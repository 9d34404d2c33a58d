//! How does a mesh from the drawing behave away from its mean load? Does its force jump, and does a quasi-static mesh
//! cycle at constant torque conserve energy?
//!
//! Oh, Grosh & Barber (2005, "Energy conservation and the dynamic response of a pair of gears with time-varying
//! stiffness") require that a mesh law agrees with frictionless gears that rotate slowly under a constant torque: its
//! work is the change of the energy stored in the teeth. A pair that comes into contact without force stores nothing at
//! that time. A jump of the stiffness under the load F changes `F²/(2k)` instantly without a source of energy.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use common::advance::{advance, advance_with, volterra};
use gearatlas::manifest;
use gearatlas::model::{InitialState, Model, Segment};
use gearatlas::numerics::legendre::{at_end, at_start};
use gearatlas::propagate::{Observer, Window};
use std::path::Path;

/// Spur gears of 18 and 35 teeth that whine.
const WHINE: &str = r#"
[job]
name = "whine"
[model]
kind = "torsional"
[gear]
teeth = [18, 35]
module = "3 mm"
face_width = "30 mm"
body_length = ["30 mm", "30 mm"]
bore = "20 mm"
rated_torque = "10 N*m"
thinning = "60 um"
[shafts]
density = "7850 kg/m^3"
span = "150 mm"
overhang = "50 mm"
[shafts.pinion]
diameter = "20 mm"
end_inertia = "5e-3 kg*m^2"
[shafts.wheel]
diameter = "20 mm"
end_inertia = "4.5e-3 kg*m^2"
[shafts.bearings]
x = "1.9e8 N/m"
y = "1.9e8 N/m"
tilt = "1e4 N*m/rad"
axial = ["1e8 N/m", 0]
[mesh]
stiffness = "table"
contact_damping = 0.05
[grid]
torque = "4.47 N*m"
speed = "40 Hz"
[run]
cycles = 800
"#;

/// The drive with a resolution of its mesh (`None`: the default), and further keys in `[gear]` and `[mesh]`.
fn model(resolution: Option<&str>, gear: &str, mesh: &str) -> Model {
    let resolution = resolution.map_or(String::new(), |law| format!("resolution = \"{law}\"\n"));
    let text = WHINE
        .replace("[gear]\n", &format!("[gear]\n{gear}\n"))
        .replace("[mesh]\n", &format!("[mesh]\n{resolution}{mesh}\n"));
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    common::parts().model(&job.points.at(0)).unwrap()
}

/// Stiffness and error of the drive flanks before and after every border of the mesh cycle.
fn borders(model: &Model) -> Vec<[[f64; 2]; 2]> {
    let segments = &model.contacts[0].cycles[0].segments;
    let at = |segment: &Segment, x: f64| [segment.stiffness.at(x), segment.error.at(x)];
    (segments.iter().zip(segments.iter().cycle().skip(1)))
        .map(|(before, behind)| [at(before, 1.0), at(behind, -1.0)])
        .collect()
}

/// Mean mesh force \[N\].
fn load() -> f64 {
    4.47 / (0.5 * 18.0 * 3e-3 * 20f64.to_radians().cos())
}

/// Largest jump of the force at the borders of the cycle, for deflections with forces from zero to twice the mean,
/// relative to the mean; and largest jump of the energy stored under the mean, relative to its mean.
fn jumps(model: &Model) -> [f64; 2] {
    let mean = load();
    let borders = borders(model);
    let force = borders.iter().flat_map(|[before, behind]| {
        [0.0, 0.5, 1.5, 2.0].map(|part| {
            let deflection = before[1] + part * mean / before[0];
            (behind[0] * (deflection - behind[1]) / mean - part).abs()
        })
    });
    let stored = |k: f64| 0.5 * mean * mean / k;
    let all: f64 = borders.iter().map(|[_, behind]| stored(behind[0])).sum();
    let scale = all / borders.len() as f64;
    let energy = borders
        .iter()
        .map(|[before, behind]| (stored(behind[0]) - stored(before[0])).abs() / scale);
    [force.fold(0.0, f64::max), energy.fold(0.0, f64::max)]
}

/// By default, neither force nor stored energy jumps over a mesh cycle, for flanks of every kind; with the tangent at
/// the mean load they do.
#[test]
fn no_pair_takes_hold_without_force() {
    let relief = "tip_relief = { amount = \"4 um\", length = \"1.5 mm\" }";
    for (name, gear, mesh, bound) in [
        ("spur", "", "", 1e-5),
        ("spur, friction", "", "friction = 0.05", 1e-5),
        ("spur, course", "", "stiffness = \"continuous\" #", 1e-5),
        ("relieved", relief, "", 1e-5),
        ("askew", "", "misalignment = \"0.1 mrad\"", 1e-3),
        (
            "slices",
            "",
            "misalignment = \"0.1 mrad\"\nface = \"independent\"",
            1e-5,
        ),
        ("crowned", "lead_crowning = \"3 um\"", "", 1e-3),
        ("helical", "helix_angle = \"15 deg\"", "", 1e-2),
    ] {
        let mesh = mesh.replace("stiffness = \"continuous\" #", "contact = \"linear\"");
        let [law, tangent] = [None, Some("mean_load")].map(|law| jumps(&model(law, gear, &mesh)));
        println!(
            "{name}: jumps of force {:.1e}, of energy {:.1e}; tangent {:.1e}, {:.1e}",
            law[0], law[1], tangent[0], tangent[1]
        );
        assert!(law[0] < bound && law[1] < bound, "{name}: {law:?}");
        if name != "helical" {
            assert!(
                tangent[0] > 0.02 && tangent[1] > 0.02,
                "{name}: {tangent:?}"
            );
        }
    }
}

/// Under a constant torque teeth in slow rotation follow `x = b + e + F/k`. Torque, error and stiffness exchange the
/// stored energy. Over a cycle the torque does no work, and the sum of the work of varying stiffness and error within
/// segments is zero, so that none comes from their borders.
#[test]
fn a_quasi_static_cycle_keeps_its_energy() {
    let supplied = |law: Option<&str>| {
        let model = model(law, "", "");
        let mean = load();
        let segments = &model.contacts[0].cycles[0].segments;
        // ∫ (½ k' (F/k)² − F e') over the segments; the stretch under the mean is F/k.
        let work: f64 = (segments.iter())
            .map(|segment| {
                let [k, e] = [-1.0, 1.0].map(|x| [segment.stiffness.at(x), segment.error.at(x)]);
                0.5 * mean * mean * (k[0].recip() - e[0].recip()) + mean * (k[1] - e[1])
            })
            .sum();
        let place = |[k, e]: [f64; 2]| e + mean / k;
        let borders = borders(&model);
        let steps = borders
            .iter()
            .map(|[before, behind]| (place(*behind) - place(*before)).abs());
        let places: Vec<f64> = borders.iter().map(|[_, behind]| place(*behind)).collect();
        let highest = places.iter().copied().fold(f64::MIN, f64::max);
        (
            steps.fold(0.0, f64::max) / highest,
            work.abs() / (mean * highest),
        )
    };
    let (step, work) = supplied(None);
    println!("static course steps by {step:.1e}, energy from nowhere {work:.1e}");
    assert!(step < 1e-5 && work < 1e-6, "{step} {work}");
}

/// The largest change of the mesh force between a window and the next, and its extremes \[N\].
#[derive(Default)]
struct Jumps {
    last: Option<f64>,
    largest: f64,
    extremes: Option<[f64; 2]>,
}

impl Observer for Jumps {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let series: [f64; 24] =
            std::array::from_fn(|n| window.force.get(n).copied().unwrap_or(0.0));
        let [start, end] = [at_start(&series), at_end(&series)];
        if let Some(last) = self.last.replace(end) {
            self.largest = self.largest.max((start - last).abs());
        }
        let [least, most] = self.extremes.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
        self.extremes = Some([least.min(start).min(end), most.max(start).max(end)]);
    }
}

/// A drive that whines: its force is continuous with pairs and by default; the extremes are nearly those of the pairs.
#[test]
fn whine_has_a_continuous_force() {
    let [default, tangent, pairs] = [None, Some("mean_load"), Some("pairs")].map(|law| {
        let model = model(law, "", "");
        let kernel = volterra(&model);
        let start = advance(&kernel, &model.start(&InitialState::Static), 400);
        let mut seen = Jumps::default();
        advance_with(&kernel, &start, 2, &mut seen);
        println!(
            "{law:?}: force {:?} N, largest jump {:.1e} N",
            seen.extremes.unwrap(),
            seen.largest
        );
        seen
    });
    assert!(default.largest < 1e-3, "{}", default.largest);
    assert!(pairs.largest < 1.0 && tangent.largest > 10.0);
    let [own, exact] = [&default, &pairs].map(|seen| seen.extremes.unwrap());
    for (own, exact) in own.iter().zip(exact) {
        assert!((own / exact - 1.0).abs() < 0.15, "{own} {exact}");
    }
}
