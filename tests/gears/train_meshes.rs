//! Meshes of trains from the drawings of their gears.
// Helpers outside the test functions may also unwrap.
#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, advance_with, volterra};
use gearatlas::analysis::{Nvh, Outputs, Signals};
use gearatlas::manifest::{self, Job, PointSpec, StiffnessSpec};
use gearatlas::model::{InitialState, Model, Quantity};
use gearatlas::propagate::{Observer, Window};
use std::path::Path;

fn job(text: &str) -> Job {
    manifest::parse(text, "test.toml", Path::new("")).unwrap_or_else(|errors| panic!("{errors}"))
}

fn shipped() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/trains");
    std::fs::read_to_string(folder.join("helical-two-stage.toml")).unwrap()
}

/// As an axis the half gap replaces the backlash of the drawing, as if the thinning of both gears were another one.
#[test]
fn half_gaps_of_an_axis_are_those_of_thinner_teeth() {
    let text = shipped().replacen("thinning = \"40 um\"", "thinning = \"65 um\"", 2);
    let drawn = job(&text).points.at(0);
    let gap = drawn.mesh.half_gap;
    let with = |table: &str, line: &str| shipped().replacen(table, &format!("{table}\n{line}"), 1);
    let given = format!("\"mesh.half_gap\" = {{ values = [{gap:e}, 1e-4] }}");
    let points = job(&with("[grid]", &given)).points;
    let [first, last] = [0, points.len() - 1].map(|index| points.at(index));
    assert_eq!([first.mesh.half_gap, last.mesh.half_gap], [gap, 1e-4]);
    let thinning = |point: &PointSpec| match &point.mesh.stiffness {
        StiffnessSpec::Table(spec) => spec.gears.form.thinning,
        other => panic!("{other:?}"),
    };
    let [varied, expected] = [&first, &drawn].map(thinning);
    for (varied, expected) in varied.iter().zip(expected) {
        assert!((varied - expected).abs() < 1e-12, "{varied} {expected}");
    }
    // Only the first mesh has it.
    assert_eq!(
        first.model.source,
        job(&shipped()).points.at(0).model.source
    );
    let refused = with("\n[mesh]", &format!("half_gap = {gap:e}"));
    let refused = manifest::parse(&refused, "test.toml", Path::new("")).unwrap_err();
    assert!(
        refused.to_string().contains("contradicts the drawing"),
        "{refused}"
    );
}

struct Watched(Outputs);

impl Observer for Watched {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.0.window(window);
    }
}

/// Mean force on every bearing of a model by its name, over some cycles of a settled motion.
pub(crate) fn bearing_means(model: &Model, [lead, cycles]: [u64; 2]) -> Vec<(String, f64)> {
    let kernel = volterra(model);
    let start = advance(&kernel, &model.start(&InitialState::Static), lead);
    let asked = Signals {
        bearings: true,
        ..Signals::NONE
    };
    let mut watched = Watched(Outputs::new(model, asked).unwrap());
    advance_with(&kernel, &start, cycles, &mut watched);
    let [means, _] = watched.0.statistics(Quantity::BearingForce);
    let names = model.bearings.iter().map(|bearing| bearing.name.clone());
    names.zip(means.mean).collect()
}

