//! The gear body as an elastic ring, clamped at its bore and loaded on arcs of its root circle, the
//! feet of its teeth. The ring of inner teeth is loaded on its inside and clamped at its outer diameter.
//!
//! Each harmonic of the stress gives displacements in closed form (Michell's solution; Barber,
//! Elasticity, 3rd ed., table 9.1, plane stress). If the tractions of the feet differ only by a
//! phase of `2π k/z` from tooth to tooth, they load only the harmonics n = k, k ± z, k ± 2z …. The
//! problem of all teeth therefore separates into waves, each as small as that of one tooth.
//!
//! Lengths are in root radii and stresses in Young's moduli here, so every compliance
//! comes out times E per unit width.

use crate::numerics::bessel::{LANES, ORDERS, spherical_bessel};
use crate::numerics::linalg;
use faer::Mat;
use std::f64::consts::PI;

/// A bore is negligible for a harmonic if it changes the compliance by less than this part.
const NEGLIGIBLE: f64 = 1e-17;

/// Phase of a mode of a foot in quarter turns, of `count` radial modes followed
/// by as many tangential ones. With these phases the compliance of a wave is real.
pub(super) fn quarter_turns(mode: usize, count: usize) -> usize {
    match mode.checked_sub(count) {
        None => mode,
        Some(degree) => degree + 3,
    }
}

/// A wave k of 0 … z/2 to which a harmonic contributes, the transforms of the foot's polynomials for this
/// harmonic, and the direction of the harmonic round the gear (±1).
pub(super) type Alias = (usize, Vec<f64>, f64);

/// Calls `each` for every harmonic up to about `most / half_angle`, with the waves to which the harmonic
/// contributes. Returns `None` as soon as `each` does. Each of the z feet has the half angle `half_angle`
/// \[rad\] and `foot` polynomials.
pub(super) fn harmonics(
    teeth: u32,
    half_angle: f64,
    foot: usize,
    most: f64,
    mut each: impl FnMut(u64, &[Alias]) -> Option<()>,
) -> Option<()> {
    let teeth = u64::from(teeth);
    let share = teeth as f64 / (2.0 * PI);
    // The transform of the polynomial m of the foot is a spherical Bessel function.
    let scales: Vec<f64> = (0..foot)
        .map(|m| ((2.0 * m as f64 + 1.0) * 2.0 * half_angle * share).sqrt())
        .collect();
    let mut uniform = vec![0.0; foot];
    uniform[0] = scales[0];
    each(0, &[(0, uniform, 1.0)])?;
    let last = (most / half_angle).ceil() as u64;
    let mut bessel = [[0.0; LANES]; ORDERS];
    for first in (1..=last).step_by(LANES) {
        let place: [f64; LANES] =
            std::array::from_fn(|lane| (first + lane as u64) as f64 * half_angle);
        let (sin, cos) = (place.map(f64::sin), place.map(f64::cos));
        spherical_bessel(&place, &sin, &cos, &mut bessel);
        for lane in 0..LANES {
            let order = first + lane as u64;
            let transform = |m: usize, sense: f64| {
                let sign = if m.is_multiple_of(2) { 1.0 } else { sense };
                sign * (scales[m] * bessel[m][lane])
            };
            // Also the harmonic that runs in the opposite direction.
            let wave = order % teeth;
            let aliases: Vec<Alias> = [(wave, 1.0), ((teeth - wave) % teeth, -1.0)]
                .into_iter()
                .filter(|(wave, _)| *wave <= teeth / 2)
                .map(|(wave, sense)| {
                    let transforms = (0..foot).map(|m| transform(m, sense)).collect();
                    (wave as usize, transforms, sense)
                })
                .collect();
            each(order, &aliases)?;
        }
    }
    Some(())
}

/// Compliance matrices over the modes of a foot, one per wave k = 0 … z/2 round z feet of a half angle \[rad\]. Every
/// foot has `foot` polynomials in either direction. The sum ends at the harmonic `most` over the half angle.
pub(super) fn waves(
    teeth: u32,
    half_angle: f64,
    ring: &Ring,
    foot: usize,
    most: f64,
) -> Vec<Mat<f64>> {
    let mut waves = vec![Mat::zeros(2 * foot, 2 * foot); (teeth / 2) as usize + 1];
    harmonics(teeth, half_angle, foot, most, |order, aliases| {
        let [rr, rt, tt] = match order {
            0 => [ring.breathing(), 0.0, ring.twist()],
            _ => {
                let [[rr, rt], [_, tt]] = ring.harmonic(order);
                [rr, rt, tt]
            }
        };
        for (wave, transforms, sense) in aliases {
            let wave = &mut waves[*wave];
            for (j, one) in transforms.iter().enumerate() {
                for (i, other) in transforms.iter().enumerate() {
                    let product = one * other;
                    wave[(i, j)] += rr * product;
                    wave[(foot + i, j)] += sense * rt * product;
                    wave[(i, foot + j)] += sense * rt * product;
                    wave[(foot + i, foot + j)] += tt * product;
                }
            }
        }
        Some(())
    });
    waves
}

