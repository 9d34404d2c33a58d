//! Why a mesh table cannot be built or read.

use super::super::sharing::SharingError;

/// Why a mesh table cannot be built or read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshTableError {
    /// The load cannot be shared at some mesh phase.
    #[error("at mesh phase {phase}: {source}")]
    Sharing {
        /// Mesh phase in cycles.
        phase: f64,
        /// The error there.
        source: SharingError,
    },
    /// A path of contact that is not finite, has no direction or is shorter than a base pitch.
    #[error(
        "a path of contact from {start} to {end} m with a base pitch of {base_pitch} m has contact ratio {contact_ratio}; it must be at least 1"
    )]
    Path {
        /// Start of the path \[m\].
        start: f64,
        /// End of the path \[m\].
        end: f64,
        /// Base pitch \[m\].
        base_pitch: f64,
        /// Length of the path in base pitches.
        contact_ratio: f64,
    },
    /// Helical pairs were requested as springs.
    #[error(
        "pairs of teeth can be separate springs only on spur gears, but the lines of contact have the slope {helix}; \
         set mesh.resolution = \"secant\" or \"mean_load\""
    )]
    HelicalPairs {
        /// Slope of the lines of contact `tan β_b`.
        helix: f64,
    },
    /// Polynomials cannot follow a quantity within the tolerance.
    #[error(
        "at mesh phase {phase:.6} the interpolated {quantity} is off by {error:.1e} (tolerance {tolerance:.0e}), even \
         on the finest division of the mesh cycle. It has a jump or kink there that neither the flanks nor the load \
         explain. Raise the load, change the misalignment or the modifications of the flanks a little, or use means \
         over segments (mesh.stiffness = \"table\") instead of a continuous stiffness"
    )]
    Unresolved {
        /// Name of the quantity.
        quantity: &'static str,
        /// Mesh phase in cycles.
        phase: f64,
        /// Its error, relative; infinite if unknown.
        error: f64,
        /// Largest accepted error.
        tolerance: f64,
    },
    /// An axis without values, or with values that do not increase.
    #[error("the {axis} axis must have at least one value and increase; it is {values:?}")]
    Axis {
        /// `misalignment` or `torque`.
        axis: &'static str,
        /// Its values, SI.
        values: Vec<f64>,
    },
    /// A number outside its range.
    #[error("{name} is {value}; it must be {accepted}")]
    OutOfRange {
        /// Name of the number.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// Accepted values.
        accepted: &'static str,
    },
    /// A value beyond the ends of an axis.
    #[error("{axis} {value} is outside the table, which reaches from {lowest} to {highest}")]
    Outside {
        /// `misalignment` or `torque`.
        axis: &'static str,
        /// The requested value, SI.
        value: f64,
        /// First value of the axis.
        lowest: f64,
        /// Last value of the axis.
        highest: f64,
    },
}
