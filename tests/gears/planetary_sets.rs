//! Two planetary sets in one train: speeds, balance, frequencies by hand, rattle, and refusals.

use crate::planetary::{
    Plane, Set, frequencies_without, in_contact, job, model, of_train, refusal,
};
use crate::planetary_frames::{at_rest, train};
use crate::planetary_rattle::{compare, hardly_disturbed};
use gearatlas::shaft::{MeshLaw, TrainDrive};
use nalgebra::{DMatrix, DVector};

/// Twist of the coupling between both sets \[N m/rad\].
const TWIST: f64 = 4e5;

/// Suffix of the names of the second set.
const SECOND: &str = " b";

/// The shafts of a set.
const SHAFTS: [&str; 4] = ["input", "carrier", "annulus", "housing"];

/// The train of two sets, the carrier of the first one coupled to the sun of the second.
fn two([first, second]: [&Set; 2], twist: f64) -> String {
    let whole = first.text().replace("\noutput = 1", "");
    let (head, rest) = whole.split_once("[mesh]").unwrap();
    let whole = second.text();
    let (_, own) = whole.split_once("[[train.shaft]]").unwrap();
    let (own, _) = own.split_once("[mesh]").unwrap();
    let mut own = own.to_owned();
    for name in SHAFTS.into_iter().chain(["sun", "ring", "planet"]) {
        own = own.replace(&format!("\"{name}\""), &format!("\"{name}{SECOND}\""));
    }
    let own = own.replace(
        "[[train.planetary]]\n",
        &format!("[[train.planetary]]\nname = \"planet{SECOND}\"\n"),
    );
    // The suns' meshes have the law of the ring's.
    let (_, law) = own.split_once("[[train.mesh]]").unwrap();
    let sun = law.replace(
        &format!("[\"planet{SECOND}\", \"ring{SECOND}\"]"),
        &format!("[\"sun{SECOND}\", \"planet{SECOND}\"]"),
    );
    let modes = |set: &Set| 6 * (3 + set.planets);
    format!(
        "{head}[[train.shaft]]{own}[[train.mesh]]{sun}\
         [[train.coupling]]\nshafts = [\"carrier\", \"input{SECOND}\"]\nat = [0, 0]\ntwist = {twist:e}\n[mesh]{rest}"
    )
    .replacen(
        &format!("modes = {}", modes(first)),
        &format!("modes = {}", modes(first) + modes(second)),
        1,
    )
}

fn speeds(text: &str) -> impl Fn(&str) -> f64 {
    let all = train(text).body_speeds().unwrap();
    move |name| all.iter().find(|(own, _)| own == name).unwrap().1
}

/// A set with other teeth and three planets.
fn other() -> Set {
    Set {
        teeth: [36, 27, 90],
        ..Set::lin_parker(3)
    }
}

fn close(found: f64, exact: f64) {
    assert!((found / exact - 1.0).abs() < 1e-15, "{found} {exact}");
}

/// Willis for each set: 120 carrier = 24 sun + 96 ring, and 126 carrier = 36 sun + 90 ring.
#[test]
fn speeds_follow_from_all_teeth() {
    let text = two([&Set::lin_parker(3), &other()], TWIST);
    let speed = speeds(&text);
    close(speed("input b"), 1.0 / 5.0);
    close(speed("carrier b"), 2.0 / 35.0);
    // ω_p = ω_c − (ω_s − ω_c) z_s/z_p.
    close(speed("planet 1"), 1.0 / 5.0 - 4.0 / 5.0 * 24.0 / 36.0);
    let (sun, carrier) = (1.0 / 5.0, 2.0 / 35.0);
    close(speed("planet b 1"), carrier - (sun - carrier) * 36.0 / 27.0);
    assert_eq!([speed("annulus"), speed("annulus b")], [0.0; 2]);

    // One ring is fixed, and the first sun drives the other: 126 carrier = 36/5 + 90.
    let driven = text.replace(
        "[\"annulus b\", \"housing b\"]",
        "[\"annulus b\", \"input\"]",
    );
    close(speeds(&driven)("carrier b"), (36.0 / 5.0 + 90.0) / 126.0);

    // In a power split both suns are driven, and the first carrier rotates the second ring.
    let split = text
        .replace("[\"carrier\", \"input b\"]", "[\"input\", \"input b\"]")
        .replace(
            "[\"annulus b\", \"housing b\"]",
            "[\"annulus b\", \"carrier\"]",
        );
    close(speeds(&split)("carrier b"), (36.0 + 90.0 / 5.0) / 126.0);
}

