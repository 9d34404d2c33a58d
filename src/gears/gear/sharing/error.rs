//! Why can a load not be shared out?

/// Largest number of pairs that share a load.
pub const MOST_PAIRS: usize = 3;

/// Why a load cannot be shared out.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SharingError {
    /// No pair of teeth is in contact.
    #[error("no pair of teeth is in contact, because the contact ratio is below 1")]
    NoPair,
    /// More pairs than [`MOST_PAIRS`].
    #[error("{found} pairs in contact; at most {MOST_PAIRS} can share the load")]
    TooManyPairs {
        /// Number of pairs; counting stops one above [`MOST_PAIRS`].
        found: usize,
    },
    /// A quantity outside its physical range.
    #[error("{name} is {value} at {position} m from the pitch point; it must be {accepted}")]
    OutOfRange {
        /// Name of the quantity.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// Position on the line of action \[m\].
        position: f64,
        /// Accepted values.
        accepted: &'static str,
    },
    /// A contact law that does not converge.
    #[error(
        "the contact compliance at {position} m from the pitch point does not converge under its load; \
         check the derivative of the contact law"
    )]
    Unsettled {
        /// Position on the line of action \[m\].
        position: f64,
    },
    /// The coupling of two pairs is unphysically strong, or is not finite.
    #[error(
        "the gear bodies couple the pair at {position} m from the pitch point too strongly to another pair: one of \
         them loses load when the gears approach"
    )]
    Coupling {
        /// Position on the line of action \[m\].
        position: f64,
    },
    /// A face without width or slices.
    #[error(
        "a face of {width} m in {slices} slices cannot bear load; give a positive width and at least one slice"
    )]
    NoFace {
        /// Width \[m\].
        width: f64,
        /// Number of slices.
        slices: usize,
    },
}
