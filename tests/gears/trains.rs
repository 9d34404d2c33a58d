//! Trains of gears from manifests: shipped ones, bevel gears in closed form, and refusals.
// Helpers outside the test functions may also unwrap.
#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance, advance_with, volterra};
use gearatlas::analysis::{EnergyAudit, EnergyNorm, Nvh};
use gearatlas::manifest::{self, Job};
use gearatlas::model::{InitialState, Model, TrajectoryState};
use gearatlas::reference::Extended;
use gearatlas::sweep::build;
use gearatlas::verify::drives::disturbed;
use std::path::Path;

fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/trains");
    std::fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap()
}

fn job(text: &str) -> Job {
    manifest::parse(text, "test.toml", Path::new("")).unwrap_or_else(|errors| panic!("{errors}"))
}

fn model(job: &Job, point: usize) -> Model {
    common::parts().model(&job.points.at(point)).unwrap()
}

/// The shipped trains, the flexible one with few modes, each with its base period.
fn shipped() -> Vec<(&'static str, Model, usize)> {
    let two_stage = text("two-stage").replace("modes = 30", "modes = 10");
    let idle = job(&text("idle-rattle"));
    let last = idle.points.len() - 1;
    vec![
        ("two-stage", model(&job(&two_stage), 3), 25),
        ("idle-rattle", model(&idle, last), 1),
        ("clutch", model(&job(&text("clutch")), 8), 1),
    ]
}

/// Compares three cycles of `volterra` with extended precision, from a state: relative difference of states, difference
/// of event times in cycles, and number of events of each.
pub fn off_extended(model: &Model, start: &TrajectoryState) -> ([f64; 2], [usize; 2]) {
    let exact = Extended::new(model).advance(start, 3).unwrap();
    let mut seen = Events::default();
    let (end, _) = advance_with(&volterra(model), start, 3, &mut seen);
    let norm = EnergyNorm::new(model);
    let exact_end = exact.end().state;
    let worst = norm.distance(&end.state, &exact_end) / norm.length(&exact_end);
    let times = seen.0.iter().zip(&exact.crossings);
    let late = times
        .map(|(event, crossing)| (event.time - crossing.time.value()).abs() / model.period())
        .fold(0.0, f64::max);
    ([worst, late], [seen.0.len(), exact.crossings.len()])
}

#[test]
fn shipped_trains_are_exact() {
    for (name, model, base) in shipped() {
        assert_eq!(model.base_cycles(), base, "{name}");
        let ([worst, late], [seen, exact]) = off_extended(&model, &disturbed(&model));
        println!("{name}: states {worst:.1e}, times {late:.1e} of a cycle, {seen} events");
        assert_eq!(seen, exact, "{name}");
        assert!(seen > 3, "{name}: {seen} events");
        // Freely rotating bodies have moved a hundred gaps, whose round-off affects contacts; a cycle of idling has as
        // many windows as thirty of the others.
        let rigid = if name == "two-stage" { 1.0 } else { 10.0 };
        assert!(worst < 1e-12 * rigid, "{name}: {worst:e}");
        assert!(late < 1e-13 * rigid, "{name}: {late:e}");
    }
}

#[test]
fn energy_of_trains_closes() {
    for (name, model, _) in shipped() {
        let start = disturbed(&model);
        let mut audit = EnergyAudit::new(&model);
        let (end, _) = advance_with(&volterra(&model), &start, 30, &mut audit);
        let residual = audit.residual(&end).unwrap();
        println!("{name}: {residual:.1e}");
        assert!(residual < 1e-12, "{name}: {residual:e}");
    }
}

/// On average every mesh of a train carries the force of its torque: the difference of the forces on its two flanks.
#[test]
fn every_mesh_of_a_train_tells_its_force() {
    let job = job(&text("two-stage").replace("modes = 30", "modes = 10"));
    let point = job.points.at(job.points.len() - 1);
    let model = common::parts().model(&point).unwrap();
    let kernel = volterra(&model);
    let start = advance(&kernel, &model.start(&InitialState::Static), 200);
    let mut nvh = Nvh::new(&model, 0);
    advance_with(&kernel, &start, 4000, &mut nvh);
    let found = nvh.outcome().unwrap();
    assert_eq!(found.values.contact_force.len(), model.contacts.len());
    let torque = point.load * 40.0;
    let base_radius = |teeth: f64, module: f64| 0.5 * teeth * module * 20f64.to_radians().cos();
    let asked = [
        torque / base_radius(20.0, 2.5e-3),
        torque * 50.0 / 20.0 / base_radius(18.0, 3e-3),
    ];
    for (mesh, asked) in asked.iter().enumerate() {
        let [drive, coast] = [0, 1].map(|flank| found.values.contact_force[2 * mesh + flank]);
        println!("mesh {mesh}: {drive} N less {coast} N, {asked} N");
        assert!(drive >= 0.0 && coast >= 0.0);
        assert!(((drive - coast) / asked - 1.0).abs() < 0.01);
    }
    let net = found.values.contact_force[0] - found.values.contact_force[1];
    assert!((net / found.values.force_mean - 1.0).abs() < 1e-9);
}

