//! One Timoshenko beam element: stiffness and consistent mass, 12 × 12.
//!
//! Two nodes with six freedoms each, `ux uy uz θx θy θz`, the beam along z and rotations
//! right-handed. Both bending planes carry shear deformation, `Φ = 12 E I / (κ G A L²)`,
//! and consistent translational and rotary inertia (Przemieniecki, *Theory of Matrix
//! Structural Analysis*, 1968, sections 5.6 and 11.6); axial and torsional motion are
//! linear in z with consistent mass. `Φ = 0` is the Euler–Bernoulli element with rotary
//! inertia.

use super::error::ShaftError;
use crate::gear::{GearError, non_negative, positive};
use std::f64::consts::PI;

/// Freedoms of an element.
pub const ELEMENT_FREEDOMS: usize = 12;

/// A 12 × 12 element matrix, row-major.
pub type ElementMatrix = [[f64; ELEMENT_FREEDOMS]; ELEMENT_FREEDOMS];

/// A circular section, solid or hollow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    diameter: f64,
    bore: f64,
}

impl Section {
    /// A solid section of the given diameter \[m\].
    ///
    /// # Errors
    /// [`GearError::NotPositive`](crate::gear::GearError).
    pub fn solid(diameter: f64) -> Result<Self, ShaftError> {
        Self::hollow(diameter, 0.0)
    }

    /// A section of the given outer diameter and bore \[m\].
    ///
    /// # Errors
    /// [`GearError::NotPositive`](crate::gear::GearError), [`GearError::Negative`](crate::gear::GearError), [`ShaftError::NoWall`].
    pub fn hollow(diameter: f64, bore: f64) -> Result<Self, ShaftError> {
        positive("diameter [m]", diameter)?;
        non_negative("bore [m]", bore)?;
        if bore >= diameter {
            return Err(ShaftError::NoWall { bore, diameter });
        }
        Ok(Self { diameter, bore })
    }

    /// Area A \[m²\].
    pub fn area(&self) -> f64 {
        0.25 * PI * (self.diameter.powi(2) - self.bore.powi(2))
    }

    /// Second moment of area about a diameter, I \[m⁴\].
    pub fn second_moment(&self) -> f64 {
        PI / 64.0 * (self.diameter.powi(4) - self.bore.powi(4))
    }

    /// Polar moment of area, `2 I` \[m⁴\]: also the torsion constant of a circular section.
    pub fn polar_moment(&self) -> f64 {
        2.0 * self.second_moment()
    }

    /// Shear coefficient κ \[1\] for Poisson's ratio `poisson` \[1\] (Cowper, *J. Appl. Mech.*
    /// 33, 1966): `6(1+ν)(1+m²)² / ((7+6ν)(1+m²)² + (20+12ν) m²)`, m the ratio of radii.
    pub fn cowper_shear_coefficient(&self, poisson: f64) -> f64 {
        let m2 = (self.bore / self.diameter).powi(2);
        let ring = (1.0 + m2).powi(2);
        6.0 * (1.0 + poisson) * ring / ((7.0 + 6.0 * poisson) * ring + (20.0 + 12.0 * poisson) * m2)
    }
}

/// An isotropic elastic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus E \[Pa\].
    pub young_modulus: f64,
    /// Shear modulus G \[Pa\].
    pub shear_modulus: f64,
    /// Density ρ \[kg/m³\]; zero makes the element a massless spring.
    pub density: f64,
}

impl Material {
    /// Poisson's ratio `E/(2G) − 1` \[1\].
    pub fn poisson(&self) -> f64 {
        0.5 * self.young_modulus / self.shear_modulus - 1.0
    }
}

/// A prismatic Timoshenko beam element along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamElement {
    section: Section,
    material: Material,
    shear_coefficient: f64,
    length: f64,
}

impl BeamElement {
    /// An element of the given length \[m\]; `shear_coefficient` is κ \[1\], infinity for a
    /// beam that is rigid in shear.
    ///
    /// # Errors
    /// [`GearError::NotPositive`](crate::gear::GearError) and [`GearError::Negative`](crate::gear::GearError).
    pub fn new(
        section: Section,
        material: Material,
        shear_coefficient: f64,
        length: f64,
    ) -> Result<Self, ShaftError> {
        positive("Young's modulus [Pa]", material.young_modulus)?;
        positive("shear modulus [Pa]", material.shear_modulus)?;
        non_negative("density [kg/m^3]", material.density)?;
        positive("element length [m]", length)?;
        if shear_coefficient.is_nan() || shear_coefficient <= 0.0 {
            return Err(ShaftError::Gear(GearError::NotPositive {
                quantity: "shear coefficient [1]",
                value: shear_coefficient,
            }));
        }
        Ok(Self {
            section,
            material,
            shear_coefficient,
            length,
        })
    }

    /// Ratio of shear to bending flexibility, `Φ = 12 E I / (κ G A L²)` \[1\].
    pub fn shear_parameter(&self) -> f64 {
        12.0 * self.material.young_modulus * self.section.second_moment()
            / (self.shear_coefficient
                * self.material.shear_modulus
                * self.section.area()
                * self.length.powi(2))
    }

    /// Stiffness, translations in m and rotations in rad.
    pub fn stiffness(&self) -> ElementMatrix {
        let l = self.length;
        let phi = self.shear_parameter();
        let bending =
            self.material.young_modulus * self.section.second_moment() / (l.powi(3) * (1.0 + phi));
        let plane = [
            [12.0, 6.0 * l, -12.0, 6.0 * l],
            [6.0 * l, (4.0 + phi) * l * l, -6.0 * l, (2.0 - phi) * l * l],
            [-12.0, -6.0 * l, 12.0, -6.0 * l],
            [6.0 * l, (2.0 - phi) * l * l, -6.0 * l, (4.0 + phi) * l * l],
        ]
        .map(|row| row.map(|entry| bending * entry));
        let axial = self.material.young_modulus * self.section.area() / l;
        let torsion = self.material.shear_modulus * self.section.polar_moment() / l;
        combine(
            plane,
            [[axial, -axial], [-axial, axial]],
            [[torsion, -torsion], [-torsion, torsion]],
        )
    }

