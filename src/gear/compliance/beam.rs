//! A tooth as a cantilever of varying section: three energies, one short function each.
//!
//! A force of 1 N per unit width acts along the line of action, at the angle β to the
//! perpendicular of the tooth's centre line: `cos β` bends, `sin β` compresses. A section at
//! height y has half thickness x, so that per unit width `A = 2 x`, `I = (2 x)³/12`. Each energy
//! U gives the compliance `2 U` (Yang & Lin 1987).

use crate::gear::{Material, Tooth};
use crate::numerics::quadrature::GaussLegendre;

/// Ratio of the largest to the mean shear stress's energy in a rectangular section
/// (Timoshenko; Tian 2004).
const SHEAR_FACTOR: f64 = 1.2;

/// Compliance of one tooth above its root circle, per unit width \[m²/N\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ToothCompliance {
    /// Bending.
    pub bending: f64,
    /// Shear.
    pub shear: f64,
    /// Compression along the tooth.
    pub axial: f64,
}

impl ToothCompliance {
    /// All three.
    pub fn total(&self) -> f64 {
        self.bending + self.shear + self.axial
    }
}

/// Where and how the unit force acts.
#[derive(Debug, Clone, Copy)]
struct Load {
    /// Height of the contact point \[m\].
    height: f64,
    /// Its distance from the centre line \[m\].
    arm: f64,
    sin: f64,
    cos: f64,
}

/// A section of the cantilever: height, half thickness, and the height dy it stands for \[m\].
#[derive(Debug, Clone, Copy)]
struct Slice {
    height: f64,
    half: f64,
    dy: f64,
}

/// `∫ M²/(E I) dy` with `M = (y_c − y) cos β − x_c sin β` (Yang & Lin 1987).
fn bending(load: &Load, slice: &Slice, young_modulus: f64) -> f64 {
    let moment = (load.height - slice.height) * load.cos - load.arm * load.sin;
    let inertia = 2.0 / 3.0 * slice.half.powi(3);
    moment * moment / (young_modulus * inertia) * slice.dy
}

/// `∫ 1.2 cos² β/(G A) dy` (Tian 2004).
fn shear(load: &Load, slice: &Slice, shear_modulus: f64) -> f64 {
    SHEAR_FACTOR * load.cos * load.cos / (shear_modulus * 2.0 * slice.half) * slice.dy
}

/// `∫ sin² β/(E A) dy` (Yang & Lin 1987).
fn axial(load: &Load, slice: &Slice, young_modulus: f64) -> f64 {
    load.sin * load.sin / (young_modulus * 2.0 * slice.half) * slice.dy
}

fn cantilever(
    load: &Load,
    material: &Material,
    slices: impl Iterator<Item = Slice>,
) -> ToothCompliance {
    let (young, shear_modulus) = (material.young_modulus, material.shear_modulus());
    slices.fold(ToothCompliance::default(), |sum, slice| ToothCompliance {
        bending: sum.bending + bending(load, &slice, young),
        shear: sum.shear + shear(load, &slice, shear_modulus),
        axial: sum.axial + axial(load, &slice, young),
    })
}

/// The tooth loaded at a roll angle of its involute: slices of fillet and involute at the nodes
/// of a Gauss rule each, in the parameter of the curve.
pub(super) fn tooth(
    tooth: &Tooth,
    roll: f64,
    material: &Material,
    rule: &GaussLegendre,
) -> ToothCompliance {
    let (sin, cos) = tooth.force_angle(roll).sin_cos();
    let point = tooth.flank(roll);
    let load = Load {
        height: point.y,
        arm: point.x,
        sin,
        cos,
    };
    let [joint, root] = tooth.fillet_range();
    // From the root upwards: the fillet's parameter falls.
    let fillet = nodes(rule, root, joint).map(|(normal, step)| {
        let point = tooth.fillet(normal);
        (point, step)
    });
    let flank = nodes(rule, tooth.form_roll, roll).map(|(roll, step)| (tooth.flank(roll), step));
    let slices = fillet.chain(flank).map(|(point, step)| Slice {
        height: point.y,
        half: point.x,
        dy: point.dy * step,
    });
    cantilever(&load, material, slices)
}

/// Nodes and weights of a rule on \[from, to\].
fn nodes(rule: &GaussLegendre, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    (rule.nodes.iter().zip(&rule.weights)).map(move |(x, w)| (centre + half * x, half * w))
}

#[cfg(test)]
#[path = "beam_tests.rs"]
mod tests;
