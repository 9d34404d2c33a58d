//! Why a kernel of dense tables cannot be built for a model.

use crate::propagate::TableError;

/// Why a kernel of dense tables cannot be built for a model.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DenseError {
    /// No kernel of tables serves it, or kept tables do not fit it.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The contacts are not two flanks on one line.
    #[error("dense tables take two flanks with one line of action and one stiffness")]
    Contacts,
    /// Modes are coupled, or a load is not in proportion to the rated one.
    #[error(
        "dense tables take modal damping and loads in proportion to the rated one, not dampers, drag, gyroscopic terms \
         or cross-coupled bearings"
    )]
    Coupled,
    /// A mode has two real eigenvalues.
    #[error("dense tables take no overdamped mode")]
    Overdamped,
    /// A cycle would take more cells than tables should have.
    #[error("one mesh cycle would take {cells:.0} cells; raise the speed or leave out high modes")]
    TooManyCells {
        /// How many.
        cells: f64,
    },
}
