//! Planetary sets with different driving and fixed members, and with other parts of a train.

use crate::planetary::{
    Plane, Set, frequencies_without, in_contact, job, model, of_train, refusal,
};
use gearatlas::manifest::{self, StructureSource};
use gearatlas::model::{InitialState, Model};
use gearatlas::shaft::TrainDrive;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

/// The shafts of sun, carrier and ring.
const SHAFTS: [&str; 3] = ["input", "carrier", "annulus"];

/// A set with its driving, driven and fixed members: 0 the sun, 1 the carrier, 2 the ring.
fn text(set: &Set, [driver, driven, held]: [usize; 3]) -> String {
    let name = |member: usize| format!("name = \"{}\"\n", SHAFTS[member]);
    set.text()
        .replace("\noutput = 1", "")
        .replace(
            "[\"annulus\", \"housing\"]",
            &format!("[\"{}\", \"housing\"]", SHAFTS[held]),
        )
        .replacen(&name(driven), &format!("{}output = 1\n", name(driven)), 1)
        .replacen(
            "[train]\n",
            &format!("[train]\ndriver = \"{}\"\n", SHAFTS[driver]),
            1,
        )
}

pub fn train(text: &str) -> Arc<TrainDrive> {
    match &job(text).points.at(0).model.source {
        StructureSource::Train(train) => train.clone(),
        _ => unreachable!(),
    }
}

/// Speeds of sun, carrier and ring in units of the driver's.
fn speeds(text: &str) -> [f64; 3] {
    let all = train(text).body_speeds().unwrap();
    SHAFTS.map(|shaft| all.iter().find(|(name, _)| name == shaft).unwrap().1)
}

/// Forces of all meshes at rest, drive flanks positive \[N\].
pub fn at_rest(model: &Model) -> Vec<f64> {
    let start = model.start(&InitialState::Static);
    let segments = model.segments_at(0, 0.0);
    let forces = segments
        .iter()
        .zip(&model.contacts)
        .map(|(segment, contact)| {
            let (deflection, _) = model.deflection_on(segment, 0, &start.state, 0.0);
            segment.stiffness_at(0.0) * (contact.side * deflection - contact.half_gap).max(0.0)
        });
    let forces: Vec<f64> = forces.collect();
    forces
        .chunks_exact(2)
        .map(|pair| pair[0] - pair[1])
        .collect()
}

/// For any driving and fixed member: torques have the ratio `z_s : z_r : −(z_s + z_r)` and balance, and so does power.
#[test]
fn any_member_may_drive() {
    let set = Set::lin_parker(3);
    let [zs, _, zr] = set.teeth.map(f64::from);
    let teeth = [zs, -(zs + zr), zr];
    let [_, _, ring] = set.base_radii();
    for roles in [
        [0, 1, 2],
        [1, 0, 2],
        [1, 2, 0],
        [2, 1, 0],
        [0, 2, 1],
        [2, 0, 1],
    ] {
        let [driver, driven, held] = roles;
        let text = text(&set, roles);
        let speeds = speeds(&text);
        assert_eq!((speeds[driver].abs(), speeds[held]), (1.0, 0.0));
        let willis = zs * speeds[0] + zr * speeds[2] - (zs + zr) * speeds[1];
        let model = model(&job(&text));
        // Without backlash the angle follows from the shifts, apart from their small safety backlash.
        let angle = train(&text).pair.operating_pressure_angle().unwrap();
        let sun = set.radius * zs / (zs + f64::from(set.teeth[1])) * angle.cos();
        // In the carrier's frame, all teeth of the sun pass a mesh per relative revolution.
        let rolling = speeds[0] - speeds[1];
        let cycles = model.period() * zs * rolling * set.speed / TAU - 1.0;
        let forces = at_rest(&model);
        let turned = |radius: f64, forces: &[f64]| radius * forces.iter().sum::<f64>();
        let mut torques = [turned(sun, &forces[..3]), 0.0, turned(ring, &forces[3..])];
        torques[1] = -torques[0] - torques[2];
        let drives = torques[driver] * speeds[driver] / 100.0 - 1.0;
        let ratios = teeth.map(|z| torques[driver] * z / teeth[driver]);
        let off = torques
            .iter()
            .zip(ratios)
            .map(|(a, b)| (a - b).abs() / b.abs());
        let off = off.fold(0.0, f64::max);
        let power: f64 = torques.iter().zip(speeds).map(|(a, b)| a * b).sum::<f64>() / 100.0;
        println!(
            "{} drives {}, {} held: speeds {speeds:?}, torques {torques:?}, off {off:.1e}, driver {drives:.1e}, power {power:.1e}",
            SHAFTS[driver], SHAFTS[driven], SHAFTS[held]
        );
        assert!(willis.abs() < 1e-12 && cycles.abs() < 1e-14 && rolling > 0.0);
        assert!(off < 1e-12 && drives.abs() < 1e-12 && power.abs() < 1e-12);
        // If the sun drives, its drive flanks carry load; if it is driven or held by the carrier, its coast flanks.
        assert!(forces[..3].iter().all(|force| (force * torques[0]) > 0.0));
    }
}