/// The neutral rotation of a train under drag is arbitrary, and nothing else depends on it.
#[test]
fn where_a_train_has_turned_to_is_not_felt() {
    let (_, model, _) = shipped().remove(1);
    let norm = EnergyNorm::new(&model);
    let [unfelt] = &model.unrestrained_displacements()[..] else {
        panic!("one displacement");
    };
    let start = disturbed(&model);
    let turned: Vec<f64> = (start.state.iter().zip(unfelt))
        .map(|(x, n)| x + 1e-4 * n)
        .collect();
    let turned = TrajectoryState::new(&model, turned, 0);
    assert!(norm.distance(&turned.state, &start.state) < 1e-9 * norm.unit());
    let kernel = volterra(&model);
    let [one, other] = [&start, &turned].map(|start| advance(&kernel, start, 2));
    let apart = norm.distance(&one.state, &other.state) / norm.unit();
    assert!(apart < 1e-9, "{apart:e}");
    // The norm has all components except the neutral displacement.
    assert_eq!(norm.dimension(), 2 * model.modes() - 1);
}

/// A pair of bevel gears at right angles on rigid shafts.
const BEVEL: &str = r#"
[job]
name = "bevel"

[model]
kind = "train"

[train]
gears = ["z20", "z30"]
rated_torque = "60 N*m"

[[train.shaft]]
name = "pinion"
origin = [0, 0, "-45 mm"]
gears = [{ name = "z20", at = 0, teeth = 20, module = "3 mm", width = "15 mm" }]
bearings = [
    { at = "-20 mm", x = "1e8 N/m", y = "1e8 N/m", axial = "1e8 N/m", tilt = "1e5 N*m/rad" },
    { at = "-60 mm", x = "1e8 N/m", y = "1e8 N/m" },
]

[[train.shaft]]
name = "wheel"
origin = ["30 mm", 0, 0]
direction = [1, 0, 0]
gears = [{ name = "z30", at = 0, teeth = 30, module = "3 mm", width = "15 mm" }]
bearings = [
    { at = "20 mm", x = "1e8 N/m", y = "1e8 N/m", axial = "1e8 N/m", tilt = "1e5 N*m/rad" },
    { at = "60 mm", x = "1e8 N/m", y = "1e8 N/m" },
]
output = 1

[mesh]
half_gap = "30 um"
stiffness = "constant"
mean_stiffness = "2e8 N/m"
contact_damping = 0.05

[grid]
load = 1
speed = "1000 rpm"
"#;

/// Friction changes its direction where teeth pass the pitch point, which no drawing gives for bevel gears.
#[test]
fn friction_of_bevel_gears_is_refused() {
    let rubbing = BEVEL.replace("[mesh]", "[mesh]\nfriction = 0.05");
    let refused = manifest::parse(&rubbing, "test.toml", Path::new("")).unwrap_err();
    let said = refused.to_string();
    assert!(
        said.contains("pitch point") && said.contains("bevel"),
        "{said}"
    );
    let further = BEVEL.replace(
        "[mesh]",
        "[[train.mesh]]\ngears = [\"z20\", \"z30\"]\nhalf_gap = \"30 um\"\ncoast_symmetry = 0\nstiffness = \"2e8 N/m\"\nfriction = 0.05\n\n[mesh]",
    );
    let refused = manifest::parse(&further, "test.toml", Path::new("")).unwrap_err();
    let said = refused.to_string();
    assert!(
        said.contains("pitch point") && said.contains("bevel"),
        "{said}"
    );
}

/// Three gears in a row, either mesh of which may be the first.
fn in_a_row(first: [&str; 2], further: [&str; 2]) -> Model {
    model(&job(&row(first, further)), 0)
}

