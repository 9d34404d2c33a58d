//! The gear body as an elastic ring of the width of the face, with free ends, clamped at its bore.
//!
//! For the first harmonics round the gear the displacements are polynomials of radius and of z, by Ritz's method. The
//! displacements of higher harmonics decay within a short distance from the load and do not reach the bore. A wave
//! along the face and round the gear is then one of an elastic half space: plane strain along its wave vector and shear
//! across this vector. Lengths are in root radii and stresses in Young's moduli.

use super::axial::{FaceIntegrals, add_product, mirror};
use super::tooth::{FOOT, modes, moduli};
use crate::gear::compliance::plate::legendre;
use crate::gear::compliance::ring::harmonics;
use crate::numerics::linalg;
use crate::numerics::quadrature::GaussLegendre;
use faer::Mat;

/// The last harmonic that is solved by polynomials of radius and z.
const EXACT: u64 = 30;

/// Number of polynomials of the radius.
const RADIAL: usize = 6;

/// Highest harmonic, times the half angle of the foot.
const HARMONICS: f64 = 40.0;

/// Compliance matrices over the modes of a foot, one per wave k = 0 … z/2 round z feet of a half angle \[rad\], on a
/// ring with a ratio of root to bore radius. `None` if the numbers are not finite.
pub(super) fn waves(
    teeth: u32,
    half_angle: f64,
    ratio: f64,
    poisson_ratio: f64,
    axial: &FaceIntegrals,
) -> Option<Vec<Mat<f64>>> {
    let ring = SolidRing::new(ratio, poisson_ratio, axial);
    let modes = modes(axial);
    let mut waves = vec![Mat::zeros(modes, modes); (teeth / 2) as usize + 1];
    harmonics(teeth, half_angle, FOOT, HARMONICS, |order, aliases| {
        let harmonic = ring.harmonic(order)?;
        for (wave, transforms, sense) in aliases {
            ring.add(&mut waves[*wave], &harmonic, transforms, *sense);
        }
        Some(())
    })?;
    Some(waves)
}

/// A ring of outer radius 1 and Young's modulus 1.
struct SolidRing<'a> {
    axial: &'a FaceIntegrals,
    shear: f64,
    lame: f64,
    /// Kolosov's constant of plane strain.
    kolosov: f64,
    /// Integrals over the radius of products of the polynomials f, of f/r and of f′.
    radial: Radial,
    /// Displacements of the outer surface by each freedom (rows), in the waves of each direction (columns).
    surface: Mat<f64>,
}

struct Radial {
    plain: Mat<f64>,
    /// `∫ f f′ r dr`, `∫ f′ f′ r dr`.
    plain_slope: Mat<f64>,
    slope: Mat<f64>,
    /// `∫ f f/r r dr`, `∫ (f/r)² r dr`, `∫ f′ f/r r dr`.
    plain_hoop: Mat<f64>,
    hoop: Mat<f64>,
    slope_hoop: Mat<f64>,
}

impl Radial {
    fn new(bore: f64) -> Self {
        let rule = GaussLegendre::new(RADIAL + 6);
        let half = 0.5 * (1.0 - bore);
        // (r − bore) P(r) vanishes at the bore.
        let sample = |of: &dyn Fn(f64, [f64; 2]) -> f64| -> Mat<f64> {
            Mat::from_fn(RADIAL, rule.nodes.len(), |degree, point| {
                let r = 0.5 * (1.0 + bore) + half * rule.nodes[point];
                let [value, slope] = legendre(rule.nodes[point], RADIAL)[degree];
                let depth = r - bore;
                let weight = (rule.weights[point] * half * r).sqrt();
                weight * of(r, [depth * value, value + depth * slope / half])
            })
        };
        let plain = sample(&|_, [value, _]| value);
        let slope = sample(&|_, [_, slope]| slope);
        let hoop = sample(&|r, [value, _]| value / r);
        let integral =
            |one: &Mat<f64>, other: &Mat<f64>| linalg::product(one.as_ref(), other.transpose());
        Self {
            plain_slope: integral(&plain, &slope),
            plain_hoop: integral(&plain, &hoop),
            slope_hoop: integral(&slope, &hoop),
            plain: integral(&plain, &plain),
            slope: integral(&slope, &slope),
            hoop: integral(&hoop, &hoop),
        }
    }
}