/// The shipped gearbox has the ratio of the published teeth: 75/19 · 111/18 · 95/24.
#[test]
fn the_ratio_of_a_wind_turbine_is_that_of_its_teeth() {
    let text = include_str!("../../manifests/trains/wind-turbine.toml");
    let speed = speeds(text);
    let ratio = 75.0 / 19.0 * 111.0 / 18.0 * 95.0 / 24.0;
    println!("1 : {ratio}");
    close(speed("rotor").abs(), 1.0);
    close(speed("second carrier"), speed("first sun shaft"));
    close(speed("generator shaft"), -ratio * speed("rotor"));
}

/// Each set multiplies the torque by its ratio, and the sum of the power of all members is zero.
#[test]
fn torques_and_power_balance() {
    let sets = [Set::lin_parker(3), other()];
    let text = two([&sets[0], &sets[1]], TWIST);
    let speed = speeds(&text);
    let forces = at_rest(&model(&job(&text)));
    let own = train(&text);
    let angles = [
        own.pair.operating_pressure_angle().unwrap(),
        own.meshes[8].pressure_angle,
    ];
    assert_eq!(own.mesh_names()[9], "sun b and planet b 1");
    let mut power = 0.0;
    let mut driving = 100.0;
    // The order of meshes is that of the manifest: first the first sun's, then rings and suns of the sets.
    for (set, angle, [sun, ring], end) in [
        (&sets[0], angles[0], [0, 3], ""),
        (&sets[1], angles[1], [9, 6], SECOND),
    ] {
        let [zs, zp, zr] = set.teeth.map(f64::from);
        let radius = set.radius * zs / (zs + zp) * angle.cos();
        let sum = |from: usize| forces[from..from + 3].iter().sum::<f64>();
        let [_, _, of_ring] = set.base_radii();
        let torques = [radius * sum(sun), 0.0, of_ring * sum(ring)];
        let carrier = -torques[0] - torques[2];
        println!("{torques:?} {carrier}");
        for (found, part) in [(torques[0], zs), (torques[2], zr), (-carrier, zs + zr)] {
            assert!((found / (driving * part / zs) - 1.0).abs() < 1e-12);
        }
        let [of_sun, of_carrier] = ["input", "carrier"].map(|name| speed(&format!("{name}{end}")));
        let taken = torques[0] * of_sun + carrier * of_carrier;
        power += taken;
        assert!(taken.abs() < 1e-12 * 100.0);
        driving = -carrier;
    }
    assert!(power.abs() < 1e-12 * 100.0);
}

/// With a very soft coupling each set has its own frequencies.
#[test]
fn softly_joined_sets_are_those_alone() {
    let sets = [Set::lin_parker(4), other()];
    let joined = in_contact(&model(&job(&two([&sets[0], &sets[1]], 1e-2))));
    let mut worst = 0.0_f64;
    for set in &sets {
        for own in in_contact(&set.model())
            .into_iter()
            .filter(|own| *own > 1.0)
        {
            let near = joined.iter().map(|other| (other / own - 1.0).abs());
            worst = worst.max(near.fold(f64::INFINITY, f64::min));
        }
    }
    println!("{} frequencies, {worst:.1e}", joined.len());
    assert!(worst < 1e-6, "{worst:e}");
}

