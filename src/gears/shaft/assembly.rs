//! From nodes, beams, springs and discs to dense mass and stiffness matrices.
//!
//! Every node has the six freedoms of [`Freedom`]. A freedom may be free or fixed to the ground. It may be tied to a
//! free freedom at a constant ratio (a gear train), or carried by the rigid body of another node. Only free freedoms
//! appear in the matrices: `T^T M T` and `T^T K T`, with the map T from free to all freedoms, are formed entry by
//! entry.

mod coupling;

pub use coupling::CouplingMatrices;

use super::beam::{BeamElement, ElementMatrix, Material, Section};
use super::disc::Disc;
use super::error::{ShaftError, finite};
use crate::gear::non_negative;
use faer::Mat;

/// Freedoms of a node.
pub const NODE_FREEDOMS: usize = 6;

/// One degree of freedom of a node, a freedom for short. The shaft lies along z, rotations are right-handed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom {
    /// Displacement along x \[m\].
    X = 0,
    /// Displacement along y \[m\].
    Y = 1,
    /// Displacement along the shaft \[m\].
    Z = 2,
    /// Rotation about x \[rad\].
    RotationX = 3,
    /// Rotation about y \[rad\].
    RotationY = 4,
    /// Rotation about the shaft \[rad\].
    RotationZ = 5,
}

impl Freedom {
    /// All six, in order.
    pub const ALL: [Self; NODE_FREEDOMS] = [
        Self::X,
        Self::Y,
        Self::Z,
        Self::RotationX,
        Self::RotationY,
        Self::RotationZ,
    ];
}

/// How a freedom enters the matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FreedomKind {
    Free,
    Fixed,
    Tied {
        master: usize,
        ratio: f64,
    },
    /// `u = Σ factor · u_of`, freedoms of one other node.
    Carried {
        of: [Option<(usize, f64)>; 3],
    },
}

/// A structure under construction.
#[derive(Debug, Clone, Default)]
pub struct Assembly {
    bonds: Vec<FreedomKind>,
    /// Entries `(row, column, value)` over all freedoms. Entries at the same position are summed.
    mass: Vec<(usize, usize, f64)>,
    stiffness: Vec<(usize, usize, f64)>,
    coupling: coupling::Entries,
}

impl Assembly {
    /// An assembly without nodes.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a node with six free freedoms and returns its index.
    pub fn add_node(&mut self) -> usize {
        self.bonds.extend([FreedomKind::Free; NODE_FREEDOMS]);
        self.bonds.len() / NODE_FREEDOMS - 1
    }

    /// Adds a prismatic shaft with nodes at the ascending `stations` \[m\] and returns the
    /// index of its first node; the others follow.
    ///
    /// # Errors
    /// Those of [`BeamElement::new`]; a shaft needs at least two stations.
    pub fn add_shaft(
        &mut self,
        stations: &[f64],
        section: Section,
        material: Material,
        shear_coefficient: f64,
    ) -> Result<usize, ShaftError> {
        if stations.len() < 2 {
            return Err(ShaftError::NoElement { stretch: "a shaft" });
        }
        let first = self.add_node();
        self.continue_shaft(stations, section, material, shear_coefficient)?;
        Ok(first)
    }

    /// Continues [`Self::add_shaft`] from the last node, which is at the first of the
    /// `stations`.
    ///
    /// # Errors
    /// Those of [`BeamElement::new`].
    pub fn continue_shaft(
        &mut self,
        stations: &[f64],
        section: Section,
        material: Material,
        shear_coefficient: f64,
    ) -> Result<(), ShaftError> {
        for pair in stations.windows(2) {
            let element =
                BeamElement::new(section, material, shear_coefficient, pair[1] - pair[0])?;
            let node = self.add_node();
            self.add_beam(node - 1, node, &element)?;
        }
        Ok(())
    }

    /// Adds a beam element between two nodes.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`].
    pub fn add_beam(
        &mut self,
        from: usize,
        to: usize,
        element: &BeamElement,
    ) -> Result<(), ShaftError> {
        let ends = [
            self.freedom(from, Freedom::X)?,
            self.freedom(to, Freedom::X)?,
        ];
        scatter(&mut self.mass, ends, &element.mass());
        scatter(&mut self.stiffness, ends, &element.stiffness());
        self.coupling.add_turning_beam(ends, element);
        Ok(())
    }

