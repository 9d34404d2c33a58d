//! A housing between bearings and the ground: reduced matrices from another program over named freedoms.
//!
//! The nodes of a housing have displacements and rotations along the global axes. There are also internal freedoms,
//! such as the modes of a Craig–Bampton reduction. The spring of a bearing on a node acts between the shaft and this
//! node, along the axes of the shaft. A freedom that a node does not have is fixed.

use super::axes::Axis;
use super::nodes::Assembled;
use super::solved::Solved;
use super::{TrainDrive, TrainError};
use crate::numerics::linalg::symmetric_eigen;
use crate::shaft::assembly::{Assembly, Freedom, NODE_FREEDOMS};
use crate::shaft::error::ShaftError;
use crate::structure::{MotionKind, PlaceMotion};
use faer::Mat;
use serde::Serialize;
use std::sync::Arc;

/// Largest distance of a bearing from its node \[m\].
const LARGEST_DISTANCE: f64 = 1e-3;

/// Differences across the diagonal and negative eigenvalues below this are round-off, in a matrix scaled
/// to a diagonal of ones.
const ROUND_OFF: f64 = 1e-10;

/// Reduced matrices over the freedoms of nodes, node by node in the order of [`Freedom`], and internal freedoms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Housing {
    /// Possible positions of bearings.
    pub nodes: Vec<HousingNode>,
    /// Names of the internal freedoms.
    pub internal: Vec<String>,
    /// Mass matrix, row by row \[kg, kg m, kg m²\].
    pub mass: Vec<f64>,
    /// Stiffness matrix \[N/m, N, N m\].
    pub stiffness: Vec<f64>,
    /// Damping matrix \[N s/m, N s, N m s\]; empty for none.
    pub damping: Vec<f64>,
    /// Points with an acceleration in the results.
    pub points: Vec<HousingPoint>,
}

/// A node of a housing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HousingNode {
    /// Its name.
    pub name: String,
    /// Its position in space \[m\].
    pub position: [f64; 3],
    /// Which freedoms it has.
    pub freedoms: [bool; NODE_FREEDOMS],
}

/// A point of a housing, in one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HousingPoint {
    /// Its name.
    pub name: String,
    /// Its displacement per unit of each freedom.
    pub row: Vec<f64>,
}

/// A housing in its train.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JoinedHousing {
    /// The housing.
    pub housing: Arc<Housing>,
    /// The bearings on it.
    pub joints: Vec<HousingJoint>,
}

/// A bearing on a node of a housing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HousingJoint {
    /// Index of the shaft, and of the bearing on it.
    pub bearing: [usize; 2],
    /// The node.
    pub node: usize,
}

/// Why the matrices of a housing are invalid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HousingError {
    /// Two entries across the diagonal differ.
    #[error(
        "the {matrix} matrix is not symmetric: row {}, column {} (`{}`, `{}`) is {:e}, but its mirror image is {:e}",
        place[0] + 1, place[1] + 1, freedoms[0], freedoms[1], entries[0], entries[1]
    )]
    Asymmetric {
        /// Name of the matrix.
        matrix: &'static str,
        /// Row and column, from 0.
        place: [usize; 2],
        /// Their freedoms.
        freedoms: [String; 2],
        /// The entry and its mirror image.
        entries: [f64; 2],
    },
    /// A matrix has an eigenvalue outside its range.
    #[error(
        "the {matrix} matrix has the eigenvalue {eigenvalue:.3e} (scaled to a diagonal of ones), but {wanted}; freedom \
         `{freedom}` has the largest part in it"
    )]
    Indefinite {
        /// Name of the matrix.
        matrix: &'static str,
        /// The smallest eigenvalue.
        eigenvalue: f64,
        /// The required range.
        wanted: &'static str,
        /// Freedom with the largest entry of its eigenvector.
        freedom: String,
    },
}