/// A set with a driving carrier equals one with a backward load on the sun.
#[test]
fn a_carrier_that_drives_is_a_sun_that_brakes() {
    let set = Set {
        gyroscopic: true,
        ..Set::lin_parker(3)
    };
    let ratio = 24.0 / 120.0;
    let carrier = text(
        &Set {
            speed: ratio * set.speed,
            ..set.clone()
        },
        [1, 0, 2],
    );
    let sun = text(&set, [0, 1, 2]).replace("load = 1\n", &format!("load = {}\n", -ratio));
    let models = [carrier, sun].map(|text| model(&job(&text)));
    let [one, other] = models.each_ref().map(at_rest);
    assert!((models[0].period() / models[1].period() - 1.0).abs() < 1e-14);
    for (a, b) in one.iter().zip(&other) {
        println!("{a} {b}");
        assert!((a / b - 1.0).abs() < 1e-9);
    }
}

/// A fixed member cannot drive.
#[test]
fn a_driver_that_is_held_is_refused() {
    let set = Set::lin_parker(3);
    let said = refusal(&text(&set, [2, 1, 2]));
    assert!(
        said.contains("`annulus` is driven, but its `motion` prevents"),
        "{said}"
    );
}

/// A set with a fixed carrier, and a bearing of the sun that differs in x and y.
fn star(set: &Set) -> String {
    let whole = text(set, [0, 2, 1]);
    let (before, rest) = whole
        .split_once("[[train.shaft]]\nname = \"housing\"")
        .unwrap();
    let (_, after) = rest.split_once("[[train.planetary]]").unwrap();
    // The fixed carrier has no degrees of freedom.
    let modes = |less: usize| format!("modes = {}", 6 * (3 + set.planets) - less);
    format!("{before}[[train.planetary]]{after}")
        .replacen(&modes(0), &modes(6), 1)
        .replacen(
            "name = \"carrier\"\n",
            "name = \"carrier\"\nmotion = \"none\"\n",
            1,
        )
        .replacen(
            "x = 1e8, y = 1e8, axial = 1e7",
            "x = 1.3e8, y = 0.6e8, axial = 1e7",
            1,
        )
}

