//! Pairs of gears in loaded contact compared with plane finite elements of both whole gears
//! (`tests/data/contact-fe.toml`, made by `scripts/records/record_contact_fe.py`): teeth, bodies, flattening and tip
//! edges off the path together. Also misaligned flanks compared with elements in three dimensions
//! (`tests/data/face-fe.toml`, `scripts/records/record_face_fe.py`).

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use gearatlas::gear::{
    Face, FlankLaw, Flanks, GearPair, IndependentSlices, LoadSharing, Plane, ToothForm, pairs_at,
};

fn number(value: &toml::Value) -> f64 {
    let whole = || value.as_integer().map(|i| i as f64);
    value.as_float().or_else(whole).unwrap()
}

fn floats(table: &toml::Value, key: &str) -> Vec<f64> {
    table[key].as_array().unwrap().iter().map(number).collect()
}

/// Approach, tangent stiffness and shares agree at every recorded phase of the mesh cycle.
#[test]
fn gears_in_contact_approach_as_finite_elements_say() {
    let file: toml::Table = include_str!("../data/contact-fe.toml").parse().unwrap();
    let cases = file["contact"].as_array().unwrap();
    assert_eq!(cases.len(), 8);
    for case in cases {
        let teeth: Vec<u32> = (case["teeth"].as_array().unwrap().iter())
            .map(|teeth| u32::try_from(teeth.as_integer().unwrap()).unwrap())
            .collect();
        let bores = floats(case, "bore");
        let face_width = case["face_width"].as_float().unwrap();
        let plane = match case["plane"].as_str().unwrap() {
            "strain" => Plane::Strain,
            _ => Plane::Stress,
        };
        let line_load = case["line_load"].as_float().unwrap();
        let flanks = Flanks::new(&GearPair {
            teeth: [teeth[0], teeth[1]],
            module: case["module"].as_float().unwrap(),
            pressure_angle: 20f64.to_radians(),
            helix_angle: 0.0,
            face_width,
            body_length: [face_width; 2],
            rated_torque: 50.0,
            form: ToothForm {
                bore: [Some(bores[0]), Some(bores[1])],
                plane,
                ..ToothForm::default()
            },
        })
        .unwrap();
        let face = Face {
            width: face_width,
            slices: 1,
        };
        let force = line_load * face_width;
        let (places, errors) = (floats(case, "place"), floats(case, "transmission_error"));
        let (tangents, shares) = (floats(case, "tangent"), case["shares"].as_array().unwrap());
        let [mut one, mut two, mut worst] = [[0.0_f64; 2]; 3];
        let mut apart = 0.0_f64;
        for (index, &place) in places.iter().enumerate() {
            let sharing =
                LoadSharing::under(&flanks, flanks.path().phase(place), face, 0.0, force).unwrap();
            let borne = sharing.distribute(force);
            let bearing = |shares: Vec<f64>| -> Vec<f64> {
                shares.into_iter().filter(|share| *share > 1e-9).collect()
            };
            // Pairs are in the order of their positions.
            let own = bearing(borne.share.to_vec());
            let recorded = shares[index].as_array().unwrap().iter();
            let theirs = bearing(recorded.map(|share| share.as_float().unwrap()).collect());
            assert_eq!(
                own.len(),
                theirs.len(),
                "{teeth:?} {plane:?} {line_load} at {place}"
            );
            for (a, b) in own.iter().zip(&theirs) {
                apart = apart.max((a - b).abs());
            }
            let off = [
                (borne.deflection / errors[index] - 1.0).abs(),
                (borne.stiffness / tangents[index] - 1.0).abs(),
            ];
            let meet = |worst: &mut [f64; 2]| {
                for (worst, off) in worst.iter_mut().zip(off) {
                    *worst = worst.max(off);
                }
            };
            meet(&mut worst);
            match own.len() {
                1 => meet(&mut one),
                2 if theirs.iter().all(|share| *share > 0.4) => meet(&mut two),
                _ => {}
            }
        }
        println!(
            "{teeth:?} {plane:?} {line_load} N/m: approach and stiffness off by {one:.4?} with one pair, \
             {two:.4?} with two, {worst:.4?} anywhere; shares by {apart:.4}"
        );
        // The flattening assumes plane strain in both cases, so that teeth in plane stress are stiffer.
        let bound = if plane == Plane::Strain { 0.03 } else { 0.052 };
        assert!(
            one.iter().chain(&two).all(|off| *off < bound),
            "{one:?} {two:?}"
        );
        // The largest differences occur when a tip edge has just come into contact.
        assert!(worst[0] < 0.08 && worst[1] < 0.12, "{worst:?}");
        assert!(apart < 0.036, "{apart}");
    }
}

