use super::*;
use crate::gear::{BasicRack, GearPair, ToothForm, fixtures};
use std::f64::consts::FRAC_PI_2;

const RESOLUTION: Resolution = Resolution {
    degree_across: 12,
    degree_along: 14,
    foot_modes: 10,
    harmonics: 100.0,
};

fn tooth(teeth: u32, pressure_angle: f64, rack: BasicRack) -> Tooth {
    let form = ToothForm {
        rack,
        ..ToothForm::default()
    };
    let pair = GearPair {
        pressure_angle,
        ..fixtures::pair([teeth; 2], form)
    };
    Tooth::new(&pair, 0).unwrap()
}

fn usual(teeth: u32) -> Tooth {
    tooth(teeth, 20f64.to_radians(), BasicRack::default())
}

/// A motion of the foot in its modes; `motion` gives its radial and tangential part from sine and
/// cosine of the angle.
fn modes_of(half_angle: f64, motion: impl Fn(f64, f64) -> [f64; 2]) -> Vec<f64> {
    let count = RESOLUTION.foot_modes;
    let rule = GaussLegendre::new(24);
    let mut modes = vec![0.0; 2 * count];
    for (place, weight) in rule.nodes.iter().zip(&rule.weights) {
        let (sin, cos) = (place * half_angle).sin_cos();
        let [radial, tangential] = motion(sin, cos);
        for (m, [polynomial, _]) in legendre(*place, count - 1).into_iter().enumerate() {
            let scale = weight * ((m as f64 + 0.5) * half_angle).sqrt() * polynomial;
            modes[m] += scale * radial;
            modes[count + m] += scale * tangential;
        }
    }
    modes
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// A foot that moves rigidly carries the tooth with it, without stress. The forces on the foot balance the force on the
/// flank and its moment about the gear's axis (base radius times force).
#[test]
fn rigid_motions_are_free_and_forces_in_equilibrium() {
    for gear in [usual(20), usual(120)] {
        let rolls = [0.5 * (gear.form_roll + gear.tip_roll), gear.tip_roll];
        let plate = Plate::new(&gear, 0.3, &rolls, &RESOLUTION).unwrap();
        let foot = gear.root_half_angle;
        let arm = gear.base_radius / gear.root_radius;
        let motions = [
            modes_of(foot, |sin, cos| [sin, cos]),
            modes_of(foot, |sin, cos| [cos, -sin]),
            modes_of(foot, |_, _| [0.0, 1.0]),
        ];
        for (&roll, forces) in rolls.iter().zip(&plate.forces) {
            let (sin, cos) = gear.force_angle(roll).sin_cos();
            for (motion, work) in motions.iter().zip([-cos, -sin, -arm]) {
                let found = dot(forces, motion);
                assert!((found - work).abs() < 1e-9, "{found} {work}");
            }
        }
        for motion in &motions {
            for i in 0..motion.len() {
                let row: Vec<f64> = (0..motion.len()).map(|j| plate.stiffness[(i, j)]).collect();
                assert!(dot(&row, motion).abs() < 1e-9, "{i}: {}", dot(&row, motion));
            }
        }
    }
}

/// Compliance of a tooth as a cantilever, times Young's modulus, from slices of equal parameter: bending, shear
/// (factor 1.2 of the section) and compression (Yang & Lin 1987; Tian 2004).
fn cantilever(gear: &Tooth, roll: f64, poisson_ratio: f64) -> f64 {
    let (sin, cos) = gear.force_angle(roll).sin_cos();
    let load = gear.flank(roll);
    let [joint, root] = gear.fillet_range();
    let slices = 2000;
    let mut sum = 0.0;
    for index in 0..slices {
        let part = (f64::from(index) + 0.5) / f64::from(slices);
        let fillet = gear.fillet(root + (joint - root) * part);
        let flank = gear.flank(gear.form_roll + (roll - gear.form_roll) * part);
        for (point, step) in [(fillet, joint - root), (flank, roll - gear.form_roll)] {
            let moment = (load.y - point.y) * cos - load.x * sin;
            let bending = moment * moment / (2.0 / 3.0 * point.x.powi(3));
            let shear = 1.2 * 2.0 * (1.0 + poisson_ratio) * cos * cos / (2.0 * point.x);
            let compression = sin * sin / (2.0 * point.x);
            sum += (bending + shear + compression) * point.dy * step / f64::from(slices);
        }
    }
    sum
}

/// A slender tooth approaches the beam of the potential-energy method. It is a rack tooth with nearly parallel
/// flanks, 2.2 to 5 modules high and 1.6 thick. The plate is 6.9, 3.8 and 2.4 % stiffer, because its foot does not
/// warp. This equals a beam that is shorter by the same part of its thickness at any height.
#[test]
fn a_slender_tooth_is_a_cantilever() {
    let excess = |height: f64| {
        let rack = BasicRack {
            addendum: 0.45 * height,
            dedendum: 0.55 * height,
            tip_radius: 0.1,
        };
        let gear = tooth(4000, 4f64.to_radians(), rack);
        let resolution = Resolution {
            degree_along: 20,
            ..RESOLUTION
        };
        let plate = Plate::new(&gear, 0.3, &[gear.tip_roll], &resolution).unwrap();
        plate.clamped[0] / cantilever(&gear, gear.tip_roll, 0.3) - 1.0
    };
    let heights = [2.2, 3.5, 5.0];
    let found = heights.map(excess);
    assert!(found.iter().all(|excess| *excess < 0.0), "{found:?}");
    // Shortening of the beam that has the same effect: 3 % of the thickness.
    for (excess, height) in found.iter().zip(heights) {
        let shorter = -excess * height / 3.0 / FRAC_PI_2;
        assert!((0.02..0.04).contains(&shorter), "{shorter}");
    }
}

/// The profile bounds the plate: the area from the nodes equals the area between the curves.
#[test]
fn nodes_fill_the_plate() {
    let gear = usual(20);
    let unit = gear.root_radius;
    let area: f64 = interior(&gear, &RESOLUTION)
        .iter()
        .map(|[_, _, area]| area)
        .sum();
    // Twice the area of the sector between a curve and the gear's axis.
    let [joint, root] = gear.fillet_range();
    let sectors = |curve: &dyn Fn(f64) -> crate::gear::ProfilePoint, from: f64, to: f64| -> f64 {
        let count = 20_000;
        (0..count)
            .map(|i| curve(from + (to - from) * (f64::from(i) + 0.5) / f64::from(count)))
            .map(|p| (p.x * p.dy - p.y * p.dx) * (to - from) / f64::from(count))
            .sum()
    };
    // Green's theorem round the tooth: both profiles, the tip's arc and the foot's.
    let profile = sectors(&|t| gear.fillet(t), root, joint)
        + sectors(&|t| gear.flank(t), gear.form_roll, gear.tip_roll);
    let tip = gear.flank(gear.tip_roll);
    let arcs = gear.tip_radius.powi(2) * tip.x.atan2(tip.y)
        - gear.root_radius.powi(2) * gear.root_half_angle;
    let exact = (profile + arcs) / (unit * unit);
    assert!((area / exact - 1.0).abs() < 1e-6, "{area} {exact}");
}
