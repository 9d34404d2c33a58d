//! Why a kernel of dense tables cannot be built for a model.

use crate::propagate::TableError;

/// Why a kernel of dense tables cannot be built for a model.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DenseError {
    /// Tables cannot represent the model.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The contacts are not two flanks on one line.
    #[error("dense tables need two flanks with the same line of action and the same stiffness")]
    Contacts,
    /// Modes are coupled, or a load is not proportional to the rated one.
    #[error(
        "dense tables accept only modal damping and loads in proportion to the rated load; remove dampers, drag, \
         gyroscopic terms and cross-coupled bearings"
    )]
    Coupled,
    /// A mode has two real eigenvalues.
    #[error("dense tables cannot represent overdamped modes")]
    Overdamped,
    /// A cycle would need too many cells.
    #[error("one mesh cycle would take {cells:.0} cells; raise the speed or omit high modes")]
    TooManyCells {
        /// Number of cells that a cycle would need.
        cells: f64,
    },
}
