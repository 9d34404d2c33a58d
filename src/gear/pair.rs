//! The gear pair as its drawing gives it.

/// A standard involute spur pair. Arrays are `[pinion, wheel]`.
#[derive(Debug, Clone, PartialEq)]
pub struct GearPair {
    /// Number of teeth.
    pub teeth: [u32; 2],
    /// Module \[m\].
    pub module: f64,
    /// Pressure angle \[rad\].
    pub pressure_angle: f64,
    /// Face width \[m\].
    pub face_width: f64,
    /// Axial length of the gear bodies \[m\].
    pub body_length: [f64; 2],
    /// Rated torque on the pinion \[N m\]: load = 1.
    pub rated_torque: f64,
}

impl GearPair {
    /// Pitch radii `r = m z / 2` \[m\].
    pub fn pitch_radii(&self) -> [f64; 2] {
        self.teeth.map(|z| 0.5 * self.module * f64::from(z))
    }

    /// Base radii `r_b = r cos α` \[m\].
    pub fn base_radii(&self) -> [f64; 2] {
        self.pitch_radii().map(|r| r * self.pressure_angle.cos())
    }

    /// Mesh force at rated torque, `T / r_b1` \[N\].
    pub fn rated_force(&self) -> f64 {
        self.rated_torque / self.base_radii()[0]
    }
}