/// The star set as a plain train: shafts with axes in space, no carrier, and the meshes one by one.
fn plain(set: &Set) -> String {
    let whole = star(set);
    let (before, rest) = whole.split_once("[[train.planetary]]").unwrap();
    let (planets, after) = rest.split_once("[[train.mesh]]").unwrap();
    let (mesh, end) = after.split_once("[mesh]").unwrap();
    let (first, carrier) = before
        .split_once("[[train.shaft]]\nname = \"carrier\"")
        .unwrap();
    let (_, others) = carrier.split_once("[[train.shaft]]").unwrap();
    let value = |key: &str| {
        let found = planets
            .lines()
            .find_map(|line| line.strip_prefix(&format!("{key} = ")));
        found.unwrap().to_owned()
    };
    let keys = [
        "teeth",
        "module",
        "width",
        "pressure_angle",
        "profile_shift",
        "body",
    ];
    let gear = keys.map(|key| format!("{key} = {}", value(key))).join(", ");
    let mut out = format!("{first}[[train.shaft]]{others}").replace("\"planet\"]", "\"planet 1\"]");
    for planet in 0..set.planets {
        let (sin, cos) = (TAU * planet as f64 / set.planets as f64).sin_cos();
        let name = planet + 1;
        let pin = set.planet.0[2];
        out += &format!(
            "[[train.shaft]]\nname = \"pin {name}\"\norigin = [{:e}, {:e}, 0]\ngears = [{{ name = \"planet {name}\", at = 0, {gear} }}]\n\
             bearings = [{{ at = 0, x = {pin:e}, y = {pin:e}, axial = 1e7, tilt = 1e4 }}]\n",
            set.radius * cos,
            set.radius * sin
        );
    }
    let law = "half_gap = \"20 um\"\nstiffness = 5e8\ndamping = 300\n";
    for planet in 2..=set.planets {
        out += &format!("[[train.mesh]]\ngears = [\"sun\", \"planet {planet}\"]\n{law}");
    }
    for planet in 1..=set.planets {
        out += &format!(
            "[[train.mesh]]{}",
            mesh.replace("\"planet\"", &format!("\"planet {planet}\""))
        );
    }
    format!("{out}[mesh]{end}")
}

/// A change of the manifests of a set and of its plain train.
type Change<'a> = &'a dyn Fn(String) -> String;

/// With a fixed carrier the set is a plain train, which allows unequal bearings, rolling elements, stops across the
/// axis and a housing.
#[test]
fn a_set_whose_carrier_is_held_is_a_plain_train() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("housing-star");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(
        folder.join("ring.toml"),
        "mass = [[3, 0], [0, 4]]\nstiffness = [[3e8, -1e8], [-1e8, 2e8]]\n\
         [[node]]\nname = \"seat\"\nposition = [0, 0, 0]\nfreedoms = [\"x\", \"y\"]\n",
    )
    .unwrap();
    let ball = "ball = { count = 9, diameter = \"12 mm\", pitch_diameter = \"60 mm\", clearance = \"5 um\" }";
    let of_ring = "x = 1e8, y = 1e8, axial = 1e7";
    let unequal = |text: String| text;
    let balls = |text: String| text.replace("x = 1.3e8, y = 0.6e8", ball);
    let housed = |text: String| {
        let at = text.find("\"annulus\"").unwrap();
        let at = at + text[at..].find(of_ring).unwrap();
        let (before, after) = text.split_at(at);
        format!("{before}housing = \"seat\", {after}\n[train.housing]\nfile = \"ring.toml\"\n")
    };
    let stopped = |text: String| {
        text + "[[train.stop]]\nshaft = \"input\"\nat = 0\ndirection = [1, 0, 0]\ngap = \"1 um\"\nstiffness = 1e8\n"
    };
    // With one planet the sun loads its bearing.
    let cases: [(&str, usize, Change<'_>); 4] = [
        ("unequal", 3, &unequal),
        ("balls", 1, &balls),
        ("housing", 3, &housed),
        ("stop", 1, &stopped),
    ];
    for (name, planets, change) in cases {
        let set = Set::lin_parker(planets);
        let models = [star(&set), plain(&set)].map(|text| {
            let read = manifest::parse(&change(text), "test.toml", &folder);
            model(&read.unwrap_or_else(|errors| panic!("{name}: {errors}")))
        });
        let found = models.each_ref().map(in_contact);
        assert_eq!(found[0].len(), found[1].len());
        let apart = (found[0].iter().zip(&found[1])).map(|(a, b)| (a / b - 1.0).abs());
        let apart = apart.fold(0.0, f64::max);
        let rest = models.each_ref().map(at_rest);
        let forces = (rest[0].iter().zip(&rest[1])).map(|(a, b)| (a / b - 1.0).abs());
        let forces = forces.fold(0.0, f64::max);
        println!(
            "{name}: {} frequencies, {apart:.1e} apart, forces {forces:.1e}",
            found[0].len()
        );
        assert!(apart < 1e-9 && forces < 1e-9);
    }
}