    /// Adds springs from a node to the ground, one stiffness per freedom in the order of
    /// [`Freedom`] \[N/m, N m/rad\].
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`GearError::Negative`](crate::gear::GearError).
    pub fn add_spring(
        &mut self,
        node: usize,
        stiffness: [f64; NODE_FREEDOMS],
    ) -> Result<(), ShaftError> {
        let first = self.freedom(node, Freedom::X)?;
        for (offset, value) in stiffness.into_iter().enumerate() {
            let value = non_negative("spring stiffness [N/m or N m/rad]", value)?;
            self.stiffness.push((first + offset, first + offset, value));
        }
        Ok(())
    }

    /// Adds springs between two nodes, one stiffness per freedom in the order of [`Freedom`]
    /// \[N/m, N m/rad\]; each acts between the same freedoms of both nodes.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`GearError::Negative`](crate::gear::GearError).
    pub fn add_spring_between(
        &mut self,
        from: usize,
        to: usize,
        stiffness: [f64; NODE_FREEDOMS],
    ) -> Result<(), ShaftError> {
        let ends = [
            self.freedom(from, Freedom::X)?,
            self.freedom(to, Freedom::X)?,
        ];
        for (offset, value) in stiffness.into_iter().enumerate() {
            let value = non_negative("spring stiffness [N/m or N m/rad]", value)?;
            let [a, b] = ends.map(|first| first + offset);
            let entries = [(a, a, value), (b, b, value), (a, b, -value), (b, a, -value)];
            self.stiffness.extend(entries);
        }
        Ok(())
    }

    /// Adds a rigid disc to a node, with its gyroscopic moments if [`Assembly::turn`] gives a speed.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`GearError::Negative`](crate::gear::GearError).
    pub fn add_disc(&mut self, node: usize, disc: Disc) -> Result<(), ShaftError> {
        self.add_inertia(node, disc)?;
        let first = self.freedom(node, Freedom::X)?;
        self.coupling.add_turning_disc(first, disc.polar_inertia);
        Ok(())
    }

    fn add_inertia(&mut self, node: usize, disc: Disc) -> Result<(), ShaftError> {
        let first = self.freedom(node, Freedom::X)?;
        let mass = non_negative("disc mass [kg]", disc.mass)?;
        let transverse = non_negative("transverse inertia [kg m^2]", disc.transverse_inertia)?;
        let polar = non_negative("polar inertia [kg m^2]", disc.polar_inertia)?;
        let inertia = [mass, mass, mass, transverse, transverse, polar];
        for (offset, value) in inertia.into_iter().enumerate() {
            self.mass.push((first + offset, first + offset, value));
        }
        Ok(())
    }

    /// Adds an inertia that acts only about the axis \[kg m²\], such as a motor behind a coupling. It
    /// does not tilt with the shaft, so it has no gyroscopic moment.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`GearError::Negative`](crate::gear::GearError).
    pub fn add_polar_inertia(&mut self, node: usize, inertia: f64) -> Result<(), ShaftError> {
        self.add_inertia(
            node,
            Disc {
                mass: 0.0,
                transverse_inertia: 0.0,
                polar_inertia: inertia,
            },
        )
    }

    /// Fixes a freedom to the ground.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`].
    pub fn fix(&mut self, node: usize, freedom: Freedom) -> Result<(), ShaftError> {
        let index = self.freedom(node, freedom)?;
        self.bonds[index] = FreedomKind::Fixed;
        Ok(())
    }

    /// Ties the freedom of `node` to the same freedom of `master`: `u = ratio · u_master`
    /// (for meshing gears `ratio = −z_master / z`).
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`]; [`ShaftError::TiedToBound`] from here or from
    /// [`Assembly::matrices`] if the master is not free.
    pub fn tie(
        &mut self,
        node: usize,
        master: usize,
        freedom: Freedom,
        ratio: f64,
    ) -> Result<(), ShaftError> {
        let (index, target) = (self.freedom(node, freedom)?, self.freedom(master, freedom)?);
        if index == target || self.bonds[target] != FreedomKind::Free {
            return Err(ShaftError::TiedToBound { node, master });
        }
        self.bonds[index] = FreedomKind::Tied {
            master: target,
            ratio,
        };
        Ok(())
    }

    /// Adds a node on the rigid body of `body`, at the distance `offset` \[m\] from it along
    /// the shaft: `u = u_body + θ_body × offset e_z`, `θ = θ_body`. Freedoms of the body may
    /// be fixed before or after.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`ShaftError::NotFinite`]; [`ShaftError::TiedToBound`] from
    /// [`Assembly::matrices`] if `body` is itself tied or carried.
    pub fn add_carried_node(&mut self, body: usize, offset: f64) -> Result<usize, ShaftError> {
        self.add_offset_node(body, [0.0, 0.0, offset])
    }

    /// As [`Self::add_carried_node`], at a distance `offset` \[m\] in any direction.
    ///
    /// # Errors
    /// As [`Self::add_carried_node`].
    pub fn add_offset_node(&mut self, body: usize, offset: [f64; 3]) -> Result<usize, ShaftError> {
        let first = self.freedom(body, Freedom::X)?;
        for part in offset {
            finite("offset on a rigid body [m]", part)?;
        }
        let node = self.add_node();
        let [x, y, z] = offset;
        let turn =
            |freedom: Freedom, arm: f64| (arm != 0.0).then_some((first + freedom as usize, arm));
        let (about_x, about_y, about_z) =
            (Freedom::RotationX, Freedom::RotationY, Freedom::RotationZ);
        for same in first..first + NODE_FREEDOMS {
            let turns = match same - first {
                0 => [turn(about_y, z), turn(about_z, -y)],
                1 => [turn(about_x, -z), turn(about_z, x)],
                2 => [turn(about_x, y), turn(about_y, -x)],
                _ => [None; 2],
            };
            let [one, two] = turns;
            self.bonds[NODE_FREEDOMS * node + same - first] = FreedomKind::Carried {
                of: [Some((same, 1.0)), one, two],
            };
        }
        Ok(node)
    }

    /// Adds a node that moves with `node` but has components along other axes, the unit vectors `frame`.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`]; [`ShaftError::TiedToBound`] from [`Assembly::matrices`] if `node`
    /// is itself tied or carried.
    pub fn add_turned_node(
        &mut self,
        node: usize,
        frame: [[f64; 3]; 3],
    ) -> Result<usize, ShaftError> {
        let first = self.freedom(node, Freedom::X)?;
        let turned = self.add_node();
        for (offset, unit) in (0..NODE_FREEDOMS).zip(frame.into_iter().cycle()) {
            let start = first + offset / 3 * 3;
            let part = |axis: usize| (unit[axis] != 0.0).then_some((start + axis, unit[axis]));
            self.bonds[NODE_FREEDOMS * turned + offset] = FreedomKind::Carried {
                of: [part(0), part(1), part(2)],
            };
        }
        Ok(turned)
    }

    /// Adds the mass, stiffness and damping matrices of a part, row by row over its freedoms
    /// \[kg, N/m, N s/m and their products with m\]; an empty matrix adds nothing.
    ///
    /// # Errors
    /// [`ShaftError::NoSuchNode`], [`ShaftError::NotFinite`].
    pub fn add_part(
        &mut self,
        freedoms: &[(usize, Freedom)],
        [mass, stiffness, damping]: [&[f64]; 3],
    ) -> Result<(), ShaftError> {
        let places = (freedoms.iter())
            .map(|&(node, freedom)| self.freedom(node, freedom))
            .collect::<Result<Vec<_>, _>>()?;
        let entries = |matrix: &[f64]| -> Result<Vec<(usize, usize, f64)>, ShaftError> {
            let mut entries = Vec::new();
            for (&row, values) in places.iter().zip(matrix.chunks(places.len().max(1))) {
                for (&column, &value) in places.iter().zip(values).filter(|(_, v)| **v != 0.0) {
                    entries.push((row, column, finite("entry of a matrix", value)?));
                }
            }
            Ok(entries)
        };
        self.mass.extend(entries(mass)?);
        self.stiffness.extend(entries(stiffness)?);
        self.coupling.add_damping(entries(damping)?);
        Ok(())
    }

    /// Number of free freedoms.
    pub fn free_freedoms(&self) -> usize {
        let free = self.bonds.iter().filter(|bond| **bond == FreedomKind::Free);
        free.count()
    }

    /// The matrices over the free freedoms.
    ///
    /// # Errors
    /// [`ShaftError::TiedToBound`].
    pub fn matrices(&self) -> Result<AssembledMatrices, ShaftError> {
        let mut free = vec![None; self.bonds.len()];
        let mut count = 0;
        for (index, bond) in self.bonds.iter().enumerate() {
            if *bond == FreedomKind::Free {
                free[index] = Some(count);
                count += 1;
            }
        }
        let position = (0..self.bonds.len())
            .map(|index| self.position(index, &free))
            .collect::<Result<Vec<_>, _>>()?;
        let collect = |entries: &[(usize, usize, f64)]| {
            let mut matrix = Mat::zeros(count, count);
            for &(row, column, value) in entries {
                for &(i, a) in &position[row] {
                    for &(j, b) in &position[column] {
                        matrix[(i, j)] += a * b * value;
                    }
                }
            }
            matrix
        };
        Ok(AssembledMatrices {
            mass: collect(&self.mass),
            stiffness: collect(&self.stiffness),
            coupling: self.coupling.matrices(collect),
            position,
        })
    }

    /// A freedom as a combination of free ones, by their indices in the matrices.
    fn position(&self, index: usize, free: &[Option<usize>]) -> Result<Position, ShaftError> {
        let bound = |master: usize| ShaftError::TiedToBound {
            node: index / NODE_FREEDOMS,
            master: master / NODE_FREEDOMS,
        };
        let mut terms = Position::new();
        match self.bonds[index] {
            FreedomKind::Free => terms.extend(free[index].map(|column| (column, 1.0))),
            FreedomKind::Fixed => {}
            // The master may have been fixed or tied after the tie was made.
            FreedomKind::Tied { master, ratio } => {
                terms.push((free[master].ok_or(bound(master))?, ratio));
            }
            FreedomKind::Carried { of } => {
                for (master, factor) in of.into_iter().flatten() {
                    match self.bonds[master] {
                        FreedomKind::Free => {
                            terms.extend(free[master].map(|column| (column, factor)))
                        }
                        FreedomKind::Fixed => {}
                        FreedomKind::Tied { .. } | FreedomKind::Carried { .. } => {
                            return Err(bound(master));
                        }
                    }
                }
            }
        }
        Ok(terms)
    }

    fn freedom(&self, node: usize, freedom: Freedom) -> Result<usize, ShaftError> {
        let nodes = self.bonds.len() / NODE_FREEDOMS;
        if node < nodes {
            Ok(NODE_FREEDOMS * node + freedom as usize)
        } else {
            Err(ShaftError::NoSuchNode { node, nodes })
        }
    }
}