/// An elastic ring of Young's modulus 1, loaded at its root radius 1: from outside and clamped at its bore, or from
/// inside and clamped at its outer diameter.
pub(super) struct Ring {
    /// Radius at which the ring is clamped: below 1 at a bore, above 1 at an outer diameter.
    clamped_radius: f64,
    shear: f64,
    /// Lamé's first constant of plane stress.
    lame: f64,
    /// Kolosov's constant of plane stress.
    kolosov: f64,
}

/// Radial and tangential displacement at a radius and their derivatives by the radius.
type Basis = [f64; 4];

impl Ring {
    /// A ring with a ratio of root radius to clamped radius, which is below 1 for inner teeth.
    pub fn new(ratio: f64, poisson_ratio: f64) -> Self {
        let shear = 0.5 / (1.0 + poisson_ratio);
        let kolosov = (3.0 - poisson_ratio) / (1.0 + poisson_ratio);
        Self {
            clamped_radius: 1.0 / ratio,
            shear,
            lame: shear * (3.0 - kolosov) / (kolosov - 1.0),
            kolosov,
        }
    }

    /// Tangential displacement by a uniform tangential stress: `v = C (r − r_i²/r)` with the clamped radius r_i.
    fn twist(&self) -> f64 {
        let clamped = self.clamped_radius * self.clamped_radius;
        (1.0 - clamped).abs() / (2.0 * self.shear * clamped)
    }

    /// Radial displacement by a uniform radial stress: `u = C (r − r_i²/r)` with the clamped radius r_i.
    fn breathing(&self) -> f64 {
        let clamped = self.clamped_radius * self.clamped_radius;
        (1.0 - clamped).abs() / (2.0 * self.lame + 2.0 * self.shear * (1.0 + clamped))
    }

    /// Displacements at the root circle by unit tractions there, `[[rr, rt], [rt, tt]]`: radial
    /// cosines and tangential sines. Tractions on the inside are the stresses with the opposite sign.
    fn harmonic(&self, order: u64) -> [[f64; 2]; 2] {
        let n = order as f64;
        let side = if self.clamped_radius < 1.0 { 1.0 } else { -1.0 };
        if side * 2.0 * n * self.clamped_radius.ln() + 2.0 * n.ln() < NEGLIGIBLE.ln() {
            // A disc without a bore; with −n in place of n, a hole in an infinite plate.
            let (first, second) = (1.0 / (n - side), self.kolosov / (n + side));
            let like = 0.25 / self.shear * (second + first);
            let cross = side * 0.25 / self.shear * (second - first);
            return [[like, cross], [cross, like]];
        }
        let clamped = self.basis(order, self.clamped_radius);
        let loaded = self.basis(order, 1.0);
        // Each column: displacements where clamped, then tractions at the root circle by Hooke's law.
        let columns: [[f64; 4]; 4] = std::array::from_fn(|j| {
            let [u, v, du, dv] = loaded[j];
            [
                clamped[j][0],
                clamped[j][1],
                side * (self.lame * (du + u + n * v) + 2.0 * self.shear * du),
                side * (self.shear * (dv - v - n * u)),
            ]
        });
        let inverse = linalg::invert(&columns);
        let at = |component: usize, load: usize| -> f64 {
            (0..4)
                .map(|j| loaded[j][component] * inverse[2 + load][j])
                .sum()
        };
        [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]]
    }

    /// The four displacement fields of a harmonic, scaled at the radius where they are largest.
    fn basis(&self, order: u64, r: f64) -> [Basis; 4] {
        let (k, n) = (self.kolosov, order as f64);
        let (inside, outside) = (self.clamped_radius.min(1.0), self.clamped_radius.max(1.0));
        let power = |coefficients: [f64; 2], exponent: f64, scale: f64| -> Basis {
            let value = (r / scale).powf(exponent);
            let by = exponent * (r / scale).powf(exponent - 1.0) / scale;
            let [u, v] = coefficients;
            [u * value, v * value, u * by, v * by]
        };
        // A translation and a force along a line through the centre (Kelvin) at order 1.
        let [first, second] = if order == 1 {
            let logarithm = k * r.ln();
            [
                [1.0, -1.0, 0.0, 0.0],
                [0.5 - logarithm, 0.5 + logarithm, -k / r, k / r],
            ]
        } else {
            [
                power([-n, n], n - 1.0, outside),
                power([k + n - 1.0, n - 1.0 - k], 1.0 - n, inside),
            ]
        };
        [
            first,
            second,
            power([k - n - 1.0, k + n + 1.0], n + 1.0, outside),
            power([n, n], -n - 1.0, inside),
        ]
    }
}

#[cfg(test)]
#[path = "ring_tests.rs"]
mod tests;
