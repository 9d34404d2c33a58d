//! Teeth on a body against plane finite elements of the whole gear (`tests/data/tooth-fe.toml`,
//! made by `scripts/record_tooth_fe.py`).

#![allow(clippy::unwrap_used)]

use atlas::gear::{Flanks, GearPair, ToothForm};

/// Teeth and bodies give 4 to 6 % more than the elements say: the cantilever counts some of the
/// root twice. What a body gives at the neighbour is within 1.1 %.
#[test]
fn a_whole_gear_in_finite_elements() {
    let file: toml::Table = include_str!("data/tooth-fe.toml").parse().unwrap();
    let gear = &file["gear"].as_array().unwrap()[0];
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
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: ToothForm {
            bore: [Some(number("bore")), Some(30e-3)],
            ..ToothForm::default()
        },
    };
    let flanks = Flanks::new(&pair).unwrap();
    let young_modulus = pair.form.material[0].young_modulus;
    let tangent = flanks.pressure_angle.tan();
    let position = |roll: f64| (roll - tangent) * flanks.teeth[0].base_radius;
    let (rolls, own, coupling) = (column("roll"), column("own"), column("coupling"));
    for (&roll, own) in rolls.iter().zip(own) {
        let compliance = flanks.compliance(position(roll));
        let value = young_modulus * (compliance.tooth[0] + compliance.foundation[0]);
        assert!((value / own - 1.0).abs() < 0.07, "{roll}: {value} {own}");
    }
    assert_eq!(coupling.len(), 2);
    for (&roll, coupling) in rolls.iter().zip(coupling) {
        let value = young_modulus * flanks.body_coupling(position(roll), 1).unwrap()[0];
        assert!(
            (value / coupling - 1.0).abs() < 0.02,
            "{roll}: {value} {coupling}"
        );
    }
}