/// The gears of a recorded pair in three dimensions.
fn gears_of(file: &toml::Table, pair: usize) -> (Flanks, f64) {
    let gears = &file["gear"].as_array().unwrap()[2 * pair..][..2];
    let float = |gear: usize, key: &str| number(&gears[gear][key]);
    let face_width = float(0, "face_width");
    let teeth =
        [0, 1].map(|gear| u32::try_from(gears[gear]["teeth"].as_integer().unwrap()).unwrap());
    let flanks = Flanks::new(&GearPair {
        teeth,
        module: float(0, "module"),
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width,
        body_length: [face_width; 2],
        rated_torque: 50.0,
        form: ToothForm {
            bore: [0, 1].map(|gear| Some(float(gear, "bore"))),
            plane: Plane::Stress,
            ..ToothForm::default()
        },
    });
    (flanks.unwrap(), face_width)
}

/// The displacements of both gears agree under waves of load along the face at the pitch point.
#[test]
fn waves_of_load_move_teeth_as_elements_in_three_dimensions_say() {
    let file: toml::Table = include_str!("../data/face-fe.toml").parse().unwrap();
    let gears = file["gear"].as_array().unwrap();
    let modulus = 206e9;
    for pair in 0..gears.len() / 2 {
        let (flanks, face_width) = gears_of(&file, pair);
        let face_coupling = flanks.face_coupling().unwrap();
        let own = face_coupling.of_pair(flanks.path().pitch_point).unwrap();
        let recorded: Vec<f64> = (0..10)
            .map(|wave| {
                let of = |gear: usize| {
                    let own = gears[2 * pair + gear]["own"].as_array().unwrap();
                    number(&own[2].as_array().unwrap()[wave])
                };
                of(0) + of(1)
            })
            .collect();
        let teeth = flanks.compliance(flanks.path().pitch_point);
        let even = (teeth.total() - teeth.hertz) * modulus;
        let ours: Vec<f64> = (0..own.nrows()).map(|n| own[(n, n)] * modulus).collect();
        println!("{face_width}: {even:.4} {ours:.4?}\n  recorded {recorded:?}");
        let whole = recorded[0];
        for (n, (ours, recorded)) in ours.iter().zip(&recorded[1..]).enumerate() {
            let off = (ours - recorded).abs() / whole;
            assert!(off < 0.02, "wave {}: {ours} {off}", n + 1);
        }
    }
}

/// Load centroid and loaded length agree for misaligned flanks with one pair at the pitch point.
#[test]
fn askew_flanks_bear_where_elements_in_three_dimensions_say() {
    let file: toml::Table = include_str!("../data/face-fe.toml").parse().unwrap();
    let mut worst = [0.0f64; 2];
    for case in file["wedge"].as_array().unwrap() {
        let pair = usize::try_from(case["pair"].as_integer().unwrap()).unwrap();
        let (flanks, face_width) = gears_of(&file, pair);
        let face = Face {
            width: face_width,
            slices: 1,
        };
        let misalignment = number(&case["misalignment"]);
        let force = number(&case["line_load"]) * face_width;
        let phase = flanks.path().phase(flanks.path().pitch_point);
        let [centre, length, _] = floats(case, "contact")[..] else {
            panic!("three figures");
        };
        let distribute = |law: &dyn Fn() -> LoadSharing| {
            let borne = law().distribute(force);
            [borne.centre, borne.contact_fraction * face_width]
        };
        let coupled = distribute(&|| {
            let pairs = pairs_at(&flanks, phase, face).unwrap();
            LoadSharing::new(&pairs, face, misalignment).unwrap()
        });
        let alone = distribute(&|| {
            let pairs = pairs_at(&IndependentSlices(&flanks), phase, face).unwrap();
            LoadSharing::new(&pairs, face, misalignment).unwrap()
        });
        println!(
            "{pair} {misalignment}: centroid {:.4e} m, recorded {centre:.4e}, slices alone {:.4e}; \
             length {:.4e} m, recorded {length:.4e}, slices alone {:.4e}",
            coupled[0], alone[0], coupled[1], alone[1]
        );
        let off = [coupled[0] / centre - 1.0, coupled[1] / length - 1.0].map(f64::abs);
        for (worst, off) in worst.iter_mut().zip(off) {
            *worst = worst.max(off);
        }
        // Independent slices give a load centroid too near mid-face, and a loaded length too large in partial contact.
        assert!(alone[0].abs() < 0.95 * centre.abs());
        assert!(length > 0.95 * face_width || alone[1] > 1.15 * length);
    }
    println!("largest errors {worst:.4?}");
    assert!(worst[0] < 0.03 && worst[1] < 0.05, "{worst:?}");
}