/// If the carrier rotates, parts that are not isotropic are refused, with the reason and a remedy.
#[test]
fn what_the_turning_frame_would_see_turn_is_refused() {
    let good = Set::lin_parker(3).text();
    let stop = "[[train.stop]]\nshaft = \"input\"\nat = 0\ndirection = [1, 0, 0]\ngap = \"1 um\"\nstiffness = 1e8\n";
    let said = refusal(&(good.clone() + stop));
    assert!(
        said.contains("acts across the axis") && said.contains("hold the carrier"),
        "{said}"
    );
    // Along the axis a stop is the same in every frame.
    job(&(good + &stop.replace("[1, 0, 0]", "[0, 0, 1]")));
}

/// Bearings of the stage before a set: unequal, because it is in the frame of space \[N/m\].
const BEARINGS: [f64; 2] = [2e8, 0.7e8];

/// Twist of the coupling after the stage \[N m/rad\].
const TWIST: f64 = 3e5;

/// Masses \[kg\] and inertias \[kg m²\] of pinion and wheel of the stage.
const BODIES: [[f64; 2]; 2] = [[0.5, 2e-4], [3.0, 8e-3]];

/// A set after a stage of 20 and 60 teeth, whose wheel is coupled to the sun.
fn with_stage(set: &Set) -> String {
    let shaft = |name: &str, x: f64, (gear, teeth): (&str, u32), [mass, inertia]: [f64; 2]| {
        let [kx, ky] = BEARINGS;
        format!(
            "[[train.shaft]]\nname = \"{name}\"\norigin = [{x}, 0, 0]\n\
             gears = [{{ name = \"{gear}\", at = 0, teeth = {teeth}, module = \"2 mm\", width = \"20 mm\", \
             body = {{ mass = {mass}, polar_inertia = {inertia}, transverse_inertia = {inertia} }} }}]\n\
             bearings = [{{ at = 0, x = {kx:e}, y = {ky:e}, axial = 1e7, tilt = 1e4 }}]\n"
        )
    };
    let modes = 6 * (3 + set.planets);
    set.text()
        .replace(&format!("modes = {modes}"), &format!("modes = {}", modes + 12))
        .replacen("[train]\n", "[train]\ndriver = \"motor\"\n", 1)
        .replacen(
            "[[train.planetary]]\n",
            &format!(
                "{}{}[[train.coupling]]\nshafts = [\"second\", \"input\"]\nat = [0, 0]\n\
                 twist = {TWIST:e}\n[[train.mesh]]\ngears = [\"pinion\", \"wheel\"]\nhalf_gap = \"20 um\"\n\
                 stiffness = {:e}\ndamping = 300\n[[train.planetary]]\n",
                shaft("motor", 0.08, ("pinion", 20), BODIES[0]),
                shaft("second", 0.0, ("wheel", 60), BODIES[1]),
                set.stiffness
            ),
            1,
        )
}