impl HousingError {
    /// Name of the invalid matrix.
    pub fn matrix(&self) -> &'static str {
        match self {
            Self::Asymmetric { matrix, .. } | Self::Indefinite { matrix, .. } => matrix,
        }
    }
}

impl HousingNode {
    /// Names of the freedoms of a node: displacements along the global axes, then rotations about them.
    pub const FREEDOMS: [&str; NODE_FREEDOMS] = ["x", "y", "z", "rx", "ry", "rz"];
}

impl Housing {
    /// Number of freedoms.
    pub fn freedoms(&self) -> usize {
        let of_node = |node: &HousingNode| node.freedoms.iter().filter(|has| **has).count();
        self.nodes.iter().map(of_node).sum::<usize>() + self.internal.len()
    }

    /// Names of all freedoms, such as `left x`.
    pub fn names(&self) -> Vec<String> {
        let of_nodes = self.nodes.iter().flat_map(|node| {
            let words = HousingNode::FREEDOMS.iter().zip(node.freedoms);
            let present = words.filter(|(_, has)| *has);
            present.map(|(word, _)| format!("{} {word}", node.name))
        });
        of_nodes.chain(self.internal.iter().cloned()).collect()
    }

    /// Checks that the matrices are symmetric, the mass positive definite, stiffness and damping positive semidefinite.
    ///
    /// # Errors
    /// [`HousingError`].
    pub fn check(&self) -> Result<(), HousingError> {
        let names = self.names();
        let not_negative = "no eigenvalue may be negative";
        let size = names.len();
        for (matrix, entries, least, wanted) in [
            (
                "mass",
                &self.mass,
                ROUND_OFF,
                "all eigenvalues must be positive",
            ),
            ("stiffness", &self.stiffness, -ROUND_OFF, not_negative),
            ("damping", &self.damping, -ROUND_OFF, not_negative),
        ] {
            if entries.is_empty() {
                continue;
            }
            let scaled = scaled(entries, size);
            for row in 0..size {
                for column in 0..row {
                    let difference = scaled[(row, column)] - scaled[(column, row)];
                    if difference.abs() > ROUND_OFF {
                        return Err(HousingError::Asymmetric {
                            matrix,
                            place: [row, column],
                            freedoms: [row, column].map(|index| names[index].clone()),
                            entries: [entries[row * size + column], entries[column * size + row]],
                        });
                    }
                }
            }
            let (eigenvalue, freedom) = least_eigenvalue(&scaled);
            let definite = eigenvalue > least;
            if !definite {
                return Err(HousingError::Indefinite {
                    matrix,
                    eigenvalue,
                    wanted,
                    freedom: names.get(freedom).cloned().unwrap_or_default(),
                });
            }
        }
        Ok(())
    }

    /// Whether the housing can move without a force.
    pub(super) fn floats(&self) -> bool {
        least_eigenvalue(&scaled(&self.stiffness, self.freedoms())).0 < ROUND_OFF
    }

    /// Adds the housing to an assembly, and returns all of its freedoms; its nodes are the first of the assembly.
    pub(super) fn assembled(
        &self,
        assembly: &mut Assembly,
    ) -> Result<Vec<(usize, Freedom)>, ShaftError> {
        let mut freedoms = Vec::new();
        let padded =
            |from: usize| std::array::from_fn(|freedom| from + freedom < self.internal.len());
        let internal_nodes = (0..self.internal.len()).step_by(NODE_FREEDOMS).map(padded);
        for has in self
            .nodes
            .iter()
            .map(|node| node.freedoms)
            .chain(internal_nodes)
        {
            let node = assembly.add_node();
            for (freedom, has) in Freedom::ALL.into_iter().zip(has) {
                if has {
                    freedoms.push((node, freedom));
                } else {
                    assembly.fix(node, freedom)?;
                }
            }
        }
        assembly.add_part(&freedoms, [&self.mass, &self.stiffness, &self.damping])?;
        Ok(freedoms)
    }
}

