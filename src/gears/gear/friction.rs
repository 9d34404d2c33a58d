//! Direction and lever of sliding friction, from the positions of the pairs in contact.
//!
//! With `n = (sin α, cos α)` along the line of action and `t = (cos α, −sin α)` across it, the
//! contact at `s n` from the pitch point has the velocity `−Ω₁ (s + r₁ sin α)` along t on the
//! pinion and `Ω₂ (s − r₂ sin α)` on the wheel. As `Ω₁ r₁ = Ω₂ r₂` the pinion slides over the
//! wheel with `v = −(Ω₁ + Ω₂) s`, and friction on it is `−μ p F sign(v) t`. Hence, with load
//! shares p and σ = sign(v) = −sign(s), the mesh force F acts on the modes along
//!
//! ```text
//! w + μ (Λ₀ w_f + Λ₁ w_fl),   Λ₀ = Σ σ p,   Λ₁ = Σ σ p s = −Σ p |s|
//! ```
//!
//! (`friction` and `friction_lever` of the structure). Its power is `−μ F Σ p |v|`: friction
//! dissipates. For helical gears F is the force along the line of action in the transverse section, where the flanks
//! slide. Friction is proportional to the force along the normal of the flanks, so σ is ± 1/cos β_b. On the coast
//! flanks pairs are at the mirror images of these positions, −s. The pinion slides there in the opposite direction: Λ₀
//! has the opposite sign, Λ₁ the same sign.

/// Effect of friction per unit of coefficient and mesh force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionDirection {
    /// Net direction Λ₀ on the drive flanks: +1 if the pinion slides along +t under the whole load, as it does before
    /// the pitch point. For helical gears callers scale the shares or the result by 1/cos β_b.
    pub direction: f64,
    /// First moment Λ₁ of the direction about the pitch point \[m\], ≤ 0.
    pub lever: f64,
}

/// Friction of pairs at `positions` \[m\] from the pitch point with shares `share` in the load.
/// A pair at the pitch point rolls.
pub fn friction_direction(positions: &[f64], share: &[f64]) -> FrictionDirection {
    let (mut direction, mut lever) = (0.0, 0.0);
    for (&s, &p) in positions.iter().zip(share) {
        if s != 0.0 {
            direction -= s.signum() * p;
            lever -= s.abs() * p;
        }
    }
    FrictionDirection { direction, lever }
}
