use super::*;
use crate::gear::{GearPair, ToothForm};
use std::time::Instant;

fn tooth(teeth: u32, shift: f64) -> Tooth {
    let pair = GearPair {
        teeth: [teeth, 30],
        module: 4e-3,
        pressure_angle: 20f64.to_radians(),
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: ToothForm { profile_shift: [shift, 0.0], ..ToothForm::default() },
    };
    Tooth::new(&pair, 0).unwrap()
}


#[test]
fn study() {
    let unit = Material { young_modulus: 1.0, poisson_ratio: 0.3 };
    for (z, ratio) in [(17, 1.15), (20, 1.458), (20, 3.18), (62, 2.0), (200, 1.2), (200, 4.0)] {
        let gear = tooth(z, if z == 17 { 0.1 } else { 0.0 });
        let range = [gear.form_roll + 0.1 * (gear.tip_roll - gear.form_roll), gear.tip_roll];
        let value = |a, b, c, h, terms| {
            let res = Resolution { across: a, along: b, foot: c, harmonics: h };
            let body = GearBody::resolved(&gear, z, ratio, &unit, range, 1, &res, terms).unwrap();
            let mut out = Vec::new();
            for i in 0..=16 {
                let roll = range[0] + (range[1] - range[0]) * f64::from(i) / 16.0;
                out.push([body.tooth(roll) , body.foundation(roll), body.coupling(roll, 1, roll).unwrap()]);
            }
            out
        };
        let exact = value(16, 20, 14, 400.0, [64, 16]);
        println!("z {z} ratio {ratio} theta {:.4}", gear.root_half_angle);
        for (a, b, c, h, n) in [(10, 12, 8, 100.0, [48, 14]), (12, 14, 10, 100.0, [48,14]), (12, 14, 10, 100.0, [48,16]), (12, 14, 10, 100.0, [48,12]), (14, 18, 12, 200.0, [64, 14])] {
            let found = value(a, b, c, h, n);
            let mut worst = [0.0f64; 2];
            for (f, e) in found.iter().zip(&exact) {
                worst[0] = worst[0].max(((f[0] + f[1]) / (e[0] + e[1]) - 1.0).abs());
                worst[1] = worst[1].max((f[2] / e[2] - 1.0).abs());
            }
            println!("  {a} {b} {c} {h} {n:?}: {:.2e} {:.2e}", worst[0], worst[1]);
        }
    }
}
