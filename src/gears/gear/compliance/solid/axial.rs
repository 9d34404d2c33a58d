//! How does a solid move along the face, and in which waves are loads on the face expanded?
//!
//! Displacements are Legendre polynomials of z, so both ends of the face are free. Loads are
//! waves `c_n cos(n π t)` of the position t = z/b + ½ on a face of width b, with c_0 = 1 and c_n = √2 otherwise.
//! Each has a mean square of 1 over the face. For a solid symmetric about mid-face the parts even and odd in z
//! are independent; displacements along the axis have the opposite parity.

use crate::gear::compliance::plate::legendre;
use crate::numerics::linalg;
use crate::numerics::quadrature::GaussLegendre;
use faer::Mat;
use std::f64::consts::{PI, SQRT_2};

/// Integrals over the face of one parity's polynomials: p for displacements in the section, a for those along
/// the axis.
pub(super) struct FaceIntegrals {
    /// `∫ p p dz`.
    pub mass: Mat<f64>,
    /// `∫ p′ p′ dz`.
    pub shear: Mat<f64>,
    /// `∫ a a dz`.
    pub axial_mass: Mat<f64>,
    /// `∫ a′ a′ dz`.
    pub stretch: Mat<f64>,
    /// `∫ a′ p dz`, a by rows.
    pub mixed: Mat<f64>,
    /// `∫ a p′ dz`, a by rows.
    pub crossed: Mat<f64>,
    /// `∫ p w dz` of the waves w, polynomials by rows; the waves are orthonormal over the face.
    pub loads: Mat<f64>,
    /// `∫ a w dz` of the waves of sines w.
    pub axial_loads: Mat<f64>,
    /// Wave numbers k of the waves in the section \[1 / unit of length\].
    pub numbers: Vec<f64>,
    /// Wave numbers of the waves along the axis. A uniform wave has no component there, so 0 is omitted.
    pub axial_numbers: Vec<f64>,
}

impl FaceIntegrals {
    /// The even or odd polynomials up to a degree on a face of width `width`, and the first `waves` waves of the same
    /// parity.
    pub fn new(width: f64, degree: usize, waves: usize, odd: bool) -> Self {
        let rule = GaussLegendre::new(degree + waves + 8);
        let points = rule.nodes.len();
        let polynomials: Vec<Vec<[f64; 2]>> =
            rule.nodes.iter().map(|z| legendre(*z, degree)).collect();
        let half = 0.5 * width;
        let parity = usize::from(odd);
        // Values at the points, times the square root of the weight; derivatives likewise.
        let sampled = |parity: usize, derivative: bool| -> Mat<f64> {
            let count = (parity..=degree).step_by(2).count();
            Mat::from_fn(count, points, |row, point| {
                let [value, slope] = polynomials[point][parity + 2 * row];
                let weight = (rule.weights[point] * half).sqrt();
                weight * if derivative { slope / half } else { value }
            })
        };
        let [p, p_slope] = [false, true].map(|derivative| sampled(parity, derivative));
        let [a, a_slope] = [false, true].map(|derivative| sampled(1 - parity, derivative));
        let orders: Vec<usize> = (parity..waves).step_by(2).collect();
        let axial_orders: Vec<usize> = orders.iter().copied().filter(|n| *n > 0).collect();
        let wave = |orders: &[usize], of: fn(f64) -> f64| -> Mat<f64> {
            Mat::from_fn(orders.len(), points, |row, point| {
                let phase = orders[row] as f64 * PI * 0.5 * (rule.nodes[point] + 1.0);
                let scale = if orders[row] == 0 { 1.0 } else { SQRT_2 };
                scale * of(phase) * (0.5 * rule.weights[point]).sqrt()
            })
        };
        let integral =
            |one: &Mat<f64>, other: &Mat<f64>| linalg::product(one.as_ref(), other.transpose());
        let number = |n: &usize| *n as f64 * PI / width;
        Self {
            mass: integral(&p, &p),
            shear: integral(&p_slope, &p_slope),
            axial_mass: integral(&a, &a),
            stretch: integral(&a_slope, &a_slope),
            mixed: integral(&a_slope, &p),
            crossed: integral(&a, &p_slope),
            loads: integral(&p, &wave(&orders, f64::cos)),
            axial_loads: integral(&a, &wave(&axial_orders, f64::sin)),
            numbers: orders.iter().map(number).collect(),
            axial_numbers: axial_orders.iter().map(number).collect(),
        }
    }
}

/// Adds the Kronecker product of a matrix of the section and one of the face to a block of `target`. The index of the
/// face runs fastest.
pub(super) fn add_product(
    target: &mut Mat<f64>,
    [first_row, first_column]: [usize; 2],
    section: &Mat<f64>,
    face: &Mat<f64>,
    scale: f64,
) {
    for j in 0..section.ncols() {
        for i in 0..section.nrows() {
            let factor = scale * section[(i, j)];
            for l in 0..face.ncols() {
                let column = first_column + j * face.ncols() + l;
                for k in 0..face.nrows() {
                    target[(first_row + i * face.nrows() + k, column)] += factor * face[(k, l)];
                }
            }
        }
    }
}

/// Copies the lower triangle of a matrix to its upper one.
pub(super) fn mirror(matrix: &mut Mat<f64>) {
    for j in 0..matrix.ncols() {
        for i in 0..j {
            matrix[(i, j)] = matrix[(j, i)];
        }
    }
}
