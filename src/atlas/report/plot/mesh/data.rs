//! A mesh table, prepared for pictures: its axes, and any of its quantities over the mesh phase.
//!
//! Between the nodes of a piece a quantity is the polynomial through them, evaluated in barycentric form (Berrut and
//! Trefethen, "Barycentric Lagrange interpolation", 2004).

use std::path::Path;

use crate::gear::MeshTable;
use crate::report::numbers::number;
use crate::report::plot::axis::scaled_unit;
use crate::report::plot::canvas::Place;
use crate::report::plot::error::PlotError;
use crate::store::TableFile;

/// Number of drawn samples of a piece of the mesh cycle, including its ends.
const SAMPLES: usize = 17;

/// A mesh table.
pub(in crate::report::plot) struct MeshCurves {
    pub table: MeshTable,
    /// First part of the names of its pictures.
    pub name: String,
}

/// A quantity at one misalignment and torque: mesh phase and value of each sample.
pub(super) type Curve = Vec<Place>;

impl MeshCurves {
    /// Reads and checks a table file.
    pub fn read(path: &Path) -> Result<Self, PlotError> {
        let refused = |fault| PlotError::Table {
            path: path.to_path_buf(),
            fault,
        };
        let file = TableFile::open(path).map_err(refused)?;
        Ok(Self {
            table: file.content().map_err(refused)?,
            name: format!("mesh-{}", &file.header.key()[..8]),
        })
    }

    /// A quantity of the table over the mesh phase, at the given indices of misalignment and torque. Every
    /// node has `members` values, of which `member` selects one.
    pub fn curve(
        &self,
        values: &[f64],
        [misalignment, torque]: [usize; 2],
        [member, members]: [usize; 2],
    ) -> Curve {
        let [_, torques, pieces, nodes] = self.table.shape();
        let length = nodes * members;
        let first = (misalignment * torques + torque) * pieces * length;
        let mut curve = Vec::with_capacity(pieces * SAMPLES);
        for (piece, ends) in self.table.breaks.windows(2).enumerate() {
            let at = first + piece * length;
            let at_nodes: Vec<f64> = (0..nodes)
                .map(|n| values[at + n * members + member])
                .collect();
            curve.extend((0..SAMPLES).map(|sample| {
                let share = sample as f64 / (SAMPLES - 1) as f64;
                let value = interpolated(&self.table.node, &at_nodes, 2.0 * share - 1.0);
                [ends[0] + share * (ends[1] - ends[0]), value]
            }));
        }
        curve
    }

    /// Edges of the cells around the nodes, in mesh phase: the ends of the pieces, and the middles between
    /// nodes.
    pub fn phase_edges(&self) -> Vec<f64> {
        let mut edges = vec![self.table.breaks[0]];
        for ends in self.table.breaks.windows(2) {
            let middles = (self.table.node.windows(2)).map(|pair| 0.5 * (pair[0] + pair[1]));
            edges.extend(middles.map(|x| ends[0] + 0.5 * (1.0 + x) * (ends[1] - ends[0])));
            edges.push(ends[1]);
        }
        edges
    }

    /// The index of the misalignment with the smallest magnitude.
    pub fn aligned(&self) -> usize {
        let angles = &self.table.misalignment;
        let smallest =
            (0..angles.len()).min_by(|&a, &b| angles[a].abs().total_cmp(&angles[b].abs()));
        smallest.unwrap_or(0)
    }

    /// The misalignments in one unit, and that unit.
    pub fn misalignments(&self) -> (Vec<String>, String) {
        quantities(&self.table.misalignment, "rad")
    }

    /// The torques in one unit, and that unit.
    pub fn torques(&self) -> (Vec<String>, String) {
        quantities(&self.table.torque, "N*m")
    }

    /// A misalignment as text: `misalignment 0.2 mrad`.
    pub fn misalignment_text(&self, index: usize) -> String {
        let (texts, unit) = self.misalignments();
        format!("misalignment {} {unit}", texts[index])
    }

    /// A torque as text: `torque 50 N·m`.
    pub fn torque_text(&self, index: usize) -> String {
        let (texts, unit) = self.torques();
        format!("torque {} {unit}", texts[index])
    }
}

/// Values as text in the scaled unit of the largest, and that unit.
fn quantities(values: &[f64], unit: &str) -> (Vec<String>, String) {
    let largest = values
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    let (factor, shown) = scaled_unit(unit, largest);
    let texts = values
        .iter()
        .map(|value| number(value * factor).replace('-', "−"));
    (texts.collect(), shown)
}

/// The value at `x` of the polynomial through `values` at `nodes`.
fn interpolated(nodes: &[f64], values: &[f64], x: f64) -> f64 {
    let (mut above, mut below) = (0.0, 0.0);
    for (j, (node, value)) in nodes.iter().zip(values).enumerate() {
        if x == *node {
            return *value;
        }
        let others = nodes.iter().enumerate().filter(|(k, _)| *k != j);
        let weight: f64 = others.map(|(_, other)| node - other).product();
        let term = 1.0 / (weight * (x - node));
        above += term * value;
        below += term;
    }
    above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_nodes_hold_a_polynomial_of_degree_seven() {
        let nodes = [-0.96, -0.8, -0.5, -0.2, 0.2, 0.5, 0.8, 0.96];
        let exact = |x: f64| 1.0 - 3.0 * x + x.powi(5) - 0.7 * x.powi(7);
        let values = nodes.map(exact);
        for x in [-1.0, -0.8, -0.31, 0.0, 0.2, 0.77, 1.0] {
            let error = interpolated(&nodes, &values, x) - exact(x);
            assert!(error.abs() < 1e-13, "{x}: {error:e}");
        }
        // A polynomial of one degree more is not reproduced: the test can fail.
        let values = nodes.map(|x| x.powi(8));
        assert!((interpolated(&nodes, &values, 1.0) - 1.0).abs() > 1e-4);
    }

    #[test]
    fn values_share_the_unit_of_the_largest() {
        let (texts, unit) = quantities(&[-2e-4, 0.0, 1e-3], "rad");
        assert_eq!(
            (&texts[..], &unit[..]),
            (&["−0.2", "0", "1"].map(String::from)[..], "mrad")
        );
        assert_eq!(quantities(&[50.0], "N*m").1, "N·m");
    }
}
