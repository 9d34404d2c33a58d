//! Contact of a tip edge off the path of contact: before and after the contact of rigid gears.
//!
//! Loaded gears come closer than rigid ones. The tip edge of an entering tooth therefore touches its mate before it
//! reaches the line of action. The tip edge of a leaving tooth stays in contact beyond this line. With rigid rotation
//! the gap between edge and mate grows with the square of the distance from the path.
//!
//! With the tip's gear at the origin, its mate at (a, 0) and the operating pressure angle α_w, consider a pair whose
//! conjugate flanks would touch at u on the line of action. Its tip edge is at the roll angle t_a of the
//! involute whose string leaves the base circle at the polar angle `γ = (u − u_a)/r_b − α_w`, with the path's end u_a:
//!
//! ```text
//! P = r_b (cos γ − t_a sin γ, sin γ + t_a cos γ)
//! ```
//!
//! Seen from the mate's centre and turned by π, the string of the mate's involute through P leaves at the polar angle
//! `γ' = ϑ − β`, `cos β = r_b'/ρ`, with the polar coordinates (ρ, ϑ) of P in that frame. While the gears turn by
//! `du/r_b`, the edge approaches along that string by its distance from the tip's centre, `a cos γ' − r_b'`, and the
//! mate recedes by `du`: the gap along the line of action is
//!
//! ```text
//! ∫ (a/r_b) (cos α_w − cos γ') du
//! ```
//!
//! from the end of the path on, where γ' is −α_w.

use crate::numerics::legendre::transforms8;

/// A tip edge and the flank on which it slides beyond the end of the path of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TipContact {
    /// Base radius of the gear with the tip \[m\].
    pub base_radius: f64,
    /// Roll angle of the tip.
    pub tip_roll: f64,
    /// Base radius of its mate \[m\].
    pub mate_base_radius: f64,
    /// Roll angle at which the mate's involute ends at its fillet.
    pub mate_form_roll: f64,
    /// Centre distance \[m\].
    pub centre_distance: f64,
    /// Operating pressure angle \[rad\].
    pub pressure_angle: f64,
}

impl TipContact {
    /// Gap along the line of action \[m\] of a pair whose conjugate flanks would touch at the distance
    /// `beyond` \[m\] after the end of the path. `None` if the edge would be in the mate's fillet.
    pub fn gap(&self, beyond: f64) -> Option<f64> {
        self.string(beyond)?;
        let opening = |x: &f64| {
            let turned = self.string(0.5 * beyond * (x + 1.0)).unwrap_or(0.0);
            // cos α − cos γ' with γ' = turned − α.
            2.0 * (0.5 * turned).sin() * (0.5 * turned - self.pressure_angle).sin()
        };
        let transforms = transforms8();
        let mean = transforms.interpolate(&transforms.nodes().each_ref().map(opening))[0];
        Some(beyond * mean * self.centre_distance / self.base_radius)
    }

    /// Angle between the line of action and the string of the mate's involute through the tip edge
    /// \[rad\]. `None` if the edge is in the mate's fillet.
    fn string(&self, beyond: f64) -> Option<f64> {
        let (sin, cos) = (beyond / self.base_radius - self.pressure_angle).sin_cos();
        let [x, y] = [cos - self.tip_roll * sin, sin + self.tip_roll * cos]
            .map(|coordinate| self.base_radius * coordinate);
        // Seen from its centre a ring is mirrored, and its involute ends at the largest roll angle.
        let sense = self.mate_base_radius.signum();
        let (x, y) = (sense * (self.centre_distance - x), sense * -y);
        let ratio = self.mate_base_radius / x.hypot(y);
        let roll = (ratio.powi(-2) - 1.0).max(0.0).sqrt();
        (sense * roll >= sense * self.mate_form_roll)
            .then(|| y.atan2(x) - roll.atan() + self.pressure_angle)
    }

