#![allow(clippy::unwrap_used)]
use super::*;
use crate::gear::compliance::body::GearBody;
use crate::gear::{Material, ToothForm, fixtures};

fn tooth(teeth: u32) -> Tooth {
    let pair = fixtures::pair([teeth, 30], ToothForm::default());
    Tooth::new(&pair, 0).unwrap()
}

fn middle(tooth: &Tooth) -> f64 {
    0.5 * (tooth.form_roll + tooth.tip_roll)
}

/// Under a uniform load a narrow gear is as compliant as in plane stress, a wide one between plane stress and strain.
#[test]
fn an_even_load_meets_the_plane_gear() {
    for (teeth, ratio) in [(20, 1.46), (30, 2.5)] {
        let gear = tooth(teeth);
        let roll = middle(&gear);
        let plane = |modulus: f64, poisson_ratio: f64| {
            let material = Material {
                young_modulus: modulus,
                poisson_ratio,
            };
            let range = [gear.form_roll, gear.tip_roll];
            let body = GearBody::new(&gear, teeth, ratio, &material, range, 0).unwrap();
            body.tooth(roll) + body.foundation(roll)
        };
        let stress = plane(1.0, 0.3);
        let strain = plane(1.0 / 0.91, 0.3 / 0.7);
        let even = |width: f64| {
            let solid = SolidGear::new(&gear, teeth, ratio, 0.3, width, 6, &[roll]).unwrap();
            solid.same_tooth[0][(0, 0)]
        };
        let (narrow, wide) = (even(2e-3) / stress, even(80e-3));
        assert!((narrow - 1.0).abs() < 0.03, "{narrow}");
        assert!(
            wide < 1.01 * stress && wide > 0.98 * strain,
            "{strain} {wide} {stress}"
        );
    }
}

/// The shorter a wave, the smaller is the compliance of the tooth to it. The coupling to the next tooth falls
/// even faster. A wave never causes a displacement of the loaded tooth with the opposite sign.
#[test]
fn short_waves_are_borne_by_stiffer_teeth() {
    let gear = tooth(20);
    let rolls = [middle(&gear), gear.tip_roll];
    let solid = SolidGear::new(&gear, 20, 1.46, 0.3, 20e-3, 6, &rolls).unwrap();
    for own in &solid.same_tooth {
        for n in 1..6 {
            assert!(
                own[(n, n)] > 0.0 && own[(n, n)] < own[(n - 1, n - 1)],
                "{own:?}"
            );
        }
    }
    let ahead = solid.coupling(1, [1, 0]);
    for n in 1..4 {
        let [own, next] =
            [&solid.same_tooth[0], &ahead].map(|matrix| matrix[(n, n)] / matrix[(0, 0)]);
        assert!(next < own, "{n}: {next} {own}");
    }
}
