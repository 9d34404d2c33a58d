//! At 0.5 rad/s gears without further excitation are in equilibrium at every phase. Under each mesh law their
//! deflection is that of the law's static equilibrium; for meshes from the drawing this is the loaded static
//! transmission error.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use common::advance::{advance, advance_with, volterra};
use gearatlas::gear::MeshTableSpec;
use gearatlas::gear::{
    Face, Flanks, LoadSharing, MeshTable, MeshTableCycle, MeshTableInputs, SecantContact, pairs_at,
};
use gearatlas::manifest::{self, StiffnessSpec};
use gearatlas::model::{InitialState, Model};
use gearatlas::propagate::{Event, Observer, Window};
use std::f64::consts::TAU;
use std::path::Path;

/// Only the mesh is elastic; load and half gap of the manifest.
const MANIFEST: &str = include_str!("../../manifests/tiers/torsional.toml");
const LOAD: f64 = 0.3;
const HALF_GAP: f64 = 10e-6;

/// Length of the decay after a jump or an event, in mesh cycles. A window with its middle in it does not count.
const DIED_OUT: f64 = 0.03;

/// The manifest with this mesh law and this line in `[gear]`, without error or friction. With its damper, oscillations
/// decay within a segment.
fn manifest(law: &str, gear: &str, excitation: &str) -> String {
    let left_out = [
        "stiffness",
        "mean_stiffness",
        "contact_ratio",
        "single_pair_drop",
        "segments",
        "friction",
        "contact_damping",
        "transmission_error",
    ];
    let kept = |line: &&str| {
        !left_out
            .iter()
            .any(|key| line.starts_with(&format!("{key} =")))
    };
    let lines: Vec<&str> = MANIFEST.lines().filter(kept).collect();
    (lines.join("\n"))
        .replace(
            "[mesh]",
            &format!("[mesh]\n{law}\nfriction = 0\ncontact_damping = \"6000 N*s/m\""),
        )
        .replace("rated_torque =", &format!("{gear}\nrated_torque ="))
        .replace(
            "[excitation]",
            &format!("[excitation]\ntransmission_error = []\n{excitation}"),
        )
}

fn model(text: &str) -> Model {
    let job = manifest::parse(text, "m.toml", Path::new("")).unwrap();
    let mut point = job.points.at(0);
    (point.speed, point.load) = (0.5, LOAD);
    common::parts().model(&point).unwrap()
}

/// The mesh of a manifest, computed from its gears.
fn spec(text: &str) -> MeshTableSpec {
    let job = manifest::parse(text, "m.toml", Path::new("")).unwrap();
    match &job.points.at(0).mesh.stiffness {
        StiffnessSpec::Table(spec) => (**spec).clone(),
        other => panic!("{other:?}"),
    }
}

/// Deflection and force in the middle of every window.
#[derive(Default)]
struct Middles {
    /// Time within the cycle, deflection, force, rate of the deflection.
    windows: Vec<[f64; 4]>,
    events: Vec<f64>,
}

impl Observer for Middles {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let value = |series: &[f64]| -> f64 {
            // P_n(0) = 1, 0, −1/2, 0, 3/8, 0, −5/16, …
            let mut at_zero = 1.0;
            let mut sum = 0.0;
            for (n, a) in series.iter().enumerate().step_by(2) {
                sum += a * at_zero;
                at_zero *= -((n + 1) as f64) / (n + 2) as f64;
            }
            sum
        };
        let slope: f64 = (window.deflection.iter().enumerate().skip(1).step_by(2))
            .map(|(n, a)| {
                // P_n'(0) = n P_{n−1}(0).
                let before = (0..(n - 1) / 2).fold(1.0, |value, i| {
                    value * -((2 * i + 1) as f64) / (2 * i + 2) as f64
                });
                a * n as f64 * before
            })
            .sum();
        self.windows.push([
            window.start + 0.5 * window.duration,
            value(window.deflection),
            value(window.force),
            2.0 * slope / window.duration,
        ]);
    }

    fn event(&mut self, event: &Event) {
        self.events.push(event.time);
    }
}

