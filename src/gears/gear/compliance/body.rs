//! A whole gear as one elastic body: teeth on a ring.
//!
//! Every tooth is a [`Plate`] whose foot is part of a [`Ring`]. The ring relates the displacements U of all
//! feet to their tractions q, `U = R q`. The teeth relate the tractions to the displacements, `q = g − S U`.
//! Here g is the force that a load on the flank exerts on a clamped foot. Hence `U = (R⁻¹ + S)⁻¹ g = H g`. A
//! tooth without load stiffens the ring like any other. The feet repeat round the gear, so H is a sum of
//! waves.
//!
//! The reference point of a force f is where its line crosses the centre line of the tooth. If the foot is clamped, f
//! displaces this point by `P f`. A displacement U of the foot adds `pᵀ U`, with the forces p on the clamped foot under
//! a unit force at this point. The compliance matrix of several teeth is symmetric, and that of all positive definite.

use super::plate::{Plate, Resolution};
use super::ring::{Ring, quarter_turns, waves};
use crate::gear::{Material, Tooth};
use crate::numerics::quadrature::GaussLegendre;
use crate::numerics::{legendre, linalg};
use faer::Mat;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

/// The resolution in use. The unit tests check its convergence.
const RESOLUTION: Resolution = Resolution {
    degree_across: 12,
    degree_along: 14,
    foot_modes: 10,
    harmonics: 100.0,
};

/// Number of terms of the series in the roll angle. The coefficients of the compliances fall to a thousandth of the
/// first within eleven terms. Later coefficients do not fall: they come from the error of the plate's polynomials.
/// Without them a mesh table needs fewer pieces.
const TERMS: usize = 12;

/// Largest number of terms of a series.
const MOST_TERMS: usize = 16;

/// Roll angles at which the series are computed: enough that products of the plate's
/// polynomials do not alias to lower degrees.
const NODES: usize = 48;

/// Smallest ratio of root to bore radius at which the rim below the teeth is solved as accurately
/// as thicker ones.
pub(in crate::gear) const LEAST_BODY_RATIO: f64 = 1.06;

/// The elastic bodies of both gears. They are solved at the first use, because checks of a drawing's geometry do not
/// need them. Equal drawings have equal bodies. `None` for a gear whose numbers are not finite.
#[derive(Debug, Clone, Default)]
pub(in crate::gear) struct GearBodies(pub(super) OnceLock<[Option<GearBody>; 2]>);

impl PartialEq for GearBodies {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Compliances of one gear as functions of the roll angle at which a flank is loaded, per
/// unit width \[m²/N\].
#[derive(Debug, Clone, PartialEq)]
pub(in crate::gear) struct GearBody {
    /// Roll angles that the series cover.
    range: [f64; 2],
    /// Legendre series of the compliance of the tooth with its foot clamped.
    tooth: Vec<f64>,
    /// Legendre series of the compliance of the body below the tooth.
    foundation: Vec<f64>,
    /// Displacements of the teeth 1, 2 … ahead under a load on this tooth, along the forces on their flanks.
    /// Ahead is the +x direction. An entry has coefficients of products of Legendre polynomials, row by row. A row
    /// belongs to a polynomial of the roll angle of the tooth ahead, a column to one of the roll angle of the
    /// load.
    neighbours: Vec<Vec<f64>>,
}

impl GearBody {
    /// Solves a gear whose tooth is loaded between two roll angles; `ratio` is the root radius divided by the bore
    /// radius. Couplings include the teeth up to `neighbours` ahead. `plane_stress` is the material in plane stress.
    /// `None` if the numbers are not finite.
    pub fn new(
        tooth: &Tooth,
        teeth: u32,
        ratio: f64,
        plane_stress: &Material,
        range: [f64; 2],
        neighbours: usize,
    ) -> Option<Self> {
        Self::resolved(
            tooth,
            (teeth, ratio),
            plane_stress,
            range,
            neighbours,
            &RESOLUTION,
            [NODES, TERMS],
        )
    }

