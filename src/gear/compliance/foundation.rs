//! How much the body below a tooth gives: the fillet foundation.
//!
//! Sainsot, Velex & Duverger, "Contribution of gear body to tooth deflections – a new
//! bidimensional analytical formula", J. Mech. Des. 126 (2004) 748: the tooth's force and moment
//! on the root circle of an elastic ring held at its bore give
//! `δ E L/F = cos² β (L* (u/S)² + M* (u/S) + P* (1 + Q* tan² β))`, u the height above the root
//! circle at which the line of action crosses the tooth's centre line, S the arc of the tooth on
//! the root circle, and L*, M*, P*, Q* polynomials of half the tooth's angle θ_f and of h, root
//! radius over bore radius.

use crate::gear::Tooth;

/// Ratios of root to bore radius for which the polynomials were fitted. The fit's range of θ_f
/// ends at 0.12 rad; below some 25 teeth θ_f is larger, as in most published uses.
pub(in crate::gear) const BODY_RATIO: [f64; 2] = [1.4, 7.0];

/// `A/θ² + B h² + C h/θ + D/θ + E h + F` (Sainsot et al. 2004, table 1).
struct Polynomial([f64; 6]);

const L: Polynomial = Polynomial([-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045]);
const M: Polynomial = Polynomial([60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086]);
const P: Polynomial = Polynomial([-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236]);
const Q: Polynomial = Polynomial([
    -6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904,
]);

impl Polynomial {
    fn at(&self, half_angle: f64, ratio: f64) -> f64 {
        let [a, b, c, d, e, f] = self.0;
        a / half_angle.powi(2)
            + b * ratio.powi(2)
            + c * ratio / half_angle
            + d / half_angle
            + e * ratio
            + f
    }
}

/// L*, M*, P* and Q*.
pub(super) fn coefficients(half_angle: f64, ratio: f64) -> [f64; 4] {
    [L, M, P, Q].map(|polynomial| polynomial.at(half_angle, ratio))
}

/// Height at which a force at angle β crosses the tooth's centre line, above the root circle and
/// in root radii: `u/r_f = r_b/(r_f cos β) − 1`.
pub(super) fn lever(tooth: &Tooth, angle: f64) -> f64 {
    tooth.base_radius / (tooth.root_radius * angle.cos()) - 1.0
}

/// Foundation of a gear with a bore \[m\] under a tooth loaded at a roll angle, per unit width
/// \[m²/N\].
pub(super) fn compliance(tooth: &Tooth, roll: f64, bore: f64, young_modulus: f64) -> f64 {
    let half_angle = tooth.root_half_angle;
    let ratio = 2.0 * tooth.root_radius / bore;
    let [l, m, p, q] = coefficients(half_angle, ratio);
    let angle = tooth.force_angle(roll);
    let lever = lever(tooth, angle) / (2.0 * half_angle);
    angle.cos().powi(2) / young_modulus
        * (l * lever * lever + m * lever + p * (1.0 + q * angle.tan().powi(2)))
}
