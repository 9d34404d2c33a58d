//! How the gears of the mesh roll and slide on each other at the mean speed.

/// Speeds that losses follow from. Vibration adds to them what the mesh deflection adds to the rotations, a
/// hundredth and less of them, which is left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rolling {
    /// Speed of the flanks along the line of action, `r_b1 Ω₁` \[m/s\].
    pub base_speed: f64,
    /// Coulomb friction coefficient μ_f \[1\].
    pub friction: f64,
    /// By which the gears turn against each other, `Ω₁ + Ω₂` \[rad/s\]: times the distance from the pitch point
    /// the speed of sliding.
    pub sliding: f64,
}
