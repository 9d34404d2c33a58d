//! Common types and tolerances of the steps of a decoupling.

/// Entries below this fraction of the largest entry of their matrix count as round-off.
pub(super) const ROUND_OFF: f64 = 64.0 * f64::EPSILON;
/// Singular values below this fraction of the largest one count as round-off.
pub(super) const SVD_ROUND_OFF: f64 = 256.0 * f64::EPSILON;
/// Largest condition number of the scaled change of state that [`super::decouple`] accepts.
///
/// Round-off splits two coinciding complex pairs that have a single eigenvector. Their condition number is
/// then 1e7 to 1e8. A larger bound would accept such pairs with few correct digits.
pub const CONDITION_BOUND: f64 = 3e6;
/// Two real eigenvectors share a block if the cosine of their angle exceeds this.
pub(super) const PARALLEL_COSINE: f64 = 0.9;
/// Largest condition number at which the real and the imaginary part of an eigenvector are the columns of a
/// block. It is also the largest one at which a double real eigenvalue, split by round-off, counts as having
/// two eigenvectors.
pub(super) const MOST_EIGENVECTOR_CONDITION: f64 = 100.0;
/// Above this condition number two eigenvectors no longer determine their common plane.
pub(super) const PLANE_CONDITION: f64 = 1e5;
/// Imaginary parts below this fraction of the matrix norm are round-off of a double real eigenvalue.
pub(super) const SPLIT_IMAGINARY: f64 = 16.0 * f64::EPSILON;
/// Imaginary parts below this fraction of the matrix norm are too uncertain for the form
/// `[[mu, nu], [-nu, mu]]`.
pub(super) const LEAST_IMAGINARY: f64 = 1e-9;
/// A pivot of the Sylvester equation `B X - X C = E` counts as zero below this fraction of the largest pivot. The
/// blocks B and C then have common eigenvalues.
pub(super) const EQUAL_EIGENVALUES: f64 = 1e-10;
/// Complex eigenvalues closer than this fraction of the matrix norm count as coinciding.
pub(super) const CLUSTER_DISTANCE: f64 = 1e-11;
/// Distance of the shift of inverse iteration from coinciding eigenvalues, as a fraction of the matrix norm.
pub(super) const CLUSTER_SHIFT: f64 = 1e-9;
/// Largest deviation of a matrix from a multiple of the identity that counts as round-off, as a fraction of
/// the norm.
pub(super) const SCALAR_DEVIATION: f64 = 1e-14;
/// Residual, as a fraction of the matrix norm, above which an eigenvector is computed again.
pub(super) const POOR_RESIDUAL: f64 = 1e-10;
/// Distance of the shift of inverse iteration from a single eigenvalue, as a fraction of the matrix norm.
pub(super) const OFFSET: f64 = 1e-7;
/// Largest number of steps of iterative improvement.
pub(super) const IMPROVEMENTS: usize = 6;
/// Largest accepted residual of blocks, as a fraction of the matrix norm.
pub(super) const ACCURACY: f64 = 1e-13;

/// Why the modes cannot be decoupled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DecouplingError {
    /// The lengths of the arguments do not belong to the same number of modes.
    #[error("give damping and stiffness as {0} by {0} matrices, one row per mode")]
    Size(usize),
    /// A frequency is negative, or a number is infinite or NaN.
    #[error("give finite numbers only, and frequencies that are not negative")]
    Value,
    /// An eigenvalue or singular value iteration did not converge.
    #[error(
        "the eigenvalues of the modes {} were not found; check the magnitude of their damping and stiffness",
        list(.0)
    )]
    NoConvergence(Vec<usize>),
    /// More than two eigenvectors are nearly parallel.
    #[error(
        "more than two eigenvectors of the modes {} are nearly parallel (condition number {condition:.1e}); \
         change their damping or cross stiffness slightly",
        list(.modes)
    )]
    NearlyDefective {
        /// Modes with the largest participation, counted from 1, the largest first.
        modes: Vec<usize>,
        /// Condition number of the scaled change of state; infinite if it is singular.
        condition: f64,
    },
}

fn list(modes: &[usize]) -> String {
    let names: Vec<String> = modes.iter().map(usize::to_string).collect();
    names.join(", ")
}

/// What is exactly known about a coordinate direction `r`, after the rotation that separates rigid
/// directions.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Direction {
    /// Nothing is known. Every elastic mode has this kind.
    General,
    /// `D r = 0` and `S r = 0`: the columns of both its displacement and its velocity are known.
    Free,
    /// `S r = 0`: the column of its displacement vanishes.
    Unsprung,
}

/// Two columns that span an invariant plane of the scaled matrix, and the block on them.
pub(super) struct Block {
    pub columns: [Vec<f64>; 2],
    pub generator: [[f64; 2]; 2],
    pub is_rotation: bool,
}
