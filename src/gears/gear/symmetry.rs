//! At which mesh phase is a tooth on the line of centres? The coast flanks mirror the drive flanks about
//! this phase.

use super::{GearError, GearPair, Tooth, involute};
use std::f64::consts::FRAC_PI_2;

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
    /// `g_f = √(r_a2² − r_b2²) − r_b2 tan α_w`: it begins at the wheel's tip, but not before the point
    /// where the pinion's base circle touches the line of action. Negative if the tip does not reach the pitch point.
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn approach(&self) -> Result<f64, GearError> {
        self.path_to_tip(1)
    }

    /// Path of contact after the pitch point \[m\], `g_a`: it ends at the pinion's tip.
    ///
    /// # Errors
    ///
    /// As [`Self::approach`].
    pub fn recess(&self) -> Result<f64, GearError> {
        self.path_to_tip(0)
    }

    /// Path of contact between the pitch point and the tip of a gear, 0 the pinion, 1 the wheel.
    fn path_to_tip(&self, gear: usize) -> Result<f64, GearError> {
        let tangent = self.operating_pressure_angle()?.tan();
        let radii = self.base_radii();
        let (radius, mate) = (radii[gear], radii[1 - gear]);
        let tip = Tooth::tip_radius_of(self, gear)?;
        let length = ((tip / radius).powi(2) - 1.0).max(0.0).sqrt() * radius - radius * tangent;
        // The line of action continues beyond the base circle of a ring.
        Ok(if mate > 0.0 { length.min(mate * tangent) } else { length })
    }

    /// Mesh phase in \[0, 1) at which a tooth of the pinion is on the line of centres:
    /// `(g_f + s_w cos α_w/2)/p_b` modulo 1.
    ///
    /// At mesh phase 0 a pair enters at the start of the path (helical gears: at mid-face). Its pinion flank passes the
    /// pitch point after the distance g_f. The middle of the tooth is `s_w/2` behind it on the pitch circle.
    ///
    /// # Errors
    ///
    /// As [`Self::approach`].
    pub fn tooth_phase(&self) -> Result<f64, GearError> {
        let cos = self.operating_pressure_angle()?.cos();
        let along = self.approach()? + 0.5 * self.operating_thickness(0)? * cos;
        Ok((along / self.base_pitch()).rem_euclid(1.0))
    }

    /// Mesh phase in \[0, ½) at which a tooth of the pinion ([`Self::tooth_phase`]), or the middle of a space half a
    /// cycle later, is on the line of centres. At these phases the pinion is symmetric about this line, and contact
    /// on its coast flanks is the image of contact on its drive flanks:
    /// `k_coast(symmetry + φ) = k_drive(symmetry − φ)`. On helical gears the image of a position on the
    /// face is at the same distance from mid-face on the other side.
    ///
    /// # Errors
    ///
    /// As [`Self::approach`].
    pub fn symmetry(&self) -> Result<f64, GearError> {
        Ok(self.tooth_phase()?.rem_euclid(0.5))
    }
}

/// The mesh phase of [`GearPair::symmetry`] of a pair with only the transverse contact ratio ε known:
/// `ε/2 + 1/4`, modulo ½. Approach and recess are assumed to be equal, and the pinion's tooth
/// to be as thick as its space.
pub fn standard_symmetry(contact_ratio: f64) -> f64 {
    (0.5 * contact_ratio + 0.25).rem_euclid(0.5)
}

#[cfg(test)]
#[path = "symmetry_tests.rs"]
mod tests;
