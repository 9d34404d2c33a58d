//! The helical gears of `manifests/gearbox.toml` in mesh compared with finite elements in three dimensions
//! (`tests/data/helical-fe.toml`, made by `scripts/records/record_helical_fe.py`).

#![allow(clippy::unwrap_used)]

use gearatlas::gear::{
    Face, FlankLaw, Flanks, GearPair, HelicalFace, Modification, Plane, Relief, SecantContact,
    ToothForm,
};

/// Slices of the face, as long as the cells of the elements.
const SLICES: usize = 20;

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

fn floats(table: &toml::Value, key: &str) -> Vec<f64> {
    let values = table[key].as_array().unwrap().iter();
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
    let file: toml::Value = include_str!("../data/helical-fe.toml").parse().unwrap();
    let flanks = Flanks::new(&gears(true)).unwrap();
    let path = flanks.path();
    let base = flanks.teeth.each_ref().map(|tooth| tooth.base_radius);
    let tip = flanks.teeth.each_ref().map(|tooth| tooth.tip_radius);
    for (key, own) in [
        ("base_radius", base),
        ("tip_radius", tip),
        ("path", [path.start, path.end]),
    ] {
        for (own, theirs) in own.iter().zip(floats(&file, key)) {
            assert!((own / theirs - 1.0).abs() < 1e-5, "{key}: {own} {theirs}");
        }
    }
}