/// The plane of both sets by hand, each in the frame of its carrier, and one spring between them.
fn by_hand(sets: [&Set; 2], ratio: f64) -> Vec<(f64, f64)> {
    let planes = sets.map(Plane::of);
    let sizes = planes.each_ref().map(|own| own.mass.nrows());
    let n = sizes[0] + sizes[1];
    let join = |parts: [&DMatrix<f64>; 2]| {
        let mut out = DMatrix::zeros(n, n);
        for (part, at) in parts.into_iter().zip([0, sizes[0]]) {
            out.view_mut((at, at), part.shape()).copy_from(part);
        }
        out
    };
    let mass = join(planes.each_ref().map(|own| &own.mass));
    let mut stiffness = join(planes.each_ref().map(|own| &own.stiffness));
    let turning = join(planes.each_ref().map(|own| &own.turning));
    let mut neutral = DVector::zeros(n);
    for ((plane, set), (at, speed)) in planes.iter().zip(sets).zip([(0, 1.0), (sizes[0], ratio)]) {
        for [drive, _] in &plane.flanks {
            let size = drive.len();
            let mut felt = DVector::zeros(n);
            felt.rows_mut(at, size).copy_from(drive);
            stiffness += set.stiffness * &felt * felt.transpose();
        }
        let size = plane.neutral.len();
        neutral
            .rows_mut(at, size)
            .copy_from(&(speed * &plane.neutral));
    }
    let mut twist = DVector::zeros(n);
    (twist[5], twist[sizes[0] + 2]) = (1.0, -1.0);
    stiffness += TWIST * &twist * twist.transpose();
    frequencies_without(&neutral, mass, &stiffness, turning)
}

/// The train equals both sets assembled by hand, at rest and in two rotating frames.
#[test]
fn two_sets_are_those_of_an_assembly_by_hand() {
    for (gyroscopic, speed) in [(false, 100.0), (true, 800.0), (true, 2500.0)] {
        let first = Set {
            gyroscopic,
            speed,
            ..Set::lin_parker(4)
        };
        let second = Set {
            gyroscopic,
            speed: speed / 5.0,
            ..other()
        };
        let found = of_train(&first, &two([&first, &second], TWIST));
        let exact = by_hand([&first, &second], 1.0 / 5.0);
        let mut worst = 0.0_f64;
        for (frequency, growth) in &exact {
            assert!(growth.abs() < 1e-8 * frequency, "{frequency}: {growth}");
            let near = found.iter().map(|own| (own.0 / frequency - 1.0).abs());
            worst = worst.max(near.fold(f64::INFINITY, f64::min));
        }
        println!(
            "{speed} rad/s: {} modes in the planes, {worst:.1e}",
            exact.len()
        );
        assert_eq!(exact.len(), 3 * (7 + 6) - 1);
        assert!(worst < 1e-10, "{worst:e}");
    }
}

/// For two coupled sets in rattle, events and states agree with the reference.
#[test]
fn two_sets_rattle_as_the_reference_says() {
    for gyroscopic in [false, true] {
        let sets = ["[8e-6, 0, 3e-6]", "[0, 12e-6, 5e-6]"].map(|pins| Set {
            gyroscopic,
            speed: 800.0,
            levels: true,
            more: format!("pin_errors = {pins}"),
            ..Set::lin_parker(3)
        });
        let text = two([&sets[0], &sets[1]], TWIST);
        let model = model(&job(&text.replace("load = 1\n", "load = 0.05\n")));
        assert_eq!(model.contacts.len(), 24);
        let found = compare(&model, &hardly_disturbed(&model), 6);
        let second = found.events.iter().filter(|contact| **contact >= 12);
        let of_second = second.count();
        println!(
            "gyroscopic {gyroscopic}: {} events, {of_second} of the second set, states {:.1e} half gaps, times {:.1e} cycles",
            found.events.len(),
            found.apart,
            found.late
        );
        assert!(found.events.len() > 20 && of_second > 4);
        assert!(found.apart < 1e-10, "{:e}", found.apart);
    }
}

