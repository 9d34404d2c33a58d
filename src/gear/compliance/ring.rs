//! How much a tooth gives when its neighbour is loaded: the gear body as an elastic ring.
//!
//! The ring is held at its bore and loaded on arcs of its root circle, as in the model of
//! Sainsot et al. (2004): a tooth that carries a unit force presses on its arc with a uniform
//! shear, and a normal stress that is uniform (its radial part) and linear (its moment). Each
//! harmonic of the stress gives displacements in closed form (Michell's solution; Barber,
//! Elasticity, 3rd ed., table 9.1, plane stress), and the compliance between two teeth is the
//! work of one's stresses on the other's displacements: symmetric, and without a fit.
//!
//! Lengths are in root radii and stresses in Young's moduli here, so that every compliance
//! comes out times E per unit width.

use crate::gear::{GearPair, Tooth};
use crate::numerics::linalg;
use std::f64::consts::PI;

/// Harmonics taken: enough for the arc's edges to matter by less than 1e-4 of the compliance
/// between teeth, whose arcs are apart.
const HARMONICS: u32 = 400;

/// Force of a tooth on its body: transverse, moment over root radius, radial outwards; in units
/// of the force on the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::gear) struct RootLoad(pub [f64; 3]);

impl RootLoad {
    /// The load of a unit force whose line, at angle β to the tooth's perpendicular, crosses the
    /// centre line `lever` root radii above the root. The normal stress of the moment has a
    /// transverse resultant of −lever, for which the shear makes up.
    pub fn new(angle: f64, lever: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self([cos * (1.0 + lever), cos * lever, -sin])
    }
}

/// Compliance between the arcs of two teeth on one ring, times E, by the parts of a
/// [`RootLoad`]: rows of the tooth ahead, columns of the other.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::gear) struct RingCompliance([[f64; 3]; 3]);

impl RingCompliance {
    /// Between a tooth and one at the angle `ahead` \[rad\] from it, positive in the sense of the
    /// transverse force; 0 is the tooth itself. The arcs have the half angle θ_f, the ring a
    /// ratio of root to bore radius.
    pub fn new(half_angle: f64, ratio: f64, poisson_ratio: f64, ahead: f64) -> Self {
        Self::with_harmonics(half_angle, ratio, poisson_ratio, ahead, HARMONICS)
    }

    pub(super) fn with_harmonics(
        half_angle: f64,
        ratio: f64,
        poisson_ratio: f64,
        ahead: f64,
        harmonics: u32,
    ) -> Self {
        let ring = Ring::new(ratio, poisson_ratio);
        let mut sum = [[0.0; 3]; 3];
        let mean = 1.0 / (2.0 * PI);
        sum[0][0] = 2.0 * PI * ring.twist() * mean * mean;
        sum[2][2] = 2.0 * PI * ring.breathing() * mean * mean;
        for order in 1..=harmonics {
            let stiffness = ring.harmonic(order);
            let loads = harmonic_loads(f64::from(order), half_angle);
            let (sin, cos) = (f64::from(order) * ahead).sin_cos();
            for (column, load) in loads.iter().enumerate() {
                let moved = turned(displacement(&stiffness, load), sin, cos);
                for (row, other) in loads.iter().enumerate() {
                    let work: f64 = other.iter().zip(&moved).map(|(t, u)| t * u).sum();
                    sum[row][column] += PI * work;
                }
            }
        }
        Self(sum)
    }

    /// Displacement of the tooth ahead along its unit force by the other's unit force, times E.
    pub fn between(&self, ahead: RootLoad, other: RootLoad) -> f64 {
        (ahead.0.iter().zip(&self.0))
            .map(|(a, row)| a * row.iter().zip(&other.0).map(|(c, o)| c * o).sum::<f64>())
            .sum()
    }
}

/// Fourier coefficients on the root circle: radial cosine and sine, tangential cosine and sine.
type Harmonic = [f64; 4];

/// Harmonics of the stresses of unit transverse force, moment and radial force.
fn harmonic_loads(order: f64, half_angle: f64) -> [Harmonic; 3] {
    let (sin, cos) = (order * half_angle).sin_cos();
    let uniform = sin / (PI * order * half_angle);
    // Tension behind the force: t_r = −3 θ/(2 θ_f³).
    let linear = -3.0 / (PI * half_angle.powi(3)) * (sin / order - half_angle * cos) / order;
    [
        [0.0, 0.0, uniform, 0.0],
        [0.0, linear, 0.0, 0.0],
        [uniform, 0.0, 0.0, 0.0],
    ]
}