fn row(first: [&str; 2], further: [&str; 2]) -> String {
    let shaft = |name: &str, gear: &str, at: u32, teeth: u32, more: &str| {
        format!(
            "[[train.shaft]]\nname = \"{name}\"\nmotion = \"rotation\"\norigin = [\"{at} mm\", 0, 0]\n\
             discs = [{{ at = 0, polar_inertia = \"1e-3 kg*m^2\" }}]\n\
             gears = [{{ name = \"{gear}\", at = \"30 mm\", teeth = {teeth}, module = \"4 mm\", width = \"20 mm\" }}]\n{more}\n"
        )
    };
    format!(
        "[job]\nname = \"row\"\n[model]\nkind = \"train\"\n[train]\ngears = [\"{}\", \"{}\"]\n\
         rated_torque = \"50 N*m\"\n{}{}{}\
         [[train.mesh]]\ngears = [\"{}\", \"{}\"]\nhalf_gap = \"20 um\"\nstiffness = \"3e8 N/m\"\ndamping = \"500 N*s/m\"\nfriction = 0.08\n\
         [mesh]\nhalf_gap = \"20 um\"\nstiffness = \"constant\"\nmean_stiffness = \"3e8 N/m\"\n\
         contact_damping = \"500 N*s/m\"\nfriction = 0.08\n[grid]\nload = 1\nspeed = 100\n",
        first[0],
        first[1],
        shaft("one", "a", 0, 20, ""),
        shaft("two", "b", 100, 30, ""),
        shaft("three", "c", 210, 25, "output = 1"),
        further[0],
        further[1],
    )
}

/// The friction loss of a mesh is the same for any order of the meshes.
#[test]
fn every_mesh_tells_its_losses() {
    let loss = |text: &str| {
        let model = model(&job(text), 0);
        let kernel = volterra(&model);
        let start = advance(&kernel, &model.start(&InitialState::Static), 2000);
        let mut nvh = Nvh::new(&model, 0);
        advance_with(&kernel, &start, 500, &mut nvh);
        nvh.outcome().unwrap().values
    };
    // The motor drives the gear in the middle, and both others drive machines.
    let between = |first, further| {
        let both = row(first, further).replace("output = 1", "output = 0.5");
        loss(&both.replace("name = \"one\"\n", "name = \"one\"\noutput = 0.5\n"))
    };
    let one = between(["b", "a"], ["b", "c"]);
    let two = between(["b", "c"], ["b", "a"]);
    let [ab, bc] = [&one.contact_loss[..2], &one.contact_loss[2..]];
    println!("{ab:?} {bc:?} W");
    for (found, expected) in two.contact_loss.iter().zip(bc.iter().chain(ab)) {
        assert!(
            (found - expected).abs() < 1e-6 * ab[0],
            "{found} {expected}"
        );
    }
    assert_eq!(one.power_loss.unwrap(), ab[0] + ab[1]);
    assert!(ab[0] > 1.0 && ab[1] == 0.0 && bc[0] > 1.0);
}

/// A further mesh has the friction of a first one. For either order of the meshes of a train, the force on every flank
/// has the same direction at the same phase, for any basis of modes.
#[test]
fn friction_of_further_meshes_turns_as_that_of_the_first() {
    let (one, two) = (
        in_a_row(["a", "b"], ["b", "c"]),
        in_a_row(["b", "c"], ["a", "b"]),
    );
    // Squares and products of directions and of participations do not depend on the modes.
    let invariants = |model: &Model, contact: usize, phase: f64| {
        let segments = &model.contacts[contact].cycles[0].segments;
        let segment = segments.iter().find(|own| phase < own.end).unwrap();
        let gains = model.gains(segment);
        let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 {
            let terms = gains.iter();
            terms
                .map(|gain| term(gain.deflection[0], gain.mesh_input[1]))
                .sum()
        };
        // The coast flanks of a further mesh have the opposite signs of deflection and force.
        [sum(&|w, _| w * w), sum(&|w, g| w * g), sum(&|_, g| g * g)]
    };
    let mut directions = Vec::new();
    for place in 0..200 {
        let phase = (f64::from(place) + 0.5) / 200.0;
        for flank in 0..2 {
            for (first, further) in [(&one, &two), (&two, &one)] {
                let found = invariants(further, 2 + flank, phase);
                let expected = invariants(first, flank, phase);
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!(
                        (found / expected - 1.0).abs() < 1e-9,
                        "{phase} {flank}: {found} {expected}"
                    );
                }
                directions.push(found[1]);
            }
        }
    }
    let least = directions.iter().copied().fold(f64::INFINITY, f64::min);
    let most = directions.iter().copied().fold(0.0, f64::max);
    assert!(most > 1.01 * least, "friction turns: {least} {most}");
}