/// Largest relative difference of the approach of the gears, over a cycle at 0.5 rad/s, from the value of a law at a
/// mesh phase and a force. The damper carries a share of the load in proportion to the rate of the deflection beyond
/// the error of the law. Windows within [`DIED_OUT`] after the end of a segment of the drive flanks or an event do not
/// count.
fn off(name: &str, text: &str, law: impl Fn(f64, f64) -> f64, error: impl Fn(f64) -> f64) -> f64 {
    let model = model(text);
    let kernel = volterra(&model);
    let start = advance(&kernel, &model.start(&InitialState::Static), 1);
    let mut middles = Middles::default();
    advance_with(&kernel, &start, 1, &mut middles);
    let force = LOAD * 50.0 / (0.04 * 20f64.to_radians().cos());
    let damping = model.first_cycle().segments[0].damping;
    let mut steps: Vec<f64> = (middles.events.iter())
        .map(|time| time / model.period())
        .collect();
    let drive = model.contacts.iter().filter(|contact| contact.side > 0.0);
    let segments = drive.flat_map(|contact| &contact.cycles[0].segments);
    steps.extend(segments.map(|segment| segment.end));
    let ([mut worst, mut bare], mut seen) = ([0.0_f64; 2], 0);
    for [time, deflection, _, rate] in middles.windows {
        let phase = time / model.period();
        if (steps.iter()).any(|step| (phase - step).rem_euclid(1.0) < DIED_OUT) {
            continue;
        }
        let approach = deflection - HALF_GAP;
        let step = 1e-6;
        let moving = (error(phase + step) - error(phase - step)) / (2.0 * step * model.period());
        let borne = force - damping * (rate - moving);
        worst = worst.max((approach / law(phase, borne) - 1.0).abs());
        bare = bare.max((approach / law(phase, force) - 1.0).abs());
        seen += 1;
    }
    println!("{name}: {worst:.1e}, {bare:.1e} without the damper's share, {seen} windows");
    assert!(seen > 100 && bare < 5e-3, "{seen} {bare}");
    worst
}

/// Stiffness over the mesh phase.
type Law<'a> = &'a dyn Fn(f64) -> f64;