/// Frequencies of a set after a stage by hand \[Hz\]: the plane of the set in the frame of the carrier, then x, y and
/// rotation of pinion and wheel in the frame of space.
fn with_stage_by_hand(set: &Set) -> Vec<(f64, f64)> {
    let plane = Plane::of(set);
    let n = plane.mass.nrows();
    let grown = |own: &DMatrix<f64>| own.clone().resize(n + 6, n + 6, 0.0);
    let [mut mass, mut stiffness, turning] =
        [&plane.mass, &plane.stiffness, &plane.turning].map(grown);
    for (gear, [m, inertia]) in BODIES.into_iter().enumerate() {
        let at = n + 3 * gear;
        for axis in 0..2 {
            mass[(at + axis, at + axis)] = m;
            stiffness[(at + axis, at + axis)] = BEARINGS[axis];
        }
        mass[(at + 2, at + 2)] = inertia;
    }
    // The wheel rotates forwards with the sun; the pinion rotates backwards, and its teeth move upwards at the mesh.
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let mut mesh = DVector::zeros(n + 6);
    let line = [-sin, cos, -0.02 * cos, sin, -cos, -0.06 * cos];
    mesh.rows_mut(n, 6).copy_from_slice(&line);
    let mut twist = DVector::zeros(n + 6);
    (twist[2], twist[n + 5]) = (-1.0, 1.0);
    stiffness += set.stiffness * &mesh * mesh.transpose() + TWIST * &twist * twist.transpose();
    for [drive, _] in &plane.flanks {
        let drive = drive.clone().resize_vertically(n + 6, 0.0);
        stiffness += set.stiffness * &drive * drive.transpose();
    }
    let mut neutral = plane.neutral.resize_vertically(n + 6, 0.0);
    (neutral[n + 2], neutral[n + 5]) = (-3.0, 1.0);
    assert!((mesh.dot(&neutral)).abs() < 1e-15);
    frequencies_without(&neutral, mass, &stiffness, turning)
}

/// A stage in the frame of space drives a set in the frame of its carrier: frequencies, speeds and torques.
#[test]
fn a_stage_beside_a_set_keeps_the_frame_of_space() {
    for (gyroscopic, speed) in [(false, 100.0), (true, 600.0), (true, 2000.0)] {
        let set = Set {
            gyroscopic,
            speed,
            ..Set::lin_parker(4)
        };
        // The speed of a point is that of the motor.
        let text = with_stage(&set).replace(
            &format!("speed = {speed:e}"),
            &format!("speed = {:e}", 3.0 * speed),
        );
        assert_eq!(
            speeds(&text).map(|own| (own * 3.0 * 5.0).round()),
            [5.0, 1.0, 0.0]
        );
        let found = of_train(
            &Set {
                speed: 3.0 * speed,
                ..set.clone()
            },
            &text,
        );
        let exact = with_stage_by_hand(&set);
        assert_eq!(exact.len(), 3 * (3 + set.planets) + 5);
        let off = exact.iter().map(|(frequency, _)| {
            let near = found.iter().map(|own| (own.0 / frequency - 1.0).abs());
            near.fold(f64::INFINITY, f64::min)
        });
        let off = off.fold(0.0, f64::max);
        let forces = at_rest(&model(&job(&text)));
        let stage = forces[set.planets] * 0.02 * 20_f64.to_radians().cos();
        let sun: f64 = forces[..set.planets].iter().sum::<f64>() * set.base_radii()[0];
        println!(
            "{speed} rad/s: {} modes, off {off:.1e}, {stage} N m, {sun} N m",
            exact.len()
        );
        assert!(off < 1e-9);
        assert!((stage / 100.0 - 1.0).abs() < 1e-9 && (sun / 300.0 - 1.0).abs() < 1e-9);
    }
}

/// Gears beside a set need a separate shaft, and planets are the first mesh.
#[test]
fn gears_on_shafts_that_turn_with_the_frame_are_refused() {
    let good = with_stage(&Set::lin_parker(3));
    for (from, to, told) in [
        (
            "twist = 3e5\n",
            "twist = 3e5\nradial = 1e6\n",
            "gear `wheel` meshes with no planet, but its shaft `second`",
        ),
        (
            "driver = \"motor\"\n",
            "driver = \"housing\"\n",
            "`housing` is driven",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        let said = refusal(&good.replacen(from, to, 1));
        assert!(said.contains(told), "{told}: {said}");
    }
    let [first, beside] = ["[\"sun\", \"planet\"]", "[\"pinion\", \"wheel\"]"];
    let exchanged = good
        .replace(first, "[]")
        .replace(beside, first)
        .replace("[]", beside);
    let said = refusal(&exchanged);
    assert!(
        said.contains("are the first mesh, but neither is a planet"),
        "{said}"
    );
}
