//! When a tooth stands on the line of centres: the mesh phase about which what the coast flanks
//! do is the mirror image of what the drive flanks do.

use super::{GearError, GearPair, Tooth, involute};
use std::f64::consts::{FRAC_PI_2, PI};

impl GearPair {
    /// Thickness of a tooth on the operating pitch circle \[m\], as drawn:
    /// `s_w = 2 r_w (s/(2 r) + inv α_t − inv α_w)` with `s = m_t (π/2 + 2 x tan α_n) − thinning` on
    /// the reference circle (ISO 21771, 7.2). 0 the pinion, 1 the wheel.
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn operating_thickness(&self, gear: usize) -> Result<f64, GearError> {
        let angle = self.operating_pressure_angle()?;
        let radius = self.operating_pitch_radii()?[gear];
        let form = &self.form;
        let reference = self.transverse_module()
            * (FRAC_PI_2 + 2.0 * form.profile_shift[gear] * self.pressure_angle.tan())
            - form.thinning[gear];
        let half_angle = 0.5 * reference / self.pitch_radii()[gear];
        Ok(2.0
            * radius
            * (half_angle + involute(self.transverse_pressure_angle()) - involute(angle)))
    }

    /// Path of contact before the pitch point \[m\],
    /// `g_f = √(r_a2² − r_b2²) − r_b2 tan α_w`: it begins at the wheel's tip, at the latest where
    /// the pinion's base circle touches the line of action.
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`], and [`GearError::TipBelowForm`] where the wheel's tip
    /// does not reach the pitch point.
    pub fn approach(&self) -> Result<f64, GearError> {
        self.path_to_tip(1)
    }

    /// Path of contact behind the pitch point \[m\], `g_a`: it ends at the pinion's tip.
    ///
    /// # Errors
    ///
    /// As [`Self::approach`], of the pinion's tip.
    pub fn recess(&self) -> Result<f64, GearError> {
        self.path_to_tip(0)
    }

    /// Path of contact between the pitch point and the tip of a gear, 0 the pinion, 1 the wheel.
    fn path_to_tip(&self, gear: usize) -> Result<f64, GearError> {
        let tangent = self.operating_pressure_angle()?.tan();
        let radii = self.base_radii();
        let (own, mate) = (radii[gear], radii[1 - gear]);
        let tip = Tooth::tip_radius_of(self, gear)?;
        let length = ((tip / own).powi(2) - 1.0).max(0.0).sqrt() * own - own * tangent;
        if length <= 0.0 {
            return Err(GearError::TipBelowForm {
                gear: gear + 1,
                tip_diameter: 2.0 * tip.abs(),
                form_diameter: 2.0 * own.abs() * tangent.hypot(1.0),
            });
        }
        // The line of action goes on beyond the base circle of a ring.
        Ok(if mate > 0.0 { length.min(mate * tangent) } else { length })
    }

    /// Mesh phase in \[0, 1) at which a tooth of the pinion stands on the line of centres:
    /// `(g_f + s_w cos α_w/2)/p_b`.
    ///
    /// At mesh phase 0 a pair takes hold at the start of the path, of helical gears at mid-face. Its pinion flank passes the pitch point
    /// the path before it later, and half the tooth follows, `s_w/2` on the pitch circle.
    ///
    /// # Errors
    ///
    /// As [`Self::approach`].
    pub fn tooth_phase(&self) -> Result<f64, GearError> {
        let cos = self.operating_pressure_angle()?.cos();
        let base_pitch = PI * self.transverse_module() * self.transverse_pressure_angle().cos();
        let along = self.approach()? + 0.5 * self.operating_thickness(0)? * cos;
        Ok((along / base_pitch).rem_euclid(1.0))
    }

    /// Mesh phase in \[0, ½) at which a tooth of the pinion ([`Self::tooth_phase`]), or the middle of a space half a
    /// cycle on, stands on the line of centres. At these phases the pinion is its own mirror image, and what
    /// touches its coast flanks is the image of what touches its drive flanks:
    /// `k_coast(symmetry + φ) = k_drive(symmetry − φ)`. Of helical gears the image of a place of the
    /// face is the one as far from mid-face on the other side.
    ///
    /// # Errors
    ///
    /// As [`Self::approach`].
    pub fn symmetry(&self) -> Result<f64, GearError> {
        Ok(self.tooth_phase()?.rem_euclid(0.5))
    }
}

/// The mesh phase of [`GearPair::symmetry`] of a pair of which the transverse contact ratio ε alone is known:
/// `ε/2 + 1/4`, modulo ½. Approach and recess are then taken to be equal, and the pinion's tooth
/// to be as thick as its space.
pub fn standard_symmetry(contact_ratio: f64) -> f64 {
    (0.5 * contact_ratio + 0.25).rem_euclid(0.5)
}

#[cfg(test)]
#[path = "symmetry_tests.rs"]
mod tests;
