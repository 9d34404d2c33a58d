//! The helical gears of `manifests/gearbox.toml` in mesh compared with finite elements in three dimensions
//! (`tests/data/helical-fe.toml`, made by `scripts/records/record_helical_fe.py`).

#![allow(clippy::unwrap_used)]

use gearatlas::gear::{
    Face, Flanks, GearPair, HelicalFace, Modification, Plane, Relief, SecantContact, ToothForm,
};

/// Slices of the face, as in the program's tables.
const SLICES: usize = 64;

/// The gears of the manifest, with or without tip relief and crowning.
fn gears(modified: bool) -> GearPair {
    let mut form = ToothForm {
        profile_shift: [0.166, 0.0098],
        thinning: [82e-6; 2],
        centre_distance: Some(75e-3),
        bore: [Some(32e-3), Some(36e-3)],
        plane: Plane::Strain,
        ..ToothForm::default()
    };
    if modified {
        form.tip_relief = [Relief {
            amount: 20e-6,
            length: 1.6e-3,
            ..Relief::default()
        }; 2];
        form.lead[0] = Modification {
            crowning: 4e-6,
            slope: 0.0,
        };
    }
    GearPair {
        teeth: [29, 42],
        module: 2e-3,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 18f64.to_radians(),
        face_width: 17e-3,
        body_length: [17e-3; 2],
        rated_torque: 190.0,
        form,
    }
}

fn floats(values: &toml::Value) -> Vec<f64> {
    let values = values.as_array().unwrap().iter();
    values.map(|value| value.as_float().unwrap()).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Peak-to-peak value.
fn span(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::MIN, f64::max);
    most - values.iter().copied().fold(f64::MAX, f64::min)
}

/// Both derive the same transverse section from the drawing.
#[test]
fn elements_have_the_radii_and_the_path_of_the_drawing() {
    let file: toml::Table = include_str!("../data/helical-fe.toml").parse().unwrap();
    let flanks = Flanks::new(&gears(true)).unwrap();
    let path = flanks.path();
    let base = flanks.teeth.each_ref().map(|tooth| tooth.base_radius);
    let tip = flanks.teeth.each_ref().map(|tooth| tooth.tip_radius);
    for (key, own) in [
        ("base_radius", base),
        ("tip_radius", tip),
        ("path", [path.start, path.end]),
    ] {
        for (own, theirs) in own.iter().zip(floats(&file[key])) {
            assert!((own / theirs - 1.0).abs() < 1e-5, "{key}: {own} {theirs}");
        }
    }
}

/// Largest deviations of the program from the elements.
struct Bounds {
    torque: f64,
    modified: bool,
    /// Relative, of the means over the cycle: transmission error, stiffness.
    means: [f64; 2],
    /// Relative, of the same at any mesh phase.
    anywhere: [f64; 2],
    /// Of the peak-to-peak values: transmission error \[m\], stiffness over its mean.
    spans: [f64; 2],
}

/// Measured deviations, rounded up. The slices of helical gears bear their loads alone. In three dimensions the loaded
/// part of a tooth is supported by the rest, the more the shorter its line of contact. The approach under light load
/// therefore varies while two teeth share the middle of the face, and that of independent slices hardly does.
/// Relieved ends of the lines bear less in three dimensions, because loaded neighbours move them away.
const BOUNDS: [Bounds; 6] = [
    Bounds {
        torque: 5.0,
        modified: true,
        means: [0.17, 0.05],
        anywhere: [0.28, 0.11],
        spans: [0.18e-6, 0.12],
    },
    Bounds {
        torque: 10.0,
        modified: true,
        means: [0.09, 0.03],
        anywhere: [0.17, 0.08],
        spans: [0.27e-6, 0.08],
    },
    Bounds {
        torque: 95.0,
        modified: true,
        means: [0.06, 0.06],
        anywhere: [0.08, 0.08],
        spans: [0.71e-6, 0.006],
    },
    Bounds {
        torque: 190.0,
        modified: true,
        means: [0.08, 0.09],
        anywhere: [0.09, 0.12],
        spans: [0.51e-6, 0.014],
    },
    Bounds {
        torque: 10.0,
        modified: false,
        means: [0.07, 0.05],
        anywhere: [0.09, 0.07],
        spans: [0.006e-6, 0.007],
    },
    Bounds {
        torque: 190.0,
        modified: false,
        means: [0.10, 0.09],
        anywhere: [0.12, 0.12],
        spans: [0.51e-6, 0.028],
    },
];