    /// Consistent mass, translational and rotary.
    pub fn mass(&self) -> ElementMatrix {
        let l = self.length;
        let phi = self.shear_parameter();
        let line_mass = self.material.density * self.section.area();
        let translation = line_mass * l / (1.0 + phi).powi(2);
        let rotation =
            self.material.density * self.section.second_moment() / (l * (1.0 + phi).powi(2));

        let end = 13.0 / 35.0 + 7.0 / 10.0 * phi + phi * phi / 3.0;
        let end_slope = (11.0 / 210.0 + 11.0 / 120.0 * phi + phi * phi / 24.0) * l;
        let far = 9.0 / 70.0 + 3.0 / 10.0 * phi + phi * phi / 6.0;
        let far_slope = (13.0 / 420.0 + 3.0 / 40.0 * phi + phi * phi / 24.0) * l;
        let slope = (1.0 / 105.0 + phi / 60.0 + phi * phi / 120.0) * l * l;
        let cross_slope = -(1.0 / 140.0 + phi / 60.0 + phi * phi / 120.0) * l * l;

        let [r_end, r_end_slope, r_slope, r_cross_slope] = self.rotary();

        let entry = |m: f64, r: f64| translation * m + rotation * r;
        let (a, b) = (entry(end, r_end), entry(end_slope, r_end_slope));
        let (c, d) = (entry(far, -r_end), entry(-far_slope, r_end_slope));
        let (e, f) = (entry(slope, r_slope), entry(cross_slope, r_cross_slope));
        let plane = [[a, b, c, d], [b, e, -d, f], [c, -d, a, -b], [d, f, -b, e]];
        let axial = line_mass * l / 6.0;
        let torsion = self.material.density * self.section.polar_moment() * l / 6.0;
        let linear = |m: f64| [[2.0 * m, m], [m, 2.0 * m]];
        combine(plane, linear(axial), linear(torsion))
    }

    /// Gyroscopic matrix of an element that rotates about its axis at 1 rad/s, consistent with
    /// the mass: skew, `G q'` of its tilts (Nelson, *J. Mech. Design* 102, 1980; Friswell, Penny,
    /// Garvey & Lees, *Dynamics of Rotating Machines*, 2010, section 5.4).
    ///
    /// The moments on a disc of the section are `+J_p θy'` about x and `−J_p θx'` about y. With
    /// `J_p = 2 J_d` the entries are twice those of the rotary part of the mass, between
    /// the two planes.
    pub fn gyroscopic(&self) -> ElementMatrix {
        let polar = 2.0 * self.material.density * self.section.second_moment()
            / (self.length * (1.0 + self.shear_parameter()).powi(2));
        let [a, b, e, f] = self.rotary().map(|entry| polar * entry);
        let plane = [[a, b, -a, b], [b, e, -b, f], [-a, -b, a, -b], [b, f, -b, e]];
        let mut full = [[0.0; ELEMENT_FREEDOMS]; ELEMENT_FREEDOMS];
        for (i, (row, row_sign)) in IN_X.into_iter().enumerate() {
            for (j, (column, column_sign)) in IN_Y.into_iter().enumerate() {
                let entry = row_sign * column_sign * plane[i][j];
                full[row][column] = entry;
                full[column][row] = -entry;
            }
        }
        full
    }

    /// Entries of the rotary inertia in one plane, in units of `ρ I / (L (1 + Φ)²)`: deflection with itself,
    /// deflection with the slope at the same end, slope with itself, slope with the slope at the other end.
    fn rotary(&self) -> [f64; 4] {
        let (l, phi) = (self.length, self.shear_parameter());
        [
            6.0 / 5.0,
            (1.0 / 10.0 - phi / 2.0) * l,
            (2.0 / 15.0 + phi / 6.0 + phi * phi / 3.0) * l * l,
            (-1.0 / 30.0 - phi / 6.0 + phi * phi / 6.0) * l * l,
        ]
    }
}

/// Deflection and slope at either end of an element in the plane of x, with their signs.
const IN_X: [(usize, f64); 4] = [(0, 1.0), (4, 1.0), (6, 1.0), (10, 1.0)];
/// Deflection and slope at either end in the plane of y, where the slope is `−θx`.
const IN_Y: [(usize, f64); 4] = [(1, 1.0), (3, -1.0), (7, 1.0), (9, -1.0)];

/// Writes the 4 × 4 matrix of one bending plane (deflection and slope at either end) into
/// both planes, and the 2 × 2 axial and torsional ones.
fn combine(plane: [[f64; 4]; 4], axial: [[f64; 2]; 2], torsion: [[f64; 2]; 2]) -> ElementMatrix {
    let mut full = [[0.0; ELEMENT_FREEDOMS]; ELEMENT_FREEDOMS];
    for i in 0..4 {
        for j in 0..4 {
            for freedoms in [IN_X, IN_Y] {
                let ((row, row_sign), (column, column_sign)) = (freedoms[i], freedoms[j]);
                full[row][column] = row_sign * column_sign * plane[i][j];
            }
        }
    }
    for i in 0..2 {
        for j in 0..2 {
            full[2 + 6 * i][2 + 6 * j] = axial[i][j];
            full[5 + 6 * i][5 + 6 * j] = torsion[i][j];
        }
    }
    full
}

#[cfg(test)]
mod tests;