/// Both sets have the phases of their gears: those of the second are counted in the rolling direction of its sun.
#[test]
fn phases_are_those_of_each_set() {
    let set = Set {
        teeth: [25, 36, 98],
        ..Set::lin_parker(3)
    };
    let text = two([&set, &set], TWIST);
    let phases = |train: &TrainDrive, name: &str| -> Vec<f64> {
        let names = train.mesh_names();
        let meshes = names[1..].iter().zip(&train.meshes);
        meshes
            .filter(|(own, _)| own.starts_with(name))
            .map(|(_, mesh)| match &mesh.law {
                MeshLaw::OfFirst { phase } => *phase,
                MeshLaw::Own(flanks) => flanks[0].phase,
                MeshLaw::Drawn(drawn) => drawn.undrawn_properties.phase,
            })
            .collect()
    };
    let own = train(&text);
    let [first, second] = ["sun and", "sun b and"].map(|name| phases(&own, name));
    // With 25 teeth the phases are −1/3 and −2/3 of a cycle.
    assert_eq!(second.len(), 3);
    for (a, b) in first.iter().zip(&second[1..]) {
        assert!((a - b).abs() < 1e-12, "{first:?} {second:?}");
    }
    assert!((first[0] - 2.0 / 3.0).abs() < 1e-12 && (first[1] - 1.0 / 3.0).abs() < 1e-12);
    let [first, second] =
        ["planet 1 and ring", "planet b 1 and ring b"].map(|name| phases(&own, name));
    assert!((first[0] - second[0]).abs() < 1e-12);
    // If a second sun rolls backwards, the planets come in the other order.
    let back = text
        .replace("[\"carrier\", \"input b\"]", "[\"annulus\", \"input b\"]")
        .replace("[\"annulus\", \"housing\"]", "[\"carrier\", \"housing\"]");
    let turned = phases(&train(&back), "sun b and");
    assert!((turned[1] - 1.0 / 3.0).abs() < 1e-12 && (turned[2] - 2.0 / 3.0).abs() < 1e-12);
}

/// Two pairs of gears of different ratios between the second carrier and a layshaft.
const LOCKED: &str = "[[train.shaft]]\nname = \"layshaft\"\nmotion = \"rotation\"\norigin = [0.08, 0, 0]\ngears = [\
    { name = \"a\", at = 0, teeth = 20, module = \"2 mm\", width = \"20 mm\" }, \
    { name = \"c\", at = 0, teeth = 40, module = \"2 mm\", width = \"20 mm\" }]\n\
    [[train.shaft]]\nname = \"first\"\nmotion = \"rotation\"\n\
    gears = [{ name = \"b\", at = 0, teeth = 60, module = \"2 mm\", width = \"20 mm\" }]\n\
    [[train.shaft]]\nname = \"second\"\nmotion = \"rotation\"\n\
    gears = [{ name = \"d\", at = 0, teeth = 40, module = \"2 mm\", width = \"20 mm\" }]\n\
    [[train.coupling]]\nshafts = [\"carrier b\", \"first\"]\nat = [0, 0]\ntwist = 1e6\n\
    [[train.coupling]]\nshafts = [\"carrier b\", \"second\"]\nat = [0, 0]\ntwist = 1e6\n\
    [[train.mesh]]\ngears = [\"a\", \"b\"]\nhalf_gap = 1e-5\nstiffness = 1e8\n\
    [[train.mesh]]\ngears = [\"c\", \"d\"]\nhalf_gap = 1e-5\nstiffness = 1e8\n\
    [[train.planetary]]";