/// A matrix scaled by the square roots of its diagonal entries.
fn scaled(entries: &[f64], size: usize) -> Mat<f64> {
    let root = |at: usize| match entries[at * size + at].abs().sqrt() {
        0.0 => 1.0,
        root => root,
    };
    let roots: Vec<f64> = (0..size).map(root).collect();
    Mat::from_fn(size, size, |i, j| {
        entries[i * size + j] / (roots[i] * roots[j])
    })
}

/// The smallest eigenvalue of a symmetric matrix, and the index of its vector's largest entry; NaN without convergence.
fn least_eigenvalue(matrix: &Mat<f64>) -> (f64, usize) {
    let Some((values, vectors)) = symmetric_eigen(matrix) else {
        return (f64::NAN, 0);
    };
    let size = |row: &usize| vectors[(*row, 0)].abs();
    let largest = (0..matrix.nrows()).max_by(|a, b| size(a).total_cmp(&size(b)));
    (
        values.first().copied().unwrap_or(f64::NAN),
        largest.unwrap_or(0),
    )
}

impl JoinedHousing {
    /// The node of the assembly under a bearing; `None` if it is not on the housing. The nodes of the housing are the
    /// first of the assembly, so their indices are equal.
    pub(super) fn node_under(&self, bearing: [usize; 2]) -> Option<usize> {
        let joint = self.joints.iter().find(|joint| joint.bearing == bearing)?;
        Some(joint.node)
    }
}

impl TrainDrive {
    /// Checks that bearings are at the positions of their nodes on the housing.
    pub(super) fn check_joints(
        &self,
        joined: &JoinedHousing,
        axes: &[Axis],
        turning: &[bool],
    ) -> Result<(), TrainError> {
        let nodes = &joined.housing.nodes;
        if joined.joints.is_empty() {
            let names: Vec<String> = nodes
                .iter()
                .map(|node| format!("{:?}", node.name))
                .collect();
            return Err(TrainError::UnusedHousing {
                nodes: names.join(", "),
                first: names.into_iter().next().unwrap_or_default(),
            });
        }
        for joint in &joined.joints {
            let [shaft, bearing] = joint.bearing;
            let train_shaft = &self.shafts[shaft];
            if turning[shaft] {
                return Err(TrainError::TurningHousing {
                    shaft: train_shaft.name.clone(),
                    bearing: bearing + 1,
                });
            }
            if !train_shaft.motion.may_deflect() {
                return Err(TrainError::RigidMount {
                    shaft: train_shaft.name.clone(),
                    bearing: bearing + 1,
                });
            }
            let node = &nodes[joint.node];
            let place = axes[shaft].at(train_shaft.bearings[bearing].0);
            let distance = (place - nalgebra::Vector3::from(node.position)).norm();
            let meets = distance <= LARGEST_DISTANCE;
            if !meets {
                return Err(TrainError::BearingOffNode {
                    shaft: train_shaft.name.clone(),
                    bearing: bearing + 1,
                    node: node.name.clone(),
                    distance,
                    most: LARGEST_DISTANCE,
                });
            }
        }
        Ok(())
    }

    /// The motions of the points of the housing.
    pub(super) fn housing_motions(
        &self,
        solved: &Solved,
        assembled: &Assembled,
    ) -> Vec<PlaceMotion> {
        let points = self
            .housing
            .iter()
            .flat_map(|joined| &joined.housing.points);
        let motion = |point: &HousingPoint| {
            let terms = assembled.housing.iter().zip(&point.row);
            let terms: Vec<_> = terms
                .map(|(&(node, freedom), &part)| (node, freedom, part))
                .collect();
            PlaceMotion {
                name: format!("housing {}", point.name),
                kind: MotionKind::Place,
                gain: solved.participation(&terms),
            }
        };
        points.map(motion).collect()
    }
}
