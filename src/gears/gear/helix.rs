//! Helical gears: their transverse section, which equals that of a spur pair, and the lines of contact
//! across it.
//!
//! z runs along the axes, and the pinion's rotation is positive about z. The section of a right-handed pinion at z is
//! turned by `z tan β/r` in this sense from the section at mid-face. At each position on the face the mesh is that of
//! the spur pair, ahead in phase by `z tan β_b/p_bt` (ISO 21771, 4 and 5).

use super::{BasicRack, GearPair, ToothForm};

impl GearPair {
    /// Transverse module `m_t = m_n/cos β` \[m\].
    pub fn transverse_module(&self) -> f64 {
        self.module / self.helix_angle.cos()
    }

    /// Transverse pressure angle, `tan α_t = tan α_n/cos β` \[rad\].
    pub fn transverse_pressure_angle(&self) -> f64 {
        if self.helix_angle == 0.0 {
            self.pressure_angle
        } else {
            (self.pressure_angle.tan() / self.helix_angle.cos()).atan()
        }
    }

    /// Helix angle at the base cylinders, `sin β_b = sin β cos α_n` \[rad\], signed as the helix angle.
    pub fn base_helix_angle(&self) -> f64 {
        (self.helix_angle.sin() * self.pressure_angle.cos()).asin()
    }

    /// Transverse base pitch `p_bt = π m_t cos α_t` \[m\].
    pub fn base_pitch(&self) -> f64 {
        std::f64::consts::PI * self.transverse_module() * self.transverse_pressure_angle().cos()
    }

    /// Overlap ratio `ε_β = b |tan β_b|/p_bt` \[1\]: the phase lead of one end of the face over the other in
    /// mesh cycles.
    pub fn overlap_ratio(&self) -> f64 {
        self.face_width * self.base_helix_angle().tan().abs() / self.base_pitch()
    }

    /// The spur pair whose flanks are those of the transverse section.
    ///
    /// The rack of the spur pair has the same depths. In this section the corner of the rack's tip is an ellipse. An
    /// arc replaces it that ends on the flank at the same point and touches the same bottom. Involutes therefore begin
    /// at the same point.
    pub(super) fn transverse_section(&self) -> Self {
        if self.helix_angle == 0.0 {
            return self.clone();
        }
        let cos = self.helix_angle.cos();
        let angle = self.transverse_pressure_angle();
        let BasicRack {
            addendum,
            dedendum,
            tip_radius,
        } = self.form.rack;
        let corner = (1.0 - self.pressure_angle.sin()) / (1.0 - angle.sin());
        Self {
            module: self.transverse_module(),
            pressure_angle: angle,
            helix_angle: 0.0,
            form: ToothForm {
                profile_shift: self.form.profile_shift.map(|shift| shift * cos),
                rack: BasicRack {
                    addendum: addendum * cos,
                    dedendum: dedendum * cos,
                    tip_radius: tip_radius * cos * corner,
                },
                ..self.form.clone()
            },
            ..self.clone()
        }
    }

    /// Numbers of teeth of the spur gears that have the curvature of the normal section, negative for a ring,
    /// `z_n = z/(cos² β_b cos β)` (ISO 6336-1).
    pub(super) fn virtual_teeth(&self) -> [f64; 2] {
        let cos = self.helix_angle.cos() * self.base_helix_angle().cos().powi(2);
        self.signed_teeth().map(|z| z / cos)
    }
}