    pub(super) fn resolved(
        tooth: &Tooth,
        (teeth, ratio): (u32, f64),
        plane_stress: &Material,
        range: [f64; 2],
        neighbours: usize,
        resolution: &Resolution,
        [nodes, terms]: [usize; 2],
    ) -> Option<Self> {
        let nodes = GaussLegendre::new(nodes);
        let [low, high] = range;
        let rolls: Vec<f64> = (nodes.nodes.iter())
            .map(|x| 0.5 * (low + high) + 0.5 * (high - low) * x)
            .collect();
        let nu = plane_stress.poisson_ratio;
        let plate = Plate::new(tooth, nu, &rolls, resolution)?;
        let foot = resolution.foot_modes;
        let waves = waves(
            teeth,
            tooth.root_half_angle,
            &Ring::new(ratio, nu),
            foot,
            resolution.harmonics,
        );
        let turns: Vec<usize> = (0..2 * foot)
            .map(|mode| quarter_turns(mode, foot))
            .collect();
        let feet = feet(teeth, &waves, &plate.stiffness, &turns, neighbours)?;
        let series =
            |values: &dyn Fn(usize) -> f64, scale: f64| series(&nodes, terms, values, scale);
        let compliance = 1.0 / plane_stress.young_modulus;
        let foundation = |index: usize| work(&feet[0], &plate.places[index], &plate.forces[index]);
        // Forces on the foot, mode by mode.
        let forces: Vec<Vec<f64>> = (0..2 * foot)
            .map(|mode| series(&|index| plate.forces[index][mode], compliance.sqrt()))
            .collect();
        let neighbours = feet.iter().skip(1).map(|feet| {
            let term = |n: usize| -> Vec<f64> { forces.iter().map(|series| series[n]).collect() };
            let products =
                (0..terms).flat_map(|teeth_ahead| (0..terms).map(move |own| [teeth_ahead, own]));
            products
                .map(|[teeth_ahead, own]| work(feet, &term(teeth_ahead), &term(own)))
                .collect()
        });
        Some(Self {
            range,
            tooth: series(&|index| plate.clamped[index], compliance),
            foundation: series(&foundation, compliance),
            neighbours: neighbours.collect(),
        })
    }

    fn place(&self, roll: f64) -> f64 {
        let [low, high] = self.range;
        (2.0 * roll - low - high) / (high - low)
    }

    /// Compliance of the tooth above its foot, loaded at a roll angle.
    pub fn tooth(&self, roll: f64) -> f64 {
        legendre::evaluate(&self.tooth, self.place(roll))
    }

    /// Compliance of the body below the tooth, loaded at a roll angle.
    pub fn foundation(&self, roll: f64) -> f64 {
        legendre::evaluate(&self.foundation, self.place(roll))
    }

