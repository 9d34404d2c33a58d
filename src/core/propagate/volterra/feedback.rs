//! How do force and deflection of a window in contact follow from its free deflection?

use super::shapes::{Row, Series, TERMS};
use super::varying::{Factors, Nodal};
use crate::numerics::linalg::invert;

/// The form of the solution operator of a window in contact.
#[derive(Debug, Clone, Copy)]
pub enum ContactSolve<'a> {
    /// An operator from a table.
    Table(&'a Feedback),
    /// The factors of the system of this window alone.
    Factors(&'a Nodal, &'a Factors),
}

/// The solution operator of one distinct pair (k, c), or of one window with varying k.
///
/// With 𝒟 the time derivative of a series, e₀ the series of the constant 1 and `S = (I + k B + c B')⁻¹`,
///
/// ```text
/// f = S̃ d − s b k S e₀,      S̃ = S (k I + c 𝒟)
/// δ = Q̃ d + s b k B S e₀,    Q̃ = I − B S̃
/// ```
#[derive(Debug)]
pub struct Feedback {
    /// Columns of S̃.
    pub force: [Row; TERMS],
    /// Columns of Q̃.
    pub deflection: [Row; TERMS],
    /// Contributions of a unit of s b to f and δ.
    pub gap: [Row; 2],
}

impl Feedback {
    /// The operator for windows of length `delta` \[s\], given the columns of B and B'.
    pub fn new(
        (stiffness, damping): (f64, f64),
        response: &[Series; TERMS],
        response_rate: &[Series; TERMS],
        delta: f64,
    ) -> Self {
        let (k, c) = (stiffness, damping);
        let mut system = [[0.0; TERMS]; TERMS];
        for j in 0..TERMS {
            for i in 0..TERMS {
                system[j][i] = k * response[j][i] + c * response_rate[j][i];
            }
            system[j][j] += 1.0;
        }
        let solution = invert(&system);
        // S 𝒟 e_j = 2/Δ Σ (2n+1) S e_n over n = j−1, j−3, …: two running sums.
        let mut sums = [[0.0; TERMS]; 2];
        let (mut to_force, mut to_deflection) = ([Row::ZERO; TERMS], [Row::ZERO; TERMS]);
        for (j, (force, deflection)) in to_force.iter_mut().zip(&mut to_deflection).enumerate() {
            for i in 0..TERMS {
                force.0[i] = k * solution[j][i] + c * 2.0 / delta * sums[j % 2][i];
                sums[(j + 1) % 2][i] += (2 * j + 1) as f64 * solution[j][i];
            }
            *deflection = Row(after_force(response, &force.0, -1.0));
            deflection.0[j] += 1.0;
        }
        let gap = solution[0].map(|s| -k * s);
        Self {
            force: to_force,
            deflection: to_deflection,
            gap: [Row(gap), Row(after_force(response, &gap, -1.0))],
        }
    }
}

/// `factor · B f`.
fn after_force(response: &[Series; TERMS], force: &Series, factor: f64) -> Series {
    let mut out = [0.0; TERMS];
    for (column, f) in response.iter().zip(force) {
        for (o, r) in out.iter_mut().zip(column) {
            *o += factor * f * r;
        }
    }
    out
}