/// The mesh at each recorded phase, with the flattening of the program's tables: transmission error, tangent stiffness
/// and the largest line load of a pair.
fn mesh(flanks: &Flanks, force: f64, phases: &[f64]) -> [Vec<f64>; 3] {
    let face = Face {
        width: flanks.face_width,
        slices: SLICES,
    };
    let law = SecantContact {
        law: flanks,
        line_load: force / face.width,
    };
    let mut found: [Vec<f64>; 3] = Default::default();
    for &phase in phases {
        let lines = HelicalFace::new(&law, phase, face).unwrap();
        let sharing = lines.sharing(0.0).unwrap();
        let load = sharing.distribute(force);
        let pattern = sharing.pattern(force);
        found[0].push(load.deflection);
        found[1].push(load.stiffness);
        found[2].push(pattern.into_iter().fold(0.0, f64::max));
    }
    found
}

/// Transmission error and stiffness agree with the elements within the deviations of [`BOUNDS`]. Under light loads one
/// pair at a time bears the middle of the face at the later phases; independent slices spread the load too wide there.
#[test]
fn helical_teeth_in_mesh() {
    let file: toml::Table = include_str!("../data/helical-fe.toml").parse().unwrap();
    let phases = floats(&file["phase"]);
    let cases = file["case"].as_array().unwrap();
    assert_eq!(cases.len(), BOUNDS.len());
    for (case, bounds) in cases.iter().zip(&BOUNDS) {
        let (torque, modified) = (case["torque"].as_float(), case["modified"].as_bool());
        assert_eq!(
            (torque, modified),
            (Some(bounds.torque), Some(bounds.modified))
        );
        let flanks = Flanks::new(&gears(bounds.modified)).unwrap();
        let force = bounds.torque / flanks.teeth[0].base_radius;
        let [errors, stiffness, peaks] = mesh(&flanks, force, &phases);
        let theirs = ["transmission_error", "tangent", "peak"].map(|key| floats(&case[key]));
        let off = |own: &[f64], theirs: &[f64]| mean(own) / mean(theirs) - 1.0;
        let worst = |own: &[f64], theirs: &[f64]| {
            let each = own.iter().zip(theirs);
            each.map(|(own, theirs)| (own / theirs - 1.0).abs())
                .fold(0.0, f64::max)
        };
        let means = [off(&errors, &theirs[0]), off(&stiffness, &theirs[1])];
        let anywhere = [worst(&errors, &theirs[0]), worst(&stiffness, &theirs[1])];
        let relative = |values: &[f64]| span(values) / mean(values);
        let spans = [
            span(&errors) - span(&theirs[0]),
            relative(&stiffness) - relative(&theirs[1]),
        ];
        // At the last five phases.
        let peak = off(&peaks[7..], &theirs[2][7..]);
        println!(
            "{} N m, modified {}: means off by {means:.4?}, at any phase {anywhere:.4?}, peak to peak \
             {spans:?}, peak of late phases {peak:.4}, of all {:.4}",
            bounds.torque,
            bounds.modified,
            off(&peaks, &theirs[2])
        );
        for (found, bounds) in [
            (means, bounds.means),
            (anywhere, bounds.anywhere),
            (spans, bounds.spans),
        ] {
            for (found, bound) in found.iter().zip(bounds) {
                assert!(found.abs() < bound, "{found} {bound}");
            }
        }
        if bounds.modified && bounds.torque <= 10.0 {
            assert!((-0.25..0.0).contains(&peak), "{peak}");
        }
    }
}

/// The bodies of the drawn bores yield as in the elements without the axial part of the force, and a quarter less than
/// with it: in the elements it bends them against their bores, which the plane rings of the program cannot.
#[test]
fn bodies_have_no_axial_elasticity() {
    let file: toml::Table = include_str!("../data/helical-fe.toml").parse().unwrap();
    let phases: Vec<f64> = floats(&file["phase"]).into_iter().step_by(2).collect();
    let bodies = file["body"].as_array().unwrap();
    let compliances: Vec<[f64; 3]> = (bodies.iter())
        .map(|body| {
            let mut gears = gears(false);
            gears.form.bore = [0, 1].map(|gear| Some(floats(&body["bore"])[gear]));
            let flanks = Flanks::new(&gears).unwrap();
            let force = 10.0 / flanks.teeth[0].base_radius;
            let [_, own, _] = mesh(&flanks, force, &phases);
            let theirs = floats(&body["stiffness"]);
            [mean(&own), theirs[0], theirs[1]].map(f64::recip)
        })
        .collect();
    let [own, with_thrust, without] =
        [0, 1, 2].map(|index| compliances[0][index] - compliances[1][index]);
    println!("bodies: {own:e}, elements {with_thrust:e}, without axial force {without:e} m/N");
    assert!((own / without - 1.0).abs() < 0.04);
    assert!((0.74..0.80).contains(&(own / with_thrust)));
}
