//! The lowest modes of large banded matrices, without computing the others.
//!
//! A basis V of a block Krylov space of `A = (K + σ M)⁻¹ M`, M-orthonormal by full
//! reorthogonalisation (Lanczos in blocks: Grimes, Lewis & Simon, *SIAM J. Matrix Anal. Appl.* 15, 1994).
//! The eigenvalues θ of `VᵀM A V` give `ω² = 1/θ − σ`. Large θ come first, so the lowest modes are most accurate.
//! Blocks are wider than the number of rigid motions or equal frequencies of a structure. A count checks that no mode
//! is missing: `K − μ M` has as many negative pivots as there are ω² below μ (Sylvester).

use super::pencil::{Pencil, Shifted};
use crate::numerics::linalg::{cholesky, product, solve_lower, symmetric_eigen};
use crate::numerics::random::Stream;
use crate::shaft::banded::Banded;
use faer::Mat;

/// Smallest number of columns of a block: two planes of two equal shafts, with some margin.
const BLOCK: usize = 6;

/// Number of modes to compute beyond the requested ones. Completeness is checked at a value between two
/// neighbouring modes from the last requested one on.
const EXTRA_MODES: usize = 4;

/// Largest residual of a mode of A in the norm of M, relative to its θ. One step of inverse iteration
/// follows.
const TOLERANCE: f64 = 1e-11;

/// Number of blocks between two checks of the residuals.
const BLOCKS_PER_CHECK: usize = 4;

/// First shift, relative to the smallest ratio of the diagonal entries of stiffness and inertia.
const FIRST_SHIFT: f64 = 1e-6;

/// Number of rounds that move the shift towards the lowest elastic ω².
const SHIFT_ROUNDS: usize = 3;

/// Estimates of the lowest ω², ascending, and their M-orthonormal shapes.
pub(super) struct Lowest {
    pub squared_frequency: Vec<f64>,
    pub shape: Mat<f64>,
}

/// The `wanted` lowest modes, including `rigid` rigid motions. `None` if the iteration does not converge, a
/// mode is missing, or `K + σ M` is not positive definite: a dense solution is needed then.
pub(super) fn lowest(
    mass: &Banded,
    stiffness: &Banded,
    wanted: usize,
    rigid: usize,
) -> Option<Lowest> {
    let pencil = Pencil::Banded(mass, stiffness);
    let size = pencil.size();
    let width = BLOCK.max(rigid + 2);
    let all = wanted + EXTRA_MODES;
    let most = (4 * all + 20 * width).min(size);
    if all + width > most {
        return None;
    }
    let mut stream = Stream::new(SEED, 0, 0);
    let start = Mat::from_fn(size, width, |_, _| stream.uniform() - 0.5);
    let (shift, start) = near_first_elastic(pencil, mass, stiffness, start, rigid)?;
    let solver = pencil.shifted(shift)?;
    let mut space = Space::new(pencil, solver, start)?;
    loop {
        for _ in 0..BLOCKS_PER_CHECK {
            space.grow()?;
        }
        if space.columns() >= all
            && let Some(found) = space.converged(all, shift)
        {
            return modes_are_complete(mass, stiffness, &found.squared_frequency, wanted).then(
                || Lowest {
                    squared_frequency: found.squared_frequency[..wanted].to_vec(),
                    shape: found.shape.subcols(0, wanted).to_owned(),
                },
            );
        }
        if space.columns() + BLOCKS_PER_CHECK * width > most {
            return None;
        }
    }
}

/// Seed of the first block.
const SEED: u64 = 1994;

/// A shift near the lowest elastic ω², and a block aligned with the lowest modes. `None` as in [`lowest`].
fn near_first_elastic(
    pencil: Pencil<'_>,
    mass: &Banded,
    stiffness: &Banded,
    mut block: Mat<f64>,
    rigid: usize,
) -> Option<(f64, Mat<f64>)> {
    let ratios = (0..pencil.size()).map(|i| stiffness.diagonal(i) / mass.diagonal(i));
    let least = ratios
        .filter(|ratio| *ratio > 0.0)
        .fold(f64::INFINITY, f64::min);
    let mut shift = FIRST_SHIFT * least;
    for _ in 0..SHIFT_ROUNDS {
        let solver = pencil.shifted(shift)?;
        let space = Space::new(pencil, solver, block)?;
        let (values, vectors) = space.ritz()?;
        block = product(space.image.as_ref(), vectors.as_ref());
        // θ ascend: the largest belong to the rigid motions.
        let theta = values[values.len() - 1 - rigid];
        shift = (1.0 / theta - shift).max(FIRST_SHIFT * shift);
    }
    (shift.is_finite()).then_some((shift, block))
}

/// Whether all modes are found below a value in the widest gap between neighbours, from mode `wanted` on.
fn modes_are_complete(mass: &Banded, stiffness: &Banded, squared: &[f64], wanted: usize) -> bool {
    let gap = |count: &usize| (squared[*count] - squared[*count - 1]) / squared[*count].abs();
    let widest = (wanted..squared.len()).max_by(|a, b| gap(a).total_cmp(&gap(b)));
    let Some(count) = widest else { return false };
    let place = 0.5 * (squared[count - 1] + squared[count]);
    let factor = stiffness.plus(-place, mass).factor();
    factor.is_some_and(|factor| factor.negative() == count)
}

/// A Krylov space.
struct Space<'a> {
    pencil: Pencil<'a>,
    solver: Shifted,
    width: usize,
    /// V, one column per vector.
    basis: Mat<f64>,
    /// M V.
    inertia: Mat<f64>,
    /// A V.
    image: Mat<f64>,
}

