//! Rolling and sliding of the gears of the mesh at the mean speed.

/// Speeds of a mesh at the mean rotation, and its friction coefficient. They determine the losses. Vibration
/// changes these speeds by a hundredth or less, which is neglected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rolling {
    /// Speed of the flanks along the line of action, `r_b1 Ω₁` \[m/s\].
    pub base_speed: f64,
    /// Coulomb friction coefficient μ_f \[1\].
    pub friction: f64,
    /// Relative rotational speed of the gears, `Ω₁ + Ω₂` \[rad/s\]. Its product with the distance from the
    /// pitch point is the sliding speed.
    pub sliding: f64,
}
