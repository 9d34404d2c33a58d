//! A mesh table as the pictures need it: axes, and any of its quantities over the mesh phase.
//!
//! Between the nodes of a piece a quantity is the polynomial through them, evaluated in
//! barycentric form (Berrut and Trefethen, "Barycentric Lagrange interpolation", 2004).

use std::path::Path;

use crate::report::numbers::number;
use crate::report::plot::axis::scaled_unit;
use crate::report::plot::canvas::Place;
use crate::report::plot::error::PlotError;
use crate::store::{CacheFault, CacheKind, MappedTable};

/// Places drawn of a piece, its ends among them.
const SAMPLES: usize = 17;

/// A mesh table.
pub(in crate::report::plot) struct MeshCurves {
    pub table: MappedTable,
    /// Start of the names of its pictures.
    pub name: String,
    /// Angle between the flanks, increasing \[rad\].
    pub misalignment: Vec<f64>,
    /// Torque, increasing \[N m\].
    pub torque: Vec<f64>,
    /// Mesh phases at which pieces meet, from 0 to 1.
    pub breaks: Vec<f64>,
    /// Places of the nodes in a piece that reaches from −1 to 1.
    nodes: Vec<f64>,
}

/// A quantity at one misalignment and torque: a line of phase and value.
pub(super) type Curve = Vec<Place>;

impl MeshCurves {
    /// Reads and checks a table file.
    pub fn read(path: &Path) -> Result<Self, PlotError> {
        let refused = |fault| PlotError::Table {
            path: path.to_path_buf(),
            fault,
        };
        let table = MappedTable::open(path).map_err(refused)?;
        if table.header().kind != CacheKind::Mesh {
            return Err(refused(CacheFault::Kind {
                found: table.header().kind.name(),
                wanted: CacheKind::Mesh.name(),
            }));
        }
        let unfit = |detail: &str| PlotError::MeshTable {
            path: path.to_path_buf(),
            detail: detail.into(),
        };
        let axis = |name: &str, least: usize| -> Result<Vec<f64>, PlotError> {
            let (shape, values) = (table.array(name)).map_err(|e| unfit(&e.to_string()))?;
            let rises = values.windows(2).all(|pair| pair[0] < pair[1]);
            match shape.len() == 1 && values.len() >= least && rises {
                true => Ok(values.to_vec()),
                false => Err(unfit(&format!("`{name}` does not rise along one axis"))),
            }
        };
        Ok(Self {
            misalignment: axis("misalignment", 1)?,
            torque: axis("torque", 1)?,
            breaks: axis("breaks", 2)?,
            nodes: axis("node", 1)?,
            name: format!("mesh-{}", &table.header().key[..8]),
            table,
        })
    }

    /// A quantity over the mesh phase; none where the table has no array of that name with a
    /// value at every node. `member` picks one of those that lie together at a node, of
    /// `members`.
    pub fn curve(
        &self,
        name: &str,
        [misalignment, torque]: [usize; 2],
        [member, members]: [usize; 2],
    ) -> Option<Curve> {
        let (shape, values) = self.table.array(name).ok()?;
        let (pieces, nodes) = (self.breaks.len() - 1, self.nodes.len());
        let full = [
            self.misalignment.len(),
            self.torque.len(),
            pieces,
            nodes,
            members,
        ];
        // Single values have no axis for the members.
        if shape != &full[..if members == 1 { 4 } else { 5 }] {
            return None;
        }
        let length = nodes * members;
        let first = (misalignment * self.torque.len() + torque) * pieces * length;
        let mut curve = Vec::with_capacity(pieces * SAMPLES);
        for (piece, ends) in self.breaks.windows(2).enumerate() {
            let at = first + piece * length;
            let own: Vec<f64> = (0..nodes)
                .map(|n| values[at + n * members + member])
                .collect();
            curve.extend((0..SAMPLES).map(|sample| {
                let share = sample as f64 / (SAMPLES - 1) as f64;
                let value = interpolated(&self.nodes, &own, 2.0 * share - 1.0);
                [ends[0] + share * (ends[1] - ends[0]), value]
            }));
        }
        Some(curve)
    }

    /// Edges of the cells around the nodes in mesh phase: ends of pieces, and halfway between
    /// nodes.
    pub fn phase_edges(&self) -> Vec<f64> {
        let mut edges = vec![self.breaks[0]];
        for ends in self.breaks.windows(2) {
            let middles = self.nodes.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            edges.extend(middles.map(|x| ends[0] + 0.5 * (1.0 + x) * (ends[1] - ends[0])));
            edges.push(ends[1]);
        }
        edges
    }

    /// Unit of an array; empty where it is not there.
    pub fn unit(&self, name: &str) -> &str {
        self.table.unit(name).unwrap_or_default()
    }

    /// The place of the smallest misalignment.
    pub fn aligned(&self) -> usize {
        let smallest = (0..self.misalignment.len()).min_by(|&a, &b| {
            self.misalignment[a]
                .abs()
                .total_cmp(&self.misalignment[b].abs())
        });
        smallest.unwrap_or(0)
    }

    /// The misalignments in one unit, and that unit.
    pub fn misalignments(&self) -> (Vec<String>, String) {
        quantities(&self.misalignment, self.unit("misalignment"))
    }

    /// The torques in one unit, and that unit.
    pub fn torques(&self) -> (Vec<String>, String) {
        quantities(&self.torque, self.unit("torque"))
    }

    /// `misalignment 0.2 mrad`.
    pub fn misalignment_text(&self, index: usize) -> String {
        let (texts, unit) = self.misalignments();
        format!("misalignment {} {unit}", texts[index])
    }

    /// `torque 50 N·m`.
    pub fn torque_text(&self, index: usize) -> String {
        let (texts, unit) = self.torques();
        format!("torque {} {unit}", texts[index])
    }
}

/// Some values in one unit that suits the largest, and that unit.
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

/// The polynomial through `values` at `nodes`, at `x`.
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
        // One degree more does not fit: the test can fail.
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
