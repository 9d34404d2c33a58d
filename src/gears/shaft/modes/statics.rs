//! How much does a load deflect a structure beyond the computed modes? The rest of the static solution.

use super::pencil::Pencil;
use super::{LARGE, Modes, NARROW};
use crate::numerics::linalg::product;
use crate::shaft::banded::Banded;
use crate::shaft::error::ShaftError;
use faer::Mat;

/// Shift, relative to the largest squared frequency computed: every step leaves less than this part of the
/// error, unless all computed modes are rigid.
const SHIFT: f64 = 1e-3;

/// Change of a shape at convergence, relative to its largest entry or to that of the whole deflection.
const CONVERGED: f64 = 1e-14;

/// Largest number of steps. If no elastic mode is computed, the shift is a guess, and a step may leave 0.9 of
/// the error.
const MOST_STEPS: usize = 400;

impl Modes {
    /// These modes followed by one static shape per load, with squared frequency 1; none if all loads are zero. A shape
    /// is the deflection under the load outside these modes, `Σ φ (φᵀ f)/ω²` over the modes of the structure that were
    /// not computed. The value of a sum of freedoms in the shape is the residual flexibility between this sum and the
    /// load.
    ///
    /// Iterates `(K + σ M) u ← f + σ M u` and removes the parts of f and u along these modes. If these modes
    /// contain the whole deflection, the result is round-off, some 1e-16 of the whole.
    ///
    /// # Errors
    /// [`ShaftError::StiffnessIndefinite`], [`ShaftError::NoStaticShape`].
    pub fn with_static_shapes(
        &self,
        mass: &Mat<f64>,
        stiffness: &Mat<f64>,
        loads: &[Vec<f64>],
    ) -> Result<Self, ShaftError> {
        let (size, modes) = (mass.nrows(), self.shape.ncols());
        // All modes together contain the whole deflection.
        if modes == size || loads.iter().flatten().all(|&force| force == 0.0) {
            return Ok(self.clone());
        }
        let band = Banded::width(&[mass, stiffness]);
        let banded = (size >= LARGE && NARROW * band <= size)
            .then(|| [mass, stiffness].map(|matrix| Banded::of(matrix, band)));
        let pencil = match &banded {
            Some([mass, stiffness]) => Pencil::Banded(mass, stiffness),
            None => Pencil::Dense(mass, stiffness),
        };
        let highest = self.squared_frequency[modes - 1];
        let scale = if highest > 0.0 {
            highest
        } else {
            (0..size)
                .map(|i| stiffness[(i, i)] / mass[(i, i)])
                .filter(|&squared| squared > 0.0)
                .fold(f64::INFINITY, f64::min)
        };
        if !scale.is_finite() {
            return Ok(self.clone());
        }
        let shift = SHIFT * scale;
        let solver = (pencil.shifted(shift))
            .ok_or(ShaftError::StiffnessIndefinite { eigenvalue: -shift })?;
        let inertia = pencil.mass_product(self.shape.as_ref());
        // x − A Bᵀ x
        let without = |x: &mut Mat<f64>, a: &Mat<f64>, b: &Mat<f64>| {
            let parts = product(b.transpose(), x.as_ref());
            let along = product(a.as_ref(), parts.as_ref());
            *x = Mat::from_fn(size, loads.len(), |i, j| x[(i, j)] - along[(i, j)]);
        };
        let largest =
            |of: &Mat<f64>, j: usize| of.col(j).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut force = Mat::from_fn(size, loads.len(), |i, j| loads[j][i]);
        // Removing the computed modes from a deflection leaves round-off that no step reduces.
        let mut deflection = force.clone();
        solver.solve(&mut deflection);
        let whole: Vec<f64> = (0..loads.len()).map(|j| largest(&deflection, j)).collect();
        without(&mut force, &inertia, &self.shape);
        let mut shape: Mat<f64> = Mat::zeros(size, loads.len());
        for _ in 0..MOST_STEPS {
            let moved = pencil.mass_product(shape.as_ref());
            let mut next = Mat::from_fn(size, loads.len(), |i, j| {
                force[(i, j)] + shift * moved[(i, j)]
            });
            solver.solve(&mut next);
            without(&mut next, &self.shape, &inertia);
            let change = Mat::from_fn(size, loads.len(), |i, j| next[(i, j)] - shape[(i, j)]);
            let there = (0..loads.len())
                .all(|j| largest(&change, j) <= CONVERGED * largest(&next, j).max(whole[j]));
            shape = next;
            if there {
                return Ok(self.followed_by(&shape));
            }
        }
        Err(ShaftError::NoStaticShape { modes })
    }

    /// These modes followed by further columns, with squared frequency 1.
    fn followed_by(&self, columns: &Mat<f64>) -> Self {
        let modes = self.shape.ncols();
        let mut squared_frequency = self.squared_frequency.clone();
        squared_frequency.resize(modes + columns.ncols(), 1.0);
        let shape = Mat::from_fn(self.shape.nrows(), squared_frequency.len(), |i, j| {
            if j < modes { self.shape[(i, j)] } else { columns[(i, j - modes)] }
        });
        Self {
            squared_frequency,
            shape,
        }
    }
}
