//! How much do the flanks flatten where they touch?

use crate::gear::Material;
use std::f64::consts::{FRAC_2_PI, PI};

/// Linear compliance per unit width, `2/π Σ (1 − ν²)/E` \[m²/N\]: for one material
/// `4 (1 − ν²)/(π E)` (Yang & Sun 1985), half of it from each body.
pub(in crate::gear) fn linear(materials: &[Material; 2]) -> f64 {
    FRAC_2_PI * reciprocal_modulus(materials)
}

/// `Σ (1 − ν²)/E`, the reciprocal of the contact modulus E* \[1/Pa\].
fn reciprocal_modulus(materials: &[Material; 2]) -> f64 {
    materials
        .iter()
        .map(|material| material.plane_strain_modulus().recip())
        .sum()
}

/// Half the width of the contact of two cylinders of relative radius R under a line load w,
/// `√(4 w R/(π E*))` \[m\] (Johnson, Contact Mechanics, 1985, eq. 4.43).
pub(super) fn half_width(materials: &[Material; 2], radius: f64, line_load: f64) -> f64 {
    (4.0 * line_load * radius * reciprocal_modulus(materials) / PI).sqrt()
}

/// Approach of two points at depths h below the contact, one in each body, under a line load w
/// \[m\]: `w 2/π Σ (1 − ν²)/E (ln(2 h/a) − ν/(2 (1 − ν)))` with the half width a (Weber & Banaschek 1953; Johnson 1985,
/// eq. 5.58). The approach grows a little less than in proportion to the load.
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

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Material = Material {
        young_modulus: 206e9,
        poisson_ratio: 0.3,
    };
    const IRON: Material = Material {
        young_modulus: 115e9,
        poisson_ratio: 0.25,
    };

    #[test]
    fn one_material_gives_the_usual_formula() {
        let usual = PI * 206e9 / (4.0 * (1.0 - 0.09));
        assert!((linear(&[STEEL; 2]) * usual - 1.0).abs() < 1e-15);
        // A rigid mate halves the compliance.
        let rigid = Material {
            young_modulus: 1e30,
            ..STEEL
        };
        assert!((linear(&[STEEL, rigid]) * usual - 0.5).abs() < 1e-12);
    }

    /// The approach is the integral of the strain along the axis below the contact. The stresses are those under an
    /// elliptical pressure in plane strain (Johnson 1985, eq. 4.46).
    #[test]
    fn the_approach_is_the_strain_below_the_contact() {
        let materials = [STEEL, IRON];
        let (radius, load, depths) = (8e-3, 3e5, [3e-3, 5e-3]);
        let a = half_width(&materials, radius, load);
        let peak = 2.0 * load / (PI * a);
        let mut sum = 0.0;
        for (material, depth) in materials.iter().zip(depths) {
            let nu = material.poisson_ratio;
            // Steps that grow with depth: z = a sinh v.
            let (count, end) = (20_000, (depth / a).asinh());
            for i in 0..count {
                let v = end * (f64::from(i) + 0.5) / f64::from(count);
                let (z, dz) = (a * v.sinh(), a * v.cosh() * end / f64::from(count));
                let root = z.hypot(a);
                let axial = -peak * a / root;
                let lateral = -peak / a * ((a * a + 2.0 * z * z) / root - 2.0 * z);
                let strain =
                    ((1.0 - nu * nu) * axial - nu * (1.0 + nu) * lateral) / material.young_modulus;
                sum -= strain * dz;
            }
        }
        let approach = approach(&materials, radius, depths, load);
        // The formula drops terms of the order (a/h)².
        assert!((approach / sum - 1.0).abs() < 1e-3, "{approach} {sum} {a}");
    }

    #[test]
    fn the_contact_stiffens_under_load() {
        let at = |load: f64| approach(&[STEEL; 2], 8e-3, [3e-3; 2], load) / load;
        // At ten times the load each body's bracket is ln(10)/2 less.
        let drop = FRAC_2_PI * 2.0 * (0.91 / 206e9) * 0.5 * 10f64.ln();
        assert!(((at(1e4) - at(1e5)) / drop - 1.0).abs() < 1e-9);
        assert_eq!(approach(&[STEEL; 2], 8e-3, [3e-3; 2], 0.0), 0.0);
    }
}
