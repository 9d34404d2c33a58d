//! What damps an assembly or couples its freedoms? Dampers, drag, gyroscopic moments,
//! cross-coupled springs, rolling contacts.
//!
//! ```text
//! M u'' + (C + Ω G) u' + (K + K_c) u = f
//! ```
//!
//! with Ω the speed of the driver (Friswell, Penny, Garvey & Lees, *Dynamics of Rotating
//! Machines*, 2010, chapters 5 and 7).

use super::super::beam::BeamElement;
use super::super::error::{ShaftError, finite};
use super::super::rolling::Ring;
use super::{Assembly, Freedom, NODE_FREEDOMS, scatter};
use crate::gear::non_negative;
use faer::Mat;

/// `(row, column, value)` over all freedoms.
type Entry = (usize, usize, f64);

/// Entries over all freedoms. Entries at the same position are summed.
#[derive(Debug, Clone, Default)]
pub(super) struct Entries {
    damping: Vec<Entry>,
    gyroscopic: Vec<Entry>,
    cross_stiffness: Vec<Entry>,
    frame_stiffness: Vec<Entry>,
    /// Speed of the parts that are added next, in units of Ω.
    turning: f64,
}

/// Matrices over the free freedoms besides mass and stiffness.
#[derive(Debug, Clone)]
pub struct CouplingMatrices {
    /// Damping matrix C \[N s/m, N m s/rad\].
    pub damping: Mat<f64>,
    /// Gyroscopic matrix G \[kg m², …\], skew; `Ω G` with the speed Ω of the driver.
    pub gyroscopic: Mat<f64>,
    /// Stiffness K_c of cross-coupled springs \[N/m\].
    pub cross_stiffness: Mat<f64>,
    /// Contribution of a rotating frame, `Ω² K_f` \[kg\], symmetric.
    pub frame_stiffness: Mat<f64>,
}

impl Entries {
    /// Gyroscopic moments of a beam element whose two ends start at the freedoms `ends`.
    pub fn add_turning_beam(&mut self, ends: [usize; 2], element: &BeamElement) {
        if self.turning != 0.0 {
            let ratio = self.turning;
            let matrix = element.gyroscopic().map(|row| row.map(|g| ratio * g));
            scatter(&mut self.gyroscopic, ends, &matrix);
        }
    }

    /// Gyroscopic moments `+J_p θy'` about x and `−J_p θx'` about y of a disc on the node whose
    /// freedoms start at `first`.
    pub fn add_turning_disc(&mut self, first: usize, polar_inertia: f64) {
        let value = self.turning * polar_inertia;
        if value != 0.0 {
            let about_x = first + Freedom::RotationX as usize;
            let about_y = first + Freedom::RotationY as usize;
            self.gyroscopic
                .extend([(about_x, about_y, value), (about_y, about_x, -value)]);
        }
    }

    /// Entries of a damping matrix.
    pub fn add_damping(&mut self, entries: Vec<Entry>) {
        self.damping.extend(entries);
    }

    /// The matrices; `collect` sums entries over the free freedoms. `None` without any entry.
    pub fn matrices(&self, collect: impl Fn(&[Entry]) -> Mat<f64>) -> Option<CouplingMatrices> {
        let all = [
            &self.damping,
            &self.gyroscopic,
            &self.cross_stiffness,
            &self.frame_stiffness,
        ];
        if all.iter().all(|entries| entries.is_empty()) {
            return None;
        }
        let [damping, gyroscopic, cross_stiffness, frame_stiffness] =
            all.map(|entries| collect(entries));
        Some(CouplingMatrices {
            damping,
            gyroscopic,
            cross_stiffness,
            frame_stiffness,
        })
    }
}

/// The column of M S, and its sign, to which a column of a matrix M contributes. `S (x, y) = (−y, x)` for
/// displacements and for rotations. `None` for freedoms along or about the axis, which S does not contain.
fn turned(column: usize) -> Option<(usize, f64)> {
    match column % NODE_FREEDOMS {
        0 | 3 => Some((column + 1, -1.0)),
        1 | 4 => Some((column - 1, 1.0)),
        _ => None,
    }
}

impl Assembly {
    /// Writes the inertia of the nodes for which `is_transformed` holds in a frame that rotates about the axis,
    /// right-handed, at `Ω_f = ratio Ω` with the speed Ω of the driver. A displacement u that is constant in the frame
    /// has the velocity `Ω_f S u`. Therefore
    ///
    /// ```text
    /// M (u'' + 2 Ω_f S u' − Ω_f² u) + Ω G (u' + Ω_f S u)
    /// ```
    ///
    /// replaces `M u'' + Ω G u'` (Cooley & Parker, J. Vib. Acoust. 134, 061014, 2012). Springs and dampers
    /// between these nodes and the ground must be isotropic.
    pub fn in_turning_frame(&mut self, ratio: f64, is_transformed: impl Fn(usize) -> bool) {
        let turned =
            |column: usize| turned(column).filter(|_| is_transformed(column / NODE_FREEDOMS));
        let moments = self.coupling.gyroscopic.clone();
        for &(row, column, value) in &self.mass {
            if let Some((to, sign)) = turned(column) {
                self.coupling
                    .gyroscopic
                    .push((row, to, 2.0 * ratio * sign * value));
                (self.coupling.frame_stiffness).push((row, column, -ratio * ratio * value));
            }
        }
        for (row, column, value) in moments {
            if let Some((to, sign)) = turned(column) {
                self.coupling
                    .frame_stiffness
                    .push((row, to, ratio * sign * value));
            }
        }
    }