/// Impossible combinations of two sets are refused with the members and a remedy.
#[test]
fn faults_of_two_sets_are_told() {
    let good = two([&Set::lin_parker(3), &other()], TWIST);
    job(&good);
    let shared = "\"annulus b\", \"carrier b\"";
    let all: [(&[[&str; 2]], &str); 14] = [
        (
            &[["twist = 4e5\n", "twist = 4e5\nradial = 1e6\n"]],
            "the coupling of `carrier` and `input b` moves across the axis with the sets of the carriers `carrier` and `carrier b`",
        ),
        (
            &[
                ["carrier = \"carrier b\"", "carrier = \"input\""],
                ["\"annulus b\", \"housing b\"", shared],
            ],
            "shaft `input` moves across the axis with the sets of the carriers `carrier` and `input`",
        ),
        (
            &[[
                "name = \"housing b\"\nmotion = \"none\"",
                "name = \"housing b\"\ndiscs = [{ at = 0, polar_inertia = 1 }]\nmotion = \"rotation\"",
            ]],
            "the speeds of `carrier b`, `annulus b`, `housing b` do not follow from that of the driver `input`",
        ),
        (
            &[["\"annulus\", \"housing\"", "\"annulus\", \"carrier\""]],
            "`sun` and `planet 1` do not roll on each other",
        ),
        (
            &[[
                "[[train.planetary]]",
                "[[train.coupling]]\nshafts = [\"carrier b\", \"housing b\"]\nat = [0, 0]\ntwist = 1e6\n[[train.planetary]]",
            ]],
            "`housing` and `housing b` are both held",
        ),
        (
            &[["count = 3\n", "angles = []\n"]],
            "a planetary set has no planets",
        ),
        (
            &[["name = \"planet b\"", "name = \"planet\""]],
            "two planetary sets call their planets `planet` and `planet`",
        ),
        (
            &[["name = \"planet b\"", "name = \"planet 2\""]],
            "two planetary sets call their planets `planet` and `planet 2`",
        ),
        (
            &[["carrier = \"carrier b\"", "carrier = \"planet 1\""]],
            "the carrier `planet 1` is one of the planets",
        ),
        (
            &[["carrier = \"carrier\"", "carrier = \"planet b 1\""]],
            "the carrier `planet b 1` is one of the planets",
        ),
        (
            &[["[\"sun b\", \"planet b\"]", "[\"planet\", \"planet b\"]"]],
            "`planet` and `planet b` are planets",
        ),
        (
            &[["[\"sun b\", \"planet b\"]", "[\"sun b\", \"planet b 2\"]"]],
            "write \"planet b\": it stands for every planet",
        ),
        (
            &[["[\"sun\", \"planet\"]", "[\"sun\", \"planet b\"]"]],
            "cannot mesh",
        ),
        (
            &[["[[train.planetary]]", LOCKED]],
            "with what joins `carrier b` and `second`, these or the driver `input` cannot turn",
        ),
    ];
    for (changes, told) in all {
        let mut text = good.clone();
        for [from, to] in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        let said = refusal(&text);
        assert!(said.contains(told), "{told}: {said}");
    }
    // The set has no distance of the pins, and no mesh that determines it.
    let (before, after) = good.rsplit_once("radius = ").unwrap();
    let (_, after) = after.split_once('\n').unwrap();
    let unplaced = format!("{before}{after}");
    let (before, after) = unplaced.rsplit_once("[[train.mesh]]").unwrap();
    let (_, after) = after.split_once("[[train.coupling]]").unwrap();
    let said = refusal(&format!("{before}[[train.coupling]]{after}"));
    assert!(
        said.contains("no mesh joins `planet b` and an external gear")
            && said.contains("give `radius` of the planets `planet b`"),
        "{said}"
    );
}

/// Sets on one carrier share its frame, and a fixed shaft is the same in all.
#[test]
fn sets_of_one_speed_share_a_frame() {
    let set = Set::lin_parker(3);
    let shared = two([&set, &set], TWIST)
        .replace("\noutput = 1", "")
        .replace("name = \"carrier\"\n", "name = \"carrier\"\noutput = 1\n")
        .replace("carrier = \"carrier b\"", "carrier = \"carrier\"")
        .replace("[\"carrier\", \"input b\"]", "[\"input\", \"input b\"]");
    let speed = speeds(&shared);
    assert_eq!([speed("annulus b"), speed("input b")], [0.0, 1.0]);
    let seats = two([&set, &other()], TWIST)
        .replace("\"annulus b\", \"housing b\"", "\"annulus b\", \"housing\"");
    job(&seats.replace(
        "\"housing\"]\nat = [0, 0]\n",
        "\"housing\"]\nat = [0, 0]\nradial = 1e8\n",
    ));
}

/// Meshes with a common period of more than ten thousand cycles are refused with this number.
#[test]
fn the_common_period_has_a_limit() {
    let set = Set {
        levels: true,
        ..Set::lin_parker(3)
    };
    let odd = |teeth: [u32; 3]| Set {
        teeth,
        ..set.clone()
    };
    // The second mesh has 103 · 41 cycles in 144 · 97 cycles of the first.
    let said = refusal(&two([&odd([23, 37, 97]), &odd([41, 31, 103])], TWIST));
    assert!(
        said.contains("has 4223 cycles in 13968") && said.contains("at most 10000 are allowed"),
        "{said}"
    );
    assert_eq!(model(&job(&two([&set, &set], TWIST))).base_cycles(), 5);
}
