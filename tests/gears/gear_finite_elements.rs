//! Teeth on a body compared with plane finite elements of the whole gear (`tests/data/tooth-fe.toml`, made by
//! `scripts/records/record_tooth_fe.py`).

#![allow(clippy::unwrap_used)]

use gearatlas::gear::{Flanks, GearPair, Plane, ToothForm};

/// Tooth and body agree with the elements within 0.1 %, from 17 to 62 teeth, root over bore from 1.45 to 6, in plane
/// stress and strain, from the root to the tip. At the neighbour the body is 0.02 to 0.16 % more compliant: there the
/// displacement is that of the flank, so that two teeth affect each other symmetrically, but that of the elements is on
/// the centre line.
#[test]
fn a_whole_gear_in_finite_elements() {
    let file: toml::Table = include_str!("../data/tooth-fe.toml").parse().unwrap();
    let gears = file["gear"].as_array().unwrap();
    assert!(gears.len() >= 11, "{}", gears.len());
    for gear in gears {
        let number = |key: &str| gear[key].as_float().unwrap();
        let column = |key: &str| -> Vec<f64> {
            let values = gear[key].as_array().unwrap().iter();
            values.map(|value| value.as_float().unwrap()).collect()
        };
        let teeth = u32::try_from(gear["teeth"].as_integer().unwrap()).unwrap();
        let pair = GearPair {
            teeth: [teeth, 30],
            module: number("module"),
            pressure_angle: 20f64.to_radians(),
            helix_angle: 0.0,
            face_width: 20e-3,
            body_length: [20e-3; 2],
            rated_torque: 50.0,
            form: ToothForm {
                profile_shift: [number("profile_shift"), 0.0],
                tip_diameter: [Some(number("tip_diameter")), None],
                bore: [Some(number("bore")), Some(30e-3)],
                plane: match gear["plane"].as_str().unwrap() {
                    "stress" => Plane::Stress,
                    "strain" => Plane::Strain,
                    other => panic!("{other}"),
                },
                ..ToothForm::default()
            },
        };
        let flanks = Flanks::new(&pair).unwrap();
        let young_modulus = pair.form.material[0].young_modulus;
        let tangent = flanks.pressure_angle.tan();
        let position = |roll: f64| (roll - tangent) * flanks.teeth[0].base_radius;
        let within = |value: f64, elements: f64, [least, most]: [f64; 2]| {
            let excess = value / elements - 1.0;
            assert!(
                (least..=most).contains(&excess),
                "{teeth} teeth, {value}: {:+.3} %",
                100.0 * excess
            );
        };
        let (rolls, own, coupling) = (column("roll"), column("own"), column("coupling"));
        assert!(rolls.len() >= 5 && coupling.len() >= 2);
        for (&roll, own) in rolls.iter().zip(own) {
            let compliance = flanks.compliance(position(roll));
            let value = young_modulus * (compliance.tooth[0] + compliance.foundation[0]);
            within(value, own, [-1e-3, 1e-3]);
        }
        for (&roll, coupling) in rolls.iter().zip(coupling) {
            let value = young_modulus * flanks.body_coupling(position(roll), 1).unwrap()[0];
            within(value, coupling, [-1e-3, 2e-3]);
        }
    }
}
