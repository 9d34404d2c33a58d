//! Mass and stiffness, dense or banded, with the operations that modes need.

use crate::numerics::linalg::{cholesky, product, solve_lower, solve_upper};
use crate::shaft::banded::{Banded, Factor};
use faer::{Mat, MatRef};

/// A pair of symmetric matrices M and K.
#[derive(Debug, Clone, Copy)]
pub(super) enum Pencil<'a> {
    /// Mass, stiffness.
    Dense(&'a Mat<f64>, &'a Mat<f64>),
    /// Mass, stiffness.
    Banded(&'a Banded, &'a Banded),
}

/// `K + σ M`, factorised.
pub(super) enum Shifted {
    /// Cholesky factor of `K + σ M`.
    Dense(Mat<f64>),
    Banded(Factor),
}

/// Products of K and M with a shape, and the sums of the moduli of their terms, row by row.
pub(super) struct ProductSums {
    pub stiffness_product: Vec<f64>,
    pub mass_product: Vec<f64>,
    pub stiffness_term_moduli: Vec<f64>,
    pub mass_term_moduli: Vec<f64>,
}

impl Pencil<'_> {
    /// Number of freedoms.
    pub fn size(&self) -> usize {
        match self {
            Self::Dense(mass, _) => mass.nrows(),
            Self::Banded(mass, _) => mass.size(),
        }
    }

    /// Diagonal inertia of a freedom.
    pub fn inertia(&self, row: usize) -> f64 {
        match self {
            Self::Dense(mass, _) => mass[(row, row)],
            Self::Banded(mass, _) => mass.diagonal(row),
        }
    }

    /// `M X`.
    pub fn mass_product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        match self {
            Self::Dense(mass, _) => product(mass.as_ref(), x),
            Self::Banded(mass, _) => mass.product(x),
        }
    }

    /// `K + σ M`; `None` if it is not positive definite.
    pub fn shifted(&self, shift: f64) -> Option<Shifted> {
        match self {
            Self::Dense(mass, stiffness) => {
                let sum = Mat::from_fn(self.size(), self.size(), |i, j| {
                    stiffness[(i, j)] + shift * mass[(i, j)]
                });
                cholesky(&sum).map(Shifted::Dense)
            }
            Self::Banded(mass, stiffness) => (stiffness.plus(shift, mass).factor())
                .filter(|factor| factor.negative() == 0)
                .map(Shifted::Banded),
        }
    }

    /// Products of both matrices with a shape.
    pub fn terms(&self, shape: &[f64]) -> ProductSums {
        match self {
            Self::Dense(mass, stiffness) => {
                let [stiffness_product, stiffness_term_moduli] = sums(stiffness, shape);
                let [mass_product, mass_term_moduli] = sums(mass, shape);
                ProductSums {
                    stiffness_product,
                    mass_product,
                    stiffness_term_moduli,
                    mass_term_moduli,
                }
            }
            Self::Banded(mass, stiffness) => {
                let column = Mat::from_fn(shape.len(), 1, |i, _| shape[i]);
                let image = |matrix: &Banded| {
                    let image = matrix.product(column.as_ref());
                    (0..shape.len()).map(|i| image[(i, 0)]).collect()
                };
                ProductSums {
                    stiffness_product: image(stiffness),
                    mass_product: image(mass),
                    stiffness_term_moduli: stiffness.sum_of_moduli(shape),
                    mass_term_moduli: mass.sum_of_moduli(shape),
                }
            }
        }
    }
}

impl Shifted {
    /// `(K + σ M)⁻¹ B` in place of B.
    pub fn solve(&self, b: &mut Mat<f64>) {
        match self {
            Self::Dense(lower) => {
                solve_lower(lower, b);
                solve_upper(lower, b);
            }
            Self::Banded(factor) => factor.solve(b),
        }
    }
}

/// `A x` and the sums of the moduli of its terms.
fn sums(matrix: &Mat<f64>, x: &[f64]) -> [Vec<f64>; 2] {
    let mut out = [vec![0.0; x.len()], vec![0.0; x.len()]];
    for (column, &value) in x.iter().enumerate() {
        for row in 0..x.len() {
            let term = matrix[(row, column)] * value;
            out[0][row] += term;
            out[1][row] += term.abs();
        }
    }
    out
}
