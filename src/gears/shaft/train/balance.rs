//! Where is the equilibrium of one-sided springs, such as rolling elements or stops behind gaps?
//!
//! ```text
//! d = d₀ + C p,   p + F(d) − K₀ d = 0
//! ```
//!
//! d are the motions at the one-sided springs, F are their forces, and K₀ replaces the springs in C. The approaches of
//! rolling elements are convex in d, and so is the total potential. The derivative of the potential by p is C times the
//! residual `p + F − K₀ d`. Newton steps with a line search on this derivative converge to the minimum of the
//! potential.

use crate::shaft::rolling::{RING_FREEDOMS, Ring, RollingLaw, RollingLoad};
use nalgebra::{DMatrix, DVector};

/// Part of K₀ added to the tangent in every step: if a shaft is free within a clearance, the tangent is singular.
const FLOOR: f64 = 1e-9;

/// A Newton step whose work is below this part of that of all springs is taken in full and is the last: it
/// leaves round-off.
const SMALL_WORK: f64 = 1e-20;

/// A deflection of a mesh below this part of the largest is round-off.
const PULLING: f64 = 1e-9;

const MOST_STEPS: usize = 200;

/// Largest number of bisections in the line search: a step near a free motion may be too long by the
/// reciprocal of [`FLOOR`].
const MOST_HALVINGS: usize = 60;

/// A one-sided support. Each of its rows is a motion of the support as a sum of the free freedoms.
pub(super) struct OneSidedSupport {
    pub rows: Vec<Vec<f64>>,
    pub law: SupportLaw,
    /// K₀, one per row.
    pub typical: Vec<f64>,
}

pub(super) enum SupportLaw {
    /// The law of a bearing, its index among the supports, and the displacement of its base, with the sign of
    /// the bearing's rows.
    Rolling(RollingLaw, usize, Ring),
    Stop {
        gap: f64,
        stiffness: f64,
    },
}

impl OneSidedSupport {
    /// The load on a bearing; `None` for a stop.
    pub fn rolling(&self, moved: &[f64]) -> Option<(usize, Ring, RollingLoad)> {
        let SupportLaw::Rolling(law, support, place) = &self.law else {
            return None;
        };
        let moved = std::array::from_fn(|i| moved[i] - place[i]);
        Some((*support, moved, law.at(&moved)))
    }

    /// Adds forces and stiffness at the row `at`.
    fn add_force(
        &self,
        at: usize,
        moved: &[f64],
        force: &mut DVector<f64>,
        tangent: &mut DMatrix<f64>,
    ) {
        if let Some((_, _, found)) = self.rolling(moved) {
            for i in 0..RING_FREEDOMS {
                force[at + i] = found.load[i];
                for j in 0..RING_FREEDOMS {
                    tangent[(at + i, at + j)] = found.stiffness[i][j];
                }
            }
        } else if let SupportLaw::Stop { gap, stiffness } = self.law
            && moved[0] > gap
        {
            force[at] = stiffness * (moved[0] - gap);
            tangent[(at, at)] = stiffness;
        }
    }
}

/// The equilibrium of the one-sided supports.
pub(super) struct EquilibriumProblem<'a> {
    pub all: &'a [OneSidedSupport],
    /// d₀ and C.
    pub free: DVector<f64>,
    pub compliance: DMatrix<f64>,
    pub typical: DVector<f64>,
    /// Deflections of the meshes without p, and their derivatives by p.
    pub meshes: (DVector<f64>, DMatrix<f64>),
}

impl EquilibriumProblem<'_> {
    /// Meshes whose flanks would have to pull.
    pub fn pulling(&self, force: &DVector<f64>) -> impl Iterator<Item = usize> {
        let deflections = &self.meshes.0 + &self.meshes.1 * force;
        let round_off = PULLING * deflections.amax();
        (0..deflections.len()).filter(move |&mesh| deflections[mesh] < -round_off)
    }

    pub fn moved(&self, force: &DVector<f64>) -> DVector<f64> {
        &self.free + &self.compliance * force
    }

    /// Residual of the equilibrium, and the derivative of F by d.
    fn at(&self, force: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let size = self.free.len();
        let moved = self.moved(force);
        let mut spring_force = DVector::zeros(size);
        let mut tangent = DMatrix::zeros(size, size);
        let mut at = 0;
        for element in self.all {
            let rows = element.rows.len();
            element.add_force(
                at,
                &moved.as_slice()[at..at + rows],
                &mut spring_force,
                &mut tangent,
            );
            at += rows;
        }
        (
            force + spring_force - self.typical.component_mul(&moved),
            tangent,
        )
    }

    /// The forces p in equilibrium. Without convergence the error contains the last forces.
    pub fn solve(&self) -> Result<DVector<f64>, DVector<f64>> {
        let size = self.free.len();
        let mut force = DVector::zeros(size);
        for _ in 0..MOST_STEPS {
            let (residual, tangent) = self.at(&force);
            let difference = tangent - DMatrix::from_diagonal(&(&self.typical * (1.0 - FLOOR)));
            let system = DMatrix::identity(size, size) + difference * &self.compliance;
            let Some(step) = system.lu().solve(&-&residual) else {
                return Err(force);
            };
            let slope = |length: f64| {
                let (residual, _) = self.at(&(&force + &step * length));
                step.dot(&(&self.compliance * residual))
            };
            let start = slope(0.0);
            let work = self.typical.dot(&self.moved(&force).map(|d| d * d));
            if -start <= SMALL_WORK * work {
                return Ok(force + step);
            }
            // Bisects until the slope has at most half the modulus of the first one. A full step may stay
            // steeper downhill.
            let mut bracket = [0.0, 1.0];
            let mut length = 1.0;
            let mut now = slope(length);
            for _ in 0..MOST_HALVINGS {
                if now <= 0.5 * start.abs() && (now >= 0.5 * start || length == 1.0) {
                    break;
                }
                bracket[usize::from(now > 0.0)] = length;
                length = 0.5 * (bracket[0] + bracket[1]);
                now = slope(length);
            }
            force += step * length;
        }
        Err(force)
    }
}
