//! Real decoupling of modes that dampers, drag, gyroscopic terms and circulatory stiffness couple.
//!
//! In mass-normalised modal coordinates the drive obeys `q'' + D q' + (W² + S) q = f`, with
//! `W = diag(w)`. Its first-order form is `x' = A x + (0, f)` with `x = (q, v)` and
//! `A = [[0, I], [-(W² + S), -D]]`. [`decouple`] finds a real `T` with `A T = T B`, where `B` is
//! block diagonal with one real 2x2 block per mode.

mod clusters;
mod components;
mod decomposition;
mod improvement;
mod parts;
mod planes;

use components::{components, isolate_rigid};
use decomposition::{decompose, scales};
use faer::Mat;
pub use parts::{CONDITION_BOUND, DecouplingError};
use parts::{Direction, ROUND_OFF};

/// The change of state `x = T z` and the blocks of `B = T⁻¹ A T`.
///
/// The state is `x = (q, v)`, modal displacements (m √kg) before modal velocities (m √kg / s), and
/// `z` holds the first components of all blocks before their second components, so block `i` acts
/// on `z[i]` and `z[N + i]`. Uncoupled modes keep `z[i] = q[i]`, `z[N + i] = v[i]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoupled {
    /// The `N` blocks of `B`, row by row, 1/s: `z_i' = B_i z_i`. A companion block
    /// `[[0, 1], [-(w² + S_ii), -D_ii]]` for an uncoupled mode, `[[0, 1], [0, l]]` for a rigid
    /// direction with an exact zero eigenvalue, `[[mu, nu], [-nu, mu]]` for the pair `mu ± i nu`,
    /// and a general block for two nearly parallel eigenvectors or two real eigenvalues. Two zero
    /// eigenvalues that have no decaying partners (a rigid body under a gyroscopic couple) share
    /// a block of zeros.
    pub generators: Vec<[[f64; 2]; 2]>,
    /// `T`, `2N` by `2N`, row by row.
    pub to_structure: Vec<f64>,
    /// `T⁻¹`, `2N` by `2N`, row by row.
    pub from_structure: Vec<f64>,
    /// Ratio of the largest to the smallest singular value of `T` with displacements multiplied by
    /// the scales of the modes, usually their frequencies, and columns scaled to length 1.
    pub condition: f64,
    /// Whether `T` is the identity, which holds when no two modes are coupled.
    pub is_identity: bool,
}

/// Finds `T` and the blocks of `B` with `A T = T B` for `N` modes.
///
/// `frequency` holds `w` in rad/s (0 for a rigid mode), `damping` holds `D` (`N` by `N`, row by
/// row, 1/s) and `stiffness` holds `S` (`N` by `N`, row by row, 1/s²). Neither matrix needs to be
/// symmetric.
///
/// Rigid directions whose columns are zero in `D` and `S`, or in `S`, are separated by a rotation first, and each
/// takes the place of a rigid mode. Then the modes are split into the connected components of the coupling graph.
/// A component of one mode keeps its companion block without arithmetic. In a larger one, blocks are in ascending
/// order of `sqrt(|det B_i|)`, the geometric mean of the moduli of their eigenvalues.
///
/// # Errors
/// Wrong lengths, values that are not finite, negative frequencies, an iteration that does not converge, and
/// components in which more than two eigenvectors are nearly parallel.
pub fn decouple(
    frequency: &[f64],
    damping: &[f64],
    stiffness: &[f64],
) -> Result<Decoupled, DecouplingError> {
    let n = frequency.len();
    if damping.len() != n * n || stiffness.len() != n * n {
        return Err(DecouplingError::Size(n));
    }
    let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
    if !finite(frequency)
        || !finite(damping)
        || !finite(stiffness)
        || frequency.iter().any(|w| *w < 0.0)
    {
        return Err(DecouplingError::Value);
    }
    let mut coupling = [damping, stiffness].map(|m| Mat::from_fn(n, n, |i, j| m[i * n + j]));
    let floor = [0, 1].map(|k| ROUND_OFF * coupling[k].norm_max());
    let mut rotation = Mat::<f64>::identity(n, n);
    let mut kind = vec![Direction::General; n];
    for part in components(&mut coupling, floor) {
        let rigid: Vec<usize> = part
            .iter()
            .copied()
            .filter(|i| frequency[*i] == 0.0)
            .collect();
        if part.len() > 1 && !rigid.is_empty() {
            isolate_rigid(&part, rigid, floor, &mut coupling, &mut rotation, &mut kind)?;
        }
    }
    let mut generators = vec![[[0.0; 2]; 2]; n];
    let mut t = Mat::<f64>::identity(2 * n, 2 * n);
    let mut inverse = t.clone();
    let (mut largest, mut smallest) = (1.0_f64, 1.0_f64);
    let mut is_identity = rotation == Mat::<f64>::identity(n, n);
    for part in components(&mut coupling, floor) {
        if let [i] = part[..] {
            let w = frequency[i];
            generators[i] = [
                [0.0, 1.0],
                [
                    0.0 - (w * w + coupling[1][(i, i)]),
                    0.0 - coupling[0][(i, i)],
                ],
            ];
            continue;
        }
        is_identity = false;
        let m = part.len();
        let scale = scales(&part, frequency, &coupling);
        let (mut blocks, back, singular) = decompose(&part, frequency, &coupling, &kind, &scale)?;
        largest = largest.max(singular.0);
        smallest = smallest.min(singular.1);
        let place = |k: usize| if k < m { part[k] } else { n + part[k - m] };
        for (b, block) in blocks.iter_mut().enumerate() {
            // A rigid direction gets the block of a rotation with drag, in displacement and speed.
            let [[zero, beta], [other, rate]] = block.generator;
            let exact = zero == 0.0 && other == 0.0 && beta.abs() > 0.1 * rate.abs();
            let factor = if exact { beta } else { 1.0 };
            block.generator[0][1] = if exact { 1.0 } else { beta };
            generators[part[b]] = block.generator;
            for k in 0..2 * m {
                let unit = if k < m { scale[k] } else { 1.0 };
                t[(place(k), part[b])] = block.columns[0][k] * factor / unit;
                t[(place(k), n + part[b])] = block.columns[1][k] / unit;
                inverse[(part[b], place(k))] = back[(2 * b, k)] * unit / factor;
                inverse[(n + part[b], place(k))] = back[(2 * b + 1, k)] * unit;
            }
        }
    }
    if rotation != Mat::<f64>::identity(n, n) {
        // Only the rows of rotated rigid modes change, so that the other modes keep their bits.
        for half in [0, n] {
            let (old, old_inverse) = (t.clone(), inverse.clone());
            let turned =
                |i: &usize| (0..n).any(|k| rotation[(*i, k)] != if *i == k { 1.0 } else { 0.0 });
            for i in (0..n).filter(turned) {
                for c in 0..2 * n {
                    t[(half + i, c)] = (0..n).map(|k| rotation[(i, k)] * old[(half + k, c)]).sum();
                    inverse[(c, half + i)] = (0..n)
                        .map(|k| old_inverse[(c, half + k)] * rotation[(i, k)])
                        .sum();
                }
            }
        }
    }
    let rows = |m: &Mat<f64>| {
        (0..4 * n * n)
            .map(|k| m[(k / (2 * n), k % (2 * n))])
            .collect()
    };
    Ok(Decoupled {
        generators,
        to_structure: rows(&t),
        from_structure: rows(&inverse),
        condition: largest / smallest,
        is_identity,
    })
}

#[cfg(test)]
mod tests;
