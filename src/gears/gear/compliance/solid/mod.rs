//! A whole gear as an elastic solid whose load varies along the face: teeth on a ring, both with free ends.
//!
//! As in the plane (`body.rs`), the foot of every tooth is part of a ring. The displacements of all feet
//! follow from the forces of loads on clamped feet. All quantities are expanded in waves along the face.
//! Lengths are in root radii and stresses in Young's moduli, so compliances come out times E per unit width.

mod axial;
mod ring;
mod tooth;

use super::body::feet;
use crate::gear::Tooth;
use crate::numerics::linalg;
use axial::FaceIntegrals;
use faer::Mat;
use tooth::{FOOT, SolidTooth};

/// Number of teeth beyond the loaded one whose displacement is computed.
const NEIGHBOURS: usize = 2;

/// Largest number of waves along the face.
const MOST_WAVES: usize = 24;

/// Number of waves that resolve the compliance of teeth on a face whose width is `heights` tooth heights.
/// Up to [`MOST_WAVES`], half the shortest wavelength is about 0.45 heights. The compliance of teeth to this
/// wave is a twentieth of that to a uniform load.
pub(super) fn wave_count(heights: f64) -> usize {
    ((2.2 * heights).ceil() as usize + 1).min(MOST_WAVES)
}

/// Compliance of a gear: waves of displacement under waves of load along the face on one tooth, by roll angle.
pub(super) struct SolidGear {
    /// At the loaded tooth, for each roll angle: waves of displacement by rows.
    pub same_tooth: Vec<Mat<f64>>,
    /// The parts even and odd along the face.
    parities: [Parity; 2],
}

struct Parity {
    /// Forces of waves of load on a clamped foot, for each roll angle.
    forces: Vec<Mat<f64>>,
    /// Displacements of feet 1, 2 … teeth ahead under tractions on this foot.
    ahead: Vec<Mat<f64>>,
}

impl SolidGear {
    /// A gear of `teeth` equal teeth with the `ratio` of root to bore radius, loaded at the roll angles
    /// `rolls` of a flank. Loads are expanded in `waves` waves along a face of `width` \[m\]. `None` if the
    /// numbers are not finite.
    pub fn new(
        tooth: &Tooth,
        teeth: u32,
        ratio: f64,
        poisson_ratio: f64,
        width: f64,
        waves: usize,
        rolls: &[f64],
    ) -> Option<Self> {
        let mut same_tooth = vec![Mat::zeros(waves, waves); rolls.len()];
        let parity = |odd: bool, same_tooth: &mut Vec<Mat<f64>>| -> Option<Parity> {
            let axial = FaceIntegrals::new(width / tooth.root_radius, waves + 1, waves, odd);
            let solid = SolidTooth::new(tooth, poisson_ratio, rolls, &axial)?;
            let ring = ring::waves(teeth, tooth.root_half_angle, ratio, poisson_ratio, &axial)?;
            let turns = quarter_turns(&axial);
            let mut feet: Vec<Mat<f64>> = feet(teeth, &ring, &solid.stiffness, &turns, NEIGHBOURS)?
                .iter()
                .map(|rows| Mat::from_fn(rows.len(), rows.len(), |i, j| rows[i][j]))
                .collect();
            let ahead = feet.split_off(1);
            for (index, same_tooth) in same_tooth.iter_mut().enumerate() {
                let carried = linalg::product(feet[0].as_ref(), solid.forces[index].as_ref());
                let body = linalg::product(solid.places[index].transpose(), carried.as_ref());
                let first = usize::from(odd);
                for j in 0..body.ncols() {
                    for i in 0..body.nrows() {
                        same_tooth[(first + 2 * i, first + 2 * j)] =
                            solid.clamped[index][(i, j)] + body[(i, j)];
                    }
                }
            }
            Some(Parity {
                forces: solid.forces,
                ahead,
            })
        };
        let parities = [
            parity(false, &mut same_tooth)?,
            parity(true, &mut same_tooth)?,
        ];
        Some(Self {
            same_tooth,
            parities,
        })
    }

    /// Waves of displacement (rows) of the tooth that is `ahead` ≥ 1 teeth ahead (in the +x direction), under
    /// waves of load (columns) on this tooth. A displacement is along the force on the flank of its tooth. `far`
    /// and `near` are the indices of the roll angles of the tooth ahead and of this one.
    pub fn coupling(&self, ahead: usize, [far, near]: [usize; 2]) -> Mat<f64> {
        let waves = self.same_tooth[near].nrows();
        let mut out = Mat::zeros(waves, waves);
        for (first, parity) in self.parities.iter().enumerate() {
            let carried = linalg::product(
                parity.ahead[ahead - 1].as_ref(),
                parity.forces[near].as_ref(),
            );
            let moved = linalg::product(parity.forces[far].transpose(), carried.as_ref());
            for j in 0..moved.ncols() {
                for i in 0..moved.nrows() {
                    out[(first + 2 * i, first + 2 * j)] = moved[(i, j)];
                }
            }
        }
        out
    }
}

/// Phase of each mode of a foot in quarter turns. With these phases the compliance of a wave round the
/// gear is real.
fn quarter_turns(axial: &FaceIntegrals) -> Vec<usize> {
    let of = |waves: usize, turn: usize| {
        (0..FOOT).flat_map(move |degree| std::iter::repeat_n(degree + turn, waves))
    };
    let (waves, axial_waves) = (axial.numbers.len(), axial.axial_numbers.len());
    (of(waves, 0).chain(of(waves, 3)).chain(of(axial_waves, 0))).collect()
}

#[cfg(test)]
mod tests;