impl<'a> SolidRing<'a> {
    fn new(ratio: f64, poisson_ratio: f64, axial: &'a FaceIntegrals) -> Self {
        let [shear, lame] = moduli(poisson_ratio);
        let bore = 1.0 / ratio;
        let (section, along) = (axial.loads.nrows(), axial.axial_loads.nrows());
        let outer = Mat::from_fn(RADIAL, 1, |_, _| 1.0 - bore);
        let (waves, axial_waves) = (axial.numbers.len(), axial.axial_numbers.len());
        // Freedoms are rows here, as `add_product` requires.
        let mut surface = Mat::zeros(RADIAL * (2 * section + along), 2 * waves + axial_waves);
        add_product(&mut surface, [0, 0], &outer, &axial.loads, 1.0);
        let second = RADIAL * section;
        add_product(&mut surface, [second, waves], &outer, &axial.loads, 1.0);
        let at = [2 * second, 2 * waves];
        add_product(&mut surface, at, &outer, &axial.axial_loads, 1.0);
        Self {
            axial,
            shear,
            lame,
            kolosov: 3.0 - 4.0 * poisson_ratio,
            radial: Radial::new(bore),
            surface,
        }
    }

    /// Compliance matrix of the outer surface for the circumferential harmonic `order`. Each column is the
    /// displacement under a unit traction wave: first the radial ones (cos nθ), then tangential (sin nθ),
    /// then axial (cos nθ). Each group has one column per wave along the face width. `None` if not finite.
    fn harmonic(&self, order: u64) -> Option<Mat<f64>> {
        if order > EXACT {
            return Some(self.half_space(order));
        }
        let lower = linalg::cholesky(&self.stiffness(order as f64))?;
        let mut moved = self.surface.clone();
        linalg::solve_lower(&lower, &mut moved);
        Some(linalg::product(moved.transpose(), moved.as_ref()))
    }

    /// Stiffness of radial, tangential and axial displacements u cos nθ, v sin nθ, w cos nθ: with strains
    /// `u′, (u + n v)/r, w_z` and `v′ − (v + n u)/r, u_z + w′, v_z − n w/r`.
    fn stiffness(&self, n: f64) -> Mat<f64> {
        let (axial, radial) = (self.axial, &self.radial);
        let (shear, lame, stiff) = (self.shear, self.lame, self.lame + 2.0 * self.shear);
        let size = self.surface.nrows();
        let v = RADIAL * axial.mass.nrows();
        let w = 2 * v;
        let hoop_slope = radial.slope_hoop.transpose();
        let both = &radial.slope_hoop + hoop_slope;
        let mut out = Mat::zeros(size, size);
        let mut add = |at, section: Mat<f64>, face: &Mat<f64>| {
            add_product(&mut out, at, &section, face, 1.0);
        };
        let times = |factor: f64, matrix: &Mat<f64>| matrix * faer::Scale(factor);
        let rotated = &radial.slope - &both + &radial.hoop;
        let stretched = &radial.slope + &radial.hoop;
        add(
            [0, 0],
            times(stiff, &stretched) + times(lame, &both) + times(shear * n * n, &radial.hoop),
            &axial.mass,
        );
        add([0, 0], times(shear, &radial.plain), &axial.shear);
        add(
            [v, v],
            times(stiff * n * n, &radial.hoop) + times(shear, &rotated),
            &axial.mass,
        );
        add([v, v], times(shear, &radial.plain), &axial.shear);
        let hoop_slope = hoop_slope.to_owned();
        add(
            [v, 0],
            times(n * stiff, &radial.hoop) + times(n * lame, &hoop_slope)
                - times(n * shear, &radial.slope_hoop)
                + times(n * shear, &radial.hoop),
            &axial.mass,
        );
        add([w, w], times(stiff, &radial.plain), &axial.stretch);
        add(
            [w, w],
            times(shear, &radial.slope) + times(shear * n * n, &radial.hoop),
            &axial.axial_mass,
        );
        let along = &radial.plain_slope + &radial.plain_hoop;
        add([w, 0], times(lame, &along), &axial.mixed);
        let sloped = radial.plain_slope.transpose().to_owned();
        add([w, 0], times(shear, &sloped), &axial.crossed);
        add([w, v], times(lame * n, &radial.plain_hoop), &axial.mixed);
        let hooped = radial.plain_hoop.transpose().to_owned();
        add([w, v], times(-shear * n, &hooped), &axial.crossed);
        mirror(&mut out);
        out
    }