/// Two helical stages in steady contact: forces on the bearings of every shaft balance the forces of its meshes,
/// computed by hand from the teeth and the axes.
#[test]
fn bearings_of_two_helical_stages_bear_what_statics_says() {
    let job = job(&shipped());
    let last = job.points.len() - 1;
    let point = job.points.at(last);
    let model = common::parts().model(&point).unwrap();
    assert_eq!(model.base_cycles(), 25);
    let found = bearing_means(&model, [4000, 25]);
    let sum = |shaft: &str, direction: &str| -> f64 {
        let own = found.iter().filter(|(name, _)| {
            name.starts_with(shaft) && name.ends_with(&format!(" {direction}"))
        });
        own.map(|(_, force)| force).sum()
    };
    // Operating pressure angle, base helix angle and first base radius of a pair.
    let pair = |teeth: [f64; 2], module: f64, helix: f64, distance: f64| {
        let (alpha, beta) = (20f64.to_radians(), helix.to_radians());
        let transverse = (alpha.tan() / beta.cos()).atan();
        let base = teeth.map(|z| 0.5 * module * z / beta.cos() * transverse.cos());
        let working = ((base[0] + base[1]) / distance).acos();
        (working, (beta.sin() * alpha.cos()).asin(), base[0])
    };
    let (angle1, helix1, base1) = pair([20.0, 50.0], 2.5e-3, 15.0, 90.59e-3);
    let (angle2, helix2, base2) = pair([18.0, 54.0], 3e-3, 12.0, 110.42e-3);
    let [force1, force2] = [120.0 / base1, 120.0 * 2.5 / base2];
    // Force of the first gear on the second: the left-handed pinion rotates forwards, the right-handed one backwards.
    let first = [angle1.sin(), angle1.cos(), helix1.tan()].map(|part| force1 * part);
    let second = [angle2.sin(), -angle2.cos(), helix2.tan()].map(|part| force2 * part);
    for (axis, direction) in ["x", "y", "axial"].into_iter().enumerate() {
        for (shaft, expected) in [
            ("input", -first[axis]),
            ("counter", first[axis] - second[axis]),
            ("output", second[axis]),
        ] {
            let force = sum(shaft, direction);
            println!("{shaft} {direction}: {force} N, {expected} N");
            assert!(
                (force - expected).abs() < 1e-10 * force2,
                "{shaft} {direction}"
            );
        }
    }
}

/// A motor between two helical meshes that share its torque; `first` selects the first mesh.
fn split(first: usize) -> String {
    let meshes = [["a", "b"], ["c", "d"]];
    let [one, two] = [meshes[first], meshes[1 - first]];
    let gear = |name: &str, teeth: u32, helix: f64, module: f64| {
        format!(
            "{{ name = \"{name}\", at = {at}, teeth = {teeth}, module = {module}, helix_angle = {helix}, \
             width = 0.02, thinning = 40e-6, lead_crowning = 4e-6, tip_relief = {{ amount = 1e-5, length = 2e-3 }} }}",
            at = if "ab".contains(name) { 0.03 } else { 0.09 }
        )
    };
    // The gears have the same errors for either choice of the first mesh.
    let errors = |mesh: [&str; 2], [key, driving, driven]: [&str; 3]| {
        let teeth = if mesh == ["a", "b"] { 20 } else { 25 };
        let deviations = (0..teeth).map(|tooth| format!("{}e-6", tooth * tooth % 7));
        format!(
            "gear_error = [{{ {key} = \"{driven}\", order = 1, amplitude = 6e-6, phase = 0.4 }}]\n\
             pitch_deviation = {{ {driving} = [{}] }}",
            deviations.collect::<Vec<_>>().join(", ")
        )
    };
    let bearings = "bearings = [{ at = 0, x = 2e8, y = 2e8, axial = 1e8, tilt = 1e4 }, { at = 0.12, x = 2e8, y = 2e8 }]";
    let section = "sections = [{ length = 0.12, outer = 0.03 }]";
    format!(
        "[job]\nname = \"split\"\nseed = 1\n\
         [model]\nkind = \"train\"\nmodes = 24\ndamping = 0.02\n\
         [train]\ngears = [\"{}\", \"{}\"]\nrated_torque = 100\n\
         [[train.shaft]]\nname = \"motor\"\n{section}\n{bearings}\ngears = [{}, {}]\n\
         discs = [{{ at = 0, polar_inertia = 2e-3 }}]\n\
         [[train.shaft]]\nname = \"left\"\norigin = [-0.0638, 0, 0]\n{section}\n{bearings}\ngears = [{}]\noutput = 0.4\n\
         discs = [{{ at = 0, polar_inertia = 2e-3 }}]\n\
         [[train.shaft]]\nname = \"right\"\norigin = [0.0762, 0, 0]\n{section}\n{bearings}\ngears = [{}]\noutput = 0.6\n\
         discs = [{{ at = 0, polar_inertia = 3e-3 }}]\n\
         [[train.mesh]]\ngears = [\"{}\", \"{}\"]\n{}\nlaw = \"continuous\"\nshaft_tilt = true\ndamping = 1500\nfriction = 0.04\n\
         [mesh]\nstiffness = \"continuous\"\nshaft_tilt = true\ncontact_damping = \"1500 N*s/m\"\nfriction = 0.04\n\
         [excitation]\n{}\ntorque_ripple = [{{ shaft = \"pinion\", order = 2, amplitude = 60 }}]\n\
         [grid]\nload = 0.05\nspeed = 300\n[run]\ntransient = 100\ncycles = 1000\n[analyses]\nlyapunov = {{ exponents = 1 }}\n",
        one[0],
        one[1],
        gear("a", 20, 0.2, 2.5e-3),
        gear("c", 25, -0.25, 2.5e-3),
        gear("b", 30, -0.2, 2.5e-3),
        gear("d", 34, 0.25, 2.5e-3),
        two[0],
        two[1],
        errors(two, ["gear", "driving", "driven"]),
        errors(one, ["shaft", "pinion", "wheel"]),
    )
}

