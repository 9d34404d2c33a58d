//! How does the mesh behave over its cycle? Stiffness, load centroid, loaded transmission
//! error, friction and load shares over mesh phase, misalignment and torque, in numbers.
//!
//! The cycle is cut into pieces inside which all quantities are smooth in the mesh phase. A piece has the values at
//! eight Gauss nodes and the polynomial through them. A piece ends at a kink due to the load, for example where a
//! relieved pair takes up load. Between the nodes the polynomials of every piece are within a tolerance of the law. All
//! loads and misalignments of a table have the same pieces.

mod breaks;
mod build;
mod cycle;
mod error;
mod joined_pieces;
mod law;
mod pieces;
mod spec;

pub(super) use breaks::breaks;
pub use cycle::{MeshTableCycle, MeshTablePiece, SegmentMeans};
pub use error::MeshTableError;
pub use joined_pieces::{JoinedPieces, JoiningAccuracy};
pub(super) use pieces::{EXTRAPOLATED_AT, EXTRAPOLATION_LIMITS};
pub use spec::{CycleDivision, MeshTableSpec};

use super::GearPair;
use super::sharing::{Contact, MOST_PAIRS};
use strum::EnumString;

/// Gauss nodes of a piece.
pub const NODES: usize = 8;

/// Whether slices of the face are elastically coupled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum FaceLaw {
    /// Coupled through teeth and gear bodies, if the law of the pairs describes the coupling.
    Coupled,
    /// Independent, as in thin-slice models.
    Independent,
}

/// Which stiffness represents a mesh near a load F.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum StiffnessLaw {
    /// The tangent stiffness dF/dx. Over the mesh cycle it jumps where a pair takes up load. The force of the
    /// linear law then jumps too, except at the load F itself.
    Tangent,
    /// The secant stiffness from the first touch of the flanks to F,
    ///
    /// ```text
    /// k = F/(x(F) − x(0))
    /// ```
    ///
    /// Under a given load the approach x does not step over the mesh cycle. Neither do k, the error
    /// `x(F) − F/k = x(0)` and the force of the linear law at any deflection.
    Secant,
}

impl StiffnessLaw {
    /// Whether it is [`Self::Tangent`].
    pub fn is_tangent(&self) -> bool {
        *self == Self::Tangent
    }
}

/// Inputs that determine a table, besides the [`FlankLaw`](super::FlankLaw).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MeshTableInputs {
    /// Face width \[m\].
    pub face_width: f64,
    /// Base radius of the pinion \[m\]: the mesh force is `torque / base_radius`.
    pub base_radius: f64,
    /// Angles between the flanks in the plane of action \[rad\], increasing.
    pub misalignment: Vec<f64>,
    /// Torques on the pinion \[N m\], > 0, increasing.
    pub torque: Vec<f64>,
    /// Largest length of a piece, in mesh cycles.
    pub longest_piece: f64,
    /// Largest error of a piece's polynomials, as a part of a reference. The reference is the value for stiffness,
    /// the deflection of the mesh by the load for deflections, the face width for the load centroid, the base pitch
    /// for the friction lever, otherwise 1. For helical gears the tolerance is at least 1e-5, and 1e-2 for pieces
    /// shorter than 1/128 of the cycle. For spur gears with uneven loads on coupled slices it is the tolerance
    /// divided by the length of the piece in cycles, at most 1e-2 unless the piece is too short to be cut.
    pub tolerance: f64,
    /// Slices of the face. One is enough for flanks without deviation across the face; more
    /// resolve crowning and the contact pattern. A helical face is divided into about as many.
    pub slices: usize,
    /// Whether slices of the face are elastically coupled.
    pub face: FaceLaw,
    /// How the flanks flatten at their contact.
    pub contact: Contact,
    /// Which stiffness the table has.
    #[serde(skip_serializing_if = "StiffnessLaw::is_tangent")]
    pub stiffness: StiffnessLaw,
    /// Whether to keep the contact pattern.
    pub pattern: bool,
}

impl MeshTableInputs {
    /// Aligned gears at rated torque: pieces of at most a twelfth of the cycle, within 1e-9 of the
    /// law, 64 elastically coupled slices, no contact pattern.
    pub fn of_gears(gears: &GearPair) -> Self {
        Self {
            face_width: gears.face_width,
            base_radius: gears.base_radii()[0],
            misalignment: vec![0.0],
            torque: vec![gears.rated_torque],
            longest_piece: 1.0 / 12.0,
            tolerance: 1e-9,
            slices: 64,
            face: FaceLaw::Coupled,
            contact: Contact::Linear,
            stiffness: StiffnessLaw::Tangent,
            pattern: false,
        }
    }
}