/// Separating and axial forces of a bevel pair: `F_t tan α cos δ` across its axis and
/// `F_t tan α sin δ` along it, away from the apex.
#[test]
fn bevel_gears_push_away_from_the_apex() {
    let job = job(BEVEL);
    let structure = build::structure(&job.points.at(0).model).unwrap();
    assert_eq!(structure.rigid_modes(), 2);
    let tangential = 60.0 / 30e-3;
    assert!((structure.rated_force * 20f64.to_radians().cos() / tangential - 1.0).abs() < 1e-12);
    let elastic = (structure.frequency.iter().enumerate()).filter(|(_, omega)| **omega > 0.0);
    // Compute the response of the modes to the mesh force, with the torques in balance.
    let force = structure.rated_force;
    let response: Vec<(usize, f64)> = elastic
        .map(|(i, omega)| {
            let load = structure.torque[i] - structure.mesh[i];
            (i, force * load / omega.powi(2))
        })
        .collect();
    let reaction = |direction: &str| -> f64 {
        let named = structure.bearings.iter();
        let named = named.filter(|b| b.name.starts_with("pinion") && b.name.ends_with(direction));
        let parts = named.flat_map(|bearing| response.iter().map(|(i, q)| bearing.gain[*i] * q));
        parts.sum()
    };
    let cone = (20.0f64 / 30.0).atan();
    let separating = tangential * 20f64.to_radians().tan();
    // The wheel is at +x of the pinion's axis, which points at the apex. The force on the pinion is along −x, against
    // its axis, and by the wheel's resistance against its direction of motion, +y.
    for (direction, expected) in [
        ("x", -separating * cone.cos()),
        ("y", -tangential),
        ("axial", -separating * cone.sin()),
    ] {
        let found = reaction(direction);
        println!("{direction}: {found:.3} N, {expected:.3} N in closed form");
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{direction}: {found} {expected}"
        );
    }
}

/// Gears on intersecting axes have errors of their orders, tooth by tooth in the count of the train.
#[test]
fn bevel_gears_have_errors_of_their_shafts() {
    let errors = "[excitation]\ngear_error = [{ shaft = \"wheel\", order = 1, amplitude = \"5 um\" }, \
                  { shaft = \"pinion\", order = 2, amplitude = \"3 um\" }]\n\n[grid]";
    let job = job(&BEVEL.replacen("[grid]", errors, 1));
    let orders = &job.points.at(0).excitation.transmission_error;
    let counted: Vec<(u32, u32)> = orders.iter().map(|e| (e.cycles, e.harmonic)).collect();
    assert_eq!(counted, [(30, 1), (20, 2)]);
    model(&job, 0);
}

/// A mesh table is for cylindrical gears only: for bevel gears it is refused with any key.
#[test]
fn bevel_gears_have_no_mesh_table() {
    for stiffness in ["table", "continuous"] {
        let text = BEVEL
            .replacen("\"constant\"", &format!("\"{stiffness}\""), 1)
            .replacen("mean_stiffness", "# mean_stiffness", 1);
        let told = refusal(&text);
        assert!(
            told.contains("the gears of the first mesh are bevel gears"),
            "{told}"
        );
    }
}

/// Stiff shafts with a soft clutch: the modes satisfy their equations for any elements.
#[test]
fn stiff_shafts_beside_a_soft_coupling_have_modes() {
    for name in ["clutch", "clutch-hysteresis"] {
        for element in [100, 50, 25, 12, 10, 8, 6, 5, 4] {
            let sections = format!(
                "name = \"input\"\nelement = \"{element} mm\"\nsections = [{{ length = \"100 mm\", outer = \"25 mm\" }}]"
            );
            let text = text(name).replacen("name = \"input\"", &sections, 1);
            let structure = build::structure(&job(&text).points.at(0).model).unwrap();
            assert_eq!(structure.neutral_modes(), 1, "{name} {element}");
        }
    }
}