    /// As [`Self::harmonic`], for a harmonic that does not reach the bore, on a disc of any thickness. A wave
    /// with the wave vector (n, k) and `q = √(n² + k²)` deforms in plane strain along its vector. Across the
    /// vector its shear compliance is `1/(G q)`.
    fn half_space(&self, order: u64) -> Mat<f64> {
        let (waves, axial_waves) = (self.axial.numbers.len(), self.axial.axial_numbers.len());
        let mut out = Mat::zeros(2 * waves + axial_waves, 2 * waves + axial_waves);
        for (wave, number) in self.axial.numbers.iter().enumerate() {
            let q = (order as f64).hypot(*number);
            let (round, along) = (order as f64 / q, number / q);
            let (first, second) = (1.0 / (q - 1.0), self.kolosov / (q + 1.0));
            let like = 0.25 / self.shear * (second + first);
            let cross = 0.25 / self.shear * (second - first);
            let across = 1.0 / (self.shear * q);
            let matrix = [
                [like, cross * round, cross * along],
                [
                    cross * round,
                    like * round * round + across * along * along,
                    (like - across) * round * along,
                ],
                [
                    cross * along,
                    (like - across) * round * along,
                    like * along * along + across * round * round,
                ],
            ];
            // A uniform wave has no component along the axis.
            let skipped = waves - axial_waves;
            let places = [Some(wave), Some(waves + wave), {
                let place = wave.checked_sub(skipped);
                place.map(|wave| 2 * waves + wave)
            }];
            for (row, values) in places.iter().zip(matrix) {
                for (column, value) in places.iter().zip(values) {
                    if let (Some(row), Some(column)) = (row, column) {
                        out[(*row, *column)] = value;
                    }
                }
            }
        }
        out
    }

    /// Adds the compliance of a harmonic around the body to that of the waves of forces on the feet of the teeth.
    /// `sense` is −1 if the harmonic runs in the opposite direction, which changes the sign of the coupling between
    /// tangential and other directions.
    fn add(&self, wave: &mut Mat<f64>, harmonic: &Mat<f64>, transforms: &[f64], sense: f64) {
        let (waves, axial_waves) = (self.axial.numbers.len(), self.axial.axial_numbers.len());
        // Start of each direction in the harmonic and in the modes, its number of waves, and whether it is tangential.
        let directions = [
            (0, 0, waves, false),
            (waves, FOOT * waves, waves, true),
            (2 * waves, 2 * FOOT * waves, axial_waves, false),
        ];
        for (from, to, count, turning) in directions {
            for (other_from, other_to, other_count, other_turning) in directions {
                let sign = if turning == other_turning { 1.0 } else { sense };
                for (n, other) in transforms.iter().enumerate() {
                    for (m, one) in transforms.iter().enumerate() {
                        let product = sign * one * other;
                        for j in 0..other_count {
                            for i in 0..count {
                                wave[(to + m * count + i, other_to + n * other_count + j)] +=
                                    product * harmonic[(from + i, other_from + j)];
                            }
                        }
                    }
                }
            }
        }
    }
}