/// A mesh table. Arrays are row by row, `[misalignment][torque][piece][node]`.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MeshTable {
    /// Base radius of the pinion \[m\].
    pub base_radius: f64,
    /// Misalignments ε \[rad\].
    pub misalignment: Vec<f64>,
    /// Torques on the pinion \[N m\].
    pub torque: Vec<f64>,
    /// Ends of the pieces in mesh phase, 0 first and 1 last.
    pub breaks: Vec<f64>,
    /// Positions of the nodes on a piece, in (−1, 1).
    pub node: Vec<f64>,
    /// Mesh stiffness along the line of action in the transverse section \[N/m\]: the tangent dF/dx, or the secant
    /// if the inputs request it.
    pub stiffness: Vec<f64>,
    /// Load centroid z_c from mid-face \[m\].
    pub centre: Vec<f64>,
    /// Loaded static transmission error x \[m\]: approach of the gears along the line of
    /// action, gear bodies included, from flanks without deviation that touch at mid-face.
    pub transmission_error: Vec<f64>,
    /// Friction direction Λ₀.
    pub friction: Vec<f64>,
    /// Friction lever Λ₁ \[m\].
    pub friction_lever: Vec<f64>,
    /// Loaded part of the lines of contact.
    pub contact_fraction: Vec<f64>,
    /// Pairs of teeth that carry load anywhere on the face.
    pub loaded_pairs: Vec<f64>,
    /// `[…][MOST_PAIRS]`: share of each pair in the load, the latest pair first; on a helical face as in
    /// [`SharedLoad::share`](super::SharedLoad::share).
    pub share: Vec<f64>,
    /// `[misalignment][torque][phase][slice]`, phases piece by piece: line load of all pairs
    /// \[N/m\]; empty if not requested.
    pub pattern: Vec<f64>,
    /// Slices of the face.
    pub slices: usize,
}

impl MeshTable {
    /// Lengths of the axes: misalignments, torques, pieces, nodes.
    pub fn shape(&self) -> [usize; 4] {
        [
            self.misalignment.len(),
            self.torque.len(),
            self.breaks.len() - 1,
            self.node.len(),
        ]
    }

    /// The cycle of one tabulated misalignment and torque, by their indices.
    ///
    /// # Panics
    /// If the table has no such index.
    pub fn cycle(&self, misalignment: usize, torque: usize) -> MeshTableCycle {
        self.blend(&[(misalignment, 1.0)], &[(torque, 1.0)])
    }

    /// The cycle at a misalignment \[rad\] and a torque \[N m\].
    ///
    /// Linear between tabulated values: monotone if they are, with an error of at most `h²/8` times the second
    /// derivative on steps h. Stiffness under misalignment varies as `√(torque/ε)` while the face is partly loaded.
    /// Between values a factor r apart the interpolated stiffness is too small along the torque by up to `1 − 2
    /// r^¼/(1 + r^½)`, 1.5 % for r = 2 and 0.4 % for r = √2. Along ε it is too large by three times as much. The
    /// kinks of relieved flanks move with the load: between values the cycle has the weighted kinks of both
    /// neighbours. For a cycle within the tolerance of its law tabulate that load and misalignment.
    ///
    /// # Errors
    /// [`MeshTableError::Outside`] beyond the ends of an axis.
    pub fn interpolate(
        &self,
        misalignment: f64,
        torque: f64,
    ) -> Result<MeshTableCycle, MeshTableError> {
        let along_misalignment = weights("misalignment", &self.misalignment, misalignment)?;
        let along_torque = weights("torque", &self.torque, torque)?;
        Ok(self.blend(&along_misalignment, &along_torque))
    }

    /// Weighted sum of tabulated cycles.
    fn blend(&self, misalignment: &[(usize, f64)], torque: &[(usize, f64)]) -> MeshTableCycle {
        let [_, torques, pieces, _] = self.shape();
        let mut force = 0.0;
        for &(index, weight) in torque {
            force += weight * self.torque[index] / self.base_radius;
        }
        let gather = |values: &[f64], width: usize, offset: usize| -> Vec<[f64; NODES]> {
            let mut out = vec![[0.0; NODES]; pieces];
            for &(i, weight_i) in misalignment {
                for &(j, weight_j) in torque {
                    for (piece, out) in out.iter_mut().enumerate() {
                        let first = ((i * torques + j) * pieces + piece) * NODES;
                        for (node, out) in out.iter_mut().enumerate() {
                            let value = values[(first + node) * width + offset];
                            *out += weight_i * weight_j * value;
                        }
                    }
                }
            }
            out
        };
        MeshTableCycle {
            force,
            breaks: self.breaks.clone(),
            stiffness: gather(&self.stiffness, 1, 0),
            centre: gather(&self.centre, 1, 0),
            transmission_error: gather(&self.transmission_error, 1, 0),
            friction: gather(&self.friction, 1, 0),
            friction_lever: gather(&self.friction_lever, 1, 0),
            contact_fraction: gather(&self.contact_fraction, 1, 0),
            loaded_pairs: gather(&self.loaded_pairs, 1, 0),
            share: std::array::from_fn(|pair| gather(&self.share, MOST_PAIRS, pair)),
        }
    }
}

/// The neighbours of a value on an increasing axis, with their weights.
fn weights(
    axis: &'static str,
    values: &[f64],
    value: f64,
) -> Result<Vec<(usize, f64)>, MeshTableError> {
    let (lowest, highest) = (values[0], values[values.len() - 1]);
    if !(value >= lowest && value <= highest) {
        return Err(MeshTableError::Outside {
            axis,
            value,
            lowest,
            highest,
        });
    }
    let above = values.partition_point(|&v| v < value);
    if values[above] == value {
        return Ok(vec![(above, 1.0)]);
    }
    let (low, high) = (values[above - 1], values[above]);
    let weight = (value - low) / (high - low);
    Ok(vec![(above - 1, 1.0 - weight), (above, weight)])
}