/// The drive of quickstart with hubs, once as `kind = "flexible"`, once with every part in a train.
#[test]
fn a_flexible_drive_is_a_train_of_two() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests");
    let quickstart = std::fs::read_to_string(folder.join("quickstart.toml")).unwrap();
    let hubs = "hub_diameter = [\"30 mm\", \"40 mm\"]\nhub_length = [\"30 mm\", \"25 mm\"]";
    let flexible = [
        (
            "[\"70 mm\", \"40 mm\"]",
            format!("[\"20 mm\", \"20 mm\"]\n{hubs}"),
        ),
        ("gear_position = 0.45", "gear_position = 0.5".to_owned()),
        ("elements = [3, 5, 7]", "elements = [4, 6, 6]".to_owned()),
    ]
    .iter()
    .fold(quickstart.clone(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    let shaft = |[name, gear, hub]: [&str; 3], [at, outer, inertia]: [&str; 3]| {
        format!(
            "[[train.shaft]]\nname = \"{name}\"\norigin = [{at}, 0, 0]\nelement = \"10 mm\"\n\
             sections = [{{ length = \"160 mm\", outer = {outer} }}]\n\
             discs = [{{ at = 0, polar_inertia = {inertia} }}]\n\
             gears = [{{ name = \"gear of {name}\", at = \"100 mm\", {gear}, module = \"4 mm\", width = \"20 mm\", {hub} }}]\n\
             bearings = [\n\
             {{ at = \"40 mm\", x = \"1.25e8 N/m\", y = \"1e8 N/m\", axial = \"1e8 N/m\", tilt = \"2e4 N*m/rad\" }},\n\
             {{ at = \"160 mm\", x = \"1.25e8 N/m\", y = \"1e8 N/m\", tilt = \"2e4 N*m/rad\" }},\n]\n"
        )
    };
    let [head, rest] = quickstart
        .split_once("[gear]")
        .map(<[&str; 2]>::from)
        .unwrap();
    let (_, tail) = rest.split_once("[mesh]").unwrap();
    let train = format!(
        "{}[train]\ngears = [\"gear of pinion\", \"gear of wheel\"]\nrated_torque = \"50 N*m\"\n{}{}output = 1\n[mesh]{}",
        head.replace("kind = \"flexible\"", "kind = \"train\""),
        shaft(
            [
                "pinion",
                "teeth = 20",
                "hub_diameter = \"30 mm\", hub_length = \"30 mm\""
            ],
            ["0", "\"22 mm\"", "2e-3"],
        ),
        shaft(
            [
                "wheel",
                "teeth = 30",
                "hub_diameter = \"40 mm\", hub_length = \"25 mm\""
            ],
            ["\"100 mm\"", "\"26 mm\"", "5e-3"],
        ),
        tail
    );
    let structure = |text: &str| build::structure(&job(text).points.at(0).model).unwrap();
    let [one, two] = [&flexible, &train].map(|text| structure(text));
    for (name, a, b) in [
        ("frequency", &one.frequency, &two.frequency),
        ("mesh", &one.mesh, &two.mesh),
        ("torque", &one.torque, &two.torque),
    ] {
        let largest = b.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let off = (a.iter().zip(b)).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        println!("{name}: {:.1e}", off / largest);
        assert!(off < 1e-10 * largest, "{name}: {off:e}");
    }
    let plain = structure(&flexible.replace(hubs, ""));
    assert!(one.frequency[2] > 1.005 * plain.frequency[2]);
}

fn refusal(text: &str) -> String {
    match manifest::parse(text, "test.toml", Path::new("")) {
        Err(errors) => errors.to_string(),
        Ok(job) => build::structure(&job.points.at(0).model)
            .unwrap_err()
            .to_string(),
    }
}

#[test]
fn bad_trains_get_one_clear_error_each() {
    let two_stage = text("two-stage");
    let bad = |from: &str, to: &str| {
        assert!(two_stage.contains(from), "{from}");
        let told = refusal(&two_stage.replacen(from, to, 1));
        println!("{told}\n");
        assert_eq!(told.matches("error[").count().max(1), 1, "{told}");
        told
    };
    for (from, to, told) in [
        (
            r#"gears = ["z18", "z54"]"#,
            r#"gears = ["z18", "z45"]"#,
            "there is no gear `z45`",
        ),
        (
            r#"teeth = 54, module = "3 mm""#,
            r#"teeth = 54, module = "2.5 mm""#,
            "cannot mesh: their modules are",
        ),
        (
            r#"origin = ["87.55 mm", 0, "40 mm"]"#,
            r#"origin = ["95 mm", 0, "40 mm"]"#,
            "cannot mesh with their axes 95.000000 mm apart: the contact ratio is",
        ),
        (
            r#"at = "75 mm", teeth = 20"#,
            r#"at = "120 mm", teeth = 20"#,
            "their faces are",
        ),
        (
            r#"origin = ["87.55 mm", 0, "40 mm"]"#,
            "origin = [\"87.55 mm\", 0, \"40 mm\"]\ndirection = [0, 1, 0]",
            "axes must be parallel (spur gears) or intersect (bevel gears)",
        ),
        ("output = 1 ", "output = 0.5 ", "add up to 0.5"),
        (
            "[[train.mesh]]                      # the second stage",
            "[[train.mesh]]\ngears = [\"z50\", \"z20\"]\nstiffness = \"1e8 N/m\"\n[[train.mesh]]",
            "these gears already mesh",
        ),
        (
            r#"name = "z18", at = "70 mm","#,
            r#"name = "z18", hub_diameter = "40 mm", hub_length = "60 mm", at = "70 mm","#,
            "the hub of `z18` is 60.000 mm long and reaches under `z50`",
        ),
        (
            r#"width = "25 mm""#,
            r#"width = "25 mm", hub_diameter = "40 mm", hub_length = "75 mm""#,
            "the hub of `z20` is 75.000 mm long and covers bearing 1 at 40.000 mm",
        ),
        (
            r#"width = "25 mm""#,
            r#"width = "25 mm", hub_diameter = "29 mm""#,
            "the hub (29.000 mm) must lie outside of the shaft (30.000 mm)",
        ),
        (
            r#"width = "25 mm""#,
            r#"width = "25 mm", hub_diameter = "40 mm", hub_length = "160 mm""#,
            "the hub is 160 mm long and reaches 25.000000 mm beyond the sections of its shaft",
        ),
        (
            r#"{ at = 0, x = "1.5e8 N/m", y = "1.2e8 N/m", axial = "8e7 N/m", tilt = "1e4 N*m/rad" }"#,
            r#"{ at = 0, x = "1.5e8 N/m", y = "1.2e8 N/m", tilt = "1e4 N*m/rad" }"#,
            "shaft `counter` is not held axially",
        ),
        (
            r#"torque_at = "140 mm""#,
            r#"torque_at = "150 mm""#,
            "the torque of shaft `output` is at 0.15 m",
        ),
    ] {
        let message = bad(from, to);
        assert!(message.contains(told), "{message}");
    }
}

/// Stages in a row with prime numbers of teeth: exact speeds exceed 127 bits after many of them.
#[test]
fn speeds_of_many_prime_stages_are_refused() {
    let prime = |n: &u32| (2..*n).all(|divisor| !n.is_multiple_of(divisor));
    let teeth: Vec<u32> = (101..).filter(prime).take(40).collect();
    let train = |stages: usize| {
        let (mut shafts, mut meshes, mut x) = (String::new(), String::new(), 0.0);
        for shaft in 0..=stages {
            let gear = |side: &str, stage: usize, z: u32| {
                let at = 20 * stage;
                format!(
                    "{{ name = \"{side} {stage}\", at = \"{at} mm\", teeth = {z}, module = 1e-3, width = 1e-2 }}"
                )
            };
            let wheel = shaft
                .checked_sub(1)
                .map(|stage| gear("wheel", stage, teeth[2 * stage + 1]));
            let pinion = (shaft < stages).then(|| gear("pinion", shaft, teeth[2 * shaft]));
            let gears: Vec<String> = wheel.into_iter().chain(pinion).collect();
            let gears = gears.join(", ");
            shafts += &format!(
                "[[train.shaft]]\nname = \"{shaft}\"\nmotion = \"rotation\"\norigin = [{x:?}, 0, 0]\ngears = [{gears}]\n"
            );
            x += 0.5e-3 * f64::from(teeth[2 * shaft] + teeth[2 * shaft + 1]);
            if (1..stages).contains(&shaft) {
                meshes += &format!(
                    "[[train.mesh]]\ngears = [\"pinion {shaft}\", \"wheel {shaft}\"]\nstiffness = 1e8\nhalf_gap = 1e-5\n"
                );
            }
        }
        format!(
            "[job]\nname = \"long\"\n[model]\nkind = \"train\"\n[train]\ngears = [\"pinion 0\", \"wheel 0\"]\nrated_torque = 1\n\
             {shafts}{meshes}[mesh]\nhalf_gap = 1e-5\nstiffness = \"constant\"\nmean_stiffness = 1e8\n[grid]\nload = 1\nspeed = 100\n"
        )
    };
    for (stages, told) in [
        (10, "but at most 10000 are allowed"),
        (19, "is too long a ratio of whole numbers"),
    ] {
        let message = refusal(&train(stages));
        assert!(message.contains(told), "{message}");
    }
}
