//! Rigid bodies of revolution on a shaft: gear bodies, rigid shafts.

use super::beam::Section;
use super::error::ShaftError;
use crate::gear::Web;
use crate::gear::positive;
use std::f64::consts::PI;

/// A rigid body of revolution about the shaft's axis, its centre of mass at the node.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Disc {
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia about a diameter \[kg m²\].
    pub transverse_inertia: f64,
    /// Moment of inertia about the axis \[kg m²\].
    pub polar_inertia: f64,
}

impl Disc {
    /// A homogeneous annulus: outer diameter, bore and length \[m\], density \[kg/m³\].
    /// `J_p = m (d_o² + d_i²)/8`, `J_d = J_p/2 + m L²/12`.
    ///
    /// # Errors
    /// [`GearError::NotPositive`](crate::gear::GearError), [`GearError::Negative`](crate::gear::GearError), [`ShaftError::NoWall`].
    pub fn annulus(
        diameter: f64,
        bore: f64,
        length: f64,
        density: f64,
    ) -> Result<Self, ShaftError> {
        Section::hollow(diameter, bore)?;
        positive("disc length [m]", length)?;
        positive("disc density [kg/m^3]", density)?;
        let mass = 0.25 * PI * (diameter.powi(2) - bore.powi(2)) * length * density;
        let polar_inertia = mass * (diameter.powi(2) + bore.powi(2)) / 8.0;
        Ok(Self {
            mass,
            transverse_inertia: 0.5 * polar_inertia + mass * length.powi(2) / 12.0,
            polar_inertia,
        })
    }

    /// A body between two diameters, the outer one first \[m\]: a rim of `length` around the web, or without a web an
    /// annulus of `length`.
    ///
    /// # Errors
    /// As [`Self::annulus`].
    pub fn webbed(
        [outer, inner]: [f64; 2],
        length: f64,
        web: Option<Web>,
        density: f64,
    ) -> Result<Self, ShaftError> {
        let Some(web) = web else {
            return Self::annulus(outer, inner, length, density);
        };
        let disc = Self::annulus(web.rim_diameter, inner, web.thickness, density)?;
        Ok(disc.with(Self::annulus(outer, web.rim_diameter, length, density)?))
    }

    /// Sum of this body and another one about the same centre.
    pub fn with(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            transverse_inertia: self.transverse_inertia + other.transverse_inertia,
            polar_inertia: self.polar_inertia + other.polar_inertia,
        }
    }
}