/// Displacements of one harmonic of stress: `[[rr, rt], [rt, tt]]` joins radial cosines with
/// tangential sines; a turn by a quarter wave gives radial sines and tangential cosines.
fn displacement(stiffness: &[[f64; 2]; 2], load: &Harmonic) -> Harmonic {
    let [[rr, rt], [_, tt]] = *stiffness;
    let [radial_cos, radial_sin, tangential_cos, tangential_sin] = *load;
    [
        rr * radial_cos + rt * tangential_sin,
        rr * radial_sin - rt * tangential_cos,
        tt * tangential_cos - rt * radial_sin,
        tt * tangential_sin + rt * radial_cos,
    ]
}

/// The harmonic as seen from a tooth further round by the angle of that sine and cosine.
fn turned(field: Harmonic, sin: f64, cos: f64) -> Harmonic {
    let [rc, rs, tc, ts] = field;
    [
        rc * cos + rs * sin,
        rs * cos - rc * sin,
        tc * cos + ts * sin,
        ts * cos - tc * sin,
    ]
}

/// An elastic ring of outer radius 1 and Young's modulus 1, held at its bore.
struct Ring {
    bore: f64,
    shear: f64,
    /// Lamé's first constant of plane stress.
    lame: f64,
    /// Kolosov's constant of plane stress.
    kolosov: f64,
}

/// Radial and tangential displacement at a radius and their derivatives by it.
type Basis = [f64; 4];

impl Ring {
    fn new(ratio: f64, poisson_ratio: f64) -> Self {
        let shear = 0.5 / (1.0 + poisson_ratio);
        let kolosov = (3.0 - poisson_ratio) / (1.0 + poisson_ratio);
        Self {
            bore: 1.0 / ratio,
            shear,
            lame: shear * (3.0 - kolosov) / (kolosov - 1.0),
            kolosov,
        }
    }

    /// Tangential displacement by a uniform tangential stress: `v = C (r − r_i²/r)`.
    fn twist(&self) -> f64 {
        let inner = self.bore * self.bore;
        (1.0 - inner) / (2.0 * self.shear * inner)
    }

    /// Radial displacement by a uniform radial stress: `u = C (r − r_i²/r)`.
    fn breathing(&self) -> f64 {
        let inner = self.bore * self.bore;
        (1.0 - inner) / (2.0 * self.lame + 2.0 * self.shear * (1.0 + inner))
    }

    /// Displacements at the outer circle, (cos, sin), by unit stresses there, (cos, sin).
    fn harmonic(&self, order: u32) -> [[f64; 2]; 2] {
        let inner = self.basis(order, self.bore);
        let outer = self.basis(order, 1.0);
        let n = f64::from(order);
        // Columns: held at the bore; stresses at the outer circle by Hooke's law.
        let columns: [[f64; 4]; 4] = std::array::from_fn(|j| {
            let [u, v, du, dv] = outer[j];
            [
                inner[j][0],
                inner[j][1],
                self.lame * (du + u + n * v) + 2.0 * self.shear * du,
                self.shear * (dv - v - n * u),
            ]
        });
        let inverse = linalg::invert(&columns);
        let at = |component: usize, load: usize| -> f64 {
            (0..4)
                .map(|j| outer[j][component] * inverse[2 + load][j])
                .sum()
        };
        [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]]
    }

    /// The four displacement fields of a harmonic, those that decay outwards scaled at the bore.
    fn basis(&self, order: u32, r: f64) -> [Basis; 4] {
        let (k, n) = (self.kolosov, f64::from(order));
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
                power([-n, n], n - 1.0, 1.0),
                power([k + n - 1.0, n - 1.0 - k], 1.0 - n, self.bore),
            ]
        };
        [
            first,
            second,
            power([k - n - 1.0, k + n + 1.0], n + 1.0, 1.0),
            power([n, n], -n - 1.0, self.bore),
        ]
    }
}

/// The bodies between teeth one, two ... base pitches apart, as many as can be in contact at
/// once. Teeth further along the path are ahead in the sense of rotation: with the force on the
/// wheel, against that on the pinion.
pub(in crate::gear) fn rings(
    pair: &GearPair,
    teeth: &[Tooth; 2],
    bores: [f64; 2],
    most: usize,
) -> Vec<[RingCompliance; 2]> {
    let ring = |gear: usize, ahead: f64| {
        let tooth = &teeth[gear];
        RingCompliance::new(
            tooth.root_half_angle,
            2.0 * tooth.root_radius / bores[gear],
            pair.form.material[gear].poisson_ratio,
            ahead * 2.0 * PI / f64::from(pair.teeth[gear]),
        )
    };
    (1..=most)
        .map(|ahead| [ring(0, -(ahead as f64)), ring(1, ahead as f64)])
        .collect()
}

#[cfg(test)]
#[path = "ring_tests.rs"]
mod tests;