/// The choice of the mesh that counts the cycles is irrelevant. A further mesh from the drawing, helical, crowned, with
/// friction, under the tilt of its shafts, has the same motion as a first one, and statistics of its contacts are the
/// same.
#[test]
fn a_further_mesh_is_what_it_is_as_the_first() {
    let models = [0, 1].map(|first| {
        let job = job(&split(first));
        common::parts().model(&job.points.at(0)).unwrap()
    });
    // Both meshes have whole numbers of cycles in a fifth of a revolution. The start is out of balance, for rattle.
    let fifths = 3;
    let per_fifth = [4, 5];
    let mut told = Vec::new();
    let mut deflections = Vec::new();
    let mut moved = Vec::new();
    for (model, cycles) in models.iter().zip(per_fifth) {
        let kernel = volterra(model);
        let start = advance(&kernel, &model.start(&InitialState::Rest), cycles);
        let asked = Signals {
            meshes: true,
            ..Signals::NONE
        };
        let outputs = Watched(Outputs::new(model, asked).unwrap());
        let mut watched = (Nvh::new(model, 0), outputs);
        let (end, _) = advance_with(&kernel, &start, fifths * cycles, &mut watched);
        told.push(watched.0.outcome().unwrap().values);
        let of_meshes = [Quantity::MeshDeflection, Quantity::MeshForce];
        let rms = of_meshes.map(|quantity| {
            let [values, _] = watched.1.0.statistics(quantity);
            values.rms
        });
        let own = [
            told[told.len() - 1].deflection_rms,
            told[told.len() - 1].force_std,
        ];
        for (rms, own) in rms.iter().zip(own) {
            assert!((rms[0] / own - 1.0).abs() < 1e-12, "{} {own}", rms[0]);
        }
        moved.push(rms);
        let at = |contact: usize| {
            let segment = &model.contacts[contact].cycles[0].segments[0];
            model.deflection_on(segment, 0, &end.state, 0.0).0
        };
        deflections.push([at(0), at(2)]);
    }
    let gap = models[0].half_gap;
    for mesh in [0, 1] {
        let [one, two] = [deflections[0][mesh], deflections[1][1 - mesh]];
        println!("mesh {mesh}: {one} m, {two} m");
        assert!((one - two).abs() < 1e-9 * gap, "{one} {two}");
        for (a, b) in moved[0].iter().zip(&moved[1]) {
            let (a, b) = (a[mesh], b[1 - mesh]);
            println!("  {a} {b}");
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
        for flank in [0, 1] {
            let [one, two] = [2 * mesh + flank, 2 * (1 - mesh) + flank];
            for (a, b) in [
                (&told[0].contact_force, &told[1].contact_force),
                (&told[0].contact_fraction, &told[1].contact_fraction),
                (&told[0].contact_impact_rate, &told[1].contact_impact_rate),
                (&told[0].contact_rattle_index, &told[1].contact_rattle_index),
            ] {
                let (a, b) = (a[one], b[two]);
                println!("  {a} {b}");
                assert!((a - b).abs() <= 1e-8 * a.abs(), "{a} {b}");
            }
        }
    }
    let first = &told[0];
    let both = |list: &[f64]| list[0] + list[1];
    assert!((both(&first.contact_rattle_index) / first.rattle_index - 1.0).abs() < 1e-12);
    assert!(first.contact_rattle_index.iter().all(|index| *index > 0.0));
}

/// The first tooth of a list of deviations engages at the start of a cycle of its mesh. A mesh that is ahead by a phase
/// therefore has the same errors earlier.
#[test]
fn the_phase_of_a_mesh_shifts_the_deviations_of_its_teeth() {
    let errors = |phase: f64| {
        let text = split(0);
        let of_mesh = text.find("gear_error = [{ gear").unwrap();
        let end = of_mesh + text[of_mesh..].find('\n').unwrap();
        let text = format!("{}phase = {phase}{}", &text[..of_mesh], &text[end..]);
        let model = common::parts().model(&job(&text).points.at(0)).unwrap();
        let segment = &model.contacts[2].cycles[0].segments[0];
        let [p, q] = model.meshes[1].cycles.map(f64::from);
        (
            model.lines[model.line(segment)].clone(),
            model.period() * q / p,
        )
    };
    let (at_zero, period) = errors(0.0);
    for (phase, ahead) in [(0.3, 0.3), (1.3, 0.3), (-0.7, 0.3)] {
        let (line, _) = errors(phase);
        assert!(!line.transmission_error.is_empty());
        for place in [0.0, 0.2, 1.7, 12.4] {
            let time = place * period;
            let [wanted, found] = [
                at_zero.transmission_error_at(0, time + ahead * period).0,
                line.transmission_error_at(0, time).0,
            ];
            assert!(
                (wanted - found).abs() < 1e-17,
                "{phase} {place}: {wanted} {found}"
            );
        }
    }
}

/// The drive of two helical stages, with its counter shaft described from the other end.
fn from_the_other_end() -> String {
    [
        (
            "origin = [\"90.59 mm\", 0, \"40 mm\"]",
            "origin = [\"90.59 mm\", 0, \"140 mm\"]\ndirection = [0, 0, -1]",
        ),
        (
            "{ at = 0, x = \"2.2e8 N/m\"",
            "{ at = \"100 mm\", x = \"2.2e8 N/m\"",
        ),
        (
            "{ at = \"100 mm\", x = \"2.2e8 N/m\", y = \"2.2e8 N/m\" }",
            "{ at = 0, x = \"2.2e8 N/m\", y = \"2.2e8 N/m\" }",
        ),
        ("\"z50\", at = \"35 mm\"", "\"z50\", at = \"65 mm\""),
        ("\"z18\", at = \"72 mm\"", "\"z18\", at = \"28 mm\""),
    ]
    .iter()
    .fold(shipped(), |text, (one, other)| {
        assert_eq!(text.matches(one).count(), 1, "{one}");
        text.replace(one, other)
    })
}

/// The end from which the gears of a shaft are counted is irrelevant. From one end the first gear of the second stage
/// rotates backwards, from the other forwards, and its lines of contact cross the face in the same direction.
#[test]
fn a_helical_mesh_does_not_know_from_which_end_its_shaft_is_described() {
    let [one, other] = [shipped(), from_the_other_end()].map(|text| {
        let job = job(&text);
        let model = (common::parts().model(&job.points.at(job.points.len() - 1))).unwrap();
        let kernel = volterra(&model);
        let end = advance(&kernel, &model.start(&InitialState::Static), 100);
        let at = |contact: usize| {
            let segment = &model.contacts[contact].cycles[0].segments[0];
            model.deflection_on(segment, 0, &end.state, 0.0).0
        };
        [at(0), at(2)]
    });
    for mesh in [0, 1] {
        println!("mesh {mesh}: {} m, {} m", one[mesh], other[mesh]);
        assert!((one[mesh] - other[mesh]).abs() < 1e-9 * one[mesh].abs());
    }
}