/// Given stiffness: F/k.
#[test]
fn given_stiffness() {
    let level = |phase: f64| if phase < 0.6 { 4e8 / 0.9 } else { 3e8 / 0.9 };
    let two = "mean_stiffness = 4e8\ncontact_ratio = 1.6\nsingle_pair_drop = 0.25";
    let values = [4.1e8, 3.9e8, 4.4e8, 3.1e8, 3.3e8];
    let wave =
        |phase: f64| 4e8 + 5e7 * (TAU * phase + 0.3).cos() + 2e7 * (2.0 * TAU * phase - 1.0).cos();
    let harmonics = "stiffness_harmonics = [{ harmonic = 1, amplitude = 5e7, phase = 0.3 }, \
                     { harmonic = 2, amplitude = 2e7, phase = -1.0 }]";
    let cases: [(&str, String, Law<'_>); 7] = [
        (
            "constant",
            "stiffness = \"constant\"\nmean_stiffness = 4e8".into(),
            &|_| 4e8,
        ),
        (
            "piecewise, two levels",
            format!("stiffness = \"piecewise\"\n{two}\nsegments = 60"),
            &level,
        ),
        (
            "piecewise, values",
            format!("stiffness = \"piecewise\"\nvalues = {values:?}"),
            &|phase| values[(5.0 * phase) as usize],
        ),
        (
            "continuous, two levels",
            format!("stiffness = \"continuous\"\n{two}"),
            &level,
        ),
        (
            "fourier",
            format!("stiffness = \"fourier\"\nmean_stiffness = 4e8\n{harmonics}"),
            &wave,
        ),
        (
            "continuous, forces that vanish",
            format!("stiffness = \"continuous\"\n{two}\nrelease = \"force\""),
            &level,
        ),
        (
            "continuous, one line",
            format!("stiffness = \"continuous\"\n{two}\ncoast_flank = \"same_line\""),
            &level,
        ),
    ];
    for (name, law, stiffness) in cases {
        let text = manifest(&law, "", "");
        let worst = off(
            name,
            &text,
            |phase, force| force / stiffness(phase),
            |_| 0.0,
        );
        assert!(worst < 1e-6, "{name}: {worst:e}");
    }
}

const CORES: &str = "bore = [\"48 mm\", \"76 mm\"]";
const FACE: Face = Face {
    width: 20e-3,
    slices: 1,
};

/// The loaded transmission error of gears, with the flattening of their flanks at a line load if it is given.
fn approach(flanks: &Flanks, line_load: Option<f64>, phase: f64, force: f64) -> f64 {
    let pairs = match line_load {
        None => pairs_at(flanks, phase, FACE),
        Some(line_load) => pairs_at(
            &SecantContact {
                law: flanks,
                line_load,
            },
            phase,
            FACE,
        ),
    };
    let sharing = LoadSharing::new(&pairs.unwrap(), FACE, 0.0).unwrap();
    sharing.distribute(force).deflection
}

/// The mesh between its kinks: the tangent at the mean load and pairs as springs. With the load-dependent contact the
/// tangent is that of flanks flattened by the whole load on one pair.
#[test]
fn courses_have_the_loaded_transmission_error() {
    let line_load = LOAD * 50.0 / (0.04 * 20f64.to_radians().cos()) / FACE.width;
    for (name, law, line_load) in [
        (
            "table, continuous",
            "stiffness = \"continuous\"\nresolution = \"mean_load\"",
            None,
        ),
        (
            "table, continuous, load-dependent",
            "stiffness = \"continuous\"\nresolution = \"mean_load\"\ncontact = \"load_dependent\"",
            Some(line_load),
        ),
        (
            "pairs",
            "stiffness = \"continuous\"\nresolution = \"pairs\"",
            None,
        ),
        (
            "pairs, load-dependent",
            "stiffness = \"continuous\"\nresolution = \"pairs\"\ncontact = \"load_dependent\"",
            Some(line_load),
        ),
    ] {
        let law = match line_load {
            None => format!("{law}\ncontact = \"linear\""),
            Some(_) => law.to_owned(),
        };
        let text = manifest(&law, CORES, "");
        let flanks = Flanks::new(&spec(&text).gears).unwrap();
        // The damper of pairs is that of the first spring, which has no error.
        let table = cycle(&text);
        let error = table.tangent_error();
        let tangent = !name.starts_with("pairs");
        let worst = off(
            name,
            &text,
            |phase, force| approach(&flanks, line_load, phase, force),
            |phase| {
                if tangent { table.value(&error, phase.rem_euclid(1.0)) } else { 0.0 }
            },
        );
        // The stiffness in joined pieces deviates from its table by 1e-5 times the length of a piece.
        assert!(worst < 1e-5, "{name}: {worst:e}");
    }
}

/// The cycle of the table that a manifest uses, under its load.
fn cycle(text: &str) -> MeshTableCycle {
    let spec = spec(text);
    let flanks = Flanks::new(&spec.gears).unwrap();
    let mut inputs = MeshTableInputs::of_gears(&spec.gears);
    inputs.torque = vec![LOAD * 50.0];
    inputs.slices = 1;
    inputs.contact = spec.contact;
    MeshTable::build(&flanks, &inputs, &|_, _| ())
        .unwrap()
        .cycle(0, 0)
}

/// Equal segments have the mean of the stiffness and the full error: b + e + F/k. The difference from the loaded
/// transmission error is the staircase of means; the test prints it. The harmonics of the error instead of the error
/// are truncated, and belong to the imposed transmission error.
#[test]
fn segments_and_harmonics_of_a_table() {
    let segments =
        "stiffness = \"table\"\nsegments = 24\nresolution = \"mean_load\"\ncontact = \"linear\"";
    let text = manifest(segments, CORES, "");
    let table = cycle(&text);
    let error = table.tangent_error();
    let ends: Vec<f64> = {
        let model = model(&text);
        model
            .first_cycle()
            .segments
            .iter()
            .map(|segment| segment.end)
            .collect()
    };
    let mean = |phase: f64| {
        let next = ends.partition_point(|end| *end <= phase);
        let from = if next == 0 { 0.0 } else { ends[next - 1] };
        table.means([from, ends[next]]).stiffness
    };
    let law = |phase: f64, force: f64| table.value(&error, phase) + force / mean(phase);
    let worst = off("table, 24 segments", &text, law, |phase| {
        table.value(&error, phase.rem_euclid(1.0))
    });
    assert!(worst < 1e-6, "{worst:e}");
    let staircase = (0..1000)
        .map(|i| (f64::from(i) + 0.5) / 1e3)
        .map(|phase| {
            let exact = table.value(&table.transmission_error, phase);
            (law(phase, table.force) / exact - 1.0).abs()
        })
        .fold(0.0, f64::max);
    println!("staircase of 24 segments: {staircase:.1e} of the loaded transmission error");
    assert!(staircase < 0.05, "{staircase}");

    // δ is along the line of action; the dynamic transmission error is δ + e.
    let excitation = "table_harmonics = 6";
    let imposed = |phase: f64| -> f64 {
        let waves = table.harmonics(&error, 6);
        (waves.iter())
            .map(|(m, amplitude, turn)| amplitude * (TAU * f64::from(*m) * phase + turn).cos())
            .sum()
    };
    let continuous = manifest(
        "stiffness = \"continuous\"\nresolution = \"mean_load\"\ncontact = \"linear\"",
        CORES,
        excitation,
    );
    let worst = off(
        "table, continuous, 6 harmonics",
        &continuous,
        |phase, force| force / table.value(&table.stiffness, phase),
        |_| 0.0,
    );
    assert!(worst < 1e-5, "{worst:e}");
    let text = manifest(segments, CORES, excitation);
    let mean_between = |phase: f64, force: f64| {
        let segment = (24.0 * phase).floor() / 24.0;
        force / table.means([segment, segment + 1.0 / 24.0]).stiffness
    };
    let worst = off(
        "table, 24 segments, 6 harmonics",
        &text,
        mean_between,
        |_| 0.0,
    );
    assert!(worst < 1e-6, "{worst:e}");
    let mean_error = table.mean(&error);
    let missed = (0..1000)
        .map(|i| (f64::from(i) + 0.5) / 1e3)
        .map(|phase| (imposed(phase) + mean_error - table.value(&error, phase)).abs())
        .fold(0.0, f64::max);
    println!(
        "6 harmonics of the error and its mean miss it by up to {:.2} um",
        1e6 * missed
    );
    assert!(missed > 1e-9);
}