    /// Displacement of the tooth that is `teeth_ahead` ≥ 1 teeth ahead (in the +x direction), along the force on its
    /// flank at its roll angle `roll_ahead`, under a unit load at the roll angle `roll` of this tooth.
    /// Exchanging load and displacement gives the same value. `None` beyond the known neighbours.
    pub fn coupling(&self, roll: f64, teeth_ahead: usize, roll_ahead: f64) -> Option<f64> {
        let products = self.neighbours.get(teeth_ahead.checked_sub(1)?)?;
        let terms = self.tooth.len();
        let mut room = [[0.0; MOST_TERMS]; 2];
        let [far, near] = &mut room;
        legendre::polynomials(self.place(roll_ahead), &mut far[..terms]);
        legendre::polynomials(self.place(roll), &mut near[..terms]);
        let rows = far.iter().zip(products.chunks_exact(terms));
        Some(
            rows.map(|(p, row)| p * row.iter().zip(&*near).map(|(a, q)| a * q).sum::<f64>())
                .sum(),
        )
    }
}

/// Work of forces at the displacements that other forces cause.
fn work(compliance: &[Vec<f64>], forces: &[f64], others: &[f64]) -> f64 {
    (forces.iter().zip(compliance))
        .map(|(force, row)| force * row.iter().zip(others).map(|(c, o)| c * o).sum::<f64>())
        .sum()
}

/// The first terms of the Legendre series of a function with these values at the nodes of a rule.
pub(super) fn series(
    rule: &GaussLegendre,
    terms: usize,
    values: &dyn Fn(usize) -> f64,
    scale: f64,
) -> Vec<f64> {
    let mut series = vec![0.0; terms];
    let mut polynomials = vec![0.0; terms];
    for (index, (node, weight)) in rule.nodes.iter().zip(&rule.weights).enumerate() {
        legendre::polynomials(*node, &mut polynomials);
        let value = scale * weight * values(index);
        for (n, (term, polynomial)) in series.iter_mut().zip(&polynomials).enumerate() {
            *term += (n as f64 + 0.5) * value * polynomial;
        }
    }
    series
}

/// Compliance matrices of a foot, row by row: displacements under tractions on this foot, then under
/// tractions on the foot that is 1, 2 … teeth behind it. `None` if a matrix is not definite.
///
/// * `waves`: compliance of the ring for each wave k = 0 … z/2 round the gear;
/// * `stiffness`: stiffness of a tooth against displacements of its foot;
/// * `turns`: phase of each mode of the foot, in quarter turns.
pub(super) fn feet(
    teeth: u32,
    waves: &[Mat<f64>],
    stiffness: &Mat<f64>,
    turns: &[usize],
    neighbours: usize,
) -> Option<Vec<Vec<Vec<f64>>>> {
    let modes = turns.len();
    // Modes that the plate couples differ by an even number of quarter turns.
    let stiffness = Mat::from_fn(modes, modes, |i, j| {
        let value = stiffness[(i, j)];
        if (turns[i] + 4 - turns[j] % 4) % 4 == 2 { -value } else { value }
    });
    let mut sums = vec![vec![vec![0.0; modes]; modes]; neighbours + 1];
    for (order, compliance) in waves.iter().enumerate() {
        let joined = joined(compliance, &stiffness)?;
        // The wave in the opposite direction is the mirror image of this one, so both are added together.
        let alone = order == 0 || 2 * order == teeth as usize;
        let weight = if alone { 1.0 } else { 2.0 } / f64::from(teeth);
        for (distance, sum) in sums.iter_mut().enumerate() {
            let angle = 2.0 * PI * (order * distance) as f64 / f64::from(teeth);
            for i in 0..modes {
                for j in 0..modes {
                    let quarters = (turns[i] + 4 - turns[j] % 4) % 4;
                    let phase = (angle + FRAC_PI_2 * quarters as f64).cos();
                    sum[i][j] += weight * phase * joined[(i, j)];
                }
            }
        }
    }
    Some(sums)
}

/// `(R⁻¹ + S)⁻¹` of a positive definite R and a positive semidefinite S: with `R = L Lᵀ` it is
/// `L (1 + Lᵀ S L)⁻¹ Lᵀ`.
fn joined(compliance: &Mat<f64>, stiffness: &Mat<f64>) -> Option<Mat<f64>> {
    let modes = compliance.nrows();
    let lower = linalg::cholesky(compliance)?;
    let mut middle = linalg::product(
        linalg::product(lower.transpose(), stiffness.as_ref()).as_ref(),
        lower.as_ref(),
    );
    for mode in 0..modes {
        middle[(mode, mode)] += 1.0;
    }
    let root = linalg::cholesky(&middle)?;
    let mut half = lower.transpose().to_owned();
    linalg::solve_lower(&root, &mut half);
    Some(linalg::product(half.transpose(), half.as_ref()))
}

#[cfg(test)]
#[path = "body_tests.rs"]
mod tests;