    /// Corrects the potential of the centrifugal force of a mass \[kg\] at `node`, on a pin at `r = [x, y]` \[m\] from
    /// the axis of its carrier. The frame gives the potential `−m Ω_f² |u|²/2`. But it must be `−m Ω_f² |u − S r θ|²/2`
    /// with the rotation θ of `pin`: a common rotation of carrier and mass does not change the force on the pin.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`].
    pub fn add_mass_on_pin(
        &mut self,
        [node, pin]: [usize; 2],
        mass: f64,
        [x, y]: [f64; 2],
        ratio: f64,
    ) -> Result<(), ShaftError> {
        let moved = self.freedom(node, Freedom::X)?;
        let turn = self.freedom(pin, Freedom::RotationZ)?;
        let square = mass * ratio * ratio;
        let entries = &mut self.coupling.frame_stiffness;
        for (freedom, along) in [(moved, -y), (moved + 1, x)] {
            entries.push((freedom, turn, square * along));
            entries.push((turn, freedom, square * along));
            entries.push((turn, turn, -square * along * along));
        }
        Ok(())
    }

    /// Beams and discs added after this call rotate about their axis, right-handed, at
    /// `ratio` times the speed Ω of the driver and have gyroscopic moments. With 0, the
    /// initial value, they have none.
    pub fn turn(&mut self, ratio: f64) {
        self.coupling.turning = ratio;
    }

    /// Adds dampers in the plane of the gears between a node and another one, or the ground:
    /// the force on `node` is `−c (u' − u'_other)`, u = (x, y), with the rows `damping` of c
    /// \[N s/m\].
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`]; [`GearError::Negative`](crate::gear::GearError) for an entry on the diagonal,
    /// [`ShaftError::NotFinite`] for another one.
    pub fn add_dampers(
        &mut self,
        node: usize,
        other: Option<usize>,
        damping: [[f64; 2]; 2],
    ) -> Result<(), ShaftError> {
        for (i, row) in damping.into_iter().enumerate() {
            non_negative("damping coefficient [N s/m]", row[i])?;
            finite("cross damping coefficient [N s/m]", row[1 - i])?;
        }
        let entries = self.between(node, other, Freedom::X, &damping)?;
        self.coupling.damping.extend(entries);
        Ok(())
    }

    /// Adds cross-coupled springs between a node and another one, or the ground: the force on
    /// `node` is `−k_xy (y − y_other)` along x and `−k_yx (x − x_other)` along y, with `cross` =
    /// `[k_xy, k_yx]` \[N/m\]. `k_xy = −k_yx > 0` drives a whirl from x to y.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`ShaftError::NotFinite`].
    pub fn add_cross_springs(
        &mut self,
        node: usize,
        other: Option<usize>,
        cross: [f64; 2],
    ) -> Result<(), ShaftError> {
        for stiffness in cross {
            finite("cross stiffness [N/m]", stiffness)?;
        }
        let matrix = [[0.0, cross[0]], [cross[1], 0.0]];
        let entries = self.between(node, other, Freedom::X, &matrix)?;
        self.coupling.cross_stiffness.extend(entries);
        Ok(())
    }

    /// Adds a symmetric stiffness against displacements and tilts, in the order of [`Freedom`] \[N/m, N, N m\], between
    /// a node and another one, or the ground.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`].
    pub fn add_stiffness(
        &mut self,
        node: usize,
        other: Option<usize>,
        matrix: &Ring<Ring>,
    ) -> Result<(), ShaftError> {
        let entries = self.between(node, other, Freedom::X, matrix)?;
        self.stiffness.extend(entries);
        Ok(())
    }

    /// Adds a viscous drag on the rotation of a node about its axis, relative to another node or the
    /// ground \[N m s/rad\].
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`GearError::Negative`](crate::gear::GearError).
    pub fn add_drag(
        &mut self,
        node: usize,
        other: Option<usize>,
        drag: f64,
    ) -> Result<(), ShaftError> {
        let drag = non_negative("drag [N m s/rad]", drag)?;
        let entries = self.between(node, other, Freedom::RotationZ, &[[drag]])?;
        self.coupling.damping.extend(entries);
        Ok(())
    }

    /// The entries of a matrix between the freedoms of a node from `first` on and those of another one, or the
    /// ground. Zeros have none.
    fn between<const N: usize>(
        &self,
        node: usize,
        other: Option<usize>,
        first: Freedom,
        matrix: &[[f64; N]; N],
    ) -> Result<Vec<Entry>, ShaftError> {
        let mut ends = vec![(self.freedom(node, first)?, 1.0)];
        if let Some(other) = other {
            ends.push((self.freedom(other, first)?, -1.0));
        }
        let mut entries = Vec::new();
        for &(row, row_sign) in &ends {
            for &(column, column_sign) in &ends {
                for (i, values) in matrix.iter().enumerate() {
                    for (j, value) in values.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                        entries.push((row + i, column + j, row_sign * column_sign * value));
                    }
                }
            }
        }
        Ok(entries)
    }
}

#[cfg(test)]
mod tests;