impl<'a> Space<'a> {
    /// The Krylov space of a first block.
    fn new(pencil: Pencil<'a>, solver: Shifted, block: Mat<f64>) -> Option<Self> {
        let none = Mat::zeros(pencil.size(), 0);
        let mut space = Self {
            pencil,
            solver,
            width: block.ncols(),
            basis: none.clone(),
            inertia: none.clone(),
            image: none,
        };
        space.add(block)?;
        Some(space)
    }

    fn columns(&self) -> usize {
        self.basis.ncols()
    }

    /// Adds the image of the last block.
    fn grow(&mut self) -> Option<()> {
        let from = self.columns() - self.width;
        let next = self.image.subcols(from, self.width).to_owned();
        self.add(next)
    }

    /// Adds the part of a block outside the space. `None` if its columns are dependent.
    fn add(&mut self, mut block: Mat<f64>) -> Option<()> {
        // Twice, against round-off.
        for _ in 0..2 {
            let parts = product(self.inertia.transpose(), block.as_ref());
            block -= product(self.basis.as_ref(), parts.as_ref());
            normalise(&mut block, |x| self.pencil.mass_product(x.as_ref()))?;
        }
        let inertia = self.pencil.mass_product(block.as_ref());
        let mut image = inertia.clone();
        self.solver.solve(&mut image);
        self.basis = side_by_side(&self.basis, &block);
        self.inertia = side_by_side(&self.inertia, &inertia);
        self.image = side_by_side(&self.image, &image);
        Some(())
    }

    /// Eigenvalues θ of A in the space, ascending, and their vectors in the basis.
    fn ritz(&self) -> Option<(Vec<f64>, Mat<f64>)> {
        let projected = product(self.inertia.transpose(), self.image.as_ref());
        let count = self.columns();
        let symmetric = Mat::from_fn(count, count, |i, j| {
            0.5 * (projected[(i, j)] + projected[(j, i)])
        });
        symmetric_eigen(&symmetric)
    }

    /// The `all` lowest modes, if all have converged.
    fn converged(&self, all: usize, shift: f64) -> Option<Lowest> {
        let (values, vectors) = self.ritz()?;
        let last = values.len() - 1;
        let vectors = Mat::from_fn(values.len(), all, |i, j| vectors[(i, last - j)]);
        let theta: Vec<f64> = (0..all).map(|j| values[last - j]).collect();
        let shape = product(self.basis.as_ref(), vectors.as_ref());
        let mut residual = product(self.image.as_ref(), vectors.as_ref());
        for j in 0..all {
            for i in 0..residual.nrows() {
                residual[(i, j)] -= theta[j] * shape[(i, j)];
            }
        }
        let inertia = self.pencil.mass_product(residual.as_ref());
        for j in 0..all {
            let square: f64 = (0..residual.nrows())
                .map(|i| residual[(i, j)] * inertia[(i, j)])
                .sum();
            let found = theta[j] > 0.0 && square.max(0.0).sqrt() <= TOLERANCE * theta[j];
            if !found {
                return None;
            }
        }
        Some(Lowest {
            squared_frequency: theta.iter().map(|theta| 1.0 / theta - shift).collect(),
            shape,
        })
    }
}

/// Makes the columns of a block M-orthonormal; `None` if they are dependent.
fn normalise(block: &mut Mat<f64>, mass: impl Fn(&Mat<f64>) -> Mat<f64>) -> Option<()> {
    let count = block.ncols();
    // With columns of equal length the Gram matrix is easy to factorise.
    let gram = product(block.transpose(), mass(block).as_ref());
    let length: Vec<f64> = (0..count).map(|j| gram[(j, j)].sqrt()).collect();
    let scaled = Mat::from_fn(count, count, |i, j| gram[(i, j)] / (length[i] * length[j]));
    let lower = cholesky(&scaled)?;
    // Xᵀ ← L⁻¹ Xᵀ.
    let mut turned = Mat::from_fn(count, block.nrows(), |i, j| block[(j, i)] / length[i]);
    solve_lower(&lower, &mut turned);
    *block = turned.transpose().to_owned();
    Some(())
}

/// Both matrices next to each other.
fn side_by_side(left: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    let before = left.ncols();
    Mat::from_fn(left.nrows(), before + right.ncols(), |i, j| {
        if j < before { left[(i, j)] } else { right[(i, j - before)] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check takes place in the widest gap between neighbouring modes, not between two equal modes.
    #[test]
    fn a_missing_mode_is_noticed_and_an_equal_pair_is_not_parted() {
        let own = [1.0, 2.0, 2.0, 5.0, 9.0];
        let diagonal = |entry: &dyn Fn(usize) -> f64| {
            let matrix = Mat::from_fn(5, 5, |i, j| if i == j { entry(i) } else { 0.0 });
            Banded::of(&matrix, 0)
        };
        let (mass, stiffness) = (diagonal(&|_| 1.0), diagonal(&|i| own[i]));
        // Two equal modes, with rounding errors as in a computed solution.
        let found = [1.0, 2.0 - 1e-13, 2.0 + 1e-13, 5.0];
        assert!(modes_are_complete(&mass, &stiffness, &found, 2));
        assert!(modes_are_complete(&mass, &stiffness, &found, 1));
        assert!(!modes_are_complete(
            &mass,
            &stiffness,
            &[1.0, 2.0, 5.0, 9.0],
            2
        ));
        assert!(!modes_are_complete(&mass, &stiffness, &found, 4));
    }
}