/// Adds an element matrix whose two ends start at the freedoms `ends`.
fn scatter(entries: &mut Vec<(usize, usize, f64)>, ends: [usize; 2], element: &ElementMatrix) {
    let global = |local: usize| ends[local / NODE_FREEDOMS] + local % NODE_FREEDOMS;
    for (i, row) in element.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            if value != 0.0 {
                entries.push((global(i), global(j), value));
            }
        }
    }
}

/// `(index in the matrices, factor)` of every free freedom in a combination.
type Position = Vec<(usize, f64)>;

/// Mass and stiffness over the free freedoms, and the position of each freedom in them.
#[derive(Debug, Clone)]
pub struct AssembledMatrices {
    /// Mass matrix M, symmetric.
    pub mass: Mat<f64>,
    /// Stiffness matrix K, symmetric.
    pub stiffness: Mat<f64>,
    /// Damping and coupling; `None` if there is neither.
    pub coupling: Option<CouplingMatrices>,
    position: Vec<Position>,
}

impl AssembledMatrices {
    /// The coefficients of `Σ coefficient · freedom of node` over the free freedoms, one
    /// entry per row of the matrices. Nonexistent nodes and fixed freedoms add nothing.
    pub fn functional(&self, terms: &[(usize, Freedom, f64)]) -> Vec<f64> {
        let mut row = vec![0.0; self.mass.nrows()];
        for &(node, freedom, coefficient) in terms {
            let index = NODE_FREEDOMS * node + freedom as usize;
            for &(column, factor) in self.position.get(index).into_iter().flatten() {
                row[column] += factor * coefficient;
            }
        }
        row
    }

    /// Mass matrix times the velocities of the free freedoms.
    pub fn momentum(&self, velocity: &[f64]) -> Vec<f64> {
        let row = |row| {
            let columns = velocity.iter().enumerate();
            columns
                .map(|(column, v)| self.mass[(row, column)] * v)
                .sum()
        };
        (0..velocity.len()).map(row).collect()
    }
}

#[cfg(test)]
mod tests;
