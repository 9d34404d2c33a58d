//! How much the flanks flatten where they touch.

use crate::gear::Material;
use std::f64::consts::{FRAC_2_PI, PI};

/// Linear compliance per unit width, `2/π Σ (1 − ν²)/E` \[m²/N\]: for one material
/// `4 (1 − ν²)/(π E)` (Yang & Sun 1985), each body giving its half.
pub(super) fn linear(materials: &[Material; 2]) -> f64 {
    FRAC_2_PI * give(materials)
}

/// `Σ (1 − ν²)/E`, the reciprocal of the contact modulus E* \[1/Pa\].
fn give(materials: &[Material; 2]) -> f64 {
    materials
        .iter()
        .map(|material| material.plane_strain_modulus().recip())
        .sum()
}

/// Half the width of the contact of two cylinders of relative radius R under a line load w,
/// `√(4 w R/(π E*))` \[m\] (Johnson, Contact Mechanics, 1985, eq. 4.43).
pub(super) fn half_width(materials: &[Material; 2], radius: f64, line_load: f64) -> f64 {
    (4.0 * line_load * radius * give(materials) / PI).sqrt()
}

/// Approach of the contact to points at given depths below either surface under a line load
/// \[m\]: `w 2/π Σ (1 − ν²)/E (ln(2 h/a) − ν/(2 (1 − ν)))` with the half width a (Weber &
/// Banaschek 1953; Johnson 1985, eq. 5.58). It grows a little less than the load.
pub(super) fn approach(
    materials: &[Material; 2],
    radius: f64,
    depths: [f64; 2],
    line_load: f64,
) -> f64 {
    if line_load <= 0.0 {
        return 0.0;
    }
    let half_width = half_width(materials, radius, line_load);
    let bodies: f64 = (materials.iter().zip(depths))
        .map(|(material, depth)| {
            let nu = material.poisson_ratio;
            let logarithm = (2.0 * depth / half_width).ln();
            (logarithm - nu / (2.0 * (1.0 - nu))) / material.plane_strain_modulus()
        })
        .sum();
    FRAC_2_PI * line_load * bodies
}
