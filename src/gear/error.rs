//! What can be wrong with the drawing of a gear pair.

/// Why a drawing is not a gear pair that runs. Gears are counted 1 = pinion, 2 = wheel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GearError {
    /// The base circles overlap at the given centre distance.
    #[error(
        "a centre distance of {centre_distance:.6} m is not more than the sum {base_radii:.6} m of the base radii: there is no line of action; raise it"
    )]
    BaseCirclesOverlap {
        /// Centre distance \[m\].
        centre_distance: f64,
        /// Sum of the base radii \[m\].
        base_radii: f64,
    },
    /// The profile shifts are so negative that no centre distance is free of backlash.
    #[error(
        "profile shifts with the sum {sum} leave no centre distance without backlash; it must be more than {limit:.4}"
    )]
    ShiftSum {
        /// Sum of the profile shift coefficients.
        sum: f64,
        /// The sum at which the operating pressure angle is 0.
        limit: f64,
    },
}