    /// Distance from the end of the path \[m\] at which the gap reaches `gap` \[m\]. The mate's fillet and
    /// `furthest` \[m\] limit the distance.
    pub fn reach(&self, gap: f64, furthest: f64) -> f64 {
        let inside = |beyond: f64| self.gap(beyond).is_some_and(|tip_gap| tip_gap <= gap);
        if inside(furthest) {
            return furthest;
        }
        let [mut low, mut high] = [0.0, furthest];
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            if inside(middle) { low = middle } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gear::fixtures::pair;
    use crate::gear::{Flanks, ToothForm};

    fn tips(teeth: [u32; 2], shift: [f64; 2], ring: Option<f64>) -> [TipContact; 2] {
        let form = ToothForm {
            ring,
            // With the rack's full addendum the ring would reach the fillet of the gear inside.
            tip_diameter: [None, ring.map(|_| 68.4 * 4e-3)],
            profile_shift: shift,
            bore: [Some(22e-3), Some(26e-3)],
            ..ToothForm::default()
        };
        let pair = pair(teeth, form);
        let flanks = Flanks::new(&pair).unwrap();
        crate::gear::flanks::tips(&flanks.teeth, flanks.centre_distance, flanks.pressure_angle)
    }

    /// End of conjugate contact at the tip, from the pitch point.
    fn end(tip: TipContact) -> f64 {
        tip.base_radius * (tip.tip_roll - tip.pressure_angle.tan())
    }

    /// The involute of a gear at the origin whose string leaves at the polar angle γ.
    fn point(base: f64, gamma: f64, roll: f64) -> [f64; 2] {
        let (sin, cos) = gamma.sin_cos();
        [base * (cos - roll * sin), base * (sin + roll * cos)]
    }

    /// Compares the gap along the line of action with the distance from the tip edge to the mate's flank, found by
    /// search along the flank.
    #[test]
    fn the_gap_is_the_distance_to_the_flank_on_small_ways() {
        for tip in tips([20, 30], [0.0; 2], None)
            .into_iter()
            .chain(tips([23, 41], [0.3, -0.1], None))
            .chain(tips([20, 70], [0.0; 2], Some(0.33)))
        {
            let pitch = 2.0 * tip.base_radius.abs().min(0.05);
            let sense = tip.mate_base_radius.signum();
            for part in [0.005, 0.01, 0.02] {
                let beyond = part * pitch;
                let edge = point(
                    tip.base_radius,
                    beyond / tip.base_radius - tip.pressure_angle,
                    tip.tip_roll,
                );
                let position = [tip.centre_distance - edge[0], -edge[1]].map(|place| sense * place);
                let start = tip.pressure_angle.tan()
                    - tip.pressure_angle
                    - (end(tip) + beyond) / tip.mate_base_radius;
                let distance = |roll: f64| {
                    let [x, y] = point(tip.mate_base_radius.abs(), start - roll, roll);
                    (x - position[0]).hypot(y - position[1])
                };
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..200 {
                    let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
                    if distance(a) < distance(b) { high = b } else { low = a }
                }
                let nearest = distance(0.5 * (low + high));
                let gap = tip.gap(beyond).unwrap();
                assert!(gap > 0.0);
                // Gap and distance grow with the square of `beyond`. They differ by a term that grows with its
                // cube.
                assert!(
                    (gap / nearest - 1.0).abs() < 0.02,
                    "{part}: {gap} {nearest}"
                );
            }
        }
    }

    #[test]
    fn the_gap_begins_with_its_square() {
        for tip in tips([20, 30], [0.0; 2], None) {
            assert!(tip.gap(0.0).unwrap().abs() < 1e-16);
            let [one, half] = [1e-4, 5e-5].map(|beyond| tip.gap(beyond).unwrap());
            assert!((one / half - 4.0).abs() < 0.05, "{one} {half}");
            let reach = tip.reach(one, 1e-2);
            assert!((reach - 1e-4).abs() < 1e-9, "{reach}");
        }
    }
}
